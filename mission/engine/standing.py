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
    it says; ``is_coarse``: it has stood for long before, and went on."""

    stale_after: float
    since: float = math.inf
    is_coarse: bool = False

    def after(self, now: float, last: float, differs: bool) -> Self:
        """A depth comes. ``last`` s: the one before was said, -inf: there was none; ``differs``
        from it."""
        if not differs:
            return self
        return self._replace(since=now, is_coarse=self.is_coarse or self._is_long(last))

    def tells(self, now: float) -> bool:
        """It may have frozen."""
        return not self.is_coarse and self._is_long(now)

    def _is_long(self, now: float) -> bool:
        return now - self.since > max(LONG, self.stale_after)
