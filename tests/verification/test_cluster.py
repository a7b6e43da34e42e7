"""Jobs on a Dask cluster: a real scheduler, real workers in processes of their own, which die."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import pytest
from clusters import UNFORGIVING, scheduling, worker
from known_missions import KNOWN as SHIPPED
from labour import Job, do, lives
from served import soon

from mission.verification.campaign.faults import fly_numbered
from mission.verification.workers import results, working
from mission.verification.workers.outcome import Lost
from mission.verification.workers.places import Place, place

pytestmark = pytest.mark.xdist_group("cluster")  # one worker of the tests begins it, once
SQUARES: list[Job] = [("square", n) for n in range(12)]
KNOWN = SHIPPED[:2]


def among_squares(job: Job, at: Place) -> Any:
    found = list(results(do, [*SQUARES[:4], job, *SQUARES[4:]], at))
    outcome = found.pop(4)
    assert found == [do(square) for square in SQUARES]
    return outcome


@pytest.mark.proof
def test_results_come_in_the_order_of_their_jobs(cluster: Place) -> None:
    assert list(results(do, SQUARES, cluster)) == [do(square) for square in SQUARES]


@pytest.mark.proof
def test_the_same_flights_are_the_same_to_the_bit_on_a_cluster(cluster: Place) -> None:
    work = functools.partial(fly_numbered, 9, known=KNOWN)
    assert list(results(work, range(4), cluster)) == list(results(work, range(4), place("local")))


@pytest.mark.proof
def test_a_worker_that_is_killed_costs_no_job(cluster: Place, tmp_path: Path) -> None:
    assert among_squares(("dies_once", tmp_path), cluster) == "lived"


@pytest.mark.proof
def test_a_job_that_kills_its_workers_is_told_by_its_name(cluster: Place) -> None:
    lost = among_squares(("dies", 0), cluster)
    assert lost == Lost("('dies', 0)", "4 workers died of it")


@pytest.mark.proof
def test_of_jobs_beside_killers_none_but_the_killers_are_told(tmp_path: Path) -> None:
    """The scheduler blames whatever waits at a worker that dies: here for its first death."""
    jobs: list[Job] = [("dies_later" if n in (3, 9, 10) else "square", n) for n in range(18)]
    with scheduling(tmp_path, **UNFORGIVING) as dask, worker(dask.word, tmp_path):
        found = list(results(do, jobs, place(f"dask://{dask.word}")))
    lost = [Lost(str(job), "1 worker died of it") for job in jobs if job[0] != "square"]
    assert [it for it in found if isinstance(it, Lost)] == lost
    assert [it for it in found if it not in lost] == [do(j) for j in jobs if j[0] == "square"]


@pytest.mark.proof
def test_a_job_that_hangs_ends_its_worker_and_is_tried_again(
    cluster: Place, tmp_path: Path
) -> None:
    impatient = place(f"dask://{cluster.address}", patience=2.0)
    assert among_squares(("hangs_once", tmp_path), impatient) == "answered"


@pytest.mark.proof
def test_a_job_that_hangs_for_ever_is_told_by_its_name(tmp_path: Path) -> None:
    with scheduling(tmp_path, **UNFORGIVING) as dask, worker(dask.word, tmp_path):
        impatient = place(f"dask://{dask.word}", patience=2.0)
        lost = among_squares(("hangs", 0), impatient)
    assert lost == Lost("('hangs', 0)", "1 worker died of it")


@pytest.mark.proof
def test_a_worker_that_stands_still_costs_its_job_another_try(tmp_path: Path) -> None:
    """It can neither look at the clock nor hear the scheduler, who gives it up after a while."""
    tries = tmp_path / "tries"
    tries.mkdir()
    with (
        scheduling(tmp_path, DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL="1s") as dask,
        worker(dask.word, tmp_path),
        worker(dask.word, tmp_path),
    ):
        assert among_squares(("stops_once", tries), place(f"dask://{dask.word}")) == "lived"
    assert len(list(tries.iterdir())) == 2


@pytest.mark.proof
def test_a_job_that_raises_is_told_at_once(cluster: Place, tmp_path: Path) -> None:
    lost = among_squares(("fails", tmp_path), cluster)
    assert (lost.why, len(list(tmp_path.iterdir()))) == ("raised KeyError: 'no such leg'", 1)


@pytest.mark.proof
def test_a_job_that_is_out_of_memory_is_tried_again_and_told(
    cluster: Place, tmp_path: Path
) -> None:
    lost = among_squares(("eats_too_much", tmp_path), cluster)
    assert (lost.why.partition(":")[0], len(list(tmp_path.iterdir()))) == ("MemoryError", 2)


@pytest.mark.proof
def test_a_job_that_outgrows_the_limit_of_its_workers_is_told_by_its_name(tmp_path: Path) -> None:
    with (
        scheduling(tmp_path, **UNFORGIVING) as dask,
        worker(dask.word, tmp_path, "--memory-limit", "400MiB") as small,
    ):
        lost = among_squares(("outgrows", 0), place(f"dask://{dask.word}"))
        assert small.times("memory budget") == 2
    assert lost == Lost("('outgrows', 0)", "1 worker died of it")


@pytest.mark.proof
def test_a_result_that_cannot_be_read_back_is_told(cluster: Place) -> None:
    why = among_squares(("sends_what_cannot_be_read", 0), cluster).why
    assert why == "raised ValueError: the result cannot be read: LookupError: no such thing here"


@pytest.mark.proof
def test_a_batch_that_is_left_early_leaves_the_next_one_alone(cluster: Place) -> None:
    with working(do, cluster) as batch:
        for _ in range(3):
            assert next(batch([("square", n) for n in range(40)])) == do(("square", 0))
            assert list(batch(SQUARES)) == [do(square) for square in SQUARES]


@pytest.mark.proof
def test_a_job_that_nobody_waits_for_any_more_ends(cluster: Place, tmp_path: Path) -> None:
    """Its process, that is: a thread cannot be ended. Another one takes its place."""
    with working(do, cluster) as batch:
        found = batch([("square", 1), ("hangs_once", tmp_path)])
        next(found)
        soon(lambda: bool(list(tmp_path.iterdir())), "it is under way")
        found.close()
        soon(lambda: not lives(tmp_path), "it has ended")
        assert list(batch(SQUARES)) == [do(square) for square in SQUARES]
