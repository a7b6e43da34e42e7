"""Laws of the watching at its bounds: what counts as a descent, a turn, a standstill, a rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from engine_world import NEUTRAL, VEHICLE, Navigation

from mission.engine.bounds import in_force
from mission.engine.limits import BLIND_TIME, LIMITS, SILENCE, On
from mission.engine.monitor import LimitMonitor
from mission.engine.vehicle_state import VehicleState
from mission.engine.watch import Descent, Progress, Steering
from mission.model import Outcome, Result
from mission.model.shipped import load_vehicle
from mission.model.units import GEARS
from protocol.messages import Fix, Setpoint, SetSafety, Telemetry

DEG = math.radians(1.0)


# --- descent --------------------------------------------------------------------------------


def sunk(
    *reports: tuple[float, float | None], asked: bool = False, fastest: float = 9.0
) -> Descent:
    """After these depths at these times."""
    descent = Descent()
    for t, depth in reports:
        descent.take(t, depth, asked, fastest)
    return descent


def test_a_descent_is_two_depths_a_second_apart_and_ten_at_most():
    assert sunk((0.0, 0.0), (1.0, 3.0)).unexplained
    assert sunk((0.0, 0.0), (0.999, 3.0)).unexplained is None
    assert sunk((0.0, 0.0), (10.0, 3.0)).unexplained
    assert sunk((0.0, 0.0), (10.001, 3.0)).unexplained is None
    assert sunk((0.0, 3.0)).unexplained is None
    assert sunk((0.0, 0.0), (0.0, 3.0)).unexplained is None


def test_reports_that_follow_too_closely_are_passed_over_and_not_what_was_before_them():
    assert sunk((0.0, 0.0), (0.6, 3.0), (1.2, 3.0)).unexplained


def test_of_two_reports_of_one_instant_the_later_counts():
    assert not sunk((0.0, 0.0), (0.0, 3.0), (1.0, 3.0)).unexplained
    assert sunk((0.0, 0.0), (0.0, 1.0), (1.0, 3.0)).unexplained


def test_after_too_long_a_gap_the_next_two_depths_are_a_rate_again():
    descent = sunk((0.0, 0.0), (20.0, 3.0), (22.0, 3.5))
    assert descent.unexplained
    assert descent.words == "sinking at 0.25 m/s at 3.5 m, and nothing asked for it"


def test_two_metres_are_an_allowance_below_the_shallowest_depth_since_it_was_asked_for():
    assert not sunk((0.0, 1.0), (2.0, 3.0)).unexplained
    assert sunk((0.0, 1.0), (2.0, 3.001)).unexplained
    up = (0.0, 4.0), (2.0, 1.0), (4.0, 1.0)
    assert not sunk(*up, (6.0, 3.0)).unexplained
    assert sunk(*up, (6.0, 3.001)).unexplained
    descent = sunk((0.0, 0.0), (2.0, 5.0), asked=True)
    assert not descent.unexplained
    descent.take(4.0, 7.0, False, 9.0)
    assert not descent.unexplained


def goes_down(rate: float, *, driven: bool, to: float) -> float:
    """m at which it is told, inf if it is not; from the surface, reports each 2 s."""
    descent = Descent()
    for i in range(int(to / rate / 2.0)):
        descent.take(2.0 * i, 0.2 + rate * 2.0 * i, False, 9.0, driven)
        if descent.unexplained:
            return 0.2 + rate * 2.0 * i
    return math.inf


def test_a_slow_descent_is_told_where_a_set_holds_no_depth():
    """0.3 N too heavy it goes down by 0.03 m/s, for as long as the leg lasts."""
    for rate in (0.02, 0.03, 0.06, 0.09):
        told = goes_down(rate, driven=True, to=12.0)
        assert 2.2 + 20.0 * rate <= told <= 2.3 + 24.0 * rate
        assert goes_down(rate, driven=False, to=12.0) == math.inf, "let go: R7"


def test_what_is_deeper_for_less_than_20_s_is_a_wave():
    descent = Descent()
    for i in range(200):
        deep = 2.5 if i % 11 else 0.4  # for 20 s, and then shallower once
        descent.take(2.0 * i, deep, i == 0, 9.0, True)
        assert not descent.unexplained or i % 11 == 1


@pytest.mark.parametrize("before", [1, 3])
@pytest.mark.parametrize("asked", [False, True])
def test_one_wild_depth_far_above_the_others_makes_no_descent_of_what_follows(before, asked):
    """-2.6 m at the surface: its neighbours are 2.6 m deeper, and it has not moved."""
    descent = sunk(*((2.0 * i, 0.2) for i in range(before)), asked=asked)
    descent.take(2.0 * before, -2.6, asked, 9.0)
    for i in range(before + 1, before + 30):
        descent.take(2.0 * i, 0.0 if i % 2 else 0.4, False, 9.0)
        assert not descent.unexplained


@pytest.mark.parametrize("between", [(8.5, 5.0), (9.0, None)], ids=["too soon", "unknown"])
def test_what_is_excused_is_so_until_a_depth_counts_and_no_longer(between):
    descent = sunk((0.0, 0.0), (8.0, 1.0))
    descent.excuse()
    for t, depth in (between, (10.0, 5.0), (12.0, 6.9)):
        descent.take(t, depth, False, 9.0)
        assert not descent.unexplained
    descent.take(14.0, 7.3, False, 9.0)
    assert descent.words == "sinking at 0.20 m/s at 7.3 m, and nothing asked for it"


def test_a_tenth_of_a_metre_a_second_is_no_descent_and_more_is():
    assert not sunk((0.0, 0.0), (5.0, 5.0), (15.0, 6.0)).unexplained
    assert sunk((0.0, 0.0), (5.0, 5.0), (15.0, 6.001)).unexplained


def test_faster_than_the_vehicle_dives_is_not_explained_whoever_asked_for_it():
    for asked, words in ((True, ""), (False, ", and nothing asked for it")):
        assert not sunk((0.0, 0.0), (1.0, 0.5), asked=asked, fastest=0.5).unexplained
        fast = sunk((0.0, 0.0), (1.0, 1.125), asked=asked, fastest=0.5)
        assert fast.unexplained
        assert fast.words == f"sinking at 1.12 m/s at 1.1 m{words}"


def test_half_a_metre_deeper_than_the_vehicle_dives_is_noise_and_more_is_not():
    assert not sunk((0.0, 0.0), (1.0, 1.0), asked=True, fastest=0.5).unexplained
    assert sunk((0.0, 0.0), (1.0, 1.001), asked=True, fastest=0.5).unexplained
    slow = ((0.0, 0.0), (2.0, 1.25), (4.0, 2.5))  # 0.25 m deeper with each
    assert not sunk(*slow, asked=True, fastest=0.5).unexplained
    assert sunk(*slow, (6.0, 3.75), asked=True, fastest=0.5).unexplained
    assert not sunk(*slow, (6.0, 3.0), (8.0, 4.25), asked=True, fastest=0.5).unexplained
    assert not sunk((0.0, 0.0), (2.0, 1.4), (13.0, 9.0), (15.0, 10.4), asked=True,
                    fastest=0.5).unexplained  # fmt: skip


def test_a_depth_that_is_not_known_is_no_descent_and_no_end_of_one():
    descent = sunk((0.0, 0.0), (2.0, 4.0), (4.0, None))
    assert descent.unexplained is None
    descent = sunk((0.0, 0.0), (2.0, None), (4.0, 4.0))
    assert descent.unexplained


# --- steering -------------------------------------------------------------------------------


def turned(*reports: tuple[float, float | None, float | None]) -> Steering:
    """After these headings and wanted headings, in degrees, at these times."""
    steering = Steering()
    for t, heading, wanted in reports:
        a, b = (None if x is None else x * DEG for x in (heading, wanted))
        steering.take(t, a, b)
    return steering


@pytest.mark.parametrize(
    ("reports", "astray"),
    [
        ([(0, 0, 0), (10, 31, 0)], True),
        ([(0, 0, 0), (9.999, 31, 0)], False),
        ([(0, 0, 0), (10, 30.5, 0)], True),
        ([(0, 0, 0), (10, 29.9, 0)], False),
        ([(0, 0, 0), (10, -30.5, 0)], True),
        ([(0, 15, 0), (10, 35.1, 0)], True),
        ([(0, 15, 0), (10, 34.9, 0)], False),
        ([(0, 350, 0), (10, 329, 0)], True),
        ([(0, 90, 90), (10, 121, 90)], True),
        ([(0, 5, 355), (10, 26, 355)], True),
    ],
)
def test_a_heading_is_astray_when_its_error_grew_by_20_deg_beyond_30_in_10_s(reports, astray):
    steering = turned(*reports)
    assert steering.astray is astray
    assert steering.words.startswith("heading 3") is astray


@pytest.mark.parametrize(("back_to", "astray"), [(49.9, False), (50.1, True)])
def test_an_error_that_shrinks_by_more_than_10_deg_is_being_mended(back_to: float, astray: bool):
    """Also where it had grown before, and grows again."""
    steering = turned((0, 0, 0), (4, 60, 0), (8, back_to, 0), (10, back_to, 0), (12, 58, 0))
    assert steering.astray is astray
    steering = turned((0, 0, 0), (4, 60, 0), (6, 52, 0), (8, back_to, 0), (12, 58, 0))
    assert steering.astray is astray


@pytest.mark.parametrize(("to", "astray"), [(15.1, False), (14.9, True), (-14.9, True)])
def test_a_heading_that_is_set_anew_by_more_than_15_deg_begins_anew(to: float, astray: bool):
    assert turned((0, 0, 0), (5, 0, to), (10, 60, to)).astray is astray
    on = 170.0
    assert turned((0, on, on), (5, on, on + to), (10, on + 60, on + to)).astray is astray


def test_without_a_heading_nothing_is_astray_and_without_a_wanted_one_all_begins_anew():
    assert turned((0, 0, 0), (10, None, 0)).astray is None
    assert turned((0, 0, 0), (5, None, 0), (10, 40, 0)).astray is True
    assert turned((0, 0, 0), (10, 40, None)).astray is None
    assert turned((0, 0, 0), (5, 0, None), (10, 40, 0)).astray is False


def rounds(rate: float, wanted: Callable[[float], float], most: float = 600.0) -> float | None:
    """When what turns by so many deg a second, reported every 2 s, is astray; None: not by then."""
    steering = Steering()
    for i in range(int(most / 2.0)):
        t = 2.0 * i
        steering.take(t, math.radians(rate * t) % math.tau, math.radians(wanted(t)))
        if steering.astray:
            assert steering.words
            return t
    return None


@pytest.mark.parametrize("rate", [-80.0, -30.0, 5.0, 15.0, 18.0, 25.0, 30.0, 40.0, 60.0, 80.0])
def test_what_turns_round_and_round_past_its_heading_is_astray(rate: float):
    """However fast: its error grows, and shrinks again, within the time that it has to grow."""
    at = rounds(rate, lambda t: 0.0)
    assert at is not None
    assert at <= 30.0


@pytest.mark.parametrize("step", [8.0, 14.0, 16.0])
def test_what_is_led_round_and_round_by_the_heading_that_is_set_is_not_astray(step: float):
    assert rounds(1.0, lambda t: step * math.floor(t / step), most=1500.0) is None


def test_what_turned_round_is_forgotten_with_a_new_heading():
    assert rounds(30.0, lambda t: 0.0 if t < 20.0 else 180.0, most=38.0) is None


# --- progress -------------------------------------------------------------------------------


def dived(*reports: tuple[float, float | None, float | None]) -> Progress:
    progress = Progress()
    for t, depth, wanted in reports:
        progress.take(t, depth, wanted)
    return progress


@pytest.mark.parametrize(
    ("reports", "stuck"),
    [
        ([(0, 5, 10), (120, 5, 10)], True),
        ([(0, 5, 10), (119.999, 5, 10)], False),
        ([(0, 8, 10), (120, 8, 10)], False),
        ([(0, 7.999, 10), (120, 7.999, 10)], True),
        ([(0, 12.001, 10), (120, 12.001, 10)], True),
        ([(0, 5, 10), (60, 5.5, 10), (120, 5.5, 10)], False),
        ([(0, 5, 10), (60, 5.499, 10), (120, 5.499, 10)], True),
        ([(0, 5, 10), (60, 5, 11), (120, 5, 11)], True),
        ([(0, 5, 10), *((float(t), 5, 10 - t // 30 % 2 * 2) for t in range(0, 121, 5))], True),
        ([(0, 5, 10), (60, 5.5, 11), (120, 5.5, 10)], False),
        ([(0, 5, 8), (60, 5.2, 10), (120, 5.4, 10)], True),
        ([(0, 5, 10), (60, 5, 12.5), (120, 5, 12.5)], False),
        ([(0, 5, 7.5), (60, 5, 6.5), (120, 5, 7.5)], False),
        ([(0, 5, 7.5), (60, 8, 6.5), (120, 8, 5.5)], False),
        ([(0, 5, 10), (60, 5, None), (61, 5, 10), (120, 5, 10)], False),
        ([(0, 5, 10), (60, None, 10), (120, 5, 10)], True),
        ([(0, 5, 10), (120, None, 10)], None),
        ([(0, 5, None), (120, 5, None)], None),
    ],
)
def test_a_depth_is_stuck_when_it_came_no_half_metre_nearer_in_two_minutes(reports, stuck):
    assert dived(*reports).stuck is stuck


# --- the watch ------------------------------------------------------------------------------


def watch(*, vehicle=VEHICLE, **report: object) -> LimitMonitor:
    """At 10 s, with one report; nothing is set."""
    vehicle_state = VehicleState(Navigation())
    one = LimitMonitor(vehicle, vehicle_state, in_force(vehicle, None, SetSafety()))
    heard(one, 10.0, **report)
    return one


def heard(one: LimitMonitor, t: float, **report: object) -> None:
    base = Telemetry(
        t=t, depth=5.0, altitude=9.0, heading=0.0, actuators=NEUTRAL, batteries=(12.0, 48.0)
    )
    one.vehicle_state.at(t)
    one.vehicle_state.take_telemetry(base._replace(**report))
    one.take_report()


def sinks(sent: Setpoint | None, *, to: float = 8.0, **report: object) -> bool | None:
    """From 5 m within 2 s while this is in force: whether that is not explained."""
    one = watch(vehicle=replace(VEHICLE, limits=replace(VEHICLE.limits, descent_rate=50.0)))
    one.set_sent(sent)
    heard(one, 12.0, depth=to, **report)
    return one.descent.unexplained


def test_a_dive_is_asked_for_until_half_a_metre_below_the_depth_that_is_set():
    assert sinks(None)
    assert sinks(Setpoint(surge=0.5))
    assert sinks(Setpoint(depth=7.5), to=8.0)
    assert not sinks(Setpoint(depth=7.5), to=7.999)
    assert not sinks(Setpoint(depth=0.0), to=0.4)


def test_a_dive_is_asked_for_until_half_a_metre_below_the_altitude_that_is_set():
    assert sinks(Setpoint(altitude=9.0), altitude=8.5)
    assert not sinks(Setpoint(altitude=9.0), altitude=8.501)
    assert not sinks(Setpoint(altitude=9.0), altitude=None)
    assert sinks(Setpoint(altitude=0.75), altitude=0.0)


def test_an_altitude_that_is_not_to_be_believed_may_be_any():
    one = watch()
    one.vehicle = replace(VEHICLE, limits=replace(VEHICLE.limits, descent_rate=50.0))
    one.set_sent(Setpoint(altitude=9.0))
    navigation: Any = one.vehicle_state.navigation
    navigation.doubt["altitude"] = "frozen"
    heard(one, 12.0, depth=8.0, altitude=1.0)
    assert one.descent.unexplained is False


def test_thrust_downward_asks_for_a_dive_and_thrust_upward_for_none():
    assert not sinks(Setpoint(heave=0.01))
    assert sinks(Setpoint(heave=0.0))
    assert sinks(Setpoint(heave=-0.5))


@pytest.mark.parametrize(("surge", "pitch"), [(0.5, -0.1), (-0.5, 0.1)], ids=["ahead", "astern"])
def test_way_on_along_a_bow_that_points_down_asks_for_a_dive_and_no_other_way_does(surge, pitch):
    assert not sinks(Setpoint(surge=surge, pitch=pitch))
    assert sinks(Setpoint(surge=-surge, pitch=pitch)), "it leads up"
    assert sinks(Setpoint(surge=0.0, pitch=pitch)), "without way it leads nowhere"
    assert sinks(Setpoint(surge=surge, pitch=0.0))
    assert sinks(Setpoint(surge=surge, pitch=pitch, depth=7.5)), "0.5 m below what is held"


def test_an_ascent_of_a_leg_answers_for_its_own_sinking():
    one = watch()
    one.descent.excuse()
    heard(one, 12.0, depth=8.0)
    assert one.descent.unexplained is (VEHICLE.limits.descent_rate < 1.5)


@pytest.mark.parametrize(
    ("t", "thrust", "turns"),
    [
        (10.5, 0.03, True),
        (10.499, 0.03, False),
        (10.5, 0.02, False),
        (10.5, -0.03, True),
        (10.5, None, False),
    ],
)
def test_a_thruster_turns_if_a_report_from_half_a_second_later_says_so(t, thrust, turns):
    one = watch()
    values = None if thrust is None else (0.0, 0.0, 0.0, 0.0, thrust, 1.0)
    heard(one, t, actuators=values)
    assert one.turning(10.0) is turns


@pytest.mark.parametrize(
    ("t", "ahead", "turns"),
    [(12.0, 0.06, True), (11.99, 0.06, False), (12.0, 0.05, False), (12.0, -0.06, True)],
)
def test_what_drives_has_way_if_a_report_from_two_seconds_later_says_so(t, ahead, turns):
    one = watch()
    one.vehicle = load_vehicle("robot")
    heard(one, t, velocity=(ahead, 0.0, 0.0))
    assert one.turning(10.0) is turns
    one.vehicle = load_vehicle("auv")  # it drifts, and has a depth to be judged by
    assert not one.turning(10.0)


def test_rudders_are_no_thrusters():
    one = watch()
    heard(one, 12.0, actuators=(*NEUTRAL, 1.0, 1.0))
    assert not one.turning(10.0)
    one.set_sent(Setpoint(surge=0.5))
    one.accepted_at = 10.0
    assert one.powerless()


@pytest.mark.parametrize("sent", [Setpoint(surge=0.1), Setpoint(turn=0.1), Setpoint(heave=0.1)])
def test_thrust_that_was_accepted_half_a_second_ago_turns_a_thruster_or_power_is_gone(sent):
    one = watch()
    one.set_sent(sent)
    heard(one, 12.0)
    assert one.powerless() is None, "not accepted yet"
    one.accepted_at = 11.501
    assert one.powerless() is None
    one.accepted_at = 11.5
    assert one.powerless() is True
    one.repeated = True
    heard(one, 14.0, actuators=(0.0, 0.0, 0.0, 0.0, -0.03))
    assert one.powerless() is False
    assert not one.repeated
    heard(one, 16.0, actuators=())
    assert one.powerless() is None


def closed_by_the_pi(*headings: tuple[float, float | None], held: bool = True) -> LimitMonitor:
    """A ROV that goes ahead, by a heading where it is ``held``; every thruster is neutral."""
    rov = load_vehicle("rov")
    assert rov.outer_loop is not None
    one = watch()
    one.vehicle = replace(rov, outer_loop=replace(rov.outer_loop, confirmed="2026-06-01"))
    one.set_sent(Setpoint(surge=0.3, heading=1.0 if held else None))
    one.accepted_at = 0.0
    for t, heading in headings:
        heard(one, t, heading=heading)
    return one


@pytest.mark.parametrize(
    ("headings", "gone"),
    [
        (((19.5, 1.0), (20.0, 1.0)), True),
        (((19.5, 1.0), (20.0, None)), True),
        (((19.0, 1.0), (19.5, 1.0), (20.0, None)), True),
        (((19.0, 1.0), (19.4, 1.0), (20.0, None)), None),
        (((19.2, 1.0), (20.0, 1.0)), None),
        (((19.2, 1.0), (20.0, 1.0), (20.4, 1.0)), None),
        (((19.2, 1.0), (20.0, 1.0), (20.5, 1.0)), True),
    ],
)
def test_thrusters_that_the_pi_itself_made_neutral_are_not_without_power(headings, gone):
    """R17: it does where the report of an axis that it holds is older than half a second."""
    assert closed_by_the_pi(*headings).powerless() is gone
    assert closed_by_the_pi(*headings, held=False).powerless() is True
    unconfirmed = closed_by_the_pi(*headings)
    unconfirmed.vehicle = load_vehicle("rov")
    assert unconfirmed.powerless() is True


def test_a_heading_that_its_report_flags_is_none_that_thrusters_turn_by():
    one = closed_by_the_pi((19.0, 1.0), (19.4, 1.0))
    for t in (19.8, 20.0):
        heard(one, t, heading=4.9, faults=("ez_deg:out_of_range",))
    assert one.powerless() is None


def test_where_nothing_is_asked_of_the_thrusters_power_is_not_gone():
    one = watch()
    assert one.powerless() is None
    one.set_sent(Setpoint(depth=5.0))
    one.accepted_at = 10.0
    heard(one, 12.0)
    assert one.powerless() is False


def at_the_surface(**changes: Any) -> LimitMonitor:
    """Under way ahead at the surface, the course 61 deg off the bow."""
    one = watch(depth=changes.pop("depth", 0.2))
    one.set_sent(Setpoint(surge=changes.pop("surge", 1.0)))
    if changes.pop("doubt", ""):
        navigation: Any = one.vehicle_state.navigation
        navigation.doubt["heading"] = "frozen"
        one.vehicle_state.at(10.0)
    known = {"course": 61.0 * DEG, "speed": 0.8} | changes
    one.vehicle_state.take_fix(Fix(10.0, 0.5, 2.0, 2.5, **known))
    return one


@pytest.mark.parametrize(
    ("changes", "apart"),
    [
        ({}, True),
        ({"course": 59.0 * DEG}, False),
        ({"course": -61.0 * DEG}, True),
        ({"course": None}, None),
        ({"speed": None}, None),
        ({"speed": 0.4}, True),
        ({"speed": 0.399}, False),
        ({"surge": 0.0}, False),
        ({"depth": 0.8}, None),  # or a wave has lifted the surface above it
        ({"depth": 0.799}, True),
        ({"depth": None}, None),
        ({"doubt": "heading"}, None),
    ],
)
def test_a_course_is_apart_from_the_bow_at_the_surface_and_under_way_alone(changes, apart):
    assert at_the_surface(**changes).course_apart() is apart


def test_without_a_fix_a_set_or_an_estimate_no_course_is_apart():
    assert watch(depth=0.2).course_apart() is None
    one = at_the_surface()
    one.set_sent(None)
    assert one.course_apart() is None
    one = at_the_surface()
    assert one.vehicle_state.estimate is not None
    one.vehicle_state.estimate = one.vehicle_state.estimate._replace(heading=None)
    assert one.course_apart() is None
    one.vehicle_state.estimate = None
    assert one.course_apart() is None


@pytest.mark.parametrize("later", [12.0, 100.0])  # stuck, and of before a dive
def test_a_place_that_is_said_again_tells_no_course(later: float):
    one = at_the_surface()
    one.vehicle_state.take_fix(Fix(later, 0.5, 2.0, 2.5, course=61.0 * DEG, speed=0.8))
    assert one.course_apart() is None


def test_a_course_is_held_against_where_the_bow_points():
    for heading, apart in ((100.0, False), (61.0, False), (-1.0, True), (123.0, True)):
        one = at_the_surface()
        assert one.vehicle_state.estimate is not None
        one.vehicle_state.estimate = one.vehicle_state.estimate._replace(heading=heading * DEG)
        assert one.course_apart() is apart


def test_a_gear_that_makes_0_4_m_a_second_is_under_way_and_a_slower_one_not():
    speeds = VEHICLE.speed_by_gear
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if speeds.at(GEARS * middle) >= 0.4 else (middle, high)
    assert at_the_surface(surge=high + 1e-6).course_apart() is True
    assert at_the_surface(surge=low - 1e-6).course_apart() is False


# --- time -----------------------------------------------------------------------------------


def test_the_next_deadline_is_the_first_of_those_that_wait():
    one = watch()
    assert one.next_timer() == 10.0 + SILENCE
    one.topside_silence, one.topside_heard = 3.0, 9.0
    assert one.next_timer() == 12.0
    one.started, one.bounds = 10.0, replace(one.bounds, time=1.5)
    assert one.next_timer() == 11.5
    one.blind_since = 5.25
    assert one.next_timer() == 5.25 + BLIND_TIME
    one.begin(20.0)
    assert one.next_timer() == min(20.0 + SILENCE, 11.5)


def test_whoever_was_never_heard_is_silent_and_nothing_is_lost_yet():
    one = LimitMonitor(VEHICLE, VehicleState(), in_force(VEHICLE, None, SetSafety()))
    one.topside_silence = 30.0
    assert {row.name for row in one.look(False, False)} == {"telemetry", "topside"}
    assert one.lost == 0


def test_a_mission_that_begins_is_heard_now_and_has_lost_nothing():
    one = watch()
    one.topside_silence, one.lost, one.repeated = 3.0, 2, True
    one.lost_words = {b"@ZAH": (3, 40.0)}
    assert one.unanswered == 3
    one.begin(50.0)
    assert one.unanswered == 0
    assert (one.heard, one.topside_heard, one.lost, one.repeated) == (50.0, 50.0, 0, False)
    assert (one.breaches, one.blind_since) == ((), None)
    assert one.descent.unexplained is None


@pytest.mark.parametrize(("apart", "times"), [(20.0, 3), (60.0, 3), (60.1, 1)])
def test_words_that_were_lost_long_ago_are_not_counted(apart: float, times: int) -> None:
    """One that is never answered is said again within seconds."""
    one, sent = watch(), Setpoint(surge=0.5, heading=0.0, depth=3.0)
    one.set_sent(sent)
    for i in range(3):
        one.vehicle_state.at(10.0 + i * apart)
        one.count(Outcome(Result.LOST, b"@ZAH0$", sent))
        one.count(Outcome(Result.ACCEPTED, b"@ZAS3$", sent))
    assert one.unanswered == times


def test_a_limit_of_the_clock_that_is_breached_stays_so_until_its_next_look():
    one = watch()
    one.vehicle_state.at(10.0 + SILENCE)
    (silent,) = one.look(reported=False, fixed=False)
    assert silent.name == "telemetry"
    assert one.breaches == (silent,)
    heard(one, 16.0)
    assert one.look(reported=True, fixed=False) == []
    assert one.breaches == ()


def test_what_reports_breach_stays_breached_while_only_the_clock_goes_on():
    one = watch(roll=3.0)
    one.look(reported=True, fixed=False)
    heard(one, 12.0, roll=3.0)
    (over,) = one.look(reported=True, fixed=False)
    assert over.on is On.REPORT
    assert one.look(reported=False, fixed=False) == []
    assert one.breaches == (over,)
    one.vehicle_state.at(12.0 + SILENCE)
    (silent,) = one.look(reported=False, fixed=False)
    assert one.breaches == (over, silent)


@pytest.mark.parametrize("angle", ["roll", "pitch"])
def test_a_roll_over_is_either_angle_beyond_the_vehicles_own(angle: str):
    lies = {"roll": 0.0, "pitch": 0.0, angle: VEHICLE.limits.roll + 0.01}
    one = watch(**lies)
    rows = one.look(reported=True, fixed=False)
    heard(one, 12.0, **lies)
    rows += one.look(reported=True, fixed=False)
    assert [row.name for row in rows] == ["roll-over"]


@pytest.mark.parametrize("hertz", [10.0, 50.0])
def test_one_reading_that_a_fast_board_says_many_times_is_one_sample(hertz: float):
    """For 0.8 s; what lies on its side longer than that has rolled over."""
    one, row, lies = watch(), LIMITS["roll-over"], VEHICLE.limits.roll + 0.01
    for i in range(1, int(9.0 * hertz)):
        t = i / hertz
        over = 2.0 <= t < 2.8 or 4.0 <= t < 4.8 or t >= 6.0
        heard(one, 10.0 + t, roll=lies if over else 0.0, pitch=0.0)
        found = row in one.look(reported=True, fixed=False)
        assert found is (t > 6.9) or abs(t - 6.9) < 0.01


@pytest.mark.parametrize(("wild", "ends"), [(1, False), (2, True)])
def test_one_wild_heading_ends_no_leg_and_two_do(wild: int, ends: bool):
    """A compass may turn by half a circle in 2 s, so that its health says nothing of one."""
    one, found = watch(), []
    one.set_sent(Setpoint(surge=0.5, heading=0.0))
    for i in range(1, 20):
        heard(one, 10.0 + 2.0 * i, heading=70.0 * DEG if 10 <= i < 10 + wild else 0.0)
        found += one.look(reported=True, fixed=False)
    assert (LIMITS["heading does not follow"] in found) is ends


def test_two_reports_that_come_together_are_one_sample():
    """The first was read late."""
    one = watch(roll=3.0)
    one.look(reported=True, fixed=False)
    heard(one, 10.005, roll=3.0)
    assert one.look(reported=True, fixed=False) == []
    heard(one, 11.805, roll=3.0)
    assert one.look(reported=True, fixed=False) == [LIMITS["roll-over"]]


def test_a_vehicle_that_may_lie_on_its_side_has_rolled_over_beyond_its_own_limit_alone():
    own = replace(VEHICLE, limits=replace(VEHICLE.limits, roll=math.radians(110.0)))
    one, row = watch(vehicle=own), LIMITS["roll-over"]
    one.vehicle_state.navigation.doubt["attitude"] = "absurd"  # beyond the document's range
    for second, (degrees, over) in enumerate(
        ((95.0, None), (105.0, None), (108.0, None), (112.0, True), (112.0, True), (80.0, None))
    ):
        heard(one, 12.0 + second, roll=math.radians(degrees), pitch=0.0)
        assert row.breached(one) is over


def test_a_limit_that_is_forgiven_counts_anew():
    one = watch(roll=3.0)
    row = next(row for row in LIMITS.values() if row.name == "roll-over")
    for _ in range(3):
        assert one.look(reported=True, fixed=False) == []
        one.forgive(row)
    assert one.look(reported=True, fixed=False) == []
    heard(one, 12.0, roll=3.0)
    assert one.look(reported=True, fixed=False) == [row]


def test_a_clone_goes_its_own_way():
    one = watch(roll=3.0)
    one.look(reported=True, fixed=False)
    other = one.clone(one.vehicle_state.clone())
    heard(other, 12.0, depth=8.0, roll=3.0)
    other.look(reported=True, fixed=False)
    assert one.breaches == ()
    assert one.descent.unexplained is None
    assert one.samples != other.samples
    other.set_sent(Setpoint(surge=0.5))
    assert one.vehicle_state.command is None


def test_the_blindness_of_a_submerged_vehicle_counts_from_its_first_look():
    one = watch()
    navigation: Any = one.vehicle_state.navigation
    one.look(reported=True, fixed=False)
    assert one.blind_since is None
    navigation.doubt["depth"] = "frozen"
    for t in (12.0, 14.0):
        one.vehicle_state.at(t)
        one.look(reported=False, fixed=False)
        assert one.blind_since == 12.0
    navigation.doubt.clear()
    one.vehicle_state.at(15.0)
    one.look(reported=False, fixed=False)
    assert one.blind_since is None


@pytest.mark.parametrize(
    "down",
    [Setpoint(altitude=4.0), Setpoint(heave=0.1), Setpoint(surge=0.5, pitch=-0.1)],
    ids=["altitude", "thrust", "nose"],
)
def test_one_that_was_led_down_without_a_depth_is_blind_until_the_surface_is_known(down):
    """Though the last depth that was believed was that of the surface."""
    one = watch(depth=0.2)
    navigation: Any = one.vehicle_state.navigation
    navigation.doubt["depth"] = "frozen"
    one.set_sent(down)
    look_at(one, 12.0)
    assert one.blind_since == 12.0
    one.set_sent(Setpoint(surge=0.5))
    look_at(one, 14.0)
    assert one.blind_since == 12.0
    navigation.doubt.clear()
    look_at(one, 15.0)
    navigation.doubt["depth"] = "frozen"
    look_at(one, 16.0)
    assert one.blind_since is None


def test_legs_that_hold_a_depth_one_after_the_other_are_blind_when_none_was_left_for_it():
    """A leg of 5 s is over before the 6 s that it would wait for its depth."""
    one = watch(depth=0.2)
    navigation: Any = one.vehicle_state.navigation
    navigation.doubt["depth"] = "frozen"
    one.set_sent(Setpoint(depth=4.0))
    for t in (12.0, 16.0, 19.5):
        look_at(one, t)
        assert one.blind_since is None
    one.set_sent(Setpoint(depth=6.0))
    look_at(one, 20.0)
    assert one.blind_since == 20.0


def test_a_leg_that_holds_a_depth_needs_it_itself_and_the_next_one_is_blind():
    one = watch(depth=0.2)
    navigation: Any = one.vehicle_state.navigation
    navigation.doubt["depth"] = "frozen"
    one.set_sent(Setpoint(depth=4.0))
    look_at(one, 12.0)
    assert one.blind_since is None
    one.set_sent(Setpoint(surge=0.5))
    look_at(one, 14.0)
    assert one.blind_since == 14.0


@pytest.mark.parametrize(("started", "blind"), [(8.0, True), (16.0, False)])
def test_one_whose_fixes_of_this_mission_have_ended_is_blind(started: float, blind: bool):
    one = watch(depth=0.2)
    navigation: Any = one.vehicle_state.navigation
    navigation.doubt["depth"] = "frozen"
    one.started = started
    one.vehicle_state.take_fix(Fix(12.0, 0.5, 2.1, 2.5, hdop=1.0))
    look_at(one, 32.0)
    assert one.blind_since is None
    look_at(one, 32.5)
    assert one.blind_since == (32.5 if blind else None)


def look_at(one: LimitMonitor, t: float) -> None:
    one.vehicle_state.at(t)
    one.look(reported=False, fixed=False)


def test_at_the_surface_nobody_is_blind():
    one = watch(depth=0.2)
    navigation: Any = one.vehicle_state.navigation
    navigation.doubt["depth"] = "frozen"
    one.vehicle_state.at(12.0)
    one.look(reported=False, fixed=False)
    assert one.blind_since is None
