"""What @AR says of a refusal is never old and shown as new."""

from __future__ import annotations

import math

import pytest

from mission.onboard.runtime.refusals import DOUBT_S, NEW_S, UNOBEYED, Refusals

NEVER = -math.inf


def refused(code: str = "AA") -> Refusals:
    made = Refusals()
    made.note(code, "no mission is stored", 10.0)
    return made


def test_a_refusal_is_told_as_it_is_and_later_with_its_age() -> None:
    one = refused()
    assert one.told(10.0 + NEW_S - 0.1, NEVER) == "AA: no mission is stored"
    assert one.told(45.0, NEVER) == "AA: no mission is stored; 35 s ago"
    assert one.told(10.0 + 600.0, NEVER) == "AA: no mission is stored; 10 min ago"
    assert one.told(10.0 + 3.0 * 3600.0, NEVER) == "AA: no mission is stored; 3 h ago"
    assert Refusals().told(45.0, NEVER) == ""


def test_its_age_is_never_cut_off() -> None:
    one = Refusals()
    one.note("AA", "x" * 400, 0.0)
    assert len(one.told(0.0, NEVER)) == 200
    assert len(one.told(45.0, NEVER)) == 200
    assert one.told(45.0, NEVER).endswith("x; 45 s ago")


@pytest.mark.parametrize(
    ("code", "accepted", "ends"),
    [
        ("AA", "AA", True), ("SP", "SP", True), ("SP", "AA", True), ("ST", "AC", True),
        ("AA", "SP", False), ("AA", "manual", False), ("AW", "AW", False), ("AW", "AA", True),
    ],
)  # fmt: skip
def test_it_ends_when_the_same_is_accepted_or_with_the_mission(
    code: str, accepted: str, ends: bool
) -> None:
    one = refused(code)
    one.accepted(accepted)
    assert (one.told(10.0, NEVER) == "") is ends


def test_a_stop_that_is_not_obeyed_stands_before_all_refusals() -> None:
    one = refused()
    assert one.told(20.0, 20.0 - DOUBT_S) == UNOBEYED
    assert one.told(20.1, 20.0 - DOUBT_S).startswith("AA: ")
