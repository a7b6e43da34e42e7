"""The parts of a recording with a position: the estimated track, the fixes, the plans.

What does not live here: files (gpx, kml, geojson), the smoothed track (smoothing).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from mission.analysis.export.columns import ExportError
from mission.analysis.journal import start_of
from mission.analysis.tell import printable
from mission.model import Record
from mission.onboard.blackbox import Gap
from mission.onboard.stream.derived import Derivation, Message
from mission.onboard.stream.topics import FIX, PLAN, STATE

_APART_S = 30.0  # between two points of one line, at most


@dataclass(frozen=True, slots=True)
class Point:
    """A position in degrees of WGS 84. ``up``: m above the surface. ``within``: m; of the track the
    long half axis of the 95 % ellipse, of a fix one sigma."""

    wall: float  # s since 1970
    latitude: float
    longitude: float
    up: float | None
    within: float | None

    @property
    def time(self) -> str:
        moment = datetime.fromtimestamp(self.wall, UTC).isoformat(timespec="milliseconds")
        return moment.replace("+00:00", "Z")


@dataclass(frozen=True, slots=True)
class Plan:
    """The plan of one mission. ``features``: as in mission.onboard.stream.plan."""

    mission: str
    features: Sequence[dict[str, Any]]

    def lines(self, form: str) -> Iterator[tuple[str, str, list[list[float]]]]:
        """Yield name, meaning and corners (longitude, latitude) of each feature of the form Point,
        LineString or Polygon; of a Polygon the outer ring, whose last corner is its first."""
        for feature in self.features:
            said, drawn = feature["properties"], feature["geometry"]
            if drawn["type"] == form:
                places = drawn["coordinates"]
                corners = [places] if form == "Point" else places
                corners = places[0] if form == "Polygon" else corners
                yield printable(said["name"]), printable(said["what"]), corners


@dataclass(slots=True)
class Places:
    began: str = ""
    vehicle: str = ""
    track: list[Point] = field(default_factory=list)
    fixes: list[Point] = field(default_factory=list)
    plans: dict[str, Plan] = field(default_factory=dict)  # by digest: the last one

    def take(self, message: Message, derivation: Derivation) -> None:
        said, wall = message.value, derivation.wall(message.t)
        if message.topic == STATE and said["latitude_deg"] is not None:
            depth = said["depth_m"]
            up = None if depth is None else 0.0 - depth
            self.track.append(_point(wall, said, up, said["radius_95_m"]))
        elif message.topic == FIX:
            self.fixes.append(_point(wall, said, said["elevation_m"], said["accuracy_m"]))
        elif message.topic == PLAN and derivation.chart is not None:
            chart = derivation.chart
            features = json.loads(said["geojson"])["features"]
            self.plans[chart.digest] = Plan(printable(chart.mission.name), features)


def _point(wall: float, said: Mapping[str, Any], up: float | None, within: float | None) -> Point:
    return Point(wall, said["latitude_deg"], said["longitude_deg"], up, within)


def places(items: Sequence[Record | Gap]) -> Places:
    """Collect the places of one recording. Raises ExportError if nothing in it has a position."""
    start = start_of(items)
    if start is None:
        raise ExportError("there is no whole start record, so nothing says what vehicle it is")
    derivation, found = Derivation(start), Places()
    for item in items:
        if isinstance(item, Record):
            for message in derivation.receive(item):
                found.take(message, derivation)
    if not (found.track or found.fixes or found.plans):
        raise ExportError("nothing in it has a place: there is no position, no fix and no plan")
    found.began = Point(derivation.start.wall, 0.0, 0.0, None, None).time
    found.vehicle = printable(derivation.start.vehicle.name)
    return found


def pieces(track: Sequence[Point]) -> Iterator[list[Point]]:
    """Split a track into lines: where nothing was known for a while, and at the date line."""
    piece: list[Point] = []
    for point in track:
        if piece and (
            point.wall - piece[-1].wall > _APART_S
            or abs(point.longitude - piece[-1].longitude) > 180.0
        ):
            yield piece
            piece = []
        piece.append(point)
    if piece:
        yield piece
