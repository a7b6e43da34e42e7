"""Laws of the check: what it refuses, what it bounds, and that the bounds are those of the text."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.authoring.check import Report, check_mission
from mission.authoring.check.assumptions import FROZEN, LATE, STICKS
from mission.authoring.check.show import as_text
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.authoring.prepare import check_prepared, prepare
from mission.cli import main
from mission.model.shipped import load_vehicle

ROOT = Path(__file__).resolve().parents[3]
VEHICLE = load_vehicle("auv")
LEANS = load_vehicle("auv-documented")  # it holds a pitch

HEAD = (
    "mission m vehicle auv\nhome 30.2874595 120.1535765\nsafety radius 1000 time 60min depth 30\n"
)


def report(body: str, head: str = HEAD) -> Report:
    mission = parse(head + body)
    return check_mission(compile_mission(mission, VEHICLE, digest(mission)), VEHICLE)


def rules(found: Report) -> list[str]:
    return [r.code for r in found.refusals]


def test_a_plain_mission_is_proved() -> None:
    found = report(
        "down: ZAS10 ZAH0 ZAF4 until depth >= 9 timeout 2min\nalong: heading 90 ZAF6 for 60s\n"
    )
    assert found.ok
    assert found.proved is not None
    # 120 s, 60 s, and the ascent from 10 m and 1 m of overshoot: 20 s of tries, 11 / 0.25, 8 s
    assert found.proved.worst_time == pytest.approx(120 + 60 + 20 + 44 + 8)
    assert found.proved.max_depth == pytest.approx(11.0)


def test_rows_from_where_they_are_entered_reach_as_far_in_truth_as_any_by_an_estimate() -> None:
    """The boat may be 20 % faster than its file says, and its compass off: 1275 m were flown."""
    head = HEAD.replace("radius 1000", "radius 2000") + "assume current 0 start 5\n"
    row = "a: rows 1 bearing 0 length 1000 spacing 10{} gear 8 depth 4 timeout 30min\nup: surface until fix timeout 5min\n"
    here, home = (report(row.format(f), head).proved for f in ("", " from north 0 east 0"))
    assert here is not None
    assert home is not None
    assert here.max_range > 1275.5
    assert home.max_range < here.max_range < 1.1 * home.max_range


def test_the_worst_time_takes_every_round_and_every_timeout() -> None:
    body = "repeat 3 box:\n a: heading 0 ZAF2 until travelled >= 5 timeout 40s\n b: heading 180 ZAF2 for 10s\nend\n"
    one = report(body.replace("repeat 3", "repeat 1")).proved
    three = report(body).proved
    assert one is not None
    assert three is not None
    assert three.worst_time - one.worst_time == pytest.approx(2 * 50)


def test_a_guard_on_the_clock_shortens_the_worst_case() -> None:
    slow = report("a: ZAF2 heading 0 until altitude < 3 timeout 5min\n").proved
    fast = report("a: ZAF2 heading 0 until altitude < 3 or elapsed > 30s timeout 5min\n").proved
    assert slow is not None
    assert fast is not None
    assert slow.worst_time - fast.worst_time == pytest.approx(270)


def test_a_mission_longer_than_its_safety_time_is_refused_with_its_path() -> None:
    found = report("repeat 40 r:\n a: heading 0 ZAF2 for 60s\n b: heading 180 ZAF2 for 60s\nend\n")
    assert "time" in rules(found)
    refusal = next(r for r in found.refusals if r.code == "time")
    assert any("r/a" in step for step in refusal.path)
    assert any("more" in step for step in refusal.path)


@pytest.mark.parametrize(
    "leg",
    [
        "goto 31 121",
        "follow north 0 east 10, 31 121",
        "rows 2 bearing 0 length 50 spacing 10 from 31 121",
        "loiter 31 121 radius 20",
    ],
)
def test_a_latitude_without_a_home_to_measure_it_from_is_refused(leg: str) -> None:
    head = "mission m vehicle auv\nsafety radius 300 time 30min depth 10\n"
    body = f"go: {leg} gear 8 depth 3 timeout 5min\n"
    found = report(body, head)
    assert rules(found) == ["no-home"]
    assert found.proved is None
    assert found.refusals[0].where.line == 3
    assert "no-home" not in rules(report(body))
    assert report(body.replace("31 121", "north 10 east 5"), head).ok


def test_a_swept_path_beyond_the_radius_is_refused_at_the_leg_that_leaves_it() -> None:
    found = report("near: heading 0 ZAF6 for 60s\nfar: heading 0 ZAF8 for 20min\n")
    refusal = next(r for r in found.refusals if r.code == "radius")
    assert refusal.where.line in (5, 4)
    assert "1000 m" in refusal.message


def test_out_and_back_is_nearer_than_out_and_out() -> None:
    out = "a: heading 0 ZAF6 for 5min\n"
    back = report(out + "b: heading 180 ZAF6 for 5min\nc: stop for 1min\n").proved
    on = report(out + "b: heading 0 ZAF6 for 5min\nc: stop for 1min\n").proved
    assert back is not None
    assert on is not None
    assert on.max_range > back.max_range + 100


def test_more_current_widens_the_range_and_is_said() -> None:
    body = "a: heading 0 ZAF4 for 5min\n"
    calm = report(body, HEAD + "assume current 0\n")
    strong = report(body, HEAD + "assume current 0.5\n")
    assert calm.proved is not None
    assert strong.proved is not None
    assert strong.proved.max_range - calm.proved.max_range == pytest.approx(
        0.5 * (300 + 28), rel=0.1
    )
    assert any("0.5 m/s (the mission)" in line for line in strong.assumed)


def test_a_depth_beyond_the_safety_depth_is_refused() -> None:
    found = report("a: ZAS40 ZAF4 heading 0 for 4min\n")
    assert rules(found) == ["depth"]
    assert "30 m" in found.refusals[0].message


@pytest.mark.parametrize(
    ("legs", "deepest"),
    [("y: yoyo 1 shallow 2 deep 8 heading 0 gear 4 timeout 4min", 9.0),
     ("d: depth 3 heading 0 gear 4 for 60s\n    b: altitude 5 heading 0 gear 4 for 60s", 11.0),
     ("d: depth 8 heading 0 gear 4 for 60s", 9.0)],
)  # fmt: skip
def test_a_round_more_is_no_deeper(legs: str, deepest: float) -> None:
    for rounds in (1, 6):
        body = f"repeat {rounds} rows:\n    {legs}\nend\nup: surface timeout 3min\n"
        found = report("assume floor 15\n" + body).proved
        assert found is not None
        assert found.max_depth == pytest.approx(deepest)


def test_a_dive_by_gear_is_bounded_by_the_depth_that_ends_it() -> None:
    ended = report("a: ZAD8 until depth >= 20 timeout 5min\n")
    open_ended = report("a: ZAD8 until elapsed > 5min timeout 6min\n")
    assert ended.ok
    assert "depth" in rules(open_ended)


def _pitched(body: str) -> Report:
    mission = parse(HEAD.replace("vehicle auv", "vehicle auv-documented") + body)
    return check_mission(compile_mission(mission, LEANS, digest(mission)), LEANS)


@pytest.mark.parametrize("along", ["pitch -60 gear 8", "pitch 60 gear -8"])
def test_a_leg_whose_way_leads_down_along_its_bow_is_as_deep_as_its_clock_allows(
    along: str,
) -> None:
    found = _pitched(f"a: {along} heading 0 for 15s\n").proved
    assert found is not None
    # 20 % faster than its file says; buoyancy lifts; 10 s in which W does not stick
    down = 1.0 * 1.2 * math.sin(math.radians(60)) - LEANS.ascent_buoyancy
    assert found.max_depth == pytest.approx(0.5 + down * (15 + STICKS))
    assert rules(_pitched(f"a: {along} heading 0 for 1min\n")) == ["depth"]
    assert _pitched(f"a: {along} heading 0 until depth >= 5 timeout 1min\n").ok
    both = _pitched(f"a: {along} down 2 heading 0 for 5s\n").proved
    assert both is not None
    pushed = down + LEANS.ascent_buoyancy + LEANS.dive_rate
    assert both.max_depth == pytest.approx(0.5 + pushed * (5 + STICKS))


@pytest.mark.parametrize("along", ["pitch -60 gear 0", "pitch 60 gear 8", "pitch -20 gear 4"])
def test_a_pitch_without_way_upward_or_less_than_buoyancy_lifts_leads_nowhere_down(
    along: str,
) -> None:
    found, held = (_pitched(f"a: {along} {x} heading 0 for 2min\n").proved for x in ("", "depth 5"))
    assert found is not None
    assert held is not None
    assert found.max_depth == 0.5
    assert held.max_depth == 6.0


def test_what_a_leg_with_a_pitch_made_of_its_way_is_not_taken_for_sure_on_the_way_back() -> None:
    """`pitch 60` at gear 8 was flown 61 m out in 4 min, where 240 m were taken for sure."""
    body = "a: pitch {} gear 8 heading 0 for 4min\nb: pitch 0 heading 180 for 8min\n"
    level, leant = (_pitched(body.format(pitch)).proved for pitch in (0, 60))
    assert level is not None
    assert leant is not None
    assert leant.max_range > level.max_range + 0.5 * 240


@pytest.mark.parametrize("held", ["depth 5", "altitude 20"])
def test_no_hold_bounds_a_bow_that_leads_down_faster_than_buoyancy_lifts(held: str) -> None:
    """`depth 5` at pitch -60 and gear 8 was flown 7.8 m deep, where 6 m were proved."""
    assert "depth" in rules(_pitched(f"a: pitch -60 gear 8 {held} heading 0 for 1min\n"))


def test_a_trend_over_less_depth_than_a_dive_makes_between_reports_is_told() -> None:
    asked = "a: depth 15 gear 6 heading 0 until temperature falls 1 within {} timeout 2min\n"
    (said,) = [x for x in report(asked.format("0.5 m")).assumed if "not known in a dive" in x]
    assert said.startswith("a: whether temperature falls within 0.5 m")
    assert said.endswith("ask within 3 m or more")
    for fine in ("5 m", "0.8 m", "3 s"):
        assert not [x for x in report(asked.format(fine)).assumed if "not known in a dive" in x]


def test_what_is_asked_of_batteries_that_never_change_is_told() -> None:
    """The AUV as built reports 12 V: a mission that comes up below 13 V does so at once."""

    def told(mission: str, vehicle: str) -> list[str]:
        assumed = check_prepared(prepare(mission, vehicle)).assumed
        return [line for line in assumed if "what the mission asks of battery " in line]

    assert len(told("coreboard-dive", "auv")) == 1
    assert not told("coreboard-dive", "auv-documented")
    assert not told("robot-drive", "auv"), "it asks for none"


def test_an_altitude_hold_assumes_a_floor_and_says_so() -> None:
    found = report("a: ZAE3 ZAF4 heading 0 for 10min\n")
    assert any("sea floor" in line for line in found.assumed)
    shallow = report("a: ZAE3 ZAF4 heading 0 for 10min\n", HEAD + "assume floor 12\n")
    assert shallow.proved is not None
    assert shallow.proved.max_depth == pytest.approx(10.0)


def test_a_hold_whose_sensor_fails_goes_on_down_until_that_is_known_and_for_its_whole_leg() -> None:
    for seconds, unseen in ((10, 18), (60, 60)):
        held = report(f"a: ZAS10 ZAF4 heading 0 for {seconds}s\n").proved
        assert held is not None
        # five reports alike and 8 s until that counts, or the leg where nothing can see it;
        # then 10 s in which W does not stick, and 3 s to turn
        deeper = VEHICLE.dive_rate * (unseen + 10 + 3)
        assert held.blind_depth == pytest.approx(held.max_depth + deeper)
    floor = report("a: ZAE3 ZAF4 heading 0 for 5min\n", HEAD + "assume floor 12\n").proved
    assert floor is not None
    assert floor.blind_depth == pytest.approx(12.0)
    plain = report("a: ZAF4 heading 0 for 60s\n").proved
    assert plain is not None
    assert plain.blind_depth == plain.max_depth


def test_what_a_hold_may_have_sunk_unseen_the_next_one_goes_on_from_until_the_surface() -> None:
    hold = "{}: ZAS10 ZAF4 heading 0 for 60s\n".format
    one, two = report(hold("a")).proved, report(hold("a") + hold("b")).proved
    three = report(hold("a") + hold("b") + hold("c")).proved
    up = hold("a") + "u: surface timeout 2min{}\n" + hold("b")
    between, given_up = report(up.format("")).proved, report(up.format(" else b")).proved
    assert one is not None
    assert two is not None
    assert three is not None
    assert between is not None
    assert given_up is not None
    assert two.blind_depth == pytest.approx(one.blind_depth + 60 * VEHICLE.dive_rate)
    assert three.blind_depth == pytest.approx(one.blind_depth + 120 * VEHICLE.dive_rate)
    assert three.blind_time == pytest.approx(
        (three.blind_depth - three.max_depth) / VEHICLE.ascent_buoyancy
    )
    assert between.blind_depth == pytest.approx(one.blind_depth)
    assert given_up.blind_depth == pytest.approx(two.blind_depth)


def test_a_leg_that_surfaces_lasts_as_long_as_its_clock_allows_and_drifts_so_long() -> None:
    dive = "a: ZAS5 heading 0 ZAF4 for 60s\n"
    for clock, until in ((180, ""), (180, " until fix"), (1800, " until fix")):
        long = report(f"{dive}up: surface{until} timeout {clock}s\n").proved
        short = report(f"{dive}up: surface{until} timeout 60s\n").proved
        assert long is not None
        assert short is not None
        assert long.worst_time - short.worst_time == pytest.approx(clock - 60)
        assert long.max_range - short.max_range == pytest.approx(0.2 * (clock - 60))


def test_the_ascent_that_a_limit_begins_counts_from_anywhere() -> None:
    """Where a leg has led farthest the way goes on under a W that does not stick, and it drifts."""
    out = "a: heading 0 ZAF8 for 5min\n"
    for current in (0.0, 0.2):
        alone = report(out, HEAD + f"assume current {current}\n").proved
        assert alone is not None
        assert alone.max_range > 25.0 + 5.0 + 300.0 + 20.0 * 1.0 + current * (300 + 30)
    alone = report(out, HEAD + "assume current 0\n").proved
    home = "a: heading 0 ZAF8 for 5min else b\nb: goto home gear 8 timeout 10min\n"
    back = report(home, HEAD + "assume current 0\n").proved
    assert alone is not None
    assert back is not None
    assert back.max_range >= alone.max_range


def test_a_compass_that_fails_costs_the_way_until_that_is_known() -> None:
    """Five reports alike, and 8 s; a shorter leg costs no more than itself."""
    for seconds in (10, 60):
        slow, fast = (
            report(f"a: {way} for {seconds}s\n", HEAD + "assume current 0\n").proved
            for way in ("heading 0 ZAF4", "heading 0 ZAF8")
        )
        assert slow is not None
        assert fast is not None
        lost = 0.55 * min(seconds, FROZEN + LATE)  # m; ZAF8 is 0.55 m/s faster than ZAF4
        goes_on = 0.55 * 1.2 * 2.0 * STICKS
        share = math.hypot(0.2, 2.0 * VEHICLE.sensors.heading_bias)
        made = 0.55 * (seconds + min(seconds, math.pi / 2.0 / VEHICLE.turn_rate))
        scale = made * share + 0.55 * seconds * VEHICLE.sensors.heading
        assert fast.uncertainty - slow.uncertainty == pytest.approx(lost + goes_on + scale, abs=0.5)


def test_a_way_back_without_end_is_refused_with_the_way() -> None:
    found = report(
        "a: heading 0 ZAF4 until travelled > 10 timeout 1min\n"
        "b: heading 180 ZAF4 until travelled > 10 -> a timeout 1min\n"
    )
    assert "endless" in rules(found)
    refusal = next(r for r in found.refusals if r.code == "endless")
    assert refusal.where.line == 5
    assert refusal.path[0].startswith("b")


def test_clocks_that_only_lead_back_have_no_way_up() -> None:
    found = report(
        "a: heading 0 ZAF4 for 10s\nb: heading 180 ZAF4 until depth > 5 timeout 1min else a\n"
    )
    assert "no-way-up" in rules(found)


def test_a_leg_that_no_way_leads_to_is_refused() -> None:
    found = report(
        "a: heading 0 ZAF4 until depth > 5 -> c timeout 1min else c\n"
        "b: heading 90 ZAF4 for 10s\nc: heading 180 ZAF4 for 10s\n"
    )
    assert rules(found) == ["unreachable"]
    assert found.refusals[0].where.line == 5


def test_a_handler_adds_its_leg_to_the_worst_case_once() -> None:
    body = "a: heading 0 ZAF4 for 60s\nb: heading 180 ZAF4 for 60s\nout: surface timeout 3min\n"
    plain = report(body).proved
    handled = report(body + "on battery < 11 held 10s -> b\n").proved
    assert plain is not None
    assert handled is not None
    assert plain.worst_time < handled.worst_time <= plain.worst_time + 60 + 180 + 1e-6


def test_energy_beyond_the_battery_is_refused() -> None:
    found = report(
        "repeat 4 r:\n a: heading 0 ZAF10 for 20min\n b: heading 180 ZAF10 for 20min\nend\n",
        HEAD.replace("60min", "230min").replace("1000", "2000"),
    )
    assert "energy" in rules(found)


def test_a_fix_at_the_surface_forgets_the_error() -> None:
    body = "a: heading 0 ZAF6 ZAS5 for 5min\nup: surface until fix timeout 3min\nb: heading 180 ZAF6 ZAS5 for 5min\n"
    without = report(body.replace(" until fix", "")).proved
    with_fix = report(body).proved
    assert with_fix is not None
    assert without is not None
    assert with_fix.uncertainty <= without.uncertainty


@pytest.mark.proof
def test_rounds_beyond_what_can_be_walked_are_refused_not_walked_for_ever() -> None:
    body = (
        "".join(f"repeat 9999 r{i}:\n" for i in range(3))
        + "a: heading 0 ZAF2 for 1s\n"
        + "end\n" * 3
    )
    assert rules(report(body)) == ["too-long"]


@pytest.mark.parametrize("path", sorted((ROOT / "missions").glob("*.*")), ids=lambda p: p.name)
def test_every_shipped_mission_is_clean(path: Path) -> None:
    result = CliRunner().invoke(main, ["check", str(path), "--json"])
    assert result.exit_code == 0, result.output
    shown = json.loads(result.stdout)
    assert shown["ok"]
    assert shown["refusals"] == []
    assert shown["proved"]["worst_time_s"] > 0


def test_a_refused_mission_exits_1_and_an_unreadable_one_2(tmp_path: Path) -> None:
    deep, broken = tmp_path / "deep.mission", tmp_path / "broken.mission"
    deep.write_text(HEAD + "a: ZAS40 ZAF4 heading 0 for 4min\n")
    broken.write_text(HEAD + "a: ZAF130 for 4min\n")
    refused = CliRunner().invoke(main, ["check", str(deep), "--json"])
    assert refused.exit_code == 1
    assert json.loads(refused.stdout)["refusals"][0]["line"] == 4
    unreadable = CliRunner().invoke(main, ["check", str(broken), "--json"])
    assert unreadable.exit_code == 2
    assert "gear and seconds" in unreadable.stderr
    assert json.loads(unreadable.stdout)["refusals"][0]["line"] == 4


def test_the_check_names_the_text_that_it_judged_as_the_vehicle_will() -> None:
    told = CliRunner().invoke(main, ["check", "first-dive"]).stdout
    assert told.endswith(f"digest {prepare('first-dive').chart.digest[:16]}\n")


def test_a_refusal_shows_the_line_it_is_about(tmp_path: Path) -> None:
    deep = tmp_path / "deep.mission"
    line = "way_down: depth 40 gear 4 heading 0 for 4min"
    deep.write_text(HEAD + line + "\n")
    told = CliRunner().invoke(main, ["check", str(deep)]).stdout.splitlines()
    assert told[0].startswith(f"{deep}:4:1: ")
    assert told[1:3] == [f"    {line}", "    " + "^" * len(line)]


@pytest.mark.parametrize(
    ("unreported", "says"),
    [
        ("yaw", "(without a believed depth up to {dark} min more until fixes prove the surface)"),
        ("position", "(without a believed depth until an X: nothing reports a position)"),
        ("depth", "the ascent included\n"),
    ],
)
def test_an_ascent_without_a_depth_ends_by_fixes_where_a_position_is_reported(
    unreported: str, says: str
) -> None:
    vehicle = replace(VEHICLE, reports=VEHICLE.reports - {unreported})
    mission = parse(HEAD + "out: heading 0 gear 6 for 60s\nup: surface timeout 5min\n")
    compiled = compile_mission(mission, VEHICLE, digest(mission))
    dark = (VEHICLE.limits.depth / VEHICLE.ascent_buoyancy + 5.0) / 60.0
    assert says.format(dark=f"{dark:.1f}") in as_text("m", check_mission(compiled, vehicle), "")
