"""The limits: every row of the table trips when it must, and not before."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from random import Random

import pytest
from engine_world import VEHICLE, World, leg, mission, sets
from limit_cases import CASES, LEAKY, LONG, far, flying, sink, thrust, unsure

from mission.engine.bounds import Bounds, admit, in_force
from mission.engine.limits import LIMITS, Limit, On
from mission.engine.monitor import LimitMonitor
from mission.engine.vehicle_state import VehicleState
from mission.legs import Surface
from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    By,
    NavigationMode,
    Safety,
)
from mission.model.regions import IDLE
from mission.model.vehicle import REPORTS
from protocol.messages import ClearMission, Manual, Setpoint, SetSafety, StartMission, Telemetry


def tripped(world: World, name: str) -> bool:
    """Whether the row, and no other, took the vehicle where it is."""
    left = [s for s in world.steps if s.trigger == "limit" or s.by is By.UNCERTAIN]
    names = {e.trigger for s in left for e in s.evaluations}
    assert names <= {f"limit {name}"}, names
    return bool(left)


@pytest.mark.parametrize(
    "bare", [{"roll": None}, {"batteries": None}, {"batteries": ()}, {"batteries": (None, 48.0)}]
)
def test_a_report_that_leaves_something_out_breaches_nothing(bare):
    world = flying()
    for _ in range(10):
        world.t += 2.0
        world.tell(world.report(**bare))
    assert world.state == "autonomous/out"


def test_the_longest_axis_of_what_is_not_known_decides():
    """450 m from home, known to a metre one way and to 40 m the other: along, and across."""
    for covariance, end in (
        ((1600.0, 0.0, 1.0), "autonomous/surface"),
        ((1.0, 0.0, 1600.0), "autonomous/out"),
    ):
        world = flying()
        world.tell(SetSafety(radius=500.0))
        world.nav.north, world.nav.covariance = 450.0, covariance
        world.wait(6.0)
        assert world.state == end


def test_a_sample_that_is_sure_begins_the_count_of_uncertain_ones_anew():
    world = flying()
    for _ in range(3):
        unsure(world, 2.0, 1)
    assert world.state == "autonomous/out"


def scripted(row: Limit, patch: pytest.MonkeyPatch) -> tuple[LimitMonitor, list[bool | None]]:
    """A watch with this row alone, which says what the list says."""
    says: list[bool | None] = [False]
    one = replace(row, breached=lambda _: says[-1], needs=frozenset())
    patch.setattr("mission.engine.monitor.LIMITS", {one.name: one})
    bounds = in_force(LEAKY, None, SetSafety())
    return LimitMonitor(LEAKY, VehicleState(), bounds), says


@pytest.mark.replaces
@pytest.mark.parametrize("row", LIMITS.values(), ids=lambda row: row.name)
def test_every_limit_waits_for_its_whole_persistence(row, monkeypatch):
    """Unknown samples count neither way."""
    watch, says = scripted(row, monkeypatch)
    period = 2.0
    needed = row.samples if not row.seconds else round(row.seconds / period) + 1

    def look(says_now: bool | None) -> bool:
        watch.vehicle_state.now += period
        says.append(says_now)
        return bool(watch.look(reported=True, fixed=True))

    for _ in range(2):
        assert [look(True) for _ in range(needed - 1)] == [False] * (needed - 1)
        assert [look(False) for _ in range(needed)] == [False] * needed
    assert [look(True) for _ in range(needed)] == [False] * (needed - 1) + [True]
    assert look(True)
    assert not look(None)
    assert watch.breaches == ()
    assert look(True)


@pytest.mark.replaces
def test_samples_count_by_the_clock_where_no_report_comes_between(monkeypatch):
    """Fixes alone may say where it is."""
    row = LIMITS["uncertain"]
    watch, says = scripted(row, monkeypatch)
    watch.vehicle_state.take_telemetry(Telemetry(t=0.0))
    says.append(True)
    assert [watch.look(reported=True, fixed=True) for _ in range(9)] == [[]] * 9  # of one moment
    for t in range(1, row.samples):
        watch.vehicle_state.now = float(t)
        assert bool(watch.look(reported=True, fixed=True)) is (t == row.samples - 1)


_LONG_ROWS = [row for row in LIMITS.values() if row.seconds or row.samples > 2]


def _looks(row: Limit, patch: pytest.MonkeyPatch, said: Iterable[bool]) -> list[bool]:
    watch, says = scripted(row, patch)
    found = []
    for one in said:
        watch.vehicle_state.now += 2.0
        says.append(one)
        found.append(bool(watch.look(reported=True, fixed=True)))
    return found


@pytest.mark.replaces
@pytest.mark.parametrize("row", _LONG_ROWS, ids=lambda row: row.name)
@pytest.mark.parametrize("seed", range(5))
def test_a_limit_acts_through_noise_that_now_and_then_says_otherwise(row, seed, monkeypatch):
    rng = Random(seed)
    said = [rng.random() < 0.85 for _ in range(60)]
    assert any(_looks(row, monkeypatch, said))


@pytest.mark.replaces
@pytest.mark.parametrize("row", _LONG_ROWS, ids=lambda row: row.name)
def test_a_limit_does_not_act_on_what_is_within_its_bound_for_most_of_the_time(row, monkeypatch):
    said = [i % 3 == 0 for i in range(3000)]
    assert not any(_looks(row, monkeypatch, said))


@pytest.mark.replaces
def test_a_confirmed_leak_is_not_counted_again(monkeypatch):
    """The codec has asked for three frames more than those that deny it (R16)."""
    row = next(row for row in LIMITS.values() if row.name == "leak")
    assert _looks(row, monkeypatch, [False, True, False]) == [False, True, False]


def test_a_noisy_voltage_below_its_limit_trips_within_a_minute():
    """21 V with 0.8 V of noise, under 22 V."""
    for seed in range(50):
        rng, world = Random(seed), flying(safety=Safety(voltage=22.0))
        begun = world.t
        while world.state != SURFACING and world.t < begun + 120.0:
            volts_now = rng.gauss(21.0, 0.8)
            world.t += 2.0
            world.tell(world.report(batteries=(volts_now, 48.0)))
        assert world.t - begun <= 60.0


@pytest.mark.replaces
def test_a_good_moment_takes_twice_its_time_back(monkeypatch):
    """Bad for 8 s, good for one sample, and bad again: 4 s are left of the 8."""
    row = replace(next(row for row in LIMITS.values() if row.name == "voltage"), seconds=10.0)
    said = [True] * 4 + [False] + [True] * 6
    assert _looks(row, monkeypatch, said).index(True) == 8


def _low(world: World, seconds: float) -> None:
    """The voltage is below its limit in the next report, so much later."""
    world.wait(seconds, reports=False)
    world.tell(world.report(batteries=(VEHICLE.limits.voltage - 1.0, 48.0)))


def _unknown(world: World, seconds: float) -> None:
    world.nav.doubt["battery"] = "absurd"
    world.wait(seconds)
    world.nav.doubt.clear()


def test_what_nobody_could_tell_for_long_is_no_time_that_a_breach_lasted():
    """One low report stands for 6 s without another, and no longer."""
    world = flying()
    _low(world, 1.0)
    _unknown(world, 60.0)
    for pause in (0.0, 2.0, 1.9):
        _low(world, pause)
        assert world.state == "autonomous/out"
    _low(world, 0.1)
    assert world.state == SURFACING


def test_reports_that_are_lost_between_two_that_breach_count_as_they_do():
    world = flying()
    _low(world, 1.0)
    for _ in range(2):
        assert world.state == "autonomous/out"
        _unknown(world, 5.0)
        _low(world, 0.0)
    assert world.state == SURFACING


def test_a_course_apart_once_before_a_dive_and_once_behind_it_is_no_breach():
    world = flying()
    world.nav.speed = 0.75
    for dive in (0.0, 90.0):
        world.depth = 10.0
        world.wait(dive)
        world.depth = 0.2
        world.wait(2.0)
        assert world.state == "autonomous/out"
        world.tell(world.fix(speed=0.8, course=math.radians(90.0)))
        assert world.state == "autonomous/out"


@pytest.mark.replaces
@pytest.mark.parametrize("row", LIMITS.values(), ids=lambda row: row.name)
def test_a_limit_is_looked_at_when_its_source_speaks_and_no_other_time(row, monkeypatch):
    watch, says = scripted(replace(row, samples=1, seconds=0.0), monkeypatch)
    says.append(True)
    wanted = {On.CLOCK: (1, 1, 1), On.REPORT: (0, 1, 0), On.FIX: (0, 0, 1)}[row.on]
    seen = [watch.look(r, f) for r, f in ((False, False), (True, False), (False, True))]
    assert tuple(map(len, seen)) == wanted


@pytest.mark.parametrize("row", LIMITS.values(), ids=lambda row: row.name)
def test_every_row_says_all_that_a_limit_is(row):
    assert row.source
    assert row.bound
    assert row.samples >= 1
    assert row.acts <= {AUTONOMOUS, IDLE, MANUAL_WAITING, STOPPED, SURFACED}  # else reported (R5)
    assert row.needs <= REPORTS
    assert CASES.keys() == {r.name for r in LIMITS.values()}


@pytest.mark.parametrize("row", LIMITS.values(), ids=lambda row: row.name)
def test_in_manual_every_limit_is_reported_and_none_acts(row):
    world = flying()
    world.tell(Manual("MM", b"@MMF5$"))
    until = world.until

    def held(t: float, *, reports: bool = True) -> None:
        while world.t + 1.0 <= t:
            until(world.t + 1.0, reports=reports)
            world.tell(Manual("MM", b"@MMF5$"))
        until(t, reports=reports)

    world.until = held  # type: ignore[method-assign]
    CASES[row.name].trips(world)
    assert world.state == "manual/driving"


def test_a_limit_that_is_breached_in_manual_is_reported():
    world = flying()
    world.tell(Manual("MM", b"@MMF5$"))
    world.nav.north = 5000.0
    for _ in range(4):
        world.wait(1.0)
        world.tell(Manual("MM", b"@MMF5$"))
    assert "radius" in {row.name for row in world.engine.breaches}


def test_a_descent_that_nobody_asked_for_acts_also_in_idle():
    world = World()
    world.wait(4.0)
    assert world.state == IDLE_EMPTY
    sink(world, 0.2, 40.0)
    assert world.state == SURFACING


def test_the_topside_may_be_silent_for_ever_unless_told_otherwise():
    world = flying(depth=20.0)
    world.wait(250.0)
    assert not tripped(world, "topside")


def test_an_absurd_single_sample_trips_nothing():
    world = flying()
    for changes in ({"depth": 500.0}, {"roll": 3.0}):
        world.t += 2.0
        world.tell(world.report(**changes))
        world.wait(4.0)
    assert world.state == "autonomous/out"


def test_a_brown_out_is_answered_once_with_the_whole_set():
    world = flying()
    before = len(world.actions)
    thrust(world, 0.0, 3)
    sent = [a for _, a in world.actions[before:]]
    assert [a.command for a in sent] == [Setpoint(surge=0.5, heading=0.0, depth=20.0)]
    assert "brown-out" in sent[0].reason


def test_on_uncertain_leads_where_the_mission_says_and_only_once():
    world = flying(on_uncertain="away")
    unsure(world, 2.0)
    assert world.state == "autonomous/away"
    world.wait(20.0)
    taken = [s for s in world.steps if s.by is By.UNCERTAIN]
    assert len(taken) == 1


def test_a_second_uncertainty_surfaces():
    home = leg("away", settings=sets(depth=20.0), timeout=10.0, otherwise="out")
    out = leg("out", settings=sets(surge=0.5, heading=0.0, depth=20.0), timeout=LONG)
    world = World(mission(out, home, on_uncertain="away"))
    assert world.start()
    world.depth = 10.0
    world.wait(4.0)
    for state in ("autonomous/away", "autonomous/surface"):
        unsure(world, 2.0)
        assert world.state == state
        world.nav.covariance = (0.01, 0.0, 0.01)
        world.wait(14.0)


def test_a_position_that_is_not_known_breaches_no_radius():
    world = flying()
    world.nav.mode = NavigationMode.NONE
    far(world, 5000.0, 30)
    assert world.state == "autonomous/out"


def test_in_force_is_the_tightest_of_vehicle_mission_and_operator():
    own = Safety(radius=300.0, depth=50.0, voltage=11.0)
    operator = SetSafety(radius=400.0, time=100.0, depth=20.0, voltage=10.5)
    assert in_force(VEHICLE, own, operator) == Bounds(300.0, 100.0, 20.0, 11.0)
    hard = VEHICLE.limits
    alone = in_force(VEHICLE, None, SetSafety())
    assert alone == Bounds(hard.radius, hard.time, hard.depth, hard.voltage)


def test_a_missions_own_limits_are_in_force_from_its_loading_to_its_clearing():
    world = World(mission(leg("a"), safety=Safety(radius=123.0)))
    assert world.engine.bounds.radius == 123.0
    world.tell(ClearMission())
    assert world.engine.bounds.radius == VEHICLE.limits.radius


def test_what_the_vehicle_does_not_report_disarms_its_limit_and_says_why():
    why = {row.name: row.disarmed(VEHICLE) for row in LIMITS.values()}
    assert "leak" in why["leak"]
    assert "constants" in why["voltage"]
    assert why["depth"] == ""


def test_the_operators_limit_is_in_force_at_once():
    world = flying()
    world.nav.north = 800.0
    world.wait(6.0)
    assert world.state == "autonomous/out"
    world.tell(SetSafety(radius=700.0))
    world.wait(4.0)
    assert world.state == SURFACING


def test_no_set_leaves_that_is_deeper_than_the_limit_in_force():
    deep = leg("deep", settings=sets(surge=0.5, heading=0.0, depth=40.0), timeout=60.0)
    first = leg("first", timeout=None, duration=30.0)
    world = World(mission(first, deep))
    assert world.start()
    world.depth = 5.0
    world.wait(10.0)
    world.tell(SetSafety(depth=30.0))
    world.wait(30.0)
    assert all(getattr(c, "depth", None) != 40.0 for c in world.commands())
    assert world.state == "autonomous/surface"
    assert any("40" in s for s in [world.engine.reason])


def test_a_mission_deeper_than_the_limit_in_force_does_not_start():
    world = World(mission(leg("deep", settings=sets(surge=0.5, heading=0.0, depth=40.0))))
    world.tell(SetSafety(depth=30.0))
    assert not world.start()
    assert "deep" in world.verdicts[-1].why


@pytest.mark.parametrize(
    "bad",
    [
        Setpoint(surge=1.5),
        Setpoint(heave=-2.0),
        Setpoint(depth=math.nan),
        Setpoint(depth=51.0),
        Setpoint(heading=math.inf),
        Setpoint(depth=1.0, heave=0.5),
    ],
)
def test_the_gate_lets_no_nonsense_out(bad: Setpoint):
    assert admit(bad, Bounds(1.0, 1.0, 50.0, 1.0), VEHICLE)
    assert admit(Setpoint(surge=1.0, depth=50.0), Bounds(1.0, 1.0, 50.0, 1.0), VEHICLE) == ""


def test_a_limit_does_not_begin_a_legs_ascent_anew():
    up = leg("up", kind=Surface(), settings=(), timeout=LONG)
    first = leg("first", timeout=None, duration=10.0)
    world = World(mission(first, up))
    assert world.start()
    world.depth = 20.0
    world.wait(24.0)  # in the ascent's second way by now
    sent = world.commands()[-1]
    assert sent == Setpoint(heave=-1.0)
    world.wait(5.1, reports=False)
    assert world.state == SURFACING
    assert world.commands()[-1] == sent


def test_a_silent_vehicle_is_no_fault_before_the_mission_and_again_one_after_its_start():
    world = World(mission(leg("a")))
    world.wait(60.0, reports=False)
    assert world.state == "idle/ready"
    world.tell(StartMission())
    assert not world.verdicts[-1].accepted


def test_a_dive_without_a_depth_ends_after_six_seconds_and_not_before():
    world = flying()
    world.depth = None
    world.until(math.floor(world.t / 2.0) * 2.0 + 2.0)
    blind = world.t
    world.until(blind + 5.9)
    assert world.state == "autonomous/out"
    world.until(blind + 6.1)
    assert world.state == SURFACING
