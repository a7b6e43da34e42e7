"""A fault is one row: this file has a toy that nobody else knows, and it is seen everywhere."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from contracts import keep

from links.simulated.fault import Fault, Parts
from links.simulated.faults import FAULTS
from links.simulated.plant import LEFT_MAIN, RIGHT_MAIN
from links.simulated.settings import FaultEvent, parse_settings, setting_of
from mission.analysis.replay.replay import replay
from mission.authoring.language import parse
from mission.authoring.prepare import prepare
from mission.cli import main
from mission.model.shipped import load_vehicle, missions_folder
from mission.onboard.runtime.records import ListRecorder
from mission.verification.campaign.draw import Subject, draw
from mission.verification.simulation.flight import fly

DOCS = Path(__file__).resolve().parents[2] / "docs"
VEHICLE = load_vehicle("auv")
TEXT = (
    "mission toy vehicle auv\nhome 30.28 120.15\nsafety radius 400 time 30min depth 20\n"
    "a: heading 0 gear 6 depth 4 for 60\n"
)


def begin(parts: Parts, value: float) -> None:
    parts.plant.strength[LEFT_MAIN] = parts.plant.strength[RIGHT_MAIN] = value


def end(parts: Parts, _: float) -> None:
    parts.plant.strength[LEFT_MAIN] = parts.plant.strength[RIGHT_MAIN] = 1.0


TOY = Fault("weed in both screws", begin, end, 0.5, "of the thrust", 120.0)


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAULTS, "toy_weed", TOY)


def test_it_is_read_written_and_flown() -> None:
    settings = parse_settings(["fault=toy_weed=0.1@5"])
    (event,) = settings.faults
    assert event == FaultEvent("toy_weed", 5.0, None, 0.1)
    assert setting_of(event) == "toy_weed=0.1@5.0"
    sound, sick = (fly(parse(TEXT), VEHICLE, seed=3, settings=s) for s in (None, settings))
    assert sound.max_range > sick.max_range + 10.0


def test_what_is_flown_with_it_is_recorded_and_replayed_to_the_bit() -> None:
    recorder = ListRecorder()
    fly(parse(TEXT), VEHICLE, seed=3, settings=parse_settings(["fault=toy_weed=0.1@5"]),
        recorder=recorder)  # fmt: skip
    assert replay(recorder.records).identical


def test_it_is_listed_in_the_reference_and_taken_by_the_commands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(str(DOCS))
    from from_code.tables import simulation_settings

    assert "`toy_weed`" in simulation_settings()
    ran = CliRunner().invoke(main, ["simulate", "first-dive", "--set", "fault=toy_wed=1@5"])
    assert ran.exit_code != 0
    assert "toy_weed" in ran.output


def test_it_keeps_the_contract_of_faults() -> None:
    keep("faults", "toy_weed")


def test_the_campaign_draws_it() -> None:
    prepared = prepare("first-dive")
    subject = Subject(missions_folder() / "first-dive.yaml", prepared.mission, 300.0)
    plans = [draw(0, number, [subject]) for number in range(600)]
    drawn = [event for plan in plans for event in plan.settings.faults if event.name == "toy_weed"]
    assert drawn
    assert all(0.25 <= event.value <= 0.75 for event in drawn)
