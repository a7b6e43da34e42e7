"""A circle about a place; it ends by its time or an exit, never by itself.

course = bearing from the centre + side * (90 deg + atan((distance - radius) / half lookahead))
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

from mission.legs import guidance
from mission.legs.base import Author, LegType, Point, Track, View
from mission.legs.guidance import GIVES, NEEDS, SIDE, STEERS
from mission.legs.words import Head, Measure, Shape
from mission.model import LegKind, Place
from mission.model.copies import copied
from mission.model.shown import number, place
from protocol.messages import Setpoint

LEAST_RADIUS = 4.0  # m; twice the turning radius as tried at sea
_RADIUS = Measure("radius", "m", 1, 5000, "of the circle")


@dataclass(frozen=True, slots=True)
class Loiter(LegKind):
    """A circle of ``radius`` m about a place (None: where entered); ``side``: +1 clockwise."""

    place: Place | None
    radius: float
    side: int


class Circle:
    __slots__ = ("_base", "_centre", "_heading", "_here", "_kind")

    def __init__(self, kind: Loiter, base: Setpoint, view: View) -> None:
        self._kind, self._base = kind, base
        self._centre = view.place(kind.place) if kind.place is not None else None
        self._here = kind.place is None
        self._heading = view.estimate.heading if view.estimate else None

    def setpoint(self, view: View) -> Setpoint:
        if view.estimate is not None:
            if self._here:
                self._centre, self._here = (view.estimate.north, view.estimate.east), False
            if self._centre is not None:
                course = self._course(self._centre, (view.estimate.north, view.estimate.east))
                self._heading = guidance.heading_for(course, view.estimate)
        return replace(self._base, heading=self._heading)

    def finished(self, view: View) -> bool:
        return False

    def track(self, view: View) -> Track | None:
        """``distance`` is to the centre; ``cross_track`` is positive outside the circle."""
        if view.estimate is None or self._centre is None:
            return None
        north = view.estimate.north - self._centre[0]
        east = view.estimate.east - self._centre[1]
        distance, bearing = math.hypot(north, east), math.atan2(east, north)
        return Track(distance, distance - self._kind.radius, bearing, bearing + math.pi)

    def clone(self) -> Self:
        return copied(self)

    def _course(self, centre: Point, here: Point) -> float:
        north, east = here[0] - centre[0], here[1] - centre[1]
        off = math.hypot(north, east) - self._kind.radius
        inward = math.pi / 2 + math.atan2(off, guidance.LOOKAHEAD / 2)
        return math.atan2(east, north) + self._kind.side * inward


def _begin(kind: Loiter, base: Setpoint, view: View) -> Circle:
    return Circle(kind, base, view)


def _fault(kind: Loiter) -> str:
    if kind.radius < LEAST_RADIUS:
        return f"the vehicle cannot circle tighter than {LEAST_RADIUS:g} m"
    return ""


def _square(kind: Loiter, named: tuple[Point, ...]) -> tuple[Point, ...]:
    """The four corners of the square about the circle."""
    (north, east), radius = named[0], kind.radius
    return tuple((north + n, east + e) for n in (-radius, radius) for e in (-radius, radius))


def _shown(kind: Loiter) -> str:
    about = f" about {place(kind.place)}" if kind.place is not None else ""
    turn = "clockwise" if kind.side > 0 else "counter-clockwise"
    return f"loiter{about}, radius {number(kind.radius)} m, {turn}"


def _draw(author: Author) -> str:
    rng = author.rng
    where = rng.choice([f" {author.place()}", ""])
    side = rng.choice(["starboard", "port"])
    radius, seconds = rng.randint(15, 50), rng.randint(30, 300)
    return f"loiter{where} radius {radius} side {side} gear 4 for {seconds}"


TYPE: LegType = LegType(
    name="loiter",
    kind=Loiter,
    description="circle about a place",
    head=Head(Shape.ABOUT, "place"),
    clauses=(_RADIUS, SIDE),
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    makes_way=True,
    fault=_fault,
    places=lambda kind: (kind.place,) if kind.place is not None else (),
    corners=_square,
    room=lambda kind: 0.0 if kind.place is not None else 2.0 * kind.radius,
    shown=_shown,
    draws=(_draw,),
    trials=(
        "a: loiter here radius 10 gear 4 depth 4 for 60",
        "a: loiter north 20 east 0 radius 10 gear 4 depth 4 for 60",
    ),
)
