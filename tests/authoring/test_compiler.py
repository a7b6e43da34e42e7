"""Laws of the compiler: every way out of a leg, every axis of every leg, every error at once."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace

import pytest
from engine_world import VEHICLE, compiled, leg, mission, sets, when
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.authoring.compiler.compiler import MissionErrors, compile_mission
from mission.authoring.language import digest, parse
from mission.legs import Goto, Hold, Surface, Wait, Yoyo
from mission.model import (
    AUTONOMOUS,
    IDLE_READY,
    IMPLICIT_SURFACE,
    By,
    Comparison,
    Group,
    Guard,
    Handler,
    Leg,
    Local,
    Loop,
    Set,
    Where,
)

HELD = sets(surge=0.5, heading=1.0, depth=5.0)


def rules(*body, vehicle=VEHICLE, **more) -> list[str]:
    with pytest.raises(MissionErrors) as caught:
        compiled(mission(*body, **more), vehicle)
    return [p.code for p in caught.value.diagnostics]


def targets(chart, source: str, by: By) -> list[tuple[tuple[Loop, ...], str]]:
    return [(e.loops, e.target) for e in chart.leaving(source) if e.by is by]


def path(name: str) -> str:
    return f"{AUTONOMOUS}/{name}"


# --- ways ---------------------------------------------------------------------------------


def test_an_exit_without_target_leads_to_the_next_leg_and_the_last_to_the_surface():
    chart = compiled(mission(leg("a", when("depth", ">", 1)), leg("b", when("depth", ">", 2))))
    assert chart.initial == path("a")
    assert targets(chart, path("a"), By.UNTIL) == [((), path("b"))]
    assert targets(chart, path("b"), By.UNTIL) == [((), IMPLICIT_SURFACE)]
    assert targets(chart, IMPLICIT_SURFACE, By.END) == [((), IDLE_READY)]
    assert chart.states[-1].path == IMPLICIT_SURFACE


def test_a_timeout_without_else_leads_to_the_surface_or_where_the_mission_says():
    assert targets(compiled(mission(leg("a"))), path("a"), By.TIMEOUT) == [((), IMPLICIT_SURFACE)]
    chart = compiled(mission(leg("a"), leg("b"), on_timeout="b"))
    assert targets(chart, path("a"), By.TIMEOUT) == [((), path("b"))]
    assert targets(chart, path("a"), By.ELSE) == [((), path("b"))]


def test_the_missions_timeout_leads_to_its_own_leg_and_not_to_a_groups() -> None:
    text = (
        "mission m vehicle auv\nsafety radius 600 time 60min depth 30\n"
        "group g:\nout: heading 0 gear 4 timeout 60s\nback: heading 90 gear 6 timeout 60s\nend\n"
        "back: heading 180 gear 4 timeout 60s\non timeout -> back\non uncertain -> back\n"
    )
    parsed = parse(text)
    chart = compile_mission(parsed, VEHICLE, digest(parsed))
    leads = {edge.target for edge in chart.edges if edge.trigger == "autonomous/g/out:timeout"}
    assert leads == {"autonomous/back"}


def test_the_end_of_nested_rounds_has_one_edge_for_every_outcome():
    inner = Group("in", 3, (leg("x", timeout=None, duration=5.0),))
    outer = Group("out", 2, (leg("w"), inner))
    chart = compiled(mission(outer, leg("z")))
    inside, around = path("out/in"), path("out")
    assert targets(chart, path("out/in/x"), By.FOR) == [
        ((Loop(inside, True),), path("out/in/x")),
        ((Loop(inside, False), Loop(around, True)), path("out/w")),
        ((Loop(inside, False), Loop(around, False)), path("z")),
    ]


def test_edges_stand_in_the_order_in_which_they_are_looked_at():
    one = leg("a", when("depth", ">", 1), when("depth", ">", 2), timeout=60.0, duration=30.0)
    kinds = [e.by for e in compiled(mission(one)).leaving(path("a"))]
    assert kinds == [By.UNTIL, By.UNTIL, By.FOR, By.TIMEOUT, By.ELSE]


@pytest.mark.parametrize("awaits", [True, False])
def test_an_ascent_that_awaits_a_fix_ends_with_it_or_after_its_time_whichever_is_first(
    awaits: bool,
) -> None:
    """Without ``until fix`` the time says how long it stays up."""
    up = leg("up", kind=Surface(until_fix=awaits), settings=(), timeout=None, duration=600.0)
    chart = compiled(mission(leg("a", duration=5.0), up, leg("b", duration=5.0)))
    assert targets(chart, path("up"), By.FOR) == [((), path("b"))]
    assert targets(chart, path("up"), By.END) == ([((), path("b"))] if awaits else [])


def test_triggers_are_unique():
    group = Group("g", 4, (leg("a", when("depth", ">", 1)), leg("b", when("depth", ">", 1))))
    chart = compiled(mission(group, leg("a", when("depth", ">", 1))))
    triggers = [e.trigger for e in chart.edges]
    assert len(triggers) == len(set(triggers))


def test_a_target_is_sought_from_the_innermost_group_outward():
    group = Group("g", 1, (leg("a", when("depth", ">", 1, "b")), leg("b")))
    chart = compiled(mission(group, leg("b"), leg("c", when("depth", ">", 1, "g/b"))))
    assert targets(chart, path("g/a"), By.UNTIL) == [((), path("g/b"))]
    assert targets(chart, path("c"), By.UNTIL) == [((), path("g/b"))]


def test_a_group_as_target_means_its_first_leg():
    group = Group("g", 1, (Group("h", 1, (leg("a"),)),))
    chart = compiled(mission(leg("s", when("depth", ">", 1, "g")), group))
    assert targets(chart, path("s"), By.UNTIL) == [((), path("g/h/a"))]


def test_handlers_belong_to_their_group_and_on_uncertain_to_the_mission():
    low = Handler(Guard(Comparison("battery", "<", 11.0), 10.0), "up")
    group = Group("g", 1, (leg("a"),), handlers=(low,))
    up = leg("up", kind=Surface(), settings=())
    chart = compiled(mission(group, up, handlers=(low,), on_uncertain="up"))
    assert targets(chart, path("g"), By.ON) == [((), path("up"))]
    assert targets(chart, AUTONOMOUS, By.ON) == [((), path("up"))]
    assert targets(chart, AUTONOMOUS, By.UNCERTAIN) == [((), path("up"))]


# --- axes ---------------------------------------------------------------------------------


def test_an_omitted_axis_keeps_its_value():
    chart = compiled(
        mission(
            leg("a", settings=HELD), leg("b", settings=sets(heading=2.0)), leg("c", settings=())
        )
    )
    # by the timeouts alone nothing leads from a to b: the ways are the exits
    chart = compiled(
        mission(
            leg("a", when("depth", ">", 1), settings=HELD),
            leg("b", when("depth", ">", 1), settings=sets(heading=2.0)),
            leg("c", settings=()),
        )
    )
    kept = chart.state(path("c")).setpoint
    assert (kept.surge, kept.heading, kept.depth) == (0.5, 2.0, 5.0)


def test_bare_lines_are_folded_into_what_follows():
    body = (
        Set("line1", sets(depth=5.0)),
        Set("line2", sets(surge=0.5)),
        Leg("line3", Wait(), duration=10.0),
        Set("line4", sets(turn=-0.25)),
        Leg("line5", Wait(), duration=10.0),
    )
    chart = compiled(mission(*body))
    first, second = (chart.state(path(n)).setpoint for n in ("line3", "line5"))
    assert (first.surge, first.turn, first.depth) == (0.5, 0.0, 5.0)
    assert (second.surge, second.turn, second.depth) == (0.0, -0.25, 5.0)


def test_a_heading_ends_the_turn_and_a_turn_ends_the_heading():
    chart = compiled(
        mission(
            leg("t", when("depth", ">", 1), settings=sets(turn=0.5, depth=5.0)),
            leg("h", when("depth", ">", 1), settings=sets(heading=1.0)),
            leg("u", settings=sets(turn=-0.5)),
        )
    )
    assert chart.state(path("h")).setpoint.turn == 0.0
    assert chart.state(path("u")).setpoint.heading is None


def test_two_ways_in_with_different_values_name_the_axis_and_the_line():
    body = (
        leg("a", when("depth", ">", 1), when("altitude", "<", 2, "c"), settings=HELD),
        leg("b", when("depth", ">", 1), settings=sets(depth=9.0)),
        Leg("c", Hold(), sets(heading=3.0), timeout=60.0, where=Where(7, 1)),
    )
    with pytest.raises(MissionErrors) as caught:
        compiled(mission(*body))
    (problem,) = caught.value.diagnostics
    assert problem.code == "axis-conflict"
    assert problem.where == Where(7, 1)
    assert "depth, altitude, up or down" in problem.message
    assert "depth 5" in problem.message
    assert "depth 9" in problem.message


def test_one_conflict_is_told_once_and_not_by_every_leg_behind_it():
    tail = [leg(f"t{i}", when("depth", ">", 1), settings=()) for i in range(5)]
    body = (
        leg("a", when("depth", ">", 1), when("altitude", "<", 2, "t0"), settings=HELD),
        leg("b", when("depth", ">", 1), settings=sets(heading=2.0)),
        *tail,
    )
    assert rules(*body) == ["axis-conflict"]


def test_a_repeated_group_brings_its_last_values_back_to_its_first_leg():
    group = Group(
        "g",
        2,
        (
            leg("x", when("depth", ">", 1), settings=sets(heading=1.0)),
            leg("y", when("depth", ">", 1), settings=sets(depth=8.0)),
        ),
    )
    assert rules(leg("a", when("depth", ">", 1), settings=HELD), group) == ["axis-conflict"]


def test_a_handler_brings_the_values_of_all_its_legs():
    handler = Handler(Guard(Comparison("battery", "<", 11.0)), "away")
    group = Group(
        "g",
        1,
        (
            leg("x", when("depth", ">", 1), settings=HELD),
            leg("y", when("depth", ">", 1, "z"), settings=sets(depth=8.0)),
        ),
        handlers=(handler,),
    )
    z = leg("z", when("depth", ">", 1), settings=HELD)
    assert rules(group, z, leg("away", settings=sets(heading=2.0))) == ["axis-conflict"]


def test_what_a_goto_steered_cannot_be_kept():
    go = leg("go", kind=Goto(Local(10, 0), 5.0), settings=sets(surge=0.5, depth=5.0))
    assert rules(go, leg("on", settings=())) == ["axis-steered"]
    compiled(mission(go, leg("on", settings=sets(surge=0.0))))


def test_after_a_surface_leg_everything_is_off():
    up = leg("up", kind=Surface(), settings=())
    chart = compiled(mission(leg("a", when("depth", ">", 1)), up, leg("b", settings=())))
    assert chart.state(path("b")).setpoint.depth is None
    assert chart.state(path("b")).setpoint.surge == 0.0


AXES = st.fixed_dictionaries(
    {},
    optional={
        "surge": st.sampled_from([0.25, 0.5]),
        "heading": st.sampled_from([1.0, 2.0]),
        "depth": st.sampled_from([3.0, 6.0]),
    },
)


@st.composite
def jumpy(draw):
    """Legs, some in a repeated group, with jumps to each other."""
    names = [f"n{i}" for i in range(draw(st.integers(2, 6)))]
    legs = []
    for name in names:
        exits = [when("depth", ">", 1)] if draw(st.booleans()) else []
        if draw(st.booleans()):
            exits.append(when("altitude", "<", 2, draw(st.sampled_from(names))))
        legs.append(leg(name, *exits, settings=sets(**draw(AXES))))
    cut = draw(st.integers(0, len(legs)))
    tail = (Group("g", draw(st.integers(1, 2)), tuple(legs[cut:])),) if cut < len(legs) else ()
    body = (*legs[:cut], *tail)
    return mission(leg("first", when("depth", ">", 1), settings=HELD), *body)


@settings(max_examples=60, deadline=None)
@given(jumpy())
def test_axes_agree_with_a_walk_along_every_way(one):
    """The oracle carries whole sets along all edges, leg by leg, and needs no lattice."""
    chart, refused = _try(one)
    assert refused <= {"axis-conflict"}
    stated = list(_legs(one))
    every = tuple(sets(surge=0.5, heading=1.0, depth=5.0))
    free = compiled(replace(one, body=_with_all(one.body, every)))  # same ways, nothing omitted
    found: dict[str, set[tuple[object, ...]]] = {}
    todo = [(free.initial, ((), None, None))]
    settings_of = {p: {s.word: s.value for s in one.settings} for p, one in stated}
    while todo:
        at, values = todo.pop()
        words = settings_of[at]
        inside = tuple(
            words.get(w, v) for w, v in zip(("surge", "heading", "depth"), values, strict=True)
        )
        if inside in found.setdefault(at, set()):
            continue
        found[at].add(inside)
        todo += [(e.target, inside) for e in free.leaving(at) if e.target != IMPLICIT_SURFACE]
    if {p for p, _ in stated} <= set(found):  # what nothing reaches is the check's to refuse
        assert bool(refused) == any(len(v) > 1 for v in found.values())
    if chart is not None:
        for at, values in found.items():
            ((surge, heading, depth),) = values
            got = chart.state(at).setpoint
            assert (got.surge, got.heading, got.depth) == (surge, heading, depth)


def _try(one):
    try:
        return compiled(one), set()
    except MissionErrors as error:
        return None, {p.code for p in error.diagnostics}


def _legs(one):
    for node in one.body:
        if isinstance(node, Group):
            yield from ((path(f"{node.name}/{n.name}"), n) for n in node.body)
        else:
            yield path(node.name), node


def _with_all(body, every):
    return tuple(
        replace(n, body=_with_all(n.body, every))
        if isinstance(n, Group)
        else replace(n, settings=every)
        for n in body
    )


# --- errors -------------------------------------------------------------------------------


def test_a_leg_without_a_bound_by_time_is_refused():
    assert rules(leg("a", when("depth", ">", 1), timeout=None)) == ["no-time-bound"]
    assert rules(leg("a", timeout=math.inf)) == ["no-time-bound"]


def test_an_unknown_target_gets_the_nearest_known_name():
    with pytest.raises(MissionErrors) as caught:
        compiled(mission(leg("home_run"), leg("a", when("depth", ">", 1, "home_rum"))))
    assert "home_run" in caught.value.diagnostics[0].hint


def test_a_name_that_several_legs_have_must_be_written_with_its_path():
    groups = [Group(g, 1, (leg("x"),)) for g in ("g", "h")]
    assert rules(leg("a", when("depth", ">", 1, "x")), *groups) == ["ambiguous-target"]


def test_surface_is_nobodys_name_and_no_name_stands_twice():
    assert rules(leg("surface")) == ["name-reserved", "no-leg"]
    assert rules(leg("a"), leg("a")) == ["name-twice"]


def test_a_loop_without_a_wait_is_refused():
    loop = Group("g", 3, (Set("l1", sets(depth=5.0)),))
    assert rules(loop, leg("a")) == ["loop-without-wait"]


def test_groups_stand_inside_each_other_at_most_sixteen_deep():
    def nested(depth: int):
        node = leg("a")
        for i in range(depth):
            node = Group(f"g{i}", 2, (node,))
        return node

    compiled(mission(nested(16)))
    assert "too-deep-nesting" in rules(nested(17))
    assert "too-deep-nesting" in rules(nested(300))


def test_a_mission_that_never_lasts_is_refused():
    assert rules(Set("l1", sets(depth=5.0))) == ["no-leg"]


def test_a_guard_that_can_never_be_known_is_refused():
    assert rules(leg("a", when("leak", ">", 0))) == ["never-known"]
    assert rules(leg("a", when("distance", "<", 5))) == ["never-known"]
    assert rules(leg("a", when("bosons", "<", 5))) == ["unknown-variable"]


def test_turn_and_heading_in_one_line_exclude_each_other():
    assert "axis-clash" in rules(leg("a", settings=sets(turn=0.5, heading=1.0)))
    assert "axis-clash" in rules(leg("a", settings=sets(depth=5.0, heave=0.5)))
    assert "axis-clash" in rules(leg("a", settings=sets(depth=5.0, altitude=3.0, heave=0.5)))
    go = leg("go", kind=Goto(Local(1, 0), 5.0), settings=sets(surge=0.5, heading=1.0))
    assert rules(go) == ["axis-clash"]


def test_what_the_vehicle_cannot_follow_is_refused():
    assert rules(leg("a", settings=sets(pitch=0.1))) == ["vehicle-cannot-follow"]
    blind = replace(VEHICLE, reports=VEHICLE.reports - {"position"})
    go = leg("go", kind=Goto(Local(10, 0), 5.0), settings=sets(surge=0.5))
    assert rules(go, vehicle=blind) == ["vehicle-cannot-know"]
    assert rules(leg("a", settings=sets(depth=500.0))) == ["too-deep"]


def test_one_speed_for_both_is_refused_only_where_both_have_one_and_they_differ():
    assert rules(leg("a", settings=sets(surge=0.5, heave=0.25))) == ["one-speed"]
    compiled(mission(leg("a", settings=sets(surge=0.5, heave=0.5))))
    compiled(mission(leg("a", settings=sets(heave=0.5))))
    compiled(mission(leg("a", settings=sets(surge=0.5, heave=0.0))))


def test_a_set_for_which_the_dialect_has_no_word_is_refused():
    assert rules(leg("a", settings=sets(surge=0.5, turn=0.5))) == ["vehicle-has-no-word"]
    letter = replace(VEHICLE, dialect="documented", one_speed=False)
    compiled(mission(leg("a", settings=sets(surge=0.5, turn=0.5))), letter)


def test_a_leg_that_makes_way_needs_way_on():
    go = leg("go", kind=Goto(Local(10, 0), 5.0), settings=sets(depth=5.0))
    assert rules(go) == ["no-way-on"]


def test_all_problems_are_told_at_once_in_the_order_of_the_text():
    body = (
        replace(leg("a", timeout=None), where=Where(3, 1)),
        replace(leg("b", settings=sets(pitch=1.0)), where=Where(2, 1)),
        replace(leg("c", kind=Yoyo(5.0, 2.0, 1), settings=()), where=Where(9, 1)),
    )
    with pytest.raises(MissionErrors) as caught:
        compiled(mission(*body))
    lines = [p.where.line for p in caught.value.diagnostics]
    assert lines == sorted(lines)
    assert {2, 3, 9} <= set(lines)


# --- size ---------------------------------------------------------------------------------


def _long(n: int):
    legs = [leg(f"l{i}", when("depth", ">", 1)) for i in range(n)]
    return mission(*(Group(f"g{k}", 2, tuple(legs[k : k + 10])) for k in range(0, n, 10)))


def _calls(work: Callable[[], object]) -> int:
    """Of functions, those of the interpreter included: the same on every machine."""
    count = 0

    def seen(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(seen)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.proof
def test_four_times_the_legs_are_compiled_with_four_times_the_calls():
    small, large = _long(250), _long(1000)
    compiled(small)
    assert _calls(lambda: compiled(large)) < 5.0 * _calls(lambda: compiled(small))  # n^2: 16
