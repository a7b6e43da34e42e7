"""What a law judges: a configuration, an event, and what was seen.

What does not live here: how they come about (configurations, events), what is right (laws).
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
    """``leaf``: the active or the interrupted leg. ``auto``: node AUTO is open. ``loaded``: a
    mission is stored. ``preceded``: there was an emergency since idle. ``quiet``: no Z is
    outstanding."""

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
    """``play`` makes the event happen and lets some time pass.

    ``command``: the frame type of an operator's command; ``path``: how it comes (boat, the
    commander; tender; modem). ``limit``: the row of R5 and R8 that is breached. ``sensor``: its
    readings cannot be believed from ``after`` s on. ``also``: further causes of an effect.
    ``needs``: what a vehicle must have for this event (lines). ``word``: the M that is sent."""

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
    stick_age: float  # s since anyone's last M, obeyed or not
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
        """Return what left for the vehicle and begins with ``start``. ``since`` and ``until`` are
        counts of all that had left; by default, from the event on."""
        sent = self.world.sent[self.before.sent if since is None else since : until]
        return [t for t in sent if t.link == "vehicle" and t.data.startswith(start)]

    def answers(self, start: bytes) -> list[Tx]:
        """Return what left for operators and contains ``start``."""
        of_operators = ("topside", "modem")
        return [t for t in self.sent if t.link in of_operators and start in t.data]

    @property
    def steps(self) -> list[Step]:
        return self.world.notes.steps[self.before.steps :]

    @property
    def states(self) -> list[str]:
        """All states since the event began, the first and the last included."""
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
        """The leg that was active when the event began."""
        c = self.configuration
        return self.chart.state(c.leaf) if c.region == "autonomous" else None

    @property
    def ascends(self) -> bool:
        """Whether the leg that was active is of a kind that ascends."""
        leg = None if self.leg is None else self.leg.leg
        return leg is not None and LEGS[type(leg.kind)].ascends


def _emergency_age(world: World) -> float:
    """Return the s since the last X, W or limit led to an emergency; inf without one."""
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
