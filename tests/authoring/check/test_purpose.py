"""What rows are expected to bring home: refused by row, with what would do, and as flights do."""

from __future__ import annotations

import itertools
import math
import re

import pytest

from links.simulated.settings import parse_settings
from mission.authoring.check import Report
from mission.authoring.check.outlook import MOST, Drift, expected, outlooks
from mission.authoring.check.show import as_object, as_text
from mission.authoring.prepare import check_prepared, prepare, prepare_text
from mission.model.shipped import load_vehicle
from mission.navigation.distribution import radius_95, within
from mission.verification.rehearsing.sea import drawn
from mission.verification.simulation.coverage import coverage_of, is_of
from mission.verification.simulation.flight import fly

AUV = load_vehicle("auv")
TEXT = """mission m vehicle auv
home 30.2874595 120.1535765
safety radius 1500 time 100min depth 12 voltage 10
assume current 0.2
dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90s
learn: surface until fix timeout 5min
mow: rows 4 bearing 90 length 150 spacing 20 from north 60 east 0 within 3 swath 35 gear 8 depth 6
+ {more} timeout 25min
up: surface until fix timeout 3min
"""
FLIGHTS = 6


def report(more: str, text: str = TEXT) -> Report:
    return check_prepared(prepare_text(text.format(more=more), "m"))


def test_a_mission_without_a_purpose_is_judged_as_before() -> None:
    plain = report("")
    assert plain.ok
    assert plain.outlook == ()
    assert as_object(plain)["expected"] == []


def test_rows_that_drift_too_far_are_refused_by_row_with_changes_that_do() -> None:
    (found,) = report("achieve position 50").refusals
    assert found.code == "purpose"
    assert found.where.line == 7
    assert found.message.startswith("rows 3, 4 of mow may end")
    assert "resurface 2 " in found.hint
    assert "spacing" not in found.hint  # which is no cure for that
    assert report("resurface 2 achieve position 50").ok
    assert not report("resurface 3 achieve position 50").ok
    length = found.hint.partition("length ")[2].split()[0]
    shorter = TEXT.replace("length 150", f"length {length}")
    assert report("achieve position 50", shorter).ok


def test_rows_that_leave_strips_unseen_are_refused_with_a_spacing_that_does() -> None:
    wide = TEXT.replace("spacing 20", "spacing 40")
    (found,) = report("resurface 1 achieve coverage 85%", wide).refusals
    assert "expected to cover" in found.message
    spacing = found.hint.partition("spacing ")[2].split()[0]
    nearer = TEXT.replace("spacing 20", f"spacing {spacing}")
    assert report("resurface 1 achieve coverage 85%", nearer).ok


def test_what_no_change_cures_is_told_with_what_can_be_asked_for_and_that_is_enough() -> None:
    asked = re.compile(r"(with resurface 1 )?ask for coverage (\d+)% and position (\d+) m;")
    often = asked.search(report("resurface 1 achieve coverage 99% position 1").refusals[0].hint)
    never = asked.search(report("achieve coverage 99% position 1").refusals[0].hint)
    assert often
    assert never
    assert (often[1], never[1]) == (None, "with resurface 1 ")
    assert often.groups()[1:] == never.groups()[1:]
    coverage, position = int(often[2]), int(often[3])
    assert report(f"resurface 1 achieve coverage {coverage}% position {position}").ok
    assert not report(f"resurface 1 achieve coverage {coverage + 1}%").ok
    assert not report(f"resurface 1 achieve position {position - 1}").ok


def test_no_share_is_refused_as_the_same_that_is_wanted() -> None:
    wide = TEXT.replace("spacing 20", "spacing 40")
    expects = report("resurface 1 achieve coverage 1%", wide).outlook[0].coverage
    assert expects is not None
    (found,) = report(f"resurface 1 achieve coverage {100 * expects + 0.3:.1f}%", wide).refusals
    said, wanted = (float(n) for n in re.findall(r"(\d+\.?\d*)%", found.message)[:2])
    assert said <= 100 * expects < wanted


def test_a_share_of_an_area_needs_a_swath() -> None:
    (found,) = report("achieve coverage 80%", TEXT.replace("swath 35 ", "")).refusals
    assert "says no swath" in found.message


def test_a_purpose_that_nothing_could_achieve_is_refused() -> None:
    text = "\n".join(line for line in TEXT.splitlines() if line[0] not in "m+")
    (found,) = report("", f"achieve coverage 20%\n{text}\n").refusals
    assert found.code == "purpose"
    assert "no rows" in found.message


def plain(out: str, aims: str = "", down: str = "depth 5") -> Report:
    """Of a dive, a leg, and up."""
    lines = [line for line in TEXT.splitlines() if line[0] not in "ml+"]
    lines[-1:] = [aims, f"out: {down} heading 0 gear 6 for 10min {out}", lines[-1]]
    return report("", "mission m vehicle auv\n" + "\n".join(filter(None, lines)) + "\n")


def test_a_leg_without_rows_that_ends_too_far_from_where_it_is_believed_to_is_refused() -> None:
    good = plain("achieve position 500")
    assert good.ok
    (one,) = good.outlook
    assert (one.leg, one.rows, one.coverage) == ("out", False, None)
    assert f"expected of out  position within {one.errors[0]:.0f} m at its end" in as_text(
        "m", good, ""
    )
    (found,) = plain(f"achieve position {one.errors[0] - 1.0:.0f}").refusals
    assert found.code == "purpose"
    assert found.message.startswith("out may end")
    assert "fix" in found.hint


def test_a_mission_without_rows_states_the_position_of_each_leg_but_its_ascents() -> None:
    said = [(one.leg, one.aims) for one in plain("", "achieve position 900").outlook]
    assert said == [("dive", (("position", 900.0),)), ("out", (("position", 900.0),))]


def test_a_leg_that_waits_for_a_fix_is_judged_where_it_ends_and_not_where_it_begins() -> None:
    legs = "out: depth 6 heading 0 gear 6 for 10min\nfix: surface until fix timeout 5min\nmow:"
    prepared = prepare_text(TEXT.replace("{more}", "").replace("mow:", legs), "m")
    _, errors, _ = outlooks(prepared.mission, prepared.vehicle)
    assert errors["fix"] < 10.0 < 50.0 < errors["out"]


def test_a_mission_with_rows_states_what_they_are_flown_for_alone() -> None:
    whole = TEXT.replace("dive:", "achieve position 900\ndive:")
    assert [one.leg for one in report("", whole).outlook] == ["mow"]


@pytest.mark.parametrize(
    "until", ["until travelled >= 40", "until elapsed > 60s", "until depth < 0.5 or elapsed > 60s"]
)
def test_a_leg_counts_for_as_long_as_it_is_meant_to_last(until: str) -> None:
    (soon,), (late,) = (plain(f"{u} achieve position 900").outlook for u in (until, ""))
    assert soon.errors[0] < 0.5 * late.errors[0]


def test_what_may_end_a_leg_at_any_time_makes_it_no_shorter() -> None:
    (one,), (clock,) = (
        plain(f"{u} achieve position 900").outlook
        for u in ("until temperature < 8 and elapsed > 5s", "")
    )
    assert one.errors == clock.errors


def test_fixes_come_along_a_leg_at_the_surface() -> None:
    (below,) = plain("achieve position 900").outlook
    lines = [line for line in TEXT.splitlines() if line[0] not in "mdl+"]
    lines[-1:] = ["out: heading 0 gear 6 for 10min achieve position 900", lines[-1]]
    (above,) = report("", "mission m vehicle auv\n" + "\n".join(lines) + "\n").outlook
    assert above.errors[0] < 0.1 * below.errors[0]


def yoyo(rise: str, cycles: int = 3) -> list[float]:
    """m at the end of each leg of so many dives to 10 m, each brought up as said."""
    lines = TEXT.splitlines()[:4]
    lines[2] = lines[2].replace("depth 12", "depth 15")
    for i in range(cycles):
        lines.append(f"d{i}: depth 10 heading 90 gear 4 until depth >= 9.5 timeout 90s")
        lines.append(f"r{i}: {rise} heading 90 gear 4")
    text = "\n".join([*lines, TEXT.splitlines()[-1], ""])
    errors = outlooks(prepare_text(text, "m").mission, AUV)[1]
    return [errors[f"{leg}{i}"] for i in range(cycles) for leg in "dr"]


@pytest.mark.parametrize(
    "rise",
    [
        "depth 0 until depth < 3 timeout 90s",
        "depth 0 for 20s",
        "depth 0 for 42s",  # just up, and no fix yet
        "depth 2 for 90s",
        "up 0 until depth < 3 timeout 90s",
        "down 0 until depth < 3 timeout 90s",
    ],
)
def test_a_rise_that_ends_below_brings_no_fix_and_takes_its_time(rise: str) -> None:
    errors = yoyo(rise)
    assert all(b > a + 2.0 for a, b in itertools.pairwise(errors))


def test_a_rise_that_has_been_up_for_some_seconds_brings_a_fix() -> None:
    below, above = yoyo("depth 0 for 42s"), yoyo("depth 0 for 46s")
    assert above[2] < below[2] - 2.0
    assert above[4] < above[1] + 2.0


def clocked(until: str, current: float = 0.2) -> float | None:
    """s that a leg is told to need beyond its clock of 240 s, at gear 8 (1 m/s)."""
    lines = TEXT.replace("current 0.2", f"current {current}").splitlines()[:5]
    leg = f"out: {until} gear 8 depth 6 timeout 240 achieve position 900"
    text = "\n".join([*lines, leg, TEXT.splitlines()[-1], ""])
    (one,) = report("", text).outlook
    return one.needs


def test_a_leg_whose_clock_may_end_it_before_its_way_is_done_is_told_so() -> None:
    """95 % of dives make 83.6 % of the speed, less the current."""
    assert clocked("heading 0 until travelled >= 150") is None
    needs = clocked("heading 0 until travelled >= 155")
    assert needs == pytest.approx(155 / 0.6355, rel=1e-3)
    assert clocked("heading 0 until travelled >= 155", current=0.0) is None


def test_so_is_one_that_goes_to_a_place_from_where_the_legs_before_led() -> None:
    near, far = clocked("goto north 150 east 0"), clocked("goto north 200 east 0")
    assert near is None
    assert far is not None
    assert 240.0 < far < 200 / 0.6355  # the dive has led it north already


def test_rows_whose_clock_may_end_them_are_told_one_that_does() -> None:
    """Of parts that resurface each has its share; 95 % of dives make 83.6 % of the speed."""
    for more, rows in (("", 4), ("resurface 2 ", 2), ("resurface 1 ", 1)):
        told = report(f"{more}achieve coverage 1%", TEXT.replace("25min", "10min"))
        (one,) = told.outlook
        assert one.needs is not None
        there = 150 / 0.6355  # straight against the current
        back = 150 / 1.0355 if rows > 1 else there
        over = (4 - 4 / rows) * 20 / 0.6355
        assert 2.0 * (there + back) < one.needs < 2.0 * (there + back) + over + 4 / rows * 170
        clock = f"timeout {math.ceil(one.needs)}s"
        assert f"its clock may end it before: {math.ceil(one.needs)} s would do" in as_text(
            "m", told, "0" * 64
        )
        enough = report(f"{more}achieve coverage 1%", TEXT.replace("timeout 25min", clock))
        assert enough.outlook[0].needs is None


def test_a_leg_that_makes_no_way_against_the_current_is_told_so() -> None:
    slow = TEXT.replace("current 0.2", "current 0.9").splitlines()[:5]
    leg = "out: heading 0 until travelled >= 20 gear 8 depth 6 timeout 240 achieve position 900"
    text = "\n".join([*slow, leg, TEXT.splitlines()[-1], ""])
    told = report("", text)
    assert told.outlook[0].needs == math.inf
    assert "its clock may end it before: it makes no way" in as_text("m", told, "0" * 64)
    assert as_object(told)["expected"][0]["needs_s"] is None


def test_what_may_end_a_leg_but_its_way_is_no_matter_of_its_clock() -> None:
    assert clocked("heading 0 until depth < 2") is None


def test_a_surface_leg_brings_a_fix_only_where_it_waits_for_one() -> None:
    def last(rest: str) -> float:
        lines = TEXT.splitlines()
        legs = ["out: heading 90 gear 6 for 5min", rest, "on: depth 6 heading 90 gear 6 for 60s"]
        text = "\n".join([*lines[:5], *legs, lines[-1], ""])
        return outlooks(prepare_text(text, "m").mission, AUV)[1]["on"]

    known, passed = last("r: surface until fix timeout 4min"), last("r: surface timeout 4min")
    assert passed > 2.0 * known
    assert last("r: surface timeout 4min\nw: wait 20s") < 1.2 * known


def test_a_depth_that_a_leg_is_not_led_to_does_not_end_it() -> None:
    (one,), (clock,) = (
        plain(f"{u} achieve position 900").outlook for u in ("until depth < 2 or depth > 8", "")
    )
    assert one.errors == clock.errors


def test_what_thrusters_led_down_is_at_no_surface_when_they_stop() -> None:
    lines = TEXT.splitlines()
    legs = ["a: down 6 for 20s", "b: up 0 heading 90 gear 4 for 40s"]
    text = "\n".join([*lines[:4], *legs, lines[-1], ""])
    errors = outlooks(prepare_text(text, "m").mission, AUV)[1]
    assert errors["b"] > errors["a"] + 2.0


def test_more_rows_than_can_be_looked_at_are_not_believed() -> None:
    many = TEXT.replace("rows 4", f"rows {MOST + 1}").replace("spacing 20", "spacing 0.5")
    found = report("achieve coverage 10%", many).refusals
    assert any(f.code == "purpose" and str(MOST) in f.message for f in found)


def test_rows_of_every_round_count() -> None:
    rounds = TEXT.replace("mow: ", "repeat 3 g:\nmow: ").replace("up: ", "end\nup: ")
    once = prepare_text(TEXT.format(more="achieve position 900"), "m")
    thrice = prepare_text(rounds.format(more="achieve position 900"), "m")
    alone = expected(once.mission, AUV)["mow"]
    found = expected(thrice.mission, AUV)["g/mow"]
    assert len(found.rows) == 12
    assert found.errors[-1] > 2.0 * alone.errors[-1]  # no fix between the rounds


def test_a_look_at_the_uncertainty_comes_up_only_where_it_is_too_much() -> None:
    def errors(more: str) -> tuple[float, ...]:
        ready = prepare_text(TEXT.format(more=f"{more} achieve position 900"), "m")
        return expected(ready.mission, AUV)["mow"].errors

    assert errors("unsure 1") == pytest.approx(errors("resurface 1"), rel=0.05)
    assert errors("unsure 10000") == pytest.approx(errors(""), rel=0.05)
    assert errors("resurface 1")[-1] < errors("unsure 40")[-1] < errors("")[-1]


def test_the_current_is_learned_from_two_fixes() -> None:
    drift = Drift(AUV, 0.2)
    grown = []
    for _ in range(3):
        drift.go(0.0, 0.5, 200.0)
        grown.append(drift.radius)
        drift.fix()
    assert grown[1] < 0.5 * grown[0]
    assert drift.radius < 1.1 * 2.45 * AUV.sensors.fix


@pytest.mark.parametrize("ratio", [0.01, 0.2, 0.5, 0.8, 1.0])
def test_the_radius_of_an_ellipse_holds_95_of_100(ratio: float) -> None:
    c = (1.0, 0.0, ratio**2)
    assert within(radius_95(c), 0.0, 0.0, c) == pytest.approx(0.95, abs=6e-4)


@pytest.mark.proof
@pytest.mark.parametrize("parameters", [{}, {"row_length": "200", "row_spacing": "25"}])
def test_flights_bring_home_what_the_check_expects(parameters: dict[str, str]) -> None:
    """Truth in seas of the mission's own assumptions: no worse, and not better by far."""
    ready = prepare("lawnmower", None, parameters)
    one = expected(ready.mission, ready.vehicle)["mow/rows"]
    inside, covered, shares = 0, [], []
    for number in range(FLIGHTS):
        sea = parse_settings(drawn(ready.mission, ready.vehicle, 0, number))
        flight = fly(ready.mission, ready.vehicle, seed=number, settings=sea)
        covered.append(coverage_of(flight, ready.mission)[0].true)
        runs = [leg for leg in flight.legs if is_of(leg.name, "mow/rows")]
        ends = [next(s.error for s in reversed(flight.samples) if s.t <= r.left) for r in runs]
        inside += sum(end <= bound for end, bound in zip(ends, one.errors, strict=True))
        shares += [end / bound for end, bound in zip(ends, one.errors, strict=True)]
    assert inside >= 0.9 * len(shares)
    assert math.sqrt(sum(s * s for s in shares) / len(shares)) > 0.25
    assert one.coverage - 0.02 < sum(covered) / FLIGHTS < one.coverage + 0.08
