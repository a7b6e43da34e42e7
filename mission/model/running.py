"""What is handed about while a mission runs: estimate, readings, steps, what came of them."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from mission.model.chart import By, Chart
from protocol.messages import Order, Outputs, Setpoint


class NavigationMode(enum.Enum):
    NONE = "none"  # no position known
    FIX = "fix"  # fixes are coming in
    DEAD_RECKONING = "dead reckoning"


class Estimate(NamedTuple):
    """Where the vehicle is, in metres north and east of the origin, and how sure that is.

    ``covariance`` is the 2 x 2 of (north, east) as (nn, ne, ee), m^2. ``sigmas`` are standard
    deviations by variable name, for everything that is not a position. ``nis`` is the normalised
    innovation squared of the last update with its degrees of freedom.
    """

    t: float
    north: float
    east: float
    depth: float | None
    depth_rate: float | None
    altitude: float | None
    heading: float | None  # true, rad
    speed: float  # through the water, m/s
    current_north: float
    current_east: float
    covariance: tuple[float, float, float]
    sigmas: Mapping[str, float]
    nis: tuple[float, int] | None
    fix_age: float | None
    mode: NavigationMode

    @property
    def located(self) -> bool:
        """It says a position, and of numbers: what is none would be beyond no limit."""
        told = self.north + self.east + sum(self.covariance)
        return self.mode is not NavigationMode.NONE and math.isfinite(told)


@dataclass(frozen=True, slots=True)
class Reading:
    """What a guard sees of one variable. Not ``valid``: a comparison with it is unknown."""

    value: float
    sigma: float
    age: float  # s
    valid: bool
    reason: str = ""  # why not valid: stale, missing, frozen, absurd


@dataclass(frozen=True, slots=True)
class Evaluation:
    """A guard that was looked at and decided something, with the values it saw."""

    trigger: str
    result: bool | None
    values: tuple[tuple[str, float | None], ...]


@dataclass(frozen=True, slots=True)
class Step:
    """One transition, or one decision without a transition (``trigger`` is "")."""

    t: float
    event: str  # what came in: telemetry, fix, timer, operator X, ack N, ...
    evaluations: tuple[Evaluation, ...]
    exited: tuple[str, ...]
    entered: tuple[str, ...]
    actions: tuple[str, ...]  # in words; every command that leaves has one
    trigger: str = ""  # the edge that was taken
    by: By | None = None  # why, where a leg was left


@dataclass(frozen=True, slots=True)
class Action:
    """Something for the vehicle, with the reason that goes on record. ``steers``: a set
    that differs a little from the one in force, so that nothing need be cleared before."""

    command: Setpoint | Order | Outputs
    reason: str
    steers: bool = False


class Result(enum.Enum):
    """What became of one frame to the vehicle."""

    ACCEPTED = "accepted"  # ACK Y
    REFUSED = "refused"  # ACK N
    LOST = "lost"  # no answer after all tries (R1)
    LATE = "late"  # a set of which something has not left in time


@dataclass(frozen=True, slots=True)
class Outcome:
    """Reported to the engine for every Z frame, in the order they were sent; a frame that is
    LATE may be sent yet."""

    result: Result
    frame: bytes
    command: Setpoint | Order | Outputs


@dataclass(frozen=True, slots=True)
class Verdict:
    """The engine's answer to an operator's command; ``why`` is for the operator's eyes."""

    accepted: bool
    why: str = ""


@dataclass(frozen=True, slots=True)
class Loaded:
    """The store holds this mission (None: none); told to the engine, which then can start it."""

    chart: Chart | None


@dataclass(frozen=True, slots=True)
class LineOpened:
    """The vehicle's port is open again. Meanwhile something else may have been on it, and may have
    acknowledged what the vehicle never heard."""


@dataclass(frozen=True, slots=True)
class AutoNode:
    """The node AUTO was opened or closed (R13)."""

    open: bool


@dataclass(frozen=True, slots=True)
class Restarted:
    """The program starts: ``during`` is what ``Engine.under_way`` said last ("" if nothing was,
    UNKNOWN where the store cannot tell)."""

    during: str


UNKNOWN = "something that the store does not tell"


@dataclass(frozen=True, slots=True)
class Ending:
    """The program is to end, in order: up first. ``now``: it has no more time for that."""

    now: bool = False


CONTRADICTED = "contradicted"  # how such a reason begins
NEARS_GROUND = "the ground comes nearer"  # what one of them says: it sinks, by the altimeter


class Health(NamedTuple):
    """Whether a sensor can be believed, and if not why (missing, stale, frozen, absurd,
    contradicted). ``moves``: it is contradicted, but what it changes by can be believed. A tuple,
    because some are made for every report."""

    valid: bool
    reason: str
    age: float  # s since the last report, inf if none
    moves: bool = False


class Vertical(NamedTuple):
    """What moves the vehicle up and down: ``down`` is the share of full thrust that its verticals
    report, downward positive (None: they do not), ``asked`` the depth that the set in force asks
    for in m (infinite: as deep, or as high, as it goes; None: none)."""

    down: float | None
    asked: float | None


@dataclass(frozen=True, slots=True)
class Tx:
    """Bytes that leave, and why. ``address`` picks the peer where a link has several."""

    t: float
    link: str
    data: bytes
    reason: str
    address: str = ""


@dataclass(frozen=True, slots=True)
class Record:
    """One entry of the black box."""

    t: float
    kind: str
    payload: bytes
