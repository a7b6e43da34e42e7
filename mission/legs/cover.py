"""Rows over an area: a polygon, along the edge across which it is narrowest, or along a bearing.

The rows begin at the end nearest to the first named place. Bearing, number and order follow from
the polygon alone, so that check, engine and pictures find the same rows. If the polygon is concave,
a row has several pieces; the way from one to the next may lead outside, but stays within the hull
of the corners.

With ``resurface`` or ``unsure`` it is divided into runs with fixes between them (resurfacing.py).
The number of rows is then taken from a plane about the first corner; the last run takes all rows
that are left.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from mission.legs.base import Author, LegType, Point, View, straight
from mission.legs.guidance import GIVES, NEEDS, STEERS
from mission.legs.pattern import Pattern
from mission.legs.resurfacing import RESURFACE, UNSURE, Run, parted, parting_fault
from mission.legs.rows import BEARING as OF_ROWS
from mission.legs.rows import SKIP, SPACING, SWATH
from mission.legs.strips import across, flown, narrowest, pieces, strips
from mission.legs.waypoints import WITHIN, Waypoints, arrival_fault
from mission.legs.words import Head, Measure, Misfit, Shape
from mission.model import HOME, Leg, LegKind, Local, Place, Position
from mission.model.shown import bearing, number
from protocol.messages import Setpoint

NARROWEST = -1.0  # as a bearing: none is given
MOST = 300  # rows of one leg
_BEARING = replace(OF_ROWS, usual=NARROWEST, silent=True)
_SPACING = replace(SPACING, usual=0.0, silent=True)
_OVERLAP = Measure(
    "overlap", "", 0, 0.9, "share of the swath that neighbouring rows both see", 0.0, "20%",
    silent=True,
)  # fmt: skip


_ONLY = Measure(
    "only", "", 1, 9999, "rows of the area that are flown; all unless said", 0.0, "4", silent=True
)


@dataclass(frozen=True, slots=True)
class Cover(LegKind):
    """Rows over the polygon ``area``, ``spacing`` m apart at most, along ``bearing`` (rad;
    NARROWEST: along the edge across which the polygon is narrowest)."""

    area: tuple[Place, ...]
    bearing: float
    spacing: float  # m; 0: by swath and overlap
    overlap: float
    within: float  # m, arrival radius
    skip: float = 0.0  # rows before the first of these
    only: float = 0.0  # rows of these; 0: all
    swath: float = 0.0  # m seen, half to either side; 0: not given
    resurface: float = 0.0  # rows between fixes; 0: none
    unsure: float = 0.0  # m of uncertainty; 0: none

    @property
    def apart(self) -> float:
        """The greatest distance between its rows, m."""
        return self.spacing or self.swath * (1.0 - self.overlap)


def _pattern(kind: Cover, named: tuple[Point, ...], here: Point) -> Pattern:
    """The whole polygon is the area; ``here`` is not used."""
    (north, east), along = named[0], _along(kind, named)
    c, s = math.cos(along), math.sin(along)
    outline = [
        ((n - north) * c + (e - east) * s, (e - east) * c - (n - north) * s) for n, e in named
    ]
    ahead, aside = ((min(axis), max(axis)) for axis in zip(*outline, strict=True))
    count = strips(aside[1] - aside[0], kind.apart)
    spacing = (aside[1] - aside[0]) / count
    rows = flown(pieces(outline, aside[0], spacing, count), (0.0, 0.0))
    first = int(kind.skip)

    def back(point: Point) -> Point:
        a, b = point
        return north + a * c - b * s, east + a * s + b * c

    return Pattern(
        origin=named[0],
        bearing=along,
        side=1,
        rows=tuple(
            (back(begin), back(end))
            for begin, end in rows[first : first + int(kind.only) if kind.only else None]
        ),
        spacing=spacing,
        swath=kind.swath,
        within=kind.within,
        along=ahead,
        across=aside,
        outline=named,
        whole=False,
    )


def _begin(kind: Cover, base: Setpoint, view: View) -> Waypoints:
    named = tuple(point for place in kind.area if (point := view.place(place)) is not None)
    if len(named) < len(kind.area):
        return Waypoints(base, (None,), kind.within, view)
    return Waypoints(base, _pattern(kind, named, named[0]).points, kind.within, view)


def plane(area: Sequence[Place]) -> tuple[Point, ...]:
    """The points, m, of places that are all relative to home, or all in degrees: those relative to
    the first of them. Empty for a mixture, whose distances depend on where home is."""
    places = [Local(0.0, 0.0) if place == HOME else place for place in area]
    local = [(p.north, p.east) for p in places if isinstance(p, Local)]
    degrees = [p for p in places if isinstance(p, Position)]
    if local and degrees:
        return ()
    if local:
        return tuple(local)
    first = degrees[0]
    high, wide = _degree(math.radians(first.latitude_deg))
    return tuple(
        (
            high * (p.latitude_deg - first.latitude_deg),
            wide * math.remainder(p.longitude_deg - first.longitude_deg, 360.0),
        )
        for p in degrees
    )


def _degree(latitude: float) -> Point:
    """The length, m, of a degree of latitude and of longitude at a latitude (rad), on WGS 84.

    Source: NGA, American Practical Navigator (Bowditch), length of a degree.
    """
    return (
        111_132.92 - 559.82 * math.cos(2.0 * latitude) + 1.175 * math.cos(4.0 * latitude),
        111_412.84 * math.cos(latitude) - 93.5 * math.cos(3.0 * latitude),
    )


def _fault(kind: Cover) -> str:
    if not (kind.resurface.is_integer() and kind.skip.is_integer() and kind.only.is_integer()):
        return "resurface, skip and only count whole rows"
    if kind.apart <= 0.0:
        return "the spacing of the rows must be greater than 0"
    if len(kind.area) < 3:
        return "an area has at least three corners"
    named = plane(kind.area)
    if not named:
        return "its corners are all metres from home, or all latitudes and longitudes: not both"
    many = f"more than {MOST} rows: make the area smaller, or the spacing greater"
    if strips(_wide(kind, named), kind.apart) > MOST:
        return many
    rows = _estimated(kind).rows
    if not rows:
        return "no row finds room in it: is it an area, and skip less than its rows?"
    return many if len(rows) > MOST else arrival_fault(kind.within)


def _wide(kind: Cover, named: Sequence[Point]) -> float:
    aside = across(named, _along(kind, named))
    return max(aside) - min(aside)


def _along(kind: Cover, named: Sequence[Point]) -> float:
    return narrowest(named) if kind.bearing < 0.0 else kind.bearing


def _estimated(kind: Cover) -> Pattern:
    named = plane(kind.area)
    return _pattern(kind, named, named[0])


def _misfit(given: Mapping[str, float]) -> Misfit | None:
    if "spacing" not in given and "swath" not in given:
        hint = "add for instance spacing 20, or swath 25 overlap 20%"
        return Misfit("missing-word", "cover", "cover needs spacing or swath", hint)
    if "overlap" in given and "spacing" in given:
        message = "spacing and overlap both say how far apart rows are"
        return Misfit("contradiction", "overlap", message, "keep one of them")
    if "overlap" in given and "swath" not in given:
        return Misfit("missing-word", "overlap", "overlap is a share of swath", "add swath")
    return None


def _parts(leg: Leg) -> tuple[Leg, ...]:
    kind = leg.kind
    assert isinstance(kind, Cover)
    each = 1 if kind.unsure > 0.0 else int(kind.resurface)
    if not each or _fault(kind) or each >= len(_estimated(kind).rows):
        return ()
    return parted(leg, _runs(kind, each), kind.unsure)


def _runs(kind: Cover, each: int) -> Iterator[Run]:
    """The runs. The share of each follows from the length of its rows and of the ways between."""
    estimated = _estimated(kind)
    rows = estimated.rows
    whole = _way(rows, estimated.spacing)
    for row in range(0, len(rows), each):
        own = rows[row : row + each]
        only = float(each) if row + each < len(rows) else max(0.0, kind.only - row)
        part = replace(kind, skip=kind.skip + row, only=only, resurface=0.0, unsure=0.0)
        (a, b), (c, d) = own[-1]
        heading = math.atan2(d - b, c - a) % math.tau
        yield Run(row, part, _way(own, estimated.spacing) / whole, heading)


def _way(rows: Sequence[tuple[Point, Point]], spacing: float) -> float:
    return sum(math.dist(*row) + spacing for row in rows)


def _parts_fault(leg: Leg) -> str:
    kind = leg.kind
    assert isinstance(kind, Cover)
    return _fault(kind) or parting_fault(leg, kind.resurface, kind.unsure)


def _shown(kind: Cover) -> str:
    along = "bearing by its shape" if kind.bearing < 0.0 else bearing(kind.bearing)
    rows = f", from row {number(kind.skip + 1)} on" if kind.skip else ""
    rows += f", {number(kind.only)} of its rows" if kind.only else ""
    return (
        f"rows over an area of {len(kind.area)} corners, {number(kind.apart)} m apart at most, "
        f"{along}{rows}"
    )


def _corners(author: Author) -> str:
    """A rectangle, or one with a corner cut out of it."""
    rng = author.rng
    north, east = rng.randint(-60, 30), rng.randint(-60, 30)
    high, wide = rng.randint(30, 90), rng.randint(30, 90)
    cut = [(high // 2, wide), (high // 2, wide // 2), (high, wide // 2)]
    corners = [(0, 0), (0, wide), *rng.choice([[(high, wide)], cut]), (high, 0)]
    return ", ".join(f"north {north + n} east {east + e}" for n, e in corners)


def _draw(author: Author) -> str:
    rng = author.rng
    apart = rng.choice([f"spacing {rng.randint(10, 30)}", "overlap 0.2 swath 25"])
    along = rng.choice(["", f" bearing {rng.randrange(0, 360, 15)}"])
    return (
        f"cover {_corners(author)}{along} {apart} within 8 gear 8{author.way()} "
        f"{author.timeout(900)}"
    )


def _draw_fixes(author: Author) -> str:
    rng = author.rng
    rule = rng.choice([f"resurface {rng.randint(1, 2)}", f"unsure {rng.randint(5, 40)}"])
    return (
        f"cover {_corners(author)} spacing {rng.randint(15, 30)} within 8 swath 20 {rule} "
        f"gear 8 depth {author.depth()} {author.timeout(900)}"
    )


_SQUARE = "north 0 east 0, north 0 east 20, north 20 east 20, north 20 east 0"

TYPE: LegType = LegType(
    name="cover",
    kind=Cover,
    description="rows over an area: its corners, in their order",
    head=Head(Shape.PLACES, "area"),
    clauses=(_BEARING, _SPACING, _OVERLAP, WITHIN, SKIP, _ONLY, SWATH, RESURFACE, UNSURE),
    contradiction=_misfit,
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    pattern=_pattern,
    encloses=True,
    fault=_fault,
    places=lambda kind: tuple(kind.area),
    corners=straight,
    within=lambda kind: float(kind.within),
    shown=_shown,
    done=lambda kind: "all rows done",
    parts=_parts,
    parts_fault=_parts_fault,
    draws=(_draw, _draw_fixes),
    trials=(
        f"a: cover {_SQUARE} spacing 10 within 5 gear 6 depth 4 timeout 90",
        f"a: cover {_SQUARE} spacing 10 within 5 resurface 1 gear 6 depth 4 timeout 120",
    ),
)
