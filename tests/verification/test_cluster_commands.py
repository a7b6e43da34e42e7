"""Commands on a Dask cluster that do not come to their end: interrupted, killed, or left by the
scheduler. They go on later from what they have kept."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner
from clusters import scheduling, worker
from commanded import CODE, begun, interrupted
from labour import lives
from served import PATIENCE, soon

from mission.cli import main
from mission.verification.workers.places import Place

pytestmark = [pytest.mark.proof, pytest.mark.xdist_group("cluster")]
WORLDS = {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
FAULTS = ("faults", "--seed", "4")
ALONE = """import sys
from pathlib import Path
from labour import do
from mission.verification.workers import results
from mission.verification.workers.places import place
list(results(do, [("hangs_once", Path(sys.argv[1]))], place(sys.argv[2])))
"""


def on(address: str, kept: Path) -> tuple[str, ...]:
    return ("--on", f"dask://{address}", "--resume", str(kept))


def some_are_kept(kept: Path) -> Callable[[], bool]:
    return lambda: kept.exists() and kept.read_bytes().count(b"\n") > 4


def told(call: tuple[str, ...], *more: str) -> tuple[int, str]:
    ran = CliRunner().invoke(main, [*call, "--flights", "8", *more])
    return ran.exit_code, ran.stdout


@pytest.fixture(scope="module")
def alone() -> tuple[int, str]:
    """What the command says of its flights from a process of its own."""
    return told(FAULTS, "--on", "local")


def test_flights_that_were_interrupted_are_kept_and_the_rest_flown_later(
    cluster: Place, tmp_path: Path, alone: tuple[int, str]
) -> None:
    kept = tmp_path / "kept.jsonl"
    call = (*FAULTS, *on(cluster.address, kept))
    with begun("-m", "mission", *call, "--flights", "2000") as process:
        soon(some_are_kept(kept), "some have ended")
        assert interrupted(process) == (CODE, ["interrupted"])
    there = kept.read_bytes()
    assert there.endswith(b"\n")
    assert told(call) == alone
    assert kept.read_bytes().startswith(there)


def test_a_scheduler_that_is_killed_ends_the_command_which_goes_on_elsewhere(
    cluster: Place, tmp_path: Path, alone: tuple[int, str]
) -> None:
    kept = tmp_path / "kept.jsonl"
    with scheduling(tmp_path) as dask, worker(dask.word, tmp_path):
        call = ("-m", "mission", *FAULTS, *on(dask.word, kept), "--flights", "2000")
        with begun(*call) as process:
            soon(some_are_kept(kept), "some have ended")
            dask.kill()
            _, words = process.communicate(timeout=PATIENCE)
    gone = f"the scheduler at tcp://{dask.word} is gone; the same command continues"
    assert process.returncode == 2
    assert f"Error: {gone} from what --resume has kept" in words.splitlines()
    assert "Traceback" not in words
    there = kept.read_bytes()
    assert told((*FAULTS, *on(cluster.address, kept))) == alone
    assert kept.read_bytes().startswith(there)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_job_does_not_outlive_who_wanted_it(
    number: signal.Signals, cluster: Place, tmp_path: Path
) -> None:
    """Its process ends, even if nobody can tell it: the scheduler knows who is connected."""
    with begun("-c", ALONE, str(tmp_path), f"dask://{cluster.address}", **WORLDS) as process:
        soon(lambda: bool(list(tmp_path.iterdir())), "it is under way")
        if number == signal.SIGINT:
            interrupted(process)
        else:
            process.kill()
        soon(lambda: not lives(tmp_path), "it has ended")
