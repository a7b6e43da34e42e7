"""What else is known of going up and down contradicts a depth, and what is natural does not."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from random import Random

import pytest

from mission.model import Vertical
from mission.navigation.belief import DepthBelief
from mission.navigation.fixes import Receiver
from protocol.messages import Fix

DOWN, UP, HOLD = Vertical(0.83, 10.0), Vertical(-1.0, -math.inf), Vertical(0.42, 10.0)
REST = Vertical(0.0, None)
PERIOD = 2.0


class Dive:
    """Reports every 2 s, fixes every second while they come."""

    def __init__(self, seed: int = 1, noise: float = 0.1) -> None:
        self.rng, self.noise = Random(seed), noise
        self.belief, self.receiver = DepthBelief(), Receiver()
        self.t, self.mains = 0.0, 0.0

    def go(
        self,
        seconds: float,
        push: Vertical,
        depth: Callable[[float], float],
        altitude: Callable[[float], float | None] = lambda s: None,
        *,
        fixes: bool = False,
    ) -> str:
        """``depth`` and ``altitude`` are told s from the beginning; the reason at the end."""
        begun = self.t
        while self.t < begun + seconds - 1e-6:
            if fixes:
                self.fix()
                self.fix(0.9)
            shown = depth(self.t - begun) + self.rng.gauss(0.0, self.noise)
            high = altitude(self.t - begun)
            self.belief.take(self.t, shown, high, self.mains, push, self.receiver)
            self.t += PERIOD
        return self.belief.reason

    def fix(self, after: float = 0.0, **changes: float) -> None:
        place = 0.5 + 1e-7 * self.rng.gauss(0.0, 1.0)
        self.receiver.take(Fix(self.t + after, place, 2.0, 2.5, **changes))  # type: ignore[arg-type]


def at(depth: float) -> Callable[[float], float]:
    return lambda s: depth


def sinking(rate: float, start: float = 0.2) -> Callable[[float], float]:
    return lambda s: start + rate * s


def near(dive: Dive) -> Callable[[float], float]:
    """The ground, as a noisy altimeter hears it."""
    return lambda s: max(0.05, 0.3 + dive.rng.gauss(0.0, 0.05))


# --- contradicted ------------------------------------------------------------------------------


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.1, 0.3])
@pytest.mark.parametrize("push", [DOWN, Vertical(None, 10.0), Vertical(0.6, 10.0)])
@pytest.mark.parametrize("seed", range(5))
def test_a_depth_that_stands_under_a_push_is_contradicted_within_18_seconds(noise, push, seed):
    dive = Dive(seed, noise)
    assert dive.go(12.0, push, sinking(0.35)) == ""
    assert dive.go(18.0, push, at(4.2)).startswith("contradicted: the verticals push down")


def test_one_that_stands_from_the_beginning_of_the_dive_is_too():
    dive = Dive()
    assert dive.go(60.0, REST, at(0.2), fixes=True) == ""
    assert dive.go(18.0, DOWN, at(0.2)).startswith("contradicted")


def test_one_that_stands_at_depth_though_the_verticals_push_up_is_too():
    assert Dive().go(18.0, UP, at(6.0)).startswith("contradicted: the verticals push up")


@pytest.mark.parametrize("rises", [0.8, 1.0, 1.2])
def test_a_stick_that_had_it_between_two_reports_has_ended_the_push(rises: float):
    """As built there are none while it drives. It rose meanwhile, and the dive that went on was a
    depth that stood under a push."""
    dive = Dive(noise=0.0)
    dive.go(16.0, DOWN, sinking(0.3))
    dive.t += 4.0  # driven by hand
    dive.go(2.0, REST, at(4.7 - rises))
    assert dive.go(6.0, DOWN, sinking(0.3, 4.6 - rises)) == ""


def test_where_fixes_have_ended_half_a_metre_short_is_enough_for_the_set_alone():
    for fixes, contradicted in ((True, True), (False, False)):
        dive, push = Dive(noise=0.02), Vertical(None, 1.0)
        dive.go(20.0, REST, at(0.2), fixes=fixes)
        assert bool(dive.go(30.0, push, at(0.2))) is contradicted


@pytest.mark.parametrize("rate", [0.3, -0.3])
def test_ground_that_comes_nearer_or_goes_while_the_depth_stands_contradicts_it(rate):
    dive = Dive()
    dive.go(60.0, HOLD, at(9.8), at(20.0))
    reason = dive.go(20.0, HOLD, at(9.8), lambda s: 20.0 - rate * s)
    way = "comes nearer" if rate > 0.0 else "goes"
    assert reason.startswith(f"contradicted: the ground {way} by ")


@pytest.mark.parametrize("rate", [0.05, -0.05, -0.3, -0.8])
def test_what_floats_by_depth_and_fixes_may_drift_over_any_slope(rate):
    """Without fixes it may be sinking, or rising, with a port that is clogged."""
    for fixes in (True, False):
        dive = Dive(noise=0.02)
        dive.go(80.0, REST, at(0.2), at(60.0), fixes=True)
        reason = dive.go(120.0, REST, at(0.2), lambda s: 60.0 - rate * s, fixes=fixes)
        assert bool(reason) is not fixes


def test_what_floats_by_depth_and_fixes_and_comes_nearer_the_ground_quickly_sinks_maybe():
    dive = Dive(noise=0.02)
    dive.go(80.0, REST, at(0.2), at(60.0), fixes=True)
    assert dive.go(30.0, REST, at(0.2), lambda s: 60.0 - 0.3 * s, fixes=True) != ""


def test_a_depth_that_goes_faster_than_a_body_does_is_contradicted():
    assert "no body" in Dive().go(16.0, HOLD, lambda s: 40.0 - 1.8 * s)


@pytest.mark.parametrize("stands_for", [18.0, 22.0, 30.0, 60.0])
def test_an_offset_that_ends_as_soon_as_it_is_contradicted_has_moved_too(stands_for):
    """At the surface, with fixes: from 1.0 m to 0.2 m at once, and no more than that."""
    dive = Dive(noise=0.02)
    assert dive.go(stands_for, UP, at(1.0), fixes=True).startswith("contradicted")
    assert dive.go(30.0, UP, at(0.2), fixes=True) == ""


@pytest.mark.parametrize("off", [1.5, -1.5])
def test_an_offset_is_contradicted_by_half_a_minute_of_fixes(off):
    dive = Dive()
    assert dive.go(30.0, REST, at(off), fixes=True) == ""
    assert dive.go(18.0, REST, at(off), fixes=True).startswith("contradicted: fixes come")


@pytest.mark.parametrize("seed", range(20))
def test_noise_about_a_depth_that_the_air_makes_is_no_offset(seed: int):
    """1035 hPa, and a coarse sensor: one half of the window says 0.8 m, both seldom do."""
    assert Dive(seed, noise=0.2).go(600.0, REST, at(0.55), fixes=True) == ""


@pytest.mark.parametrize("gap", [3.0, 5.0, 7.0])
def test_an_offset_is_contradicted_though_waves_wash_over_the_antenna(gap: float):
    dive, reason = Dive(noise=0.05), ""
    for _ in range(12):
        dive.fix()
        dive.fix(0.9)
        reason = dive.go(gap // PERIOD * PERIOD + PERIOD, REST, at(1.5))
    assert reason.startswith("contradicted: fixes come")


def test_a_drift_is_contradicted_by_fixes_once_a_push_upward_does_not_bring_it_up():
    dive = Dive()
    assert dive.go(60.0, REST, lambda s: 3.0 + 0.1 * s, fixes=True) == ""
    dive.go(10.0, UP, lambda s: 9.0 + 0.1 * s, fixes=True)
    assert dive.belief.reason.startswith("contradicted: fixes come")


def test_a_leap_is_contradicted_at_once():
    belief = DepthBelief()
    belief.leap(3.0, -4.0)
    assert belief.reason == "contradicted: it leapt by -4.0 m"


# --- natural -------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [0.1, 0.35, 0.6])
@pytest.mark.parametrize("seed", range(20))
def test_a_dive_and_a_rise_at_any_pace_are_natural(rate, seed):
    dive = Dive(seed)
    assert dive.go(80.0, Vertical(0.83, 99.0), sinking(rate)) == ""
    assert dive.go(80.0, UP, sinking(-rate, 0.2 + 80.0 * rate)) == ""


@pytest.mark.parametrize(
    "push",
    [HOLD, Vertical(0.5, 10.0), Vertical(0.7, 10.0), Vertical(None, 10.0), Vertical(-0.3, 10.0)],
)
def test_to_hover_against_buoyancy_is_natural(push):
    dive = Dive()
    dive.mains = 0.5
    assert dive.go(1800.0, push, at(9.8), lambda s: 12.0 + 3.0 * math.sin(0.02 * s)) == ""


def test_a_hold_that_is_always_a_little_short_is_natural():
    """Without an integral part: it pushes as much as the buoyancy asks for, and is never there."""
    for short, push in ((0.9, Vertical(0.5, 10.0)), (0.9, Vertical(None, 10.0))):
        assert Dive(noise=0.02).go(600.0, push, at(10.0 - short)) == ""


def test_a_push_that_moves_no_depth_is_doubted_whatever_the_receiver_says():
    """A port that clogged on deck and a receiver that makes places up under water: 41 m, where 8
    were asked. A vehicle that is truly too light to dive loses a mission that fails anyway."""
    assert "push down and it stands at 0.2 m" in Dive().go(20.0, DOWN, at(0.2), fixes=True)


@pytest.mark.parametrize("places", [1, 2, 4, 20])
def test_places_that_a_stuck_receiver_says_in_turn_explain_no_depth_that_stands(places: int):
    """As flight 14711 of seed 1717: its port clogged at 0.4 m, it dived to the ground in 90 s."""
    dive = Dive()
    for i in range(places):
        dive.receiver.take(Fix(0.1 * i, 0.5 + 1e-7 * i, 2.0, 2.5))
    for second in range(10, 30):
        said = 0.5 + 1e-7 * (second % places)
        dive.receiver.take(Fix(float(second), said, 2.0, 2.5))
        dive.t = float(second)
        dive.belief.take(dive.t, 0.4, None, 0.3, DOWN, dive.receiver)
    assert dive.belief.reason


def test_to_push_at_the_surface_upward_is_natural():
    assert Dive().go(300.0, UP, at(0.2)) == ""


def test_to_lie_on_the_ground_is_natural_where_the_altimeter_says_so():
    def heard(s: float) -> float | None:
        return 0.3 if s % 40.0 == 0.0 else None

    assert Dive().go(300.0, DOWN, at(6.0), heard) == ""


@pytest.mark.parametrize("period", [4.0, 8.0, 11.9])
@pytest.mark.parametrize("phase", range(4))
def test_to_lie_on_the_ground_under_a_swell_is_natural_where_the_altimeter_says_so(period, phase):
    """A board that dives by itself held one at 6.7 m of a sea of 7 m, under waves of 0.6 m."""
    dive = Dive(noise=0.05)

    def swell(s: float) -> float:
        return 0.5 * math.sin(math.tau * (dive.t / period + phase / 4.0))

    dive.go(16.0, DOWN, lambda s: 0.3 + 0.4 * s + swell(s), lambda s: 6.7 - 0.4 * s)
    assert dive.go(1200.0, DOWN, lambda s: 6.7 + swell(s), near(dive)) == ""


@pytest.mark.parametrize("clogs_at", [3.0, 6.0, 9.6])
def test_an_altimeter_that_hears_itself_all_the_way_down_explains_no_depth_that_stands(clogs_at):
    dive = Dive(noise=0.03)
    assert dive.go(2.0 * clogs_at, DOWN, sinking(0.5), at(0.6)) == ""
    assert dive.go(20.0, DOWN, at(clogs_at), at(0.6)).startswith("contradicted: the verticals")


@pytest.mark.parametrize("heard", [10.0, 25.0])
@pytest.mark.parametrize("rings_at", [0.3, 0.98])
def test_ground_that_comes_near_faster_than_a_vehicle_sinks_explains_no_depth_that_stands(
    heard: float, rings_at: float
):
    """As flight 13397 of seed 11833: its port clogged, and seconds later its altimeter, 25 m above
    the ground, heard its own pulse. It was 30 m deep, where 20 m were allowed."""
    dive = Dive(noise=0.03)
    dive.mains = 0.4
    dive.go(10.0, DOWN, sinking(0.33), lambda s: heard + 3.3 - 0.33 * s)
    dive.go(6.0, DOWN, at(3.4), lambda s: heard - 0.33 * s)
    reason = dive.go(20.0, DOWN, at(3.4), lambda s: rings_at + dive.rng.gauss(0.0, 0.05))
    assert reason.startswith("contradicted: the verticals push down")


def test_a_step_of_the_ground_and_ground_that_was_last_heard_long_ago_are_ground():
    dive = Dive(noise=0.03)
    dive.go(10.0, DOWN, sinking(0.33), lambda s: 8.0 - 0.33 * s)
    assert dive.go(120.0, DOWN, at(3.4), near(dive)) == ""
    dive = Dive(noise=0.03)
    dive.go(20.0, DOWN, sinking(0.4), lambda s: 20.0 if s < 1.0 else None)
    assert dive.go(120.0, DOWN, at(8.0), near(dive)) == ""


def test_an_altimeter_that_has_heard_itself_is_believed_once_it_hears_far_ground():
    dive = Dive(noise=0.03)
    dive.go(10.0, REST, at(0.2), at(20.0), fixes=True)
    dive.go(10.0, REST, at(0.2), at(0.5), fixes=True)
    dive.go(40.0, DOWN, sinking(0.5), lambda s: max(0.3, 20.0 - 0.5 * s))
    assert dive.go(120.0, DOWN, at(20.0), near(dive)) == ""


@pytest.mark.parametrize("seed", range(4))
def test_to_crawl_along_a_slope_is_natural_where_the_altimeter_says_that_there_is_ground(seed):
    dive = Dive(seed, 0.05)
    dive.mains = 0.4
    dive.go(16.0, DOWN, sinking(0.6), lambda s: 9.9 - 0.6 * s)
    assert dive.go(300.0, DOWN, sinking(0.02, 9.8), near(dive)) == ""


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_an_altimeter_makes_no_other_ground(seed):
    dive = Dive(seed, 0.05)
    dive.go(16.0, DOWN, sinking(0.6), lambda s: 9.9 - 0.6 * s)
    assert dive.go(1200.0, DOWN, at(9.8), near(dive)) == ""


@pytest.mark.parametrize("step", [-2.4, 2.4])
def test_a_ledge_under_what_floats_is_natural(step):
    """One step between two reports, as slow as 1 m/s and 0.4 m allow."""
    dive = Dive(noise=0.05)
    assert dive.go(60.0, REST, at(0.2), at(32.0), fixes=True) == ""
    assert dive.go(60.0, REST, at(0.2), at(32.0 + step), fixes=True) == ""


def test_ground_that_was_heard_far_off_in_between_is_another_one():
    dive = Dive(noise=0.03)
    dive.go(60.0, DOWN, at(6.0), at(0.3))
    dive.go(20.0, Vertical(-0.6, 2.0), sinking(-0.2, 6.0), lambda s: 0.3 + 0.2 * s)
    dive.go(20.0, DOWN, sinking(0.5, 2.0), lambda s: 11.0 - 0.5 * s)
    assert dive.go(120.0, DOWN, at(12.0), at(0.3)) == ""


def test_no_echo_is_the_ground_where_it_says_it_is_at_the_surface_and_fixes_have_ended():
    dive = Dive(noise=0.03)
    dive.go(20.0, REST, at(0.2), at(0.6), fixes=True)
    assert dive.go(24.0, DOWN, at(0.2), at(0.6)).startswith("contradicted: the verticals push down")


@pytest.mark.parametrize("heard", [0.55, None])
def test_ground_that_an_altimeter_makes_up_keeps_no_depth_that_moves_from_belief(heard):
    """As flight 667 of seed 12237: contradicted at the surface by dead verticals, its altimeter
    ringing, a board that dives by itself took it down. Ground explains only a depth that stands."""
    dive = Dive(noise=0.03)
    assert dive.go(20.0, DOWN, at(0.2), fixes=True)
    assert dive.go(60.0, REST, at(0.2), at(heard), fixes=True)
    pushed = Vertical(1.0, None)
    assert dive.go(4.0, pushed, at(0.2), at(heard))
    assert dive.go(8.0, pushed, sinking(0.45), at(heard)) == ""


@pytest.mark.parametrize("push", [DOWN, UP])
def test_a_push_that_lapses_for_one_report_goes_on_and_for_two_it_has_ended(push):
    depth = at(4.2)
    dive = Dive(noise=0.03)
    assert dive.go(8.0, push, depth) == ""
    assert dive.go(2.0, REST, depth) == ""
    assert dive.go(8.0, push, depth).startswith("contradicted: the verticals push")
    dive = Dive(noise=0.03)
    for _ in range(20):
        assert dive.go(8.0, push, depth) == ""
        assert dive.go(4.0, REST, depth) == ""


@pytest.mark.parametrize("every", [2, 3])
def test_a_depth_that_is_held_by_thrust_that_goes_on_and_off_is_natural(every: int):
    dive = Dive(noise=0.05)
    dive.go(20.0, REST, at(10.0))
    for report in range(300):
        push = Vertical(0.0, 10.0) if report % every == 0 else DOWN
        assert dive.go(2.0, push, at(10.0)) == ""


def test_a_slope_under_way_a_step_of_the_ground_and_a_slow_altimeter_are_natural():
    moving = Dive()
    moving.mains = 0.4
    assert moving.go(120.0, HOLD, at(9.8), lambda s: 60.0 - 0.4 * s) == ""
    assert Dive().go(200.0, HOLD, at(9.8), lambda s: 20.0 if s < 100.0 else 12.0) == ""
    slow = Dive()
    slow.go(28.0, Vertical(0.83, 14.2), sinking(0.5), lambda s: 45.0 - 0.2 * s)
    assert slow.go(120.0, HOLD, at(14.2), lambda s: 25.0 + 15.0 * math.exp(-s / 30.0)) == ""


def test_a_vehicle_that_sinks_truly_is_believed_whatever_its_receiver_says():
    dive = Dive()
    assert dive.go(120.0, REST, sinking(0.15, 5.0), fixes=True) == ""


def test_waves_are_natural():
    for seed in range(10):
        dive, rng = Dive(seed), Random(seed)
        phase = rng.uniform(0.0, 6.3)
        swell = lambda s, p=phase: 0.4 + 0.35 * math.sin(0.9 * s + p)  # noqa: E731
        assert dive.go(600.0, REST, swell, fixes=True) == ""


def test_a_gap_in_the_reports_begins_the_window_anew():
    dive = Dive()
    dive.go(12.0, DOWN, at(4.2))
    dive.t += 10.0
    assert dive.go(12.0, DOWN, at(4.2)) == ""


@pytest.mark.parametrize("hz", [0.5, 10.0])
def test_reports_ten_times_a_second_are_judged_as_those_of_two_seconds(hz):
    belief, receiver, t = DepthBelief(), Receiver(), 0.0
    while not belief.reason:
        belief.take(t, 4.2, None, 0.5, DOWN, receiver)
        t += 1.0 / hz
    assert 12.0 <= t <= 18.0


# --- believed again ------------------------------------------------------------------------------


def contradicted() -> Dive:
    dive = Dive(noise=0.05)
    dive.go(20.0, DOWN, at(4.2))
    assert dive.belief.reason
    return dive


def test_a_depth_that_moves_as_the_vehicle_is_moved_is_believed_again():
    for push in (UP, REST):
        dive = contradicted()
        assert dive.go(12.0, push, sinking(-0.25, 12.0))
        assert dive.go(20.0, push, sinking(-0.25, 9.0)) == ""


def test_one_that_moves_against_the_push_is_not():
    dive = contradicted()
    assert dive.go(40.0, DOWN, sinking(-0.2, 12.0))


def test_what_a_push_upward_in_vain_contradicted_while_fixes_come_may_be_an_offset():
    dive = Dive(noise=0.05)
    assert dive.go(18.0, UP, at(6.0), fixes=True).startswith("contradicted: the verticals push up")
    assert dive.go(40.0, UP, sinking(-0.2, 12.0))
    assert dive.go(40.0, REST, sinking(0.2, 4.0))


@pytest.mark.parametrize("push", [UP, REST])
def test_fixes_that_go_on_while_it_moves_were_made_up_and_it_stood_since_it_was_heavy(push):
    """Nothing rises or sinks by metres at the surface."""
    dive = Dive(noise=0.05)
    assert dive.go(18.0, UP, at(12.0), fixes=True).startswith("contradicted: the verticals push up")
    assert dive.go(24.0, push, sinking(-0.2 if push is UP else 0.2, 12.0), fixes=True) == ""


@pytest.mark.parametrize("push", [UP, REST])
def test_a_body_that_its_thrusters_just_hold_is_believed_as_soon_as_it_moves(push):
    """Where no fix comes it is under water: it rises once less is held, it sinks when let go."""
    rate = -0.2 if push is UP else 0.2
    dive = Dive(noise=0.05)
    dive.go(30.0, REST, at(0.2), fixes=True)
    dive.go(18.0, HOLD, sinking(0.8, 0.2))
    assert dive.go(18.0, UP, at(15.5)).startswith("contradicted: the verticals push up")
    assert dive.go(24.0, push, sinking(rate, 15.5)) == ""


def test_what_was_clogged_and_sinks_when_nothing_pushes_is_believed():
    dive = contradicted()
    assert dive.go(24.0, REST, sinking(0.2, 4.2)) == ""


@pytest.mark.parametrize("rate", [0.018, 0.06, 0.12])
def test_what_is_hardly_too_heavy_sinks_by_a_depth_that_is_believed_again(rate):
    """No metre in 7 s, and tens of metres in half an hour: nobody would see it go."""
    dive = Dive(noise=0.3)
    assert dive.go(20.0, DOWN, at(0.2)).startswith("contradicted: the verticals push down")
    assert dive.go(20.0 + 2.8 / rate, REST, sinking(rate)) == ""


def test_a_swell_and_a_slow_rise_are_no_way_down():
    for waves in (lambda s: 0.2 + 0.75 * math.sin(s / 2.2), sinking(-0.05, 20.0)):
        dive = Dive(noise=0.1)
        dive.go(20.0, DOWN, at(waves(0.0)))
        assert dive.go(380.0, REST, waves)
        assert not dive.belief.follows


def test_what_creeps_long_after_the_last_fix_is_no_way_down():
    """On deck, under a roof: what is shut in behind a clogged port grows warm."""
    dive = Dive(noise=0.05)
    dive.go(20.0, DOWN, at(0.2))
    dive.go(20.0, REST, at(0.2), fixes=True)
    dive.go(400.0, REST, at(0.2))
    assert dive.go(900.0, REST, sinking(0.005))


@pytest.mark.parametrize("slope", [-0.05, -0.03, 0.03, 0.05])
def test_a_drift_over_a_gentle_slope_contradicts_no_depth_that_is_held(slope):
    dive = Dive(noise=0.1)
    light = Vertical(0.35, 5.0)
    dive.go(20.0, DOWN, sinking(0.25))
    assert dive.go(600.0, light, at(5.0), lambda s: 40.0 - 0.3 * slope * s) == ""


def test_an_offset_that_comes_at_once_is_no_slow_way_down():
    dive = contradicted()
    dive.go(60.0, REST, at(4.2))
    assert dive.go(600.0, REST, at(7.9))


def test_what_fixes_come_from_does_not_sink():
    dive = Dive(noise=0.05)
    dive.go(20.0, DOWN, at(0.2))
    assert dive.go(400.0, REST, sinking(0.02), fixes=True)


def test_a_leap_to_the_surface_is_movement_enough_for_ten_seconds_of_fixes():
    dive = contradicted()
    dive.belief.leap(dive.t, -4.0)
    assert dive.go(40.0, REST, at(0.2))
    assert dive.go(40.0, REST, at(0.2), fixes=True) == ""


def test_a_clogged_port_at_the_surface_is_never_believed():
    dive = Dive(noise=0.1)
    dive.go(20.0, DOWN, at(0.2))
    assert dive.go(1800.0, REST, at(0.2), fixes=True)


def test_one_that_has_come_back_to_the_surface_is_believed_after_ten_seconds_of_fixes():
    dive = contradicted()
    dive.go(20.0, UP, at(4.2))
    assert dive.go(8.0, REST, at(0.2), fixes=True)
    assert dive.go(20.0, REST, at(0.2), fixes=True) == ""


@pytest.mark.parametrize("fixes", [False, True])
def test_what_leapt_is_believed_at_the_surface_alone(fixes):
    dive = Dive(noise=0.05)
    dive.go(20.0, HOLD, at(10.0))
    dive.belief.leap(dive.t, -6.0)
    assert dive.go(18.0, UP, sinking(-0.22, 4.0))
    assert dive.go(30.0, REST, at(0.2), fixes=fixes).startswith("" if fixes else "contradicted")
    assert bool(dive.belief.reason) is not fixes


def test_a_depth_that_is_contradicted_and_moves_with_the_vehicle_follows_it():
    """It is off, not clogged: what it changes by tells whether an ascent rises."""
    dive = Dive(noise=0.05)
    dive.go(20.0, HOLD, at(10.0))
    dive.belief.leap(dive.t, -6.0)
    assert not dive.belief.follows
    assert dive.go(24.0, UP, sinking(-0.22, 8.0))
    assert dive.belief.follows
    assert dive.go(24.0, UP, at(3.0))
    assert not dive.belief.follows


@pytest.mark.parametrize("push", [UP, REST])
def test_one_that_is_clogged_follows_nothing(push):
    dive = contradicted()
    for _ in range(20):
        assert dive.go(10.0, push, at(4.2))
        assert not dive.belief.follows


def test_behind_a_silence_it_has_to_show_again_that_it_follows():
    dive = Dive(noise=0.05)
    dive.go(20.0, HOLD, at(10.0))
    dive.belief.leap(dive.t, -6.0)
    dive.go(24.0, UP, sinking(-0.22, 8.0))
    dive.t += 10.0
    dive.go(2.0, REST, at(0.7))
    assert dive.belief.reason
    assert not dive.belief.follows


def test_fixes_contradict_no_depth_that_goes_as_a_body_does():
    """Nothing rises or sinks by metres at the surface: the receiver makes its places up."""
    dive = Dive(noise=0.05)
    assert dive.go(22.0, REST, sinking(0.3, 10.0), fixes=True) == ""
    assert dive.go(16.0, UP, sinking(-0.25, 16.6), fixes=True) == ""
    assert dive.go(22.0, REST, sinking(0.3, 12.6), fixes=True) == ""


def test_what_fixes_have_contradicted_is_believed_when_it_moves_under_them():
    dive = Dive(noise=0.05)
    hovering = Vertical(-0.4, 14.0)
    assert dive.go(60.0, hovering, at(14.0), fixes=True).startswith("contradicted: fixes come")
    assert dive.go(24.0, UP, sinking(-0.25, 14.0), fixes=True) == ""


@pytest.mark.parametrize(("off", "fixes"), [(-0.95, False), (3.0, False), (-0.95, True)])
def test_an_offset_that_sinks_when_the_fixes_have_ended_is_believed(off: float, fixes: bool):
    """Nobody would see the vehicle go, else: at rest an unknown depth turns nothing."""
    dive = Dive(noise=0.05)
    assert dive.go(50.0, REST, at(off), fixes=True).startswith("contradicted: fixes come")
    assert dive.go(20.0, REST, at(off), fixes=fixes)
    assert dive.go(20.0, REST, sinking(0.3, off), fixes=fixes) == ""


# --- the receiver --------------------------------------------------------------------------------


def run(fixes: Iterable[Fix]) -> tuple[Receiver, float]:
    receiver, last = Receiver(), 0.0
    for fix in fixes:
        receiver.take(fix)
        last = fix.t
    return receiver, receiver.settled(last)


def steady(count: int = 20, gap: float = 1.0, **changes: object) -> list[Fix]:
    return [Fix(gap * i, 0.5 + 1e-7 * i, 2.0, 2.5, **changes) for i in range(count)]  # type: ignore[arg-type]


def test_fixes_that_come_each_second_are_settled_for_as_long():
    _, settled = run(steady())
    assert settled == 19.0


@pytest.mark.parametrize(("gap", "settled"), [(2.0, 38.0), (4.0, 76.0), (6.0, 114.0)])
def test_fixes_between_waves_are_settled_while_four_of_20_s_are_new(gap: float, settled: float):
    assert run(steady(gap=gap))[1] == settled
    assert run(steady(gap=8.0))[1] == 0.0  # four take 24 s


@pytest.mark.parametrize(
    "fixes",
    [
        steady(gap=9.0),
        steady(hdop=6.0),
        steady(satellites=3),
        steady(speed=5.0),
        [Fix(float(i), 0.5 + 1e-5 * (i % 2) * i, 2.0, 2.5) for i in range(20)],
        [Fix(float(i), 0.5 + 1e-7 * (i % 3), 2.0, 2.5) for i in range(20)],
    ],
    ids=["gaps", "hdop", "satellites", "speed", "leaps", "in turn"],
)
def test_what_does_not_behave_as_at_the_surface_is_not_settled(fixes: list[Fix]):
    assert run(fixes)[1] == 0.0


def test_a_receiver_that_got_stuck_is_no_longer_settled_though_it_goes_on():
    stuck = [Fix(20.0 + i, 0.5 + 1e-7 * 19, 2.0, 2.5) for i in range(60)]
    assert run([*steady(), *stuck[:10]])[1] > 0.0
    assert run([*steady(), *stuck])[1] == 0.0


def test_a_run_of_fixes_is_over_with_the_last_of_them():
    receiver, _ = run(steady())
    assert receiver.settled(27.0) == 19.0
    assert receiver.settled(27.1) == 0.0
    assert receiver.last_at == 19.0
    assert Receiver().last_at == -math.inf
