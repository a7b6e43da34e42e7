"""Rows over an area: how they lie in it, in which order they are flown, their parts, both texts."""

from __future__ import annotations

import math
from itertools import pairwise
from random import Random
from typing import Any

import pytest

from links.simulated.settings import parse_settings
from mission.authoring.check.covered import PIECES, Row, covered
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse, to_lines, to_yaml
from mission.authoring.prepare import check_prepared, prepare_text
from mission.legs import LEGS, Cover
from mission.legs.cover import NARROWEST
from mission.legs.pattern import Pattern, Point
from mission.legs.resurfacing import FIX_S
from mission.model import Chart, Local
from mission.model.diagnostics import MissionErrors
from mission.model.shipped import load_vehicle
from mission.navigation.polygons import inside, signed_area
from mission.verification.planned.track import planned
from mission.verification.simulation import reaching
from mission.verification.simulation.flight import fly

BOX = ((0.0, 0.0), (0.0, 100.0), (40.0, 100.0), (40.0, 0.0))
ELL = ((20.0, 20.0), (20.0, 160.0), (80.0, 160.0), (80.0, 90.0), (140.0, 90.0), (140.0, 20.0))
FORK = ((0.0, 0.0), (0.0, 90.0), (100.0, 90.0), (100.0, 60.0), (30.0, 60.0), (30.0, 30.0),
        (100.0, 30.0), (100.0, 0.0))  # fmt: skip
WEDGE = ((0.0, 0.0), (10.0, 120.0), (70.0, 60.0))
SHAPES = (BOX, ELL, FORK, WEDGE)
HEAD = "mission m vehicle auv\nhome 30.2874595 120.1535765\nassume current 0.05\n"
HELD = "gear 8 depth 4 timeout 20min"


def kind(shape: tuple[Point, ...], **said: Any) -> Cover:
    figures = {"bearing": NARROWEST, "spacing": 20.0, "overlap": 0.0, "within": 5.0, **said}
    return Cover(tuple(Local(n, e) for n, e in shape), **figures)


def pattern(shape: tuple[Point, ...], **said: Any) -> Pattern:
    made = LEGS[Cover].pattern
    assert made is not None
    return made(kind(shape, **said), shape, (999.0, 999.0))


def words(shape: tuple[Point, ...]) -> str:
    return ", ".join(f"north {n:g} east {e:g}" for n, e in shape)


def chart(leg: str) -> Chart:
    mission = parse(f"{HEAD}mow: {leg}\nup: surface timeout 3min")
    return compile_mission(mission, load_vehicle("auv"), digest(mission))


# --- how they lie ------------------------------------------------------------------------------


def test_rows_lie_along_the_side_across_which_the_area_is_narrowest() -> None:
    made = pattern(BOX)
    expected = ((10.0, 0.0), (10.0, 100.0), (30.0, 100.0), (30.0, 0.0))
    for one, other in zip(made.points, expected, strict=True):
        assert one == pytest.approx(other)


def test_rows_lie_along_a_bearing_that_is_said() -> None:
    made = pattern(BOX, bearing=0.0)
    assert len(made.rows) == 5
    assert all(abs(a[1] - b[1]) < 1e-9 for a, b in made.rows)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("bearing", [NARROWEST, 0.4, 2.0])
def test_rows_are_within_the_area_and_no_farther_apart_than_is_said(
    shape: tuple[Point, ...], bearing: float
) -> None:
    made = pattern(shape, bearing=bearing, spacing=12.0)
    offs = sorted({round(made.framed(begin)[1], 6) for begin, _ in made.rows})
    assert all(b - a <= 12.0 * 1.001 + 1e-5 for a, b in pairwise(offs))
    for a, b in made.rows:
        for share in (0.01, 0.3, 0.5, 0.99):
            point = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
            assert inside(shape, point)


@pytest.mark.parametrize("shape", SHAPES)
def test_fine_rows_fill_the_area(shape: tuple[Point, ...]) -> None:
    made = pattern(shape, spacing=1.0, bearing=0.7)
    assert sum(math.dist(*row) for row in made.rows) * made.spacing == pytest.approx(
        abs(signed_area(shape)), rel=0.02
    )


def test_spacing_is_the_swath_less_its_overlap_unless_it_is_said() -> None:
    assert kind(BOX, spacing=0.0, swath=25.0, overlap=0.2).apart == 20.0
    assert kind(BOX, spacing=12.0, swath=25.0, overlap=0.2).apart == 12.0


def test_an_area_that_is_turned_has_the_same_rows_turned() -> None:
    c, s = math.cos(0.6), math.sin(0.6)
    turned = tuple((n * c - e * s, n * s + e * c) for n, e in ELL)
    for one, other in zip(pattern(ELL).points, pattern(turned).points, strict=True):
        n, e = one
        assert other == pytest.approx((n * c - e * s, n * s + e * c), abs=1e-6)


def test_an_area_named_the_other_way_round_has_the_same_rows() -> None:
    back = (ELL[0], *reversed(ELL[1:]))
    rows = {frozenset(tuple(round(x, 6) for x in p) for p in row) for row in pattern(ELL).rows}
    assert rows == {
        frozenset(tuple(round(x, 6) for x in p) for p in row) for row in pattern(back).rows
    }


# --- in which order ------------------------------------------------------------------------------


@pytest.mark.parametrize("corner", range(4))
def test_the_rows_begin_nearest_to_the_corner_that_is_named_first(corner: int) -> None:
    shape = BOX[corner:] + BOX[:corner]
    assert math.dist(pattern(shape).rows[0][0], shape[0]) < 10.0 + 1e-9


def test_each_arm_of_a_concave_area_is_flown_before_the_next() -> None:
    rows = pattern(FORK, bearing=math.pi / 2, spacing=10.0).rows
    arms = [begin[1] < 45.0 for begin, _ in rows if begin[0] > 30.0]
    assert sum(one != other for one, other in pairwise(arms)) == 1


def test_neighbouring_rows_are_flown_up_and_down() -> None:
    made = pattern(BOX, bearing=0.0, spacing=10.0)
    for (_, end), (begin, _) in pairwise(made.rows):
        assert math.dist(end, begin) == pytest.approx(10.0)


# --- fixes on the way ------------------------------------------------------------------------------


def legs(leg: str) -> list[Any]:
    return [state.leg for state in chart(leg).states if state.leg][:-2]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("more", ["", " skip 1", " only 3", " skip 1 only 2"])
def test_its_runs_fly_the_rows_of_the_whole_in_its_order(
    shape: tuple[Point, ...], more: str
) -> None:
    made = LEGS[Cover].pattern
    assert made is not None
    text = f"cover {words(shape)} spacing 12{more}"
    (whole,) = legs(f"{text} {HELD}")
    runs = [leg.kind for leg in legs(f"{text} resurface 2 {HELD}") if isinstance(leg.kind, Cover)]
    rows = [row for run in runs for row in made(run, shape, shape[0]).rows]
    assert rows == list(made(whole.kind, shape, shape[0]).rows)
    assert len(runs) == math.ceil(len(rows) / 2)


def test_its_clock_is_shared_by_what_the_runs_fly() -> None:
    parts = legs(f"cover {words(ELL)} spacing 20 resurface 2 {HELD}")
    clocks = [leg.timeout for leg in parts if isinstance(leg.kind, Cover)]
    assert sum(clocks) == pytest.approx(1200.0)
    assert clocks[0] > clocks[-1]
    assert {leg.timeout for leg in parts if not isinstance(leg.kind, Cover)} == {FIX_S}


def test_a_look_between_two_rows_keeps_the_direction_of_the_row_before() -> None:
    parts = legs(f"cover {words(BOX)} spacing 20 unsure 15 {HELD}")
    look = next(leg for leg in parts if leg.name == "look1")
    assert {s.word: s.value for s in look.settings}["heading"] == pytest.approx(math.pi / 2)


def test_an_area_in_degrees_parts_as_one_in_metres() -> None:
    degrees = [(30.2874595 + n / 110_855, 120.1535765 + e / 96_230) for n, e in ELL]
    said = ", ".join(f"{lat:.7f} {lon:.7f}" for lat, lon in degrees)
    one, other = (
        legs(f"cover {places} spacing 20 resurface 2 {HELD}") for places in (words(ELL), said)
    )
    assert [leg.name for leg in one] == [leg.name for leg in other]


# --- texts ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", [to_lines, to_yaml])
@pytest.mark.parametrize("more", ["spacing 20", "swath 25 overlap 20%", "bearing 0 spacing 20"])
def test_both_texts_say_it_and_leave_out_what_it_chooses_itself(form: Any, more: str) -> None:
    mission = parse(f"{HEAD}mow: cover {words(ELL)} {more} {HELD}\n")
    assert parse(form(mission)) == mission
    assert ("bearing" in form(mission)) == ("bearing" in more)


AREA = f"keep in bay: {words(ELL)}\n"


def test_an_area_that_is_kept_in_lends_its_corners() -> None:
    named = parse(f"{HEAD}{AREA}mow: cover area bay spacing 20 {HELD}\n")
    said = parse(f"{HEAD}{AREA}mow: cover {words(ELL)} spacing 20 {HELD}\n")
    assert digest(named) == digest(said)
    assert parse(to_yaml(named).replace(f"[{words(ELL)}], spacing", "area bay, spacing")) == said


@pytest.mark.parametrize(
    ("leg", "told", "hint"),
    [
        ("cover area bey spacing 20", "there is no area 'bey'", "did you mean bay?"),
        ("follow area bay", "follow goes along places", "cover area bay"),
        ("cover area bay", "cover needs spacing or swath", "overlap 20%"),
        ("cover area bay overlap 20%", "cover needs spacing or swath", "spacing 20"),
        ("cover area bay spacing 9 overlap 0.2", "both say how far apart", "keep one"),
        ("rows 2 bearing 9 length 9", "rows needs spacing", "spacing 20"),
    ],
)
def test_what_is_wrong_with_it_is_told_with_what_instead(leg: str, told: str, hint: str) -> None:
    with pytest.raises(MissionErrors) as error:
        parse(f"{HEAD}{AREA}mow: {leg} {HELD}\n")
    assert told in str(error.value)
    assert hint in str(error.value)


def test_corners_that_are_no_polygon_are_refused_by_the_check_with_their_leg() -> None:
    crossed = words((BOX[0], BOX[2], BOX[1], BOX[3]))
    prepared = prepare_text(f"{HEAD}mow: cover {crossed} spacing 20 {HELD}\n", "m.mission")
    refusal = next(r for r in check_prepared(prepared).refusals if r.code == "area")
    assert "the area of mow: its edges cross" in refusal.message
    assert refusal.where.line == 4


# --- what it brings home ------------------------------------------------------------------------------


def sure(made: Pattern, sigma: float) -> list[Row]:
    return [Row((sigma,) * PIECES, 0.0, 0.0) for _ in made.rows]


def test_rows_that_are_sure_of_their_place_see_all_of_a_box_and_most_of_a_wedge() -> None:
    box, wedge = (pattern(shape, swath=25.0) for shape in (BOX, WEDGE))
    assert covered(box, sure(box, 0.01)) == pytest.approx(1.0, abs=0.01)
    assert 0.8 < covered(wedge, sure(wedge, 0.01)) < 0.97


def test_rows_that_are_unsure_of_their_place_see_less() -> None:
    made = pattern(ELL, swath=25.0)
    shares = [covered(made, sure(made, sigma)) for sigma in (1.0, 5.0, 20.0, 80.0)]
    assert shares == sorted(shares, reverse=True)
    assert shares[-1] < 0.5


SURVEY = f"""mission bay vehicle auv
home 30.2874595 120.1535765
safety radius 800 time 75min depth 12
assume current 0.05
achieve coverage 80%
learn: surface until fix timeout 5min
mow: cover {words(ELL)} swath 25 overlap 20% within 3 resurface 1 depth 5 gear 8 timeout 30min
up: surface until fix timeout 3min
"""


@pytest.mark.proof
@pytest.mark.parametrize("seed", [0, 1])
def test_a_survey_that_the_check_lets_pass_truly_covers_its_area_in_its_current(seed: int) -> None:
    prepared = prepare_text(SURVEY, "bay.mission")
    report = check_prepared(prepared)
    assert report.ok, report.refusals
    sea = parse_settings([f"current=0.05@{Random(seed).randrange(360)}"])
    flight = fly(prepared.mission, prepared.vehicle, seed=seed, settings=sea)
    assert flight.outcome == "completed"
    (found,) = reaching.achieved_by(flight, prepared.mission)
    assert found.reached
    assert dict(found.figures)["coverage"] >= 0.8


def test_the_plan_shows_its_area_and_turns_at_the_ends_of_its_rows() -> None:
    text = f"{HEAD}safety time 40min\nmow: cover {words(BOX)} spacing 20 within 3 {HELD}\n"
    prepared = prepare_text(text, "m.mission")
    plan = planned(prepared.mission, prepared.chart, prepared.vehicle)
    stretch = next(s for s in plan.stretches if s.name == "mow")
    assert stretch.area == BOX
    assert len(stretch.turns) == len(pattern(BOX).points)
