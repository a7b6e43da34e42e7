"""Every alarm is one row; it comes when it should, says what to do, and goes."""

from __future__ import annotations

import math

import pytest

from mission.model.alarms import (
    AFLOAT_S,
    ALARMS,
    CLOCK_S,
    DANGER,
    FREE_B,
    REFUSED_S,
    RUNS_OUT_S,
    UNPROVED_S,
    UNSENT_S,
    AlarmRow,
    Condition,
    ago,
    alarms_of,
    mask_of,
    standing,
)

RAISED = [
    ("emergency", Condition(state="emergency/stopped", reason="X"), "emergency/stopped (X)"),
    ("limit", Condition(breached={"leak": "water inside"}), "water inside"),
    ("stop not obeyed", Condition(unobeyed=True), "way after the stop"),
    ("old report", Condition(report_age=5.1), "5 s old"),
    ("old report", Condition(report_age=math.inf), "never been heard"),
    ("no fix", Condition(afloat_without_fix=AFLOAT_S), "no fix for 60 s"),
    ("refused", Condition(refusal="AA: no", refusal_age=REFUSED_S), "AA: no (120 s ago)"),
    ("battery", Condition(battery_runs_out=RUNS_OUT_S), "in 15 min"),
    ("link away", Condition(closed=("vehicle", "gps")), "vehicle, gps"),
    ("NOT SENT", Condition(unsent_age=UNSENT_S), "60 s ago"),
    ("disk", Condition(disk_free=FREE_B - 1), "1000 MB"),
    ("black box", Condition(recording="no space"), "no space"),
    ("clock", Condition(clock_off=-CLOCK_S - 1), "31 s behind"),
    ("broken", Condition(broken=("serve.yaml",)), "serve.yaml"),
    ("receiver", Condition(receivers="the second counts"), "the second counts"),
    ("surface unproved", Condition(unproved=UNPROVED_S), "up for 120 s"),
    ("no contact", Condition(silent=130.0), "2 min ago"),
    ("OVERDUE", Condition(overdue="since 3"), "since 3"),
]
NOT_YET = [
    Condition(),
    Condition(state="autonomous/a"),
    Condition(unproved=UNPROVED_S - 0.1),
    Condition(report_age=5.0),
    Condition(report_age=9.0, reports_within=10.0),
    Condition(afloat_without_fix=AFLOAT_S - 0.1),
    Condition(refusal="AA: no", refusal_age=REFUSED_S + 0.1),
    Condition(battery_runs_out=RUNS_OUT_S + 0.1),
    Condition(unsent_age=UNSENT_S + 0.1),
    Condition(disk_free=FREE_B),
    Condition(clock_off=CLOCK_S),
]


@pytest.mark.parametrize(("name", "condition", "words"), RAISED)
def test_an_alarm_stands_with_words_and_with_what_to_do(
    name: str, condition: Condition, words: str
) -> None:
    (alarm,) = standing(condition)
    assert alarm.name == name
    assert words in alarm.words
    assert alarm.do in str(alarm)
    assert alarm.do


def test_a_refusal_that_tells_its_age_is_not_given_a_second_one() -> None:
    (alarm,) = standing(Condition(refusal="AA: no; 5 s ago", refusal_age=0.0))
    assert alarm.words == "AA: no; 5 s ago"


def test_every_row_is_tried() -> None:
    assert {name for name, _, _ in RAISED} == set(ALARMS)


@pytest.mark.parametrize("condition", NOT_YET)
def test_what_is_well_raises_none(condition: Condition) -> None:
    assert standing(condition) == ()


def test_bits_are_those_of_the_first_version_for_ever() -> None:
    """A boat may be older than its vehicle."""
    assert {row.name: row.bit for row in ALARMS.values() if row.bit is not None} == {
        "emergency": 0, "limit": 1, "stop not obeyed": 2, "old report": 3, "no fix": 4, "refused": 5,
        "battery": 6, "link away": 7, "NOT SENT": 8, "disk": 9, "black box": 10, "clock": 11,
        "broken": 12, "receiver": 13, "surface unproved": 14,
    }  # fmt: skip


@pytest.mark.parametrize("name", [n for n, row in ALARMS.items() if row.bit is not None])
def test_a_mask_carries_each_by_name(name: str) -> None:
    (alarm,) = alarms_of(mask_of([name]))
    assert (alarm.name, alarm.level, alarm.do) == (name, ALARMS[name].level, ALARMS[name].do)


def test_an_alarm_of_a_newer_vehicle_is_not_left_out() -> None:
    (alarm,) = alarms_of(1 << 15)
    assert (alarm.name, alarm.level) == ("alarm 15", DANGER)


def test_what_the_boat_alone_knows_is_in_no_mask() -> None:
    assert mask_of(["OVERDUE", "no contact"]) == 0


def test_a_new_alarm_is_one_row_and_a_bit_is_given_once() -> None:
    row = AlarmRow("hungry", 15, DANGER, "feed it", lambda c: "always")
    with ALARMS.registered(row):
        assert [alarm.name for alarm in standing(Condition())] == ["hungry"]
        assert alarms_of(1 << 15)[0].do == "feed it"
    for bit, why in ((0, "emergency has bit 0"), (16, "bits 0 to 15")):
        with pytest.raises(ValueError, match=why):
            ALARMS.register(AlarmRow("other", bit, DANGER, "", lambda c: ""))


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(math.inf, "never"), (3.4, "3 s ago"), (600.0, "10 min ago"), (9000.0, "2.5 h ago")],
)
def test_an_age_is_told_in_words(seconds: float, words: str) -> None:
    assert ago(seconds) == words
