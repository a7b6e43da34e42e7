"""The limits: every row of the table trips when it must, and not before."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from engine_world import VEHICLE, World, leg, mission, sets, when

from mission.envelope import LIMITS, Bounds, Response, admit, in_force
from mission.model import (
    IDLE_EMPTY,
    SURFACING,
    By,
    NavigationMode,
    Outcome,
    Result,
    Safety,
    Surface,
)
from protocol.messages import ClearMission, Manual, Setpoint, SetSafety, StartMission

LEAKY = replace(VEHICLE, reports=VEHICLE.reports | {"leak"}, constant_batteries=False)
LONG = 20000.0


def flying(depth: float = 10.0, **more: object) -> World:
    """Under way on heading 0 at 10 m, with 20 m asked for."""
    body = leg("out", settings=sets(surge=0.5, heading=0.0, depth=20.0), timeout=LONG)
    away = leg("away", when("depth", ">", 99.0), settings=sets(depth=20.0), timeout=LONG)
    world = World(mission(body, away, **more), vehicle=LEAKY)
    world.leak = False
    assert world.start()
    world.depth = depth
    world.nav.covariance = (0.01, 0.0, 0.01)
    world.wait(4.0)
    return world


def sink(world: World, rate: float, seconds: float) -> None:
    for _ in range(round(seconds / 2.0)):
        world.depth += 2.0 * rate
        world.wait(2.0)


def depth(world: World, beyond: float) -> None:
    world.tell(SetSafety(depth=11.0))
    sink(world, (1.0 + beyond) / 10.0, 10.0)
    sink(world, 0.0, 6.0)


def hard_depth(world: World, beyond: float) -> None:
    """In idle: under way the limit in force, never wider, is the first to act."""
    world.depth = VEHICLE.limits.depth + 1.0 + beyond
    world.wait(8.0)


def unasked_descent(world: World, rate: float) -> None:
    world.depth = 20.5
    world.wait(4.0)
    sink(world, rate, 20.0)


def blind(world: World, seconds: float) -> None:
    world.nav.doubt["depth"] = "frozen"
    world.wait(seconds)
    world.nav.doubt.clear()
    world.wait(4.0)


def silence(world: World, seconds: float) -> None:
    world.wait(seconds, reports=False)


def unanswered(world: World, times: int) -> None:
    world.answer = None
    sent = world.engine._core.watch.sent  # what the drive would report about
    for _ in range(times):
        world.tell(Outcome(Result.LOST, b"@ZAF6$", sent))


def leaking(world: World, reports: int) -> None:
    for _ in range(reports):
        world.leak = True
        world.wait(2.0)
    world.leak = False
    world.wait(4.0)


def rolled(world: World, reports: int) -> None:
    for _ in range(reports):
        world.roll = math.radians(75.0)
        world.wait(2.0)
    world.roll = 0.0
    world.wait(4.0)


def weak(world: World, seconds: float) -> None:
    for _ in range(round(seconds / 2.0)):
        world.t += 2.0
        world.tell(world.report(batteries=(9.5, 48.0)))
    world.wait(4.0)


def long_run(world: World, seconds: float) -> None:
    world.tell(SetSafety(time=60.0))
    started = 100.0
    world.until(started + seconds)


def far(world: World, metres: float) -> None:
    world.tell(SetSafety(radius=500.0))
    world.nav.north = metres
    world.wait(6.0)


def unsure(world: World, sigma: float) -> None:
    world.tell(SetSafety(radius=500.0))
    world.nav.north = 450.0
    world.nav.covariance = (sigma**2, 0.0, sigma**2)
    world.wait(6.0)


def turning(world: World, rate_deg: float) -> None:
    for _ in range(14):
        world.heading = (world.heading + math.radians(2.0 * rate_deg)) % math.tau
        world.wait(2.0)


def course(world: World, off_deg: float, seconds: float) -> None:
    world.depth = 0.2
    world.nav.speed = 0.75
    world.wait(2.0)
    for _ in range(round(seconds)):
        world.wait(1.0)
        world.tell(world.fix(speed=0.8, course=math.radians(off_deg)))


def dead_thrusters(world: World, reports: int) -> None:
    world.actuators = (0.0,) * 5
    for _ in range(reports):
        world.wait(2.0)
    world.actuators = (0.3, 0.3, 0.0, 0.0, 0.0)
    world.wait(4.0)


# name of the row -> what trips it, and what is near it and must not
def unheard(world: World, seconds: float) -> None:
    world.engine.limit_topside_silence(30.0)
    world.engine.hear_topside(world.t)
    world.until(world.t + seconds)


CASES: dict[str, tuple[Callable[[World], None], Callable[[World], None]]] = {
    "depth": (lambda w: depth(w, 1.2), lambda w: depth(w, 0.8)),
    "hard depth": (lambda w: hard_depth(w, 0.5), lambda w: hard_depth(w, -0.5)),
    "unexplained descent": (lambda w: unasked_descent(w, 0.3), lambda w: unasked_descent(w, 0.05)),
    "depth unknown": (lambda w: blind(w, 9.0), lambda w: blind(w, 5.0)),
    "telemetry": (lambda w: silence(w, 5.1), lambda w: silence(w, 4.8)),
    "topside": (lambda w: unheard(w, 30.5), lambda w: unheard(w, 29.5)),
    "no answer": (lambda w: unanswered(w, 3), lambda w: unanswered(w, 2)),
    "leak": (lambda w: leaking(w, 3), lambda w: leaking(w, 2)),
    "roll-over": (lambda w: rolled(w, 2), lambda w: rolled(w, 1)),
    "voltage": (lambda w: weak(w, 14.0), lambda w: weak(w, 8.0)),
    "time": (lambda w: long_run(w, 60.0), lambda w: long_run(w, 59.5)),
    "radius": (lambda w: far(w, 501.0), lambda w: far(w, 499.0)),
    "heading does not follow": (lambda w: turning(w, 4.0), lambda w: turning(w, 0.5)),
    "course against heading": (lambda w: course(w, 70.0, 24.0), lambda w: course(w, 70.0, 15.0)),
    "brown-out": (lambda w: dead_thrusters(w, 4), lambda w: dead_thrusters(w, 3)),
    "uncertain": (lambda w: unsure(w, 40.0), lambda w: unsure(w, 10.0)),
}


def ready(row) -> World:
    if row.name != "hard depth":
        return flying()
    world = World()
    world.wait(4.0)
    return world


def tripped(world: World, name: str) -> bool:
    """Whether the row, and no other, took the vehicle where it is."""
    left = [s for s in world.steps if s.trigger == "limit" or s.by is By.UNCERTAIN]
    names = {e.trigger for s in left for e in s.evaluations}
    assert names <= {f"limit {name}"}, names
    return bool(left)


@pytest.mark.parametrize("row", LIMITS, ids=lambda row: row.name)
def test_every_limit_trips_when_it_must(row):
    world = ready(row)
    CASES[row.name][0](world)
    assert tripped(world, row.name)
    if row.response is Response.UNCERTAIN:
        assert world.state == "autonomous/surface"
    else:
        assert SURFACING in [path for s in world.steps for path in s.entered]
        assert world.engine.reason.startswith(f"limit {row.name}: ")


@pytest.mark.parametrize("row", LIMITS, ids=lambda row: row.name)
def test_every_limit_keeps_still_below_its_bound(row):
    world = ready(row)
    before = world.state
    CASES[row.name][1](world)
    assert not tripped(world, row.name)
    assert world.state == before


@pytest.mark.parametrize("row", LIMITS, ids=lambda row: row.name)
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
    CASES[row.name][0](world)
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
    world = flying()
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
    dead_thrusters(world, 3)
    sent = [a for _, a in world.actions[before:]]
    assert [a.command for a in sent] == [Setpoint(surge=0.5, heading=0.0, depth=20.0)]
    assert "brown-out" in sent[0].reason


def test_on_uncertain_leads_where_the_mission_says_and_only_once():
    world = flying(on_uncertain="away")
    unsure(world, 40.0)
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
        unsure(world, 40.0)
        assert world.state == state
        world.nav.covariance = (0.01, 0.0, 0.01)
        world.wait(14.0)


def test_a_position_that_is_not_known_breaches_no_radius():
    world = flying()
    world.nav.mode = NavigationMode.NONE
    far(world, 5000.0)
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
    why = {row.name: row.disarmed(VEHICLE) for row in LIMITS}
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
