"""The world that cells are played in: what it forgets when its program begins again."""

from __future__ import annotations

import pytest

from mission.authoring.prepare import prepare
from mission.model.copies import held
from mission.model.shipped import missions_folder
from mission.verification.exhaustive.configurations import configurations, ground
from mission.verification.exhaustive.fork import Fork
from mission.verification.exhaustive.world import World


@pytest.fixture(scope="module")
def world() -> World:
    """That of a configuration, some seconds old."""
    on = ground(prepare(missions_folder() / "first-dive.yaml"), "as-built")
    _, found = next(configurations(on))
    assert found.now > 1.0
    return found


def test_a_program_that_begins_again_counts_its_time_anew(world: World) -> None:
    """Whatever holds the time: a dictionary, or slots of a compiled class."""
    again = Fork(world).copy()
    again.restart()
    assert again.now == 0.0
    again.wait(1.0)
    assert again.now == 1.0


def test_what_was_seen_before_a_restart_stays(world: World) -> None:
    again = Fork(world).copy()
    again.restart()
    assert again.sent[: len(world.sent)] == world.sent
    assert again.states[: len(world.states)] == world.states
    assert held(again).keys() == held(world).keys()
