"""How a depth goes up and down of which the zero alone is contradicted (R7). Waves average out.

What does not live here: whether the change of such a depth is believed (navigation: belief), what
follows (vehicle_state, core).
"""

from __future__ import annotations

import itertools
from typing import NamedTuple, Self

from mission.navigation.belief import EVERY, GAP

_TRAVELS = 1.0  # m between two means: not at rest
_HALF, _QUARTER = 15.0, 7.5  # s of the means


class Travel(NamedTuple):
    """``samples``: s, m, of the last two halves; the oldest first."""

    samples: tuple[tuple[float, float], ...] = ()

    def after(self, now: float, depth: float | None) -> Self:
        """The state after one more report. None (there is no such depth) starts it again."""
        samples = self.samples
        if depth is None:
            return self._replace(samples=()) if samples else self
        if samples and now - samples[-1][0] < EVERY:
            return self
        kept = (sample for sample in samples if sample[0] >= now - 2.0 * _HALF)
        return self._replace(samples=(*kept, (now, depth)))

    def stands(self, now: float) -> bool:
        """Whether the depth goes neither up nor down: over the halves, for what is slow, and over
        the quarters, for what turns round between them. True if reports have no such depth."""
        samples = self.samples
        if not samples or now - samples[-1][0] > _HALF:
            return True
        if samples[0][0] > now - 2.0 * _HALF + GAP:
            return False
        return not any(
            abs(newer - older) >= _TRAVELS
            for part in (_HALF, _QUARTER)
            for newer, older in self._neighbours(now, part)
        )

    def descends(self, now: float) -> bool:
        """Whether the depth has just gone down as no depth does at the surface."""
        if not self.samples or now - self.samples[-1][0] >= _QUARTER:
            return False
        latest = self._neighbours(now, _QUARTER)[:1]
        return any(newer - older >= _TRAVELS for newer, older in latest)

    def _neighbours(self, now: float, part: float) -> list[tuple[float, float]]:
        """Means over parts of so many s, each with the one before; the newest first."""
        depths: list[list[float]] = [[] for _ in range(int(2.0 * _HALF / part))]
        for t, depth in self.samples:
            at = int((now - t) / part)
            if at < len(depths):
                depths[at].append(depth)
        means = [sum(some) / len(some) for some in depths if some]
        return list(itertools.pairwise(means))
