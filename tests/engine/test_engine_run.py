"""Laws of a mission under way, at their bounds: rounds, waiting, blindness, steering, reckoning."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from engine_world import World, compiled, flying, guard, leg, legs_of, mission, sets, when

from mission.engine.clearance import Clearance
from mission.engine.run import MISSED, NEW_HEADING, Run
from mission.engine.vehicle_state import VehicleState
from mission.legs import Goto, Surface, Yoyo
from mission.model import By, Group, Handler, Local, Outcome, Result
from mission.model.copies import slots_of
from protocol.messages import Order, Setpoint

LONG = 20000.0


# --- steering -------------------------------------------------------------------------------


def test_a_steered_heading_is_sent_again_when_it_changed_by_two_degrees_and_a_half():
    assert pytest.approx(math.radians(2.5)) == NEW_HEADING
    for turned, again in ((2.49, False), (2.51, True), (-2.51, True), (-2.49, False)):
        east = leg("go", kind=Goto(Local(0.0, 1e6), 5.0), settings=sets(surge=0.5), timeout=LONG)
        world = flying(east)
        before = len(world.actions)
        estimate = world.nav.estimate
        off = math.radians(turned)
        world.nav.estimate = lambda now, e=estimate, off=off: e(now)._replace(
            heading=(e(now).heading - off) % math.tau
        )
        world.wait(2.0)
        assert len(world.actions) == before + again
        for _, action in world.actions[before:]:
            assert action.steers
            assert action.reason == "go steers"
            assert action.command.heading == pytest.approx(math.pi / 2 + off)


def test_another_depth_of_a_pilot_is_sent_whatever_the_heading():
    yoyo = leg("y", kind=Yoyo(3.0, 9.0, 2), settings=sets(surge=0.5), timeout=LONG)
    world = flying(yoyo, depth=1.0)
    world.depth = 8.9
    world.wait(4.0)
    assert [c.depth for c in world.commands()] == [9.0, 3.0]


def test_without_a_compass_a_goto_does_not_set_off():
    go = leg("go", kind=Goto(Local(1000.0, 0.0), 5.0), settings=sets(surge=0.5), timeout=LONG)
    world = World(mission(go))
    estimate = world.nav.estimate
    world.nav.estimate = lambda now: estimate(now)._replace(heading=None)
    assert world.start()
    assert world.commands()[-1] == Setpoint(surge=0.0, heading=None)
    world.nav.estimate = estimate
    world.wait(2.0)
    assert world.commands()[-1] == Setpoint(surge=0.5, heading=0.0)


def test_a_steered_set_forgives_that_an_older_one_was_refused():
    """What the vehicle says no to is what was sent last."""
    go = leg(
        "go",
        kind=Goto(Local(1000.0, 0.0), 5.0),
        settings=sets(surge=0.5),
        timeout=LONG,
        otherwise="b",
    )
    world = flying(go, leg("b", settings=sets(heading=1.0), timeout=LONG))
    first = world.commands()[-1]
    world.nav.east = 600.0
    world.wait(2.0)
    assert world.commands()[-1] != first
    world.tell(Outcome(Result.REFUSED, b"@Z$", first))
    world.wait(4.0)
    assert world.state == "autonomous/go"


# --- waiting --------------------------------------------------------------------------------


def test_without_a_guard_that_waits_nothing_is_due_when_readings_grow_old():
    world = flying(leg("a", when("altitude", "<", 3.0, held=60.0), timeout=1000.0), leg("b"))
    world.engine.core.watch.heard = math.inf  # no limit of silence may hide it
    world.tell()
    assert world.engine.next_timer() == 1100.0


@pytest.mark.parametrize("seconds", [0.5, 0.5000000000000001, 0.5000000009])
def test_a_bound_between_two_microseconds_is_waited_for_once(seconds: float):
    world = World(mission(leg("a", when("elapsed", ">=", seconds), timeout=LONG), leg("b")))
    assert world.start()
    timers = 0
    while world.state == "autonomous/a":
        timer = world.engine.next_timer()
        assert timer is not None
        world.t, timers = timer, timers + 1
        world.tell()
    assert world.t == pytest.approx(100.5, abs=2e-6)
    assert timers <= 2


def test_a_handler_does_not_wait_in_the_leg_it_leads_to():
    """Low since 104; 3 s in a, 3 s in the handler's own leg, then in b."""
    near = Handler(guard("altitude", "<", 3.0, held=5.0), "own")
    a = leg("a", timeout=None, duration=7.0)
    own = leg("own", settings=sets(heading=1.0), timeout=None, duration=3.0)
    world = flying(a, own, leg("b", timeout=LONG), handlers=(near,))
    world.until(103.0)
    world.altitude = 1.0
    world.until(114.9)
    assert legs_of(world) == ["a", "own", "b"]
    world.until(115.1)
    assert legs_of(world) == ["a", "own", "b", "own"]


def test_a_leg_without_a_time_of_its_own_waits_for_nothing_but_reports():
    world = flying(leg("a", timeout=LONG))
    due = world.engine.next_timer()
    assert due == world.t + 5.0, "the silence of the vehicle alone"


def test_a_guard_that_is_held_waits_for_its_time_and_for_the_readings_that_grow_old():
    body = leg("a", when("altitude", "<", 3.0, held=60.0), timeout=LONG)
    world = flying(body, leg("b", timeout=LONG))
    world.altitude = 1.0
    world.until(104.0)
    for t in (104.5, 105.0):
        world.t = t
        world.tell()
    # no limit of silence may hide it
    world.engine.core.watch.heard = math.inf
    world.tell()
    timer = world.engine.next_timer()
    assert timer == pytest.approx(104.0 + 6.0 + 1e-3)


def test_a_wait_that_was_broken_off_begins_anew():
    a = leg("a", when("altitude", "<", 3.0, held=5.0), timeout=LONG)
    world = flying(a, leg("b", timeout=LONG))
    world.altitude = 1.0
    world.until(107.0)
    world.altitude = 9.0
    world.until(108.5)
    world.altitude = 1.0
    world.until(114.9)
    assert world.state == "autonomous/a"
    world.until(115.1)
    assert world.state == "autonomous/b"


def test_a_handlers_wait_goes_on_from_leg_to_leg_and_begins_anew_with_its_group():
    near = Handler(guard("altitude", "<", 3.0, held=6.0), "away")
    away = leg("away", settings=sets(heading=1.0), timeout=LONG)
    body = Group(
        "g",
        1,
        (leg("x", timeout=None, duration=6.0), leg("y", timeout=None, duration=20.0)),
        handlers=(near,),
    )
    world = flying(body, away)
    world.altitude = 1.0
    world.until(109.9)  # x ends at 106, low since 104
    assert world.state == "autonomous/g/y"
    world.until(110.1)
    assert world.state == "autonomous/away"
    world = flying(
        leg("w", timeout=None, duration=5.0), replace(body, handlers=()), away, handlers=(near,)
    )
    world.altitude = 1.0
    world.until(110.1)
    assert world.state == "autonomous/away"


def test_an_exits_wait_begins_anew_when_its_leg_is_entered_again():
    a = leg("a", when("altitude", "<", 3.0, held=6.0), timeout=4.0, otherwise="c")
    b = leg("b", timeout=LONG)
    c = leg("c", timeout=None, duration=1.0)
    back = leg("back", when("depth", ">", 1.0, "a"), timeout=LONG)
    world = flying(a, b, c, back)
    world.altitude = 1.0
    world.wait(40.0)
    assert "b" not in legs_of(world)
    assert legs_of(world).count("a") > 4


# --- rounds ---------------------------------------------------------------------------------


def test_the_round_that_is_told_is_that_of_the_innermost_group_that_repeats():
    once = Group("once", 1, (leg("x", timeout=None, duration=4.0),))
    world = flying(Group("g", 3, (once,)), leg("end", timeout=LONG))
    told = [world.engine.round]
    for _ in range(3):
        world.wait(4.0)
        told.append(world.engine.round)
    assert told == [1, 2, 3, 1]
    assert world.state == "autonomous/end"


def test_a_group_that_is_all_of_another_begins_anew_in_each_of_its_rounds():
    inner = Group("in", 3, (leg("x", timeout=None, duration=4.0),))
    world = flying(Group("out", 2, (inner,)), leg("end", timeout=LONG))
    world.wait(40.0)
    assert legs_of(world) == ["out/in/x"] * 6 + ["end"]


def test_rounds_can_be_asked_for_by_a_guard():
    x = leg("x", when("round", ">=", 2.0, "end"), timeout=None, duration=4.0)
    world = flying(Group("g", 5, (x,)), leg("end", timeout=LONG))
    world.wait(10.0)
    assert legs_of(world) == ["g/x", "g/x", "end"]


# --- blindness ------------------------------------------------------------------------------


def test_the_else_of_a_blind_leg_counts_from_the_first_reading_that_was_missing():
    held = sets(surge=0.5, heading=0.0, altitude=3.0)
    world = flying(leg("a", settings=held, timeout=LONG, otherwise="b"), leg("b"))
    world.until(103.0)
    world.nav.doubt["altitude"] = "frozen"
    world.until(105.0)
    world.nav.doubt["heading"] = "frozen"
    world.until(107.0)
    assert world.state == "autonomous/a"
    world.until(109.9)
    assert world.state == "autonomous/a"
    world.until(110.1)  # 6 s after the report of 104
    assert world.state == "autonomous/b"


def test_a_reading_that_came_back_is_no_blindness():
    held = sets(surge=0.5, heading=0.0, altitude=3.0)
    world = flying(leg("a", settings=held, timeout=LONG, otherwise="b"), leg("b"))
    for _ in range(5):
        world.nav.doubt["altitude"] = "frozen"
        world.wait(5.0)
        world.nav.doubt.clear()
        world.wait(2.0)
    assert world.state == "autonomous/a"


def test_a_leg_that_is_entered_blind_has_its_own_six_seconds():
    held = sets(surge=0.5, heading=0.0, altitude=3.0)
    a = leg("a", settings=held, timeout=None, duration=6.0, otherwise="c")
    b = leg("b", settings=held, timeout=LONG, otherwise="c")
    world = flying(a, b, leg("c", settings=sets(turn=0.5, heave=0.5), timeout=LONG))
    world.until(103.0)
    world.nav.doubt["altitude"] = "frozen"
    world.until(111.9)
    assert world.state == "autonomous/b"
    world.until(112.1)
    assert world.state == "autonomous/c"


def test_an_ascent_needs_no_reading():
    up = leg("up", kind=Surface(), settings=(), timeout=LONG, otherwise="b")
    world = flying(leg("a", timeout=None, duration=4.0), up, leg("b"), depth=20.0)
    world.wait(4.0)
    for sensor in ("heading", "altitude", "attitude"):
        world.nav.doubt[sensor] = "frozen"
    world.wait(30.0)
    assert world.state == "autonomous/up"


# --- what a timeout says ---------------------------------------------------------------------


def test_a_timeout_more_than_a_metre_short_of_its_depth_says_so():
    assert MISSED == 1.0
    for depth, words in ((4.0, ""), (3.9, "no progress, depth 3.9 m of 5 m"), (9.0, "")):
        world = flying(leg("a", timeout=10.0), depth=depth)
        world.wait(10.0)
        (step,) = [s for s in world.steps if s.by is By.TIMEOUT]
        assert step.event == (f"timer: {words}" if words else "timer") or words in step.event
        assert ("no progress" in step.event) is bool(words)


def test_a_timeout_of_a_leg_that_asks_for_no_depth_says_nothing_of_it():
    world = flying(leg("a", settings=sets(surge=0.5, heading=0.0), timeout=10.0), depth=9.0)
    world.wait(10.0)
    (step,) = [s for s in world.steps if s.by is By.TIMEOUT]
    assert "progress" not in step.event


# --- the ascent as a leg -----------------------------------------------------------------------


def test_a_refused_upward_thrust_does_not_end_an_ascent():
    up = leg("up", kind=Surface(), settings=(), timeout=LONG, otherwise="b")
    world = flying(leg("a", timeout=None, duration=4.0), up, leg("b"), depth=20.0)
    world.wait(4.0)
    assert world.state == "autonomous/up"
    world.answer = Result.REFUSED
    world.wait(30.0)
    assert world.state == "autonomous/up"
    assert Setpoint(heave=-1.0) in world.commands()


def test_while_a_leg_climbs_the_next_deadline_is_its_judging_or_the_surface():
    up = leg("up", kind=Surface(), settings=(), timeout=LONG)
    world = flying(leg("a", timeout=None, duration=4.0), up, leg("b", timeout=LONG), depth=20.0)
    world.engine.core.watch.heard = math.inf
    world.until(104.0, reports=False)
    assert world.state == "autonomous/up"
    assert world.engine.next_timer() == 114.0
    world.t, world.depth = 107.0, 0.2
    world.tell(world.report())
    world.engine.core.watch.heard = math.inf
    world.tell()
    assert world.engine.next_timer() == 113.0
    world.t = 109.0
    world.tell(world.report())
    world.engine.core.watch.heard = math.inf
    world.until(113.0, reports=False)
    assert world.state == "autonomous/b"


def test_an_ascent_that_was_given_up_deep_goes_on_in_the_next_leg():
    """Begun anew with each leg it would say W again and again, which as built dives on."""
    up = leg("up", kind=Surface(), settings=(), timeout=7.0)
    world = flying(leg("a", timeout=None, duration=4.0), up, depth=20.0)
    world.until(111.5)
    assert world.state == "autonomous/surface"
    assert world.commands().count(Order.SURFACE) == 1
    world.until(114.5)
    assert world.commands()[-1] == Setpoint(heave=-1.0)


def test_an_ascent_behind_a_leg_that_dives_again_begins_anew():
    up = leg("up", kind=Surface(), settings=(), timeout=None, duration=7.0)
    again = leg("b", timeout=None, duration=4.0)
    world = flying(leg("a", timeout=None, duration=4.0), up, again, depth=20.0)
    world.until(116.5)
    assert world.state == "autonomous/surface"
    assert world.commands().count(Order.SURFACE) == 2


def test_at_the_surface_a_leg_waits_for_its_time_alone():
    up = leg("up", kind=Surface(), settings=(), timeout=None, duration=90.0)
    world = flying(leg("a", timeout=None, duration=4.0), up, leg("b", timeout=LONG), depth=0.2)
    world.until(111.0)  # up since 110: the ascent would be judged at 114
    assert world.state == "autonomous/up"
    world.engine.core.watch.heard = math.inf  # no limit of silence may hide it
    world.tell()
    assert world.engine.next_timer() == 194.0


def test_two_surface_legs_in_succession_climb_once_and_stop_once():
    one = leg("one", kind=Surface(), settings=(), timeout=LONG)
    two = leg("two", kind=Surface(), settings=(), timeout=None, duration=20.0)
    world = flying(leg("a", timeout=None, duration=4.0), one, two, leg("b", timeout=LONG))
    world.wait(4.0)
    world.depth = 0.2
    world.wait(12.0)
    assert world.state == "autonomous/two"
    assert world.commands().count(Order.SURFACE) == 1
    assert world.commands().count(Order.STOP) == 1
    world.wait(20.0)
    assert world.state == "autonomous/b"


# --- path over ground --------------------------------------------------------------------------


def test_the_path_over_ground_is_counted_from_the_entry_and_only_forward():
    world = World(mission(leg("a", timeout=LONG)))
    world.nav.speed, world.nav.current = 0.6, (0.0, 0.8)
    assert world.start()
    world.depth = 5.0
    run = world.engine.core.run
    world.until(107.0)
    assert run.travelled == pytest.approx(6.0)  # the report of 106
    world.heading, world.nav.current = math.pi / 2, (0.0, 0.4)
    world.until(109.0)
    assert run.travelled == pytest.approx(8.0)
    world.heading, world.nav.current = 0.0, (0.4, 0.0)
    world.until(111.0)
    assert run.travelled == pytest.approx(10.0)
    world.nav.speed = 0.0
    world.until(113.0)
    assert run.travelled == pytest.approx(10.8)
    assert world.engine.readings["travelled"].value == pytest.approx(10.8)


def test_without_a_heading_nothing_is_counted_and_nothing_is_made_up_for():
    vehicle_state = VehicleState()
    world = World(mission(leg("a", timeout=LONG)))
    world.nav.speed = 1.0
    run = Run(compiled(mission(leg("a"))), 10.0, (), Clearance(30.0, 1.0))
    world.nav.report = world.report()
    for t, heading, travelled in ((12.0, 0.0, 2.0), (14.0, None, 2.0), (16.0, 0.0, 4.0)):
        vehicle_state.estimate = world.nav.estimate(t)._replace(heading=heading)
        run.reckon(vehicle_state)
        run.reckon(vehicle_state)
        assert run.travelled == pytest.approx(travelled)
    vehicle_state.estimate = world.nav.estimate(15.0)._replace(heading=0.0)
    run.reckon(vehicle_state)
    assert run.travelled == pytest.approx(4.0)
    vehicle_state.estimate = None
    run.reckon(vehicle_state)
    assert run.travelled == pytest.approx(4.0)


# --- records and copies --------------------------------------------------------------------------


def test_what_ended_a_leg_by_itself_is_on_record_as_true_with_what_was_seen():
    """Times to the microsecond, so that a deadline computed the other way round is met."""
    world = flying(leg("a", timeout=None, duration=4.0), leg("b", timeout=6.123456789))
    world.trembles = 0.0
    world.wait(12.0)
    for by, elapsed in ((By.FOR, 4.0), (By.TIMEOUT, 6.123457)):
        (step,) = [s for s in world.steps if s.by is by]
        (seen,) = step.evaluations
        assert (seen.trigger, seen.result) == (step.trigger, True)
        assert dict(seen.values) == {"elapsed": elapsed, "depth": 5.0}


def test_an_uncertain_position_takes_its_own_way_and_no_handlers():
    near = Handler(guard("altitude", "<", 3.0), "near")
    legs = [leg(name, timeout=LONG) for name in ("a", "near", "away")]
    world = flying(*legs, handlers=(near,), on_uncertain="away")
    world.nav.north, world.nav.covariance = 1990.0, (1e6, 0.0, 1e6)
    world.wait(6.0)
    assert legs_of(world) == ["a", "away"]


def attributes(run: Run) -> list[str]:
    """A compiled run has slots, and no dictionary."""
    return [*slots_of(type(run)), *getattr(run, "__dict__", ())]


def test_a_run_and_its_clone_share_nothing_that_changes():
    yoyo = leg("y", kind=Yoyo(3.0, 9.0, 2), settings=sets(surge=0.5, heading=0.0), timeout=LONG)
    up = leg("up", kind=Surface(), settings=(), timeout=LONG)
    for body in (yoyo, up):
        run = flying(body, depth=9.0).engine.core.run
        other = run.clone()
        mutable = {
            name
            for name in attributes(run)
            if isinstance(getattr(run, name), dict | set | list) or name in ("_pilot", "ascent")
        }
        shared = {n for n in mutable if getattr(run, n) is getattr(other, n) is not None}
        assert shared == {"_plans"}, "what is compiled once, for all"
        assert attributes(other) == attributes(run)
