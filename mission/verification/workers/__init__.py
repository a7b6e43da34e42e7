"""Many jobs in several places at once: ordered results, progress, and no result lost with a worker.

Results depend only on the jobs, never on where they are done or by how many workers. A job whose
worker is lost is retried, and then reported by its name (Lost). A job that raises is reported at
once. Whatever ends the work early (Ctrl-C, an error, a caller that takes no more results) ends the
processes at once; a terminal's Ctrl-C does not reach them.

What does not live here: what a job is.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

from mission.verification.workers.kept import Kept
from mission.verification.workers.outcome import Lost, Run
from mission.verification.workers.places import Place
from mission.verification.workers.progress import Progress

_J = TypeVar("_J")
_R = TypeVar("_R")
Batch = Callable[[Iterable[_J]], Iterator[_R | Lost]]


def results(
    work: Callable[[_J], _R],
    jobs: Iterable[_J],
    at: Place,
    name: Callable[[_J], str] = str,
    kept: Kept[_R] | None = None,
    progress: Progress | None = None,
) -> Iterator[_R | Lost]:
    """Yield the outcomes in the order of the jobs. ``work`` and jobs must be picklable, the names
    unique. A job whose result is kept is not done again. ``progress`` counts each job that ends, in
    whatever order. Raises Unreachable and Unusable."""
    with working(work, at, name, kept, progress) as batch:
        yield from batch(jobs)


@contextmanager
def working(
    work: Callable[[_J], _R],
    at: Place,
    name: Callable[[_J], str] = str,
    kept: Kept[_R] | None = None,
    progress: Progress | None = None,
) -> Iterator[Batch[_J, _R]]:
    """The same for jobs that come in batches, one batch at a time."""
    with at.doing(work) as run:
        yield lambda jobs: _Ordered(run, name, kept, progress).outcomes(jobs)


class _Ordered(Generic[_J, _R]):
    """Collect outcomes as they come, and yield them in the order of their jobs."""

    def __init__(
        self,
        run: Run[_J, _R],
        name: Callable[[_J], str],
        kept: Kept[_R] | None,
        progress: Progress | None,
    ) -> None:
        self._run, self._name, self._kept, self._progress = run, name, kept, progress
        self._due: deque[str] = deque()
        self._open: set[str] = set()
        self._here: dict[str, _R | Lost] = {}

    def outcomes(self, jobs: Iterable[_J]) -> Iterator[_R | Lost]:
        for name, outcome in self._run(self._undone(jobs)):
            if self._kept is not None and not isinstance(outcome, Lost):
                self._kept.add(name, outcome)
            self._take(name, outcome)
            yield from self._ready()
        yield from self._ready()

    def _undone(self, jobs: Iterable[_J]) -> Iterator[tuple[str, _J]]:
        for job in jobs:
            name = self._name(job)
            if name in self._open:
                raise ValueError(f"two jobs named {name}")
            self._due.append(name)
            self._open.add(name)
            known = self._kept.get(name) if self._kept is not None else None
            if known is None:
                yield name, job
            else:
                self._take(name, known, kept=True)

    def _take(self, name: str, outcome: _R | Lost, *, kept: bool = False) -> None:
        self._here[name] = outcome
        if self._progress is not None:
            self._progress.count(kept=kept)

    def _ready(self) -> Iterator[_R | Lost]:
        while self._due and self._due[0] in self._here:
            name = self._due.popleft()
            self._open.remove(name)
            yield self._here.pop(name)
