"""Laws of what guards remember: trends within a leg, and the peak of the leg before."""

from __future__ import annotations

import math
import pickle

import pytest
from engine_world import M, World, leg, legs_of, mission, sets
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.engine.memory import PARTS, Peak, Window
from mission.model import Back, Exit, Guard, Not, Trend
from protocol.messages import StartMission, Telemetry

FALLS = Trend("temperature", False, 2.0, 5.0, True)
LONG = 20000.0


class Water(World):
    """Reports a temperature, too."""

    def __init__(self, *body: object) -> None:
        self.temperature: float | None = 18.0
        super().__init__(mission(*body))
        assert self.start()
        self.depth = 5.0

    def report(self, **changes: object) -> Telemetry:
        return super().report(**{"temperature_c": self.temperature, **changes})

    def see(self, *samples: tuple[float, float | None]) -> None:
        """A report of each depth and temperature, 2 s apart."""
        for self.depth, self.temperature in samples:
            self.wait(2.0)


def until(term: object, target: str | None = None, held: float = 0.0) -> Exit:
    return Exit(Guard(term, held), target)  # type: ignore[arg-type]


def dive(*terms: object, **more: object) -> Water:
    """A leg a with these exits, then b."""
    exits = [until(term) for term in terms]
    return Water(leg("a", *exits, timeout=LONG, **more), leg("b", timeout=LONG))


def falling(per_metre: float, down_to: float) -> list[tuple[float, float]]:
    depths = [0.25 * n for n in range(1, int(4 * down_to) + 1)]
    return [(depth, 18.0 - per_metre * depth) for depth in depths]


# --- a window ------------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([2.0, 5.0, 33.0, math.inf]),
    st.lists(st.tuples(st.floats(0.0, 20.0), st.floats(-3.0, 3.0)), min_size=3, max_size=60),
)
def test_a_window_remembers_no_farther_than_it_reaches_and_nearly_as_far(reach, samples):
    window, at, middles = Window(reach), 0.0, []
    seen = []
    for value, step in samples:
        at += step
        seen.append((value, at))
        window.take(at, value)
        if len(seen) >= 3:
            middles.append((sorted(v for v, _ in seen[-3:])[1], seen[-2][1]))
        near = [v for v, where in middles if abs(where - at) <= reach]
        found = window.extreme(highest=True)
        assert found is None or found in near
    straight, found = Window(reach), []
    for n, (value, _) in enumerate(samples):
        straight.take(0.1 * n, value)
        found.append(sorted(v for v, _ in samples[n - 2 : n + 1])[1] if n >= 2 else None)
        least = [
            v for k, v in enumerate(found) if v and 0.1 * (n - k + 2) < reach * (1 - 1 / PARTS)
        ]
        assert not least or straight.extreme(highest=True) >= max(least)


def test_one_wild_report_is_no_peak():
    window = Window(math.inf)
    for n, value in enumerate([18.0, 18.0, 18.0, 40.0, 18.0, 18.0, -4.0, 18.0]):
        window.take(float(n), value)
    assert (window.extreme(highest=True), window.extreme(highest=False)) == (18.0, 18.0)


@pytest.mark.parametrize("reach", [5.0, math.inf])
def test_a_window_is_of_bounded_size_whatever_comes_in(reach: float):
    window = Window(reach)
    sizes = []
    for n in range(20_000):
        window.take(0.37 * n % 700.0, math.sin(n))
        sizes.append(len(pickle.dumps(window)) if n % 500 == 0 else 0)
    assert max(sizes) < 60 * PARTS


# --- trends in flight --------------------------------------------------------------------------


def test_a_fall_within_so_many_metres_ends_the_leg_and_a_slower_one_does_not():
    steep, gentle = dive(FALLS), dive(FALLS)
    steep.see(*falling(0.6, 6.0))
    gentle.see(*falling(0.3, 20.0))
    assert (legs_of(steep)[-1], legs_of(gentle)[-1]) == ("b", "a")


def test_what_was_seen_farther_off_or_longer_ago_counts_for_nothing():
    deep, late = dive(FALLS), dive(Trend("temperature", False, 2.0, 20.0))
    for world in (deep, late):
        world.see(*[(3.0, 20.0)] * 4, *[(9.0, 18.5)] * 14, *[(9.0, 17.5)] * 4)
        assert legs_of(world)[-1] == "a"
    whole = dive(Trend("temperature", False, 2.0))
    whole.see(*[(3.0, 20.0)] * 4, *[(9.0, 18.5)] * 14, (9.0, 17.5))
    assert legs_of(whole)[-1] == "b"


def test_rising_is_from_the_lowest_and_falling_from_the_highest():
    rises, falls = dive(Trend("temperature", True, 2.0)), dive(Trend("temperature", False, 2.0))
    for world in (rises, falls):
        world.see(*[(5.0, 18.0)] * 3, *[(5.0, 16.5)] * 3, *[(5.0, 18.6)] * 2)
    assert (legs_of(rises)[-1], legs_of(falls)[-1]) == ("b", "a")


def test_a_leg_remembers_nothing_of_the_one_before():
    falls = Trend("temperature", False, 2.0)
    first = leg("a", until(Trend("temperature", True, 4.0)), timeout=LONG)
    world = Water(first, leg("b", until(falls), timeout=LONG), leg("c", timeout=LONG))
    world.see(*[(5.0, 18.0)] * 4, (5.0, 23.0), *[(5.0, 18.0)] * 6)
    assert legs_of(world)[-1] == "b"
    world.see((5.0, 15.0))
    assert legs_of(world)[-1] == "c"


def test_a_reading_that_is_not_believed_opens_nothing_and_is_not_remembered():
    world = dive(Trend("temperature", False, 2.0))
    world.see(*[(5.0, 18.0)] * 4)
    world.nav.doubt["temperature"] = "absurd"
    world.see(*[(5.0, 40.0)] * 4, *[(5.0, 10.0)] * 4)
    assert legs_of(world)[-1] == "a"
    world.nav.doubt.clear()
    world.see(*[(5.0, 17.0)] * 4)
    assert legs_of(world)[-1] == "a"
    world.see((5.0, 16.0))
    assert legs_of(world)[-1] == "b"


def test_a_fix_between_two_reports_does_not_count_one_of_them_twice():
    world = dive(Trend("temperature", False, 2.0))
    world.see(*[(5.0, 18.0)] * 4, (5.0, 40.0))
    world.tell(world.fix())
    world.tell(world.fix())
    world.see(*[(5.0, 18.0)] * 3)
    assert legs_of(world)[-1] == "a"


@pytest.mark.parametrize("hertz", [10.0, 50.0])
def test_one_wild_reading_that_a_fast_board_says_many_times_is_no_peak(hertz: float):
    """Its sensor says another 2 times a second."""
    world = dive(Trend("temperature", False, 2.0))
    begin = world.t
    for i in range(1, int(10.0 * hertz)):
        world.t = begin + i / hertz
        world.tell(world.report(temperature_c=40.0 if 5.0 <= i / hertz < 5.5 else 18.0))
        assert legs_of(world)[-1] == "a"
    world.tell(world.report(temperature_c=15.9))
    assert legs_of(world)[-1] == "b"


def test_what_is_not_known_yet_is_not_false_either():
    world = dive(Not(Trend("temperature", False, 2.0)))
    world.see((5.0, 18.0))
    assert legs_of(world)[-1] == "a"
    world.see(*[(5.0, 18.0)] * 3)
    assert legs_of(world)[-1] == "b"


def test_without_a_depth_nothing_is_known_of_what_falls_with_it():
    world = dive(FALLS)
    world.see(*[(5.0, 18.0)] * 4)
    world.nav.doubt["depth"] = "frozen"
    world.see((5.0, 12.0))
    assert legs_of(world)[-1] == "a"


# --- the leg before ----------------------------------------------------------------------------

PEAK = Back("depth", True, "temperature", 0.5)
LAYER = [(d / 4, 15.0 + 3.0 * math.exp(-((d / 4 - 8.1) ** 2))) for d in range(4, 59)]


def layered(*between: object) -> Water:
    deep, high = (sets(surge=0.5, heading=0.0, depth=d) for d in (15.0, 2.0))
    first = leg("a", until(Trend("depth", True, 12.0)), timeout=LONG, settings=deep)
    up = leg("up", until(PEAK), timeout=LONG, settings=high)
    return Water(first, *between, up, leg("b", timeout=LONG))


def test_the_depth_comes_back_to_where_the_leg_before_had_its_peak():
    world = layered()
    world.see(*LAYER, (14.5, 15.0))
    assert legs_of(world)[-1] == "up"
    world.see((12.0, 15.0), (10.0, 15.0), (8.7, 17.0))
    assert legs_of(world)[-1] == "up"
    world.see((8.4, 17.5))
    assert legs_of(world)[-1] == "b"


def test_a_leg_in_which_nothing_was_known_is_no_leg_before():
    world = layered(leg("blink", timeout=0.5, otherwise="up", settings=sets(depth=15.0)))
    world.see(*LAYER, (14.5, 15.0), (12.0, 15.0), (8.4, 17.5), (8.4, 17.5))
    assert legs_of(world)[-1] == "b"


def test_an_interrupted_leg_goes_on_with_the_same_leg_before():
    world = layered()
    world.see(*LAYER, (14.5, 15.0), (13.0, 30.0), (12.9, 30.0), (12.8, 30.0), (12.7, 30.0))
    world.tell(M)
    world.wait(4.0)
    world.tell(StartMission())
    assert legs_of(world)[-1] == "up"
    world.see((10.0, 15.0), (8.4, 17.5))
    assert legs_of(world)[-1] == "b"


def test_without_a_leg_before_nothing_is_back():
    world = dive(PEAK)
    world.see(*LAYER)
    assert legs_of(world)[-1] == "a"


def test_a_heading_comes_back_the_short_way_round():
    world = Water(
        leg("a", until(Trend("temperature", False, 2.0)), timeout=LONG),
        leg("turn", until(Back("heading", True, "temperature", 0.1)), timeout=LONG),
        leg("b", timeout=LONG),
    )
    for world.heading, warm in ((6.0, 18.0), (6.2, 20.0), (6.2, 20.0), (0.3, 18.0), (0.5, 17.0)):
        world.see((5.0, warm))
    assert legs_of(world)[-1] == "turn"
    world.heading = 0.01
    world.see((5.0, 17.0))
    assert legs_of(world)[-1] == "b"


# --- copies ------------------------------------------------------------------------------------


def test_a_copy_of_the_engine_remembers_by_itself():
    world = dive(Trend("temperature", False, 2.0))
    world.see(*[(5.0, 18.0)] * 4)
    kept = world.engine.snapshot()
    world.see(*[(5.0, 30.0)] * 3)
    world.engine.restore(kept)
    world.t -= 6.0
    world.see(*[(5.0, 17.0)] * 2)
    assert legs_of(world)[-1] == "a"
    world.see((5.0, 15.5))
    assert legs_of(world)[-1] == "b"


@pytest.mark.parametrize(("highest", "there"), [(False, 13.0), (True, 11.0)])
def test_a_peak_is_the_highest_or_the_lowest_and_a_copy_of_it_goes_its_own_way(highest, there):
    peak = Peak(highest)
    for value, where in ((5.0, 10.0), (4.0, 11.0), (3.0, 12.0), (2.0, 13.0), (1.0, 14.0)):
        peak.take(value, where)
    assert peak.there == there
    copy = peak.clone()
    for where in (20.0, 21.0, 22.0):
        copy.take(9.0 if highest else -9.0, where)
    assert (copy.there, peak.there) == (20.0, there)
