"""Laws of guards: Kleene's logic, what is sure, what time alone will change."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
from engine_world import Navigation
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.engine.guards import Sheet
from mission.engine.readings import Scope
from mission.engine.variables import VARIABLES, reading_of, value_of
from mission.legs import Track
from mission.model import And, Comparison, Guard, Health, NavigationMode, Not, Or, terms
from mission.navigation import distribution
from protocol.messages import Telemetry

REPORT = Telemetry(
    100.0,
    depth=5.0,
    altitude=8.0,
    heading=1.0,
    pitch=0.1,
    roll=0.2,
    temperature_c=12.0,
    batteries=(11.5, 47.0),
    leak=False,
)


def scope(*, doubt: str = "", now: float = 101.0, **estimate: object) -> Scope:
    """Depth 5, altitude 8, heading 1; ``doubt`` names the sensor that is not to be believed."""
    nav = Navigation()
    nav.report, nav.speed, nav.north, nav.east, nav.fix_t = REPORT, 1.0, 30.0, 40.0, 90.0
    believed = nav.estimate(100.0)._replace(**estimate)

    def health(sensor: str) -> Health:
        return Health(sensor != doubt, "frozen" if sensor == doubt else "", now - 100.0)

    track = Track(10.0, 2.0, 0.0, 0.2)
    return Scope(now, believed, REPORT, health, 90.0, 50.0, 12.0, 2, lambda: track)


def ask(expression, at: Scope) -> bool | None:
    sheet = Sheet()
    guard = sheet.add(Guard(expression))
    return guard.test(sheet.values(at), at)


TRUE, FALSE = Comparison("depth", ">", 1.0), Comparison("depth", ">", 9.0)
UNKNOWN = Comparison("pitch", ">", 0.0)
KNOWN = {TRUE: True, FALSE: False, UNKNOWN: None}
EXPRESSIONS = st.recursive(
    st.sampled_from([TRUE, FALSE, UNKNOWN]),
    lambda inner: st.one_of(
        inner.map(Not),
        st.lists(inner, min_size=2, max_size=3).map(lambda x: And(tuple(x))),
        st.lists(inner, min_size=2, max_size=3).map(lambda x: Or(tuple(x))),
    ),
    max_leaves=8,
)


def kleene(expression) -> bool | None:
    """By the order false < unknown < true: and is the least, or the greatest."""
    rank = {False: 0, None: 1, True: 2}
    back = {0: False, 1: None, 2: True}
    if isinstance(expression, Comparison):
        return KNOWN[expression]
    if isinstance(expression, Not):
        return back[2 - rank[kleene(expression.operand)]]
    found = [rank[kleene(e)] for e in expression.operands]
    return back[min(found) if isinstance(expression, And) else max(found)]


@settings(max_examples=150, deadline=None)
@given(EXPRESSIONS)
def test_and_or_not_are_kleenes(expression):
    assert ask(expression, scope(doubt="attitude")) is kleene(expression)


@pytest.mark.parametrize("operator", ["<", "<=", ">", ">="])
def test_no_comparison_with_a_doubtful_reading_is_ever_true_nor_its_negation(operator: str):
    for bound in (-1e9, 0.0, 1e9):
        one = Comparison("depth", operator, bound)
        assert ask(one, scope(doubt="depth")) is None
        assert ask(Not(one), scope(doubt="depth")) is None


def test_comparisons_mean_what_they_say():
    at = scope()
    for bound, (lt, le, gt, ge) in {
        4.0: (False, False, True, True),
        5.0: (False, True, False, True),
        6.0: (True, True, False, False),
    }.items():
        got = tuple(ask(Comparison("depth", o, bound), at) for o in ("<", "<=", ">", ">="))
        assert got == (lt, le, gt, ge)


def test_a_heading_is_compared_the_short_way_round():
    north = scope()
    north.telemetry = REPORT._replace(heading=math.radians(5.0))
    assert ask(Comparison("heading", ">", math.radians(355.0)), north) is True
    assert ask(Comparison("heading", "<", math.radians(10.0)), north) is True
    for heading, below in ((170.0, False), (190.0, True), (260.0, True), (350.0, True)):
        north.telemetry = REPORT._replace(heading=math.radians(heading))
        assert ask(Comparison("heading", "<", 0.0), north) is below
        assert ask(Comparison("heading", ">", 0.0), north) is not below


def test_sure_asks_for_the_share_of_the_distribution():
    at = scope(sigmas={"depth": 1.0})
    # depth 5 with sigma 1: P(depth > 3.355) is 95 %
    assert ask(Comparison("depth", ">", 3.34, 0.95), at) is True
    assert ask(Comparison("depth", ">", 3.37, 0.95), at) is False
    assert ask(Comparison("depth", "<", 6.66, 0.95), at) is True
    assert ask(Comparison("depth", "<", 6.63, 0.95), at) is False


def test_sure_of_a_range_asks_the_plane_and_not_a_line():
    at = scope(north=0.0, east=0.0, covariance=(1.0, 0.0, 1.0))
    # at the centre 95 % of the plane lie within 2.4477 sigma; along a line it would be 1.96
    assert ask(Comparison("range", "<", 2.43, 0.95), at) is False
    assert ask(Comparison("range", "<", 2.46, 0.95), at) is True


def test_sure_of_the_cross_track_asks_across_the_track():
    wide = scope(covariance=(100.0, 0.0, 0.01))  # the track runs north: across it is sure
    assert ask(Comparison("cross_track", "<", 2.5, 0.95), wide) is True
    narrow = scope(covariance=(0.01, 0.0, 100.0))
    assert ask(Comparison("cross_track", "<", 2.5, 0.95), narrow) is False


@settings(max_examples=12, deadline=None)
@given(
    st.floats(0.1, 20.0),
    st.floats(0.1, 1.0),
    st.floats(0.0, math.pi),
    st.floats(-40.0, 40.0),
    st.floats(-40.0, 40.0),
    st.floats(1.0, 60.0),
)
def test_the_share_within_a_disc_agrees_with_a_sum_over_a_grid(great, ratio, turn, north, east, r):
    small = great * ratio
    c, s = math.cos(turn), math.sin(turn)
    cov = (
        great**2 * c * c + small**2 * s * s,
        (great**2 - small**2) * c * s,
        great**2 * s * s + small**2 * c * c,
    )
    total, n = 0.0, 240
    steps = [(i + 0.5) / n * 12.0 - 6.0 for i in range(n)]
    weights = [math.exp(-0.5 * x * x) for x in steps]
    norm = sum(weights) ** 2
    for (a, wa), (b, wb) in itertools.product(zip(steps, weights, strict=True), repeat=2):
        x = north + great * a * c - small * b * s
        y = east + great * a * s + small * b * c
        total += wa * wb * (math.hypot(x, y) <= r)
    assert distribution.within(r, north, east, cov) == pytest.approx(total / norm, abs=0.02)


@pytest.mark.parametrize("cov", [(9.0, 0.0, 9.0), (9.0, 2.0, 1.0), (9.0, 0.0, 0.0)])
def test_a_place_that_is_not_certain_is_nowhere_exactly(cov):
    assert distribution.within(0.0, 1.0, 2.0, cov) == distribution.within(0.0, 0.0, 0.0, cov) == 0.0
    assert distribution.within(0.0, 0.0, 0.0, (0.0, 0.0, 0.0)) == 1.0


def test_the_share_within_a_disc_about_its_centre_is_exact():
    for r in (0.5, 1.0, 3.0):
        assert distribution.within(r, 0.0, 0.0, (1.0, 0.0, 1.0)) == pytest.approx(
            1.0 - math.exp(-r * r / 2.0), abs=1e-6
        )


def test_what_time_alone_will_change_is_foretold():
    at = scope()  # entered at 90, now 101
    sheet = Sheet()
    late = sheet.add(Guard(Comparison("elapsed", ">=", 20.0)))
    strict = sheet.add(Guard(Comparison("elapsed", ">", 20.0)))
    past = sheet.add(Guard(Comparison("elapsed", ">", 5.0)))
    deep = sheet.add(Guard(TRUE))
    values = sheet.values(at)
    assert late.next_change(values, at.now) == pytest.approx(110.0, abs=1e-9)
    assert 110.0 < strict.next_change(values, at.now) < 110.001
    assert past.next_change(values, at.now) is None
    assert deep.next_change(values, at.now) is None
    then = replace(at, now=late.next_change(values, at.now))
    assert late.test(sheet.values(then), then) is True
    then = replace(at, now=strict.next_change(values, at.now))
    assert strict.test(sheet.values(then), then) is True


def test_of_several_times_the_nearest_is_foretold_and_what_is_reached_no_more():
    at, sheet = scope(), Sheet()  # in the leg for 11 s, in the mission for 51 s
    parts = (("elapsed", ">=", 20.0), ("mission_time", ">=", 55.0), ("fix_age", ">=", 40.0))
    both = sheet.add(Guard(And(tuple(Comparison(*part) for part in parts))))
    for now, due in ((101.0, 105.0), (105.0, 110.0), (107.0, 110.0), (110.0, 130.0)):
        then = replace(at, now=now)
        assert both.next_change(sheet.values(then), now) == pytest.approx(due, abs=1e-5)
    then = replace(at, now=130.0)
    assert both.next_change(sheet.values(then), 130.0) is None


@pytest.mark.parametrize(
    ("operator", "later"), [("<", 0.0), (">=", 0.0), (">", 1e-6), ("<=", 1e-6)]
)
def test_a_comparison_of_time_changes_when_it_was_foretold_and_not_before(operator, later: float):
    at, sheet = scope(), Sheet()
    guard = sheet.add(Guard(Comparison("elapsed", operator, 20.0)))
    due = guard.next_change(sheet.values(at), at.now)
    assert due == pytest.approx(110.0 + later, abs=1e-9)
    before, then = (replace(at, now=t) for t in (due - 2e-6, due))
    assert guard.test(sheet.values(before), before) is (operator[0] == "<")
    assert guard.test(sheet.values(then), then) is (operator[0] == ">")


def test_a_guard_names_what_it_read_and_what_may_grow_stale():
    at, sheet = scope(), Sheet()
    sheet.add(Guard(Comparison("temperature", ">", 1.0)))
    guard = sheet.add(Guard(Or((FALSE, Comparison("elapsed", ">", 3.0), FALSE)), held=2.0))
    assert guard.held == 2.0
    assert sheet.named(guard, sheet.values(at)) == (("depth", 5.0), ("elapsed", 11.0))
    assert sheet.stale_after == (6.0, 30.0)


@pytest.mark.parametrize("operator", ["<", "<=", ">", ">="])
def test_where_nothing_is_uncertain_sure_is_plain(operator: str):
    exact = scope(sigmas={"depth": 0.0})
    for bound in (4.0, 5.0, 6.0):
        plain = ask(Comparison("depth", operator, bound), exact)
        assert ask(Comparison("depth", operator, bound, 0.9), exact) is plain


@pytest.mark.parametrize(("operator", "less"), [("<", 1), ("<=", 1), (">", 0), (">=", 0)])
def test_sure_means_either_side_of_a_distribution(operator: str, less: int):
    at = scope(sigmas={"depth": 1.0, "heading": 0.1})
    for name, value, sigma in (("depth", 5.0, 1.0), ("heading", 1.0, 0.1)):
        for far in (-2.0, 2.0):
            sure = ask(Comparison(name, operator, value + far * sigma, 0.9), at)
            assert sure is ((far > 0) == bool(less))
        assert ask(Comparison(name, operator, value, 0.5), at) is True  # just so sure
        assert ask(Comparison(name, operator, value, 0.51), at) is False


def test_sure_of_a_heading_asks_the_short_way_round():
    at = scope(sigmas={"heading": 0.1})
    at.telemetry = REPORT._replace(heading=0.1)
    assert ask(Comparison("heading", ">", math.tau - 0.3, 0.9), at) is True
    assert ask(Comparison("heading", "<", math.tau - 0.3, 0.9), at) is False


def test_what_is_not_known_is_not_sure_either():
    assert ask(Comparison("depth", "<", 1e9, 0.5), scope(doubt="depth")) is None
    lost = scope(mode=NavigationMode.NONE)
    assert ask(Comparison("range", "<", 1e9, 0.5), lost) is None


@pytest.mark.parametrize(
    ("operator", "at_it"), [("<", False), ("<=", True), (">", False), (">=", True)]
)
def test_at_its_bound_a_heading_is_compared_as_anything_else(operator: str, at_it: bool):
    assert ask(Comparison("heading", operator, 1.0), scope()) is at_it
    assert ask(Comparison("heading", operator, 1.0), scope(doubt="heading")) is None


def test_each_variable_of_a_leg_is_read_once_and_no_other():
    sheet = Sheet()
    sheet.add(Guard(And((TRUE, FALSE, Not(TRUE)))))
    sheet.add(Guard(TRUE))
    assert [row.name for row in sheet.rows] == ["depth"]


def test_terms_are_found_in_the_order_of_the_text():
    expression = Or((And((TRUE, Not(UNKNOWN))), FALSE))
    assert list(terms(expression)) == [TRUE, UNKNOWN, FALSE]


# --- one contract over all rows -----------------------------------------------------------


@pytest.mark.parametrize("name", list(VARIABLES))
def test_every_variable_can_be_read_compared_and_asked_for_surely(name: str):
    at, row = scope(sigmas={"depth": 0.1, "heading": 0.1}), VARIABLES[name]
    value = value_of(row, at)
    assert value is not None
    assert math.isfinite(value)
    reading = reading_of(row, at)
    assert reading.valid
    assert reading.value == value
    assert reading.sigma >= 0.0
    far = 3.0 if row.circular else 1e6
    assert ask(Comparison(name, "<", value + far, 0.6), at) is True
    assert ask(Comparison(name, ">", value + far, 0.6), at) is False


@pytest.mark.parametrize("name", [n for n, r in VARIABLES.items() if r.max_age < math.inf])
def test_every_variable_of_a_sensor_is_unknown_once_it_is_stale(name: str):
    row = VARIABLES[name]
    assert value_of(row, scope(now=100.0 + row.max_age)) is not None
    late = scope(now=100.1 + row.max_age)
    assert value_of(row, late) is None
    assert reading_of(row, late).reason == "stale"


@pytest.mark.parametrize("name", ["north", "east", "range", "bearing", "distance", "uncertainty"])
def test_without_a_position_nothing_about_it_is_known(name: str):
    lost = scope(mode=NavigationMode.NONE)
    assert value_of(VARIABLES[name], lost) is None


def test_nothing_is_known_before_anything_was_heard():
    def deaf(sensor: str) -> Health:
        return Health(False, "missing", math.inf)

    silent = Scope(1.0, None, None, deaf, 0.0, 0.0, 0.0, 1, lambda: None)
    known = {n for n, row in VARIABLES.items() if value_of(row, silent) is not None}
    assert known == {"elapsed", "mission_time", "round"}
