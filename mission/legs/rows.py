"""A lawnmower area: parallel rows up and down, after the way to its start.

start -> end of row 1, across by the spacing, back along row 2, across, ...

With ``resurface`` or ``unsure`` it is divided into runs with fixes between them (resurfacing.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from mission.legs.base import Author, LegType, Point, View
from mission.legs.guidance import GIVES, NEEDS, SIDE, STEERS
from mission.legs.pattern import Pattern
from mission.legs.resurfacing import RESURFACE, UNSURE, Run, parted, parting_fault
from mission.legs.waypoints import WITHIN, Waypoints, arrival_fault
from mission.legs.words import Head, Measure, Shape, Spot
from mission.model import Leg, LegKind, Place
from mission.model.shown import bearing, number, place
from protocol.messages import Setpoint

BEARING = Measure(
    "bearing", "deg", 0, 360, "direction of the first row", example="90", circular=True
)
_LENGTH = Measure("length", "m", 1, 20000, "length of each row")
SPACING = Measure("spacing", "m", 0.5, 2000, "distance between rows", example="20")
SWATH = Measure(
    "swath", "m", 0.5, 2000, "seen along each row; its coverage is told", 0.0, "20", silent=True
)
SKIP = Measure(
    "skip", "", 1, 9999, "rows of the area passed over: flown before", 0.0, "2", silent=True
)
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
    swath: float = 0.0  # m seen, half to either side; 0: not given
    resurface: float = 0.0  # rows between fixes; 0: none
    unsure: float = 0.0  # m of uncertainty; 0: none
    skip: float = 0.0  # rows of the area before the first of these


def corners(kind: Rows, start: Point) -> tuple[Point, ...]:
    """The points in the order they are visited, the start first."""
    ahead = (math.cos(kind.bearing), math.sin(kind.bearing))
    across = (-kind.side * ahead[1], kind.side * ahead[0])
    points = []
    for row in range(int(kind.skip), int(kind.skip) + kind.count):
        ends = (0.0, kind.length) if row % 2 == 0 else (kind.length, 0.0)
        offset = row * kind.spacing
        for reach in ends:
            north = start[0] + reach * ahead[0] + offset * across[0]
            east = start[1] + reach * ahead[1] + offset * across[1]
            points.append((north, east))
    return tuple(points)


def _pattern(kind: Rows, named: tuple[Point, ...], here: Point) -> Pattern:
    """The area extends beyond its outer rows by half the swath, at most by half the spacing."""
    start = named[0] if named else here
    points = corners(kind, start)
    spacing = kind.spacing if kind.count > 1 else max(kind.spacing, kind.swath)
    edge = min(kind.swath, spacing) / 2.0
    first, last = kind.skip * kind.spacing, (kind.skip + kind.count - 1) * kind.spacing
    ends = points[-2:] if kind.count % 2 == 0 else points[-1:-3:-1]
    return Pattern(
        origin=start,
        bearing=kind.bearing,
        side=kind.side,
        rows=tuple(zip(points[::2], points[1::2], strict=True)),
        spacing=spacing,
        swath=kind.swath,
        within=kind.within,
        along=(0.0, kind.length),
        across=(first - edge, last + edge),
        outline=(points[0], points[1], *ends),
    )


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
    if not (kind.resurface.is_integer() and kind.skip.is_integer()):
        return "resurface and skip count whole rows"
    return arrival_fault(kind.within)


def _area(kind: Rows, named: tuple[Point, ...]) -> tuple[Point, ...]:
    """The four corners of the area, which starts at the named place."""
    (north, east) = named[0]
    c, s = math.cos(kind.bearing), math.sin(kind.bearing)
    first = kind.spacing * kind.skip * kind.side
    wide = kind.spacing * (kind.count - 1) * kind.side
    return tuple(
        (north + a * c - b * s, east + a * s + b * c)
        for a in (0.0, kind.length)
        for b in (first, first + wide)
    )


def _room(kind: Rows) -> float:
    if kind.start is not None:
        return 0.0
    return math.hypot(kind.length, kind.spacing * (kind.skip + kind.count - 1))


def _shown(kind: Rows) -> str:
    start = f" from {place(kind.start)}" if kind.start is not None else ""
    side = "starboard" if kind.side > 0 else "port"
    if kind.skip:
        start += f", from row {number(kind.skip + 1)} on"
    return (
        f"{kind.count} rows of {number(kind.length)} m, {number(kind.spacing)} m apart to {side}, "
        f"first {bearing(kind.bearing)}{start}"
    )


# --- fixes on the way -----------------------------------------------------------------------------


def _parts(leg: Leg) -> tuple[Leg, ...]:
    kind = leg.kind
    assert isinstance(kind, Rows)
    each = 1 if kind.unsure > 0.0 else int(kind.resurface) or kind.count
    if each >= kind.count:
        return ()
    return parted(leg, (_run(kind, row, each) for row in range(0, kind.count, each)), kind.unsure)


def _run(kind: Rows, row: int, each: int) -> Run:
    count = min(each, kind.count - row)
    skip = kind.skip + row
    back = math.pi if (skip + count) % 2 == 0 else 0.0
    flown = replace(kind, count=count, skip=skip, resurface=0.0, unsure=0.0)
    return Run(row, flown, count / kind.count, (kind.bearing + back) % math.tau)


def _parts_fault(leg: Leg) -> str:
    kind = leg.kind
    assert isinstance(kind, Rows)
    if why := _fault(kind):
        return why
    if kind.start is None:
        return "rows that resurface drift off: say with from where they begin"
    return parting_fault(leg, kind.resurface, kind.unsure)


def _draw(author: Author) -> str:
    rng = author.rng
    start = rng.choice([f" from {author.place()}", ""])
    return (
        f"rows {rng.randint(2, 4)} bearing {rng.randrange(0, 360, 15)} "
        f"length {rng.randint(30, 120)} spacing {rng.randint(10, 30)} "
        f"side {rng.choice(['starboard', 'port'])}{start} within 8 gear 8 {author.timeout(900)}"
    )


def _draw_fixes(author: Author) -> str:
    rng = author.rng
    rule = rng.choice([f"resurface {rng.randint(1, 2)}", f"unsure {rng.randint(5, 40)}"])
    aims = rng.choice(["", " achieve coverage 30%", " achieve coverage 20% position 300"])
    area = f"rows {rng.randint(2, 4)} bearing {rng.randrange(0, 360, 15)}"
    return (
        f"{area} length {rng.randint(30, 80)} "
        f"spacing {rng.randint(10, 30)} from {author.place()} within 8 swath 20 {rule} "
        f"gear 8 depth {author.depth()} {author.timeout(900)}{aims}"
    )


TYPE: LegType = LegType(
    name="rows",
    kind=Rows,
    description="a lawnmower: so many parallel rows",
    head=Head(Shape.COUNT, "count"),
    clauses=(BEARING, _LENGTH, SPACING, SIDE, _FROM, WITHIN, SKIP, SWATH, RESURFACE, UNSURE),
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    pattern=_pattern,
    fault=_fault,
    places=lambda kind: (kind.start,) if kind.start is not None else (),
    corners=_area,
    room=_room,
    within=lambda kind: float(kind.within),
    shown=_shown,
    done=lambda kind: "all rows done",
    parts=_parts,
    parts_fault=_parts_fault,
    draws=(_draw, _draw_fixes),
    trials=(
        "a: rows 2 bearing 90 length 20 spacing 10 within 5 gear 6 depth 4 timeout 60",
        "a: rows 2 bearing 0 length 20 spacing 10 from north 10 east 0 gear 6 depth 4 timeout 90",
        "a: rows 3 bearing 0 length 20 spacing 10 from north 10 east 0 resurface 1 gear 6 depth 4 "
        "timeout 120",
        "a: rows 2 bearing 0 length 20 spacing 10 from north 10 east 0 unsure 5 gear 6 "
        "depth 4 timeout 120",
    ),
)
