"""`auvmission status` never shows an old position or an old report as if it were new."""

from __future__ import annotations

import itertools

import pytest

from mission.onboard.serve import health
from mission.topside.looking import LOOKS, Looked, look
from mission.topside.upload import NoAnswer
from protocol.messages import DataQuery, Fix, Status, StoreReport, Telemetry

STORE = StoreReport("ready", 3, 3, "", "0123456789abcdef", "")


def told(second: int, place: float | None = None, depth: float | None = 0.1) -> Status:
    fix = None if place is None else Fix(0.0, place, 2.0, 1.0)
    return Status(f"2025-01-01T00:00:{second:02}", fix, Telemetry(0.0, depth=depth))


def looked(*reports: Status, under_water: bool = False) -> tuple[Looked, int]:
    """What is shown, and how often it was asked for; the last of the reports stays."""
    coming, found, asked = itertools.chain(reports, itertools.repeat(reports[-1])), [], 0
    talk = look(found.append, under_water=under_water)
    ask = next(talk)
    try:
        while True:
            is_status = isinstance(ask.command, DataQuery)
            asked += is_status
            answer = next(coming) if is_status else STORE
            ask = talk.send(answer if ask.fits(answer) else None)
    except StopIteration:
        return found[0], asked


def test_what_changes_is_new_and_no_longer_waited_for() -> None:
    found, asked = looked(told(0, 1.0), told(2, 1.1), told(4, 1.2))
    assert (found.reports, found.position, asked) == ("new", "new", 2)
    assert found.last.fix is not None
    assert found.last.fix.latitude == 1.1, "the newest is shown"


def test_a_report_that_does_not_change_is_old() -> None:
    found, asked = looked(told(0, 1.0))
    assert asked == 1 + LOOKS
    assert found.reports == "OLD: none has come for 3 s; all of it is of that time"
    assert found.position == "LAST FIX: none has come for 3 s"


def test_a_fix_that_stays_while_reports_come_is_the_last_one() -> None:
    found, asked = looked(*(told(second, 1.0) for second in range(9)))
    assert (found.reports, asked) == ("new", 1 + LOOKS)
    assert found.position == "LAST FIX: none has come for 3 s"


@pytest.mark.parametrize("under_water", [False, True])
def test_a_position_of_a_vehicle_that_has_dived_is_from_before(under_water: bool) -> None:
    reports = [told(second, 1.0, depth=4.2) for second in (0, 2)]
    found, _ = looked(*reports, under_water=under_water)
    assert found.position == "LAST FIX, from before it dived; 4.2 m deep"


def test_by_modem_it_is_asked_for_once_and_called_of_unknown_age() -> None:
    found, asked = looked(told(0, 1.0), under_water=True)
    assert asked == 1
    assert "not known" in found.reports
    assert "not known" in found.position


def test_what_was_never_there_is_none() -> None:
    found, _ = looked(*(told(second, None, None) for second in range(9)))
    assert found.reports == "none: the vehicle has not been heard"
    assert found.position == "none: no fix so far"


def test_no_answer_is_said() -> None:
    talk = look(lambda _: None)
    next(talk)
    talk.send(None)  # to @AE: an older vehicle does not
    with pytest.raises(NoAnswer):
        talk.send(None)


@pytest.mark.parametrize(
    ("value", "age", "why", "shown"),
    [
        (3.2, 0.4, "", "3.20 m, 0 s ago"),
        (3.2, None, "", "3.20 m"),
        (3.2, 61.4, "stale", "STALE, 61 s old: last 3.20 m"),
        (None, None, "missing", "MISSING"),
        (None, 9.0, "stale", "STALE, 9 s old"),
    ],
)
def test_on_the_pi_a_value_that_is_not_believed_has_its_age_before_it(
    value: float | None, age: float | None, why: str, shown: str
) -> None:
    sensor = {"value": value, "unit": "m", "age_s": age, "why": why}
    assert health.sensed(sensor) == shown
