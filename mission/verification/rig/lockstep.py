"""The event loop of every simulated flight: time jumps from event to event.

There is no tick, no clock and no thread; the same inputs give the same bytes. If several are due at
one instant, the first in ``dues`` runs; then the loop asks ``dues`` again.

    Busy      (a bug of a participant: it is due again and again, and time does not advance)

What does not live here: who takes part (rig, exhaustive.world), the loop at sea (onboard.serve).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable

_MOST = 200  # actions at one instant; with more, a participant never finishes
Due = tuple[float | None, Callable[[], None]]  # time in s, and the action that is due then


class Busy(Exception):
    """A participant is due again and again at one instant."""


class LockStep(ABC):
    def __init__(self, now: float = 0.0) -> None:
        self.now = now
        self._at_once = 0  # actions since time last advanced

    @abstractmethod
    def dues(self) -> Iterable[Due]:
        """Return who is due when. None: only after an action of another participant."""

    def step(self, until: float = math.inf) -> bool:
        """Do the first action that is due by ``until``; False if there is none. Raises Busy."""
        now, first, act = self.now, math.inf, None
        for due, what in self.dues():
            if due is not None and due < first:
                if due <= now:
                    first, act = now, what
                    break
                first, act = due, what
        if act is None or first > until:
            return False
        self._at_once = self._at_once + 1 if first == now else 0
        if self._at_once > _MOST:
            raise Busy(f"{self._at_once} inputs at {now:.3f} s")
        self.now = first
        act()
        return True

    def run_until(self, end: float) -> None:
        """Do all that is due by ``end``, and set the time to ``end``. Raises Busy."""
        while self.step(end):
            pass
        self.now = end
