"""R6: the stick takes over at once, lets go by time, and the mission goes on where it was."""

from __future__ import annotations

import pytest
from engine_world import M, W, World, X, leg, mission, sets, when
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.model import (
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACING,
    AutoNode,
    Group,
)
from mission.model.shipped import load_vehicle
from protocol.messages import Emergency, Order, Setpoint, SetSafety, StartMission


def flying() -> World:
    group = Group(
        "g", 3, (leg("a", timeout=None, duration=10.0), leg("b", timeout=None, duration=10.0))
    )
    world = World(mission(group, leg("c", when("elapsed", ">", 30.0), timeout=400.0)))
    assert world.start()
    world.depth = 5.0
    return world


def drive(world: World, seconds: float, period: float = 0.3) -> None:
    """M every ``period``; as built there is no report meanwhile."""
    for _ in range(round(seconds / period)):
        assert world.tell(M).verdicts[0].accepted
        world.wait(period, reports=False)


def test_any_m_takes_over_at_once_and_nothing_is_sent():
    world = flying()
    out = world.tell(M)
    assert world.state == MANUAL_DRIVING
    assert out.verdicts[0].accepted
    assert not out.actions


def test_while_m_arrives_every_z_is_held_back():
    world = flying()
    begun = len(world.actions)
    drive(world, 100.0)
    assert len(world.actions) == begun
    assert world.state == MANUAL_DRIVING


@pytest.mark.parametrize("depth", [None, 4.8])
def test_a_stick_that_is_forgotten_turns_nothing_while_auto_is_closed(depth):
    """Somebody works on the vehicle: it surfaces as soon as the node is open again."""
    world = World(mission(leg("a", timeout=400.0)))
    world.depth = depth
    drive(world, 3.0)
    world.tell(AutoNode(False))
    begun = len(world.actions)
    world.wait(300.0)
    assert world.state == MANUAL_WAITING
    assert {a.command for _, a in world.actions[begun:]} <= {Order.STOP}
    world.tell(AutoNode(True))
    assert world.state == SURFACING


@pytest.mark.parametrize("stands", [True, False])
def test_a_stick_that_is_forgotten_believes_no_depth_that_stands_since_before_it(stands: bool):
    """The board reports nothing under the stick: a depth that froze is not found out."""
    world = World(mission(leg("a", timeout=400.0)))
    world.trembles = 0.0
    world.tell(world.report())
    drive(world, 30.0)
    for _ in range(40):
        world.depth += 0.0 if stands else 0.001
        world.wait(2.0)
    assert world.state == (SURFACING if stands else IDLE_READY)


@pytest.mark.parametrize("name", ["motorboards", "robot"])
def test_a_stick_that_is_forgotten_turns_nothing_on_what_never_tells_a_depth(name: str):
    """No report could end an ascent: it may lie on a bench."""
    world = World(vehicle=load_vehicle(name))
    world.depth = None
    drive(world, 3.0)
    begun = len(world.actions)
    world.wait(100.0)
    assert world.state == IDLE_EMPTY
    assert {a.command for _, a in world.actions[begun:]} <= {Order.STOP}


@pytest.mark.parametrize("order", [X, None])
def test_what_the_stick_leads_down_is_no_unexplained_descent_when_it_ends(order):
    world = World(mission(leg("a", timeout=400.0)))
    world.wait(4.0)
    for _ in range(200):
        world.tell(M)
        world.wait(0.3)
        world.depth += 0.08
    assert world.engine.breaches == ()
    world.tell(*([order] if order else []))
    for rate in (0.2, 0.1, 0.05, 0.0, 0.0):
        world.wait(2.0)
        world.depth += rate
    assert world.state == (STOPPED if order else MANUAL_WAITING)


@pytest.mark.parametrize("how", ["stick", "W"])
def test_a_stop_behind_a_dive_that_no_report_told_of_is_a_stop(how: str):
    """As built the board says nothing under the stick, and W goes on diving at first."""
    world = World(mission(leg("a", timeout=400.0)))
    world.wait(4.0)
    if how == "stick":
        drive(world, 12.0)
        world.depth = 4.0
    else:
        world.tell(W)
        for _ in range(4):
            world.depth += 1.0
            world.wait(2.0)
    world.tell(X)
    for sinks in (0.3, 0.3, 0.2, 0.1, 0.0):
        world.depth += sinks
        world.wait(2.0)
    assert world.state == STOPPED


@pytest.mark.parametrize("told", [(), (1,), range(100)], ids=["nothing", "once", "all"])
@pytest.mark.parametrize("order", [W, M], ids=["W", "stick"])
def test_an_x_behind_a_dive_is_a_stop_however_much_of_it_reports_told(order, told):
    world = World()
    world.depth = 1.0
    world.wait(8.0)
    world.tell(order)
    for fifth in range(100):
        world.t += 0.2
        world.depth += 0.04
        world.tell(*([M] if order is M else []), *([world.report()] if fifth in told else []))
    world.tell(X)
    for _ in range(12):
        world.t += 1.0
        world.depth += 0.15
        world.tell(world.report())
    assert world.state == STOPPED


@pytest.mark.parametrize("told", [True, False])
def test_what_lay_deeper_behind_the_stick_than_before_it_has_not_sunk_at_rest(told: bool):
    """By what it was before, full thrust took it away from whoever moves it."""
    world = World()
    world.wait(8.0)
    for _ in range(20):
        world.depth += 0.15
        world.tell(M, *([world.report()] if told else []))
        world.t += 1.0
    world.wait(15.0)
    assert world.state == MANUAL_WAITING


def test_a_stick_that_is_forgotten_as_the_program_stood_still_with_auto_closed_stops():
    world = World(mission(leg("a", timeout=400.0)))
    world.tell(world.report(), AutoNode(False))
    world.depth = 4.8
    drive(world, 3.0)
    world.t += 90.0
    world.tell(world.report())
    assert world.state == MANUAL_WAITING
    assert world.commands()[-1] is Order.STOP


def test_two_seconds_of_silence_stop_everything_and_bring_reports_back():
    world = flying()
    drive(world, 3.0)
    begun = len(world.actions)
    world.tell(M)
    world.wait(1.99, reports=False)
    assert len(world.actions) == begun
    world.wait(0.02, reports=False)
    assert world.state == MANUAL_WAITING
    assert [a.command for _, a in world.actions[begun:]] == [Order.STOP]


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("auv", "no M for 2 s: the STM32 back to automatic with everything stopped"),
        *((name, "no M for 2 s: everything stopped") for name in ("coreboard", "robot")),
    ],
)
def test_the_journal_says_of_a_silent_stick_what_a_stop_does_to_the_manual_of_the_board(
    name: str, why: str
):
    world = World(vehicle=load_vehicle(name))
    world.tell(world.report(), M)
    world.wait(2.1)
    assert world.state == MANUAL_WAITING
    assert world.actions[-1][1].reason == why


def test_the_stick_takes_over_again_from_waiting():
    world = flying()
    world.tell(M)
    world.wait(3.0)
    world.tell(M)
    assert world.state == MANUAL_DRIVING


@pytest.mark.parametrize(
    ("depth", "target"), [(0.3, IDLE_READY), (0.5, SURFACING), (8.0, SURFACING), (None, SURFACING)]
)
def test_a_minute_of_silence_ends_manual_by_the_depth(depth: float | None, target: str):
    world = flying()
    world.tell(M)
    world.depth = depth
    world.wait(59.9)
    assert world.state == MANUAL_WAITING
    world.wait(0.2)
    assert world.state == target


@pytest.mark.parametrize(
    ("depth", "state", "last"), [(0.2, IDLE_EMPTY, Order.STOP), (3.0, SURFACING, Order.SURFACE)]
)
def test_a_stick_that_is_forgotten_as_the_program_stood_still_is_stopped_first(
    depth: float, state: str, last: Order
):
    world = World()
    world.depth = depth
    world.wait(4.0)
    world.tell(M)
    before = len(world.commands())
    world.t += 90.0
    world.tell(world.report())
    said = world.commands()[before:]
    assert (world.state, said[0], said[-1]) == (state, Order.STOP, last)


def test_a_minute_of_silence_without_any_mission_is_idle_and_empty():
    world = World()
    world.tell(world.report(), M)
    world.wait(60.1)
    assert world.state == IDLE_EMPTY


def test_how_long_is_configurable():
    from mission.engine.engine import Engine

    world = World()
    world.engine = Engine(world.vehicle, world.nav, forgotten_after=20.0)
    world.tell(world.report(), M)
    world.wait(20.1)
    assert world.state == IDLE_EMPTY


def test_the_mission_goes_on_only_by_a_new_start_two_seconds_after_the_stick():
    world = flying()
    world.tell(M)
    world.wait(1.9)
    assert not world.tell(StartMission()).verdicts[0].accepted
    world.wait(0.2)
    assert world.tell(StartMission()).verdicts[0].accepted
    assert world.state == "autonomous/g/a"


def test_the_interrupted_leg_is_entered_anew_with_its_whole_set():
    world = flying()
    world.wait(6.0)
    world.tell(M)
    world.wait(20.0)
    out = world.tell(StartMission())
    assert [a.command for a in out.actions] == [Setpoint(surge=0.5, heading=0.0, depth=5.0)]
    world.wait(9.9)
    assert world.state == "autonomous/g/a"
    world.wait(0.2)
    assert world.state == "autonomous/g/b"


def test_rounds_go_on_after_an_interruption():
    world = flying()
    world.wait(25.0)  # the second round, leg a
    assert world.engine.round == 2
    drive(world, 6.0)
    world.wait(3.0)
    assert world.tell(StartMission()).verdicts[0].accepted
    assert world.engine.round == 2
    world.wait(10.1 + 10.0 + 10.0 + 10.0)
    assert world.state == "autonomous/c"


def test_the_missions_clock_goes_on_in_manual():
    world = flying()
    world.tell(M)
    world.wait(50.0)
    assert world.tell(StartMission()).verdicts[0].accepted
    assert world.engine.mission_time == pytest.approx(50.0)


def test_the_limit_of_time_counts_from_the_missions_begin_through_a_stick():
    world = flying()
    world.tell(SetSafety(time=60.0))
    world.tell(M)
    world.wait(50.0)
    assert world.tell(StartMission()).verdicts[0].accepted
    world.wait(12.0)
    assert world.state == SURFACING
    assert "limit time" in world.engine.reason


def test_the_age_of_the_reports_starts_again():
    world = flying()
    drive(world, 30.0)
    world.wait(2.5, reports=False)
    assert world.tell(StartMission()).verdicts[0].accepted
    world.wait(4.9, reports=False)
    assert world.state == "autonomous/g/a"
    world.wait(0.2, reports=False)
    assert world.state == SURFACING


def test_a_held_stick_does_not_cancel_a_surfacing():
    world = flying()
    drive(world, 3.0)
    world.tell(W)
    for _ in range(20):
        assert not world.tell(M).verdicts[0].accepted
        world.wait(0.3)
    assert world.state == SURFACING
    world.wait(2.0)
    world.push()
    assert world.state == MANUAL_DRIVING


@pytest.mark.parametrize("order", [X, W])
def test_after_an_emergency_the_stick_does_not_lead_back_into_the_mission(order: Emergency):
    world = flying()
    world.tell(order)
    world.wait(3.0)
    world.push()
    assert world.verdicts[-1].accepted
    world.wait(3.0)
    assert not world.tell(StartMission()).verdicts[0].accepted
    assert "emergency" in world.verdicts[-1].why
    world.depth = 0.2
    world.wait(60.0)
    assert world.state == IDLE_READY
    assert world.start()
    assert world.state == "autonomous/g/a"


def test_from_idle_the_stick_and_then_a_start_begin_the_mission():
    world = World(mission(leg("a")))
    world.tell(M)
    world.wait(4.0)
    assert world.start()
    assert world.state == "autonomous/a"


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(0.05, 4.0), min_size=1, max_size=12))
def test_whatever_the_stick_does_nothing_but_stop_is_ever_sent(pauses: list[float]):
    world = flying()
    begun = len(world.actions)
    for pause in pauses:
        world.tell(M)
        world.wait(pause, reports=False)
    sent = [a for _, a in world.actions[begun:]]
    assert {a.command for a in sent} <= {Order.STOP}
    assert len(sent) == sum(p >= 2.0 for p in pauses)


AFLOAT = sets(surge=0.5, heave=0.0)


def blind_behind_the_stick(heave: float) -> World:
    """Interrupted without a depth, whose last one was the surface's, and started again."""
    down = leg("down", timeout=None, duration=5.0, settings=sets(surge=0.5, heave=heave))
    world = World(mission(down, leg("run", timeout=300.0, settings=AFLOAT)))
    assert world.start()
    world.wait(1.0)
    world.nav.doubt["depth"] = "frozen"
    world.wait(4.5)
    drive(world, 3.0)
    world.wait(2.1)
    assert world.tell(StartMission()).verdicts[0].accepted
    return world


@pytest.mark.parametrize("heave", [0.5, 0.0], ids=["a set", "the stick alone"])
def test_what_led_down_without_a_depth_still_counts_when_the_mission_goes_on(heave: float):
    world = blind_behind_the_stick(heave)
    world.wait(5.9)
    assert world.state == "autonomous/run"
    world.wait(0.2)
    assert world.state == SURFACING
    assert "depth unknown" in world.engine.reason
