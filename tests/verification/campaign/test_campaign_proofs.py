"""What the check proved holds in flight: on shipped and generated missions, and is seen if not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from links.simulated.settings import FaultEvent
from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.commands.campaign import _subject, campaign
from mission.model.shipped import load_vehicle
from mission.verification.campaign.faults import shipped
from mission.verification.campaign.generated import NoneFound, generate
from mission.verification.campaign.proofs import DEPTH, ENERGY, RANGE, TIME, Claim, draw_proof, show
from mission.verification.campaign.trial import FOREVER
from mission.verification.rig.vehicle import flown

pytestmark = pytest.mark.proof  # long: make proofs

VEHICLE = load_vehicle("auv")
MISSIONS, FLIGHTS = 20, 3
SHIPPED = shipped()
LAWNMOWER = next(path for path in SHIPPED if path.stem == "lawnmower")


def known(path: Path) -> Claim:
    found = _subject(path, "auv").known
    assert found is not None
    return found


def claim(number: int) -> Claim:
    if number < len(SHIPPED):
        return known(SHIPPED[number])
    made = generate(0, number, VEHICLE)
    return Claim(f"--generated {number}", made.mission, made.proved)


@pytest.mark.parametrize("number", range(MISSIONS))
def test_no_flight_within_the_assumptions_leaves_what_was_proved(number: int) -> None:
    proved = claim(number)
    for flight in range(FLIGHTS):
        shown = show(proved, VEHICLE, 0, flight)
        assert shown.started, shown
        assert not shown.violations, shown


@pytest.mark.parametrize("vehicle", ["auv-documented", "coreboard", "mainboard"])
def test_no_flight_of_another_vehicle_leaves_what_was_proved_of_a_drawn_mission(
    vehicle: str,
) -> None:
    for number in range(4):
        made = generate(1, number, flown(vehicle))
        assert made.mission.vehicle == vehicle
        of = Claim(f"--generated {number}", made.mission, made.proved)
        for flight in range(FLIGHTS):
            shown = show(of, flown(vehicle), 1, flight)
            assert not shown.violations, shown


def test_legs_with_a_pitch_are_drawn_for_a_vehicle_that_has_one() -> None:
    texts = [generate(2, number, flown("auv-documented")).text for number in range(12)]
    assert any(" pitch " in text for text in texts)
    assert not any(" pitch " in generate(2, number, VEHICLE).text for number in range(12))


def test_what_no_drawn_mission_passes_is_told() -> None:
    with pytest.raises(NoneFound, match="rov holds no heading"):
        generate(0, 3, flown("rov"))


def test_a_generated_mission_is_told_by_its_seed_and_passes_the_check() -> None:
    made = generate(3, 4, VEHICLE)
    assert made.text == generate(3, 4, VEHICLE).text
    assert made.text != generate(4, 4, VEHICLE).text
    mission = parse(made.text)
    assert check_mission(compile_mission(mission, VEHICLE, digest(mission)), VEHICLE).ok


def test_a_flight_stays_within_what_is_assumed() -> None:
    proved = known(LAWNMOWER)
    for flight in range(50):
        sea = draw_proof(proved, VEHICLE, 1, flight).settings.sea
        assert sea.current[0] <= 0.2
        assert sea.floor <= 12.0


def test_a_dive_whose_depth_freezes_stays_above_the_depth_proved_for_that() -> None:
    proved = known(LAWNMOWER)
    drawn = draw_proof(proved, VEHICLE, 5, 1)
    deepest = 0.0
    for begin in (14.0, 17.0, 20.0):
        faults = (FaultEvent("depth_frozen", begin, FOREVER),)
        proof = replace(drawn, settings=replace(drawn.settings, faults=faults), disturbances=())
        shown = show(proved, VEHICLE, 5, 1, lambda *_, proof=proof: proof)
        assert not shown.violations, shown
        deepest = max(deepest, shown.needed.depth)
    assert proved.proved.max_depth < deepest < proved.proved.blind_depth


def test_what_was_proved_too_low_is_found() -> None:
    honest = known(LAWNMOWER)
    low = replace(
        honest.proved,
        worst_time=100.0,
        worst_energy=1e3,
        max_range=20.0,
        max_depth=2.0,
        blind_depth=2.0,
    )
    kinds = {v.kind for v in show(replace(honest, proved=low), VEHICLE, 0, 0).violations}
    assert kinds == {TIME, RANGE, DEPTH, ENERGY}


def test_the_command_ends_with_one_object() -> None:
    done = CliRunner().invoke(campaign, ["--generated", "3", "--flight", "1", "--workers", "1"])
    assert done.exit_code == 0, done.output
    assert "auvmission campaign --generated 3 --seed 0 --flight 1" in done.output
    found = json.loads(done.stdout.splitlines()[-1])
    assert (found["missions"], found["flights"]) == (1, 1)
    assert set(found["violations"].values()) == {0}
