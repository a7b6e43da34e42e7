"""What is kept in a results file is of what was asked for: another vehicle, sea floor, mission or
file beside it is refused or flown anew, and no path has a say in it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from mission.cli import main
from mission.model.shipped import vehicle_file
from mission.verification.exhaustive import run
from mission.verification.exhaustive.run import Found
from mission.verification.workers.code import _files

DIVE = (
    "mission short vehicle auv\nhome 30.2874595 120.1535765\nassume current 0.1\n"
    "safety depth 5 radius 400 time 20min\n"
    "out: follow file way.csv gear 6 depth 2 within 10 timeout 3min\nup: surface timeout 2min\n"
)
WAY = "latitude,longitude\n30.2877,120.1536\n30.2878,120.1538\n"
BAY = "ncols 2\nnrows 2\nxllcorner 120\nyllcorner 30\ncellsize 0.5\n20 20\n20 20\n"
RESUMED = ("--on", "local", "--resume", "kept.jsonl")
REHEARSE = ("rehearse", "dive.mission", "--flights", "2", "--vehicle", "own.yaml",
            "--bathymetry", "bay.asc", "--json", *RESUMED)  # fmt: skip
CAMPAIGN = ("campaign", "dive.mission", "--flights", "1", *RESUMED)
EXHAUSTIVE = ("exhaustive", "dive.mission", "--vehicle", "own.yaml", "--json", *RESUMED)
CHANGES = {
    "vehicle": ("own.yaml", "hotel: 35", "hotel: 135"),
    "bathymetry": ("bay.asc", "20 20", "19 20"),
    "rehearsed": ("dive.mission", "gear 6", "gear 8"),
    "rehearsed by a file beside it": ("way.csv", "30.2878", "30.2879"),
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a mission and all that it needs."""
    monkeypatch.chdir(tmp_path)
    own = vehicle_file("auv").read_text()
    for name, text in (
        ("dive.mission", DIVE),
        ("way.csv", WAY),
        ("bay.asc", BAY),
        ("own.yaml", own),
    ):
        (tmp_path / name).write_text(text)
    return tmp_path


def told(call: tuple[str, ...], code: int = 0) -> Result:
    ran = CliRunner().invoke(main, [*call])
    assert ran.exit_code == code, ran.output
    return ran


def changed(what: str) -> None:
    name, old, new = CHANGES[what]
    text = Path(name).read_text()
    assert old in text
    Path(name).write_text(text.replace(old, new))


def rows() -> list[str]:
    return [json.loads(line)["job"] for line in Path("kept.jsonl").read_text().splitlines()[1:]]


@pytest.mark.parametrize("what", CHANGES)
def test_a_rehearsal_of_something_else_is_refused(what: str, here: Path) -> None:
    told(REHEARSE)
    before = Path("kept.jsonl").read_bytes()
    changed(what)
    ran = told(REHEARSE, 2)
    assert f"another campaign ({what.partition(' ')[0]} " in ran.stderr
    assert Path("kept.jsonl").read_bytes() == before


def test_a_rehearsal_on_another_vehicle_by_name_is_refused(here: Path) -> None:
    told(REHEARSE)
    ran = told((*REHEARSE, "--vehicle", "auv-documented"), 2)
    assert "another campaign (vehicle " in ran.stderr


def test_a_rehearsal_goes_on_wherever_the_same_files_are_now(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = json.loads(told(REHEARSE).stdout)
    there = here / "moved"
    there.mkdir()
    for file in [*here.iterdir()]:
        if file.is_file():
            file.rename(there / file.name)
    monkeypatch.chdir(there)
    assert json.loads(told(REHEARSE).stdout) == first
    assert rows() == ["flight 0", "flight 1"]


@pytest.mark.parametrize("what", ["rehearsed", "rehearsed by a file beside it"])
def test_a_campaign_flies_another_mission_anew_and_keeps_both(what: str, here: Path) -> None:
    told(CAMPAIGN)
    first = rows()
    told(CAMPAIGN)
    assert rows() == first
    changed(what)
    told(CAMPAIGN)
    assert len({*rows()}) == 2


@pytest.mark.parametrize("what", ["rehearsed", "rehearsed by a file beside it", "vehicle"])
def test_cells_of_something_else_are_examined_anew(
    what: str, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    examined: list[str] = []
    monkeypatch.setattr(run, "examine_ground", lambda on: examined.append(on.profile) or Found())
    monkeypatch.setattr("mission.verification.exhaustive.run.unasked", lambda *_, **__: [])
    told(EXHAUSTIVE)
    told(EXHAUSTIVE)
    assert examined == ["as-built", "documented"]
    changed(what)
    told(EXHAUSTIVE)
    assert examined == 2 * ["as-built", "documented"]
    assert len({*rows()}) == 4


def test_the_program_has_the_shipped_vehicles_and_the_missions_of_all_of_them() -> None:
    names = {name for name, _ in _files()}
    assert {"missions/first-dive.yaml", "missions/others/rov-dive.yaml"} < names
    assert {"missions/vehicles/auv.yaml", "missions/vehicles/rov.yaml"} < names
