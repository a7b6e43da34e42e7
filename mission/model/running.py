"""Types of a mission that runs: estimate, readings, steps, outcomes."""

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
        """Whether it has a position, in finite numbers: NaN would exceed no limit."""
        told = self.north + self.east + sum(self.covariance)
        return self.mode is not NavigationMode.NONE and math.isfinite(told)


@dataclass(frozen=True, slots=True)
class Reading:
    """What a guard sees of one variable. If it is not ``valid``, a comparison is unknown."""

    value: float
    sigma: float
    age: float  # s
    valid: bool
    reason: str = ""  # why not valid: stale, missing, frozen, absurd, contradicted


@dataclass(frozen=True, slots=True)
class Evaluation:
    """A guard that was evaluated and decided something, with the values it saw."""

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
    actions: tuple[str, ...]  # in words; every command that is sent has one
    trigger: str = ""  # the edge that was taken
    by: By | None = None  # why, where a leg was left


@dataclass(frozen=True, slots=True)
class Action:
    """A command for the vehicle, with the reason for the record. ``steers``: a set that differs a
    little from the one in force, so that nothing must be cleared before it."""

    command: Setpoint | Order | Outputs
    reason: str
    steers: bool = False


class Result(enum.Enum):
    """What became of one frame to the vehicle."""

    ACCEPTED = "accepted"  # ACK Y
    REFUSED = "refused"  # ACK N
    LOST = "lost"  # no answer after all tries (R1)
    LATE = "late"  # a part of a set was not sent in time


@dataclass(frozen=True, slots=True)
class Outcome:
    """Reported to the engine for every Z frame, in the order in which they were sent. A frame that
    is LATE may still be sent."""

    result: Result
    frame: bytes
    command: Setpoint | Order | Outputs


@dataclass(frozen=True, slots=True)
class Verdict:
    """The engine's answer to an operator's command; ``why`` is shown to the operator."""

    accepted: bool
    why: str = ""


@dataclass(frozen=True, slots=True)
class Loaded:
    """The store holds this mission (None: none). With this the engine can start it."""

    chart: Chart | None


@dataclass(frozen=True, slots=True)
class LineOpened:
    """The vehicle's port is open again. Meanwhile another device may have been on it, and may have
    acknowledged commands that the vehicle never received."""


@dataclass(frozen=True, slots=True)
class AutoNode:
    """The node AUTO was opened or closed (R13)."""

    open: bool


@dataclass(frozen=True, slots=True)
class Restarted:
    """The program starts. ``during`` is the last ``Engine.under_way`` ("" if nothing was under way,
    UNKNOWN if the store cannot tell)."""

    during: str


UNKNOWN = "something that the store does not tell"


@dataclass(frozen=True, slots=True)
class Ending:
    """The program has to end in order, with the vehicle up first. ``now``: no time is left."""

    now: bool = False


CONTRADICTED = "contradicted"  # such a reason begins with it
NEARS_GROUND = "the ground comes nearer"  # in one of them: the vehicle sinks, by the altimeter


class Health(NamedTuple):
    """Whether a sensor is believed, and if not why (missing, stale, frozen, absurd, contradicted).
    ``moves``: it is contradicted, but its changes can be believed. A tuple, because several are
    made for every report."""

    valid: bool
    reason: str
    age: float  # s since the last report, inf if none
    moves: bool = False


class Vertical(NamedTuple):
    """What moves the vehicle up and down. ``down``: share of full thrust that its vertical
    thrusters report, downward positive (None: not reported). ``asked``: the depth of the set in
    force, m (infinite: as deep, or as high, as possible; None: none)."""

    down: float | None
    asked: float | None


@dataclass(frozen=True, slots=True)
class Tx:
    """Bytes to send, and why. ``address`` picks the peer if a link has several."""

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
