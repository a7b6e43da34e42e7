"""Items of a MAVLink mission (mavlink.io/en/messages/common.html, MAV_CMD and MAV_FRAME) as steps.

Heights: home is on the water, so a negative height is a depth. In the two terrain frames a positive
height is an altitude. A height of 0 is the surface if other items are under water; if none is (the
plan of a boat), it tells nothing about the depth.

Commands from 95 on (conditions, payload, autopilot) and takeoff are left out, except a change of
speed (178), which is used, and a jump (177). A jump, and commands below 95 without a counterpart,
are refused, since they change where the vehicle goes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mission.authoring.importing.route import (
    At,
    Circle,
    Findings,
    Go,
    Home,
    Point,
    Rise,
    Step,
    below,
    position,
)
from mission.model import Position

WAYPOINT, SPLINE = 16, 82
_UNLIMITED, _TURNS, _TIME, _RETURN, _LAND, _TAKEOFF = 17, 18, 19, 20, 21, 22
_LAST_NAV, _JUMP, _SPEED = 95, 177, 178
FRAMES = frozenset({0, 2, 3, 5, 6, 10, 11})
ABSOLUTE = 0
_TERRAIN = frozenset({10, 11})


@dataclass(frozen=True, slots=True)
class Item:
    """One item. ``numbers``: four parameters, then latitude, longitude, height; None if not
    given."""

    command: int
    frame: int
    numbers: Sequence[float | None]
    where: At


def steps_of(items: Iterable[Item], found: Findings) -> tuple[Step, ...]:
    known = tuple(items)
    reader = _Reader(found, dives=any(_is_under(item) for item in known))
    return tuple(step for item in known for step in reader.steps(item))


class _Reader:
    """Reads items in turn; a change of speed applies to all later items."""

    def __init__(self, found: Findings, dives: bool) -> None:
        self._found, self._dives = found, dives
        self._speed: float | None = None

    def steps(self, item: Item) -> tuple[Step, ...]:
        if item.frame not in FRAMES:
            self._found.refuse(
                "no-counterpart", item.where, f"frame {item.frame} is no frame of places on earth"
            )
            return ()
        match item.command:
            case 16 | 82:
                return self._waypoint(item)
            case 18 | 19:
                return self._circle(item)
            case 20:
                return (Home(item.where),)
            case 21:
                there = self._point(item) if _has_place(item) else None
                return (*((Go(there),) if there else ()), Rise(item.where))
            case _:
                self._other(item)
                return ()

    def _waypoint(self, item: Item) -> tuple[Step, ...]:
        if item.numbers[0]:
            self._found.leave_out(item.where, "the time to stay: it has way on; write loiter")
        point = self._point(item)
        return (Go(point),) if point is not None else ()

    def _circle(self, item: Item) -> tuple[Step, ...]:
        point, radius = self._point(item), item.numbers[2] or 0.0
        if radius == 0.0:
            self._found.refuse(
                "plan-form", item.where, "a circle without a radius", "set its third parameter"
            )
        if not item.numbers[0] or item.numbers[0] < 0.0:
            self._found.refuse(
                "no-counterpart", item.where, "a circle that never ends", "give it turns or a time"
            )
        if point is None or not item.numbers[0]:
            return ()
        turns, side = item.numbers[0], 1 if radius > 0.0 else -1
        if item.command == _TURNS:
            return (Circle(point, abs(radius), side, turns=turns),)
        return (Circle(point, abs(radius), side, seconds=turns),)

    def _other(self, item: Item) -> None:
        if item.command == _SPEED:
            if item.numbers[1] is not None and item.numbers[1] > 0.0:
                self._speed = item.numbers[1]
        elif item.command == _JUMP:
            self._found.refuse(
                "no-counterpart",
                item.where,
                "a jump has no counterpart",
                "write repeat in the mission",
            )
        elif item.command == _UNLIMITED:
            self._found.refuse(
                "no-counterpart", item.where, "a circle that never ends", "give it turns or a time"
            )
        elif item.command < _LAST_NAV and item.command != _TAKEOFF:
            self._found.refuse(
                "no-counterpart", item.where, f"command {item.command} has no counterpart"
            )
        else:
            self._found.leave_out(item.where, f"command {item.command}")

    def _point(self, item: Item) -> Point | None:
        place = place_of(item, self._found)
        if place is None:
            return None
        height = item.numbers[6]
        if item.frame in _TERRAIN and height is not None and height > 0.0:
            return Point(place, item.where, altitude=height, speed=self._speed)
        depth = below(height, item.where, self._found)
        if height == 0.0 and self._dives and item.frame not in _TERRAIN:
            depth = 0.0
        return Point(place, item.where, depth=depth, speed=self._speed)


def _is_under(item: Item) -> bool:
    height = item.numbers[6]
    return height is not None and height < 0.0


def _has_place(item: Item) -> bool:
    return bool(item.numbers[4] or item.numbers[5])


def place_of(item: Item, found: Findings) -> Position | None:
    """The position of an item; 0, 0 means that none is given, which is refused."""
    latitude, longitude = item.numbers[4], item.numbers[5]
    if latitude is None or longitude is None or not _has_place(item):
        found.refuse("position", item.where, "it has no latitude and longitude")
        return None
    return position(latitude, longitude, item.where, found)
