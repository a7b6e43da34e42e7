"""The current time of a vehicle that is received with an unknown delay. Sans-IO.

The time of a frame minus its time of arrival is the vehicle's zero on this computer's clock, minus
the frame's delay. The maximum of the last minutes is from the frame with the least delay. Slower
frames are known to be old by comparison. The delay of the fastest frame cannot be known here.
Clocks drift, so old values are dropped.
"""

from __future__ import annotations

import math

KEPT_S = 60.0  # values are kept for that long, and up to three times that


class VehicleClock:
    """``speed``: of the vehicle's time. Times of this computer are monotonic."""

    def __init__(self, speed: float = 1.0) -> None:
        self._speed = speed
        self._last: tuple[float, float] | None = None
        self._best = self._before = -math.inf
        self._since = 0.0

    def hear(self, at: tuple[float, float]) -> None:
        """Take the vehicle's time of a frame, and when it arrived; a repeated pair is ignored."""
        if at == self._last:
            return
        if self._last is not None and at[0] < self._last[0]:  # the vehicle has restarted
            self._best = self._before = -math.inf
        self._last = at
        if at[1] > self._since + KEPT_S:
            self._best, self._before, self._since = -math.inf, self._best, at[1]
        self._best = max(self._best, at[0] - at[1] * self._speed)

    def now(self, now: float) -> float:
        """Return the vehicle's time; 0 while no frame was received."""
        if self._last is None:
            return 0.0
        return now * self._speed + max(self._best, self._before)
