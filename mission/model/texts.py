"""The mission as its author wrote it: places in a text, guards, legs, groups."""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

# --- where things stand in a text -----------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Where:
    """A place in a mission text, counted from 1; ``length`` characters are meant."""

    line: int
    column: int
    length: int = 1


NOWHERE = Where(0, 0, 0)


# --- guards ---------------------------------------------------------------------------------------


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

    @property
    def asks(self) -> tuple[str, ...]:
        return (self.variable,)


@dataclass(frozen=True, slots=True)
class Trend:
    """``variable`` falls, or ``rises``, by ``amount`` (SI) within the last ``window`` s, or
    within ``window`` m of the depth that it is at (``of_depth``); infinite: since the leg began."""

    variable: str
    rises: bool
    amount: float
    window: float = math.inf
    of_depth: bool = False
    where: Where = field(default=NOWHERE, compare=False)

    @property
    def asks(self) -> tuple[str, ...]:
        return (self.variable, "depth") if self.of_depth else (self.variable,)


@dataclass(frozen=True, slots=True)
class Back:
    """``variable`` is within so much (SI) of what it was where ``peak`` was ``highest``, or else
    lowest, in the leg before."""

    variable: str
    highest: bool
    peak: str
    within: float
    where: Where = field(default=NOWHERE, compare=False)

    @property
    def asks(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((self.variable, self.peak)))


Term = Comparison | Trend | Back


@dataclass(frozen=True, slots=True)
class Not:
    operand: Expression


@dataclass(frozen=True, slots=True)
class And:
    operands: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Or:
    operands: tuple[Expression, ...]


Expression = Term | Not | And | Or


@dataclass(frozen=True, slots=True)
class Guard:
    """An expression that must hold without a gap for ``held`` seconds (unknown resets it)."""

    expression: Expression
    held: float = 0.0


def terms(expression: Expression) -> Iterator[Term]:
    """What is joined by and, or, not; as written, from left to right."""
    stack = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Not):
            stack.append(node.operand)
        elif isinstance(node, And | Or):
            stack.extend(reversed(node.operands))
        else:
            yield node


# --- the mission as its author wrote it -----------------------------------------------------------


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

    HORIZONTAL = "gear and turn (left, right)"
    HEADING = "heading"
    VERTICAL = "depth, altitude, up or down"
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
class OutputSetting:
    """``output name value``: an output of the vehicle file, in its unit there. They stand sorted
    by name."""

    name: str
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


# What rows are flown for: coverage (share), position (m); sorted by name.
Aims = tuple[tuple[str, float], ...]


class LegKind:
    """What a leg does beside holding its settings: a frozen dataclass in its leg type's own file
    (mission.legs)."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Leg:
    """``name`` is unique in its group; generated ones are ``line12``. ``duration`` is ``for``.

    ``otherwise`` is the leg's ``else``: taken at the timeout, when a Z is refused and when a
    needed reading stays invalid; None: the mission's ``on timeout`` (default surface).
    """

    name: str
    kind: LegKind
    settings: tuple[Setting, ...] = ()
    exits: tuple[Exit, ...] = ()
    duration: float | None = None
    timeout: float | None = None
    otherwise: str | None = None
    where: Where = field(default=NOWHERE, compare=False)
    outputs: tuple[OutputSetting, ...] = ()
    achieve: Aims = ()


@dataclass(frozen=True, slots=True)
class Set:
    """A bare ZA line: sets and goes on at once."""

    name: str
    settings: tuple[Setting, ...]
    where: Where = field(default=NOWHERE, compare=False)
    outputs: tuple[OutputSetting, ...] = ()


@dataclass(frozen=True, slots=True)
class Group:
    """``repeat`` >= 1 rounds of its body; ``handlers`` act while one of its legs is active."""

    name: str
    repeat: int
    body: tuple[Node, ...]
    handlers: tuple[Handler, ...] = ()
    where: Where = field(default=NOWHERE, compare=False)
    achieve: Aims = ()


Node = Leg | Set | Group


def legs_of(body: Iterable[Node]) -> Iterator[Leg]:
    """In their order, those of the groups too."""
    for node in body:
        if isinstance(node, Leg):
            yield node
        elif isinstance(node, Group):
            yield from legs_of(node.body)


def aims_of(
    body: Iterable[Node], above: Aims, path: str = ""
) -> Iterator[tuple[str, Leg, dict[str, float]]]:
    """Each leg with its path and what it is to achieve: what it says itself, else the groups
    around it, the innermost first, else ``above``."""
    for node in body:
        if isinstance(node, Leg):
            yield path + node.name, node, dict(above) | dict(node.achieve)
        elif isinstance(node, Group):
            inner = tuple((dict(above) | dict(node.achieve)).items())
            yield from aims_of(node.body, inner, f"{path}{node.name}/")


@dataclass(frozen=True, slots=True)
class Safety:
    """What the mission itself allows; None: the vehicle's hard limit alone."""

    radius: float | None = None  # m from home
    time: float | None = None  # s autonomous
    depth: float | None = None  # m
    voltage: float | None = None  # V, control battery


@dataclass(frozen=True, slots=True)
class Area:
    """What a mission keeps in, or out of (``out``): a polygon. It counts between two depths, m."""

    name: str
    out: bool
    corners: tuple[Place, ...]
    top: float = 0.0
    bottom: float = math.inf
    where: Where = field(default=NOWHERE, compare=False)

    @property
    def limited(self) -> bool:
        return self.bottom < math.inf

    def counts_at(self, depth: float | None) -> bool:
        """An unknown depth may be any; one that is less than 0 is a sensor's word for the
        surface."""
        return depth is None or self.top <= max(depth, 0.0) <= self.bottom

    def counts_between(self, shallow: float, deep: float) -> bool:
        return self.top <= max(deep, 0.0) and shallow <= self.bottom

    def counts_throughout(self, shallow: float, deep: float) -> bool:
        return self.counts_at(shallow) and self.counts_at(deep)


NEVER_BELOW = "never below"  # a depth with an altitude, one setting
START_WITHIN = 25.0  # m from home, unless the mission assumes another start


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
    achieve: Aims = ()
    areas: tuple[Area, ...] = ()

    def start_within(self, sigma: float) -> float:
        """m from home: where it is started at most, as the check assumes and the start demands; no
        nearer than fixes of one ``sigma`` (m) can tell."""
        return max(dict(self.assume).get("start", START_WITHIN), 2.0 * sigma)

    def floor(self, allowed: float) -> float:
        """m: the deepest sea floor that it assumes; ``allowed`` is the depth allowed, which stands
        in where it says nothing of it."""
        return dict(self.assume).get("floor", allowed)

    def current(self, usual: float) -> float:
        """m/s: the greatest current that it assumes; ``usual`` where it says nothing of it."""
        return dict(self.assume).get("current", usual)
