"""Laws of the operator's commands: X and W from everywhere, @AA, @AC, @SP, the node AUTO."""

from __future__ import annotations

import pytest
from engine_world import HOME, M, W, World, X, compiled, fixes, leg, mission, sets, when

from mission.engine.engine import Engine
from mission.engine.restart import STICK, UNANSWERED
from mission.model import (
    IDLE_EMPTY,
    IDLE_READY,
    STOPPED,
    SURFACED,
    SURFACING,
    AutoNode,
    By,
    Loaded,
    Outcome,
    Position,
    Restarted,
    Result,
)
from protocol.messages import (
    UPWARD,
    ClearMission,
    DataQuery,
    Emergency,
    Order,
    Setpoint,
    SetSafety,
    StartMission,
)

MISSION = mission(leg("a", timeout=600.0), leg("b"))


def world_in(state: str) -> World:
    """A world that has come to ``state`` by the ways there are."""
    if state == IDLE_EMPTY:
        return World()
    world = World(MISSION)
    if state == IDLE_READY:
        return world
    assert world.start()
    world.depth = 5.0
    world.wait(4.0)
    if state.startswith("manual"):
        world.tell(M)
        if state == "manual/waiting":
            world.wait(3.0)
    elif state.startswith("emergency"):
        world.tell(X if state == STOPPED else W)
        if state == SURFACED:
            world.depth = 0.2
            world.wait(9.0)
    assert world.state == state
    return world


STATES = (
    IDLE_EMPTY,
    IDLE_READY,
    "autonomous/a",
    "manual/driving",
    "manual/waiting",
    STOPPED,
    SURFACING,
    SURFACED,
)


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize(("order", "target"), [(X, STOPPED), (W, SURFACING)])
def test_x_and_w_act_from_every_state_within_the_step(state: str, order: Emergency, target: str):
    world = world_in(state)
    out = world.tell(order)
    assert world.state == target
    assert out.actions[0].command is order.order
    assert {a.command for a in out.actions[1:]} <= {UPWARD}, "in idle the depth is not known"
    assert out.verdicts[0].accepted
    assert all(a.reason for a in out.actions)


@pytest.mark.parametrize("state", STATES)
def test_x_overtakes_everything_that_came_with_it(state: str):
    world = world_in(state)
    out = world.tell(StartMission(), world.report(), M, X, StartMission())
    assert world.state == STOPPED
    assert out.actions[0].command is Order.STOP
    assert len(out.verdicts) == 4


def test_x_and_w_are_never_the_same_command_again():
    world = world_in("autonomous/a")
    for _ in range(3):
        assert [a.command for a in world.tell(X).actions] == [Order.STOP]
    for _ in range(3):
        assert [a.command for a in world.tell(W).actions] == [Order.SURFACE]


def test_a_stop_goes_out_every_half_second_until_it_is_acknowledged():
    world = world_in("autonomous/a")
    world.answer = None
    world.tell(X)
    begun = len(world.actions)
    world.wait(2.1)
    times = [round(t - world.t + 2.1, 6) for t, a in world.actions[begun:]]
    assert times == [0.5, 1.0, 1.5, 2.0]
    world.tell(Outcome(Result.REFUSED, b"@ZAX0$", Order.STOP))
    world.wait(1.0)
    assert len(world.actions) == begun + 6
    world.tell(Outcome(Result.ACCEPTED, b"@ZAX0$", Order.STOP))
    world.wait(5.0)
    assert len(world.actions) == begun + 6


def test_after_stopped_nothing_is_sent_but_the_stop():
    world = world_in("autonomous/a")
    world.tell(X)
    begun = len(world.actions)
    world.depth, world.nav.north = 90.0, 1e5
    world.nav.doubt["depth"] = "frozen"
    world.wait(120.0)
    world.wait(20.0, reports=False)
    assert len(world.actions) == begun
    assert world.state == STOPPED


# --- @AA ----------------------------------------------------------------------------------


def test_start_flies_the_first_leg_and_sends_its_whole_set():
    world = World(MISSION)
    assert world.start()
    assert world.state == "autonomous/a"
    assert world.commands() == [Setpoint(surge=0.5, heading=0.0, depth=5.0)]


def test_a_second_start_while_it_runs_is_acknowledged_and_changes_nothing():
    world = world_in("autonomous/a")
    out = world.tell(StartMission())
    assert out.verdicts[0].accepted
    assert not out.actions
    assert not out.steps


@pytest.mark.parametrize("state", [IDLE_EMPTY, STOPPED, SURFACING, SURFACED, "manual/driving"])
def test_start_is_refused_where_there_is_nothing_to_start(state: str):
    world = world_in(state)
    out = world.tell(StartMission())
    assert not out.verdicts[0].accepted
    assert out.verdicts[0].why
    assert world.state == state


def test_a_mission_begins_out_of_waiting_at_the_surface_alone():
    world = world_in(IDLE_READY)
    world.tell(M)
    world.wait(4.0)
    world.depth = 5.0
    world.wait(2.0)
    world.tell(world.fix(3.0), StartMission())
    assert not world.verdicts[-1].accepted
    assert "deep" in world.verdicts[-1].why
    assert world.state == "manual/waiting"


def test_an_old_proof_of_the_surface_clears_nothing_where_no_depth_tells():
    """Fixes that end over a minute behind say no more: it may have sunk meanwhile, unseen."""
    world = world_in(SURFACED)
    world.depth = None
    fixes(world, 70)
    world.wait(12.0)
    world.tell(ClearMission())
    assert not world.verdicts[-1].accepted
    assert world.state == SURFACED


def test_start_waits_for_navigation_and_says_so():
    world = World(MISSION, navigation=False)
    assert not world.start()
    assert "navigation" in world.verdicts[-1].why
    world.engine.attach(world.nav)
    assert world.start()


def test_start_needs_a_vehicle_that_was_heard():
    world = World(MISSION)
    world.tell(world.fix())
    world.tell(StartMission())
    assert "not heard" in world.verdicts[-1].why


def test_start_needs_a_depth_to_believe():
    world = World(MISSION)
    world.nav.doubt["depth"] = "frozen"
    assert not world.start()
    assert "frozen" in world.verdicts[-1].why


def test_home_is_the_median_of_five_good_fixes():
    world = World(mission(leg("a"), home=None))
    world.tell(world.report())
    for north in (0.0, 1.0, 2.0, 3.0, 9.0):
        world.tell(StartMission())
        assert not world.verdicts[-1].accepted
        world.t += 0.2
        world.tell(world.fix(north=north))
    world.tell(StartMission())
    assert world.verdicts[-1].accepted
    assert world.nav.frame.to_local(*_rad(HOME))[0] == pytest.approx(-2.0, abs=1e-3)


def _rad(p: Position) -> tuple[float, float]:
    import math

    return math.radians(p.latitude_deg), math.radians(p.longitude_deg)


@pytest.mark.parametrize("bad", [{"hdop": 4.0}, {"hdop": None}, {"north": 25.0}])
def test_one_bad_fix_among_the_five_is_no_home(bad: dict[str, float]):
    world = World(mission(leg("a"), home=None))
    world.tell(world.report())
    for i in range(5):
        world.t += 0.2
        world.tell(world.fix(**(bad if i == 2 else {})))
    world.tell(StartMission())
    assert not world.verdicts[-1].accepted
    assert "five fixes" in world.verdicts[-1].why


def test_a_pool_mission_starts_without_any_fix():
    world = World(mission(leg("a"), home=None, start_without_fix=True))
    world.tell(world.report())
    world.tell(StartMission())
    assert world.verdicts[-1].accepted


def test_home_beyond_the_radius_is_refused():
    world = World(MISSION)
    world.tell(SetSafety(radius=200.0))
    world.tell(world.report(), world.fix(north=250.0))
    world.tell(StartMission())
    assert not world.verdicts[-1].accepted
    assert "250" in world.verdicts[-1].why


# --- @AC, @SP, AUTO -----------------------------------------------------------------------


@pytest.mark.parametrize("state", STATES)
def test_clear_leaves_idle_stopped_and_surfaced_alone(state: str):
    world = world_in(state)
    accepted = world.tell(ClearMission()).verdicts[0].accepted
    assert accepted == (state in (IDLE_EMPTY, IDLE_READY, SURFACED)), "STOPPED is 5 m deep here"
    assert world.state == (IDLE_EMPTY if accepted else state)
    if accepted:
        world.tell(StartMission())
        assert not world.verdicts[-1].accepted


@pytest.mark.parametrize(
    ("state", "says"),
    [
        ("autonomous/a", "a mission runs: stop it"),
        ("manual/driving", "the stick has the vehicle: stop it"),
        ("manual/waiting", "the stick has the vehicle: stop it"),
        (SURFACING, "wait until it is at the surface"),
    ],
)
def test_a_refused_clear_says_what_is_and_what_to_do(state: str, says: str) -> None:
    verdict = world_in(state).tell(ClearMission()).verdicts[0]
    assert not verdict.accepted
    assert says in verdict.why


def test_safety_keeps_what_is_left_out_and_refuses_nonsense():
    world = World(MISSION)
    world.tell(SetSafety(radius=300.0, depth=20.0))
    world.tell(SetSafety(radius=400.0))
    assert world.engine.safety == SetSafety(radius=400.0, depth=20.0)
    assert not world.tell(SetSafety(time=-1.0)).verdicts[0].accepted
    assert world.engine.safety == SetSafety(radius=400.0, depth=20.0)


def test_what_is_not_the_engines_is_answered_and_changes_nothing():
    world = world_in("autonomous/a")
    out = world.tell(DataQuery())
    assert not out.verdicts[0].accepted
    assert world.state == "autonomous/a"


def test_closing_auto_ends_the_mission_and_none_starts_until_it_is_open():
    world = world_in("autonomous/a")
    out = world.tell(AutoNode(False))
    assert world.state == IDLE_READY
    assert [a.command for a in out.actions] == [Order.STOP]
    world.depth = 0.2
    assert not world.start()
    assert "AUTO" in world.verdicts[-1].why
    world.tell(AutoNode(True))
    assert world.start()


def test_closing_auto_in_an_emergency_changes_nothing():
    world = world_in(SURFACING)
    assert not world.tell(AutoNode(False)).actions
    assert world.state == SURFACING


# --- restart ------------------------------------------------------------------------------


@pytest.mark.parametrize("state", STATES)
def test_a_restart_during_a_mission_or_an_ascent_surfaces_and_the_end_of_one_is_latched(state: str):
    """No depth is known yet, so X0 and U12 come first (R7); in stopped and surfaced X0 alone, for
    somebody may have it on deck, and what sinks from there is brought up again."""
    during = world_in(state).engine.under_way
    assert bool(during) == (not state.startswith("idle"))
    fresh = World(navigation=False)
    fresh.tell(Loaded(compiled(MISSION)), Restarted(during))
    rests = state in (STOPPED, SURFACED)
    assert fresh.state == (state if rests else SURFACING if during else IDLE_READY)
    if during:
        assert fresh.commands() == [Order.STOP if rests else UPWARD]
        assert not fresh.tell(ClearMission()).verdicts[0].accepted
    else:
        assert (fresh.state, fresh.commands()) == (IDLE_READY, [])


def test_a_restart_while_the_stick_has_the_vehicle_without_a_mission_stops_and_is_idle():
    world = world_in(IDLE_READY)
    world.tell(M)
    during = world.engine.under_way
    assert during == STICK
    fresh = World(navigation=False)
    fresh.answer = None
    fresh.tell(Restarted(during))
    assert fresh.state == IDLE_EMPTY
    assert fresh.commands() == [Order.STOP]
    fresh.wait(2.0)
    assert len(fresh.commands()) > 3  # until it is acknowledged
    fresh.tell(Outcome(Result.ACCEPTED, b"@ZAX0$", Order.STOP))
    assert fresh.engine.under_way == ""


def test_a_stop_is_under_way_in_idle_until_it_is_acknowledged():
    world = world_in("autonomous/a")
    world.answer = None
    world.tell(AutoNode(False))
    assert (world.state, world.engine.under_way) == (IDLE_READY, UNANSWERED)
    world.tell(Outcome(Result.LOST, b"@ZAX0$", Order.STOP))
    assert world.engine.under_way == UNANSWERED
    world.tell(Outcome(Result.ACCEPTED, b"@ZAX0$", Order.STOP))
    assert world.engine.under_way == ""


@pytest.mark.parametrize("state", [STOPPED, SURFACED, IDLE_READY, "manual/waiting"])
def test_a_thruster_that_turns_after_an_acknowledged_stop_is_stopped_again(state: str):
    world = world_in("autonomous/a" if state == IDLE_READY else state)
    if state == IDLE_READY:
        world.tell(AutoNode(False))
    assert world.state == state
    before = len(world.actions)
    world.wait(6.0)
    assert not world.commands()[before:]  # it has stopped, and nothing more is said
    world.stops = False
    world.wait(6.0)
    assert world.state == state
    assert set(world.commands()[before:]) == {Order.STOP}
    world.stops = True
    before = len(world.actions)
    world.wait(6.0)
    assert not world.commands()[before:]


def test_a_thruster_that_turns_in_idle_is_nothing_while_no_stop_was_said():
    world = world_in(IDLE_READY)
    world.wait(10.0)
    assert not world.actions


def test_a_thruster_that_turns_as_the_program_begins_is_stopped():
    """A program may end between a word and the record of it."""
    world = world_in(IDLE_READY)
    world.stops = False
    world.tell(Restarted(""))
    world.wait(10.0)
    assert set(world.commands()) == {Order.STOP}
    assert world.state == IDLE_READY


def test_clearing_does_not_end_a_stop_that_nobody_acknowledged():
    world = world_in("autonomous/a")
    world.answer = None
    world.tell(X)
    world.depth = 0.2
    world.tell(world.report())
    assert world.tell(ClearMission()).verdicts[0].accepted
    assert world.state == IDLE_EMPTY
    before = len(world.commands())
    world.wait(2.0)
    assert set(world.commands()[before:]) == {Order.STOP}
    assert world.engine.under_way == UNANSWERED
    world.tell(Outcome(Result.ACCEPTED, b"@ZAX0$", Order.STOP))
    before = len(world.commands())
    world.wait(2.0)
    assert not world.commands()[before:]
    assert world.engine.under_way == ""


# --- the engine itself --------------------------------------------------------------------


def test_time_never_goes_back():
    world = World()
    world.tell(world.report())
    with pytest.raises(ValueError, match="back"):
        world.engine.step(world.t - 1.0)


def test_every_leg_that_is_left_says_why():
    world = World(mission(leg("a", when("elapsed", ">", 5.0)), leg("b", timeout=30.0)))
    assert world.start()
    world.depth = 5.0
    world.wait(10.0)
    world.tell(X)
    left = [s for s in world.steps if any(p.startswith("autonomous/") for p in s.exited)]
    assert [s.by for s in left] == [By.UNTIL, By.OPERATOR]


def test_an_unreadable_state_never_comes_from_garbage():
    engine = Engine(World().vehicle)
    out = engine.step(1.0, [object(), DataQuery()])
    assert engine.state == IDLE_EMPTY
    assert len(out.verdicts) == 2


def test_a_leg_with_a_heading_sends_what_was_written():
    world = World(mission(leg("a", settings=sets(surge=0.25, heading=1.5))))
    assert world.start()
    assert world.commands()[-1] == Setpoint(surge=0.25, heading=1.5)
