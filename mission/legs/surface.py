"""The leg that ascends and proves the surface (R7). The ascent itself is mission.engine.ascent,
shared with the emergency. The leg holds every axis itself, and ends with everything stopped."""

from __future__ import annotations

from dataclasses import dataclass, field

from mission.legs.base import WAY, Author, LegType
from mission.model import Axis, LegKind
from mission.model.plain import UNSAID


@dataclass(frozen=True, slots=True)
class Surface(LegKind):
    """Ascend; end at the proved surface (R7), or with a fix there (``until_fix``).
    ``keeps_outputs``: it is the ascent within another leg, whose outputs stay."""

    until_fix: bool = False
    keeps_outputs: bool = field(default=False, metadata=UNSAID)


def _draw(author: Author) -> str:
    fix = author.rng.choice(["", " until fix"])
    return f"surface{fix} timeout {author.rng.randint(60, 300)}"


TYPE: LegType = LegType(
    name="surface",
    kind=Surface,
    description="up, and prove it; `until fix`: with GPS",
    until_fix="until_fix",
    steers=frozenset(Axis),
    ends=True,
    ascends=True,
    makes_safe=lambda kind: not kind.keeps_outputs,
    shown=lambda kind: "surface until a fix" if kind.until_fix else "surface",
    done=lambda kind: "fix at the surface" if kind.until_fix else "at the surface",
    draws=(_draw,),
    trials=(
        f"a: {WAY} for 20\nb: surface timeout 90",
        f"a: {WAY} for 20\nb: surface until fix timeout 3min\nc: {WAY} for 20",
        f"a: {WAY} for 20\nb: surface until fix timeout 5",
    ),
)
