"""@AE: the whole state of a vehicle in 64 bytes, whatever it is (R4)."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.codec import CannotEncode
from protocol.messages import FrameFault, Order, Setpoint, StateReport
from protocol.state_frame import (
    COMMANDERS,
    CUT,
    MOST,
    NUMBERS,
    STATES,
    setpoint_text,
    setpoint_words,
)
from protocol.topside import ConsoleCodec, encode

PLAIN = StateReport(
    "autonomous", "asker", 1, 423, 38, -120, 45, 7, 860, 31, 1.9, 0, "F50%H90S3", "row"
)
LEGS = st.text("abcdefghij_", min_size=1, max_size=12)
VALUES = st.none() | st.floats(-1e7, 1e7) | st.just(math.inf)


@st.composite
def reports(draw: st.DrawFn) -> StateReport:
    numbers = {item.name: draw(VALUES) for item in NUMBERS}
    return StateReport(
        state=draw(st.sampled_from(sorted(STATES.values()))),
        commander=draw(st.sampled_from(sorted(COMMANDERS.values()))),
        **numbers,
        alarms=draw(st.integers(0, 0xFFFF)),
        setpoint=draw(st.sampled_from(["", "X", "F50%H90S3", "F100%R100%H359.9P-12.5O-12.5S99.9"])),
        leg="/".join(draw(st.lists(LEGS, max_size=4))),
    )


def read(raw: bytes) -> StateReport:
    (answer,) = ConsoleCodec().receive(raw, 0.0)
    assert isinstance(answer, StateReport)
    return answer


@pytest.mark.proof
@settings(max_examples=300, deadline=None)
@given(report=reports())
def test_any_state_fits_into_64_bytes_and_state_ages_and_alarms_are_never_cut(
    report: StateReport,
) -> None:
    raw = encode(report)
    assert len(raw) <= MOST
    told = read(raw)
    assert (told.state, told.commander, told.alarms) == (
        report.state,
        report.commander,
        report.alarms,
    )
    for item in NUMBERS:
        meant, carried = getattr(report, item.name), getattr(told, item.name)
        if meant is None:
            assert carried is None
        else:
            assert carried == pytest.approx(min(max(meant, item.low), item.high), abs=0.5)
    assert told.setpoint in (report.setpoint, CUT, "")
    whole = [report.leg, report.leg.rpartition("/")[2]]
    assert told.leg in (*whole, "") or whole[1].startswith(told.leg.removesuffix(CUT))


def test_the_name_of_the_leg_outlasts_its_groups() -> None:
    assert read(encode(replace(PLAIN, leg="survey/lines/row"))).leg == "row"
    assert read(encode(replace(PLAIN, leg="a_leg_with_a_name_that_is_long"))).leg.endswith(CUT)


@pytest.mark.parametrize(
    ("raw", "kind"),
    [
        (b"@AE,2,AU,Y,1,423,38,-120,45,7,860,31,1.9,0,X,row,$", "bad_enum"),
        (b"@AE,1,AX,Y,1,423,38,-120,45,7,860,31,1.9,0,X,row,$", "bad_enum"),
        (b"@AE,1,AU,Y,1,423,38,-120,45,7,860,31,1.9,g,X,row,$", "non_numeric"),
        (b"@AE,1,AU,Y,1,x,38,-120,45,7,860,31,1.9,0,X,row,$", "non_numeric"),
        (b"@AE,1,AU,Y,-1,423,38,-120,45,7,860,31,1.9,0,X,row,$", "out_of_range"),
        (b"@AE,1,AU,Y,1,423,38,-120,45,7,860,31,1.9,0,X,$", "field_count"),
    ],
)
def test_what_is_no_state_is_a_fault(raw: bytes, kind: str) -> None:
    fault, _ = ConsoleCodec().receive(raw + encode(PLAIN), 0.0)
    assert isinstance(fault, FrameFault)
    assert fault.kind == kind


@pytest.mark.parametrize(
    ("report", "why"),
    [
        (replace(PLAIN, state="asleep"), "no state"),
        (replace(PLAIN, commander="anybody"), "no commander"),
        (replace(PLAIN, leg="a,b"), "leg is text"),
        (replace(PLAIN, setpoint="F5$"), "setpoint is text"),
    ],
)
def test_what_no_vehicle_is_in_is_not_sent(report: StateReport, why: str) -> None:
    with pytest.raises(CannotEncode, match=why):
        encode(report)


@pytest.mark.parametrize(
    ("command", "text", "words"),
    [
        (None, "", ""),
        (Order.STOP, "X", "everything stopped"),
        (Order.SURFACE, "W", "emergency surfacing"),
        (Setpoint(), "X", "everything stopped"),
        (
            Setpoint(surge=0.5, heading=math.radians(90), depth=3.5),
            "F50%H90S3.5",
            "ahead 50 %, heading 90 deg, depth 3.5 m",
        ),
        (
            Setpoint(surge=-0.25, turn=-1.0, heave=1.0),
            "B25%L100%D100%",
            "astern 25 %, to port 100 %, down 100 %",
        ),
        (Setpoint(heave=-1.0), "U100%", "up 100 %"),
        (Setpoint(altitude=2.0, pitch=math.radians(-10)), "P-10E2", "pitch -10 deg, altitude 2 m"),
    ],
)
def test_a_setpoint_is_told_in_letters_and_read_in_words(
    command: Setpoint | Order | None, text: str, words: str
) -> None:
    assert setpoint_text(command) == text
    assert setpoint_words(text) == words
