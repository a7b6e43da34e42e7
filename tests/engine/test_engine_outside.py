"""Laws of the engine as others see it: what it takes in, in which order, and what it says."""

from __future__ import annotations

import math

import pytest
from engine_world import NEUTRAL, M, W, World, X, compiled, guard, leg, mission, sets, when

from mission.engine.engine import GOES_ON, MICROSTEPS, Engine
from mission.engine.restart import STICK
from mission.legs import Surface
from mission.model import (
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    AutoNode,
    Group,
    Handler,
    Loaded,
    NavigationMode,
    Outcome,
    Restarted,
    Result,
)
from protocol.messages import (
    ClearMission,
    DataQuery,
    Emergency,
    Order,
    SetSafety,
    StartMission,
)

LONG = 20000.0
MISSION = mission(leg("a", timeout=LONG), leg("b"))


def flying(body=MISSION, depth: float = 5.0) -> World:
    world = World(body)
    assert world.start()
    world.depth = depth
    world.wait(4.0)
    return world


# --- in -------------------------------------------------------------------------------------


def test_verdicts_stand_in_the_order_of_the_commands_whatever_overtook_them():
    world = World(MISSION)
    bad = SetSafety(radius=-1.0)
    out = world.tell(world.report(), DataQuery(), bad, X, world.fix(), StartMission(), SetSafety())
    assert [v.accepted for v in out.verdicts] == [False, False, True, False, True]
    assert out.verdicts[0].why == "DataQuery is not for the engine"
    assert "an emergency" in out.verdicts[3].why


def test_every_x_and_w_of_a_step_acts_and_has_one_verdict():
    world = flying()
    out = world.tell(X, W)
    assert [v.accepted for v in out.verdicts] == [True, True]
    assert [a.command for a in out.actions] == [Order.STOP, Order.SURFACE]
    assert world.state == SURFACING


def test_reports_and_outcomes_have_no_verdict_and_no_steps_of_their_own():
    world = flying()
    out = world.engine.step(world.t, [world.report(), world.fix()])
    assert (out.verdicts, out.actions, out.steps) == ((), (), ())
    out = world.engine.step(world.t, [Outcome(Result.ACCEPTED, b"@Z$", Order.STOP)])
    assert (out.verdicts, out.actions, out.steps) == ((), (), ())


def test_a_mission_that_is_stored_while_one_is_under_way_is_not_taken():
    other = Loaded(compiled(mission(leg("other"))))
    for world in (flying(), flying()):
        before = world.engine.chart
        world.tell(other)
        assert world.engine.chart is before
        world.tell(M)
        world.tell(other)
        assert world.engine.chart is before


def test_only_the_closing_of_the_node_acts_and_only_once():
    world = flying()
    world.tell(AutoNode(True))
    assert world.state == "autonomous/a"
    world.tell(AutoNode(False))
    assert world.state == IDLE_READY
    world.tell(Emergency(Order.STOP))
    world.tell(M)
    world.wait(3.0)
    before = len(world.actions)
    world.tell(AutoNode(False))
    assert len(world.actions) == before


@pytest.mark.parametrize("order", [X, W])
def test_a_restart_that_is_told_in_an_emergency_changes_nothing(order: Emergency):
    for during in ("autonomous/a", STICK):
        world = World()
        world.tell(order)
        before = world.state
        out = world.tell(Restarted(during))
        assert world.state == before
        assert not out.actions


def test_a_restart_out_of_idle_is_nothing():
    world = World()
    assert not world.tell(Restarted("")).actions
    assert world.state == IDLE_EMPTY


def test_whatever_the_operator_says_the_topside_was_heard():
    world = flying()
    world.engine.limit_topside_silence(30.0)
    world.engine.hear_topside(world.t)
    silent_at = world.t + 30.0
    world.until(silent_at - 0.001)
    assert world.state == "autonomous/a"
    world.until(silent_at)
    assert world.state == SURFACING


# --- limits ---------------------------------------------------------------------------------


def test_of_a_surfacing_and_a_brown_out_in_one_report_the_surfacing_acts():
    world = flying()
    bad = {"actuators": NEUTRAL, "roll": 3.0}
    for _ in range(2):
        world.t += 2.0
        out = world.tell(world.report(**bad))
    assert world.state == SURFACING
    assert [a.command for a in out.actions] == [Order.SURFACE]
    assert "roll" in world.engine.reason


def test_a_second_brown_out_surfaces_and_thrust_in_between_forgives_the_first():
    world = flying()
    world.actuators = NEUTRAL
    world.wait(4.0)
    assert world.state == "autonomous/a"
    world.actuators = (0.3, 0.0, 0.0, 0.0, 0.0)
    world.wait(4.0)
    world.actuators = NEUTRAL
    world.wait(4.0)
    assert world.state == "autonomous/a"
    world.wait(4.0)
    assert world.state == SURFACING
    assert "brown-out" in world.engine.reason


def circles(outer: int, rounds: int = 1) -> World:
    """Each round leaves at once, as soon as a report says 5 m. Nothing answers."""
    inner = Group("g", rounds, (leg("x", when("depth", ">", 1.0)),))
    world = World(mission(Group("o", outer, (inner,)), leg("end", timeout=LONG)))
    assert world.start()
    world.answer, world.depth = None, 5.0
    return world


def test_two_hundred_transitions_are_taken_in_one_step_and_the_others_in_the_next_ones():
    assert MICROSTEPS == 200
    world = circles(200)
    world.tell(world.report())
    assert world.state == "autonomous/end"
    world = circles(9, 50)
    taken = [len(world.tell(world.report()).steps)]
    for _ in range(2):
        world.t = world.engine.next_timer()
        taken.append(len(world.tell().steps))
    assert taken == [200, 200, 50]
    assert world.t == pytest.approx(100.0 + 2 * GOES_ON)
    assert world.state == "autonomous/end"


def test_between_so_many_transitions_an_operator_is_heard():
    world = circles(450)
    world.tell(world.report())
    assert world.state == "autonomous/o/g/x"
    world.tell(X)
    assert world.state == STOPPED


# --- time -----------------------------------------------------------------------------------


def test_after_the_stick_the_next_deadline_is_its_silence_and_then_its_being_forgotten():
    world = World()
    world.tell(world.report(), M)
    begun = world.t
    assert world.engine.next_timer() == begun + 2.0
    world.until(begun + 2.0, reports=False)
    assert world.state == MANUAL_WAITING
    assert world.engine.next_timer() == begun + 60.0
    world.until(begun + 59.999)
    assert world.state == MANUAL_WAITING
    world.until(begun + 60.0)
    assert world.state == IDLE_EMPTY
    assert world.engine.next_timer() is None


def test_while_it_surfaces_the_next_deadline_is_its_judging_or_the_surface():
    world = flying(depth=20.0)
    world.tell(W)
    begun = world.t
    assert world.engine.next_timer() == begun + 10.0
    world.t += 5.0
    world.depth = 0.2
    world.tell(world.report())
    assert world.engine.next_timer() == begun + 10.0
    world.until(begun + 10.0, reports=False)
    world.tell(world.report())
    assert world.engine.next_timer() == begun + 11.0
    world.until(begun + 11.0, reports=False)
    assert world.state == SURFACED


# --- whole ----------------------------------------------------------------------------------


def test_a_leg_is_placed_as_if_it_had_been_entered_so_long_ago():
    b = leg("b", timeout=50.0, otherwise="c")
    world = flying(mission(leg("a", timeout=LONG), b, leg("c", timeout=LONG)))
    world.engine.place("autonomous/b", {}, elapsed=40.0)
    assert world.state == "autonomous/b"
    assert world.engine.readings["elapsed"].value == 40.0
    begun = world.t
    world.tell(world.report())
    assert world.engine.next_timer() is not None
    world.until(begun + 9.999)
    assert world.state == "autonomous/b"
    world.until(begun + 10.0)
    assert world.state == "autonomous/c"


def test_only_a_mission_that_is_under_way_can_be_placed():
    with pytest.raises(LookupError, match="no mission is under way"):
        World(MISSION).engine.place("autonomous/a", {})


def test_a_placed_leg_has_its_set_as_accepted_and_nothing_is_sent_again():
    world = flying()
    before = len(world.actions)
    world.engine.place("autonomous/b", {})
    assert world.engine.readings["elapsed"].value == 0.0
    world.actuators = (0.0,) * 5
    for _ in range(3):
        world.t += 2.0
        world.tell(world.report())
    sent = [a for _, a in world.actions[before:]]
    assert len(sent) == 1, "the brown-out's, which asks for an accepted set"
    assert "brown-out" in sent[0].reason


def test_a_snapshot_of_an_engine_without_navigation_leaves_a_later_one_alone():
    world = World(navigation=False)
    kept = world.engine.snapshot()
    world.engine.attach(world.nav)
    world.tell(world.report())
    world.engine.restore(kept)
    assert world.nav.report is not None
    world.t += 2.0
    world.tell(world.report())
    assert world.engine.estimate.t == world.t


def test_a_snapshot_takes_the_navigation_back_too():
    world = flying()
    kept = world.engine.snapshot()
    world.nav.north = 77.0
    world.nav.mode = NavigationMode.NONE
    world.engine.restore(kept)
    assert (world.nav.north, world.nav.mode) == (0.0, NavigationMode.FIX)


# --- what it says ---------------------------------------------------------------------------


def test_without_a_mission_under_way_readings_begin_at_nothing():
    world = World()
    world.trembles = 0.0
    world.wait(6.0)
    engine = world.engine
    read = {name: row.value for name, row in engine.readings.items()}
    assert (read["elapsed"], read["mission_time"]) == (0.0, 0.0)
    assert (read["travelled"], read["round"]) == (0.0, 1.0)
    assert math.isnan(read["distance"])
    assert (engine.round, engine.leg, engine.mission_time) == (1, "", None)
    assert (engine.depth, engine.chart) == (0.2, None)
    assert engine.estimate.t == world.t


def test_in_manual_the_interrupted_leg_and_its_readings_are_told():
    world = flying(mission(Group("g", 2, (leg("a", timeout=LONG),))))
    world.tell(M)
    world.wait(1.0, reports=False)
    world.tell()
    assert world.engine.leg == "g/a"
    assert world.engine.mission_time == 5.0
    assert world.engine.readings["mission_time"].value == 5.0
    assert world.engine.round == 1
    assert world.engine.under_way == MANUAL_DRIVING


def test_every_state_has_its_region_and_its_reason():
    world = World(MISSION)
    assert (world.engine.region, world.engine.reason) == ("idle", "a mission is stored")
    world.tell(world.report())
    world.tell(X)
    assert (world.engine.region, world.engine.reason) == ("emergency", "X from the operator")
    world.tell(ClearMission())
    assert (world.engine.region, world.engine.reason) == ("idle", "cleared by the operator")
    world.tell(M)
    assert (world.engine.region, world.engine.reason) == ("manual", "the stick was moved")


def test_sinking_while_a_leg_climbs_is_that_ascents_and_not_a_limits():
    up = leg("up", kind=Surface(), settings=(), timeout=LONG)
    world = flying(mission(leg("a", timeout=None, duration=5.0), up), depth=10.0)
    world.wait(4.0)
    assert world.state == "autonomous/up"
    for _ in range(10):
        world.depth += 0.6
        world.wait(2.0)
    assert world.state == "autonomous/up"


def test_a_handler_whose_condition_holds_in_manual_acts_when_the_mission_goes_on():
    near = Handler(guard("altitude", "<", 3.0), "away")
    away = leg("away", settings=sets(heading=1.0), timeout=LONG)
    world = World(mission(leg("a", timeout=LONG), away, handlers=(near,)))
    assert world.start()
    world.depth = 5.0
    world.tell(M)
    world.altitude = 1.0
    world.wait(4.0)
    assert world.state == MANUAL_WAITING
    world.tell(StartMission())
    assert world.state == "autonomous/away"


def test_an_engine_says_nothing_before_its_first_step():
    engine = Engine(World().vehicle)
    assert engine.next_timer() is None
    assert (engine.state, engine.leg, engine.under_way) == (IDLE_EMPTY, "", "")
    assert engine.step(0.0).steps == ()
    assert engine.state != STOPPED
