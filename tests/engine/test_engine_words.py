"""What stands in records: events, commands and legs in words; and what is fixed about a leg."""

from __future__ import annotations

import math

import pytest
from engine_world import compiled, guard, leg, mission, when

from mission.engine.plan import name_of, plan_of, repeat_of
from mission.engine.words import event_of, in_words, short
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    AutoNode,
    By,
    Edge,
    Group,
    Handler,
    Loaded,
    Outcome,
    Restarted,
    Result,
)
from protocol.messages import (
    ClearMission,
    Emergency,
    Fix,
    Manual,
    Order,
    Setpoint,
    SetSafety,
    StartMission,
    Telemetry,
)

EVENTS = (
    (Telemetry(1.0), "telemetry"),
    (Fix(1.0, 0.5, 2.0, 2.5), "fix"),
    (StartMission(), "operator @AA"),
    (ClearMission(), "operator @AC"),
    (SetSafety(), "operator @SP"),
    (Manual("MM", b"@MMF5$"), "operator M"),
    (Loaded(None), "store"),
    (AutoNode(True), "node AUTO"),
    (Restarted(""), "restart"),
    (Emergency(Order.STOP), "operator X"),
    (Emergency(Order.SURFACE), "operator W"),
    (Outcome(Result.LOST, b"@ZAX0$", Order.STOP), f"{Result.LOST.value} @ZAX0$"),
    (3, "int"),
)


@pytest.mark.parametrize(("one", "words"), EVENTS, ids=lambda e: e if isinstance(e, str) else "")
def test_every_input_has_its_words(one: object, words: str):
    assert event_of([one]) == words


def test_several_inputs_stand_in_their_order_and_none_is_the_timer():
    assert event_of([EVENTS[0][0], EVENTS[9][0]]) == "telemetry, operator X"
    assert event_of([]) == "timer"


def test_a_frame_that_is_no_ascii_is_on_record_all_the_same():
    words = event_of([Outcome(Result.REFUSED, b"@\xff$", Order.STOP)])
    assert words == f"{Result.REFUSED.value} @�$"


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (Order.STOP, "everything stopped"),
        (Order.SURFACE, "emergency surfacing"),
        (Setpoint(), "surge 0"),
        (Setpoint(surge=0.5, turn=0.25, heave=0.0), "surge 0.5 turn 0.25 heave 0"),
        (
            Setpoint(surge=0.0, heading=math.pi, depth=0.0, pitch=math.radians(-12.5)),
            "surge 0 heading 180 depth 0 pitch -12.5",
        ),
        (Setpoint(altitude=3.0, roll=math.radians(1.0)), "surge 0 altitude 3 roll 1"),
        (Setpoint(heading=0.0), "surge 0 heading 0"),
    ],
)
def test_a_command_is_told_with_all_that_it_asks_for(command: Setpoint | Order, words: str):
    assert in_words(command) == words


def test_a_leg_is_called_without_its_region():
    assert short("autonomous/g/a") == "g/a"
    assert short("autonomous") == "autonomous"


# --- what is fixed about a leg ----------------------------------------------------------------

CHART = compiled(
    mission(
        Group(
            "g",
            2,
            (
                Group("h", 1, (leg("a", when("depth", ">", 1.0)), leg("b"))),
                leg("c"),
            ),
            handlers=(Handler(guard("altitude", "<", 3.0), "last"),),
        ),
        leg("last"),
        handlers=(Handler(guard("roll", ">", 1.0), "surface"),),
    )
)


def test_a_leg_asks_the_innermost_handlers_first_and_then_its_own_exits():
    plan = plan_of(CHART, "autonomous/g/h/a")
    by = [(edge.by, edge.source) for edge, _ in plan.guarded]
    assert by == [
        (By.ON, "autonomous/g"),
        (By.ON, AUTONOMOUS),
        *((By.UNTIL, "autonomous/g/h/a") for _ in by[2:]),
    ]
    assert len(by) > 2
    assert {edge.by for edge in plan.plain} == {By.TIMEOUT, By.ELSE}
    assert plan.groups == ("autonomous/g/h", "autonomous/g")
    assert plan.repeated == "autonomous/g", "the innermost that repeats"
    assert plan_of(CHART, "autonomous/last").repeated == ""
    assert (repeat_of(CHART, "autonomous/g"), repeat_of(CHART, "autonomous/g/h")) == (2, 1)
    assert repeat_of(CHART, "autonomous/last") == 1


def test_the_implicit_leg_asks_no_handler():
    plan = plan_of(CHART, IMPLICIT_SURFACE)
    assert plan.guarded == ()
    assert plan.plain


def test_all_ways_of_one_handler_through_the_rounds_have_one_name():
    def name(trigger: str) -> str:
        return name_of(Edge(trigger, "autonomous/g", "autonomous/last", By.ON))

    assert name("autonomous/g:on1.1") == name("autonomous/g:on1.2") == name("autonomous/g:on1")
    assert len({name(t) for t in ("a:on1", "a:on2", "b:on1", "a/b:on1", "a:on11")}) == 5
