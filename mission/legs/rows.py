"""A lawnmower area: parallel rows up and down, the way to its start first.

start -> end of row 1, across by the spacing, back along row 2, across, ...
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mission.legs.base import Author, LegType, Point, View
from mission.legs.guidance import GIVES, NEEDS, SIDE, STEERS
from mission.legs.waypoints import WITHIN, Waypoints, arrival_fault
from mission.legs.words import Head, Measure, Shape, Spot
from mission.model import LegKind, Place
from mission.model.shown import bearing, number, place
from protocol.messages import Setpoint

_BEARING = Measure(
    "bearing", "deg", 0, 360, "direction of the first row", example="90", circular=True
)
_LENGTH = Measure("length", "m", 1, 20000, "length of each row")
_SPACING = Measure("spacing", "m", 0.5, 2000, "distance between rows", example="20")
_FROM = Spot("from", "start", "where the first row begins; where it is, unless said")


@dataclass(frozen=True, slots=True)
class Rows(LegKind):
    """A lawnmower area: ``count`` parallel rows of ``length``, ``spacing`` apart, first along
    ``bearing`` (rad), the others to ``side`` of it (+1 starboard, -1 port), from ``start``."""

    start: Place | None  # None: where the leg is entered
    bearing: float
    length: float
    spacing: float
    count: int
    side: int
    within: float  # m, arrival radius


def corners(kind: Rows, start: Point) -> tuple[Point, ...]:
    """The points in the order they are visited, the start first."""
    ahead = (math.cos(kind.bearing), math.sin(kind.bearing))
    across = (-kind.side * ahead[1], kind.side * ahead[0])
    points = []
    for row in range(kind.count):
        ends = (0.0, kind.length) if row % 2 == 0 else (kind.length, 0.0)
        offset = row * kind.spacing
        for reach in ends:
            north = start[0] + reach * ahead[0] + offset * across[0]
            east = start[1] + reach * ahead[1] + offset * across[1]
            points.append((north, east))
    return tuple(points)


def _begin(kind: Rows, base: Setpoint, view: View) -> Waypoints:
    start: Point | None
    if kind.start is not None:
        start = view.place(kind.start)
    else:
        start = (view.estimate.north, view.estimate.east) if view.estimate else None
    points = corners(kind, start) if start is not None else (None,)
    return Waypoints(base, points, kind.within, view)


def _fault(kind: Rows) -> str:
    if kind.count < 1:
        return "an area has at least one row"
    if kind.length <= 0.0 or (kind.spacing <= 0.0 and kind.count > 1):
        return "length and spacing of the rows must be greater than 0"
    return arrival_fault(kind.within)


def _area(kind: Rows, named: tuple[Point, ...]) -> tuple[Point, ...]:
    """The four corners of the area, which lies at the place that is named."""
    (north, east) = named[0]
    c, s = math.cos(kind.bearing), math.sin(kind.bearing)
    wide = kind.spacing * (kind.count - 1) * kind.side
    return tuple(
        (north + a * c - b * s, east + a * s + b * c)
        for a in (0.0, kind.length)
        for b in (0.0, wide)
    )


def _room(kind: Rows) -> float:
    if kind.start is not None:
        return 0.0
    return math.hypot(kind.length, kind.spacing * (kind.count - 1))


def _shown(kind: Rows) -> str:
    start = f" from {place(kind.start)}" if kind.start is not None else ""
    side = "starboard" if kind.side > 0 else "port"
    return (
        f"{kind.count} rows of {number(kind.length)} m, {number(kind.spacing)} m apart to {side}, "
        f"first {bearing(kind.bearing)}{start}"
    )


def _draw(author: Author) -> str:
    rng = author.rng
    start = rng.choice([f" from {author.place()}", ""])
    return (
        f"rows {rng.randint(2, 4)} bearing {rng.randrange(0, 360, 15)} "
        f"length {rng.randint(30, 120)} spacing {rng.randint(10, 30)} "
        f"side {rng.choice(['starboard', 'port'])}{start} within 8 gear 8 {author.timeout(900)}"
    )


TYPE: LegType = LegType(
    name="rows",
    kind=Rows,
    description="a lawnmower: so many parallel rows",
    head=Head(Shape.COUNT, "count"),
    clauses=(_BEARING, _LENGTH, _SPACING, SIDE, _FROM, WITHIN),
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    fault=_fault,
    places=lambda kind: (kind.start,) if kind.start is not None else (),
    corners=_area,
    room=_room,
    within=lambda kind: float(kind.within),
    shown=_shown,
    done=lambda kind: "all rows done",
    draws=(_draw,),
    trials=(
        "a: rows 2 bearing 90 length 20 spacing 10 within 5 gear 6 depth 4 timeout 60",
        "a: rows 2 bearing 0 length 20 spacing 10 from north 10 east 0 gear 6 depth 4 timeout 90",
    ),
)
