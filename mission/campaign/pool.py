"""Many flights in several processes, in order, with progress told.

What comes out depends on the jobs alone, never on how many work on them. ``workers`` 1: in this
process.

What does not live here: what a job is.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

EVERY = 2.0  # s between two lines of progress
AHEAD = 4  # jobs a worker is given at once, at most
_J = TypeVar("_J")
_R = TypeVar("_R")


def results(
    work: Callable[[_J], _R], jobs: Sequence[_J], workers: int | None = None
) -> Iterator[_R]:
    """In the order of the jobs. ``work`` and jobs must be picklable; None: a worker a core."""
    count = min(workers or os.cpu_count() or 1, max(len(jobs), 1))
    if count == 1:
        yield from map(work, jobs)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(count, mp_context=context) as pool:
        chunk = max(1, min(AHEAD, len(jobs) // count))
        yield from pool.map(work, jobs, chunksize=chunk)


def with_progress(
    found: Iterable[_R], total: int, word: str, tell: Callable[[str], None]
) -> Iterator[_R]:
    begun = told = time.monotonic()
    for number, one in enumerate(found, 1):
        yield one
        now = time.monotonic()
        if now - told >= EVERY or number == total:
            told = now
            left = (now - begun) / number * (total - number)
            tell(f"{number} of {total} {word}, {left:.0f} s left")
