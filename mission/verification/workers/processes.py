"""Jobs in processes on this machine. A process that dies loses only its own job.

Each process has its own pipe and one job at a time. So the job of a process that is killed, hangs
or runs out of memory is known, and no other process shares a lock with it. The job is retried once
in another process. The processes end with their parent, however that ends.

A process reads the program from the disk when it begins, and a lost one is replaced. So each first
reports its program before it receives a job, and one that runs another program than the caller
ends the work.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

from mission.verification.workers.code import code, difference
from mission.verification.workers.outcome import RETRIES, Lost, Run, Unreachable, answer, read

OUT_OF_MEMORY = 77  # exit code of a process that runs out of memory
BEGINNING = 300.0  # s until a process must have started
LAST_WORD = 5.0  # s until a process whose pipe has ended must have an exit code
_SPAWN = multiprocessing.get_context("spawn")
_J = TypeVar("_J")
_R = TypeVar("_R")


@dataclass(frozen=True, slots=True)
class _Attempt(Generic[_J]):
    name: str
    job: _J
    ended: tuple[str, ...] = ()  # how the earlier attempts ended


@contextmanager
def in_processes(work: Callable[[_J], _R], count: int, patience: float) -> Iterator[Run[_J, _R]]:
    """Work in ``count`` processes. ``patience``: s that a job may take. Raises Unreachable if the
    program on the disk is another one now."""
    code()  # before a process begins: later the disk may have another program
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
        """Yield the outcome of the worker's job; nothing if it has none yet or is retried."""
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
        """Kill the workers whose jobs nobody waits for any more."""
        for worker in [w for w in self._all if w.busy]:
            self._all.remove(worker)
            worker.kill()

    def _given(self, again: deque[_Attempt[_J]], fresh: Iterator[_Attempt[_J]]) -> bool:
        """Give each free worker a job; return whether any worker is busy."""
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
        self._all.append(worker)  # before it starts, since Ctrl-C may come meanwhile
        worker.begin(self._work)
        return worker

    def _due(self) -> list[_Worker[_J]]:
        """Wait for workers that have answered, have ended, or take too long; return them."""
        busy = [worker for worker in self._all if worker.busy]
        rest = min(worker.until for worker in busy) - time.monotonic()
        ready = set(wait([w.connection for w in busy], timeout=max(rest, 0.0)))
        now = time.monotonic()
        return [w for w in busy if w.connection in ready or now >= w.until]


class _Worker(Generic[_J]):
    """One process. ``attempt``: its job while it is ``busy``; ``until``: its deadline, monotonic
    s."""

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
        with theirs, _interrupts_held():  # the process inherits the blocked signal
            process.start()

    def give(self, attempt: _Attempt[_J]) -> None:
        """Send the job; to a process that has not reported its program yet, once it has."""
        self.attempt, self.busy = attempt, True
        if self._begun:
            self._send()
        else:
            self.until = time.monotonic() + BEGINNING

    def _send(self) -> None:
        self.until = time.monotonic() + self._patience
        with suppress(OSError):  # it has died meanwhile, which its pipe will show
            self.connection.send(self.attempt.job)

    def take(self) -> tuple[Any, str]:
        """Return the result or Lost, and ""; or None, and how the process ended. None and "" of a
        worker that is still busy: the process has just started, and receives its job now."""
        if not self.connection.poll():
            self.kill()
            return None, "hung"
        try:
            received = self.connection.recv_bytes()
        except (EOFError, OSError):
            return None, self._last_word()
        if not self._begun:
            _refuse_other_program(pickle.loads(received))
            self._begun = True
            self._send()
            return None, ""
        self.busy = False
        return read(self.attempt.name, received), ""

    def kill(self) -> None:
        if self._process is not None and self._process.pid is not None:
            self._process.kill()
            self._process.join()
            self.connection.close()

    def _last_word(self) -> str:
        assert self._process is not None
        self._process.join(LAST_WORD)
        status = self._process.exitcode
        self.kill()
        if status is not None and status < 0:
            return f"killed by {_signal_name(-status)}"
        return "out of memory" if status == OUT_OF_MEMORY else f"ended with exit code {status}"


def _refuse_other_program(theirs: Mapping[str, str]) -> None:
    if differs := difference(theirs, code()):
        raise Unreachable(f"the program was changed on the disk meanwhile ({differs})")


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # most of the real-time signals have no name
        return f"signal {number}"


def _serve(connection: Connection, work: Callable[[Any], Any]) -> None:
    """Run in the process: report the program, then receive a job and send its outcome, until the
    pipe is closed."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):
        connection.send_bytes(pickle.dumps(dict(code())))
        while True:
            job = connection.recv()
            try:
                found = answer(work, job)
            except MemoryError:
                os._exit(OUT_OF_MEMORY)
            connection.send_bytes(found)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold back SIGINT in this thread and in processes that it starts meanwhile.

    The tracker of shared resources is started before, since multiprocessing unblocks SIGINT when it
    starts one. A library's thread (BLAS) may receive the signal all the same, and Python would
    raise it in the main thread: it is noted, and raised afterwards."""
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
