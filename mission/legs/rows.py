"""A lawnmower area: parallel rows up and down, the way to its start first.

start -> end of row 1, across by the spacing, back along row 2, across, ...

With ``resurface`` it parts into runs of so many rows with a fix at the surface between them; with
``unsure`` into single rows, each followed by a look at the estimate's uncertainty and,
where that is too much, a fix. The estimate learns the current from each two fixes, and the next
rows are steered with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from mission.legs.base import Author, LegType, Point, View
from mission.legs.guidance import GIVES, NEEDS, SIDE, STEERS
from mission.legs.hold import Hold
from mission.legs.surface import Surface
from mission.legs.waypoints import WITHIN, Waypoints, arrival_fault
from mission.legs.words import Head, Measure, Shape, Spot
from mission.model import Comparison, Exit, Guard, Leg, LegKind, Place, Setting
from mission.model.shown import bearing, number, place
from protocol.messages import Setpoint

_BEARING = Measure(
    "bearing", "deg", 0, 360, "direction of the first row", example="90", circular=True
)
_LENGTH = Measure("length", "m", 1, 20000, "length of each row")
_SPACING = Measure("spacing", "m", 0.5, 2000, "distance between rows", example="20")
_SWATH = Measure(
    "swath", "m", 0.5, 2000, "seen along each row; its coverage is told", 0.0, "20", silent=True
)
_RESURFACE = Measure(
    "resurface", "", 1, 9999, "up for a fix after so many rows", 0.0, "2", silent=True
)
_ABOVE = Measure(
    "unsure",
    "m",
    1,
    10000,
    "up for a fix after a row where `uncertainty` is more",
    0.0,
    "15",
    silent=True,
)
_SKIP = Measure(
    "skip", "", 1, 9999, "rows of the area passed over: flown before", 0.0, "2", silent=True
)
FIX_S = 300.0  # that a way up may take until there is a fix; then the mission's on timeout
_LOOK_S = 4.0  # two reports: so long the estimate is looked at between two rows
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
    swath: float = 0.0  # m seen, half to either side; 0: not said
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
    """The four corners of the area, which lies at the place that is named."""
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


def _runs(kind: Rows) -> int:
    """Rows between two places at which it may surface; all of them where it does not."""
    if kind.unsure > 0.0:
        return 1
    return int(kind.resurface) or kind.count


def _parts(leg: Leg) -> tuple[Leg, ...]:
    kind = leg.kind
    if not isinstance(kind, Rows) or _runs(kind) >= kind.count:
        return ()
    parts: list[Leg] = []
    for row in range(0, kind.count, _runs(kind)):
        if row:
            parts += _between(leg, kind, row)
        count = min(_runs(kind), kind.count - row)
        run = replace(kind, count=count, skip=kind.skip + row, resurface=0.0, unsure=0.0)
        share = count / kind.count
        timeout = None if leg.timeout is None else leg.timeout * share
        parts.append(replace(leg, name=_run(row), kind=run, timeout=timeout, achieve=()))
    return tuple(parts)


def _run(row: int) -> str:
    return f"row{row + 1}"


def _between(leg: Leg, kind: Rows, row: int) -> list[Leg]:
    """Before ``row``: a fix, or a look at whether one is needed."""
    fix = Leg(f"fix{row}", Surface(until_fix=True), timeout=FIX_S, otherwise=leg.otherwise,
              where=leg.where)  # fmt: skip
    if kind.unsure <= 0.0:
        return [fix]
    known = Comparison("uncertainty", "<=", kind.unsure, where=leg.where)
    back = math.pi if (row + int(kind.skip)) % 2 == 0 else 0.0  # as the row before leads
    heading = Setting("heading", (kind.bearing + back) % math.tau, leg.where)
    look = Leg(f"look{row}", Hold(), (*leg.settings, heading),
               (Exit(Guard(known), _run(row), leg.where),), duration=_LOOK_S,
               otherwise=leg.otherwise, where=leg.where)  # fmt: skip
    return [look, fix]


def _parts_fault(leg: Leg) -> str:
    kind = leg.kind
    assert isinstance(kind, Rows)
    if why := _fault(kind):
        return why
    said = {setting.word for setting in leg.settings}
    if kind.resurface and kind.unsure:
        return "resurface and unsure are two rules for one thing: keep one"
    if kind.start is None:
        return "rows that resurface drift off: say with from where they begin"
    if "surge" not in said or said.isdisjoint({"depth", "altitude"}):
        return "at the surface all is off: say gear, and depth or altitude, in this leg"
    if leg.duration is not None:
        return "rows that resurface end by themselves: say timeout, not for"
    if any(way.target is None for way in leg.exits):
        return "until would lead to the next part of the rows: say until ... -> NAME"
    return ""


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
    clauses=(_BEARING, _LENGTH, _SPACING, SIDE, _FROM, WITHIN, _SKIP, _SWATH, _RESURFACE, _ABOVE),
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    surveys=True,
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
