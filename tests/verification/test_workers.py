"""Jobs in several processes: all are answered, in order, whatever becomes of the processes."""

from __future__ import annotations

import functools
import json
import os
import platform
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from known_missions import KNOWN as SHIPPED
from labour import Job, do
from served import soon

from mission.cli import main
from mission.verification.campaign.faults import FlightResult, fly_numbered
from mission.verification.workers import results, working
from mission.verification.workers.code import code, difference
from mission.verification.workers.kept import Unusable, keeping
from mission.verification.workers.outcome import Lost, had
from mission.verification.workers.places import Place, place

TWO = place("processes", 2)
LOCAL = place("local")
KNOWN = SHIPPED[:2]
SQUARES: list[Job] = [("square", n) for n in range(8)]
ASKED = {"squares": 8}


def among_squares(job: Job, at: Place = TWO) -> Any:
    """What becomes of it; the jobs around it are done."""
    found = list(results(do, [*SQUARES[:4], job, *SQUARES[4:]], at))
    outcome = found.pop(4)
    assert found == [do(square) for square in SQUARES]
    return outcome


@pytest.mark.proof
@pytest.mark.parametrize("at", [LOCAL, place("processes", 1), TWO, place("processes", 5)])
def test_results_come_in_the_order_of_their_jobs(at: Place) -> None:
    assert list(results(do, SQUARES, at)) == [do(square) for square in SQUARES]
    assert list(results(do, [], at)) == []


@pytest.mark.proof
def test_the_same_flights_are_the_same_to_the_bit_in_whichever_process() -> None:
    work = functools.partial(fly_numbered, 9, known=KNOWN)
    here = list(results(work, range(4), LOCAL))
    assert here == list(results(work, range(4), TWO))
    digests = [had(result).digest for result in here]
    assert len({*digests}) == 4
    assert all(len(digest) == 16 for digest in digests)


@pytest.mark.proof
def test_a_process_that_is_killed_costs_its_job_another_try_and_no_other_anything(
    tmp_path: Path,
) -> None:
    assert among_squares(("dies_once", tmp_path)) == "lived"
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.proof
@pytest.mark.parametrize("workers", [1, 2])
def test_a_job_that_kills_its_processes_is_told_by_its_name(workers: int) -> None:
    lost = among_squares(("dies", 0), place("processes", workers))
    assert lost == Lost("('dies', 0)", "killed by SIGKILL, then killed by SIGKILL")


@pytest.mark.proof
def test_a_job_that_hangs_is_tried_again_and_then_told(tmp_path: Path) -> None:
    at = place("processes", 2, patience=1.0)
    assert among_squares(("hangs_once", tmp_path), at) == "answered"
    assert among_squares(("hangs", 0), at) == Lost("('hangs', 0)", "hung, then hung")


@pytest.mark.proof
def test_a_process_that_stands_still_is_given_up(tmp_path: Path) -> None:
    with working(do, place("processes", 1, patience=2.0)) as batch:
        (pid,) = batch([("tells_its_process", tmp_path)])
        os.kill(had(pid), signal.SIGSTOP)
        assert list(batch(SQUARES)) == [do(square) for square in SQUARES]


@pytest.mark.proof
def test_a_job_that_is_out_of_memory_is_told_so() -> None:
    assert among_squares(("eats", 0)) == Lost("('eats', 0)", "out of memory, then out of memory")


@pytest.mark.parametrize("at", [LOCAL, TWO])
def test_a_job_that_raises_is_told_at_once_and_can_be_raised(at: Place, tmp_path: Path) -> None:
    lost = among_squares(("fails", tmp_path), at)
    assert (lost.why, len(list(tmp_path.iterdir()))) == ("raised KeyError: 'no such leg'", 1)
    with pytest.raises(KeyError, match="no such leg"):
        had(lost)


@pytest.mark.proof
def test_a_result_that_cannot_be_sent_is_told() -> None:
    assert "cannot be sent" in among_squares(("sends_what_cannot_be_sent", 0)).why


def test_two_jobs_of_one_name_are_refused() -> None:
    with pytest.raises(ValueError, match="two jobs named"):
        list(results(do, [SQUARES[1], SQUARES[1]], TWO))


def test_processes_do_not_outlive_who_wanted_them(tmp_path: Path) -> None:
    """Killed, it can tell them nothing."""
    script = (
        "import sys\nfrom mission.verification.workers import results\n"
        "from mission.verification.workers.places import place\n"
        "from labour import do\nfrom pathlib import Path\n"
        "if __name__ == '__main__':\n"
        "    jobs = [('hangs_once', Path(sys.argv[1]))]\n"
        "    print(list(results(do, jobs, place('processes', 1))))\n"
    )
    path = os.pathsep.join(p for p in sys.path if p)
    parent = subprocess.Popen(
        [sys.executable, "-c", script, str(tmp_path)], env={**os.environ, "PYTHONPATH": path}
    )
    soon(lambda: bool(list(tmp_path.iterdir())), "the job is under way")
    child = int(next(tmp_path.iterdir()).suffix[1:])
    parent.kill()
    parent.wait()
    soon(lambda: not Path(f"/proc/{child}").exists(), "the process has ended")


# --- kept on a file ---


def kept_squares(path: Path, jobs: list[Job], at: Place = LOCAL) -> list[Any]:
    with keeping(path, ASKED, float) as kept:
        return list(results(do, jobs, at, kept=kept))


@pytest.mark.proof
def test_what_is_kept_is_not_done_again(tmp_path: Path) -> None:
    file, tries = tmp_path / "kept.jsonl", tmp_path / "tries"
    tries.mkdir()
    job = ("tells_its_process", tries)
    first = kept_squares(file, [*SQUARES[:3], job], TWO)
    again = kept_squares(file, [job, *SQUARES])
    assert again == [first[3], *map(do, SQUARES)]
    assert len(list(tries.iterdir())) == 1


@pytest.mark.proof
def test_a_result_that_is_read_back_is_the_same_to_the_bit(tmp_path: Path) -> None:
    flown = [fly_numbered(9, number, KNOWN) for number in range(2)]
    for _ in range(2):
        with keeping(tmp_path / "kept.jsonl", ASKED, FlightResult) as kept:
            assert list(results(flown.__getitem__, range(2), LOCAL, kept=kept)) == flown


def test_a_line_that_was_cut_off_is_done_again(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    whole = kept_squares(file, SQUARES)
    content = file.read_bytes()
    for cut in (1, 9, len(content.splitlines()[-1])):
        file.write_bytes(content[:-cut])
        assert kept_squares(file, SQUARES) == whole
        assert sorted(file.read_bytes().splitlines()) == sorted(content.splitlines())


def test_what_is_lost_is_not_kept(tmp_path: Path) -> None:
    file, tries = tmp_path / "kept.jsonl", tmp_path / "tries"
    tries.mkdir()
    for times in (1, 2):
        assert isinstance(kept_squares(file, [("fails", tries)])[0], Lost)
        assert len(list(tries.iterdir())) == times


@pytest.mark.parametrize(
    ("part", "name", "words"),
    [("asked", "squares", "another campaign"), ("code", "sources", "another program")],
)
def test_results_of_something_else_are_refused(
    part: str, name: str, words: str, tmp_path: Path
) -> None:
    file = tmp_path / "kept.jsonl"
    kept_squares(file, SQUARES)
    head, *rows = file.read_text().splitlines()
    other = json.loads(head)
    other[part][name] = "other"
    file.write_text("\n".join([json.dumps(other), *rows, ""]))
    before = file.read_bytes()
    with pytest.raises(Unusable, match=f"{words}.*{name} other, here"):
        kept_squares(file, SQUARES)
    assert file.read_bytes() == before


@pytest.mark.parametrize("content", ["mission: x\n", "[]\n", "{}\n", '{"asked": 1}\nx\n', "\0"])
def test_a_file_of_something_else_is_refused_and_left_alone(content: str, tmp_path: Path) -> None:
    file = tmp_path / "mission.yaml"
    file.write_text(content)
    with pytest.raises(Unusable, match="no file of results"):
        kept_squares(file, SQUARES)
    assert file.read_text() == content


@pytest.mark.parametrize("file", ["nodir/kept.jsonl", "/proc/kept.jsonl", "."])
def test_a_file_that_cannot_be_written_is_refused_before_any_job(
    file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(Unusable, match=f"^{re.escape(file)}: cannot be written: "):
        kept_squares(Path(file), SQUARES)


@pytest.mark.parametrize(
    "call", [["faults"], ["campaign"], ["exhaustive"], ["rehearse", "first-dive"]]
)
def test_results_that_can_be_kept_nowhere_end_a_command_before_anything_is_flown(
    call: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = CliRunner().invoke(main, [*call, "--on", "local", "--resume", "nodir/kept.jsonl"])
    assert (ran.exit_code, ran.stdout) == (2, "")
    assert "Error: nodir/kept.jsonl: cannot be written: No such file" in ran.stderr
    assert " flights" not in ran.stderr


# --- which program, and how far ---


def test_programs_differ_by_what_they_compute_with() -> None:
    ours = code()
    assert difference(ours, ours) == ""
    assert difference({**ours, "numpy": "1.0"}, ours) == f"numpy 1.0, here {ours['numpy']}"
    assert difference({}, ours).count("unknown") == len(ours)


def arithmetic(kernel: str) -> str:
    words = "from mission.verification.workers.code import code; print(code()['arithmetic'])"
    told = subprocess.run(
        [sys.executable, "-c", words],
        env=os.environ | {"OPENBLAS_CORETYPE": kernel},
        capture_output=True,
        text=True,
        check=True,
    )
    return told.stdout.strip()


def test_programs_differ_by_how_their_processor_multiplies_matrices() -> None:
    """One kernel has multiplications and additions in one instruction, the other has not."""
    blas = np.show_config("dicts")["Build Dependencies"]["blas"]["name"]  # type: ignore[index]
    if platform.machine() != "x86_64" or "openblas" not in blas:
        pytest.skip("numpy multiplies by other means here")
    assert arithmetic("Nehalem") != arithmetic("Haswell")


@pytest.mark.parametrize("on", ["here", "processes://x", "dask://", "dask://host", "dask://:87"])
def test_a_place_that_is_none_is_refused(on: str) -> None:
    with pytest.raises(ValueError, match=r"place|HOST:PORT"):
        place(on)
