"""Jobs on a Dask cluster: a scheduler, and workers on any number of machines.

Before the first job every worker reports which program it runs (joining). Every job checks that
again (on_worker), since workers come and go: one that joins later and cannot be used receives no
more jobs.

If a worker dies, the scheduler gives its job to others, and to three of them at most (its setting
``allowed-failures``). It blames the jobs that waited at that worker as much. So a job that it gives
up is done once more with no other job of ours on the cluster, and reported as lost if its workers
die then, too.

Results depend only on the jobs. A worker must have one thread, since a flight takes a whole core
and Python gives a process only one.
"""

from __future__ import annotations

import asyncio
import itertools
import math
import pickle
import queue
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import distributed

from mission.verification.workers.code import code
from mission.verification.workers.joining import gone, joined, leave_out, reached, url_of
from mission.verification.workers.on_worker import Unfit, perform
from mission.verification.workers.outcome import RETRIES, Lost, Run, Unreachable, read

AHEAD = 3  # jobs per worker on the scheduler: no worker waits, and few jobs are done in vain
ALONE = 120.0  # s without any worker of this program until that is an error
COUNT = 5.0  # s between two counts of the workers
_J = TypeVar("_J")
_R = TypeVar("_R")


@dataclass(frozen=True, slots=True)
class _Try(Generic[_J]):
    """``again``: number of earlier tries; ``alone``: with no other job of ours on the cluster."""

    name: str
    job: _J
    again: int = 0
    alone: bool = False


@contextmanager
def on_cluster(work: Callable[[_J], _R], address: str, patience: float) -> Iterator[Run[_J, _R]]:
    """Work on a cluster. ``address``: HOST:PORT of the scheduler; ``patience``: s that a job may
    take. Raises Unreachable."""
    with joined(address) as client:
        cluster = _Cluster(client, url_of(address), patience)
        yield lambda jobs: _Batch[_J, _R](cluster, pickle.dumps(work)).run(jobs)


class _Cluster:
    """The connection, and its workers. ``room``: how many of our jobs the scheduler should have."""

    def __init__(self, client: distributed.Client, url: str, patience: float) -> None:
        self.client, self._url, self._patience = client, url, patience
        self.room = 0
        self._others: set[str] = set()  # workers that are left out
        self._counted = -math.inf
        self._seen = time.monotonic()
        self._serial = itertools.count()

    def submit(self, name: str, work: bytes, job: Any) -> distributed.Future:
        key = f"{name} #{next(self._serial)} of {self.client.id}"
        return self.client.submit(
            perform, dict(code()), work, job, self._patience, key=key, pure=False
        )

    def leave_out(self, worker: str, why: str) -> None:
        if worker not in self._others:
            self._others.add(worker)
            with reached(self._url):
                leave_out(self.client, worker, why)

    def check(self) -> None:
        if self.client.status != "running":
            raise gone(self._url)

    def count(self) -> None:
        """Count the workers every COUNT s. Raises Unreachable after ALONE s without any."""
        self.check()
        now = time.monotonic()
        if now - self._counted < COUNT:
            return
        with reached(self._url):
            workers = len(self.client.nthreads().keys() - self._others)
        self._counted = now
        self._seen = now if workers else self._seen
        if now - self._seen > ALONE:
            raise Unreachable(f"{self._url} has had no worker of this program for {ALONE:.0f} s")
        self.room = AHEAD * max(workers, 1)


class _Batch(Generic[_J, _R]):
    def __init__(self, cluster: _Cluster, work: bytes) -> None:
        self._cluster, self._work = cluster, work
        self._at: dict[distributed.Future, _Try[_J]] = {}
        self._suspects: deque[_Try[_J]] = deque()  # given up by the scheduler: to be done alone
        self._ended: queue.SimpleQueue[tuple[distributed.Future, Any]] = queue.SimpleQueue()

    def run(self, jobs: Iterable[tuple[str, _J]]) -> Iterator[tuple[str, _R | Lost]]:
        fresh = iter(jobs)
        try:
            while self._filled(fresh):
                for future, found in self._next():
                    yield from self._ended_with(future, found)
        finally:
            for future in self._at:  # nobody waits for them any more: their processes end
                future.release()

    def _ended_with(
        self, future: distributed.Future, found: Any
    ) -> Iterator[tuple[str, _R | Lost]]:
        """Yield the outcome of a job that ended; nothing if it is retried. ``found``: what it
        returned, or what Dask raised."""
        it = self._at.pop(future)
        given_up = isinstance(found, distributed.KilledWorker)
        if isinstance(found, Unfit):
            self._cluster.leave_out(found.worker, found.why)
            self._submit(it)
        elif isinstance(found, bytes):
            yield it.name, read(it.name, found)
        elif given_up and not it.alone:
            self._suspects.append(replace(it, alone=True))
        elif given_up or it.again >= RETRIES:
            yield it.name, Lost(it.name, _why(future, found))
        else:
            self._submit(replace(it, again=it.again + 1))

    def _submit(self, it: _Try[_J]) -> None:
        future = self._cluster.submit(it.name, self._work, it.job)
        self._at[future] = it
        self._cluster.client.loop.add_callback(self._follow, future)

    async def _follow(self, future: distributed.Future) -> None:
        """Whatever ends a job is queued, so that none is waited for in vain."""
        try:
            found = await future
        except (Exception, asyncio.CancelledError) as error:
            found = error
        self._ended.put((future, found))

    def _filled(self, fresh: Iterator[tuple[str, _J]]) -> bool:
        self._cluster.count()
        if self._suspects and not self._at:
            self._submit(self._suspects.popleft())
        elif not self._suspects and not any(it.alone for it in self._at.values()):
            for name, job in itertools.islice(fresh, max(self._cluster.room - len(self._at), 0)):
                self._submit(_Try(name, job))
        return bool(self._at)

    def _next(self) -> list[tuple[distributed.Future, Any]]:
        """Wait for jobs that ended, and return them; an empty list after COUNT s without any."""
        found = []
        with suppress(queue.Empty):
            found.append(self._ended.get(timeout=COUNT))
            while True:
                found.append(self._ended.get_nowait())
        self._cluster.check()  # a scheduler that is gone ends all jobs
        return found


def _why(future: distributed.Future, found: Any) -> str:
    if future.cancelled():
        return "cancelled by the scheduler"
    if isinstance(found, distributed.KilledWorker):
        died = found.allowed_failures + 1
        return f"{died} worker{'s' if died > 1 else ''} died of it"
    return f"{type(found).__name__}: {found}"
