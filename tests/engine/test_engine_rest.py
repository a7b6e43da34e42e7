"""R7: no state is an end. What sinks from rest is brought up, and only at the surface all is over."""

from __future__ import annotations

import math

import pytest
from engine_world import HOME, VEHICLE, M, W, World, X, compiled, fixes, leg, mission, sets

from mission.engine.attitude import Attitude
from mission.engine.rest import Rest
from mission.engine.restart import STICK, UNSEEN
from mission.legs import Surface
from mission.model import (
    CONTRADICTED,
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    UNKNOWN,
    AutoNode,
    LineOpened,
    Loaded,
    Outcome,
    Restarted,
    Result,
)
from protocol.messages import UPWARD, ClearMission, Emergency, Order, StartMission, Telemetry

MISSION = mission(leg("a", timeout=600.0))
REST = (IDLE_READY, MANUAL_WAITING, SURFACED)


def at_rest(state: str, depth: float = 0.2) -> World:
    world = World(MISSION)
    world.tell(world.report())
    if state == SURFACED:
        world.tell(W)
        world.wait(10.0)
    elif state == STOPPED:
        world.tell(X)
    elif state == MANUAL_WAITING:
        world.tell(M)
        world.wait(3.0)
    world.depth = depth
    world.wait(2.0)
    assert world.state == state
    return world


def sent(world: World) -> set[object]:
    """Since it came to rest, without what led there."""
    return set(world.commands()[1:])


def sink(world: World, rate: float, until: float) -> None:
    assert world.depth is not None
    while world.depth < until and world.state != SURFACING:
        world.depth += 2.0 * rate
        world.wait(2.0)


@pytest.mark.parametrize(
    ("state", "rate"),
    [
        *((state, rate) for state in REST for rate in (0.1, 0.3, 0.5)),
        (IDLE_READY, 0.03),
        (SURFACED, 0.03),
    ],
)
def test_what_sinks_from_rest_is_brought_up_by_thrust_before_it_is_deep(state: str, rate: float):
    world = at_rest(state)
    sink(world, rate, 20.0)
    assert world.state == SURFACING
    assert world.commands()[-1] == UPWARD
    deep = 1.0 if state == SURFACED else 2.0
    assert world.depth <= deep + 4.0 * rate + 1e-9


@pytest.mark.parametrize("state", [*REST, STOPPED])
def test_at_rest_a_depth_that_is_not_known_turns_no_thruster(state: str):
    world = at_rest(state)
    world.nav.doubt["depth"] = "frozen"
    for _ in range(40):
        world.depth += 1.0
        world.wait(1.0)
    assert sent(world) <= {Order.STOP}
    assert world.state == state


@pytest.mark.parametrize("state", [IDLE_READY, SURFACED, STOPPED])
def test_while_auto_is_closed_nothing_turns_by_itself(state: str):
    world = at_rest(state)
    world.tell(AutoNode(False))
    sink(world, 0.3, 120.0)
    world.wait(60.0)
    assert sent(world) <= {Order.STOP}
    assert world.state == state


@pytest.mark.parametrize("state", [*REST, STOPPED])
def test_at_rest_waves_noise_and_a_jump_on_deck_turn_no_thruster(state: str):
    world = at_rest(state)
    for second in range(300):
        world.depth = 0.4 + 0.4 * math.sin(second) + (4.6 if second == 100 else 0.0)
        world.wait(1.0)
    assert sent(world) <= {Order.STOP}


def test_lying_on_the_floor_of_a_pool_turns_no_thruster():
    world = at_rest(IDLE_READY, 3.2)
    world.wait(20.0)
    for second in range(600):
        world.depth = 3.2 + 0.15 * math.sin(7.3 * second)
        world.wait(2.0)
    assert world.commands() == []


def test_a_stop_leaves_the_vehicle_to_its_buoyancy_for_twenty_seconds_and_no_longer():
    world = at_rest(STOPPED, 8.0)
    begun = world.t
    while world.state == STOPPED:
        world.wait(1.0)
    assert 20.0 <= world.t - begun <= 24.0
    assert world.state == SURFACING
    assert UPWARD in world.commands()


def test_a_stop_that_lets_it_rise_is_left_alone():
    world = at_rest(STOPPED, 8.0)
    while world.depth > 0.3:
        world.depth -= 0.06
        world.wait(2.0)
    world.wait(60.0)
    assert world.state == STOPPED
    assert UPWARD not in world.commands()


@pytest.mark.parametrize("rises_for", range(4, 30, 2))
def test_a_stop_counts_twenty_seconds_from_the_last_rise_whenever_that_was(rises_for: int):
    world = at_rest(STOPPED, 12.0)
    for _ in range(rises_for):
        world.depth -= 0.2
        world.wait(1.0)
    turned = world.t
    while world.state == STOPPED:
        world.depth += 0.05  # slower than the limit of an unexplained descent
        world.wait(1.0)
    assert 15.0 <= world.t - turned <= 24.0
    assert UPWARD in world.commands()


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.2])
def test_a_stop_leaves_alone_what_rises_slowly_by_a_noisy_depth(noise: float):
    world = at_rest(STOPPED, 14.0)
    for second in range(300):
        world.depth = 14.0 - 0.04 * second + noise * math.sin(2.7 * second)
        world.wait(1.0)
    assert world.state == STOPPED
    assert UPWARD not in world.commands()


def test_it_is_brought_up_as_often_as_it_sinks_and_then_held_up():
    world = at_rest(SURFACED)
    for _ in range(3):
        world.depth = 0.2
        world.wait(4.0)
        sink(world, 0.3, 9.0)
        assert world.state == SURFACING
        world.depth = 0.2
        world.wait(9.0)
        assert world.state == SURFACED
        assert world.commands()[-1] == UPWARD, "let go, it would sink again"
        assert "held up" in world.engine.reason
    world.wait(120.0)
    assert world.commands()[-1] == UPWARD


@pytest.mark.parametrize(
    ("roll", "rises", "held"), [(0.0, 0.0, True), (0.0, 0.5, False), (170.0, 0.0, False)]
)
def test_what_sank_is_held_up_though_its_ascent_lets_it_go_when_it_is_up(roll, rises, held):
    """Unless letting go has made it rise, or it may be upside down."""
    world = at_rest(SURFACED)
    sink(world, 0.3, 9.0)
    world.depth = 4.0
    while world.commands()[-1] is not Order.STOP:
        world.wait(1.0)
    world.roll = math.radians(roll)
    while world.depth > 0.3 and rises:
        world.depth -= rises
        world.wait(2.0)
    world.depth = 0.2
    begun = world.t
    while world.state == SURFACING and world.t < begun + 30.0:
        world.wait(2.0)
        world.roll += math.radians(0.1)
    assert world.state == SURFACED
    assert 10.0 < world.t - begun <= 16.0 if held else world.t - begun <= 10.0  # behind the thrust
    assert ("held up" in world.engine.reason) is held
    assert world.commands()[-1] == (UPWARD if held else Order.STOP)


def test_an_operators_stop_lets_go_of_what_was_held_up():
    world = at_rest(SURFACED)
    sink(world, 0.3, 9.0)
    world.depth = 0.2
    world.wait(9.0)
    world.tell(X)
    assert world.commands()[-1] is Order.STOP


def test_what_is_held_up_is_not_stopped_for_a_stop_that_was_acknowledged_before():
    world = at_rest(SURFACED)
    sink(world, 0.3, 9.0)
    world.tell(Outcome(Result.ACCEPTED, b"@ZAX0$", Order.STOP))  # of a turn of the ascent
    world.depth = 0.2
    world.wait(9.0)
    assert world.state == SURFACED
    world.wait(20.0)  # the thrusters turn, as they should
    assert world.commands()[-1] == UPWARD


def test_what_was_held_up_is_let_go_when_it_is_cleared():
    world = at_rest(SURFACED)
    sink(world, 0.3, 9.0)
    world.depth = 0.2
    world.wait(9.0)
    assert world.commands()[-1] == UPWARD
    world.tell(ClearMission())
    assert world.state == IDLE_EMPTY
    assert world.commands()[-1] is Order.STOP


def held_up() -> World:
    """At the surface by thrust, since it sank when it was let go; the thrusters turn."""
    world = at_rest(SURFACED)
    sink(world, 0.3, 9.0)
    world.depth = 0.2
    world.wait(9.0)
    assert world.state == SURFACED
    assert world.commands()[-1] == UPWARD
    return world


def test_what_holds_it_up_is_said_again_behind_a_line_that_was_away():
    world = held_up()
    world.depth = None
    world.wait(2.0)
    said = len(world.actions)
    world.tell(LineOpened())
    assert world.commands()[said:] == [UPWARD]


@pytest.mark.parametrize("answer", [None, Result.ACCEPTED])
def test_a_stop_is_said_again_behind_a_line_that_was_away_whether_it_was_answered_or_not(
    answer: Result | None,
):
    """As flight 42 of seed 11530: a late answer came 52 ms after the line, before the next try."""
    world = at_rest(IDLE_READY)
    world.answer = answer
    world.tell(X)
    said = len(world.actions)
    world.tell(LineOpened())
    assert world.commands()[said:] == [Order.STOP]


def test_what_holds_it_up_is_said_again_while_reports_show_it_off():
    """By two reports each time: one may have left before it was heard."""
    world = held_up()
    world.depth = None
    said = len(world.actions)
    world.wait(20.0)
    assert len(world.actions) == said
    world.actuators = (0.0,) * 5
    world.wait(4.0)
    assert world.commands()[said:] == [UPWARD]


def test_a_board_that_is_deaf_to_what_holds_it_up_is_told_the_other_word_that_pushes_up():
    """As flight 10267 of seed 5717: deaf to U12, it sank out of each hold, and W alone lifted it."""
    world = held_up()
    said = len(world.actions)
    world.actuators = (0.0,) * 5
    world.wait(8.0)
    assert world.commands()[said:] == [UPWARD, Order.SURFACE]
    world.actuators = (0.5,) * 5
    world.wait(20.0)
    assert world.commands()[said:] == [UPWARD, Order.SURFACE]
    sink(world, 0.3, 9.0)
    assert (world.state, world.commands()[-1]) == (SURFACING, Order.SURFACE)
    world.depth = 0.2
    world.wait(9.0)
    assert (world.state, world.commands()[-1]) == (SURFACED, Order.SURFACE), "and holds it up"


def test_without_a_depth_it_is_lifted_by_the_word_that_last_showed_a_thruster_on():
    """Two brown-outs in succession had it lifted by W, which as built turns nothing for long: what
    is heavy sank in the turns of U12, and stayed on the bottom."""
    world = held_up()
    fixes(world, 10)
    world.depth, world.actuators = None, (0.0,) * 5
    fixes(world, 8)
    assert world.commands()[-1] is Order.SURFACE, "of the hold, by two neutral reports"
    world.wait(9.0, reports=False)
    assert (world.state, world.commands()[-1]) == (SURFACING, UPWARD)
    world.wait(36.0, reports=False)
    assert world.commands()[-1] == UPWARD, "four turns of it"


def test_with_a_depth_it_is_lifted_by_the_word_that_last_showed_a_thruster_on_too():
    world = held_up()
    world.wait(4.0)
    world.actuators = (0.0,) * 5
    world.wait(6.0)
    assert world.commands()[-1] is Order.SURFACE
    sink(world, 0.3, 9.0)
    assert (world.state, world.commands()[-1]) == (SURFACING, UPWARD)


def test_what_has_held_it_up_in_between_is_said_again_and_nothing_else():
    """Its board begins anew now and then."""
    world = held_up()
    said = len(world.actions)
    for _ in range(4):
        world.actuators = (0.0,) * 5
        world.wait(4.0)
        world.actuators = (0.5,) * 5
        world.wait(6.0)
    assert set(world.commands()[said:]) == {UPWARD}


@pytest.mark.parametrize("taken", [M, ClearMission()])
def test_what_the_stick_or_a_clear_has_taken_over_is_held_up_no_more(taken):
    """Nor is it behind the next ascent: it may float by now, and people may pick it up."""
    world = held_up()
    if taken is M:
        world.push()
    else:
        world.tell(taken)
    said = len(world.actions)
    world.actuators = (0.0,) * 5
    world.wait(20.0)
    assert set(world.commands()[said:]) <= {Order.STOP}
    world.tell(W)
    world.wait(12.0)
    assert (world.state, world.commands()[-1]) == (SURFACED, Order.STOP)


def test_an_ascent_of_what_was_held_up_goes_on_when_auto_is_closed():
    """Nothing is let go: it is let go at the surface."""
    world = held_up()
    world.depth = 0.7
    world.tell(W)
    said = len(world.actions)
    world.tell(AutoNode(False))
    assert world.state == SURFACING
    assert len(world.actions) == said


def test_what_is_held_up_is_let_go_when_auto_is_closed_and_until_it_is_acknowledged():
    """A hand may be at a thruster: a stop as any other."""
    world = held_up()
    world.answer, world.stops = None, False
    said = len(world.actions)
    world.tell(AutoNode(False))
    world.wait(10.0)
    assert world.commands()[said:] == [Order.STOP] * 21, "every 500 ms"
    world.answer, world.stops = Result.ACCEPTED, True
    world.wait(0.5)
    said = len(world.actions)
    world.tell(LineOpened())
    world.wait(30.0)
    assert set(world.commands()[said:]) == {Order.STOP}
    assert (world.state, "node AUTO" in world.engine.reason) == (SURFACED, True)


@pytest.mark.parametrize("blind", [True, False])
def test_what_was_let_go_when_auto_was_closed_sinks_until_it_is_open(blind: bool):
    """Also where nobody saw it sink: by the first depth that is told again."""
    world = held_up()
    said = len(world.actions)
    world.tell(AutoNode(False))
    if blind:
        world.depth = None
        world.wait(60.0)
        world.depth = 5.0
    else:
        sink(world, 0.3, 5.0)
    world.wait(60.0)
    assert set(world.commands()[said:]) == {Order.STOP}
    assert world.state == SURFACED
    world.tell(AutoNode(True))
    world.wait(4.0)
    assert world.state == SURFACING
    world.depth = 0.2
    world.wait(20.0)
    assert world.commands()[-1] == UPWARD
    assert "held up" in world.engine.reason


def test_what_was_let_go_when_auto_was_closed_and_is_opened_at_once_comes_up_by_its_fixes():
    world = held_up()
    world.depth = None
    told_fixes(world, 10)
    world.tell(AutoNode(False), AutoNode(True))
    assert world.commands()[-1] is Order.STOP
    world.wait(10.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("way", [UPWARD, Order.STOP])
def test_an_ascent_goes_on_while_auto_is_closed_and_lets_go_at_the_surface(way):
    """It never gives up; but full thrust begins nothing at the surface, and holds nothing there."""
    world = at_rest(SURFACED)
    sink(world, 0.3, 9.0)
    world.depth = 4.0
    world.tell(AutoNode(False))
    world.wait(60.0)
    assert {UPWARD, Order.SURFACE, Order.STOP} <= set(world.commands()[1:])
    while world.commands()[-1] != way:
        world.wait(1.0)
    assert world.state == SURFACING
    world.depth = 0.2
    said = len(world.actions)
    world.wait(8.0)
    assert world.state == SURFACED
    assert set(world.commands()[said:]) == {Order.STOP}
    world.wait(60.0)
    assert set(world.commands()[said:]) == {Order.STOP}


@pytest.mark.parametrize("fixes", [True, False])
def test_what_is_held_up_without_a_depth_comes_up_again_when_its_fixes_end(fixes: bool):
    world = held_up()
    world.depth = None
    for second in range(200):
        world.wait(1.0)
        world.tell(world.fix(0.3 * second))
    assert world.state == SURFACED
    for second in range(20):
        world.wait(1.0)
        if fixes:
            world.tell(world.fix(-0.3 * second - 1.0))
    assert world.state == (SURFACED if fixes else SURFACING)


def told_fixes(world: World, seconds: int, begin: int = 0) -> None:
    """A new place each second, half a metre on."""
    for second in range(begin, begin + seconds):
        world.wait(1.0)
        world.tell(world.fix(0.5 * second))


@pytest.mark.parametrize("reports", [True, False])
@pytest.mark.parametrize("cleared", [True, False])
def test_what_sinks_unseen_is_brought_up_without_a_report_and_though_it_was_cleared(
    reports: bool, cleared: bool
):
    world = at_rest(SURFACED)
    world.depth = None
    told_fixes(world, 3)
    if cleared:
        world.tell(world.report(depth=0.2))
        world.tell(ClearMission())
        assert world.state == IDLE_EMPTY
    world.wait(20.0, reports=reports)
    assert world.state == SURFACING
    assert "no fix for 8 s" in world.engine.reason


@pytest.mark.parametrize("lives", [True, False])
@pytest.mark.parametrize("cleared", [True, False])
def test_what_sinks_with_a_depth_that_stands_is_brought_up_when_its_fixes_end(
    lives: bool, cleared: bool
):
    """Where nothing turns nothing else says that it has frozen."""
    world = at_rest(SURFACED)
    world.tell(world.report(depth=0.2))
    if cleared:
        world.tell(ClearMission())
    world.trembles *= lives
    told_fixes(world, 10)
    world.wait(20.0)
    assert world.state == ((IDLE_EMPTY if cleared else SURFACED) if lives else SURFACING)
    if not lives:
        assert world.engine.reason == "no fix for 8 s since it was let go, and the depth stands"


def test_what_sinks_with_a_depth_above_the_water_is_brought_up_when_its_fixes_end() -> None:
    """1 N too heavy, its sensor drifting into the air: on the ground before it says 2 m."""
    world = at_rest(SURFACED)
    world.tell(world.report(depth=0.2))
    world.depth = -1.7
    told_fixes(world, 10)
    for _ in range(10):
        world.depth += 0.05
        world.wait(2.0)
    assert world.state == SURFACING
    assert "let go, and the depth is above the water" in world.engine.reason


def test_what_is_held_up_with_a_depth_that_stands_comes_up_again_when_its_fixes_end():
    world = held_up()
    world.trembles = 0.0
    told_fixes(world, 100)
    assert world.state == SURFACED
    world.wait(10.0)
    assert world.state == SURFACING
    assert "since it was held up, and the depth stands" in world.engine.reason


def test_places_that_are_fixes_by_a_depth_that_stands_say_nothing_against_it():
    """A core board's own: on deck it says the same depth, and the same place."""
    world = at_rest(SURFACED)
    for second in range(80):
        world.wait(1.0, reports=False)
        world.trembles *= second < 10
        world.tell(world.report(position=(0.5, 2.0 + 1e-8 * min(second, 20))))
    assert world.state == SURFACED


def test_the_end_of_the_fixes_of_a_depth_that_stands_is_looked_for_when_it_is_due():
    """Not with the next report, nor again and again while node AUTO is closed."""
    for closed in (False, True):
        world = at_rest(SURFACED)
        world.trembles = 0.0
        told_fixes(world, 12)
        if closed:
            world.tell(AutoNode(False))
        world.tell(world.report())
        due = world.t + 8.0
        assert world.engine.next_timer() == due
        world.wait(7.0)
        world.until(due, reports=False)
        timer = world.engine.next_timer()
        assert timer is None or timer > world.t
        assert world.state == (SURFACED if closed else SURFACING)


def test_what_was_let_go_a_minute_before_its_fixes_end_floats():
    world = at_rest(SURFACED)
    world.depth = None
    told_fixes(world, 60)
    world.wait(100.0, reports=False)
    assert world.state == SURFACED


@pytest.mark.parametrize("ways", [("held", X), ("held", None), ("let go", X)])
def test_what_is_let_go_by_a_stop_or_a_clear_is_watched_by_its_fixes(ways):
    how, order = ways
    world = held_up() if how == "held" else at_rest(SURFACED)
    if order:
        world.tell(order)
        world.wait(1.0)
    world.tell(world.report(depth=0.2))
    world.tell(ClearMission())
    assert world.state == IDLE_EMPTY
    world.depth = None
    told_fixes(world, 3)
    world.wait(20.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("end", ["X", "AUTO"])
def test_what_a_leg_has_let_go_at_the_surface_is_watched_when_the_mission_is_ended(end: str):
    up = leg("up", kind=Surface(until_fix=True), settings=(), timeout=600.0)
    world = World(mission(up))
    assert world.start()
    world.wait(8.0)
    assert world.commands()[-1] is Order.STOP
    if end == "X":
        world.tell(X)
        world.tell(ClearMission())
    else:
        world.tell(AutoNode(False))
        world.tell(AutoNode(True))
    world.depth = None
    told_fixes(world, 3)
    world.wait(20.0)
    assert world.state == SURFACING


def waits_at_the_surface(seconds: float = 600.0) -> World:
    """A leg of so long, its ascent over."""
    up = leg("up", kind=Surface(), settings=(), timeout=None, duration=seconds)
    world = World(mission(up, leg("b", timeout=600.0)))
    assert world.start()
    told_fixes(world, 9)
    assert (world.state, world.commands()[-1]) == ("autonomous/up", Order.STOP)
    return world


@pytest.mark.parametrize("rate", [0.02, 0.04, 0.09])
def test_a_leg_that_waits_at_the_surface_is_watched_for_sinking(rate: float):
    world = waits_at_the_surface()
    said = len(world.actions)
    sink(world, rate, 6.0)
    assert world.state == SURFACING
    assert world.depth is not None
    assert world.depth < 2.5
    assert "though everything is stopped" in world.engine.reason
    assert world.commands()[said:][0] is not Order.STOP


def test_a_leg_that_waits_is_brought_up_where_the_depth_stands_and_the_fixes_end():
    """Frozen at the surface, and it sinks: the leg's end would be the surface, under water."""
    world = waits_at_the_surface()
    world.trembles = 0.0
    told_fixes(world, 10)
    world.wait(19.0)
    assert world.state == "autonomous/up"
    world.wait(10.0)
    assert world.state == SURFACING
    assert "the depth stands" in world.engine.reason


def test_a_leg_that_waits_stays_where_fixes_end_and_the_depth_tells():
    world = waits_at_the_surface()
    world.trembles = 0.02
    world.wait(60.0)
    assert world.state == "autonomous/up"


@pytest.mark.parametrize("stands", [True, False])
def test_the_next_ascent_goes_by_no_depth_that_has_stood_since_the_last(stands: bool):
    up = leg("up", kind=Surface(), settings=(), timeout=None, duration=200.0)
    again = leg("again", kind=Surface(), settings=(), timeout=600.0)
    world = World(mission(up, again, leg("b", timeout=600.0)))
    assert world.start()
    world.trembles = 0.02
    told_fixes(world, 100)
    said = world.commands().count(Order.SURFACE)
    world.trembles = 0.0 if stands else 0.02
    world.wait(110.0)
    assert (world.commands().count(Order.SURFACE) > said) is stands


def test_what_was_let_go_before_a_new_start_is_no_reason_to_turn_a_thruster():
    """Lifted aboard meanwhile, with AUTO closed."""
    world = World(mission(leg("up", kind=Surface(), settings=(), timeout=600.0)))
    assert world.start()
    world.wait(8.0)
    assert world.state == IDLE_READY
    assert world.start()
    world.tell(AutoNode(False))
    world.depth = None
    told_fixes(world, 3)
    world.wait(20.0)
    world.tell(AutoNode(True))
    world.wait(20.0)
    assert world.state == IDLE_READY


@pytest.mark.parametrize("legs", ["up", "dive"])
def test_what_a_mission_has_let_go_at_the_surface_is_brought_up_when_its_fixes_end(legs: str):
    """Whether a leg of its own brought it up, or its end."""
    dive = leg("a", timeout=None, duration=4.0)
    world = World(mission(leg("up", kind=Surface(), settings=(), timeout=600.0)))
    assert world.start()
    world.depth = None
    told_fixes(world, 1200)
    assert world.state == IDLE_READY
    world.wait(100.0)
    assert world.state == IDLE_READY  # a minute is over: it floats

    up = leg("up", kind=Surface(), settings=(), timeout=600.0)
    world = World(mission(up if legs == "up" else dive))
    assert world.start()
    world.wait(8.0 if legs == "up" else 14.0)
    assert world.state == IDLE_READY
    world.depth = None
    told_fixes(world, 3)
    world.wait(20.0)
    assert world.state == SURFACING


def test_what_sank_with_auto_closed_turns_nothing_by_a_depth_that_is_no_more():
    """It may have been hoisted on deck since."""
    world = at_rest(IDLE_READY)
    world.tell(AutoNode(False))
    sink(world, 0.3, 4.0)
    world.depth = None
    world.wait(60.0)
    world.tell(AutoNode(True))
    world.wait(20.0)
    assert world.state == IDLE_READY
    assert world.commands() == []
    world.depth = 4.0
    world.wait(20.0)
    assert world.state == SURFACING


def test_a_restart_under_the_stick_brings_up_what_stays_deep():
    """Nobody may be there any more whose silence could be counted."""
    world = World(MISSION)
    world.depth = 9.0
    world.tell(Restarted(STICK))
    world.wait(15.0)
    assert world.state == IDLE_READY
    world.wait(15.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("back", [0.0, 30.0])
@pytest.mark.parametrize("again", [True, False])
def test_what_came_to_rest_unseen_is_brought_up_behind_a_restart_too(back: float, again: bool):
    """And by a depth that is back with the first report behind it."""
    world = World(MISSION)
    assert world.start()
    world.depth = None
    world.wait(4.0)
    world.tell(AutoNode(False))
    world.wait(back)
    if again and back:
        during = world.engine.under_way
        world = World(MISSION)
        world.depth = None
        world.tell(Restarted(during))
        world.wait(10.0)
        assert world.engine.under_way == UNSEEN
    world.depth = 8.0
    world.tell(AutoNode(True))
    world.wait(30.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("waits", [0.0, 60.0])
def test_what_was_surfaced_and_cleared_unseen_is_brought_up_behind_a_restart(waits: float):
    world = at_rest(SURFACED)
    world.nav.doubt["depth"] = "absurd"
    world.tell(W)
    told_fixes(world, 200)
    assert world.state == SURFACED
    world.tell(ClearMission())
    told_fixes(world, 62, 200)  # let go a minute before: it floats
    world.wait(waits)
    assert (world.state, world.engine.under_way) == (IDLE_EMPTY, UNSEEN)
    again = World(MISSION)
    again.tell(Restarted(world.engine.under_way))
    again.depth = 8.0
    again.wait(30.0)
    assert again.state == SURFACING


def test_what_came_to_rest_unseen_is_kept_before_the_first_report_of_its_rest():
    """The stop is acknowledged at once, and the program may end before a report."""
    world = World(MISSION)
    assert world.start()
    world.wait(4.0)
    world.nav.doubt["depth"] = "absurd"
    world.wait(2.0)
    world.tell(AutoNode(False))
    assert (world.state, world.engine.under_way) == (IDLE_READY, UNSEEN)


@pytest.mark.parametrize("again", [True, False])
def test_what_came_to_rest_unseen_at_its_mission_s_end_is_brought_up(again: bool):
    """The mission ends by fixes, and no report follows; then one says that it is deep."""
    world = World()
    world.tell(world.report())
    world.tell(Loaded(compiled(mission(leg("a", timeout=4.0, settings=sets(surge=0.5))))))
    assert world.start()
    world.nav.doubt["depth"] = "absurd"
    second = 0
    while world.state != IDLE_READY and second < 900:
        second += 1
        world.wait(1.0, reports=second % 2 == 0)
        world.tell(world.fix(0.3 * (second % 29) + 0.0017 * second))
    assert world.state == IDLE_READY
    world.tell(AutoNode(False))
    if again:
        during, world = world.engine.under_way, World(MISSION)
        world.tell(Restarted(during))
    world.nav.doubt.clear()
    world.depth = 8.0
    world.wait(30.0, reports=False)
    world.tell(AutoNode(True))
    world.wait(30.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("state", [IDLE_EMPTY, IDLE_READY])
def test_a_program_that_began_at_rest_without_a_depth_leaves_nothing_under_way(state: str):
    """It may be on deck, with a board that says nothing."""
    world = World(MISSION if state == IDLE_READY else None)
    world.depth = None
    assert (world.state, world.engine.under_way) == (state, "")
    world.wait(6.0)
    assert world.engine.under_way == ""


def let_go_in_idle(how: str) -> World:
    """By the program's begin, a clear, a stick that was forgotten, a mission's end, or AUTO, the
    last without a report behind it."""
    if how == "ended":
        world = World(mission(leg("up", kind=Surface(), settings=(), timeout=600.0)))
        assert world.start()
        world.wait(12.0)
    elif how == "AUTO":
        world = World(MISSION)
        assert world.start()
        world.wait(3.0)
        world.tell(AutoNode(False))
    else:
        world = at_rest({"cleared": SURFACED, "forgotten": MANUAL_WAITING}.get(how, IDLE_READY))
        if how == "cleared":
            world.tell(ClearMission())
        elif how == "forgotten":
            world.wait(62.0)
    assert world.state in (IDLE_EMPTY, IDLE_READY)
    return world


HOW = ("begun", "cleared", "forgotten", "ended", "AUTO")
UNSEEN_BEFORE = "rest that began without a depth to believe"  # in the store of an older program


def again_at(depth: float, kept: str) -> World:
    world = World(MISSION)
    world.depth = depth
    world.tell(Restarted(kept))
    world.wait(30.0)
    return world


@pytest.mark.parametrize("how", HOW)
def test_what_has_sunk_in_idle_while_auto_is_closed_is_brought_up_behind_a_restart(how: str):
    """A restart opens AUTO, and on the bottom it does not sink any more."""
    world = let_go_in_idle(how)
    world.tell(AutoNode(False))
    assert world.engine.under_way == ""
    sink(world, 0.3, 8.0)
    world.wait(20.0)
    assert world.engine.under_way == UNSEEN
    assert again_at(8.0, world.engine.under_way).state == SURFACING


@pytest.mark.parametrize("how", ["begun", "cleared", "forgotten", "ended"])
def test_what_was_up_in_idle_and_has_no_depth_any_more_is_brought_up_behind_a_restart(how: str):
    world = let_go_in_idle(how)
    world.wait(4.0)
    world.nav.doubt["depth"] = "absurd"
    world.wait(8.0)
    assert world.engine.under_way == UNSEEN
    assert again_at(8.0, world.engine.under_way).state == SURFACING
    world.nav.doubt.clear()
    world.wait(4.0)
    assert world.engine.under_way == "", "it is seen again"


def test_a_board_that_falls_silent_at_rest_or_a_depth_that_was_off_there_leaves_nothing_under_way():
    """On deck its board is switched off before the Pi, and its sensor may be off for days."""
    world = at_rest(IDLE_READY)
    world.wait(60.0, reports=False)
    assert world.engine.under_way == ""
    world = World(MISSION)
    world.depth = 3.0
    world.wait(60.0)
    world.nav.doubt["depth"] = "absurd"
    world.wait(8.0)
    assert world.engine.under_way == ""


def test_a_depth_that_is_contradicted_leaves_nothing_under_way():
    """It leapt on deck, say; a further program would believe it."""
    world = World(MISSION)
    world.depth = 0.2
    world.wait(60.0)
    world.nav.doubt["depth"] = f"{CONTRADICTED}: it leapt"
    world.wait(60.0)
    assert world.engine.under_way == ""


def test_what_seems_to_sink_while_auto_is_closed_and_fixes_come_leaves_nothing_under_way():
    """A depth that drifts on deck."""
    world = let_go_in_idle("begun")
    world.tell(AutoNode(False))
    told_fixes(world, 10)
    for second in range(40):
        world.depth = 0.2 + 0.1 * second
        told_fixes(world, 1, 10 + second)
    assert world.engine.core.rest.sinks
    assert world.engine.under_way == ""
    world.wait(10.0)
    assert world.engine.under_way == UNSEEN


def test_what_goes_down_by_a_depth_that_is_off_while_auto_is_closed_is_kept_for_a_restart():
    """No depth was ever believed, and what moves says that it sinks."""
    world = World(MISSION)
    world.nav.doubt["depth"], world.nav.moves = "clogged", True
    world.wait(4.0)
    world.tell(AutoNode(False))
    assert world.engine.under_way == ""
    sink(world, 0.3, 8.0)
    assert world.engine.under_way == UNSEEN
    assert again_at(8.0, world.engine.under_way).state == SURFACING


@pytest.mark.parametrize("kept", [UNSEEN, UNSEEN_BEFORE])
def test_a_rest_in_which_it_may_have_sunk_turns_no_thruster_at_the_surface(kept: str):
    """On deck, say, where its board was without power; as an older program kept it, too."""
    world = again_at(0.2, kept)
    assert (world.state, set(world.commands())) == (IDLE_READY, {Order.STOP})
    assert world.engine.under_way == ""
    assert again_at(8.0, kept).state == SURFACING


def test_what_was_at_rest_and_seen_there_stays_where_it_is_behind_a_restart():
    """Deep in the first report, it may be on deck, its sensor wrong: nobody saw it sink."""
    world = again_at(3.0, at_rest(IDLE_READY).engine.under_way)
    assert world.state == IDLE_READY
    assert not {UPWARD, Order.SURFACE} & set(world.commands())


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("closed", [30.0, 70.0])
def test_what_its_fixes_alone_see_sink_while_auto_is_closed_counts_for_a_minute(
    closed: float, held: bool
):
    """Opened later, it may have been carried under a roof, and hands may be near it; a depth that
    is believed brings it up at any time."""
    world = held_up() if held else at_rest(SURFACED)
    world.nav.doubt["depth"] = "absurd"
    told_fixes(world, 3)
    world.tell(AutoNode(False))
    told_fixes(world, 8, 3)
    world.wait(closed - 8.0)
    assert world.state == SURFACED
    world.tell(AutoNode(True))
    world.wait(20.0)
    assert world.state == (SURFACING if closed < 60.0 else SURFACED)
    world.nav.doubt.clear()
    world.depth = 8.0
    world.wait(20.0)
    assert world.state == SURFACING


def test_a_stop_in_the_seconds_of_a_lift_lets_it_go_at_the_surface():
    """As full thrust takes over the surface is proved; a clear behind the X forgets no minute."""
    world = at_rest(SURFACED)
    sink(world, 0.3, 6.0)
    assert world.state == SURFACING
    world.wait(28.0)  # it will be let go when its fixes prove the surface
    world.depth, world.nav.doubt["depth"] = 0.2, "absurd"
    second = 0
    while "would sink again" not in world.actions[-1][1].reason:
        second += 1
        told_fixes(world, 1, second)
        assert second < 900
    assert world.state == SURFACING
    world.tell(X)
    world.wait(1.0)
    world.tell(ClearMission())
    assert world.state == IDLE_EMPTY
    told_fixes(world, 3, 1000)
    world.wait(20.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("way", [Order.SURFACE, UPWARD])
def test_it_is_held_up_by_full_thrust_and_not_by_a_w_that_may_not_last(way):
    world = held_up()
    world.depth = 2.0
    if way is Order.SURFACE:
        world.tell(W)
    else:
        world.wait(4.0)
    assert world.commands()[-1] == way
    world.depth = 0.2
    world.wait(20.0)
    assert "held up" in world.engine.reason
    assert world.commands()[-1] == UPWARD


def test_a_store_that_does_not_know_turns_nothing_while_auto_is_closed():
    world = World(MISSION)
    world.tell(AutoNode(False))
    world.tell(Restarted(UNKNOWN))
    world.depth = 3.0
    world.wait(15.0)
    assert world.state == STOPPED
    world.tell(AutoNode(True))
    world.wait(4.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("stopped", [True, False])
def test_a_stop_has_it_let_go_again_at_the_next_surface(stopped: bool):
    """Of an ascent behind an X it is not known that it sinks when it is let go."""
    world = held_up()
    if stopped:
        world.tell(X)
        world.wait(4.0)
    world.tell(W)
    world.wait(20.0)
    assert world.state == SURFACED
    assert ("held up" in world.engine.reason) is not stopped


@pytest.mark.parametrize("later", [0.5, 2.5])
def test_a_stop_against_an_ascent_out_of_stopped_has_its_20_seconds(later: float):
    """Whether a report came in between or not."""
    world = at_rest(STOPPED, 8.0)
    while world.state == STOPPED:
        world.wait(1.0)
    world.wait(later)
    world.tell(X)
    begun = world.t
    while world.state == STOPPED:
        world.wait(1.0)
    assert world.t - begun >= 20.0


@pytest.mark.parametrize("state", REST)
def test_what_sank_while_no_depth_was_believed_is_brought_up_when_one_is(state: str):
    world = at_rest(state)
    world.depth = None
    world.wait(40.0)
    assert world.state == state
    world.depth = 12.0  # on the floor, say: it does not sink any more
    world.wait(6.0)
    assert world.state == SURFACING


def closed_under_way() -> World:
    world = World(MISSION)
    assert world.start()
    world.wait(4.0)
    world.nav.doubt["depth"] = "absurd"
    world.tell(AutoNode(False))
    return world


def stopped_and_cleared() -> World:
    world = World(MISSION)
    assert world.start()
    world.wait(4.0)
    world.nav.doubt["depth"] = "absurd"
    world.tell(X)
    world.tell(ClearMission())
    world.wait(6.0)
    assert world.tell(ClearMission()).verdicts[0].accepted
    return world


@pytest.mark.parametrize("come_to_rest", [closed_under_way, stopped_and_cleared])
@pytest.mark.parametrize("unseen_for", [4.0, 100.0])
def test_what_came_to_rest_unseen_and_lies_on_the_bottom_is_brought_up(come_to_rest, unseen_for):
    world = come_to_rest()
    world.wait(unseen_for)
    world.tell(AutoNode(True))
    world.depth = 29.8
    world.wait(2.0)
    world.nav.doubt.clear()
    seen = world.t
    world.wait(19.0)
    assert world.state.startswith("idle")
    world.wait(6.0)
    assert world.state == SURFACING
    assert "does not rise" in world.engine.reason
    assert next(t for t, a in world.actions if a.command == UPWARD and t > seen) - seen >= 20.0


def test_what_came_to_rest_unseen_and_rises_is_left_alone_and_no_longer_unseen_then():
    world = closed_under_way()
    world.tell(AutoNode(True))
    world.depth = 12.0
    world.wait(2.0)
    world.nav.doubt.clear()
    while world.depth > 1.95:
        world.depth -= 0.06
        world.wait(2.0)
    world.depth = 2.3  # on the floor of a pool
    world.wait(60.0)
    assert world.state == IDLE_READY


@pytest.mark.parametrize(("depth", "up"), [(23.9, True), (1.6, True), (0.9, False)])
def test_what_was_surfaced_before_a_restart_and_lies_deep_has_sunk_meanwhile(depth, up):
    world = World(navigation=False)
    world.depth = depth
    world.tell(Restarted(SURFACED))
    world.wait(12.0)
    assert (world.state == SURFACING) is up
    assert world.commands()[-1] == (UPWARD if up else Order.STOP)


@pytest.mark.parametrize("during", ["", UNKNOWN, SURFACED])
@pytest.mark.parametrize("depth", [6553.5, 655.35, VEHICLE.limits.depth + 0.1])
def test_on_deck_a_depth_beyond_the_vehicles_own_turns_no_thruster_before_navigation(
    during: str, depth: float
):
    """A sensor at full scale. Navigation calls it absurd, and it takes some seconds to load."""
    world = World(navigation=False)
    if during:
        world.tell(Restarted(during))
    said = len(world.actions)
    world.depth = depth
    world.wait(12.0)
    assert world.state == (STOPPED if during == UNKNOWN else during or IDLE_EMPTY)
    assert set(world.commands()[said:]) <= {Order.STOP}


def test_a_depth_at_full_scale_as_the_program_begins_makes_no_ascent_longer():
    """It was taken for the last one believed, and the way up from there for hours."""
    world = World(navigation=False)
    world.tell(Restarted(SURFACED))
    world.depth = 6553.5
    world.wait(4.0)
    assert world.engine.core.vehicle_state.believed_depth is None
    world.tell(W)
    fixes(world, int(VEHICLE.limits.depth / VEHICLE.ascent_buoyancy) + 10)
    assert world.state == SURFACED


def test_on_deck_a_depth_that_begins_to_be_known_turns_no_thruster():
    """It was not under way: a program may be started on the floor of a pool, too."""
    world = World(MISSION)
    world.nav.doubt["depth"] = "missing"
    world.wait(10.0)
    world.depth = 3.2
    world.nav.doubt.clear()
    world.wait(120.0)
    assert world.commands() == []


def test_a_copy_watches_its_own_rest():
    rest = Rest(0.6)
    rest.take(0.0, 0.2)
    assert rest.sinks == ""
    world = at_rest(IDLE_READY)
    kept = world.engine.snapshot()
    sink(world, 0.2, 9.0)
    assert world.state == SURFACING
    world.engine.restore(kept)
    assert world.state == IDLE_READY


# --- the surface, for a clear and for a start ---------------------------------------------------


@pytest.mark.parametrize("state", [STOPPED, SURFACED])
@pytest.mark.parametrize(("depth", "may"), [(0.3, True), (0.6, False), (5.0, False)])
def test_an_emergency_is_cleared_only_at_the_surface(state: str, depth: float, may: bool):
    world = at_rest(state)
    world.depth = depth
    world.tell(world.report())
    assert world.tell(ClearMission()).verdicts[0].accepted is may
    assert (world.state == state) is not may


@pytest.mark.parametrize(
    ("pause", "depth", "may"),
    [(4.9, 1.5, False), (5.0, 1.5, True), (30.0, 1.5, True), (30.1, 1.5, False), (10.0, 2.1, False),
     (5.0, None, True), (10.0, None, True), (4.0, None, False)],
)  # fmt: skip
def test_a_clear_that_is_repeated_is_meant(pause: float, depth: float | None, may: bool):
    """So that a dead sensor indoors locks nobody out."""
    world = at_rest(STOPPED)
    world.depth = depth
    world.tell(world.report())
    assert not world.tell(ClearMission()).verdicts[0].accepted
    world.wait(pause)
    world.tell(world.report())
    assert world.tell(ClearMission()).verdicts[0].accepted is may


def test_a_clear_that_was_refused_before_an_x_is_not_repeated_behind_it():
    world = at_rest(STOPPED, 1.5)
    assert not world.tell(ClearMission()).verdicts[0].accepted
    world.wait(4.0)
    world.tell(X)
    world.wait(2.0)
    assert not world.tell(ClearMission()).verdicts[0].accepted
    world.wait(5.0)
    assert world.tell(ClearMission()).verdicts[0].accepted


@pytest.mark.parametrize("order", [X, W])
def test_a_clear_that_was_refused_elsewhere_is_not_repeated_at_rest(order: Emergency):
    world = World(MISSION)
    assert world.start()
    world.tell(W if order is W else M)
    assert not world.tell(ClearMission()).verdicts[0].accepted
    if order is X:
        world.tell(X)
    world.wait(9.0)
    assert world.state == (STOPPED if order is X else SURFACED)
    world.depth = 0.9
    world.tell(world.report())
    assert not world.tell(ClearMission()).verdicts[0].accepted


def test_a_program_that_repeats_a_clear_all_the_time_does_not_mean_it():
    world = at_rest(STOPPED, 1.5)
    for _ in range(30):
        assert not world.tell(ClearMission()).verdicts[0].accepted
        world.wait(1.0)


def test_while_it_surfaces_no_clear_is_obeyed_however_often():
    world = at_rest(IDLE_READY)
    world.depth = 5.0
    world.tell(world.report(), W)
    for _ in range(4):
        assert not world.tell(ClearMission()).verdicts[0].accepted
        world.wait(6.0)
    assert world.state == SURFACING


@pytest.mark.parametrize(
    ("depth", "free", "may"),
    [(0.4, False, True), (0.5, False, False), (5.0, False, False), (1.9, True, True),
     (2.0, True, False)],
)  # fmt: skip
def test_a_mission_starts_at_the_surface(depth: float, free: bool, may: bool):
    world = World(
        mission(leg("a", timeout=600.0), start_without_fix=free, home=None if free else HOME)
    )
    world.depth = depth
    assert world.start() is may
    assert may or "at the surface" in world.verdicts[-1].why


def test_a_mission_goes_on_at_any_depth():
    world = World(MISSION)
    assert world.start()
    world.depth = 8.0
    world.wait(4.0)
    world.tell(M)
    world.wait(4.0)
    assert world.tell(StartMission()).verdicts[0].accepted


# --- upside down -----------------------------------------------------------------------------------


def attitude(*reports: tuple[float | None, float | None]) -> Attitude:
    """By reports 2 s apart."""
    seen = Attitude()
    for i, (roll, pitch) in enumerate(reports):
        angles = [None if a is None else math.radians(a) for a in (roll, pitch)]
        seen = seen.after(Telemetry(2.0 * i, roll=angles[0], pitch=angles[1]))
    return seen


@pytest.mark.parametrize(
    ("reports", "over"),
    [
        ([(170.0, 1.0), (171.0, 2.0), (-178.0, 1.0)], True),
        ([(1.0, 170.0), (2.0, 171.0), (1.0, -178.0)], True),  # as the document says pitch
        ([(170.0, 1.0), (171.0, 2.0)], False),
        ([(119.0, 1.0), (118.0, 2.0), (117.0, 1.0)], False),
        ([(120.5, 1.0), (120.6, 2.0), (120.7, 1.0)], True),
        ([(180.4, 1.0), (180.3, 2.0), (180.2, 1.0)], True),  # rounded by the wire
        ([(181.0, 1.0), (180.9, 2.0), (180.8, 1.0)], False),  # no angle
        ([(170.0, 1.0)] * 9, False),  # it repeats itself
        ([(180.0, 180.0)] * 9, False),  # full scale
        ([(180.0, 0.0), (-180.0, 0.0), (180.0, 0.0)], False),  # one angle
        ([(170.0, 1.0), (900.0, 2.0), (172.0, 1.0), (171.0, 1.0)], False),
        ([(170.0, 1.0), (None, 2.0), (172.0, 1.0), (171.0, 1.0)], False),
        ([(170.0, 1.0), (171.0, 2.0), (172.0, 1.0), (10.0, 1.0)], False),
    ],
)
def test_upside_down_is_what_three_reports_that_change_agree_on(reports, over: bool):
    assert attitude(*reports).overturned is over


@pytest.mark.parametrize(
    ("reports", "beyond"),
    [
        ([(95.0, 1.0), (96.0, 2.0), (-170.0, 1.0)], True),
        ([(1.0, 95.0), (2.0, 110.0), (1.0, 100.0)], True),
        ([(95.0, 1.0), (96.0, 2.0)], False),
        ([(89.0, 1.0), (88.0, 2.0), (89.5, 1.0)], False),
        ([(100.0, 1.0), (80.0, 2.0), (101.0, 1.0), (102.0, 1.0)], False),
        ([(100.0, 1.0), (None, None), (101.0, 1.0), (102.0, 1.0)], False),
        ([(100.0, 1.0), (900.0, 2.0), (101.0, 1.0), (102.0, 1.0)], False),
        ([(100.0, 1.0)] * 9, False),  # it repeats itself
        ([(180.0, 180.0)] * 9, False),  # full scale
    ],
)
def test_on_its_side_is_what_three_reports_that_change_agree_on(reports, beyond: bool):
    assert attitude(*reports).on_its_side is beyond


@pytest.mark.parametrize(
    ("reports", "doubtful"),
    [
        ([(170.0 + i % 2, 1.0) for i in range(3)] + [(170.0, 1.0)] * 31, True),  # for a minute
        ([(170.0 + i % 2, 1.0) for i in range(3)] + [(170.0, 1.0)] * 29, False),
        ([(170.0 + i % 2, 1.0) for i in range(3)] + [(170.0, 1.0 + i) for i in range(40)], False),
        ([(180.0, 180.0)] * 9, True),  # full scale
        ([(900.0, 0.0)], True),
        ([(170.0, 1.0)], True),  # not yet
        ([(170.0, 1.0), (171.0, 2.0), (-178.0, 1.0)], False),  # it is
        ([(119.0, 1.0)], False),
        ([(900.0, 0.0), (1.0, 2.0)], True),  # what says no angle tells nothing for a minute
        ([(900.0, 0.0), (None, None), (1.0, 2.0)], True),
        ([(900.0, 0.0), *[(1.0 + i, 2.0) for i in range(30)]], False),
        ([(900.0, 0.0), (170.0, 1.0), (171.0, 2.0), (-178.0, 1.0)], False),  # it is
        ([(None, None)] * 3, False),  # a vehicle that reports none
        ([(1.0, 2.0), (None, None)], True),  # it did
        ([(170.0, 1.0), (None, None)], True),
        ([(1.0, 2.0), (None, None), (None, None)], True),
        ([(1.0, 2.0), (None, None), (1.0, 2.0)], False),
    ],
)
def test_it_may_be_upside_down_where_a_report_says_so_that_is_not_believed(reports, doubtful: bool):
    assert attitude(*reports).doubtful(2.0 * len(reports)) is doubtful


def test_upside_down_rolls_over_a_mission_and_begins_by_letting_go():
    world = World(mission(leg("a", timeout=600.0, settings=sets(surge=0.5, depth=5.0))))
    assert world.start()
    world.depth = 5.0
    world.wait(2.0)
    world.nav.doubt["attitude"] = "absurd"  # beyond the document's range
    for degrees in (160.0, 165.0, 162.0, 161.0, 163.0):
        world.roll = math.radians(degrees)
        world.wait(2.0)
    assert world.state == SURFACING
    assert world.commands()[-1] is Order.STOP
    assert "roll or pitch" in world.engine.reason


@pytest.mark.parametrize(
    ("rolls", "state"),
    [
        ((95.0, 100.0, 110.0, 118.0), SURFACING),
        ((95.0, 100.0, 110.0), "autonomous/a"),
    ],
)
def test_on_its_side_rolls_over_a_mission(rolls: tuple[float, ...], state: str):
    world = World(mission(leg("a", timeout=600.0, settings=sets(surge=0.5, depth=5.0))))
    assert world.start()
    world.depth = 5.0
    world.wait(2.0)
    world.nav.doubt["attitude"] = "absurd"  # beyond the document's range
    for degrees in rolls:
        world.roll = math.radians(degrees)
        world.wait(2.0)
    assert world.state == state


def test_a_restart_into_surfaced_watches_as_before():
    world = World(navigation=False)
    world.tell(Restarted(SURFACED))
    world.wait(4.0)
    sink(world, 0.3, 9.0)
    assert world.state == SURFACING


@pytest.mark.parametrize("during", ["autonomous/a", SURFACING])
def test_after_a_restart_what_proves_the_surface_counts_from_six_seconds_on(during: str):
    """By then five reports tell whether a depth that nobody saw before is frozen."""
    world = World(navigation=False)
    world.depth = 0.2
    world.tell(Restarted(during))
    world.wait(2.1)
    world.depth = 0.25
    world.wait(9.8)
    assert world.state == SURFACING
    world.wait(2.2)
    assert world.state == SURFACED


def test_after_a_restart_a_depth_that_has_not_changed_proves_no_surface():
    """Frozen is known with a thruster on alone, and letting go is one of the ways."""
    world = World(navigation=False)
    world.trembles = 0.0
    world.depth = 0.2
    world.tell(Restarted(SURFACING))
    world.wait(300.0)
    assert world.state == SURFACING
    world.depth, world.trembles = 0.21, 0.001
    world.wait(10.1)
    assert world.state == SURFACED
