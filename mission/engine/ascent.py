"""Surfacing, proved and not assumed (R7): the ascent of the surface leg and of the emergency.

    W, 10 s  -- the depth does not fall -->  X0 and U12, 10 s  -- it does not -->  W ...
       ^ kept while it falls                     ^ kept while it falls

An ACK proves nothing, and on the vehicle as built W does not stick. An unknown depth counts as not
falling. It never gives up; whether the surface is reached is seen by the senses (depth below 0.5 m
for 6 s, or a fix), and then everything is stopped.
"""

from __future__ import annotations

import copy
from typing import Self

from mission.model import Action
from protocol.messages import Order, Setpoint

TURN = 10.0  # s each way is given (R7)
FALL = 0.3  # m in that time: 0.03 m/s, twice the noise of the difference of two depths
UPWARD = Setpoint(heave=-1.0)  # a whole set: what it does not control is cleared by X0


class Ascent:
    __slots__ = ("_since", "_start_depth", "_thrust", "_why", "began")

    def __init__(self, now: float, depth: float | None, why: str) -> None:
        self.began = self._since = now
        self._start_depth, self._why = depth, why
        self._thrust = False

    def first(self) -> tuple[Action, ...]:
        return (Action(Order.SURFACE, self._why),)

    def act(self, now: float, depth: float | None) -> tuple[Action, ...]:
        """What is due; nothing while the way in use is being tried, or works."""
        if now < self._since + TURN:
            return ()
        before, self._start_depth, self._since = self._start_depth, depth, now
        if before is not None and depth is not None and before - depth >= FALL:
            return ()
        seen = "is not known" if depth is None or before is None else f"is {depth:.1f} m, no less"
        why = f"{self._why}: after {TURN:g} s the depth {seen}"
        self._thrust = not self._thrust
        return (Action(UPWARD if self._thrust else Order.SURFACE, why),)

    def next_timer(self) -> float:
        return self._since + TURN

    def clone(self) -> Self:
        return copy.copy(self)
