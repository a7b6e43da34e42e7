"""The event loop of every simulated flight: time jumps from event to event.

There is no tick, no clock and no thread; the same inputs give the same bytes. Of those who are due
at one instant, whoever stands first in ``dues`` goes first, then the next look is taken.

    busy.Busy (a bug of whoever is due: an instant that never ends)

What does not live here: who takes part (rig, exhaustive.world), the loop at sea (onboard.serve).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable

from mission.verification.rig.busy import Busy

_MOST = 200  # at one instant: more, and somebody is never done
Due = tuple[float | None, Callable[[], None]]  # s, and what is then to be done


class LockStep(ABC):
    def __init__(self, now: float = 0.0) -> None:
        self.now = now
        self._at_once = 0  # things done without time passing

    @abstractmethod
    def dues(self) -> Iterable[Due]:
        """When who has something to do; None: not before another has."""

    def step(self, until: float = math.inf) -> bool:
        """What is due first, if something is by then. Raises Busy."""
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
        """All that is due until then; it is then."""
        while self.step(end):
            pass
        self.now = end
