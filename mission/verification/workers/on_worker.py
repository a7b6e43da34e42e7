"""What a worker of a Dask cluster runs: one job, as long as that takes and somebody wants it.

A thread of Python cannot be ended. So the process of the worker ends itself where a job takes too
long, or the scheduler no longer wants its result: the command was interrupted or has died. Dask's
nanny starts another process in its place.
"""

from __future__ import annotations

import functools
import os
import pickle
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import distributed

from mission.verification.workers.code import code, difference
from mission.verification.workers.outcome import answer

HUNG, UNWANTED = 78, 79  # exit codes of a process that has ended itself
LOOK = 0.5  # s between two looks at the clock and at the scheduler's wishes


@dataclass(frozen=True, slots=True)
class Unfit:
    """The answer of a worker that cannot be used."""

    worker: str
    why: str


def unfit(threads: int, theirs: Mapping[str, str], ours: Mapping[str, str]) -> str:
    """Return why a worker with so many threads and their program cannot be used; "" if it can."""
    if differs := difference(theirs, ours):
        return f"runs another program ({differs})"
    return f"has {threads} threads: begin it with --nthreads 1" if threads != 1 else ""


def perform(ours: Mapping[str, str], work: bytes, job: Any, patience: float) -> bytes | Unfit:
    """Do a job; return what ``answer`` returns. ``ours``: the program of the caller; ``patience``:
    s that the job may take."""
    worker = distributed.get_worker()
    if why := unfit(worker.state.nthreads, code(), ours):
        return Unfit(worker.address, why)
    with _watched(worker, patience):
        return answer(_loaded(work), job)


@functools.lru_cache(maxsize=4)
def _loaded(work: bytes) -> Callable[[Any], Any]:
    found: Callable[[Any], Any] = pickle.loads(work)
    return found


@contextmanager
def _watched(worker: distributed.Worker, patience: float) -> Iterator[None]:
    key, until, over = worker.get_current_task(), time.monotonic() + patience, threading.Event()

    def watch() -> None:
        while not over.wait(min(LOOK, patience)):
            task = worker.state.tasks.get(key)
            if task is not None and task.state == "cancelled":
                os._exit(UNWANTED)
            if time.monotonic() >= until:
                os._exit(HUNG)

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        over.set()
