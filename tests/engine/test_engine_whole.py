"""The whole engine: the same input gives the same output, from any snapshot; and no input, in any
order, brings it where the design has no state or out of an emergency by another way than R7's."""

from __future__ import annotations

import random

import pytest
from engine_world import M, World, guard, leg, mission, sets, when
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from mission.legs import Goto, Yoyo
from mission.model import (
    IDLE_EMPTY,
    STOPPED,
    SURFACED,
    SURFACING,
    And,
    AutoNode,
    Comparison,
    Exit,
    Group,
    Guard,
    Handler,
    Local,
    NavigationMode,
    Outcome,
    Result,
)
from mission.model.regions import REGIONS
from protocol.messages import (
    ClearMission,
    Emergency,
    Order,
    Setpoint,
    SetSafety,
    StartMission,
)

MISSION = mission(
    leg("dive", when("depth", ">=", 4.5), timeout=40.0),
    Group(
        "rows",
        2,
        (
            leg(
                "out", when("elapsed", ">", 11.0), when("altitude", "<", 2.0, "home_run", held=3.0)
            ),
            leg("yo", kind=Yoyo(2.0, 6.0, 1), settings=sets(surge=0.5, heading=2.0), timeout=30.0),
        ),
        handlers=(Handler(guard("roll", ">", 0.5, held=1.0), "home_run"),),
    ),
    leg(
        "home_run",
        kind=Goto(Local(0.0, 0.0), 10.0),
        settings=sets(surge=0.5, depth=3.0),
        timeout=40.0,
    ),
    handlers=(Handler(guard("battery", "<", 11.0, held=4.0), "surface"),),
)
LEAVES = {leaf for leaves in REGIONS.values() for leaf in leaves}


def random_input(rng: random.Random, world: World) -> list[object]:
    kind = rng.randrange(14)
    if kind < 6:
        world.depth = max(0.0, (world.depth or 0.0) + rng.uniform(-1.0, 1.0))
        world.altitude = rng.choice([1.0, 9.0])
        world.roll = rng.choice([0.0, 0.0, 0.0, 0.7])
        return [world.report()]
    if kind == 6:
        world.nav.doubt = rng.choice([{}, {}, {"depth": "frozen"}, {"heading": "stale"}])
        return [world.report()]
    if kind == 7:
        return [world.fix(north=rng.uniform(-50, 50))]
    if kind == 8:
        return [M]
    if kind == 9:
        return [Emergency(rng.choice(list(Order)))]
    if kind == 10:
        return [StartMission()]
    if kind == 11:
        return [rng.choice([ClearMission(), SetSafety(depth=rng.uniform(3.0, 20.0))])]
    if kind == 12:
        sent = world.commands()[-1] if world.actions else Order.STOP
        return [Outcome(rng.choice(list(Result)), b"@Z$", sent)]
    world.nav.north = rng.uniform(0.0, 900.0)
    return [world.report()]


def script(seed: int, world: World, steps: int) -> list[object]:
    """A fixed run of inputs and timers; the engine's whole output."""
    rng, outputs = random.Random(seed), []
    world.answer = None
    for _ in range(steps):
        timer = world.engine.next_timer()
        world.t += rng.uniform(0.0, 2.0)
        if timer is not None and timer <= world.t:
            world.t = max(timer, world.engine.core.now)
            outputs.append(world.tell())
        else:
            outputs.append(world.tell(*random_input(rng, world)))
    return outputs


def started() -> World:
    world = World(MISSION)
    assert world.start()
    return world


def test_the_same_inputs_give_the_same_outputs():
    for seed in range(10):
        assert script(seed, started(), 150) == script(seed, started(), 150)


@pytest.mark.proof
def test_a_snapshot_holds_everything_that_decides_what_comes_next():
    for seed in range(20):
        world = started()
        script(seed, world, 5 * seed)
        kept, t = world.engine.snapshot(), world.t
        body = (world.depth, world.altitude, world.roll, list(world.actions))
        first = script(seed + 1, world, 80)
        after = world.engine.state
        for _ in range(2):
            world.engine.restore(kept)
            world.t = t
            world.depth, world.altitude, world.roll, world.actions = (*body[:3], list(body[3]))
            assert script(seed + 1, world, 80) == first
            assert world.engine.state == after


def test_a_snapshot_is_not_touched_by_what_comes_after_it():
    world = started()
    world.depth = 5.0
    world.wait(4.0)
    kept = world.engine.snapshot()
    timer = world.engine.next_timer()
    world.tell(Emergency(Order.STOP))
    world.engine.restore(kept)
    assert world.engine.state == "autonomous/rows/out"
    assert world.engine.next_timer() == timer


def test_a_placed_engine_goes_on_like_one_that_came_there_by_itself():
    flown = started()
    flown.depth = 5.0
    flown.wait(2.0)  # into rows/out
    placed = started()
    placed.depth = 5.0
    placed.t = flown.t
    placed.engine.place("autonomous/rows/out", {"autonomous/rows": 2})
    assert placed.engine.state == flown.engine.state
    assert (placed.engine.round, flown.engine.round) == (2, 1)
    placed.tell(placed.report())
    assert not placed.actions[1:]
    for world in (placed, flown):
        world.depth, world.altitude = 5.0, 1.0
        world.wait(8.0)
        assert "autonomous/home_run" in [s.entered[-1] for s in world.steps if s.entered]


@settings(
    max_examples=25,
    stateful_step_count=40,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
class Anything(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.world = World(MISSION)
        self.world.tell(self.world.report(), self.world.fix())
        self.sent = 0

    def told(self, *inputs: object) -> None:
        before, self.sent = self.world.state, len(self.world.actions)
        self.world.tell(*inputs)
        self.check(before, inputs)

    def check(self, before: str, inputs: tuple[object, ...]) -> None:
        now = self.world.state
        news = self.world.actions[self.sent :]
        assert all(a.reason for _, a in news)
        if before.startswith("emergency") and not now.startswith("emergency"):
            assert self.world.verdicts[-1].accepted
            stick = now == "manual/driving" and M in inputs
            cleared = now == IDLE_EMPTY and before in (STOPPED, SURFACED)
            assert stick or (cleared and ClearMission() in inputs)
        if now.startswith("autonomous") and not before.startswith("autonomous"):
            assert StartMission() in inputs
        if now == "manual/driving":
            assert not any(isinstance(a.command, Setpoint) for _, a in news)
        if now == STOPPED or now.startswith("idle"):
            assert {a.command for _, a in news} <= {Order.STOP}

    @rule(
        depth=st.floats(0.0, 30.0),
        altitude=st.sampled_from([None, 1.0, 9.0]),
        volts=st.sampled_from([10.0, 12.0]),
    )
    def report(self, depth: float, altitude: float | None, volts: float) -> None:
        self.world.depth, self.world.altitude = depth, altitude
        self.told(self.world.report(batteries=(volts, 48.0)))

    @rule(doubt=st.sampled_from([{}, {"depth": "frozen"}, {"heading": "stale"}]))
    def sensors(self, doubt: dict[str, str]) -> None:
        self.world.nav.doubt = doubt
        self.told(self.world.report())

    @rule(mode=st.sampled_from(list(NavigationMode)), north=st.floats(0.0, 3000.0))
    def position(self, mode: NavigationMode, north: float) -> None:
        self.world.nav.mode, self.world.nav.north = mode, north
        self.told(self.world.report())

    @rule()
    def gps(self) -> None:
        self.told(self.world.fix())

    @rule(command=st.sampled_from([M, M, StartMission(), StartMission(), ClearMission()]))
    def operator(self, command: object) -> None:
        self.told(command)

    @rule()
    def begin(self) -> None:
        self.told(self.world.report())
        self.told(self.world.fix())
        self.told(StartMission())

    @rule(order=st.sampled_from(list(Order)))
    def emergency(self, order: Order) -> None:
        self.told(Emergency(order))
        assert self.world.state == (STOPPED if order is Order.STOP else SURFACING)

    @rule(
        limit=st.sampled_from([SetSafety(radius=100.0), SetSafety(depth=8.0), SetSafety(time=30.0)])
    )
    def safety(self, limit: SetSafety) -> None:
        self.told(limit)

    @rule(is_open=st.booleans())
    def auto(self, is_open: bool) -> None:
        self.told(AutoNode(is_open))
        assert is_open or not self.world.state.startswith("autonomous")

    @rule(result=st.sampled_from([None, *Result]))
    def vehicle(self, result: Result | None) -> None:
        self.world.answer = result

    @rule(seconds=st.floats(0.1, 30.0), reports=st.booleans())
    def time(self, seconds: float, reports: bool) -> None:
        before = self.world.state
        self.world.wait(seconds, reports=reports)
        deep = reports and self.world.depth is not None and self.world.depth > 2.0
        if before == STOPPED:  # and brought up where it does not rise (R7)
            assert self.world.state in ((STOPPED, SURFACING) if deep else (STOPPED,))

    @precondition(lambda self: self.world.state.startswith("autonomous"))
    @rule()
    def snapshots(self) -> None:
        kept = self.world.engine.snapshot()
        self.world.engine.restore(kept)

    @invariant()
    def the_state_is_one_of_the_design(self) -> None:
        state = self.world.state
        chart = self.world.engine.chart
        known = {s.path for s in chart.states if s.leg} if chart else set()
        assert state in LEAVES | known

    @invariant()
    def deadlines_lie_ahead(self) -> None:
        timer = self.world.engine.next_timer()
        assert timer is None or timer > self.world.engine.core.now


TestAnything = Anything.TestCase


def test_the_machine_is_told_what_fires_and_asked_for_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Why guards stand outside it: one dispatch of it costs as much as a hundred comparisons."""
    names = ("depth", "altitude", "elapsed", "range", "battery")
    exits = [
        Exit(Guard(And((Comparison(n, ">", 900.0), Comparison(n, ">", 950.0))))) for n in names
    ]
    world = World(mission(leg("a", *exits, timeout=600.0), leg("b", timeout=20000.0)))
    assert world.start()
    library = world.engine.core.machine.library
    told: list[str] = []
    dispatch = library.trigger_event

    def counted(model: object, trigger: str) -> bool:
        told.append(trigger)
        return dispatch(model, trigger)

    monkeypatch.setattr(library, "trigger_event", counted)
    world.depth = 5.0  # as asked for
    world.wait(590.0)
    assert told == []
    before = len(world.steps)
    world.wait(20.0)
    assert told == [step.trigger for step in world.steps[before:] if step.trigger]
    assert told[0] == "autonomous/a:timeout"
