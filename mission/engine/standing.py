"""Since when a depth says the same to the last bit, and whether that tells anything (R7, at rest).

A sensor that has frozen says the same for ever. One that is coarse, or says 0 in the air, does so
now and then, and goes on: from then on its standing tells nothing.

What does not live here: what is frozen under thrust (navigation: health), what follows (core).
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

LONG = 8.0  # s: four reports of the AUV with the same depth


class Standing(NamedTuple):
    """``stale_after`` s: of vehicles that report seldom it takes so long; ``since`` s: it says what
    it says; ``stood``: at which depths it has for long, and went on: at one, and again there, or at
    several, and it is coarse; at one other than now, and it came to life then."""

    stale_after: float
    since: float = math.inf
    depth: float | None = None
    stood: tuple[float, ...] = ()

    def after(self, now: float, last: float, differs: bool, depth: float) -> Self:
        """A depth comes. ``last`` s: the one before was said, -inf: there was none; ``differs``
        from it."""
        if not differs:
            return self
        stood = self.stood
        if self.depth is not None and self._is_long(last):
            stood = (*stood[-1:], self.depth)
        return self._replace(since=now, depth=depth, stood=stood)

    def tells(self, now: float) -> bool:
        """It may have frozen."""
        is_coarse = len(self.stood) > 1 or self.depth in self.stood
        return not is_coarse and self._is_long(now)

    def _is_long(self, now: float) -> bool:
        return now - self.since > max(LONG, self.stale_after)
