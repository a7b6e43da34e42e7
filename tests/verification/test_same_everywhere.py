"""A command says the same from this process, from several and from a Dask cluster, whose workers
stand in other folders: no job needs a file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from click.testing import CliRunner
from served import soon
from test_cluster import scheduling, worker

from mission.cli import main
from mission.model.shipped import vehicle_file
from mission.verification.workers import results
from mission.verification.workers.places import place
from mission.verification.workers.telling import tell

pytestmark = [pytest.mark.proof, pytest.mark.xdist_group("cluster")]
DIVE = (
    "mission short vehicle auv\nhome 30.2874595 120.1535765\nassume current 0.1\n"
    "safety depth 5 radius 400 time 20min\nparam far 3min\n"
    "out: follow file way.csv gear 6 depth 2 within 10 timeout far\nup: surface timeout 2min\n"
)
DRIVE = "mission drive vehicle robot\nstart without fix\nsafety time 20min\nout: gear 6 for 60\n"
FILES = {
    "dive.mission": DIVE,
    "drive.mission": DRIVE,
    "way.csv": "latitude,longitude\n30.2877,120.1536\n30.2878,120.1538\n",
    "bay.asc": "ncols 2\nnrows 2\nxllcorner 120\nyllcorner 30\ncellsize 0.5\n20 20\n20 21\n",
    "own-auv.yaml": vehicle_file("auv").read_text().replace("hotel: 35", "hotel: 135"),
    "own-robot.yaml": vehicle_file("robot")
    .read_text()
    .replace("full_speed: 1000", "full_speed: 900"),
}


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Of a scheduler with two workers."""
    with scheduling(tmp_path_factory.mktemp("scheduler")) as found, ExitStack() as workers:
        for _ in range(2):
            workers.enter_context(worker(found, tmp_path_factory.mktemp("worker")))
        yield found


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        Path(name).write_text(text)


def said(call: str, on: str) -> str:
    ran = CliRunner().invoke(main, [*call.split(), "--on", on])
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout.splitlines()[-1]).get("undone", 0) in (0, [])
    return ran.stdout


@pytest.mark.parametrize(
    "call",
    [
        "rehearse dive.mission --param far=4min --vehicle own-auv.yaml --bathymetry bay.asc "
        "--flights 4 --seed 5 --json",
        "campaign dive.mission --missions 3 --flights 2 --seed 5",
        "campaign --word 3 --flights 2 --seed 5",
        "faults --search --flights 4 --seed 5 --vehicle robot --json",
        "faults --calm --flights 4 --seed 5 --json",
        pytest.param(
            "exhaustive drive.mission --vehicle own-robot.yaml --json", marks=pytest.mark.minutes
        ),
    ],
    ids=lambda call: call[:40],
)
@pytest.mark.usefixtures("here")
def test_a_command_says_the_same_from_everywhere(call: str, address: str) -> None:
    alone = said(call, "local")
    assert said(call, "processes") == alone
    assert said(call, f"dask://{address}") == alone


@pytest.mark.usefixtures("here")
def test_results_of_a_cluster_are_taken_for_those_of_this_process(address: str) -> None:
    call = "rehearse dive.mission --vehicle own-auv.yaml --flights 3 --json --resume kept.jsonl"
    there = said(call, f"dask://{address}")
    before = Path("kept.jsonl").read_bytes()
    assert said(call, "local") == there
    assert Path("kept.jsonl").read_bytes() == before


def test_what_a_job_tells_reaches_the_command(
    address: str, capfd: pytest.CaptureFixture[str]
) -> None:
    told = ""

    def has_come() -> bool:
        nonlocal told
        told += capfd.readouterr().err
        return f"to {on}" in told

    for on in ("local", "processes", f"dask://{address}"):
        assert list(results(tell, [f"to {on}"], place(on, 1))) == [None]
        soon(has_come, f"a line of {on}")
