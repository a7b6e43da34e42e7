"""Neptus missions (LSTS, github.com/LSTS/neptus): XML, or mission.nmis in a ZIP file.

    mission-def/definitions/home-reference, mission-def/body/plan/graph/(node | edge)

Each plan is a route: the chain of its nodes along the edges, whose guards must all be "done".
Latitudes are 50N12'3.4'', 50N12.5', 41.18N, N41.18 or decimal. A point may have offsets in metres.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import MappingProxyType

from mission.authoring.importing.archive import is_archive, member
from mission.authoring.importing.route import (
    Circle,
    Findings,
    Go,
    Mow,
    Point,
    Rise,
    Route,
    Source,
    Step,
    Undulate,
    number,
    position,
)
from mission.authoring.importing.xml import Element, elements
from mission.model import Position
from mission.model.units import UNITS
from mission.navigation.geodesy import LocalFrame

_ANGLE = re.compile(
    r"(?P<before>[NSEW])?(?P<sign>-)?(?P<degrees>\d+(?:\.\d+)?)(?P<after>[NSEW])?"
    r"(?:(?P<minutes>\d+(?:\.\d+)?)'(?:(?P<seconds>\d+(?:\.\d+)?)'')?)?"
)
_DONE = frozenset({"maneuverisdone", "true"})
_NOT_MANEUVERS = frozenset({"minTime", "maxTime", "custom-settings"})
_SPEEDS = {"mps": 1.0, "m/s": 1.0, "knots": UNITS["kn"].factor, "kph": 1.0 / 3.6}


def read(data: bytes, found: Findings) -> Source:
    if is_archive(data):
        data = member(data, ".nmis", "mission.nmis", found)
    root = elements(data, "mission-def", found)
    home = None
    for name in ("home-reference", "home-referential"):
        if (element := root.one("definitions", name)) is not None:
            home = _place(element, found)
    body = root.one("body")
    plans = [e for e in body.children if e.name.endswith("plan")] if body is not None else []
    return Source(tuple(_route(plan, found) for plan in plans), home)


# --- the graph ------------------------------------------------------------------------------------


def _route(plan: Element, found: Findings) -> Route:
    name = plan.attributes.get("id") or plan.said("id")
    return Route(name, plan.where, partial(_steps, plan, found))


def _steps(plan: Element, found: Findings) -> tuple[Step, ...]:
    graph = plan.one("graph")
    if graph is None:
        return ()
    return tuple(step for node in _chain(graph, found) for step in _maneuver(node, found))


def _chain(graph: Element, found: Findings) -> Iterator[Element]:
    """The nodes from the first one on. Refuse a way back to an earlier node; report nodes that the
    chain does not reach."""
    nodes = {node.said("id"): node for node in graph.all("node")}
    ways = _ways(graph, found)
    first = [n for n, node in nodes.items() if node.attributes.get("start") == "true"]
    here: str | None = next(iter(first or nodes), None)
    seen: set[str] = set()
    while here in nodes:
        if here in seen:
            found.refuse(
                "plan-order", nodes[here].where, f"the plan comes back to {here}", "write repeat"
            )
            return
        seen.add(here)
        yield nodes[here]
        here = ways.get(here)
    for name in nodes.keys() - seen:
        found.leave_out(nodes[name].where, f"{name}, which the plan does not come to")


def _ways(graph: Element, found: Findings) -> dict[str, str]:
    ways: dict[str, str] = {}
    for edge in graph.all("edge"):
        source = edge.said("source")
        if edge.said("guard").lower() not in _DONE:
            found.refuse(
                "plan-order", edge.where, f"a guard that is no end: {edge.said('guard')[:40]!r}"
            )
        if source in ways:
            found.refuse("plan-order", edge.where, f"a second way out of {source}")
        ways[source] = edge.said("target")
    return ways


# --- maneuvers ------------------------------------------------------------------------------------


def _maneuver(node: Element, found: Findings) -> tuple[Step, ...]:
    name, maneuver = node.said("id"), node.one("maneuver")
    for element in maneuver.children if maneuver is not None else ():
        if element.name in _NOT_MANEUVERS:
            continue
        if element.name not in _MANEUVERS:
            found.refuse("no-counterpart", element.where, f"{element.name} has no counterpart")
            return ()
        holder = element.one("finalPoint", "point") or element.one("basePoint", "point")
        point = _point(holder, element, name, found) if holder is not None else None
        if point is None:
            found.refuse("plan-form", element.where, f"{element.name} without a place")
            return ()
        return _MANEUVERS[element.name](element, point, found)
    found.refuse("plan-form", node.where, "a node without a maneuver")
    return ()


def _goto(element: Element, point: Point, found: Findings) -> tuple[Step, ...]:
    return (Go(point),)


def _loiter(element: Element, point: Point, found: Findings) -> tuple[Step, ...]:
    radius = _size(element, found, "trajectory", "radius")
    seconds = _size(element, found, "duration")
    kind, way = element.said("trajectory", "type"), element.said("trajectory", "direction")
    if kind not in ("", "Circular"):
        found.refuse("no-counterpart", element.where, f"a loiter that is {kind}, not a circle")
    if not seconds:
        found.refuse("no-counterpart", element.where, "it never ends", "give it a duration")
    if not radius or not seconds:
        return ()
    side = -1 if way.lower().startswith("counter") else 1
    return (Circle(point, radius, side, seconds=seconds),)


def _pop_up(element: Element, point: Point, found: Findings) -> tuple[Step, ...]:
    flags = element.one("flags")
    there = flags is not None and flags.attributes.get("CurrPos") == "true"
    rise = Rise(element.where, _size(element, found, "duration") or 0.0)
    return (rise,) if there else (Go(point), rise)


def _rows(element: Element, point: Point, found: Findings) -> tuple[Step, ...]:
    """Rows: width across, length along, as in RowsManeuver.java; without a length, it is the
    width."""
    width, step = _size(element, found, "width"), _size(element, found, "hstep")
    length = _size(element, found, "length") if element.said("length") else width
    bearing = number(element.said("bearing"), "bearing", element.where, found)
    if not width or not length or not step or bearing is None:
        return ()
    for name in ("crossAngle", "alternationPercentage"):
        if element.said(name):
            found.refuse(
                "no-counterpart",
                element.where,
                f"{name} {element.said(name)}: rows are whole and upright",
            )
    side = -1 if element.said("firstCurveRight") == "false" else 1
    found.leave_out(element.where, "curveOffset: the vehicle turns at the ends of the rows")
    count = int(width / step + 1e-9) + 1
    return (Mow(point, math.radians(bearing), length, step, count, side),)


def _yoyo(element: Element, point: Point, found: Findings) -> tuple[Step, ...]:
    amplitude, pitch = _size(element, found, "amplitude"), _size(element, found, "pitch")
    if point.depth is None or not amplitude or not pitch:
        found.refuse("plan-form", element.where, "a yoyo needs a depth, an amplitude and a pitch")
        return ()
    shallow, deep = max(point.depth - amplitude, 0.0), point.depth + amplitude
    return (Undulate(point, shallow, deep, pitch),)


def _follow(element: Element, point: Point, found: Findings) -> tuple[Step, ...]:
    """A step to each offset (m) from the base point, in turn."""
    if not isinstance(point.place, Position):
        return ()
    path = element.one("path")
    steps: list[Step] = []
    for offset in path.all("nedOffsets") if path is not None else ():
        sizes = [_attribute(offset, f"{axis}Offset", found) for axis in ("north", "east", "depth")]
        place = _moved(point.place, sizes[0], sizes[1])
        depth = point.depth + sizes[2] if point.depth is not None else None
        steps.append(Go(Point(place, offset.where, point.name, depth, point.altitude, point.speed)))
    return tuple(steps)


_MANEUVERS: Mapping[str, Callable[[Element, Point, Findings], tuple[Step, ...]]] = MappingProxyType(
    {
        "Goto": _goto,
        "Loiter": _loiter,
        "StationKeeping": _loiter,
        "PopUp": _pop_up,
        "Rows": _rows,
        "RowsManeuver": _rows,
        "YoYo": _yoyo,
        "FollowPath": _follow,
    }
)


# --- points ---------------------------------------------------------------------------------------


def _point(holder: Element, element: Element, name: str, found: Findings) -> Point | None:
    place = _place(holder, found)
    if place is None:
        return None
    depth, altitude = _vertical(holder, found)
    speed = _speed(element, found)
    return Point(place, holder.where, name, depth, altitude, speed)


def _place(holder: Element, found: Findings) -> Position | None:
    """The position by latitude and longitude anywhere below, plus offsets in m."""
    said = {inner.name: inner for inner in holder.within()}
    if "latitude" not in said or "longitude" not in said:
        found.refuse("position", holder.where, "no latitude and longitude")
        return None
    latitude = _degrees(said["latitude"], "NS", found)
    longitude = _degrees(said["longitude"], "EW", found)
    if latitude is None or longitude is None:
        return None
    place = position(latitude, longitude, holder.where, found)
    north = _offset(said, "offset-north", "offset-south", found)
    east = _offset(said, "offset-east", "offset-west", found)
    return _moved(place, north, east) if place is not None and (north or east) else place


def _degrees(element: Element, letters: str, found: Findings) -> float | None:
    text = element.text.strip()
    match = _ANGLE.fullmatch(text)
    letter = (match["before"] or match["after"] or "") if match else ""
    minutes = float(match["minutes"] or 0.0) if match else 0.0
    seconds = float(match["seconds"] or 0.0) if match else 0.0
    wrong = match is None or (match["before"] and match["after"]) or letter not in ("", *letters)
    if match is None or wrong or minutes >= 60.0 or seconds >= 60.0 or (match["sign"] and letter):
        found.refuse(
            "position",
            element.where,
            f"{text[:40]!r} is no {element.name}",
            "as 41.18 or 41N10'48''",
        )
        return None
    size = float(match["degrees"]) + minutes / 60.0 + seconds / 3600.0
    return -size if match["sign"] or letter in ("S", "W") else size


def _offset(said: Mapping[str, Element], plus: str, minus: str, found: Findings) -> float:
    for name, sign in ((plus, 1.0), (minus, -1.0)):
        if name in said:
            value = number(said[name].text, name, said[name].where, found)
            return sign * value if value is not None else 0.0
    return 0.0


def _moved(place: Position, north: float, east: float) -> Position:
    latitude, longitude = LocalFrame(place).to_geodetic(north, east)
    return Position(math.degrees(latitude), math.degrees(longitude))


def _vertical(holder: Element, found: Findings) -> tuple[float | None, float | None]:
    """Depth and altitude. Old files have only ``depth``; there a negative value is an altitude."""
    said = {inner.name: inner.text.strip() for inner in holder.within()}
    units = said.get("zunits", "")
    text = said.get("z") if units else said.get("depth")
    if text is None or units in ("NONE", "HEIGHT"):
        if units == "HEIGHT":
            found.leave_out(holder.where, "a height above the sea's level")
        return None, None
    value = number(text, "z", holder.where, found)
    if value is None or (units and value < 0.0):
        found.refuse("plan-form", holder.where, f"{units.lower()} {text}: not under the water")
        return None, None
    if units == "ALTITUDE" or value < 0.0:
        return None, abs(value)
    return value, None


def _speed(element: Element, found: Findings) -> float | None:
    said = element.one("speed") or element.one("velocity")
    if said is None:
        return None
    unit = said.attributes.get("unit", "MPS")
    if unit.lower() not in _SPEEDS:
        found.leave_out(said.where, f"a speed in {unit[:20]}, which says nothing of this vehicle")
        return None
    value = number(said.text, "speed", said.where, found)
    return value * _SPEEDS[unit.lower()] if value is not None and value > 0.0 else None


def _size(element: Element, found: Findings, *path: str) -> float | None:
    """The absolute value of the number at the path; None if there is none."""
    if not element.said(*path):
        return None
    value = number(element.said(*path), path[-1], element.where, found)
    return abs(value) if value is not None else None


def _attribute(element: Element, name: str, found: Findings) -> float:
    return number(element.attributes.get(name, "0"), name, element.where, found) or 0.0
