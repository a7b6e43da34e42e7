"""`auvmission status`: no value without its age, no emergency left out, an exit status by health."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from mission.model.alarms import ALARMS, mask_of
from mission.topside.looking import Looked
from mission.topside.showing import UNTOLD, alarms_in, as_lines, as_object, bearing, contact_of
from protocol.messages import Fix, StateReport, Status, StoreReport, Telemetry

STATE = StateReport(
    "autonomous", "asker", 1, 423, 38, -120, 45, 7, 860, 31, 1.9, 0, "F50%H90S3", "survey/row"
)
STORE = StoreReport("running", 9, 9, "", "0123456789abcdef", "")
FIX = Fix(0.0, math.radians(30.0), math.radians(120.0), math.inf)
SEEN = Status("2025-01-01T00:00:00", FIX, Telemetry(0.0, depth=3.2, heading=1.0))
LOOKED = Looked(SEEN, SEEN, STORE, 0, STATE)


def shown(looked: Looked) -> str:
    return "\n".join(as_lines(looked))


def test_state_leg_setpoint_and_commander_are_told_in_words() -> None:
    told = as_object(LOOKED)
    assert (told["state"], told["leg"], told["commander"]) == ("autonomous", "survey/row", "you")
    assert told["setpoint"] == "ahead 50 %, heading 90 deg, depth 3 m"
    assert told["margins"] == {"depth_m": 7, "radius_m": 860, "time_min": 31, "voltage_v": 1.9}


def test_a_store_that_is_held_is_not_said_to_run_a_mission() -> None:
    """The document's word for it is `running`, also in an emergency without one."""
    assert "store        takes no upload: not idle" in shown(LOOKED)
    assert as_object(LOOKED)["store"] == "running"


def test_every_value_of_the_boards_has_the_age_of_its_report() -> None:
    text = shown(LOOKED)
    assert "depth_m      3.2   1 s ago" in text
    assert "heading_deg  57.3   1 s ago" in text
    assert "OLD" not in text


def test_a_heading_that_is_rounded_up_to_north_is_shown_as_north() -> None:
    own = Telemetry(0.0, heading=math.radians(359.97))
    seen = Status("2025-01-01T00:00:00", None, own)
    assert as_object(Looked(seen, seen, STORE, 0, STATE))["heading_deg"] == 0.0
    assert [bearing(math.radians(a), 0) for a in (0.4, 359.4, 359.5)] == [0.0, 359.0, 0.0]


def test_the_last_fix_is_marked_with_its_age_and_the_estimate_is_beside_it() -> None:
    text, told = shown(LOOKED), as_object(LOOKED)
    assert "LAST FIX, 423 s ago, from before it dived; 3.2 m deep" in text
    assert "within 38 m (95 %), 128 m from the last fix" in text
    assert told["estimate"]["latitude"] == pytest.approx(30.0 - 120 / 110_852, abs=1e-5)
    assert told["estimate"]["longitude"] == pytest.approx(120.0 + 45 / 96_486, abs=1e-5)


def test_time_that_passed_since_the_answer_is_added_to_every_age() -> None:
    slow = replace(LOOKED, waited=20.0)
    assert "depth_m      3.2   21 s ago" in shown(slow)
    assert as_object(slow)["fix_age_s"] == 443.0
    assert alarms_in(slow) == (), "it was new when it was told"


def test_an_old_report_is_said_to_be_old_at_each_of_its_values() -> None:
    old = replace(STATE, report_age=61, alarms=mask_of(["old report"]))
    text = shown(replace(LOOKED, state=old))
    assert "reports      OLD: the last one is 61 s old" in text
    assert "depth_m      3.2   61 s ago   OLD" in text
    assert text.startswith("ALARM old report: the last report of the vehicle's board is 61 s old")
    assert "to depth     7 m   OLD" in text
    assert "to voltage   1.9 V   OLD" in text
    assert "to radius    860 m\n" in text, "the estimate goes on"


@pytest.mark.parametrize(
    "state", ["emergency/stopped", "emergency/surfacing", "emergency/surfaced"]
)
def test_an_emergency_cannot_be_left_out(state: str) -> None:
    looked = replace(LOOKED, state=replace(STATE, state=state, alarms=0))
    assert [alarm.name for alarm in alarms_in(looked)] == ["emergency"]
    assert shown(looked).startswith(f"ALARM emergency: {state}")
    assert f"state        {state}" in shown(looked)


@pytest.mark.parametrize("name", [n for n, row in ALARMS.items() if row.bit is not None])
def test_every_alarm_of_the_vehicle_is_shown_with_what_to_do(name: str) -> None:
    looked = replace(LOOKED, state=replace(STATE, alarms=mask_of([name])))
    assert ALARMS[name].do in shown(looked)
    assert as_object(looked)["alarms"][0]["name"] == name


def test_a_refusal_is_told_in_its_own_words() -> None:
    refused = replace(STORE, refusal="AA: no mission is stored")
    told = replace(STATE, alarms=mask_of(["refused"]))
    assert "ALARM refused: AA: no mission is stored" in shown(
        replace(LOOKED, store=refused, state=told)
    )
    old = replace(LOOKED, store=refused)
    assert alarms_in(old) == (), "the vehicle says that it is over"
    assert "refusal      AA: no mission is stored" in shown(old)


def test_a_vehicle_of_an_older_program_is_said_to_tell_no_state() -> None:
    old = Looked(SEEN, SEEN, STORE, 3)
    assert f"state        {UNTOLD}" in shown(old)
    assert [alarm.name for alarm in alarms_in(old)] == ["old report"]


def test_what_is_not_known_is_not_made_up() -> None:
    bare = replace(STATE, report_age=None, fix_age=None, uncertainty_m=None, north_m=None,
                   east_m=None, to_radius_m=None)  # fmt: skip
    nothing = Status(None, None, Telemetry(0.0))
    text = shown(Looked(nothing, nothing, None, 0, bare))
    assert "none: the vehicle has not been heard" in text
    assert "none: no fix so far" in text
    assert "to radius    not known" in text
    assert "estimate" not in text


def test_the_boat_keeps_the_estimate_and_how_sure_it_is() -> None:
    kept = contact_of(LOOKED, 5.0)
    assert (kept.wall, kept.state) == (5.0, "autonomous")
    assert kept.latitude == as_object(LOOKED)["estimate"]["latitude"]
    assert kept.covariance is not None
    assert math.sqrt(kept.covariance[0]) * 2.4477 == pytest.approx(38.0, abs=0.01)
