"""Searched flights and soaks of the boards of documents 002 to 004: rows, margins, commands."""

from __future__ import annotations

import json
from collections.abc import Sequence

import pytest
from click.testing import CliRunner
from known_missions import known_on

from mission.cli import main
from mission.model.shipped import load_vehicle
from mission.verification.campaign import margins as of_margins
from mission.verification.campaign.draw import Subject, rows
from mission.verification.campaign.faults import FlightResult
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.soak import Soaked
from mission.verification.campaign.soak import story as soak_story
from mission.verification.campaign.staging import scenes_of
from mission.verification.campaign.steered import plan_of


@pytest.fixture(scope="module")
def known() -> Sequence[Subject]:
    return known_on("rov")


def test_rows_of_a_board_are_the_scenes_that_can_come_to_it_and_its_missions(
    known: Sequence[Subject],
) -> None:
    assert rows(known) == (*scenes_of("rov"), "rov-dive")


def test_a_searched_flight_of_a_board_follows_from_its_name(known: Sequence[Subject]) -> None:
    plan = plan_of("rov-dive/3/0", 5, known)
    assert plan == plan_of("rov-dive/3/0", 5, known)
    assert plan != plan_of("rov-dive/3/1", 5, known)
    assert (plan.profile, plan.vehicle.name) == ("documented", "rov")


def test_a_scene_that_cannot_come_to_a_board_is_no_flight_of_it(known: Sequence[Subject]) -> None:
    with pytest.raises(ValueError, match="no flight 'clogged/3'"):
        plan_of("clogged/3", 5, known)


class _Story:
    def __init__(self, name: str) -> None:
        self.vehicle = load_vehicle(name)
        self.board = None if name == "auv" else object()


@pytest.mark.parametrize(
    ("name", "absent"),
    [
        ("auv", set()),
        ("coreboard", {"answers", "stop", "order"}),
        ("rov", {"answers", "stop", "order", "radius", "estimate"}),
    ],
)
def test_no_margin_asks_for_what_a_vehicle_never_says(
    name: str, absent: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    half = dict.fromkeys(of_margins.MARGINS, lambda flight: [0.5])
    monkeypatch.setattr(of_margins, "MARGINS", half)
    found = of_margins.margins(_Story(name))  # type: ignore[arg-type]
    assert set(half) - set(found) == absent


@pytest.mark.proof
def test_the_command_searches_and_soaks_on_a_board() -> None:
    search = ["faults", "--vehicle", "robot", "--search", "--flights", "1", "--workers", "1"]
    done = CliRunner().invoke(main, search)
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout.splitlines()[-1])["flights"] == 1
    soaked = CliRunner().invoke(main, ["faults", "--vehicle", "robot", "--soak", "0.0002"])
    assert json.loads(soaked.stdout.splitlines()[-1])["missions"] == 1


def test_a_soak_of_a_board_that_broke_a_law_is_told_with_its_vehicle() -> None:
    result = FlightResult(0, "words", (), (Violation("lost", 3.0, "gone"),), ())
    told = list(soak_story(Soaked(0.5), result, 7, "rov"))
    assert told[-1] == "  again: auvmission faults --vehicle rov --seed 7 --soak 0.50"
    *_, calm = soak_story(Soaked(0.5041), result, 7, "auv", calmly=True)
    assert calm == "  again: auvmission faults --calm --seed 7 --soak 0.51"  # not before it
