"""Import the plans of other programs as routes: one row per format, one file each.

    bytes --format.read--> Source --writing.mission_of--> Mission --> YAML, which the check judges

The file's suffix tells the format. An element that cannot be imported is refused, or reported with
its line or path as left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from mission.authoring.importing import geojson, gpx, kml, moos, neptus, qgc, slocum, wpl
from mission.authoring.importing.route import Findings, ImportErrors, Route, Source, said
from mission.model.extent import BYTES

__all__ = [
    "FORMATS", "Findings", "Format", "ImportErrors", "bounded", "chosen", "data_of", "format_of",
    "load",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Format:
    name: str
    suffixes: tuple[str, ...]
    what: str
    read: Callable[[bytes, Findings], Source]


_ROWS = (
    Format("gpx", (".gpx",), "GPX routes", gpx.read),
    Format("geojson", (".geojson", ".json"), "GeoJSON lines", geojson.read),
    Format("kml", (".kml", ".kmz"), "Google Earth paths", kml.read),
    Format("plan", (".plan",), "QGroundControl plans", qgc.read),
    Format("wpl", (".waypoints", ".wpl", ".txt"), "QGC WPL 110 waypoints", wpl.read),
    Format("neptus", (".nmis", ".nmisz"), "Neptus missions", neptus.read),
    Format("slocum", (".ma",), "Slocum goto lists", slocum.read),
    Format("moos", (".bhv",), "MOOS-IvP waypoint behaviors", moos.read),
)
FORMATS: Mapping[str, Format] = MappingProxyType({row.name: row for row in _ROWS})


def format_of(path: Path, found: Findings) -> Format:
    """The format of a file, by its suffix. Raises ImportErrors."""
    for row in FORMATS.values():
        if path.suffix.lower() in row.suffixes:
            return row
    known = ", ".join(f"{' '.join(row.suffixes)} ({row.what})" for row in FORMATS.values())
    raise found.refusal(
        "plan-format", "", f"its suffix {path.suffix!r} is no format's", f"known: {known}"
    )


def load(path: Path, format_: Format, found: Findings) -> Source:
    """Read a plan. Raises ImportErrors, also if the file cannot be read."""
    return format_.read(data_of(path, found), found)


def data_of(path: Path, found: Findings) -> bytes:
    """The bytes of a file. Raises ImportErrors if it cannot be read, or is too large."""
    try:
        with path.open("rb") as file:
            data = file.read(BYTES.most + 1)
    except OSError as error:
        why = error.strerror or str(error)
        raise found.refusal("unreadable", "", f"cannot be read: {why}") from None
    return bounded(data, found)


def bounded(data: bytes, found: Findings) -> bytes:
    """Return ``data``. Raises ImportErrors if it is larger than any plan."""
    found.read_in(data)
    if len(data) > BYTES.most:
        raise found.refusal("too-long", "", f"it has {BYTES.exceeded}, which no plan has")
    return data


def chosen(source: Source, name: str | None, found: Findings) -> Route:
    """The route of that name, or the only route. Raises ImportErrors."""
    fits = [route for route in source.routes if name is None or route.name == name]
    if len(fits) == 1:
        return fits[0]
    known = ", ".join(f"{r.name or 'without a name'} ({said(r.where)})" for r in source.routes[:30])
    hint = f"choose with --pick: {known}" if known else ""
    if not source.routes:
        raise found.refusal(
            "plan-route", "", "there is no route in it", "\n    ".join(found.left_out)
        )
    count = "no" if not fits else str(len(fits))
    raise found.refusal(
        "plan-route", "", f"{count} routes{f' called {name}' if name else ''}", hint
    )
