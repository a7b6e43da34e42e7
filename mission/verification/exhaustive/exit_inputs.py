"""Inputs that open a leg's first exit: the readings that the leg waits for.

Only variables of a guard that one report or the run itself decides can be set here. Exits that ask
for another variable (a position, a current) are tried in simulation.

What does not live here: the laws that the exit is then taken, and by its rounds (proof_laws).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from mission.model import (
    And,
    By,
    Chart,
    Comparison,
    Guard,
    terms,
)
from mission.verification.exhaustive.cell import Configuration
from mission.verification.exhaustive.world import World

BEYOND = 0.2  # beyond the guard's bound, in the variable's unit
WAIT = 9.0  # s: a reading that jumps is believed at its third report


def _depth(world: World, value: float) -> None:
    world.come_to(value)


def _altitude(world: World, value: float) -> None:
    world.sea.altitude = value


def _temperature(world: World, value: float) -> None:
    world.sea.temperature = value


def _heading(world: World, value: float) -> None:
    world.sea.heading_deg = math.degrees(value)


def _travelled(world: World, value: float) -> None:
    run = world.engine.core.run
    assert run is not None
    run.travelled = value


_BRING: Mapping[str, Callable[[World, float], None]] = MappingProxyType(
    {
        "depth": _depth,
        "altitude": _altitude,
        "temperature": _temperature,
        "heading": _heading,
        "travelled": _travelled,
    }
)


def wish(configuration: Configuration, chart: Chart) -> Guard | None:
    """Return the guard of the leg's first exit; None if its readings cannot be set here."""
    if configuration.region != "autonomous":
        return None
    for edge in chart.leaving(configuration.leaf):
        if edge.by is By.UNTIL and edge.guard is not None:
            plain = isinstance(edge.guard.expression, Comparison | And)
            known = all(
                isinstance(c, Comparison) and c.variable in _BRING
                for c in terms(edge.guard.expression)
            )
            return edge.guard if plain and known else None
    return None


def come_true(world: World, configuration: Configuration, chart: Chart) -> None:
    guard = wish(configuration, chart)
    world.answers = "Y"
    if guard is None:
        return
    for c in terms(guard.expression):
        assert isinstance(c, Comparison)
        _BRING[c.variable](world, c.bound + (BEYOND if c.operator[0] == ">" else -BEYOND))
    world.wait(WAIT + guard.held)


def end_leg(world: World, configuration: Configuration, chart: Chart) -> None:
    """Let the time of the active leg be up in 0.05 s."""
    if configuration.region != "autonomous":
        return
    leg = chart.state(configuration.leaf).leg
    assert leg is not None
    times = [t for t in (leg.duration, leg.timeout) if t is not None]
    if times:
        world.engine.place(configuration.leaf, dict(configuration.rounds), min(times) - 0.05)
