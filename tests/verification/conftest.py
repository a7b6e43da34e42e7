"""A cluster of this machine, for the tests that need one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from clusters import scheduling, worker

from mission.verification.workers.places import Place, place


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with scheduling(tmp_path_factory.mktemp("scheduler")) as program:
        yield program.word


@pytest.fixture(scope="module")
def cluster(scheduler: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Place]:
    """Two workers."""
    with ExitStack() as workers:
        for _ in range(2):
            workers.enter_context(worker(scheduler, tmp_path_factory.mktemp("worker")))
        yield place(f"dask://{scheduler}")
