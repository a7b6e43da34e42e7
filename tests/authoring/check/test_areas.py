"""What the check proves of areas: each leg, and the ascent from anywhere in it (R5)."""

from __future__ import annotations

import math

import pytest

from mission.authoring.check import check_mission
from mission.authoring.check.rules import Report
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.model.shipped import load_vehicle

AUV = load_vehicle("auv")
HEAD = (
    "mission m vehicle auv\nhome 30 120\nsafety radius 900 time 40min depth 12\n"
    "assume current 0.02 start 5\n"
)
GO = "go: goto north 200 east 0 within 5 gear 8 depth 4 timeout 8min\nup: surface timeout 3min\n"


def box(north: float, east: float, half: float = 15.0) -> str:
    ends = ((-half, -half), (-half, half), (half, half), (half, -half))
    return ", ".join(f"north {north + n:g} east {east + e:g}" for n, e in ends)


def judged(areas: str, legs: str = GO, head: str = HEAD) -> Report:
    mission = parse(head + areas + legs)
    return check_mission(compile_mission(mission, AUV, digest(mission)), AUV)


def why(areas: str, legs: str = GO) -> str:
    (refusal,) = judged(areas, legs).refusals
    assert refusal.code == "area"
    return refusal.message


def test_a_way_that_leads_through_what_is_kept_out_of_is_refused_with_leg_and_place() -> None:
    told = why(f"keep out wreck: {box(100, 0)}\n")
    assert told.startswith("go leads through keep out wreck (north ")


def test_a_way_that_passes_it_within_the_error_is_refused_with_the_metres() -> None:
    told = why(f"keep out wreck: {box(100, 40)}\n")
    assert "go leads within 22 m of keep out wreck" in told
    assert "m to any side" in told


def test_what_lies_far_off_is_no_matter() -> None:
    assert judged(f"keep out wreck: {box(0, 400)}\n").ok


def test_a_diagonal_way_is_no_box_about_it() -> None:
    """A box about the whole way would hold the wreck."""
    go = GO.replace("north 200 east 0", "north 400 east 400").replace("8min", "15min")
    assert judged(f"keep out wreck: {box(560, -140)}\n", go).ok


def test_an_ascent_drifts_on_from_where_the_leg_itself_passes_clear() -> None:
    """Between a leg that may touch it and one that is far from it, the way up may."""
    reports = [judged(f"keep out ships: {box(100, east)} between 0 and 2\n") for east in
               range(100, 400, 5)]  # fmt: skip
    told = [r.message.partition(" leads")[0] for report in reports for r in report.refusals]
    assert list(dict.fromkeys(told)) == ["go", "the ascent from go"]
    assert reports[-1].ok


def test_above_what_is_kept_out_of_a_leg_may_pass() -> None:
    assert judged(f"keep out wreck: {box(100, 0)} between 8 and 12\n").ok


def test_a_leg_must_be_surely_within_what_is_kept_in() -> None:
    assert judged(f"keep in harbour: {box(100, 0, 600)}\n").ok
    assert why(f"keep in harbour: {box(100, 0, 110)}\n").startswith("go may leave keep in harbour")


def test_a_yoyo_from_the_surface_may_be_within_what_is_kept_in() -> None:
    """What it overshoots at its shallow end is no depth above the surface."""
    yoyo = "y: yoyo 2 shallow 2 deep 6 heading 0 gear 4 timeout 5min\nup: surface timeout 3min\n"
    assert judged(f"keep in harbour: {box(100, 0, 800)}\n", yoyo).ok
    assert judged(f"keep in harbour: {box(100, 0, 800)} between 0 and 12\n", yoyo).ok
    assert not judged(f"keep in harbour: {box(100, 0, 800)} between 1 and 12\n", yoyo).ok


def test_of_several_one_is_enough_that_holds_the_leg_whole() -> None:
    assert judged(f"keep in near: {box(0, 0, 90)}\nkeep in wide: {box(100, 0, 600)}\n").ok
    assert not judged(f"keep in near: {box(0, 0, 90)}\nkeep in off: {box(900, 0, 90)}\n").ok


def test_what_is_kept_in_below_leaves_the_surface_free() -> None:
    deep = f"keep in deep: {box(900, 0)} between 10 and 12\n"
    assert judged(deep).ok


def test_the_start_is_within_it_or_out_of_it_as_well() -> None:
    assert not judged(f"keep out quay: {box(8, 0, 4)}\n").ok


def test_a_leg_that_holds_a_heading_is_judged_by_where_it_may_lead() -> None:
    east = "a: heading 90 gear 8 depth 4 for 3min\nup: surface timeout 3min\n"
    assert not judged(f"keep out wreck: {box(0, 120)}\n", east).ok
    assert judged(f"keep out wreck: {box(0, -400)}\n", east).ok


@pytest.mark.parametrize("north", [-200, 200])
@pytest.mark.parametrize("east", [-200, 200])
def test_a_circle_is_judged_all_the_way_round(north: int, east: int) -> None:
    circle = "a: loiter north 0 east 0 radius 283 gear 4 depth 4 for 2min\nsurface timeout 3min\n"
    assert judged("", circle).ok
    assert "a leads through keep out wreck" in why(f"keep out wreck: {box(north, east)}\n", circle)


def test_a_circle_reaches_as_far_on_either_side() -> None:
    def reach(side: int) -> float:
        circle = f"a: loiter north 200 east {side} radius 100 gear 4 depth 4 for 4min\n"
        proved = judged("", f"{circle}surface timeout 3min\n").proved
        assert proved is not None
        return proved.max_range

    assert reach(-200) == pytest.approx(reach(200))
    assert reach(200) > math.hypot(300, 300)


def test_a_handler_may_interrupt_a_leg_anywhere() -> None:
    aside = GO + "aside: goto north 0 east 300 within 5 gear 8 depth 4 timeout 9min\n"
    aside += "on depth > 9 -> aside\n"
    assert not judged(f"keep out wreck: {box(100, 150)}\n", aside).ok


@pytest.mark.parametrize(
    ("corners", "says"),
    [
        ("home, north 9 east 9", "at least three corners"),
        ("home, home, north 9 east 9", "corners 1 and 2 are the same place"),
        ("home, north 9 east 9, north 9 east 0, north 0 east 9", "its edges cross"),
        ("home, north 0 east 0.5, north 0.5 east 0", "less than 1"),
    ],
)
def test_what_is_no_polygon_is_refused_where_it_stands(corners: str, says: str) -> None:
    (refusal,) = judged(f"keep out wreck: {corners}\n").refusals
    assert refusal.code == "area"
    assert says in refusal.message
    assert refusal.where.line == 5


def test_a_latitude_needs_a_home() -> None:
    head = HEAD.replace("home 30 120\n", "")
    report = judged("keep out wreck: 30 120, 30.01 120, 30 120.01\n", head=head)
    assert [r.code for r in report.refusals] == ["area"]


def test_across_the_antimeridian_an_area_is_as_large_as_it_is() -> None:
    head = HEAD.replace("home 30 120", "home 0 179.9999")
    far = "keep out reef: 0.005 179.9999, 0.005 -179.9989, 0.004 -179.9989, 0.004 179.9999\n"
    assert judged(far, head=head).ok
    across = "keep out reef: 0.0005 179.999, 0.0005 -179.999, 0.001 -179.999, 0.001 179.999\n"
    assert [r.code for r in judged(across, head=head).refusals] == ["area"]


def test_where_a_vehicle_never_says_where_it_is_the_check_says_that_areas_are_off() -> None:
    rov = load_vehicle("rov")
    head = "mission m vehicle rov\nstart without fix\nsafety radius 900 time 20min depth 12\n"
    legs = "a: gear 4 for 30\nup: surface timeout 3min\n"

    def off(areas: str) -> list[str]:
        mission = parse(head + areas + legs)
        report = check_mission(compile_mission(mission, rov, digest(mission)), rov)
        return [line for line in report.assumed if "position" in line and "off" in line]

    (with_area,), (without,) = off(f"keep out wreck: {box(400, 0)}\n"), off("")
    assert "radius and all areas" in with_area
    assert "radius, " in without
