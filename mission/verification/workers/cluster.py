"""Jobs on a Dask cluster: a scheduler, and workers on any number of machines.

Before the first job every worker reports which program it runs. Every job checks that again, since
workers come and go: a worker that joins later with another program receives no more jobs. If a
worker dies, the scheduler gives its job to others, and to three of them at most (its setting
``allowed-failures``). It blames the jobs that waited at that worker as much. So a job that it gives
up is done once more with no other job of ours on the cluster, and reported as lost if its workers
die then, too. The process of a job that hangs ends itself after ``patience``.

Results depend only on the jobs. A worker must have one thread, since a flight takes a whole core
and Python gives a process only one.
"""

from __future__ import annotations

import functools
import itertools
import os
import pickle
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from ipaddress import ip_address
from typing import Any, Generic, TypeVar

import distributed

from mission.verification.workers.code import code, difference
from mission.verification.workers.outcome import (
    RETRIES,
    Lost,
    Raised,
    Run,
    Unreachable,
    tried,
)

AHEAD = 3  # jobs per worker on the scheduler: no worker waits, and few jobs are done in vain
CONNECTING = 10.0  # s until a scheduler must have answered
JOINING = 30.0  # s until there must be a worker
ALONE = 120.0  # s without any worker of this program until that is an error
LOOK = 0.02  # s between two checks for ended jobs
COUNT = 5.0  # s between two counts of the workers
HUNG = 78  # exit code of a worker's process that has ended itself
_J = TypeVar("_J")
_R = TypeVar("_R")


@dataclass(frozen=True, slots=True)
class OtherCode:
    """The answer of a worker that runs another program."""

    worker: str
    differs: str


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
    client = _connected(address)
    try:
        _compare(client)
        yield _Cluster[_J, _R](client, work, patience).run
    finally:
        client.close(timeout=1)


def url_of(address: str) -> str:
    """Return the URL of a scheduler, with TLS unless it is on this machine: whoever reaches a
    scheduler can run any code there."""
    host = address.rpartition(":")[0].strip("[]")
    return f"{'tcp' if _loopback(host) else 'tls'}://{address}"


def _loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _connected(address: str) -> distributed.Client:
    url = url_of(address)
    security = distributed.Security(require_encryption=url.startswith("tls"))
    if security.require_encryption and not security.get_connection_args("client")["ssl_context"]:
        raise Unreachable(f"{url} is beyond this machine, and needs keys: docs/how-to/campaign.md")
    try:
        return distributed.Client(
            url, security=security, timeout=CONNECTING, set_as_default=False, name="auvmission"
        )
    except (OSError, ValueError, RuntimeError) as error:
        raise Unreachable(f"no scheduler at {url}: {error or type(error).__name__}") from None


def _compare(client: distributed.Client) -> None:
    try:
        client.wait_for_workers(1, timeout=JOINING)
    except TimeoutError:
        raise Unreachable(f"the scheduler at {client.scheduler.address} has no worker") from None
    threads = client.nthreads()
    told = client.run(code, on_error="return")
    found = [_unfit(name, threads.get(name, 1), theirs) for name, theirs in told.items()]
    if any(found):
        raise Unreachable("workers that cannot be used: " + "; ".join(filter(None, found)))


def _unfit(worker: str, threads: int, theirs: Mapping[str, str] | BaseException) -> str:
    if isinstance(theirs, BaseException):
        return f"{worker} has no auvmission ({type(theirs).__name__}: {theirs})"
    if differs := difference(theirs, code()):
        return f"{worker} runs another program ({differs})"
    return f"{worker} has {threads} threads: begin it with --nthreads 1" if threads != 1 else ""


class _Cluster(Generic[_J, _R]):
    def __init__(
        self, client: distributed.Client, work: Callable[[_J], _R], patience: float
    ) -> None:
        self._client, self._patience = client, patience
        self._work = pickle.dumps(work)
        self._ended = distributed.as_completed(
            loop=client.loop, with_results=True, raise_errors=False
        )
        self._at: dict[distributed.Future, _Try[_J]] = {}
        self._suspects: deque[_Try[_J]] = deque()  # given up by the scheduler: to be done alone
        self._others: set[str] = set()  # workers that run another program
        self._room = self._counted = 0.0
        self._seen = time.monotonic()
        self._serial = itertools.count()

    def run(self, jobs: Iterable[tuple[str, _J]]) -> Iterator[tuple[str, _R | Lost]]:
        fresh = iter(jobs)
        try:
            while self._filled(fresh):
                for future, found in self._next():
                    yield from self._ended_with(future, found)
        finally:
            self._client.cancel(list(self._at), asynchronous=False)
            self._at.clear()

    def _ended_with(
        self, future: distributed.Future, found: Any
    ) -> Iterator[tuple[str, _R | Lost]]:
        """Yield the outcome of a job that ended; nothing if it is retried."""
        it = self._at.pop(future)
        if isinstance(found, OtherCode):
            self._others.add(found.worker)
            self._client.retire_workers([found.worker], close_workers=False)
            self._submit(it)
        elif future.status == "finished":
            yield it.name, found.lost(it.name) if isinstance(found, Raised) else found
        elif _tried_by_scheduler(future, found) and not it.alone:
            self._suspects.append(replace(it, alone=True))
        elif it.again >= RETRIES or _tried_by_scheduler(future, found):
            yield it.name, Lost(it.name, _why(future, found))
        else:
            self._submit(replace(it, again=it.again + 1))

    def _submit(self, it: _Try[_J]) -> None:
        key = f"{it.name} #{next(self._serial)} of {self._client.id}"
        future = self._client.submit(
            perform, dict(code()), self._work, it.job, self._patience, key=key, pure=False
        )
        self._at[future] = it
        self._ended.add(future)

    def _filled(self, fresh: Iterator[tuple[str, _J]]) -> bool:
        self._count()
        if self._suspects and not self._at:
            self._submit(self._suspects.popleft())
        elif not self._suspects and not any(it.alone for it in self._at.values()):
            for name, job in itertools.islice(fresh, max(int(self._room) - len(self._at), 0)):
                self._submit(_Try(name, job))
        return bool(self._at)

    def _count(self) -> None:
        now = time.monotonic()
        if self._room and now - self._counted < COUNT:
            return
        workers = len(self._client.nthreads().keys() - self._others)
        self._counted = now
        self._seen = now if workers else self._seen
        self._room = float(AHEAD * max(workers, 1))

    def _next(self) -> list[tuple[distributed.Future, Any]]:
        """Wait for jobs that ended, and return them; an empty list after COUNT s without any."""
        until = time.monotonic() + COUNT
        while not self._ended.has_ready() and time.monotonic() < until:
            time.sleep(LOOK)
        if self._client.status != "running":
            raise Unreachable("the scheduler is gone")
        if time.monotonic() - self._seen > ALONE + COUNT:
            raise Unreachable(f"no worker of this program for {ALONE:.0f} s")
        return list(self._ended.next_batch(block=False))


def _tried_by_scheduler(future: distributed.Future, found: Any) -> bool:
    return future.status == "error" and isinstance(found[1], distributed.KilledWorker)


def _why(future: distributed.Future, found: Any) -> str:
    if future.status != "error":
        return "cancelled by the scheduler"
    error = found[1]
    if isinstance(error, distributed.KilledWorker):
        died = error.allowed_failures + 1
        return f"{died} worker{'s' if died > 1 else ''} died of it"
    return f"{type(error).__name__}: {error}"


# --- on the worker ---


def perform(theirs: Mapping[str, str], work: bytes, job: Any, patience: float) -> Any:
    """Do a job on the worker. Return its result, Raised or OtherCode."""
    if differs := difference(code(), theirs):
        return OtherCode(distributed.get_worker().address, differs)
    clock = threading.Timer(patience, os._exit, [HUNG])
    clock.daemon = True
    clock.start()
    try:
        return tried(_loaded(work), job)
    finally:
        clock.cancel()


@functools.lru_cache(maxsize=4)
def _loaded(work: bytes) -> Callable[[Any], Any]:
    found: Callable[[Any], Any] = pickle.loads(work)
    return found
