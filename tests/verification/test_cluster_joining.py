"""Who can join a campaign on a Dask cluster, and how: by TLS, with this program, one thread, and an
answer."""

from __future__ import annotations

import socket
import subprocess
from contextlib import ExitStack
from pathlib import Path

import pytest
from click.testing import CliRunner
from clusters import other_program, processes_of, scheduling, stopped, worker
from labour import Job, do

from mission.cli import main
from mission.verification.workers import results
from mission.verification.workers.code import code
from mission.verification.workers.outcome import Unreachable
from mission.verification.workers.places import Place, place

pytestmark = pytest.mark.xdist_group("cluster")  # one worker of the tests begins it, once
SQUARES: list[Job] = [("square", n) for n in range(12)]


@pytest.mark.proof
def test_a_scheduler_without_a_worker_is_told(
    scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.verification.workers.joining.JOINING", 0.5)
    with pytest.raises(Unreachable, match="has no worker"):
        list(results(do, SQUARES, place(f"dask://{scheduler}")))


@pytest.mark.proof
def test_a_scheduler_that_is_not_there_is_told_with_exit_2(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("mission.verification.workers.joining.CONNECTING", 0.5)
    with socket.socket() as silent:  # bound, so nobody else gets the port; and nobody listens
        silent.bind(("127.0.0.1", 0))
        at = f"dask://127.0.0.1:{silent.getsockname()[1]}"
        done = CliRunner().invoke(main, ["faults", "--on", at])
    assert done.exit_code == 2
    assert "no scheduler at tcp://127.0.0.1" in done.stderr


@pytest.mark.proof
def test_a_worker_with_another_program_is_refused_before_the_first_job(
    cluster: Place, tmp_path: Path
) -> None:
    tree = other_program(tmp_path / "tree")
    with (
        worker(cluster.address, tmp_path, tree=tree),
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
    with worker(cluster.address, tmp_path, tree=tree):
        assert {first, *found} == {code()["sources"]}


@pytest.mark.proof
def test_where_only_workers_with_another_program_are_left_that_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.verification.workers.cluster.COUNT", 0.5)
    tree = other_program(tmp_path / "tree")
    with scheduling(tmp_path) as dask, ExitStack() as later:
        with worker(dask.word, tmp_path):
            at = place(f"dask://{dask.word}")
            found = results(do, [("sources", n) for n in range(10_000)], at)
            next(found)
            monkeypatch.setattr("mission.verification.workers.cluster.ALONE", 0.5)
            later.enter_context(worker(dask.word, tmp_path, tree=tree))
        with pytest.raises(Unreachable, match="of this program"):
            list(found)


@pytest.mark.proof
def test_a_worker_with_several_threads_is_refused(cluster: Place, tmp_path: Path) -> None:
    with (
        worker(cluster.address, tmp_path, threads=2),
        pytest.raises(Unreachable, match="2 threads: begin it with --nthreads 1"),
    ):
        list(results(do, SQUARES, cluster))


def test_beyond_this_machine_it_is_tls() -> None:
    from mission.verification.workers.joining import url_of  # and Dask with it

    for address in ("127.0.0.1:8786", "localhost:8786", "[::1]:8786"):
        assert url_of(address) == f"tcp://{address}"
    for address in ("192.168.1.7:8786", "cluster:8786", "[fe80::1]:8786"):
        assert url_of(address) == f"tls://{address}"
    with pytest.raises(Unreachable, match="needs keys"):
        list(results(do, SQUARES, place("dask://192.0.2.1:8786")))


@pytest.mark.proof
def test_a_worker_that_joins_later_with_several_threads_does_no_job(
    cluster: Place, tmp_path: Path
) -> None:
    found = results(do, [("process", n) for n in range(200)], cluster)
    first, before = next(found), processes_of(cluster.address).values()
    with worker(cluster.address, tmp_path, threads=4):
        (late,) = {*processes_of(cluster.address).values()} - {*before}
        assert late not in {first, *found}


@pytest.mark.proof
def test_a_worker_that_does_not_answer_is_named_and_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("mission.verification.workers.joining.ANSWERING", 5.0)
    with (
        scheduling(tmp_path) as dask,
        worker(dask.word, tmp_path),
        worker(dask.word, tmp_path),
    ):
        at = place(f"dask://{dask.word}")
        list(results(do, SQUARES, at))  # both know their program
        (silent, pid), (other, _) = processes_of(dask.word).items()
        with stopped(pid):
            assert list(results(do, SQUARES, at)) == [do(square) for square in SQUARES]
            assert f"{silent} does not answer: it is left out" in caplog.messages
            assert [*processes_of(dask.word)] == [other]


@pytest.mark.proof
def test_where_no_worker_answers_that_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.verification.workers.joining.ANSWERING", 0.5)
    with scheduling(tmp_path) as dask, worker(dask.word, tmp_path):
        ((silent, pid),) = processes_of(dask.word).items()
        with stopped(pid), pytest.raises(Unreachable, match=f"answers: {silent}"):
            list(results(do, SQUARES, place(f"dask://{dask.word}")))


# --- keys ---


def openssl(folder: Path, *words: str) -> None:
    subprocess.run(["openssl", *words], cwd=folder, capture_output=True, check=True)


def made_keys(folder: Path) -> dict[str, str]:
    """As docs/how-to/campaign.md makes them: what Dask is told of an authority, a certificate and
    its key, by the names of its settings."""
    folder.mkdir()
    openssl(folder, *["req", "-x509", "-newkey", "rsa:3072", "-nodes", "-days", "365", "-subj", "/CN=campaign", "-addext", "basicConstraints=critical,CA:TRUE", "-keyout", "ca.key", "-out", "ca.pem"])  # fmt: skip
    openssl(folder, *["req", "-newkey", "rsa:3072", "-nodes", "-subj", "/CN=node", "-keyout", "node.key", "-out", "node.csr"])  # fmt: skip
    openssl(folder, *["x509", "-req", "-in", "node.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "365", "-out", "node.pem"])  # fmt: skip
    roles = {"scheduler", "worker", "client"}
    return {
        "distributed.comm.tls.ca-file": str(folder / "ca.pem"),
        **{f"distributed.comm.tls.{role}.cert": str(folder / "node.pem") for role in roles},
        **{f"distributed.comm.tls.{role}.key": str(folder / "node.key") for role in roles},
    }


def as_environment(settings: dict[str, str]) -> dict[str, str]:
    names = {name: name.upper().replace(".", "__").replace("-", "_") for name in settings}
    return {f"DASK_{names[name]}": value for name, value in settings.items()}


@pytest.fixture
def beyond(monkeypatch: pytest.MonkeyPatch) -> None:
    """This machine counts as another one."""
    monkeypatch.setattr("mission.verification.workers.joining._loopback", lambda _: False)


@pytest.mark.proof
@pytest.mark.usefixtures("beyond")
def test_jobs_are_done_over_tls_for_who_has_the_keys_and_for_nobody_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import dask

    ours, others = made_keys(tmp_path / "ours"), made_keys(tmp_path / "others")
    env = as_environment(ours)
    with (
        scheduling(tmp_path, "--protocol", "tls", **env) as program,
        worker(program.word, tmp_path, protocol="tls", **env),
    ):
        at = place(f"dask://{program.word}")
        with dask.config.set(ours):
            assert list(results(do, SQUARES, at)) == [do(square) for square in SQUARES]
        monkeypatch.setattr("mission.verification.workers.joining.CONNECTING", 1.0)
        with dask.config.set(others), pytest.raises(Unreachable, match="no scheduler at tls://"):
            list(results(do, SQUARES, at))


def test_keys_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    import dask

    keys = made_keys(tmp_path / "keys")
    there = tmp_path / "keys" / "node.key"
    there.unlink()
    with (
        dask.config.set(keys),
        pytest.raises(Unreachable, match=f"the keys cannot be read .*{there}"),
    ):
        list(results(do, SQUARES, place("dask://192.0.2.1:8786")))
