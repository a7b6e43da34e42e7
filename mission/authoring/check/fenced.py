"""Whether a leg, or the ascent from anywhere in it, may break an area of the mission.

    keep out   the swept path, widened by the error, may touch it at a depth at which it counts
    keep in    the path is not surely within one that counts at all depths of the leg

A leg sweeps the convex hull of its intended positions; the true position is within the error of it.
At any place in it a limit may begin an ascent, which drifts and passes all depths to the surface.

What does not live here: the bounds of a leg (bounds.py), the engine's own judgement (engine.areas).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from mission.authoring.check.bounds import Bounds, LegBounds
from mission.authoring.check.intervals import Interval
from mission.authoring.check.places import local_of
from mission.engine.areas import Fence
from mission.legs import LEGS
from mission.legs.base import Point
from mission.model import Mission, Position, Where, legs_of
from mission.model.shown import number
from mission.navigation.geodesy import LocalFrame
from mission.navigation.polygons import fault, gap, hull, inside


@dataclass(frozen=True, slots=True)
class Swept:
    """The hull of the intended positions in m from home, and the greatest distance (``margin``, m)
    of the true position from it."""

    body: tuple[Point, ...]
    margin: float
    depth: Interval


@dataclass(frozen=True, slots=True)
class Broken:
    """The first leg that may break an area. ``where``: a place of the area. ``near``: its distance
    from the swept path, m. ``ascent``: not the leg itself, but an ascent from it breaks it."""

    path: str
    fence: Fence
    where: Point
    near: float
    margin: float
    ascent: bool


def fenced(mission: Mission) -> tuple[Fence, ...]:
    """The mission's areas in m from home. Without a home, only corners given in m are right."""
    frame = LocalFrame(mission.home) if mission.home is not None else None
    return tuple(
        Fence(area, tuple(local_of(corner, frame) for corner in area.corners))
        for area in mission.areas
    )


def area_faults(mission: Mission) -> Iterator[tuple[Where, str, str]]:
    """Place, message and hint for each area that is no valid polygon."""
    for fence in fenced(mission):
        area = fence.area
        far = any(isinstance(corner, Position) for corner in area.corners)
        if far and mission.home is None:
            message = f"area {area.name} names a latitude and longitude, but the mission no home"
            yield area.where, message, "add home, or write north .. east .."
        elif why := fault(fence.polygon):
            hint = "name its corners one after the other, either way round"
            yield area.where, f"area {area.name}: {why}", hint
    frame = LocalFrame(mission.home) if mission.home is not None else None
    for leg in legs_of(mission.body):
        corners = tuple(local_of(place, frame) for place in LEGS[type(leg.kind)].places(leg.kind))
        if LEGS[type(leg.kind)].encloses and (why := fault(corners)):
            hint = "name its corners one after the other, either way round"
            yield leg.where, f"the area of {leg.name or 'this leg'}: {why}", hint


def swept(leg: LegBounds, entry: Bounds, sweep: Bounds) -> Swept:
    """What an active leg sweeps: straight ways between its entry and its places or end, with a
    margin for the error and for the turn at its beginning."""
    turning = leg.speed * math.pi / leg.vehicle.turn_rate / 2.0 if leg.speed else 0.0
    margin = sweep.error + turning + leg.row.within(leg.leg.kind)
    ahead = leg.places or _corners(sweep.north, sweep.east)
    return Swept(hull((*_corners(entry.north, entry.east), *ahead)), margin, sweep.depth)


def _corners(north: Interval, east: Interval) -> Iterator[Point]:
    return ((n, e) for n in north for e in east)


def broken(path: str, fences: Sequence[Fence], leg: Swept, drift: float) -> Broken | None:
    """The area that the leg, or else an ascent from it, may break. ``drift``: m that the ascent
    moves to any side."""
    if not fences:
        return None
    up = Swept(leg.body, leg.margin + drift, (0.0, leg.depth[1]))
    for ascent, body in ((False, leg), (True, up)):
        found = _out(fences, body) or _in(fences, body)
        if found is not None:
            return Broken(path, *found, body.margin, ascent)
    return None


_Found = tuple[Fence, Point, float]


def _out(fences: Iterable[Fence], leg: Swept) -> _Found | None:
    for fence in fences:
        if fence.area.out and fence.area.counts_between(*leg.depth):
            near = _apart(leg.body, fence.polygon)
            if near <= leg.margin:
                nearest = min(fence.polygon, key=lambda corner: _apart((corner,), leg.body))
                return fence, nearest, near
    return None


def _in(fences: Iterable[Fence], leg: Swept) -> _Found | None:
    counting = [f for f in fences if not f.area.out and f.area.counts_between(*leg.depth)]
    worst: _Found | None = None
    for fence in counting:
        whole = fence.area.counts_throughout(*leg.depth)
        outside = [point for point in leg.body if not inside(fence.polygon, point)]
        near = 0.0 if outside else gap(leg.body, fence.polygon)
        if whole and near > leg.margin:
            return None
        at = (outside or [min(leg.body, key=lambda p: gap((p,), fence.polygon))])[0]
        worst = worst or (fence, at, near)
    return worst


def _apart(body: Sequence[Point], polygon: Sequence[Point]) -> float:
    """The distance in m; 0 if one is within the other."""
    if inside(polygon, body[0]) or (len(body) > 2 and inside(body, polygon[0])):
        return 0.0
    return gap(body, polygon)


def words(found: Broken, name: str) -> str:
    """The message of the refusal."""
    who = f"the ascent from {name}" if found.ascent else name
    place = f"north {number(round(found.where[0]))} east {number(round(found.where[1]))}"
    reach = f"with current and uncertainty {found.margin:.0f} m to any side"
    if found.fence.area.out:
        near = f"within {found.near:.0f} m of" if found.near else "through"
        return f"{who} leads {near} {found.fence.words} ({place}), {reach}"
    return f"{who} may leave {found.fence.words} (about {place}), {reach}"
