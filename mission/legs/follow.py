"""Through several places in turn; done within the arrival radius of the last one."""

from __future__ import annotations

from dataclasses import dataclass

from mission.legs.base import Author, LegType, View, straight
from mission.legs.guidance import GIVES, NEEDS, STEERS
from mission.legs.waypoints import WITHIN, Waypoints, arrival_fault
from mission.legs.words import Head, Shape
from mission.model import LegKind, Place
from mission.model.shown import number
from protocol.messages import Setpoint


@dataclass(frozen=True, slots=True)
class Follow(LegKind):
    places: tuple[Place, ...]
    within: float  # m, arrival radius


def _begin(kind: Follow, base: Setpoint, view: View) -> Waypoints:
    return Waypoints(base, tuple(view.place(p) for p in kind.places), kind.within, view)


def _fault(kind: Follow) -> str:
    return arrival_fault(kind.within) if kind.places else "follow has no points"


def _draw(author: Author) -> str:
    places = ", ".join(author.place() for _ in range(author.rng.randint(2, 3)))
    return f"follow {places} within 15 gear 8{author.way()} {author.timeout(900)}"


TYPE: LegType = LegType(
    name="follow",
    kind=Follow,
    description="through several places in turn",
    head=Head(Shape.PLACES, "places"),
    clauses=(WITHIN,),
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    fault=_fault,
    places=lambda kind: tuple(kind.places),
    corners=straight,
    within=lambda kind: float(kind.within),
    ends_at_last=True,
    shown=lambda kind: f"follow {len(kind.places)} points within {number(kind.within)} m",
    done=lambda kind: "at the last point",
    draws=(_draw,),
    trials=("a: follow north 20 east 0, north 20 east 20 gear 8 depth 4 timeout 60",),
)
