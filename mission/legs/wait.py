"""The leg that keeps the settings in force, for a time or until an exit: wait 30s [until ...]."""

from __future__ import annotations

from dataclasses import dataclass

from mission.legs.base import WAY, Author, LegType
from mission.legs.words import Head, Shape
from mission.model import LegKind


@dataclass(frozen=True, slots=True)
class Wait(LegKind):
    """Keeps the settings in force for ``Leg.duration``, or until an exit."""


def _draw(author: Author) -> str:
    return f"wait {author.rng.randint(5, 60)}"


TYPE: LegType = LegType(
    name="wait",
    kind=Wait,
    description="hold whatever is set, for a time",
    head=Head(Shape.TIME),
    keeps=True,
    shown=lambda kind: "wait",
    draws=(_draw,),
    trials=(f"a: {WAY} for 10\nb: wait 30",),
)
