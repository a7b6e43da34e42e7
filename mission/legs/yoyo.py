"""Down and up between two depths while the other axes are held; done after its cycles.

A vehicle whose depth hold only pushes down reaches the shallow depth by buoyancy. So a turn is due
half a metre before the depth that was asked for; otherwise it might hover there forever.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

from mission.legs.base import Author, LegType, Track, View
from mission.legs.words import Head, Measure, Misfit, Shape
from mission.model import Axis, LegKind
from mission.model.copies import copied
from mission.model.shown import number
from protocol.messages import Setpoint

TOLERANCE = 0.5  # m
_SHALLOW = Measure("shallow", "m", 0, 9999, "upper turning depth", example="2")
_DEEP = Measure("deep", "m", 0.5, 9999, "lower turning depth", example="10")


@dataclass(frozen=True, slots=True)
class Yoyo(LegKind):
    """Between two depths, ``cycles`` times down and up, while the other axes are held."""

    shallow: float
    deep: float
    cycles: int


class Profile:
    __slots__ = ("_base", "_done", "_down", "_kind")

    def __init__(self, kind: Yoyo, base: Setpoint) -> None:
        self._kind, self._base = kind, base
        self._down, self._done = True, 0

    def setpoint(self, view: View) -> Setpoint:
        self._turn(view)
        deep = self._down and self._done < self._kind.cycles
        return replace(self._base, depth=self._kind.deep if deep else self._kind.shallow)

    def finished(self, view: View) -> bool:
        self._turn(view)
        return self._done >= self._kind.cycles

    def _turn(self, view: View) -> None:
        if view.depth is not None and self._done < self._kind.cycles:
            if self._down and view.depth >= self._kind.deep - TOLERANCE:
                self._down = False
            elif not self._down and view.depth <= self._kind.shallow + TOLERANCE:
                self._down = True
                self._done += 1

    def track(self, view: View) -> Track | None:
        return None

    def clone(self) -> Self:
        return copied(self)


def _begin(kind: Yoyo, base: Setpoint, view: View) -> Profile:
    return Profile(kind, base)


def _fault(kind: Yoyo) -> str:
    if kind.cycles < 1:
        return "a yoyo has at least one cycle"
    if not 0.0 <= kind.shallow < kind.deep:
        return "the shallow depth must be less than the deep one"
    if kind.deep - kind.shallow <= 2 * TOLERANCE:
        return f"the depths of a yoyo must differ by more than {2 * TOLERANCE:g} m"
    return ""


def _contradiction(given: Mapping[str, float]) -> Misfit | None:
    if given.get("shallow", 0.0) >= given.get("deep", math.inf):
        return Misfit("upside-down", "shallow", "shallow is not above deep", "swap them")
    return None


def _shown(kind: Yoyo) -> str:
    return f"yoyo {number(kind.shallow)} to {number(kind.deep)} m, {kind.cycles} times"


def _draw(author: Author) -> str:
    rng = author.rng
    deep = max(3, author.depth())
    return (
        f"yoyo {rng.randint(1, 3)} shallow {rng.randint(1, deep - 1)} deep {deep} "
        f"{author.course()} {author.timeout(600)}"
    )


TYPE: LegType = LegType(
    name="yoyo",
    kind=Yoyo,
    description="down and up between two depths, so many times",
    head=Head(Shape.COUNT, "cycles"),
    clauses=(_SHALLOW, _DEEP),
    contradiction=_contradiction,
    begin=_begin,
    steers=frozenset({Axis.VERTICAL}),
    needs=frozenset({"depth"}),
    ends=True,
    fault=_fault,
    depths=lambda kind: (kind.shallow, kind.deep),
    shown=_shown,
    done=lambda kind: "all cycles done",
    draws=(_draw,),
    trials=("a: yoyo 2 shallow 2 deep 6 heading 0 gear 6 timeout 60",),
)
