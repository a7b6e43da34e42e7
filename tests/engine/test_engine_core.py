"""Laws of the engine's verbs: what each of them leaves behind, sends, and puts on record."""

from __future__ import annotations

import pytest
from engine_world import M, W, World, X, compiled, leg, mission, sets
from limit_cases import flying as flying_with_limits
from limit_cases import unsure

from mission.model import (
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    STOPPED,
    SURFACED,
    SURFACING,
    AutoNode,
    By,
    Loaded,
    Safety,
)
from protocol.messages import (
    UPWARD,
    ClearMission,
    Emergency,
    Order,
    SetSafety,
    StartMission,
)

MISSION = mission(leg("a", timeout=600.0), leg("b"))


def flying(depth: float = 5.0) -> World:
    world = World(MISSION)
    assert world.start()
    world.depth = depth
    world.wait(4.0)
    return world


# --- a mission comes and goes ---------------------------------------------------------------


@pytest.mark.parametrize("state", [STOPPED, SURFACING, SURFACED, MANUAL_DRIVING])
def test_a_mission_that_is_stored_where_it_cannot_fly_leaves_the_state_as_it_is(state: str):
    world = World()
    world.depth = 0.2
    world.tell(world.report(), {STOPPED: X, MANUAL_DRIVING: M}.get(state, W))
    if state == SURFACED:
        world.wait(8.0)
    assert world.state == state
    world.tell(Loaded(compiled(MISSION)))
    assert world.state == state
    world.tell(Loaded(None))
    assert world.state == state
    world.wait(2.0)
    world.tell(world.report())


def test_a_store_that_is_emptied_empties_idle():
    world = World(MISSION)
    assert world.state == IDLE_READY
    world.tell(Loaded(None))
    assert world.state == IDLE_EMPTY
    assert world.engine.chart is None
    world.tell(Loaded(None))
    assert world.state == IDLE_EMPTY
    assert [s.trigger for s in world.steps] == ["load", "clear"]


def test_after_an_emergency_was_cleared_the_stick_leads_into_the_next_mission():
    world = flying()
    world.tell(X)
    world.depth = 0.2
    world.tell(world.report())
    world.tell(ClearMission())
    world.tell(Loaded(compiled(MISSION)))
    world.tell(M)
    world.wait(3.0)
    assert world.start()
    assert world.state == "autonomous/a"


def test_after_the_missions_end_nothing_is_under_way():
    world = World(mission(leg("a", timeout=None, duration=10.0)))
    assert world.start()
    world.wait(30.0)
    assert world.state == IDLE_READY
    engine = world.engine
    assert (engine.under_way, engine.leg, engine.mission_time) == ("", "", None)
    world.tell(Loaded(compiled(MISSION)))
    assert engine.chart == compiled(MISSION)


def test_the_missions_end_is_one_step_with_its_trigger_and_its_stop():
    world = World(mission(leg("a", timeout=None, duration=10.0)))
    assert world.start()
    world.wait(30.0)
    last = [s for s in world.steps if s.exited][-1]
    assert last.exited[0] == "autonomous/surface"
    assert last.entered[-1] == IDLE_READY
    assert last.by is By.END
    assert [e.trigger for e in last.evaluations] == [last.trigger]
    assert last.actions == ("everything stopped: the mission is over",)
    stops = [t for t, a in world.actions if a.command is Order.STOP]
    assert stops[-1] == last.t


def test_a_missions_own_limits_end_with_it_and_the_operators_stay():
    world = World(mission(leg("a"), safety=Safety(radius=123.0)))
    world.tell(SetSafety(depth=9.0))
    assert (world.engine.bounds.radius, world.engine.bounds.depth) == (123.0, 9.0)
    assert world.start()
    assert (world.engine.bounds.radius, world.engine.bounds.depth) == (123.0, 9.0)
    world.tell(X)
    assert world.engine.bounds.radius == 123.0
    world.tell(ClearMission())
    assert world.engine.bounds.radius == world.vehicle.limits.radius
    assert world.engine.bounds.depth == 9.0


def test_a_clear_is_on_record_where_there_was_something_to_clear():
    world = World(MISSION)
    for _ in range(2):
        world.tell(ClearMission())
    (step,) = world.steps[1:]
    assert (step.trigger, step.exited, step.entered) == (
        "clear",
        (IDLE_READY,),
        (IDLE_EMPTY,),
    )
    assert world.engine.reason == "cleared by the operator"


# --- uncertain ------------------------------------------------------------------------------


def test_a_mission_that_begins_uncertain_is_answered_like_one_that_becomes_so():
    """Also where the one before was uncertain when it ended, and it was never certain since."""
    world = flying_with_limits(on_uncertain="away")
    unsure(world, 2.0)
    assert world.state == "autonomous/away"
    world.tell(SetSafety(radius=500.0))
    world.nav.north, world.nav.covariance = 450.0, (1600.0, 0.0, 1600.0)
    world.wait(4.0)
    world.tell(X)
    world.depth = 0.2
    world.tell(world.report())
    world.tell(ClearMission())
    chart = compiled(
        mission(leg("out", timeout=600.0), leg("away", timeout=600.0), on_uncertain="away"),
        world.vehicle,
    )
    world.tell(Loaded(chart))
    world.tell(world.report(), world.fix(north=1.0))
    world.tell(StartMission())
    assert world.state == "autonomous/out"
    world.wait(4.0)
    assert world.state == "autonomous/away"


# --- what is in force at the vehicle ----------------------------------------------------------


@pytest.mark.parametrize(
    ("order", "thrust"), [(X, (0.0, 0.0, 0.0)), (W, (0.0, 0.0, -1.0)), (M, (0.0, 0.0, 0.0))]
)
def test_what_takes_over_ends_the_set_that_was_in_force(order: object, thrust: tuple[float, ...]):
    """Where the thrusters are not reported, they are taken to do what was said last."""
    world = flying()
    world.tell(world.report(actuators=None))
    assert world.nav.report.actuators == (0.5, 0.5, 1.0)
    world.tell(order)
    world.tell(world.report(actuators=None))
    assert world.nav.report.actuators == thrust


def test_an_ascent_thrusts_and_lets_go_where_no_report_tells() -> None:
    """A sensor that froze is found out by thrust alone, on boards that report none, too."""
    world = flying()
    world.nav.doubt["depth"] = "absurd"
    world.tell(W)
    seen = []
    while len(seen) < 45:
        world.wait(1.0, reports=False)
        world.tell(world.report(actuators=None))
        seen.append((world.actions[-1][1].command, world.nav.report.actuators[2]))
    assert {(Order.STOP, 0.0), (UPWARD, -1.0), (Order.SURFACE, -1.0)} == set(seen)


def test_after_a_stop_no_depth_is_asked_for_any_more():
    """In idle, out of a mission that had asked for 5 m: what sinks then is not explained."""
    world = flying(depth=0.2)
    world.tell(AutoNode(False))
    world.tell(AutoNode(True))
    assert world.state == IDLE_READY
    while world.depth < 4.0:
        world.depth += 0.5
        world.wait(2.0)
    assert world.state == SURFACING
    assert "everything is stopped" in world.engine.reason


@pytest.mark.parametrize("order", [X, W])
def test_in_an_emergency_nothing_of_the_mission_is_under_way_any_more(order: Emergency):
    world = flying()
    world.tell(order)
    assert (world.engine.leg, world.engine.mission_time) == ("", None)
    other = compiled(mission(leg("other")))
    world.tell(Loaded(other))
    assert world.engine.chart == other


def test_a_stick_that_is_forgotten_at_the_surface_ends_the_mission():
    world = flying()
    world.tell(M)
    assert world.engine.leg == "a"
    world.depth = 0.2
    world.wait(61.0)
    assert world.state == IDLE_READY
    engine = world.engine
    assert (engine.leg, engine.under_way, engine.mission_time) == ("", "", None)


def test_idle_by_the_stick_ends_what_an_emergency_forbade():
    world = flying()
    world.tell(X)
    world.depth = 0.2
    world.wait(3.0)
    world.push()
    world.wait(61.0)
    assert world.state == IDLE_READY
    world.tell(M)
    world.wait(3.0)
    assert world.start()
    assert world.state == "autonomous/a"


def test_closing_auto_in_manual_ends_the_interrupted_mission():
    world = World(mission(leg("a", timeout=None, duration=10.0), leg("b", timeout=600.0)))
    assert world.start()
    world.wait(12.0)
    assert world.state == "autonomous/b"
    world.tell(M)
    out = world.tell(AutoNode(False))
    assert (world.state, out.actions) == (MANUAL_DRIVING, ())
    assert (world.engine.leg, world.engine.mission_time) == ("", None)
    world.tell(AutoNode(True))
    world.wait(3.0)
    assert world.start()
    assert world.state == "autonomous/a"


def test_an_uncertainty_that_lasts_is_answered_once_and_one_that_ended_anew():
    away = leg("away", settings=sets(depth=20.0), timeout=10.0, otherwise="out")
    out = leg("out", settings=sets(surge=0.5, heading=0.0, depth=20.0), timeout=600.0)
    world = World(mission(out, away, on_uncertain="away"))
    assert world.start()
    world.depth = 10.0
    world.tell(SetSafety(radius=500.0))
    world.nav.north, world.nav.covariance = 450.0, (1600.0, 0.0, 1600.0)
    world.wait(40.0)
    assert [s.by for s in world.steps].count(By.UNCERTAIN) == 1
    assert world.state == "autonomous/out"


def test_what_became_uncertain_where_uncertainty_leads_is_answered_behind_it():
    away = leg("away", timeout=None, duration=20.0)
    on = leg("on", settings=sets(surge=0.5, heading=0.0, depth=20.0), timeout=600.0)
    world = World(mission(away, on, on_uncertain="away"))
    assert world.start()
    world.depth = 10.0
    world.wait(2.0)
    world.tell(SetSafety(radius=500.0))
    world.nav.north, world.nav.covariance = 450.0, (1600.0, 0.0, 1600.0)
    world.wait(10.0)
    assert world.state == "autonomous/away"
    world.wait(40.0)
    assert [s.by for s in world.steps].count(By.UNCERTAIN) == 1


def test_no_uncertainty_leads_out_of_the_implicit_leg():
    first = leg("first", timeout=None, duration=10.0)
    world = World(mission(first, on_uncertain="first"))
    assert world.start()
    world.depth = 10.0
    world.wait(12.0)
    assert world.state == "autonomous/surface"
    world.tell(SetSafety(radius=500.0))
    world.nav.north, world.nav.covariance = 450.0, (1600.0, 0.0, 1600.0)
    world.wait(10.0)
    assert world.state == "autonomous/surface"


def test_a_limit_that_acts_is_on_record_as_breached_with_what_was_seen():
    world = flying_with_limits()
    world.tell(SetSafety(depth=8.0))
    world.wait(4.0)
    assert world.state == SURFACING
    (seen,) = world.steps[-1].evaluations
    assert (seen.trigger, seen.result, seen.values) == ("limit depth", True, (("depth", 10.0),))
    world = flying_with_limits(on_uncertain="away")
    unsure(world, 2.0)
    (step,) = [s for s in world.steps if s.by is By.UNCERTAIN]
    (seen,) = step.evaluations
    assert (seen.trigger, seen.result) == ("limit uncertain", True)
    assert seen.values == (("range", pytest.approx(450.0)),)
