"""A mission as a map: home, radius, areas, the lines of its legs, as GeoJSON (RFC 7946).

A leg that steers to places is traced by its own pilot from corner to corner, from the end of the
previous leg. A leg that holds a heading is drawn for still water at its planning speed, up to the
distance, depth or time that ends it. A further round is drawn only if it leads elsewhere. A leg
that is entered only when another one fails is not drawn.

What does not live here: a route that was flown (derived), a plan that is flown in simulation
(verification.planned), pictures (report).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

from mission.authoring.check.outlook import meant
from mission.authoring.graph import words
from mission.legs import LEGS
from mission.legs.base import Point, View
from mission.legs.cover import Cover
from mission.model import (
    Area,
    By,
    Chart,
    Edge,
    Estimate,
    Local,
    NavigationMode,
    Place,
    Position,
    State,
)
from mission.model.vehicle import Vehicle
from mission.navigation.geodesy import LocalFrame
from protocol.messages import Setpoint

_CORNERS = 2000  # of one leg, at most
COVERED = "area to cover"  # the text of such an area
HEADING, PLACES = "heading", "places"  # how a leg is steered: ``by`` of its line
_ROUND = 72  # corners of a circle
_FAILS = (By.TIMEOUT, By.ELSE)
_SHORTEST = 1.0  # m: a shorter leg by heading is not drawn

Feature = dict[str, Any]


def plan_geojson(chart: Chart, vehicle: Vehicle, origin: Position) -> dict[str, Any]:
    """The mission as GeoJSON. ``origin``: home. Coordinates are longitude, then latitude."""
    frame = LocalFrame(origin)
    features = [_feature(frame, "Point", [(0.0, 0.0)], name="home", what="home")]
    radius = chart.mission.safety.radius
    if radius is not None:
        turns = (2.0 * math.pi * i / _ROUND for i in range(_ROUND + 1))
        edge = [(radius * math.cos(a), radius * math.sin(a)) for a in turns]
        features.append(
            _feature(frame, "LineString", edge, name="radius", what=f"limit of {radius:g} m")
        )
    features += [_area(frame, area) for area in chart.mission.areas]
    features += _covered(frame, chart)
    features += [
        _feature(frame, "LineString", corners, name=_name(state), what=_what(state), by=_by(state))
        for state, corners in _once(routes(chart, vehicle, frame))
    ]
    return {"type": "FeatureCollection", "features": features}


def routes(
    chart: Chart, vehicle: Vehicle, frame: LocalFrame
) -> Iterator[tuple[State, list[Point]]]:
    """Yield each leg that moves the vehicle, in the planned order, with its corners (north, east)
    in metres from home."""
    states = {_name(state): state for state in chart.states}
    here, wanted = (0.0, 0.0), _wanted(chart)
    for path, (north, east) in meant(chart.mission, vehicle):
        state = states[path]
        if state.path not in wanted:
            continue
        corners = list(_walk(state, here, frame))
        if not corners and math.hypot(north, east) >= _SHORTEST:
            corners = [here, (here[0] + north, here[1] + east)]
        if len(corners) > 1:
            here = corners[-1]
            yield state, corners


def _wanted(chart: Chart) -> set[str]:
    """Paths of the legs that are reached if each leg before them ends as planned."""
    ends: dict[str, list[Edge]] = {}
    for edge in chart.edges:
        ends.setdefault(edge.source, []).append(edge)
    found, waiting = set[str](), [chart.initial]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            ways = ends.get(path, [])
            waiting += [e.target for e in [e for e in ways if e.by not in _FAILS] or ways]
    return found


def _once(found: Iterable[tuple[State, list[Point]]]) -> Iterator[tuple[State, list[Point]]]:
    """Drop a round along the same lines as an earlier one, to the decimetre."""
    seen = set[tuple[str, tuple[Point, ...]]]()
    for state, corners in found:
        told = state.path, tuple((round(n, 1), round(e, 1)) for n, e in corners)
        if told not in seen:
            seen.add(told)
            yield state, corners


def _name(state: State) -> str:
    return state.path.partition("/")[2]


def _by(state: State) -> str:
    assert state.leg is not None
    return HEADING if LEGS[type(state.leg.kind)].begin is None else PLACES


def _what(state: State) -> str:
    assert state.leg is not None
    kind = state.leg.kind
    return LEGS[type(kind)].shown(kind) or words.setpoint(state.setpoint)


def _walk(state: State, here: Point, frame: LocalFrame) -> Iterator[Point]:
    assert state.leg is not None

    def place(named: Place) -> Point | None:
        return _local(frame, named)

    kind = state.leg.kind
    begin = LEGS[type(kind)].begin
    if begin is None:
        return
    yield here
    view = View(0.0, _standing_at(here, 0.0), 0.0, place)
    pilot = begin(kind, state.setpoint or Setpoint(), view)
    for turn in range(1, _CORNERS):
        pilot.setpoint(view)
        track = pilot.track(view)
        if pilot.finished(view) or track is None or track.distance < 1e-6:
            return
        north = here[0] + track.distance * math.cos(track.ahead)
        here = north, here[1] + track.distance * math.sin(track.ahead)
        yield here
        view = View(float(turn), _standing_at(here, float(turn)), 0.0, place)


def _local(frame: LocalFrame, named: Place) -> Point:
    if isinstance(named, Local):
        return named.north, named.east
    if isinstance(named, Position):
        angles = math.radians(named.latitude_deg), math.radians(named.longitude_deg)
        return frame.to_local(*angles)
    return 0.0, 0.0


def _covered(frame: LocalFrame, chart: Chart) -> Iterator[Feature]:
    """The areas that legs cover, unless they are areas of the mission."""
    drawn = {area.corners for area in chart.mission.areas}
    for state in chart.states:
        if state.leg is None or not isinstance(state.leg.kind, Cover):
            continue
        if state.leg.kind.area not in drawn:
            drawn.add(state.leg.kind.area)
            yield _ring(frame, state.leg.kind.area, _name(state), COVERED)


def _area(frame: LocalFrame, area: Area) -> Feature:
    return _ring(frame, area.corners, area.name, words.area(area))


def _ring(frame: LocalFrame, places: Sequence[Place], name: str, what: str) -> Feature:
    """A polygon, counterclockwise; its last corner is its first."""
    corners = [_local(frame, corner) for corner in places]
    twice = sum(a[1] * b[0] - b[1] * a[0] for a, b in pairwise([*corners, corners[0]]))
    ring = [*corners, corners[0]][:: 1 if twice > 0.0 else -1]
    feature = _feature(frame, "Polygon", ring, name=name, what=what)
    feature["geometry"]["coordinates"] = [feature["geometry"]["coordinates"]]
    return feature


def _standing_at(here: Point, t: float) -> Estimate:
    sigmas = dict.fromkeys(("depth", "depth_rate", "altitude", "heading", "speed", "current"), 0.0)
    return Estimate(
        t, *here, 0.0, 0.0, None, 0.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0), sigmas, None, 0.0,
        NavigationMode.FIX,
    )  # fmt: skip


def _feature(frame: LocalFrame, form: str, points: Sequence[Point], **named: str) -> Feature:
    places = [_degrees(frame, point) for point in points]
    coordinates = places[0] if form == "Point" else places
    geometry = {"type": form, "coordinates": coordinates}
    return {"type": "Feature", "properties": named, "geometry": geometry}


def _degrees(frame: LocalFrame, point: Point) -> list[float]:
    latitude, longitude = frame.to_geodetic(*point)
    return [round(math.degrees(longitude), 8), round(math.degrees(latitude), 8)]
