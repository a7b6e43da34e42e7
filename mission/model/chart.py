"""The chart: the mission as a hierarchical state machine, plain tables."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

from mission.model.texts import NOWHERE, Group, Guard, Leg, Mission, Where
from protocol.messages import Setpoint
from protocol.vehicles.channels import Source


@dataclass(frozen=True, slots=True)
class Loop:
    """A condition on a group's round. ``again``: rounds are left; else it was the last."""

    group: str  # path
    again: bool


class By(enum.Enum):
    """Why a leg was left."""

    UNTIL = "until"
    FOR = "for"
    TIMEOUT = "timeout"
    ELSE = "else"  # Z refused, or a needed reading stayed invalid
    ON = "on"
    UNCERTAIN = "uncertain"
    OPERATOR = "operator"
    LIMIT = "limit"
    END = "end"  # the leg did what it is for (goto arrived, surface reached, yoyo done)


@dataclass(frozen=True, slots=True)
class State:
    """A node of the mission's tree. ``path`` is ``autonomous/rows/out``; parents come first.

    ``setpoint`` is a leg's complete set (None for groups); an axis that the leg's kind steers
    (a goto's heading) is None in it. ``outputs`` are all outputs that the mission names anywhere,
    each with its value in this leg.
    """

    path: str
    parent: str
    leg: Leg | None = None
    setpoint: Setpoint | None = None
    group: Group | None = None
    outputs: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Edge:
    """One way out of a state. Of a state's edges the first that holds is taken, as written.

    ``guard`` None: the edge's kind alone decides (timeout, for, end, else). ``loops`` are all
    tested. An edge through the end of a repeated group exists several times, once per outcome. When
    it is taken, a loop with ``again`` counts one more round; one without starts again at round 1.
    A group that is entered starts at round 1, except by history.

    ``source`` may be a group or ``autonomous`` (its ``on`` handlers, and ``on uncertain``). A
    handler acts when its guard becomes true while a leg below its source is active, except in the
    leg it leads to. When that happens a second time, the implicit leg is entered instead of its
    target. A group that is entered arms its handlers again. Within the mission, only its own end
    leaves the implicit leg ``autonomous/surface``.
    """

    trigger: str  # unique
    source: str
    target: str
    by: By
    guard: Guard | None = None
    loops: tuple[Loop, ...] = ()
    where: Where = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Chart:
    """A compiled mission. ``states`` hold its tree below ``autonomous``, the implicit leg
    ``autonomous/surface`` last. ``initial`` is the first leg's path. Targets are always legs,
    except that the edge END of the implicit leg leads to ``idle/ready``. Edges of one source are in
    the order in which they are tested: exits as written, end, for, timeout, else."""

    mission: Mission
    digest: str  # SHA-256 of the canonical text, hex
    states: tuple[State, ...]
    edges: tuple[Edge, ...]
    initial: str
    sources: tuple[tuple[str, Source], ...] = ()  # of the vehicle's readings, by name
    _by_path: dict[str, State] = field(init=False, repr=False, compare=False)
    _by_source: dict[str, tuple[Edge, ...]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        leaving: dict[str, list[Edge]] = {}
        for edge in self.edges:
            leaving.setdefault(edge.source, []).append(edge)
        object.__setattr__(self, "_by_path", {s.path: s for s in self.states})
        object.__setattr__(self, "_by_source", {k: tuple(v) for k, v in leaving.items()})

    def state(self, path: str) -> State:
        return self._by_path[path]

    def leaving(self, source: str) -> tuple[Edge, ...]:
        """Return the edges of one state, in the order in which they are tested."""
        return self._by_source.get(source, ())


# The regions every mission shares (design: the states).
IDLE_EMPTY, IDLE_READY = "idle/empty", "idle/ready"
AUTONOMOUS = "autonomous"
MANUAL_DRIVING, MANUAL_WAITING = "manual/driving", "manual/waiting"
STOPPED, SURFACING, SURFACED = "emergency/stopped", "emergency/surfacing", "emergency/surfaced"
IMPLICIT_SURFACE = "autonomous/surface"
