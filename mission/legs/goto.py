"""To one place along the line from where the leg was entered; done within its arrival radius."""

from __future__ import annotations

from dataclasses import dataclass

from mission.legs.base import Author, LegType, View, straight
from mission.legs.guidance import GIVES, NEEDS, STEERS
from mission.legs.waypoints import WITHIN, Waypoints, arrival_fault
from mission.legs.words import Head, Shape
from mission.model import LegKind, Place
from mission.model.shown import number, place
from protocol.messages import Setpoint


@dataclass(frozen=True, slots=True)
class Goto(LegKind):
    """To a place along the track line from where the leg was entered (line of sight)."""

    place: Place
    within: float  # m, arrival radius


def _begin(kind: Goto, base: Setpoint, view: View) -> Waypoints:
    return Waypoints(base, (view.place(kind.place),), kind.within, view)


def _draw(author: Author) -> str:
    gear = author.rng.choice([4, 6, 8, 10])
    way = f"gear {gear}{author.way()} {author.timeout(600)}"
    return f"goto {author.place()} within 15 {way}"


TYPE: LegType = LegType(
    name="goto",
    kind=Goto,
    description="to a place, along the line",
    head=Head(Shape.PLACE, "place"),
    clauses=(WITHIN,),
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    fault=lambda kind: arrival_fault(kind.within),
    places=lambda kind: (kind.place,),
    corners=straight,
    within=lambda kind: float(kind.within),
    ends_at_last=True,
    shown=lambda kind: f"goto {place(kind.place)} within {number(kind.within)} m",
    done=lambda kind: "arrived",
    draws=(_draw,),
    trials=(
        "a: goto north 30 east 0 gear 8 depth 4 timeout 60",
        "a: goto north 200 east 0 gear 8 depth 4 timeout 40 else b\nb: heading 0 gear 0 for 10",
    ),
)
