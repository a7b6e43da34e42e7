"""Rows that come up for fixes: their parts, what keeps them from having any, and both texts."""

from __future__ import annotations

import math

import pytest

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse, to_lines, to_yaml
from mission.legs import LEGS, Hold, Rows, Surface
from mission.legs.resurfacing import FIX_S
from mission.legs.rows import corners
from mission.model import Chart
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle

HEAD = "mission m vehicle auv\nhome 30 120\nassume current 0.1\n"
AREA = "rows 5 bearing 90 length 60 spacing 20 from north 30 east 0"
HELD = "gear 6 depth 4 timeout 10min"


def chart(leg: str) -> Chart:
    mission = parse(f"{HEAD}mow: {leg}\nup: surface timeout 3min")
    return compile_mission(mission, load_vehicle("auv"), digest(mission))


def parts(leg: str) -> list[str]:
    return [s.path.removeprefix("autonomous/") for s in chart(leg).states if s.leg][:-2]


def edges(leg: str) -> set[tuple[str, str, str]]:
    return {
        (e.source.removeprefix("autonomous/"), e.by.value, e.target.removeprefix("autonomous/"))
        for e in chart(leg).edges
    }


def test_rows_without_a_rule_are_one_leg() -> None:
    assert parts(f"{AREA} {HELD}") == ["mow"]
    assert parts(f"{AREA} resurface 5 {HELD}") == ["mow"]


def test_a_fix_stands_between_runs_of_so_many_rows_and_never_within_one() -> None:
    assert parts(f"{AREA} resurface 2 {HELD}") == [
        "mow/row1", "mow/fix2", "mow/row3", "mow/fix4", "mow/row5",
    ]  # fmt: skip
    states = {s.path: s.leg for s in chart(f"{AREA} resurface 2 {HELD}").states if s.leg}
    fix = states["autonomous/mow/fix2"]
    assert fix.kind == Surface(until_fix=True, keeps_outputs=True)
    assert fix.timeout == FIX_S


def test_the_runs_fly_the_same_rows_in_the_same_order() -> None:
    made = chart(f"{AREA} resurface 2 {HELD}")
    kinds = [s.leg.kind for s in made.states if s.leg and isinstance(s.leg.kind, Rows)]
    whole = chart(f"{AREA} {HELD}").states[0].leg
    assert whole is not None
    assert isinstance(whole.kind, Rows)
    flown = [point for kind in kinds for point in corners(kind, (30.0, 0.0))]
    assert flown == list(corners(whole.kind, (30.0, 0.0)))


def test_the_clock_of_the_rows_is_shared_by_their_runs() -> None:
    made = chart(f"{AREA} resurface 2 {HELD}")
    clocks = [s.leg.timeout for s in made.states if s.leg and isinstance(s.leg.kind, Rows)]
    assert clocks == [240.0, 240.0, 120.0]


def test_after_each_row_the_uncertainty_decides_whether_it_comes_up() -> None:
    rule = f"{AREA} unsure 15 {HELD}"
    assert parts(rule)[:4] == ["mow/row1", "mow/look1", "mow/fix1", "mow/row2"]
    ways = edges(rule)
    assert ("mow/look1", "until", "mow/row2") in ways
    assert ("mow/look1", "for", "mow/fix1") in ways
    assert ("mow/fix1", "end", "mow/row2") in ways
    look = next(s.leg for s in chart(rule).states if s.path.endswith("look1"))
    assert look is not None
    assert look.kind == Hold()
    assert look.exits[0].guard.expression.variable == "uncertainty"  # type: ignore[union-attr]
    assert look.exits[0].guard.expression.bound == 15.0  # type: ignore[union-attr]


def test_a_look_holds_the_way_of_the_row_before_it() -> None:
    made = chart(f"{AREA} unsure 15 {HELD}")
    looks = [s.setpoint for s in made.states if "/look" in s.path]
    headings = [round(s.heading * 57.29578) for s in looks if s and s.heading is not None]
    assert headings == [90, 270, 90, 270]


def test_a_leg_leads_to_the_rows_by_their_name_and_from_them_onward() -> None:
    rule = f"{AREA} resurface 2 {HELD} else up"
    ways = edges(rule)
    assert ("mow/row1", "timeout", "up") in ways
    assert ("mow/fix2", "timeout", "up") in ways
    assert ("mow/row5", "end", "up") in ways


@pytest.mark.parametrize(
    ("leg", "message"),
    [
        (f"{AREA} resurface 2 unsure 15 {HELD}", "keep one"),
        ("rows 5 bearing 90 length 60 spacing 20 resurface 2 " + HELD, "say with from"),
        (f"{AREA} resurface 2 gear 6 timeout 10min", "depth or altitude"),
        (f"{AREA} resurface 2 depth 4 timeout 10min", "say gear"),
        (f"{AREA} resurface 2 {HELD} until elapsed > 60", "until ... -> NAME"),
        (f"{AREA} resurface 2 {HELD} for 60", "not for"),
        (f"{AREA} resurface 1.5 {HELD}", "whole rows"),
        (f"{AREA} skip 1.5 {HELD}", "whole rows"),
    ],
)
def test_rows_that_cannot_be_parted_are_refused(leg: str, message: str) -> None:
    with pytest.raises(MissionErrors, match=message):
        chart(leg)


@pytest.mark.parametrize("rule", ["resurface 2", "unsure 15"])
@pytest.mark.parametrize(
    ("guard", "instead"),
    [
        ("elapsed > 8min", "mission_time"),
        ("travelled > 300", "mission_time"),
        ("depth > 8 or not travelled < 300", "mission_time"),
        ("temperature falls 3", "within so many s"),
        ("temperature rises 2 within 5 m", "within so many s"),
        ("depth back at highest temperature within 1", "in a leg behind"),
    ],
)
def test_no_guard_of_rows_asks_of_the_leg_what_each_of_their_runs_would_count_anew(
    rule: str, guard: str, instead: str
) -> None:
    way = f"{HELD} until {guard} -> up"
    with pytest.raises(MissionErrors, match=f"mow: .* anew in each run .*{instead}"):
        chart(f"{AREA} {rule} {way}")


@pytest.mark.parametrize(
    "guard", ["elapsed > 8min", "travelled > 300", "temperature falls 3", "mission_time > 600"]
)
def test_rows_in_one_run_may_count_from_the_begin_of_their_leg(guard: str) -> None:
    assert parts(f"{AREA} resurface 5 {HELD} until {guard} -> up") == ["mow"]


@pytest.mark.parametrize(
    "guard", ["mission_time > 600", "depth > 8", "temperature falls 2 within 60 s"]
)
def test_each_run_of_the_rows_has_the_exits_of_the_leg_that_mean_the_same_in_all(
    guard: str,
) -> None:
    ways = edges(f"{AREA} resurface 2 {HELD} until {guard} -> up")
    assert {way for way in ways if way[1] == "until"} == {
        (f"mow/row{row}", "until", "up") for row in (1, 3, 5)
    }


@pytest.mark.parametrize("rule", ["resurface 2", "unsure 15", "swath 25 skip 1", ""])
def test_both_texts_say_the_rule_and_nothing_where_there_is_none(rule: str) -> None:
    mission = parse(f"{HEAD}mow: {AREA} {rule} {HELD}")
    lines = to_lines(mission)
    assert digest(parse(lines)) == digest(parse(to_yaml(mission))) == digest(mission)
    for word in ("resurface", "unsure", "swath", "skip"):
        assert (f" {word} " in lines) is (word in rule.split())


def test_rows_that_are_skipped_are_those_that_were_flown() -> None:
    whole, rest = (Rows(None, 0.5, 60.0, 20.0, n, -1, 5.0, skip=s) for n, s in ((4, 0.0), (2, 2.0)))
    assert corners(rest, (1.0, 2.0)) == corners(whole, (1.0, 2.0))[4:]


@pytest.mark.parametrize("skip", [0.0, 1.0, 10.0])
def test_rows_from_where_it_is_lead_no_farther_than_the_check_takes_them_to(skip: float) -> None:
    rows = Rows(None, 0.5, 60.0, 20.0, 3, 1, 5.0, skip=skip)
    far = max(math.hypot(*corner) for corner in corners(rows, (0.0, 0.0)))
    assert LEGS[Rows].room(rows) == pytest.approx(far)
