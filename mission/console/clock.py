"""What time it is for a vehicle that is heard over a way of unknown length. Sans-IO.

A frame's time less that of its arrival is the vehicle's zero on this computer's clock, less what
its way took. The greatest of the last minutes is of the frame that was quickest: what came slowly
is known to be old by it. What the quickest took nobody here can know. Clocks drift: old ones are
forgotten.
"""

from __future__ import annotations

import math

KEPT_S = 60.0  # and up to three times that


class VehicleClock:
    """``speed``: of the vehicle's time. Times of this computer are monotonic."""

    def __init__(self, speed: float = 1.0) -> None:
        self._speed = speed
        self._last: tuple[float, float] | None = None
        self._best = self._before = -math.inf
        self._since = 0.0

    def hear(self, at: tuple[float, float]) -> None:
        """The vehicle's time of a frame, and when it came; the same again says nothing."""
        if at == self._last:
            return
        if self._last is not None and at[0] < self._last[0]:  # it has begun anew
            self._best = self._before = -math.inf
        self._last = at
        if at[1] > self._since + KEPT_S:
            self._best, self._before, self._since = -math.inf, self._best, at[1]
        self._best = max(self._best, at[0] - at[1] * self._speed)

    def now(self, now: float) -> float:
        """0 while nothing has been heard."""
        if self._last is None:
            return 0.0
        return now * self._speed + max(self._best, self._before)
