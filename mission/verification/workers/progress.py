"""Progress, reported every few seconds with the rate and the time left."""

from __future__ import annotations

import time
from collections.abc import Callable

EVERY = 2.0  # s between two lines of progress, at least
_UNITS = (("a second", 1.0), ("a minute", 60.0), ("an hour", 3600.0))


class Progress:
    """Counts jobs that have ended, whichever they are: one that takes long holds back the results
    of those after it, and not their number. ``tell``: called with each line."""

    def __init__(self, total: int, word: str, tell: Callable[[str], None]) -> None:
        self._total, self._word, self._tell = total, word, tell
        self._ended = self._done = 0
        self._begun = self._told = time.monotonic()

    def count(self, *, kept: bool = False) -> None:
        """Count one more job. ``kept``: its result is from a file, and took no time."""
        self._ended += 1
        self._done += not kept
        now = time.monotonic()
        if now - self._told >= EVERY or self._ended == self._total:
            self._told = now
            left = self._total - self._ended
            ended = f"{self._ended} of {self._total} {self._word}"
            self._tell(f"{ended}, {pace(max(self._done, 1), left, now - self._begun)}")


def pace(done: float, left: float, seconds: float) -> str:
    """Return in words how much is done in which time, and when the rest is done at this rate."""
    rate = done / max(seconds, 1e-3)
    unit, lasts = next((row for row in _UNITS if rate * row[1] >= 1.0), _UNITS[-1])
    return f"{rate * lasts:.1f} {unit}, {left / rate:.0f} s left"
