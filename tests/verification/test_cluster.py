"""Jobs on a Dask cluster: a real scheduler, real workers in processes of their own, which die."""

from __future__ import annotations

import functools
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from known_missions import KNOWN as SHIPPED
from labour import Job, do
from served import soon

from mission.cli import main
from mission.verification.campaign.faults import fly_numbered
from mission.verification.workers import results
from mission.verification.workers.code import code
from mission.verification.workers.outcome import Lost, Unreachable
from mission.verification.workers.places import Place, place

pytestmark = pytest.mark.xdist_group("cluster")  # one worker of the tests begins it, once
ROOT = Path(__file__).resolve().parents[2]
SQUARES: list[Job] = [("square", n) for n in range(12)]
KNOWN = SHIPPED[:2]


@contextmanager
def begun(
    call: list[str], folder: Path, path: str, word: bytes, **settings: str
) -> Iterator[bytes]:
    """A program of Dask's from when its log says ``word``: what follows that word on its line.
    ``settings``: of Dask's own, as its environment says them.

    The program and its processes are ended with the block."""
    log = folder / f"{call[0]}{len(list(folder.iterdir()))}.log"
    with log.open("wb") as file:
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{call[0]}", *call[1:]],
            stdout=file, stderr=file, cwd=folder, start_new_session=True,
            env={**os.environ, "PYTHONPATH": path, **settings},
        )  # fmt: skip

    def told() -> list[bytes]:
        assert process.poll() is None, f"{call[0]} ended: {log.read_text()}"
        return re.findall(re.escape(word) + rb"(.*)\n", log.read_bytes())

    try:
        soon(told, f"{word!r} of {call[0]}")
        yield told()[0]
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@contextmanager
def worker(address: str, folder: Path, tree: Path = ROOT, threads: int = 1) -> Iterator[None]:
    call = ["dask_worker", f"tcp://{address}", "--nthreads", str(threads), "--no-dashboard"]
    path = os.pathsep.join([str(tree), str(ROOT / "tests" / "worlds")])
    with begun(call, folder, path, b"Registered to"):
        yield


@contextmanager
def scheduling(folder: Path, **settings: str) -> Iterator[str]:
    call = ["dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    with begun(call, folder, str(ROOT), b"Scheduler at", **settings) as rest:
        yield rest.decode().partition("tcp://")[2].strip()


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with scheduling(tmp_path_factory.mktemp("scheduler")) as address:
        yield address


@pytest.fixture(scope="module")
def cluster(scheduler: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Place]:
    """Two workers."""
    with ExitStack() as workers:
        for _ in range(2):
            workers.enter_context(worker(scheduler, tmp_path_factory.mktemp("worker")))
        yield place(f"dask://{scheduler}")


def among_squares(job: Job, at: Place) -> Any:
    found = list(results(do, [*SQUARES[:4], job, *SQUARES[4:]], at))
    outcome = found.pop(4)
    assert found == [do(square) for square in SQUARES]
    return outcome


@pytest.mark.proof
def test_a_scheduler_without_a_worker_is_told(
    scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.verification.workers.cluster.JOINING", 0.5)
    with pytest.raises(Unreachable, match="has no worker"):
        list(results(do, SQUARES, place(f"dask://{scheduler}")))


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


UNFORGIVING = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}


@pytest.mark.proof
def test_of_jobs_beside_killers_none_but_the_killers_are_told(tmp_path: Path) -> None:
    """The scheduler blames whatever waits at a worker that dies: here for its first death."""
    jobs: list[Job] = [("dies_later" if n in (3, 9, 10) else "square", n) for n in range(18)]
    with scheduling(tmp_path, **UNFORGIVING) as address, worker(address, tmp_path):
        found = list(results(do, jobs, place(f"dask://{address}")))
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
def test_a_job_that_raises_is_told_at_once(cluster: Place, tmp_path: Path) -> None:
    lost = among_squares(("fails", tmp_path), cluster)
    assert (lost.why, len(list(tmp_path.iterdir()))) == ("raised KeyError: 'no such leg'", 1)


@pytest.mark.proof
def test_a_job_that_is_out_of_memory_is_tried_again_and_told(
    cluster: Place, tmp_path: Path
) -> None:
    lost = among_squares(("eats_too_much", tmp_path), cluster)
    assert (lost.why.partition(":")[0], len(list(tmp_path.iterdir()))) == ("MemoryError", 2)


def other_program(folder: Path) -> Path:
    for package in ("mission", "links", "protocol", "missions"):
        half = shutil.ignore_patterns("*.pyc.*")  # what another process just compiles
        shutil.copytree(ROOT / package, folder / package, ignore=half)
    with (folder / "links" / "simulated" / "plant.py").open("a") as plant:
        plant.write("# heavier\n")
    return folder


@pytest.mark.proof
def test_a_worker_with_another_program_is_refused_before_the_first_job(
    cluster: Place, tmp_path: Path
) -> None:
    tree = other_program(tmp_path / "tree")
    with (
        worker(cluster.address, tmp_path, tree),
        pytest.raises(Unreachable, match=r"another program.*sources [0-9a-f]{16}, here"),
    ):
        list(results(do, SQUARES, cluster))


@pytest.mark.proof
def test_a_worker_that_joins_later_with_another_program_does_no_job(
    cluster: Place, tmp_path: Path
) -> None:
    tree = other_program(tmp_path / "tree")
    found = results(do, [("sources", n) for n in range(200)], cluster)
    first = next(found)
    with worker(cluster.address, tmp_path, tree):
        assert {first, *found} == {code()["sources"]}


@pytest.mark.proof
def test_where_only_workers_with_another_program_are_left_that_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.verification.workers.cluster.COUNT", 0.5)
    tree = other_program(tmp_path / "tree")
    with scheduling(tmp_path) as address, ExitStack() as later:
        with worker(address, tmp_path):
            found = results(do, [("sources", n) for n in range(10_000)], place(f"dask://{address}"))
            next(found)
            monkeypatch.setattr("mission.verification.workers.cluster.ALONE", 0.5)
            later.enter_context(worker(address, tmp_path, tree))
        with pytest.raises(Unreachable, match="of this program"):
            list(found)


@pytest.mark.proof
def test_a_worker_with_several_threads_is_refused(cluster: Place, tmp_path: Path) -> None:
    with (
        worker(cluster.address, tmp_path, threads=2),
        pytest.raises(Unreachable, match="2 threads: begin it with --nthreads 1"),
    ):
        list(results(do, SQUARES, cluster))


@pytest.mark.proof
def test_the_command_flies_on_the_cluster_as_it_flies_here(cluster: Place) -> None:
    call = ["faults", "--flights", "4", "--seed", "4", "--json", "--on"]
    there = CliRunner().invoke(main, [*call, f"dask://{cluster.address}"])
    assert there.exit_code == 0, there.stderr
    assert there.stdout == CliRunner().invoke(main, [*call, "local"]).stdout


@pytest.mark.proof
def test_a_scheduler_that_is_not_there_is_told_with_exit_2(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("mission.verification.workers.cluster.CONNECTING", 0.5)
    with socket.socket() as silent:  # bound, so nobody else gets the port; and nobody listens
        silent.bind(("127.0.0.1", 0))
        at = f"dask://127.0.0.1:{silent.getsockname()[1]}"
        done = CliRunner().invoke(main, ["faults", "--on", at])
    assert done.exit_code == 2
    assert "no scheduler at tcp://127.0.0.1" in done.stderr


def test_beyond_this_machine_it_is_tls() -> None:
    from mission.verification.workers.cluster import url_of  # and Dask with it

    for address in ("127.0.0.1:8786", "localhost:8786", "[::1]:8786"):
        assert url_of(address) == f"tcp://{address}"
    for address in ("192.168.1.7:8786", "cluster:8786", "[fe80::1]:8786"):
        assert url_of(address) == f"tls://{address}"
    with pytest.raises(Unreachable, match="needs keys"):
        list(results(do, SQUARES, place("dask://192.0.2.1:8786")))
