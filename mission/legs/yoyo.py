"""Down and up between two depths while the other axes are held; done after its cycles.

A vehicle whose depth hold only pushes down reaches the shallow depth by buoyancy: a turn is due
half a metre before the depth that was asked for, or it might hover there for ever.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Self

from mission.legs.base import LegType, Track, View
from mission.model import Axis, Yoyo
from mission.model.copies import copied
from protocol.messages import Setpoint

TOLERANCE = 0.5  # m


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


TYPE = LegType(
    name="yoyo",
    kind=Yoyo,
    begin=_begin,
    steers=frozenset({Axis.VERTICAL}),
    needs=frozenset({"depth"}),
    ends=True,
    fault=_fault,
    depths=lambda kind: (kind.shallow, kind.deep),
)
