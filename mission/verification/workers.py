"""Much work in several processes, in order, with progress told.

What comes out depends on the jobs alone, never on how many work on them. ``workers`` 1: in this
process. Whatever ends the work early (Ctrl-C, an error, nobody who takes the results) ends the
processes at once; a terminal's Ctrl-C does not reach them.

What does not live here: what a job is.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

EVERY = 2.0  # s between two lines of progress
AHEAD = 4  # jobs a worker is given at once, at most
_J = TypeVar("_J")
_R = TypeVar("_R")


def results(
    work: Callable[[_J], _R], jobs: Sequence[_J], workers: int | None = None, ahead: int = AHEAD
) -> Iterator[_R]:
    """In the order of the jobs. ``work`` and jobs must be picklable; None: a worker a core."""
    count = min(workers or os.cpu_count() or 1, max(len(jobs), 1))
    if count == 1:
        yield from map(work, jobs)
        return
    chunk = max(1, min(ahead, len(jobs) // count))
    with working(work, count) as batch:
        yield from batch(jobs, chunk)


@contextmanager
def working(
    work: Callable[[_J], _R], workers: int | None = None
) -> Iterator[Callable[[Sequence[_J], int], Iterator[_R]]]:
    """For jobs that come batch by batch, each with how many a worker is given at once."""
    count = workers or os.cpu_count() or 1
    if count == 1:
        yield lambda jobs, chunk: map(work, jobs)
        return
    with _pool(count) as pool:

        def batch(jobs: Sequence[_J], chunk: int) -> Iterator[_R]:
            with _interrupts_held():  # as the processes begin they take this over
                return pool.map(work, jobs, chunksize=chunk)

        yield batch


@contextmanager
def _pool(count: int) -> Iterator[ProcessPoolExecutor]:
    pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield pool
    except BaseException:
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


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
