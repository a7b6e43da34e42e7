"""The waist of the mission room: what the others hand each other. Types only, no behaviour.

    texts --language--> Mission --compiler--> Chart --machine--> transitions
    Telemetry, Fix --navigation--> Estimate --variables--> Reading --engine--> Step, Setpoint

SI and radians throughout; positions of the home in degrees only inside texts. Every type is
frozen: whoever wants another value makes another object.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field

from protocol.messages import Order, Setpoint

# --- where things stand in a text ---------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Where:
    """A place in a mission text, counted from 1; ``length`` characters are meant."""

    line: int
    column: int
    length: int = 1


NOWHERE = Where(0, 0, 0)


@dataclass(frozen=True, slots=True)
class Problem:
    """What the author must mend: which rule is broken, where, by which words, and what to write
    instead. ``text`` is the offending text, "" where it is not at hand."""

    rule: str  # short and stable: axis-conflict, unknown-target, no-timeout, ...
    where: Where
    text: str
    message: str
    hint: str = ""


# --- guards -------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Comparison:
    """``variable operator bound``, the bound in the variable's SI unit.

    ``sure`` (0..1) asks the estimate's covariance: true only if that share of the distribution
    fulfils the comparison.
    """

    variable: str
    operator: str  # < <= > >=
    bound: float
    sure: float | None = None
    where: Where = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Not:
    operand: Expression


@dataclass(frozen=True, slots=True)
class And:
    operands: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Or:
    operands: tuple[Expression, ...]


Expression = Comparison | Not | And | Or


@dataclass(frozen=True, slots=True)
class Guard:
    """An expression that must hold without a gap for ``held`` seconds (unknown resets it)."""

    expression: Expression
    held: float = 0.0


# --- the mission as its author wrote it ---------------------------------------------------


@dataclass(frozen=True, slots=True)
class Position:
    """Degrees, as texts and charts give it (WGS 84)."""

    latitude_deg: float
    longitude_deg: float


@dataclass(frozen=True, slots=True)
class Local:
    """Metres from home."""

    north: float
    east: float


Place = Position | Local | str  # str: "home"

SURFACE = "surface"  # the name of the implicit leg, reserved
HOME = "home"


class Axis(enum.Enum):
    """What a leg may set or keep. One axis has one holder at a time."""

    HORIZONTAL = "surge and turn"
    HEADING = "heading"
    VERTICAL = "depth, altitude or heave"
    ATTITUDE = "attitude"


@dataclass(frozen=True, slots=True)
class Setting:
    """One word of a leg that sets an axis, as a partial setpoint.

    ``word`` is the setpoint's field: surge, turn, heave, heading, depth, altitude, pitch, roll;
    ``value`` is that field's value (fractions, rad, m). ``stop`` (ZAF0 and the like) is surge 0.
    """

    word: str
    value: float
    where: Where = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Exit:
    """``until guard [-> target]``; no target: the next leg in order."""

    guard: Guard
    target: str | None = None
    where: Where = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Handler:
    """``on guard [held s] -> target`` at mission or group level; the innermost group wins."""

    guard: Guard
    target: str
    where: Where = field(default=NOWHERE, compare=False)


# What a leg does beside holding its settings; one type per leg kind.


@dataclass(frozen=True, slots=True)
class Hold:
    pass


@dataclass(frozen=True, slots=True)
class Wait:
    """Holds whatever is set for ``Leg.duration``, or until an exit."""


@dataclass(frozen=True, slots=True)
class Goto:
    """To a place along the track line from where the leg was entered (line of sight)."""

    place: Place
    within: float  # m, arrival radius


@dataclass(frozen=True, slots=True)
class Follow:
    places: tuple[Place, ...]
    within: float


@dataclass(frozen=True, slots=True)
class Rows:
    """A lawnmower area: ``count`` parallel rows of ``length``, ``spacing`` apart, first along
    ``bearing`` (rad), the others to ``side`` of it (+1 starboard, -1 port), from ``start``."""

    start: Place | None  # None: where the leg is entered
    bearing: float
    length: float
    spacing: float
    count: int
    side: int
    within: float


@dataclass(frozen=True, slots=True)
class Yoyo:
    """Between two depths, ``cycles`` times down and up, while the other axes are held."""

    shallow: float
    deep: float
    cycles: int


@dataclass(frozen=True, slots=True)
class Loiter:
    """A circle of ``radius`` about a place (None: where entered), ``side`` +1 clockwise."""

    place: Place | None
    radius: float
    side: int


@dataclass(frozen=True, slots=True)
class Surface:
    """Ascend as R7 proves it; ends at the surface, or with a fix there (``until_fix``)."""

    until_fix: bool = False


LegKind = Hold | Wait | Goto | Follow | Rows | Yoyo | Loiter | Surface


@dataclass(frozen=True, slots=True)
class Leg:
    """``name`` is unique in its group; generated ones are ``line12``. ``duration`` is ``for``.

    ``timeout_target``/``otherwise`` None: the mission's ``on timeout`` (default surface).
    ``otherwise`` is the leg's ``else``: taken at the timeout, when a Z is refused and when a
    needed reading stays invalid.
    """

    name: str
    kind: LegKind
    settings: tuple[Setting, ...] = ()
    exits: tuple[Exit, ...] = ()
    duration: float | None = None
    timeout: float | None = None
    otherwise: str | None = None
    where: Where = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Set:
    """A bare ZA line: sets and goes on at once."""

    name: str
    settings: tuple[Setting, ...]
    where: Where = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Group:
    """``repeat`` >= 1 rounds of its body; ``handlers`` act while one of its legs is active."""

    name: str
    repeat: int
    body: tuple[Node, ...]
    handlers: tuple[Handler, ...] = ()
    where: Where = field(default=NOWHERE, compare=False)


Node = Leg | Set | Group


@dataclass(frozen=True, slots=True)
class Safety:
    """What the mission itself allows; None: the vehicle's hard limit alone."""

    radius: float | None = None  # m from home
    time: float | None = None  # s autonomous
    depth: float | None = None  # m
    voltage: float | None = None  # V, control battery


@dataclass(frozen=True, slots=True)
class Mission:
    """What both texts say; comments are gone, parameters resolved."""

    name: str
    vehicle: str
    body: tuple[Node, ...]
    home: Position | None = None
    safety: Safety = Safety()
    assume: tuple[tuple[str, float], ...] = ()  # current m/s, ...; sorted by name
    handlers: tuple[Handler, ...] = ()
    on_uncertain: str = SURFACE
    on_timeout: str = SURFACE
    start_without_fix: bool = False
    where: Where = field(default=NOWHERE, compare=False)


# --- the chart: the mission as a hierarchical state machine, plain tables -------------------


@dataclass(frozen=True, slots=True)
class Loop:
    """A condition on a group's round: ``again`` there are rounds left, else it was the last."""

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
    (a goto's heading) is None in it.
    """

    path: str
    parent: str
    leg: Leg | None = None
    setpoint: Setpoint | None = None
    group: Group | None = None


@dataclass(frozen=True, slots=True)
class Edge:
    """One way out of a state; of a state's edges the first that holds is taken, as written.

    ``guard`` None: due by its kind alone (timeout, for, end, else). ``loops`` are all tested;
    an edge that goes through the end of a repeated group stands several times, once per outcome.
    Taking it, a loop with ``again`` counts one round more, one without starts anew at round 1;
    a group that is entered starts at round 1, except by history.

    ``source`` may be a group or ``autonomous`` (its ``on`` handlers, and ``on uncertain``). A
    handler acts when its guard becomes true while a leg below its source is active, except in the
    leg it leads to; when that happens a second time, the implicit leg is entered instead of its
    target. A group that is entered arms its handlers anew. Nothing of the mission leaves the
    implicit leg ``autonomous/surface`` but its own end.
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
    """``states`` hold the mission's tree below ``autonomous``, the implicit leg
    ``autonomous/surface`` last. ``initial`` is the first leg's path. Targets are always legs, but
    for the edge END of the implicit leg, which leads to ``idle/ready``. Edges of one source stand
    in the order in which they are looked at: exits as written, end, for, timeout, else."""

    mission: Mission
    digest: str  # SHA-256 of the canonical text, hex
    states: tuple[State, ...]
    edges: tuple[Edge, ...]
    initial: str
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
        """The edges of one state, in the order in which they are looked at."""
        return self._by_source.get(source, ())


# The regions every mission shares (design: the states).
IDLE_EMPTY, IDLE_READY = "idle/empty", "idle/ready"
AUTONOMOUS = "autonomous"
MANUAL_DRIVING, MANUAL_WAITING = "manual/driving", "manual/waiting"
STOPPED, SURFACING, SURFACED = "emergency/stopped", "emergency/surfacing", "emergency/surfaced"
IMPLICIT_SURFACE = "autonomous/surface"

# --- while it runs -------------------------------------------------------------------------


class NavigationMode(enum.Enum):
    NONE = "none"  # no position known
    FIX = "fix"  # fixes are coming in
    DEAD_RECKONING = "dead reckoning"


@dataclass(frozen=True, slots=True)
class Estimate:
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
    """Something for the vehicle, with the reason that goes on record."""

    command: Setpoint | Order
    reason: str


class Result(enum.Enum):
    """What became of one frame to the vehicle."""

    ACCEPTED = "accepted"  # ACK Y
    REFUSED = "refused"  # ACK N
    LOST = "lost"  # no answer after all tries (R1)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Reported to the engine for every Z frame, in the order they were sent."""

    result: Result
    frame: bytes
    command: Setpoint | Order


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
class AutoNode:
    """The node AUTO was opened or closed (R13)."""

    open: bool


@dataclass(frozen=True, slots=True)
class Restarted:
    """The program starts: ``during`` is what ``Engine.under_way`` said last ("" if nothing was)."""

    during: str


@dataclass(frozen=True, slots=True)
class Health:
    """Whether a sensor can be believed, and if not why (missing, stale, frozen, absurd)."""

    valid: bool
    reason: str
    age: float  # s since the last report, inf if none


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
