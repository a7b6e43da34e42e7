"""Whether a flight achieved what its mission is for: told by simulate, counted by rehearse."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from mission.authoring.language import parse
from mission.authoring.prepare import prepare
from mission.cli import main
from mission.model.plain import from_plain, to_plain
from mission.verification.rehearsing.flights import Flown
from mission.verification.rehearsing.report import as_text, report_of
from mission.verification.simulation.flight import fly
from mission.verification.simulation.reaching import Achieved, achieved_by, told

AIMS = (("coverage", 0.9), ("position", 20.0))


@pytest.mark.parametrize(
    ("figures", "reached"),
    [
        ((("coverage", 0.9), ("position", 20.0)), True),
        ((("coverage", 0.89), ("position", 5.0)), False),
        ((("coverage", 0.95), ("position", 21.0)), False),
        ((("coverage", 0.95),), False),
        ((), False),
    ],
)
def test_every_aim_must_be_reached(figures: Any, reached: bool) -> None:
    one = Achieved("mow", AIMS, figures)
    assert one.reached is reached
    (line,) = told([one])
    assert ("reached" in line) is reached


def test_a_mission_without_a_purpose_achieves_nothing_and_misses_nothing() -> None:
    flight: Any = SimpleNamespace(legs=(), samples=())
    assert achieved_by(flight, parse("mission m vehicle auv\na: wait 5s\n")) == ()


def test_a_leg_without_rows_achieves_its_position_by_the_truth_along_it() -> None:
    ready = prepare("first-dive")
    flight = fly(ready.mission, ready.vehicle)
    found = achieved_by(flight, ready.mission)
    assert [one.leg for one in found] == ["box/north", "box/east", "box/south", "box/west"]
    for one in found:
        (leg,) = (leg for leg in flight.legs if leg.name == one.leg)
        within = [s.error for s in flight.samples if leg.entered <= s.t <= leg.left]
        assert dict(one.figures) == {"position": max(within)}
        assert one.reached


def test_a_leg_that_was_not_flown_has_missed_its_purpose() -> None:
    flight: Any = SimpleNamespace(legs=(), samples=())
    found = achieved_by(flight, prepare("first-dive").mission)
    assert [one.reached for one in found] == [False] * 4


@pytest.mark.proof
def test_simulate_tells_whether_the_flight_achieved_it() -> None:
    run = CliRunner().invoke(main, ["simulate", "lawnmower", "--json"])
    flown = json.loads(run.stdout)
    (found,) = flown["purpose"]
    assert found["leg"] == "mow/rows"
    assert found["achieved"]["coverage"] == flown["coverage"][0]["true"]
    assert found["reached"] is True
    table = CliRunner().invoke(main, ["simulate", "lawnmower"]).stdout
    assert "purpose           mow/rows: reached: coverage" in table


def flown(number: int, error: float) -> Flown:
    achieved = (Achieved("mow", AIMS, (("coverage", 0.95), ("position", error))),)
    return Flown(number, (), "completed", "", 60.0, 1.0, error, (), None, (), achieved)


def test_a_rehearsal_counts_the_flights_that_achieved_it() -> None:
    made = report_of([flown(0, 5.0), flown(1, 25.0), flown(2, 6.0)])
    hits, low, high = made.reached["mow"]
    assert hits == 2
    assert 0.0 < low < 2 / 3 < high < 1.0
    assert "purpose reached   2 of 3" in as_text(made, "m", 0)


def test_what_was_achieved_is_kept_with_the_flight() -> None:
    one = flown(0, 5.0)
    assert from_plain(Flown, json.loads(json.dumps(to_plain(one)))) == one
