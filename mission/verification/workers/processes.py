"""Jobs in processes of this machine. A process that dies takes no job but its own with it.

Each process has a pipe of its own and one job at a time, so whoever is killed, hangs or runs out of
memory is known with its job, and nobody else shares a lock with it. The job is tried once more in
another process. Processes end with the one that wanted them, whatever ends that.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

from mission.verification.workers.outcome import RETRIES, Lost, Raised, Run, tried

OUT_OF_MEMORY = 77  # exit code of a process that says so itself
BEGINNING = 300.0  # s until a process has begun
LAST_WORD = 5.0  # s until a process whose pipe has ended has an exit code
_SPAWN = multiprocessing.get_context("spawn")
_J = TypeVar("_J")
_R = TypeVar("_R")


@dataclass(frozen=True, slots=True)
class _Begun:
    """The first word of a process, when it has imported what it needs."""


@dataclass(frozen=True, slots=True)
class _Attempt(Generic[_J]):
    name: str
    job: _J
    ended: tuple[str, ...] = ()  # how the earlier ones did


@contextmanager
def in_processes(work: Callable[[_J], _R], count: int, patience: float) -> Iterator[Run[_J, _R]]:
    """``patience``: s that a job may take."""
    crew = _Crew(work, count, patience)
    try:
        yield crew.run
    finally:
        crew.end()


class _Crew(Generic[_J, _R]):
    def __init__(self, work: Callable[[_J], _R], count: int, patience: float) -> None:
        self._work, self._count, self._patience = work, count, patience
        self._all: list[_Worker[_J]] = []

    def run(self, jobs: Iterable[tuple[str, _J]]) -> Iterator[tuple[str, _R | Lost]]:
        again: deque[_Attempt[_J]] = deque()
        fresh = (_Attempt(name, job) for name, job in jobs)
        try:
            while self._given(again, fresh):
                for worker in self._due():
                    yield from self._settled(worker, again)
        finally:
            self._let_go()

    def _settled(
        self, worker: _Worker[_J], again: deque[_Attempt[_J]]
    ) -> Iterator[tuple[str, _R | Lost]]:
        """What is to be told of its job; nothing if that is tried again."""
        name, job = worker.attempt.name, worker.attempt.job
        found, ended = worker.take()
        if not ended:
            if not worker.busy:
                yield name, found
            return
        self._all.remove(worker)
        ends = (*worker.attempt.ended, ended)
        if len(ends) <= RETRIES:
            again.append(_Attempt(name, job, ends))
        else:
            yield name, Lost(name, ", then ".join(ends))

    def end(self) -> None:
        for worker in self._all:
            worker.kill()
        self._all.clear()

    def _let_go(self) -> None:
        """Of those at a job that nobody waits for any more."""
        for worker in [w for w in self._all if w.busy]:
            self._all.remove(worker)
            worker.kill()

    def _given(self, again: deque[_Attempt[_J]], fresh: Iterator[_Attempt[_J]]) -> bool:
        """Whether anybody is at work now; whoever was free has been given a job."""
        idle = [worker for worker in self._all if not worker.busy]
        while idle or len(self._all) < self._count:
            attempt = again.popleft() if again else next(fresh, None)
            if attempt is None:
                break
            worker = idle.pop() if idle else self._another()
            worker.give(attempt)
        return any(worker.busy for worker in self._all)

    def _another(self) -> _Worker[_J]:
        worker = _Worker[_J](self._patience)
        self._all.append(worker)  # first: Ctrl-C may come while it begins
        worker.begin(self._work)
        return worker

    def _due(self) -> list[_Worker[_J]]:
        """Those that have answered, have ended, or have taken too long."""
        busy = [worker for worker in self._all if worker.busy]
        rest = min(worker.until for worker in busy) - time.monotonic()
        ready = set(wait([w.connection for w in busy], timeout=max(rest, 0.0)))
        now = time.monotonic()
        return [w for w in busy if w.connection in ready or now >= w.until]


class _Worker(Generic[_J]):
    """One process. ``attempt`` is what it is at, while ``busy``; ``until``: monotonic s."""

    attempt: _Attempt[_J]
    connection: Connection

    def __init__(self, patience: float) -> None:
        self._process: multiprocessing.process.BaseProcess | None = None
        self._patience = patience
        self._begun = self.busy = False
        self.until = 0.0

    def begin(self, work: Callable[[_J], Any]) -> None:
        self.connection, theirs = _SPAWN.Pipe()
        process = _SPAWN.Process(target=_serve, args=(theirs, work), daemon=True)
        self._process = process
        with theirs, _interrupts_held():  # which the process takes over as it begins
            process.start()

    def give(self, attempt: _Attempt[_J]) -> None:
        self.attempt, self.busy = attempt, True
        self.until = time.monotonic() + (self._patience if self._begun else BEGINNING)
        with suppress(OSError):  # it has died meanwhile: its pipe will say so
            self.connection.send(attempt.job)

    def take(self) -> tuple[Any, str]:
        """The result or Lost, and ""; or how the process ended, which it has then. Still busy: it
        has begun, and its job only now."""
        if not self.connection.poll():
            self.kill()
            return None, "hung"
        try:
            found = self.connection.recv()
        except (EOFError, OSError):
            return None, self._last_word()
        if isinstance(found, _Begun):
            self._begun, self.until = True, time.monotonic() + self._patience
            return None, ""
        self.busy = False
        return found.lost(self.attempt.name) if isinstance(found, Raised) else found, ""

    def kill(self) -> None:
        if self._process is not None and self._process.pid is not None:
            self._process.kill()
            self._process.join()
            self.connection.close()

    def _last_word(self) -> str:
        assert self._process is not None
        self._process.join(LAST_WORD)
        code = self._process.exitcode
        self.kill()
        if code is not None and code < 0:
            return f"killed by {signal.Signals(-code).name}"
        return "out of memory" if code == OUT_OF_MEMORY else f"ended with exit code {code}"


def _serve(connection: Connection, work: Callable[[Any], Any]) -> None:
    """The process: a job in, its outcome out, until nobody wants one."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):
        connection.send(_Begun())
        while True:
            job = connection.recv()
            try:
                found = tried(work, job)
            except MemoryError:
                os._exit(OUT_OF_MEMORY)
            _send(connection, found)


def _send(connection: Connection, found: Any) -> None:
    try:
        connection.send(found)
    except (TypeError, AttributeError, pickle.PicklingError) as error:
        connection.send(Raised(ValueError(f"the result cannot be sent: {error}")))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """In this thread, and in what it begins meanwhile. The tracker of shared resources begins
    before: multiprocessing lets interrupts through again when it has begun one. A library's thread
    (BLAS) may take one all the same, which Python raises in the main thread: it is kept."""
    resource_tracker.ensure_running()
    held: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    handler = signal.signal(signal.SIGINT, lambda *_: held.append(1)) if is_main else None
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if is_main:
            signal.signal(signal.SIGINT, signal.SIG_DFL if handler is None else handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if held:
            signal.raise_signal(signal.SIGINT)
