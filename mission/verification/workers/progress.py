"""Progress, reported every few seconds with the rate and the time left."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

EVERY = 2.0  # s between two lines of progress, at least
_R = TypeVar("_R")


def with_progress(
    found: Iterable[_R], total: int, word: str, tell: Callable[[str], None], kept: int = 0
) -> Iterator[_R]:
    """Pass results on and report progress. ``kept``: how many come from a file, without time."""
    begun = told = time.monotonic()
    for number, one in enumerate(found, 1):
        yield one
        now = time.monotonic()
        if now - told >= EVERY or number == total:
            told = now
            rate = max(number - kept, 1) / max(now - begun, 1e-3)
            left = (total - number) / rate
            tell(f"{number} of {total} {word}, {rate:.1f} a second, {left:.0f} s left")
