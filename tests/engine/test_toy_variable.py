"""A guard variable is one row: this file has a toy that nobody else knows; it is seen everywhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from random import Random

import pytest
from contracts import keep

from mission.analysis.replay.replay import replay
from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.graph import words
from mission.authoring.language import MissionErrors, digest, parse, to_lines, to_yaml
from mission.authoring.language.manual import PARTS
from mission.authoring.language.schema import schema_text
from mission.engine.readings import Scope
from mission.engine.variables import VARIABLES, Variable
from mission.model import Mission
from mission.model.shipped import load_vehicle
from mission.model.vehicle import STALE_AFTER
from mission.onboard.runtime.records import ListRecorder
from mission.verification.campaign.generated import Writer
from mission.verification.campaign.withheld import missions
from mission.verification.simulation.flight import fly


def read(scope: Scope) -> float | None:
    e = scope.estimate
    return None if e is None or e.depth is None or e.altitude is None else e.depth + e.altitude


SOUNDING = Variable(
    "sounding",
    "m",
    ("depth", "altitude"),
    STALE_AFTER,
    "depth of the water",
    read=read,
    trial="sounding < 1",
    draw=lambda rng, deep: f"sounding < {rng.randint(1, deep)}",
)
VEHICLE = load_vehicle("auv")
HEAD = "mission toy vehicle auv\nhome 30.28 120.15\nsafety radius 400 time 30min depth 20\n"
LEG = "a: heading 0 gear 6 depth 3 until sounding > 8 held 2 timeout 60"


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    with VARIABLES.registered(SOUNDING):
        yield


def test_it_keeps_the_contract_of_variables() -> None:
    keep("variables", SOUNDING)


def mission(leg: str = LEG) -> Mission:
    return parse(f"{HEAD}{leg}\n")


def test_it_is_parsed_from_both_texts_and_written_as_both() -> None:
    made = mission("a: heading 0 gear 6 depth 3 until sounding > 0.8 km sure 90% timeout 60")
    assert parse(to_lines(made)) == parse(to_yaml(made)) == made
    assert "until: sounding > 800 m sure 90%" in to_yaml(made)
    with pytest.raises(MissionErrors, match="did you mean sounding"):
        mission(LEG.replace("sounding", "sonding"))
    with pytest.raises(MissionErrors, match="sounding"):
        mission(f"param sounding 3\n{LEG}")


def test_it_is_listed_in_the_schema_and_in_the_manual() -> None:
    assert "sounding" in schema_text()
    row = "| `sounding` | m | depth of the water | depth, altitude |"
    assert row in PARTS["variables"]()


def test_it_is_checked_against_what_the_vehicle_reports_and_drawn() -> None:
    made = mission()
    chart = compile_mission(made, VEHICLE, digest(made))
    assert check_mission(chart, VEHICLE).ok
    assert "sounding > 8 m" in words.edge(chart.leaving("autonomous/a")[0], None)
    deaf = replace(VEHICLE, reports=VEHICLE.reports - {"altitude"})
    with pytest.raises(MissionErrors, match="sounding can never be known"):
        compile_mission(made, deaf, digest(made))


def test_it_is_flown_recorded_and_replayed_to_the_bit() -> None:
    recorder = ListRecorder()
    flight = fly(mission(), VEHICLE, seed=3, recorder=recorder)
    left = flight.legs[0]
    assert (left.name, left.by) == ("a", "until")
    assert dict(left.seen)["sounding"] > 8.0
    assert replay(recorder.records).identical
    never = fly(mission(LEG.replace("> 8", "> 800")), VEHICLE, seed=3)
    assert never.legs[0].by == "timeout"


def test_it_is_drawn_at_random_and_flown_with_what_it_waits_for_withheld() -> None:
    texts = ["\n".join(Writer(Random(number), "toy", VEHICLE).lines()) for number in range(30)]
    assert any("sounding < " in text for text in texts)
    assert "sounding" in dict(missions())
