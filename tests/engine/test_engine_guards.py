"""Laws of a mission under way: which edge is taken, when, and what is sent."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from random import Random

import pytest
from engine_world import World, flying, guard, leg, legs_of, mission, sets, when
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mission.legs import Goto, Hold, Yoyo
from mission.model import (
    SURFACING,
    And,
    By,
    Comparison,
    Exit,
    Group,
    Guard,
    Handler,
    Leg,
    Local,
    NavigationMode,
    Not,
    Or,
    Outcome,
    Result,
)
from mission.model.shipped import load_vehicle
from protocol.messages import Order, Setpoint

LONG = 20000.0


# --- order --------------------------------------------------------------------------------


def test_of_several_exits_that_hold_the_first_written_is_taken():
    a = leg("a", when("depth", ">", 99), when("depth", ">", 1, "c"), when("depth", ">", 2, "b"))
    assert legs_of(flying(a, leg("b"), leg("c")))[:2] == ["a", "c"]


def test_the_innermost_handler_wins_and_any_handler_goes_before_an_exit():
    inner = Handler(guard("depth", ">", 4), "in")
    outer = Handler(guard("depth", ">", 3), "out")
    group = Group("g", 1, (leg("a", when("depth", ">", 2, "exit")),), handlers=(inner,))
    others = (leg("exit"), leg("in"), leg("out"))
    assert legs_of(flying(group, *others, handlers=(outer,)))[:2] == ["g/a", "in"]
    assert legs_of(flying(replace(group, handlers=()), *others, handlers=(outer,)))[1] == "out"


def test_a_handler_does_not_act_in_the_leg_it_leads_to():
    near = Handler(guard("depth", ">", 3), "away")
    world = flying(leg("a"), leg("away", timeout=LONG), handlers=(near,))
    world.wait(100.0)
    assert legs_of(world) == ["a", "away"]


def near_the_bottom(*, held: float = 0.0) -> World:
    """a, and on altitude < 3: climb for 10 s, then back to a."""
    climb = leg("climb", timeout=10.0, otherwise="a")
    near = Handler(guard("altitude", "<", 3.0, held=held), "climb")
    return flying(leg("a", timeout=LONG), climb, handlers=(near,))


def test_a_handler_acts_when_its_condition_arises_and_not_while_it_lasts():
    world = near_the_bottom()
    world.altitude = 1.0
    world.wait(60.0)
    assert legs_of(world) == ["a", "climb", "a"]


@pytest.mark.parametrize("where", ["climb", "a"])
def test_a_condition_that_arises_a_second_time_surfaces(where: str):
    world = near_the_bottom(held=1.0)
    world.altitude = 1.0
    world.wait(6.0 if where == "climb" else 20.0)
    assert world.state == f"autonomous/{where}"
    world.altitude = 9.0
    world.wait(14.0)
    assert world.state == "autonomous/a"
    world.altitude = 1.0
    world.wait(4.0)
    assert legs_of(world) == ["a", "climb", "a", "surface"]
    assert [s.by for s in world.steps if s.entered][-1] is By.ON


def test_an_unknown_reading_does_not_arm_a_handler_again():
    world = near_the_bottom()
    world.altitude = 1.0
    world.wait(14.0)
    world.nav.doubt["altitude"] = "frozen"
    world.wait(4.0)
    world.nav.doubt.clear()
    world.wait(20.0)
    assert legs_of(world) == ["a", "climb", "a"]


def test_a_group_that_is_entered_arms_its_handlers_anew():
    near = Handler(guard("altitude", "<", 3.0), "away")
    group = Group("g", 1, (leg("x", timeout=LONG),), handlers=(near,))
    world = flying(group, leg("away", timeout=4.0, otherwise="g"))
    world.altitude = 1.0
    world.wait(20.0)
    assert legs_of(world) == ["g/x", "away", "g/x", "surface"]


def test_no_handler_leaves_the_implicit_leg():
    near = Handler(guard("altitude", "<", 3), "b")
    world = flying(leg("a", when("depth", ">", 1, "surface")), leg("b"), handlers=(near,))
    world.altitude = 1.0
    world.wait(20.0)
    assert world.state == "autonomous/surface"


def test_a_limit_goes_before_every_guard():
    world = flying(leg("a", when("roll", ">", 1.0, held=2.0), timeout=LONG), leg("b"))
    world.roll = math.radians(80)
    world.wait(2.0)
    assert world.state == "autonomous/a"
    world.wait(2.0)  # the limit's second sample and the end of held are the same report
    assert world.state == SURFACING


def test_exits_run_to_completion_within_one_step():
    body = [leg(f"l{i}", when("depth", ">", 1)) for i in range(20)]
    world = flying(*body, leg("end", timeout=LONG))
    assert world.state == "autonomous/end"
    assert len({s.t for s in world.steps if s.by is By.UNTIL}) == 1


def test_a_mission_that_turns_in_circles_surfaces():
    a = leg("a", when("depth", ">", 1, "b"))
    b = leg("b", when("depth", ">", 1, "a"))
    world = flying(a, b)
    assert world.state == SURFACING
    assert "200" in world.engine.reason


def test_rounds_are_counted_and_start_anew_in_every_outer_round():
    inner = Group("in", 2, (leg("x", timeout=None, duration=4.0),))
    outer = Group("out", 2, (leg("w", timeout=None, duration=4.0), inner))
    world = flying(outer, leg("end", timeout=LONG))
    world.wait(60.0)
    one = ["out/w", "out/in/x", "out/in/x"]
    assert legs_of(world) == [*one, *one, "end"]


def test_a_group_that_is_entered_again_by_a_jump_starts_at_its_first_round():
    body = (
        Group("g", 2, (leg("x", when("altitude", "<", 3, "z"), timeout=None, duration=4.0),)),
        leg("y", timeout=LONG),
        leg("z", timeout=None, duration=4.0),
        leg("back", when("depth", ">", 1, "g")),
    )
    world = flying(*body)
    world.wait(3.0)
    world.altitude = 1.0
    world.wait(2.0)
    world.altitude = 9.0
    world.wait(30.0)
    assert legs_of(world) == ["g/x", "g/x", "z", "back", "g/x", "g/x", "y"]


# --- unknown ------------------------------------------------------------------------------

CONDITIONS = st.recursive(
    st.sampled_from([Comparison("altitude", o, b) for o in ("<", ">") for b in (-5.0, 5.0, 50.0)]),
    lambda inner: st.one_of(
        inner.map(Not),
        st.tuples(inner, inner).map(And),
        st.tuples(inner, inner).map(Or),
    ),
    max_leaves=5,
)


@settings(max_examples=25, deadline=None)
@given(CONDITIONS, st.sampled_from(["frozen", "absurd", "stale", "missing"]))
def test_an_unknown_reading_never_opens_a_guard(expression, doubt: str):
    world = World(mission(leg("a", Exit(Guard(expression)), timeout=LONG), leg("b")))
    world.nav.doubt["altitude"] = doubt
    assert world.start()
    world.depth = 5.0
    world.wait(30.0)
    assert world.state == "autonomous/a"


@settings(max_examples=25, deadline=None)
@given(st.lists(st.sampled_from(["true", "false", "unknown"]), min_size=3, max_size=14))
def test_held_needs_its_whole_time(samples: list[str]):
    """Reports every 2 s; held 5 s: three that hold in a row are 4 s, the timer ends the fifth. One
    that does not hold takes 4 s back: all that there was."""
    world = flying(
        leg("a", when("altitude", "<", 3.0, held=5.0), timeout=LONG), leg("b", timeout=LONG)
    )
    since = None
    for sample in samples:
        world.altitude = 1.0 if sample == "true" else 9.0
        world.nav.doubt = {"altitude": "frozen"} if sample == "unknown" else {}
        world.t += 2.0 - (world.t % 2.0)
        world.tell(world.report())
        since = (since if since is not None else world.t) if sample == "true" else None
        timer = world.engine.next_timer()
        if since is not None:
            assert timer is not None
            assert timer <= since + 5.0
        if since is not None and since + 5.0 < world.t + 2.0:
            world.t = since + 5.0
            world.tell()
            assert world.state == "autonomous/b"
            return
        assert world.state == "autonomous/a"


def held_for(seconds: float, says: Iterable[bool | None]) -> float | None:
    """s until ``altitude < 3 held`` opens, a report every 2 s; None if it does not."""
    body = leg("a", when("altitude", "<", 3.0, held=seconds), timeout=LONG)
    world = flying(body, leg("b", timeout=LONG))
    world.t += 2.0 - (world.t % 2.0)
    begun = world.t
    for one in says:
        world.altitude = 1.0 if one else 9.0
        world.nav.doubt = {} if one is not None else {"altitude": "frozen"}
        world.tell(world.report())
        world.wait(2.0, reports=False)
        if world.state == "autonomous/b":
            return world.t - begun
    return None


@pytest.mark.parametrize("seed", range(8))
def test_held_sees_through_noise(seed: int):
    rng = Random(seed)
    assert held_for(20.0, (rng.random() < 0.85 for _ in range(120))) is not None


def test_held_does_not_open_on_what_holds_for_half_of_the_time():
    assert held_for(20.0, (i % 2 == 0 for i in range(400))) is None


def test_a_gap_takes_twice_its_time_back_from_held_and_the_unknown_takes_all():
    whole = [True] * 11
    assert held_for(20.0, whole) == 20.0
    assert held_for(20.0, [*[True] * 5, False, *[True] * 20]) == 26.0
    assert held_for(20.0, [*[True] * 5, None, *[True] * 20]) == 32.0


def test_a_reading_that_goes_stale_while_held_begins_anew():
    """The vehicle says nothing for 4.9 s: too short for the limit, long enough for a guard that
    asks for readings no older than 6 s only if the silence is not seen. It is seen by a timer."""
    body = leg("a", when("altitude", "<", 3.0, held=7.0), timeout=LONG)
    world = flying(body, leg("b", timeout=LONG))
    world.altitude = 1.0
    world.wait(2.0)
    timers = []
    while (timer := world.engine.next_timer()) is not None and timer < world.t + 6.5:
        timers.append(timer - world.t)
        world.t = timer
        if world.state != "autonomous/a":
            break
        world.tell()
    assert world.state == SURFACING  # silence is the limit's after 5 s; the guard did not open
    assert any(t <= 6.01 for t in timers)


# --- time ---------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@example(0.5000000000000001, "until")
@example(0.5000000004, "until>")
@given(st.floats(0.5, 50.0), st.sampled_from(["until", "until>", "for", "timeout"]))
def test_a_timer_fires_when_it_is_due_and_not_at_the_next_report(seconds: float, by: str):
    kinds = {
        "until": leg("a", when("elapsed", ">=", seconds), timeout=LONG),
        "until>": leg("a", when("elapsed", ">", seconds), timeout=LONG),
        "for": leg("a", timeout=None, duration=seconds),
        "timeout": leg("a", timeout=seconds, otherwise="b"),
    }
    world = World(mission(kinds[by], leg("b", timeout=LONG)))
    assert world.start()
    world.depth = 5.0
    begun = world.t
    world.wait(60.0)
    (left,) = [s.t for s in world.steps if s.exited and s.exited[0] == "autonomous/a"]
    assert left == pytest.approx(begun + seconds, abs=2e-6)


def test_a_deadline_is_always_later_than_the_step_that_gave_it():
    world = flying(leg("a", when("elapsed", ">", 30.0, held=3.0), timeout=LONG), leg("b"))
    for _ in range(200):
        timer = world.engine.next_timer()
        assert timer is None or timer > world.t
        world.wait(0.31)


def test_a_fix_opens_what_waits_for_one():
    under = leg("under", timeout=None, duration=10.0)
    seek = leg("a", when("fix_age", "<", 2.0), timeout=LONG)
    world = flying(under, seek, leg("b", timeout=LONG))
    world.wait(30.0)
    assert world.state == "autonomous/a"
    world.tell(world.fix())
    assert world.state == "autonomous/b"


def test_a_timer_between_late_reports_sees_the_estimate_reckoned_on():
    world = flying(leg("a", when("elapsed", ">", 8.0), timeout=LONG), leg("b", timeout=LONG))
    heard = world.engine.estimate.t
    world.wait(4.0, reports=False)
    world.tell()
    assert world.engine.estimate.t == pytest.approx(heard + 4.0)


def test_without_anything_to_wait_for_there_is_no_timer():
    assert World().engine.next_timer() is None


# --- else ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sensor", "settings_", "kind"),
    [
        ("altitude", sets(surge=0.5, altitude=3.0), Hold()),
        ("heading", sets(surge=0.5, heading=1.0), Hold()),
        ("heading", sets(surge=0.5), Goto(Local(500.0, 0.0), 5.0)),
    ],
)
def test_a_needed_reading_that_stays_invalid_for_six_seconds_takes_the_else(
    sensor, settings_, kind
):
    one = leg("a", kind=kind, settings=settings_, timeout=LONG, otherwise="b")
    world = World(mission(one, leg("b", settings=sets(turn=0.5, heave=0.5), timeout=LONG)))
    assert world.start()
    world.depth = 2.0
    world.until(110.0)
    world.nav.doubt[sensor] = "frozen"
    world.until(117.9)
    assert world.state == "autonomous/a"
    world.until(118.1)
    assert world.state == "autonomous/b"
    assert [s.by for s in world.steps][-1] is By.ELSE


def test_a_lost_position_takes_the_else_of_a_goto_and_leaves_a_hold_alone():
    for kind, end in ((Goto(Local(500.0, 0.0), 5.0), "autonomous/b"), (Hold(), "autonomous/a")):
        one = leg("a", kind=kind, settings=sets(surge=0.5), timeout=LONG, otherwise="b")
        world = flying(one, leg("b", settings=sets(heading=1.0), timeout=LONG))
        world.nav.mode = NavigationMode.NONE
        world.wait(12.0)
        assert world.state == end


def test_a_refused_set_takes_the_else_and_a_refusal_of_an_older_set_does_not():
    one = leg("a", timeout=LONG, otherwise="c")
    world = World(mission(one, leg("b"), leg("c", settings=sets(depth=9.0), timeout=LONG)))
    world.answer = None
    assert world.start()
    world.tell(Outcome(Result.REFUSED, b"@ZAS3$", Setpoint(depth=3.0)))
    assert world.state == "autonomous/a"
    world.tell(Outcome(Result.REFUSED, b"@ZAS5$", world.commands()[-1]))
    assert world.state == "autonomous/c"


def test_a_set_that_did_not_leave_in_time_takes_the_else_and_counts_as_no_lost_answer():
    one = leg("a", timeout=LONG, otherwise="c")
    world = World(mission(one, leg("b"), leg("c", settings=sets(depth=9.0), timeout=LONG)))
    world.answer = None
    assert world.start()
    (entry,) = world.commands()
    for _ in range(2):
        world.tell(Outcome(Result.LOST, b"@ZAF6$", entry))
    world.tell(Outcome(Result.LATE, b"@ZAS5$", Setpoint(depth=3.0)))  # an older one
    assert world.state == "autonomous/a"
    world.tell(Outcome(Result.LATE, b"@ZAS5$", entry))
    assert world.state == "autonomous/c"
    world.tell(Outcome(Result.LOST, b"@ZAS9$", world.commands()[-1]))
    assert world.state == SURFACING  # the third in succession


def test_an_unanswered_frame_brings_the_whole_set_again():
    world = World(mission(leg("a", timeout=LONG)))
    world.answer = None
    assert world.start()
    (entry,) = world.commands()
    world.tell(Outcome(Result.LOST, b"@ZAF6$", entry))
    assert world.commands() == [entry, entry]
    world.tell(Outcome(Result.ACCEPTED, b"@ZAF6$", entry))
    for _ in range(2):
        world.tell(Outcome(Result.LOST, b"@ZAF6$", entry))
    assert world.state == "autonomous/a"
    world.tell(Outcome(Result.LOST, b"@ZAF6$", entry))
    assert world.state == SURFACING


@pytest.mark.parametrize(("answered", "lost"), [(b"@ZAS5$", True), (b"@ZAH0$", False)])
def test_a_word_of_the_sets_that_is_never_answered_ends_the_mission_though_others_are(
    answered: bytes, lost: bool
) -> None:
    """It flew on by the old heading, and said the whole set again for ever."""
    world = World(mission(leg("a", timeout=LONG)))
    world.answer = None
    assert world.start()
    (entry,) = world.commands()
    for _ in range(2):
        world.tell(Outcome(Result.LOST, b"@ZAH0$", entry))
        world.tell(Outcome(Result.ACCEPTED, answered, entry))
        assert world.state == "autonomous/a"
    world.tell(Outcome(Result.LOST, b"@ZAH0$", entry))
    assert (world.state == SURFACING) is lost
    assert ("3 times @ZAH without an answer" in world.engine.reason) is lost


@pytest.mark.parametrize("answered", [False, True])
def test_words_of_sets_that_newer_ones_have_replaced_count_as_well(answered: bool) -> None:
    """A leg that steers has another set each second: its H was lost for 10 s, and none counted."""
    world = World(mission(leg("a", timeout=LONG)))
    world.answer = None
    assert world.start()
    (entry,) = world.commands()
    older = replace(entry, heading=1.0)
    for turn in range(3):
        assert world.state == "autonomous/a"
        result = Result.ACCEPTED if answered and turn == 1 else Result.LOST
        world.tell(Outcome(result, b"@ZAH-57$", older))
        world.tell(Outcome(Result.ACCEPTED, b"@ZAS5$", entry))
    assert (world.state == SURFACING) is not answered


def test_what_is_held_is_lost_while_the_vehicles_own_reports_are_too_old() -> None:
    """A core board's count for 1 s: half of the time nobody knew."""
    vehicle = replace(load_vehicle("auv"), stale_after=1.0)
    world = World(
        mission(
            leg("a", when("depth", ">", 4.0, "b", held=8.0), timeout=LONG), leg("b", timeout=LONG)
        ),
        vehicle=vehicle,
    )
    assert world.start()
    world.depth = 5.0
    begun = world.t

    def told(seconds: float) -> None:
        """Reports for a second, and none for the rest: only what the engine asks for comes."""
        world.nav.doubt.clear()
        world.t += 0.5
        world.tell(world.report())
        world.t += 0.5
        world.tell(world.report())
        until, heard = world.t + seconds, world.t
        while (due := world.engine.next_timer()) is not None and due < until:
            world.t = due
            if due - heard > vehicle.stale_after:
                world.nav.doubt["depth"] = "stale"
            world.tell()
        world.t = until

    while world.t < begun + 40.0:
        told(3.0)
    assert world.state == "autonomous/a"
    while world.t < begun + 50.0:
        told(0.0)
    assert world.state == "autonomous/b"


# --- steering -----------------------------------------------------------------------------


def test_a_steered_heading_is_sent_when_it_changed_enough_and_not_with_every_report():
    go = leg("go", kind=Goto(Local(1000.0, 0.0), 5.0), settings=sets(surge=0.5), timeout=LONG)
    world = flying(go)
    begun = len(world.actions)
    world.nav.speed = 0.75
    for i in range(100):
        world.nav.east = 0.3 * math.sin(i)  # a metre of noise across the line: about a degree
        world.nav.north = 1.5 * i
        world.wait(2.0)
    assert len(world.actions) == begun
    world.nav.east = 6.0
    world.wait(2.0)
    ((_, action),) = world.actions[begun:]
    assert action.command.heading == pytest.approx(math.tau - math.atan2(6.0, 12.0), abs=1e-9)


def test_a_goto_steers_by_this_vehicles_own_compass():
    """The compass says 10 deg too much: what is sent is 10 deg more than the true heading."""
    go = leg("go", kind=Goto(Local(0.0, 1000.0), 5.0), settings=sets(surge=0.5), timeout=LONG)
    world = World(mission(go))
    off = math.radians(10.0)
    estimate = world.nav.estimate

    def corrected(now: float):
        e = estimate(now)
        return None if e is None else e._replace(heading=(e.heading - off) % math.tau)

    world.nav.estimate = corrected
    assert world.start()
    assert world.commands()[-1].heading == pytest.approx(math.pi / 2 + off)


def test_a_goto_arrives_and_ends_by_itself():
    go = leg("go", kind=Goto(Local(100.0, 0.0), 5.0), settings=sets(surge=0.5), timeout=LONG)
    world = flying(go, leg("b", settings=sets(heading=1.0), timeout=LONG))
    world.nav.north = 94.0
    world.wait(2.0)
    assert world.state == "autonomous/go"
    world.nav.north = 95.5
    world.wait(2.0)
    assert world.state == "autonomous/b"
    assert [s.by for s in world.steps][-1] is By.END


def test_a_yoyo_sends_a_new_depth_at_each_turn_and_ends_after_its_cycles():
    yoyo = leg("y", kind=Yoyo(3.0, 9.0, 2), settings=sets(surge=0.5, heading=0.0), timeout=LONG)
    world = flying(yoyo, leg("b", settings=sets(depth=3.0), timeout=LONG), depth=1.0)
    for depth in (8.8, 3.2, 8.7, 3.3):
        while abs(depth - world.depth) > 0.01:
            world.depth += max(-0.8, min(0.8, depth - world.depth))
            world.wait(2.0)
    depths = [c.depth for c in world.commands()]
    assert depths == [9.0, 3.0, 9.0, 3.0, 3.0]
    assert world.state == "autonomous/b"


def test_travelled_is_the_path_over_ground_since_the_leg_was_entered():
    one = leg("a", when("travelled", ">=", 20.0), timeout=LONG)
    world = World(mission(one, leg("b", when("travelled", ">=", 20.0), timeout=LONG), leg("c")))
    world.nav.speed, world.nav.current = 0.6, (0.4, 0.0)  # 1 m/s northward
    assert world.start()
    world.depth = 5.0
    world.wait(19.0)
    assert world.state == "autonomous/a"
    world.wait(2.0)
    assert world.state == "autonomous/b"  # since 120 s
    world.wait(18.0)
    assert world.state == "autonomous/b"
    world.wait(1.0)
    assert world.state == "autonomous/c"


# --- records ------------------------------------------------------------------------------


def test_every_command_has_a_reason_and_stands_in_a_step():
    world = flying(
        leg("a", when("elapsed", ">", 4.0)), Group("g", 2, (leg("b", timeout=None, duration=6.0),))
    )
    world.wait(30.0)
    world.depth = 0.2
    world.wait(30.0)
    assert all(a.reason for _, a in world.actions)
    words = [w for s in world.steps for w in s.actions]
    assert len(words) == len(world.actions)
    assert all(a.reason in w for w, (_, a) in zip(words, world.actions, strict=True))


def test_a_guard_that_decided_stands_in_its_step_with_what_it_saw():
    both = Exit(Guard(And((Comparison("depth", ">", 1.0), Comparison("elapsed", ">", 3.0)))))
    world = flying(Leg("a", Hold(), sets(surge=0.5, depth=5.0), (both,), timeout=LONG), leg("b"))
    world.wait(4.0)
    (step,) = [s for s in world.steps if s.by is By.UNTIL]
    (evaluation,) = step.evaluations
    assert evaluation.result is True
    assert dict(evaluation.values) == {"depth": 5.001, "elapsed": pytest.approx(4.0, abs=1.01)}
    assert step.trigger == evaluation.trigger == "autonomous/a:until1"


def test_what_a_leg_was_blind_to_is_told_in_one_order_whatever_the_hash_seed():
    """Records are compared byte by byte, also with those of another process."""
    held = sets(surge=0.5, heading=0.0, altitude=3.0)
    world = flying(leg("a", settings=held, timeout=LONG, otherwise="b"), leg("b"))
    for sensor in ("heading", "altitude"):
        world.nav.doubt[sensor] = "frozen"
    world.wait(8.0)
    (step,) = [s for s in world.steps if s.by is By.ELSE]
    assert [name for name, _ in step.evaluations[0].values] == ["elapsed", "altitude", "heading"]


def test_a_dive_that_makes_no_progress_ends_by_its_timeout_and_says_so():
    world = flying(leg("a", when("depth", ">=", 4.5), timeout=30.0), depth=1.0)
    world.trembles = 0.0
    world.wait(30.0)
    (step,) = [s for s in world.steps if s.by is By.TIMEOUT]
    assert dict(step.evaluations[0].values)["depth"] == 1.0
    assert "depth 1.0 m" in step.event
    assert "5 m" in step.event


def test_nothing_is_sent_that_nothing_asked_for():
    world = flying(leg("a", timeout=LONG))
    begun = len(world.actions)
    world.wait(600.0)
    assert len(world.actions) == begun
    assert Order.STOP not in world.commands()
