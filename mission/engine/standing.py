"""How long a depth has repeated to the last bit, and whether that tells anything (R7, at rest).

A frozen sensor repeats its value forever. A coarse one, or one that reports 0 in the air, repeats a
value now and then, and changes again: from then on its repeats tell nothing.

What does not live here: what is frozen under thrust (navigation: health), what follows (core).
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

LONG = 8.0  # s: four reports of the AUV with the same depth


class Standing(NamedTuple):
    """``stale_after``: s, counts as long if a vehicle reports seldom. ``since``: s, since when the
    depth repeats. ``stood``: the last two depths at which it repeated for long and then changed.
    Two of them, or the present one among them, show a coarse sensor; a single other one may be of a
    frozen sensor that recovered."""

    stale_after: float
    since: float = math.inf
    depth: float | None = None
    stood: tuple[float, ...] = ()

    def after(self, now: float, last: float, differs: bool, depth: float) -> Self:
        """The state after one more depth. ``last``: s, when the one before was reported (-inf:
        none was); ``differs``: from the one before."""
        if not differs:
            return self
        stood = self.stood
        if self.depth is not None and self._is_long(last):
            stood = (*stood[-1:], self.depth)
        return self._replace(since=now, depth=depth, stood=stood)

    def tells(self, now: float) -> bool:
        """Whether the depth may have frozen."""
        is_coarse = len(self.stood) > 1 or self.depth in self.stood
        return not is_coarse and self._is_long(now)

    def _is_long(self, now: float) -> bool:
        return now - self.since > max(LONG, self.stale_after)
