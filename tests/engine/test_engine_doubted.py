"""R7, at rest: what goes down by a depth whose zero alone is contradicted sinks, and nothing else does."""

from __future__ import annotations

import math

import pytest
from engine_world import M, W, World, X, leg, mission

from mission.engine.rest import Rest
from mission.model import IDLE_READY, MANUAL_WAITING, STOPPED, SURFACED, SURFACING
from protocol.messages import UPWARD

MISSION = mission(leg("a", timeout=600.0))
TO = {IDLE_READY: (), SURFACED: (W,), STOPPED: (X,), MANUAL_WAITING: (M,)}
STATES = tuple(TO)


def doubted(state: str, depth: float) -> World:
    """At rest, with a depth that leapt to ``depth`` m and moves as the vehicle does."""
    world = World(MISSION)
    world.tell(world.report())
    for word in TO[state]:
        world.tell(word)
        world.wait(3.0 if word is M else 10.0)
    assert world.state == state
    world.nav.doubt["depth"], world.nav.moves = "contradicted: it leapt by 5.0 m", True
    world.depth = depth
    world.wait(2.0)
    return world


def pushed(world: World) -> bool:
    return UPWARD in world.commands()


@pytest.mark.parametrize("rate", [0.1, 0.3])
@pytest.mark.parametrize("depth", [-6.0, 5.0])
@pytest.mark.parametrize("state", STATES)
def test_what_goes_two_metres_down_by_a_depth_whose_zero_is_off_is_brought_up(
    state: str, depth: float, rate: float
):
    world = doubted(state, depth)
    while world.state == state and world.depth < depth + 20.0:
        world.depth += 2.0 * rate
        world.wait(2.0)
    assert world.state == SURFACING
    assert world.commands()[-1] == UPWARD
    assert 2.0 <= world.depth - depth <= 2.0 + 10.0 * rate


@pytest.mark.parametrize("state", STATES)
def test_a_depth_whose_zero_is_off_and_that_stands_in_the_swell_turns_no_thruster(state: str):
    world = doubted(state, 6.0)
    for second in range(50):
        world.depth = 6.0 + 0.9 * math.sin(second)
        world.wait(1.0)
    assert not pushed(world)
    assert world.state == state


@pytest.mark.parametrize("state", STATES)
def test_a_depth_that_is_contradicted_and_does_not_move_as_the_vehicle_turns_none(state: str):
    world = doubted(state, 6.0)
    world.nav.moves = False
    for _ in range(25):
        world.depth += 0.4
        world.wait(2.0)
    assert not pushed(world)
    assert world.state == state


def test_a_depth_whose_zero_is_off_says_nothing_while_fixes_come_as_at_the_surface():
    world = doubted(SURFACED, 6.0)
    for second in range(80):
        world.depth += 0.1
        world.tell(world.fix(0.3 * math.sin(second), 0.2 * second))
        world.wait(1.0)
    assert not pushed(world)
    assert world.state == SURFACED


@pytest.mark.parametrize("rate", [0.2, 0.37])
@pytest.mark.parametrize("state", STATES)
def test_what_goes_down_as_no_depth_does_at_the_surface_is_brought_up_though_fixes_come(
    state: str, rate: float
):
    """Heavy, and a receiver that makes places up: it sank to the ground with its depth showing it."""
    world = doubted(state, 6.0)
    for second in range(40):
        if world.state == SURFACING:
            break
        world.depth += rate if second > 10 else 0.0
        world.tell(world.fix(0.3 * math.sin(second), 0.2 * second))
        world.wait(1.0)
    assert world.state == SURFACING
    assert world.commands()[-1] == UPWARD
    assert 2.0 <= world.depth - 6.0 <= 8.0


def test_what_goes_down_by_a_depth_whose_zero_is_off_counts_anew_behind_a_silence():
    rest = Rest(0.6)
    for second in range(60):
        rest.follow(second, None if second == 30 else 5.0 + 0.06 * second)
    assert rest.goes_down == ""
    rest.follow(80.0, 12.0)
    assert rest.goes_down == ""
    rest.follow(86.0, 14.1)
    assert rest.goes_down
