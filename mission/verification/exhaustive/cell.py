"""What a law is asked about: a configuration, an event, and what was seen.

What does not live here: how either comes about (configurations, events), what is right (laws).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from mission.legs import LEGS
from mission.model import STOPPED, SURFACING, Chart, State, Step, Tx
from mission.verification.exhaustive.lines import Line
from mission.verification.exhaustive.world import World


@dataclass(frozen=True, slots=True)
class Configuration:
    """``leaf`` is the active leg, or the interrupted one. ``preceded``: an emergency since idle.
    ``quiet``: no Z is outstanding."""

    mission: str
    profile: str
    name: str
    state: str
    leaf: str = ""
    rounds: tuple[tuple[str, int], ...] = ()
    auto: bool = True
    loaded: bool = True
    preceded: bool = False
    quiet: bool = True
    acted: bool = False  # the mission's handlers have acted once

    @property
    def region(self) -> str:
        return self.state.partition("/")[0]


@dataclass(frozen=True, slots=True)
class Event:
    """``play`` lets it happen, and some time pass. ``command`` is the frame type of an operator's
    command, by ``path`` (boat, the commander; tender; modem); ``limit`` the row of R5 and R8 that
    it breaches; ``sensor`` tells nothing that can be believed from ``after`` s on. ``also`` names
    whatever else of it may have an effect. ``needs``: what a vehicle has that it can happen to
    (lines). ``word``: the M that is said."""

    name: str
    play: Callable[[World, Configuration, Chart], None]
    command: str = ""
    path: str = "boat"
    limit: str = ""
    sensor: str = ""
    after: float = 0.0
    also: frozenset[str] = frozenset()
    needs: frozenset[str] = frozenset()
    word: bytes = b""

    @property
    def causes(self) -> frozenset[str]:
        kind = "M" if self.command.startswith("M") else self.command
        return self.also | {kind, "limit" if self.limit else ""} - {""}


@dataclass(frozen=True, slots=True)
class Before:
    """The world when the event began."""

    t: float
    depth: float
    stick_age: float  # of anybody's, whether it was obeyed or not
    emergency_age: float  # inf without one
    fix_age: float
    started: float | None  # the mission under way, or interrupted
    sent: int
    steps: int
    states: int


@dataclass(frozen=True, slots=True)
class Cell:
    configuration: Configuration
    event: Event
    chart: Chart
    before: Before
    world: World

    @property
    def line(self) -> Line:
        return self.world.line

    @property
    def sent(self) -> list[Tx]:
        return self.world.sent[self.before.sent :]

    def frames(
        self, start: bytes = b"@", since: int | None = None, until: int | None = None
    ) -> list[Tx]:
        """What left for the STM32, of those that begin so; ``since`` and ``until``, if not the
        event's, count what had left in all."""
        sent = self.world.sent[self.before.sent if since is None else since : until]
        return [t for t in sent if t.link == "vehicle" and t.data.startswith(start)]

    def answers(self, start: bytes) -> list[Tx]:
        """What left for operators."""
        of_operators = ("topside", "modem")
        return [t for t in self.sent if t.link in of_operators and start in t.data]

    @property
    def steps(self) -> list[Step]:
        return self.world.notes.steps[self.before.steps :]

    @property
    def states(self) -> list[str]:
        """Every state that was taken, the first and the last included."""
        return [
            self.configuration.state,
            *(s for _, s in self.world.states[self.before.states :]),
        ]

    @property
    def state(self) -> str:
        return self.world.state

    @property
    def region(self) -> str:
        return self.world.state.partition("/")[0]

    @property
    def leg(self) -> State | None:
        """The active leg when the event began."""
        c = self.configuration
        return self.chart.state(c.leaf) if c.region == "autonomous" else None

    @property
    def ascends(self) -> bool:
        """Whether that leg is of a kind that ascends."""
        leg = None if self.leg is None else self.leg.leg
        return leg is not None and LEGS[type(leg.kind)].ascends


def _emergency_age(world: World) -> float:
    """Since the last X, W or limit led there."""
    begun = [t for t, state in world.states if state in (STOPPED, SURFACING)]
    return world.now - max(begun, default=-math.inf)


def before(world: World) -> Before:
    return Before(
        world.now,
        world.sea.depth,
        world.now - world.last_stick,
        _emergency_age(world),
        world.now - world.last_fix,
        run.started if (run := world.engine.core.run) is not None else None,
        len(world.sent),
        len(world.notes.steps),
        len(world.states),
    )
