"""Where jobs are done: in this process, in processes on this machine, or on a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TypeVar

from mission.verification.workers.outcome import Lost, Raised, Run, tried

LOCAL, PROCESSES, DASK = "local", "processes", "dask"
PATIENCE = 600.0  # s that a job may take
_J = TypeVar("_J")
_R = TypeVar("_R")


@dataclass(frozen=True, slots=True)
class Place:
    """``address``: HOST:PORT of a scheduler; ``workers``: number of processes on this machine."""

    kind: str = LOCAL
    address: str = ""
    workers: int = 1
    patience: float = PATIENCE

    @contextmanager
    def doing(self, work: Callable[[_J], _R]) -> Iterator[Run[_J, _R]]:
        """Yield a function that does jobs here. ``work`` and jobs must be picklable. Raises
        Unreachable if there is no usable cluster."""
        if self.kind == LOCAL:
            yield lambda jobs: ((name, _here(work, name, job)) for name, job in jobs)
        elif self.kind == PROCESSES:
            from mission.verification.workers.processes import in_processes

            with in_processes(work, self.workers, self.patience) as run:
                yield run
        else:
            from mission.verification.workers.cluster import on_cluster

            with on_cluster(work, self.address, self.patience) as run:
                yield run


def _here(work: Callable[[_J], _R], name: str, job: _J) -> _R | Lost:
    try:
        found = tried(work, job)
    except MemoryError:
        return Lost(name, "out of memory")
    return found.lost(name) if isinstance(found, Raised) else found


def place(on: str | None = None, workers: int | None = None, patience: float = PATIENCE) -> Place:
    """Return the place that ``on`` names: ``local``, ``processes`` or ``dask://HOST:PORT``; None:
    processes, one for each core unless ``workers`` says otherwise; with one worker ``local``.
    Raises ValueError with a message for the user."""
    count = workers or os.cpu_count() or 1
    kind, _, address = (on or (LOCAL if count == 1 else PROCESSES)).partition("://")
    if kind == DASK:
        return Place(kind, _checked(address), count, patience)
    if kind not in (LOCAL, PROCESSES) or address:
        raise ValueError(f"{on!r} is no place: local, processes or dask://HOST:PORT")
    return Place(kind, "", count, patience)


def _checked(address: str) -> str:
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal():
        raise ValueError(f"dask://{address}: a scheduler is named dask://HOST:PORT")
    if find_spec("distributed") is None:
        raise ValueError(
            "dask:// needs the package distributed: pip install 'auvmission[campaign]'"
        )
    return address
