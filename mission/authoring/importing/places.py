"""Read the places of a leg from a file: a route (any import format), a track, an area, a table.

    table    .csv: a first line that names latitude and longitude, then degrees, one place a line

Only the places are used; a place that comes twice in a row counts once.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from types import MappingProxyType

from mission.authoring.importing import chosen, format_of, geojson, gpx, kml, load
from mission.authoring.importing.route import Findings, Go, ImportErrors, Source, position, text_of
from mission.authoring.importing.route import number as read_number
from mission.authoring.language.files import Files, PlacesError
from mission.model import Place
from mission.model.extent import BYTES

_LATITUDE, _LONGITUDE = ("latitude", "lat", "y"), ("longitude", "lon", "lng", "long", "x")
# What to read from a file without a route.
_INSTEAD: Mapping[str, Callable[[bytes, Findings], Source]] = MappingProxyType(
    {"gpx": gpx.tracks, "geojson": geojson.areas, "kml": kml.areas}
)
_COLUMNS = "begin with a line such as latitude,longitude"


def beside(mission: Path) -> Files:
    """A reader of files whose paths are relative to the mission's folder."""
    return lambda name: places_in(mission.parent / name)


def places_in(path: Path) -> Sequence[Place]:
    """The places in a file. Raises PlacesError."""
    found = Findings(str(path))
    try:
        places = list(_table(path, found) if path.suffix.lower() == ".csv" else _route(path, found))
        found.complain()
    except ImportErrors as error:
        first = error.diagnostics[0]
        line = f":{first.where.line}" if first.where.line else ""
        raise PlacesError(f"{path}{line}: {first.message}", first.hint) from None
    return [place for place, _ in groupby(places)]


def _route(path: Path, found: Findings) -> Iterator[Place]:
    format_ = format_of(path, found)
    source = load(path, format_, found)
    if not source.routes and (instead := _INSTEAD.get(format_.name)) is not None:
        source = instead(path.read_bytes(), found)
    route = chosen(source, None, found)
    for step in route.steps():
        if not isinstance(step, Go):
            what = f"a {type(step).__name__.lower()} is no place to go through"
            raise found.refusal("plan-form", route.where, what, "take it over by import")
        yield step.point.place


def _table(path: Path, found: Findings) -> Iterator[Place]:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise found.refusal("unreadable", "", f"cannot be read: {error.strerror}") from None
    found.read_in(data)
    if len(data) > BYTES.most:
        raise found.refusal("too-long", "", f"it has {BYTES.exceeded}, which no route has")
    rows = _rows(text_of(data, found), found)
    _, first = next(rows, (1, []))
    head = [word.strip().lower() for word in first]
    at = [next((head.index(n) for n in names if n in head), None)
          for names in (_LATITUDE, _LONGITUDE)]  # fmt: skip
    if at[0] is None or at[1] is None:
        raise found.refusal("plan-form", 1, "no columns latitude and longitude", _COLUMNS)
    for where, row in rows:
        if not any(map(str.strip, row)):
            continue
        if any(map(str.strip, row[len(head) :])):
            what = f"{len(row)} columns, and the first line names {len(head)}"
            raise found.refusal("plan-form", where, what, "write decimals with a point")
        given = [row[k] if k is not None and k < len(row) else "" for k in at]
        lat, lon = (
            read_number(t, n, where, found)
            for t, n in zip(given, ("latitude", "longitude"), strict=True)
        )
        place = None if lat is None or lon is None else position(lat, lon, where, found)
        if place is not None:
            yield place


def _rows(text: str, found: Findings) -> Iterator[tuple[int, list[str]]]:
    """The rows of a table, each with its line number."""
    rows = csv.reader(text.splitlines())
    try:
        for row in rows:
            yield rows.line_num, row
    except csv.Error as error:
        raise found.refusal("plan-form", rows.line_num, f"no table: {error}", _COLUMNS) from None
