"""Scenes and broken rules on the boards of documents 002 to 004, and on the Pi as 002's main board."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Mapping
from pathlib import Path

import pytest
from known_missions import known_on
from programs import run

from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest
from mission.commands.options import tell_confirmed
from mission.model.shipped import load_vehicle
from mission.verification.campaign.broken import BROKEN, broken
from mission.verification.campaign.draw import Plan, stage
from mission.verification.campaign.faults import fly_plan, result_of
from mission.verification.campaign.reports import EVERY_S, reports
from mission.verification.campaign.scene_texts import ON_BOARDS, mission_of, texts_of
from mission.verification.campaign.scenes import ON_BOARDS_ALONE, SCENES
from mission.verification.campaign.staging import faults_of, not_staged, scenes_of
from mission.verification.campaign.steered import plan_of
from mission.verification.campaign.unseen import UNSEEN, unseen
from mission.verification.rig.speech import Speech
from mission.verification.rig.trace import Heard
from mission.verification.rig.vehicle import flown
from protocol.messages import UPWARD, Order, Setpoint
from protocol.tolerances import Tolerances
from protocol.vehicles import rov

NAMES = tuple(ON_BOARDS)
SEED = 12
UNTOLD = ("not flown", "not noticed")
HERE = Path(__file__).resolve().parent
TABLE = HERE.parents[2] / "docs" / "quality.md"
# By vehicle and rule: the flight of SEED that notices, and by which law.
NOTICED: Mapping[str, Mapping[str, tuple[str, str, str]]] = json.loads(
    (HERE / "noticed_on_boards.json").read_text()
)


@pytest.mark.parametrize("name", NAMES)
def test_every_scene_is_staged_on_a_board_or_has_the_reason_why_it_is_not(name: str) -> None:
    assert set(scenes_of(name)) | set(not_staged(name)) == {*SCENES, *ON_BOARDS_ALONE}
    assert not set(scenes_of(name)) & set(not_staged(name))
    assert all(reason.strip() for reason in not_staged(name).values())
    with pytest.raises(KeyError, match="is not staged on"):
        stage(next(iter(not_staged(name))), 0, name)


def test_the_auv_flies_every_scene_and_no_leak_which_it_does_not_report() -> None:
    assert scenes_of("auv") == tuple(SCENES)


@pytest.mark.parametrize("name", NAMES)
def test_what_a_scene_brings_to_a_board_is_what_it_can_have(name: str) -> None:
    for scene in scenes_of(name):
        for seed in range(12):
            plan = stage(scene, seed, name)
            assert {event.name for event in plan.settings.faults} <= set(faults_of(name))
            assert plan.vehicle.name == name
            assert plan.subject.mission.vehicle == name


@pytest.mark.parametrize("name", NAMES)
def test_the_missions_of_scenes_pass_the_check_of_each_vehicle(name: str) -> None:
    vehicle = flown(name)
    used = {
        stage(scene, seed, name).subject.mission.name
        for scene in scenes_of(name)
        for seed in range(9)
    }
    assert used == set(texts_of(name))
    for text in texts_of(name):
        mission = mission_of(text, name)
        assert check_mission(compile_mission(mission, vehicle, digest(mission)), vehicle).ok


def test_a_stick_on_land_says_ahead_and_back() -> None:
    said = [d.data for d in stage("held_stick", 3, "robot").disturbances]
    assert b"@MMB6$" in said
    assert not [data for data in said if data[:4] in (b"@MMD", b"@MMU")]


# --- reports ---------------------------------------------------------------------------------------


def test_of_a_board_a_report_counts_every_two_seconds_with_its_thrusters() -> None:
    values = {
        **dict.fromkeys(("ax_g", "ay_g", "gx_dps", "gy_dps", "gz_dps", "ex_deg", "ey_deg"), 0.0),
        **dict.fromkeys((f"rpm_{name}" for name in rov.THRUSTERS), 0),
        "az_g": -1.0,
        "ez_deg": -90.0,
        "depth_m": 3.0,
        "temperature_c": 18,
        "metal_pct": 0,
    }
    up = rov.up(Tolerances())
    frame = up.encode(values | {"rpm_left_front": 500})
    heard = [Heard(0.05 * i, frame) for i in range(1, 121)]
    found = list(reports(heard, load_vehicle("rov")))
    assert len(found) == 6.0 / EVERY_S
    assert [r.depth for r in found] == [pytest.approx(3.0)] * 3
    assert all(r.turning for r in found)
    assert found[0].yaw == pytest.approx(90.0, abs=0.1), "to port, as the AUV's"
    still = list(reports([Heard(1.0, up.encode(values))], load_vehicle("rov")))
    assert [(r.turning, r.may_turn) for r in still] == [(False, False)]


# --- the main board --------------------------------------------------------------------------------


def test_a_part_of_several_words_is_none_of_them_on_the_bus() -> None:
    speech = Speech(flown("mainboard"))
    force, torque, sensors = speech.board.encode(UPWARD)
    assert [speech.word(frame) for frame in (force, torque, sensors)] == [b"@ZAU12$", b"", b""]
    force, torque, _ = speech.board.encode(Order.STOP)
    assert [speech.word(frame) for frame in (force, torque)] == [b"@ZAX0$", b""]
    assert speech.word(speech.board.encode(Setpoint(surge=0.5))[0]) == b""


def test_campaigns_fly_the_main_board_with_confirmed_signs_and_say_so() -> None:
    shipped, ours = load_vehicle("mainboard").outer_loop, flown("mainboard").outer_loop
    assert shipped is not None
    assert ours is not None
    assert (shipped.confirmed, bool(ours.confirmed)) == ("", True)
    assert flown("rov") == load_vehicle("rov"), "as shipped"
    assert {subject.path.stem for subject in known_on("mainboard")} >= {"first-dive", "lawnmower"}


# --- broken rules ----------------------------------------------------------------------------------


def judged(plan: Plan) -> set[tuple[str, str]]:
    vehicle = plan.vehicle
    result = result_of(plan, fly_plan(plan, vehicle), vehicle, plan.profile)
    return {(violation.kind, violation.says) for violation in result.violations}


@functools.cache
def whole(name: str, flight: str) -> set[tuple[str, str]]:
    return judged(plan_of(flight, SEED, known_on(name)))


def test_no_rule_that_a_flight_noticed_has_a_reason_why_none_can() -> None:
    assert set(UNSEEN) == set(NAMES) == set(NOTICED)
    for name in NAMES:
        assert {*NOTICED[name], *UNSEEN[name]} <= set(BROKEN)
        assert not set(NOTICED[name]) & set(UNSEEN[name])
        flights = {flight for flight, _, _ in NOTICED[name].values()}
        assert {flight.partition("/")[0] for flight in flights} <= set(scenes_of(name))
    assert {*NOTICED["robot"], *UNSEEN["robot"]} == set(BROKEN), "all have been flown"


def test_the_table_by_vehicle_says_what_was_flown() -> None:
    told = TABLE.read_text().partition("<!-- begin boards -->")[2].partition("<!-- end boards")[0]
    found = [[cell.strip() for cell in line.split("|")[1:-1]] for line in told.splitlines()]
    rows = {row[0]: row[1:] for row in found[3:] if len(row) == 1 + len(NAMES)}
    reasons = {f"no ({number})": why for number, why in re.findall(r"^(\d+)\. (.+)$", told, re.M)}
    assert set(rows) == set(BROKEN)
    for rule, cells in rows.items():
        for name, cell in zip(NAMES, cells, strict=True):
            said = NOTICED[name].get(rule, (unseen(rule, name),))[0]
            told = reasons.get(cell, cell)
            assert told == said or (not said and told in UNTOLD), (rule, name)


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "every", [0, *(pytest.param(n, marks=pytest.mark.minutes) for n in range(1, 6))]
)
def test_a_flight_on_a_board_tells_a_rule_from_its_absence_by_its_law(
    name: str, every: int
) -> None:
    """A third of them, six times an eighteenth."""
    for rule, (flight, kind, says) in list(NOTICED[name].items())[every * 3 :: 18]:
        assert whole(name, flight) == set()
        with broken(rule):
            found = judged(plan_of(flight, SEED, known_on(name)))
        assert any(k == kind and words.splitlines()[-1] == says for k, words in found), (
            rule,
            found,
        )


@pytest.mark.proof
def test_the_command_breaks_a_rule_on_a_board_and_says_who_notices() -> None:
    words = ("faults", "--vehicle", "robot", "--seed", str(SEED), "--search", "--broken")
    ran = run(*words, "limit time", "--flights", "24", "--json")
    assert ran.exit_code == 0, ran.output
    told = json.loads(ran.stdout.splitlines()[-1])
    assert (told["rules"], told["noticed"], told["blind"]) == (1, 1, [])
    ran = run(*words, "limit leak", "--flights", "1")
    assert ran.exit_code == 0
    assert unseen("limit leak", "robot") in ran.stdout


def test_the_main_board_is_said_to_be_flown_with_confirmed_signs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    tell_confirmed("mainboard")
    assert "outer_loop: {confirmed: 20" in capsys.readouterr().err
    tell_confirmed("rov")
    assert capsys.readouterr().err == ""
