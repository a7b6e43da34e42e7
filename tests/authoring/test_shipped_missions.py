"""Every shipped mission comes home: on both vehicles, in a current, within what was proved."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from links.simulated.settings import parse_settings
from mission.authoring.prepare import Unreadable, check_prepared, mission_file, prepare
from mission.verification.simulation.flight import fly
from mission.verification.simulation.reaching import achieved_by

ROOT = Path(__file__).resolve().parents[2]
MISSIONS = sorted((ROOT / "missions").glob("*.yaml"))

OTHERS = {"coreboard": "coreboard-dive", "rov": "rov-dive", "robot": "robot-drive"}


def test_there_are_eight_missions_each_with_a_comment_on_top() -> None:
    assert len(MISSIONS) >= 8
    for path in MISSIONS:
        assert path.read_text(encoding="utf-8").startswith("# "), path


@pytest.mark.parametrize("file", [*MISSIONS, *sorted((ROOT / "missions/others").glob("*.yaml"))])
def test_each_states_its_purpose_and_has_time_for_it_against_the_current_it_assumes(
    file: Path,
) -> None:
    report = check_prepared(prepare(file))
    assert report.outlook
    assert [one.leg for one in report.outlook if one.needs is not None] == []


def test_the_shakedown_says_every_word_that_the_vehicle_follows() -> None:
    text = next(p for p in MISSIONS if p.stem == "shakedown").read_text(encoding="utf-8")
    plain = re.sub(r"#.*", "", text)
    assert set(re.findall(r"\bZA([A-Z])", plain)) == set("FBLRUDSEH")


@pytest.mark.parametrize("path", MISSIONS, ids=lambda p: p.stem)
def test_a_shipped_mission_states_what_it_is_flown_for(path: Path) -> None:
    report = check_prepared(prepare(path))
    assert report.ok
    assert report.outlook


@pytest.mark.proof
@pytest.mark.parametrize("profile", ["as-built", "documented"])
@pytest.mark.parametrize("path", MISSIONS, ids=lambda p: p.stem)
def test_a_shipped_mission_comes_home_in_a_current(path: Path, profile: str) -> None:
    prepared = prepare(path)
    proved = check_prepared(prepared).proved
    assert proved is not None
    # where a mission states no floor, the check takes the depth allowed for it
    sea = parse_settings(["current=0.2@45", f"floor={prepared.mission.safety.depth}"])
    flight = fly(prepared.mission, prepared.vehicle, profile, 3, sea)
    assert flight.outcome == "completed", flight.reason
    assert flight.at_surface
    assert flight.mission_time <= proved.worst_time
    assert flight.max_range <= proved.max_range
    assert flight.max_depth <= proved.max_depth


@pytest.mark.proof
def test_thermocline_field_ends_its_search_where_the_water_grows_cold_and_covers_the_field() -> (
    None
):
    prepared = prepare("thermocline-field")
    sea = parse_settings(["current=0.2@45", "thermocline=4@7"])
    flight = fly(prepared.mission, prepared.vehicle, "as-built", 3, sea)
    found = next(s for s in flight.steps if s.exited == ("autonomous/search",))
    assert found.by is not None
    assert found.by.value == "until"
    (done,) = achieved_by(flight, prepared.mission)
    assert done.reached


@pytest.mark.parametrize("path", MISSIONS, ids=lambda p: p.stem)
def test_a_shipped_mission_is_found_by_its_name_from_any_folder(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert mission_file(path.stem).samefile(path)
    assert prepare(path.stem).mission == prepare(path).mission


def test_a_file_of_that_name_comes_before_the_shipped_mission(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "first-dive").write_text("mission mine\nsafety time 2min\nwait 30s\n")
    assert prepare("first-dive").mission.name == "mine"


def test_a_name_that_is_neither_says_which_missions_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        Unreadable, match=r"first-dve: no such file.*\n.*first-dive, float-test, harbour-survey"
    ):
        prepare("first-dve")
    with pytest.raises(Unreadable, match=r"first-dive\.yaml: cannot be read: No such file"):
        prepare("first-dive.yaml")


@pytest.mark.proof
@pytest.mark.parametrize(("vehicle", "name"), OTHERS.items())
def test_each_of_the_other_vehicles_has_a_shipped_mission_that_comes_home(
    vehicle: str, name: str
) -> None:
    prepared = prepare(name)
    assert prepared.vehicle.name == vehicle
    assert prepared.text.startswith("# ")
    proved = check_prepared(prepared).proved
    assert proved is not None
    flight = fly(prepared.mission, prepared.vehicle, seed=3)
    assert flight.outcome == "completed", flight.reason
    assert flight.at_surface
    assert {leg.by for leg in flight.legs} <= {"until", "for", "end"}
    assert flight.mission_time <= proved.worst_time
    assert flight.max_depth <= proved.max_depth


@pytest.mark.parametrize(
    ("vehicle", "name", "reason"),
    [
        ("coreboard", "bottom-following", "coreboard cannot follow altitude"),
        ("coreboard", "float-test", "the board holds heading and depth together, or neither"),
        ("robot", "first-dive", "robot cannot follow depth"),
        ("robot", "rov-dive", "robot cannot follow heave"),
    ],
)
def test_a_mission_that_cannot_fly_on_a_vehicle_is_refused_for_the_one_reason_that_matters(
    vehicle: str, name: str, reason: str
) -> None:
    """With what instead, and once, however many legs it is true of."""
    with pytest.raises(Unreadable) as refused:
        prepare(name, vehicle)
    (found,) = refused.value.diagnostics
    assert f"not for {vehicle}: " in found.message
    assert reason in found.message
    assert found.where.line > 0
    assert found.hint


def test_boards_that_report_nothing_fly_no_mission() -> None:
    (found,) = check_prepared(prepare("robot-drive", "motorboards")).refusals
    assert found.code == "unheard"
    assert "motorboards reports nothing" in found.message
