"""Laws of how a program ends in order, and how one begins that nobody can tell what it interrupted."""

from __future__ import annotations

import pytest
from engine_world import M, W, World, X, compiled, leg, mission, sets

from mission.engine.ascent import UPWARD
from mission.model import (
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    STOPPED,
    SURFACED,
    SURFACING,
    UNKNOWN,
    AutoNode,
    Ending,
    Loaded,
    Mission,
    Outcome,
    Restarted,
    Result,
)
from protocol.messages import ClearMission, Order, StartMission

MISSION = mission(leg("a", timeout=600.0), leg("b"))
AFLOAT = mission(leg("a", timeout=600.0, settings=sets(surge=0.5, heading=0.0)))
STOP, SURFACE = Order.STOP, Order.SURFACE


def flying_at(depth: float, of: Mission = MISSION) -> World:
    world = World(of)
    assert world.start()
    world.depth = depth
    world.wait(8.0)
    return world


def since(world: World, before: int) -> list[object]:
    return list(world.commands()[before:])


# --- an orderly end -----------------------------------------------------------------------------


def test_an_end_in_a_mission_surfaces_at_once_and_is_settled_with_everything_stopped():
    world = flying_at(5.0)
    before = len(world.actions)
    world.tell(Ending())
    assert (world.state, world.engine.settled) == (SURFACING, False)
    assert since(world, before) == [SURFACE]
    world.depth = 0.2
    world.wait(9.0)
    assert (world.state, world.engine.settled) == (SURFACED, False)
    world.wait(30.0)
    assert (world.state, world.engine.settled) == (SURFACED, True)
    assert since(world, before)[-1] is STOP


def test_nobody_leaves_what_sinks_when_an_ascent_has_let_it_go():
    world = flying_at(5.0)
    world.tell(Ending())
    world.wait(11.0)
    world.depth = 0.2
    world.wait(9.0)
    assert (world.state, world.engine.settled) == (SURFACED, False)
    for depth in (0.6, 1.2, 1.8):
        world.depth = depth
        world.wait(2.0)
    assert (world.state, world.engine.settled) == (SURFACING, False)
    world.depth = 0.2
    world.wait(9.0)
    assert (world.state, world.engine.settled) == (SURFACED, True)
    assert world.commands()[-1] == UPWARD, "it is held up by thrust, and left so"


@pytest.mark.parametrize("heavy", [True, False])
def test_nobody_leaves_what_fixes_alone_have_proved_before_they_say_that_it_floats(heavy: bool):
    world = flying_at(5.0)
    world.depth = None
    world.tell(Ending())
    second = 0
    while world.state == SURFACING and second < 400:
        world.wait(1.0)
        world.tell(world.fix(0.5 * second))  # a new place each second
        second += 1
    assert (world.state, world.engine.settled) == (SURFACED, False)
    for later in range(31):
        world.wait(1.0)
        if not heavy:
            world.tell(world.fix(0.5 * (second + later)))
    expected = (SURFACING, False) if heavy else (SURFACED, True)
    assert (world.state, world.engine.settled) == expected


@pytest.mark.parametrize("heavy", [False, True])
def test_an_end_at_a_proved_surface_stops_and_sees_whether_it_floats(heavy: bool):
    """Thrust may have held it up there; where it floats nothing turns."""
    world = flying_at(0.2, AFLOAT)
    before = len(world.actions)
    world.tell(Ending())
    assert (world.state, world.engine.settled) == (SURFACED, False)
    while world.engine.settled is False and world.state == SURFACED:
        world.depth += 0.1 * heavy
        world.wait(2.0)
    assert (world.state, world.engine.settled) == (
        (SURFACING, False) if heavy else (SURFACED, True)
    )
    assert since(world, before)[0] == STOP
    assert heavy or since(world, before) == [STOP]


@pytest.mark.parametrize("now", [False, True])
def test_a_shallow_depth_proves_no_surface_where_the_leg_leads_down(now: bool):
    """As flight 18270 of seed 1818: a port that clogs as it goes under says 0.4 m for as long as
    a dive needs to tell, and ended by that it was left 4 m deep."""
    world = flying_at(0.2)
    before = len(world.actions)
    world.tell(Ending(now=now))
    assert since(world, before) == [UPWARD if now else SURFACE]
    assert world.engine.settled is False


def test_a_fix_of_just_now_is_no_surface_against_a_depth_to_believe():
    world = flying_at(0.2)
    world.depth = 1.0
    world.tell(world.report())
    world.tell(world.fix(north=3.0), Ending())
    assert world.state == SURFACING


@pytest.mark.parametrize("auto", [True, False])
def test_the_last_words_out_of_surfaced_wait_for_no_node_that_is_closed(auto: bool):
    """Nothing turns by itself while AUTO is closed."""
    world = flying_at(0.2, AFLOAT)
    world.tell(Ending())
    world.tell(AutoNode(auto))
    world.depth = 3.0
    world.tell(world.report())
    before = len(world.actions)
    world.tell(Ending(now=True))
    assert since(world, before) == ([UPWARD] if auto else [])


@pytest.mark.parametrize("depth", [0.2, 2.0, None])
def test_an_end_in_idle_sends_nothing_where_no_depth_says_deep(depth: float | None):
    world = World()
    world.depth = depth
    world.wait(4.0)
    world.tell(Ending())
    world.wait(4.0)
    assert (world.state, world.commands(), world.engine.settled) == (IDLE_EMPTY, [], True)


def test_nobody_leaves_what_is_deep_in_idle_or_stopped():
    world = World()
    world.depth = 2.1
    world.wait(4.0)
    world.tell(Ending())
    assert not world.engine.settled
    world.tell(X)
    assert (world.state, world.engine.settled) == (STOPPED, False)
    world.depth = 2.0
    world.tell(world.report())
    assert world.engine.settled


def test_nobody_leaves_a_vehicle_that_has_not_acknowledged_its_stop():
    world = flying_at(0.2, AFLOAT)
    world.answer, world.stops = None, False
    world.tell(X)
    world.tell(Ending())
    before = len(world.actions)
    world.wait(200.0)
    assert (world.state, world.engine.settled) == (STOPPED, False)
    assert since(world, before) == [STOP] * 400, "every 500 ms"
    world.answer, world.stops = Result.ACCEPTED, True
    world.wait(0.5)
    assert world.engine.settled


@pytest.mark.parametrize(("depth", "goes"), [(None, True), (0.2, True), (1.5, False)])
def test_a_board_that_says_nothing_delays_the_end_by_half_a_minute_at_the_surface_alone(
    depth: float | None, goes: bool
):
    world = World()
    world.depth, world.answer = depth, None
    world.wait(8.0)
    world.tell(X)
    world.wait(60.0, reports=False)
    world.tell(Ending())
    world.wait(29.0, reports=False)
    assert not world.engine.settled
    world.wait(2.0, reports=False)
    assert world.engine.settled is goes


def test_a_stop_without_its_acknowledgement_is_no_reason_for_thrust_upward():
    world = World()
    world.wait(8.0)
    world.tell(M)
    world.answer = None
    world.tell(Ending())
    world.tell(Ending(now=True))
    assert (world.commands(), world.engine.settled) == ([STOP], False)


def test_the_stick_keeps_what_it_has_until_it_is_silent_for_two_seconds():
    world = flying_at(5.0)
    world.tell(M)
    before = len(world.actions)
    world.tell(Ending())
    assert (world.state, world.engine.settled) == (MANUAL_DRIVING, False)
    assert since(world, before) == []
    world.wait(2.5)
    assert world.state == SURFACING


def test_the_stick_alone_at_the_surface_is_stopped_at_once():
    world = World()
    world.wait(8.0)
    world.tell(M)
    world.tell(Ending())
    assert world.commands() == [STOP]
    assert world.engine.settled
    world.tell(M)
    assert "nobody would stop what the stick moves" in world.verdicts[-1].why


def test_the_stick_is_heard_until_the_vehicle_needs_nobody():
    world = flying_at(5.0)
    world.tell(Ending())
    world.wait(2.5)
    world.push()
    assert (world.verdicts[-1].accepted, world.state) == (True, MANUAL_DRIVING)
    on_deck = World()
    on_deck.wait(8.0)
    on_deck.tell(Ending(), M)
    assert (on_deck.verdicts[-1].accepted, on_deck.commands()) == (False, [])


@pytest.mark.parametrize(("depth", "may"), [(2.1, True), (1.9, False), (0.2, False), (None, False)])
def test_the_stick_takes_an_ascent_over_only_where_it_is_left_to_it(depth: float | None, may: bool):
    """Else everything would be stopped at once, and the M would leave behind the stop."""
    world = flying_at(5.0)
    world.tell(Ending())
    world.wait(2.5)
    world.depth = depth
    world.tell(world.report())
    before = len(world.actions)
    world.push()
    assert (world.verdicts[-1].accepted, since(world, before)) == (may, [])
    assert world.state == (MANUAL_DRIVING if may else SURFACING)


def test_the_stick_takes_over_nothing_that_the_end_would_leave_as_it_moves():
    closed = World()
    closed.depth = 5.0
    closed.tell(closed.report(), AutoNode(False))
    closed.tell(X)
    closed.wait(3.0)
    let_go = flying_at(5.0)
    let_go.depth = 0.2
    told = flying_at(5.0)
    for world in (closed, let_go, told):
        world.tell(Ending())
    let_go.wait(10.0)
    told.tell(Ending(now=True))
    told.wait(3.0)
    for world, state in ((closed, STOPPED), (let_go, SURFACED), (told, SURFACING)):
        assert world.state == state
        world.tell(M)
        assert (world.verdicts[-1].accepted, world.state) == (False, state)


def test_the_stick_alone_and_deep_leads_to_an_ascent_unless_auto_is_closed():
    for is_open, state in ((True, SURFACING), (False, "manual/waiting")):
        world = World()
        world.depth = 5.0
        world.wait(4.0)
        world.tell(M, AutoNode(is_open))
        world.tell(Ending())
        assert not world.engine.settled
        world.wait(2.5)
        assert (world.state, world.engine.settled) == (state, False)


@pytest.mark.parametrize("waits", [0.0, 4.0])
def test_nobody_leaves_what_the_stick_has_let_go_deep_while_auto_is_closed(waits: float):
    """And nothing turns for it: the last words are none, or X0."""
    world = World()
    world.depth = 8.0
    world.tell(world.report(), M, AutoNode(False))
    world.wait(waits)
    world.tell(Ending())
    world.wait(3.0)
    assert (world.state, world.engine.settled) == ("manual/waiting", False)
    world.tell(Ending(now=True))
    world.wait(3.0)
    assert set(world.commands()) == {STOP}
    world.depth = 1.9
    world.wait(2.0)
    assert (world.state, world.engine.settled) == ("manual/waiting", True)


@pytest.mark.parametrize("silent", [4.0, 8.0, 60.0])
@pytest.mark.parametrize("led", [True, False])
def test_nobody_leaves_what_was_deep_in_the_last_report_that_came(led: bool, silent: float):
    """Its cable is pulled as the program is told to end: with the stick it comes up once that is
    silent, stopped it is waited for."""
    world = World()
    world.tell(world.report(), M if led else X)
    for _ in range(20):
        world.depth = 10.0
        world.tell(*[M] * led)
        world.wait(1.0)
    for _ in range(int(silent)):
        world.tell(*[M] * led)
        world.wait(1.0, reports=False)
    world.tell(Ending())
    assert (world.state, world.engine.settled) == (MANUAL_DRIVING if led else STOPPED, False)
    world.wait(3.0, reports=False)
    assert world.state == (SURFACING if led else STOPPED)
    assert world.engine.settled is False
    if not led:
        world.depth = 0.2
        world.wait(2.0)
        assert world.engine.settled


@pytest.mark.parametrize(("last", "leaves"), [(1.8, False), (0.6, False), (0.4, True)])
def test_nobody_leaves_what_was_under_water_in_the_last_report_and_was_led_down(
    last: float, leaves: bool
):
    """As flight 16618 of seed 11732: its cable was pulled at 1.8 m, its board went on to 4 m, and
    an X was acknowledged before the first report that came again."""
    world = flying_at(last)
    world.wait(7.0, reports=False)
    world.tell(Ending())
    world.wait(5.0, reports=False)
    world.tell(X)
    world.wait(40.0, reports=False)
    assert (world.state, world.engine.settled) == (STOPPED, leaves)
    world.depth = 4.0
    world.wait(3.0)
    assert not world.engine.settled
    world.depth = 1.5
    world.wait(3.0)
    assert world.engine.settled


@pytest.mark.parametrize("depth", [0.6, 1.9])
def test_what_rested_in_idle_and_is_not_heard_delays_no_end(depth: float):
    """A zero that is off, in a tank, and the board switched off."""
    world = World()
    world.depth = depth
    world.wait(5.0)
    world.wait(10.0, reports=False)
    world.tell(Ending())
    assert world.engine.settled


@pytest.mark.parametrize("fixes", [True, False])
def test_what_was_deep_in_the_last_report_and_has_fixes_is_on_deck(fixes: bool):
    """Hauled in after an X, its board without power: the Pi's own receiver tells."""
    world = World()
    world.tell(world.report(), M)
    world.depth = 3.0
    world.wait(2.0)
    world.tell(X)
    world.wait(4.0)
    world.wait(5.0, reports=False)
    for second in range(20):
        if fixes:
            world.tell(world.fix(0.7 * second))
        world.wait(1.0, reports=False)
    world.tell(Ending())
    assert world.engine.settled is fixes


def test_a_depth_that_reports_say_and_nobody_believes_keeps_no_program_with_the_stick():
    """An unknown depth turns no thruster: it may be on deck."""
    world = World()
    world.tell(world.report(), M)
    world.depth = 10.0
    world.tell(M)
    world.wait(1.0)
    world.nav.doubt["depth"] = "absurd"
    world.tell(M)
    world.wait(1.0)
    world.tell(Ending())
    world.wait(4.0)
    assert world.state == "manual/waiting"
    assert set(world.commands()) == {STOP}
    assert world.engine.settled


@pytest.mark.parametrize("late", [False, True])
def test_a_stop_from_before_an_m_that_counts_is_neither_said_again_nor_taken_for_the_ends_own(
    late: bool,
):
    """About 2 m deep the end stops what the stick moves, leaves it to the stick, and so on. A board
    may acknowledge the first stop behind that M."""
    world = World()
    world.depth = 1.9
    world.wait(8.0)
    world.tell(M)
    world.answer = None
    world.tell(Ending())
    acknowledged = Outcome(Result.ACCEPTED, b"@ZAX0$", STOP)
    world.tell(*([] if late else [acknowledged]))
    world.depth = 2.1
    world.tell(world.report())
    assert world.tell(M).verdicts[0].accepted
    world.tell(*([acknowledged] if late else []))
    world.wait(1.9)
    assert (world.state, world.commands()) == (MANUAL_DRIVING, [STOP])
    world.depth = 1.9
    world.tell(world.report())
    assert world.commands() == [STOP, STOP]


def test_while_it_ends_the_operator_is_obeyed_and_no_mission_starts():
    world = flying_at(5.0)
    world.tell(Ending())
    world.tell(X)
    assert world.state == STOPPED
    world.depth = 0.2
    world.wait(8.0)
    world.tell(ClearMission(), Loaded(compiled(MISSION)))
    assert world.state == IDLE_READY
    world.tell(world.fix())
    world.tell(StartMission())
    assert "the program is ended" in world.verdicts[-1].why


@pytest.mark.parametrize("surfacing_first", [True, False])
def test_the_last_words_are_thrust_upward_and_nothing_follows_them(surfacing_first: bool):
    world = flying_at(5.0)
    if surfacing_first:
        world.tell(Ending())
        world.wait(3.0)
    before = len(world.actions)
    world.tell(Ending(now=True))
    world.wait(60.0)
    assert since(world, before) == [UPWARD]
    assert (world.state, world.engine.under_way) == (SURFACING, SURFACING)


@pytest.mark.parametrize("state", [IDLE_EMPTY, STOPPED, SURFACED])
def test_there_are_no_last_words_where_nothing_is_under_way(state: str):
    world = World()
    world.tell(Restarted("" if state == IDLE_EMPTY else state))
    world.wait(4.0)
    before = len(world.actions)
    world.tell(Ending(now=True))
    world.wait(4.0)
    assert (world.state, since(world, before)) == (state, [])


@pytest.mark.parametrize("state", [IDLE_EMPTY, STOPPED, MANUAL_DRIVING])
def test_behind_the_last_words_the_stick_is_refused_also_where_there_were_none(state: str):
    world = World()
    world.depth = 5.0
    world.wait(8.0)
    world.tell(*{IDLE_EMPTY: [], STOPPED: [X], MANUAL_DRIVING: [M]}[state])
    world.wait(1.0 if state == MANUAL_DRIVING else 4.0)
    assert world.state == state
    world.tell(Ending())
    world.tell(Ending(now=True))
    for order in (None, X, W):
        world.tell(*([] if order is None else [order]))
        world.wait(3.0)
        assert not world.tell(M).verdicts[0].accepted


def test_what_was_just_let_go_at_the_surface_is_left_so_where_time_is_out():
    world = flying_at(5.0)
    world.tell(W)
    world.depth = 0.2
    world.wait(8.0)
    world.tell(Ending())
    assert (world.state, world.engine.settled) == (SURFACED, False)
    before = len(world.actions)
    world.tell(Ending(now=True))
    assert (world.state, since(world, before)) == (SURFACED, [])


def test_a_mission_under_the_stick_at_a_proved_surface_is_stopped_where_time_is_out():
    world = flying_at(0.2, AFLOAT)
    world.wait(8.0)
    world.tell(M)
    before = len(world.actions)
    world.tell(Ending(now=True))
    assert (world.state, since(world, before)) == (SURFACED, [Order.STOP])


def test_what_has_sunk_again_from_surfaced_is_left_with_thrust_upward():
    world = World()
    world.tell(Restarted(SURFACED))
    world.depth = 2.5
    world.tell(world.report())
    before = len(world.actions)
    world.tell(Ending(now=True))
    assert since(world, before) == [UPWARD]


# --- nobody can tell what was under way -------------------------------------------------------------


def begun(depth: float | None) -> World:
    world = World(navigation=False)
    world.depth = depth
    world.tell(Restarted(UNKNOWN))
    return world


@pytest.mark.parametrize("depth", [None, 0.2, 2.0])
def test_what_nobody_knows_is_stopped_and_on_deck_no_thruster_turns(depth: float | None):
    world = begun(depth)
    world.trembles = 0.0
    world.wait(60.0)
    assert (world.state, set(world.commands())) == (STOPPED, {STOP})
    assert world.engine.under_way == UNKNOWN, "nor does the next program"


def test_what_nobody_knows_comes_up_by_the_second_report_that_says_deep():
    world = begun(2.1)
    world.tell(world.report())
    assert world.state == STOPPED
    world.t += 2.0
    world.tell(world.report())
    assert (world.state, world.commands()) == (SURFACING, [STOP, SURFACE])
    assert world.engine.under_way == SURFACING


@pytest.mark.parametrize("period", [0.005, 0.02, 0.1])
def test_a_wild_depth_that_a_fast_board_says_many_times_turns_no_thruster(period: float):
    """For half a second, on deck; what is deep for longer comes up."""
    world = begun(0.2)
    begin = world.t
    while world.t < begin + 6.0:
        world.t += period
        lasts = world.t - begin
        world.depth = 9.0 if 1.0 < lasts < 1.5 or lasts > 4.0 else 0.2
        world.tell(world.report())
        assert (world.state == STOPPED) is (lasts < 5.0) or 5.0 <= lasts < 5.2
    assert world.state == SURFACING


def test_one_report_between_two_shallow_ones_is_no_dive():
    world = begun(0.2)
    for depth in (9.0, 0.2, 9.0, 0.2):
        world.depth = depth
        world.t += 2.0
        world.tell(world.report())
    assert world.state == STOPPED


def test_an_x_of_an_operator_is_no_longer_something_that_nobody_knows():
    world = begun(0.2)
    world.tell(X)
    assert world.engine.under_way == STOPPED
    world.wait(9.0)
    world.tell(ClearMission())
    assert (world.state, world.engine.under_way) == (IDLE_EMPTY, "")


def test_what_nobody_knows_can_be_cleared_and_is_then_known():
    world = begun(0.2)
    world.wait(9.0)
    world.tell(ClearMission())
    assert (world.state, world.engine.under_way) == (IDLE_EMPTY, "")
