"""The mission as its author wrote it: places in a text, guards, legs, groups."""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

# --- where things stand in a text -----------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Where:
    """A place in a mission text, counted from 1, and the ``length`` of what is meant."""

    line: int
    column: int
    length: int = 1


NOWHERE = Where(0, 0, 0)


# --- guards ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Comparison:
    """``variable operator bound``, the bound in the variable's SI unit.

    ``sure`` (0..1) uses the estimate's covariance: the comparison is true only if that share of the
    distribution fulfils it.
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
    within ``window`` m of the present depth (``of_depth``); infinite: since the leg began."""

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
    """``variable`` is ``within`` so much (SI) of its value at the point of the leg before where
    ``peak`` was ``highest``, or else lowest."""

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
    """An expression that must hold for ``held`` seconds. A second in which it is false takes back
    two; while it is unknown, all is lost."""

    expression: Expression
    held: float = 0.0


def terms(expression: Expression) -> Iterator[Term]:
    """Yield the terms that and, or, not join, from left to right as written."""
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
    """What a leg may set or keep. Only one setting holds an axis at a time."""

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
    """``output name value``: an output of the vehicle file, in its unit there. A leg has them
    sorted by name."""

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
    """What a leg does besides holding its settings: a frozen dataclass in the file of its leg type
    (mission.legs)."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Leg:
    """``name`` is unique in its group; a generated name is ``line12``. ``duration`` is ``for``.

    ``otherwise`` is the leg's ``else``. It is taken at the timeout, when a Z is refused, and when a
    needed reading stays invalid. None: the mission's ``on timeout`` (default surface).
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
    """A bare ZA line: it sets, and the mission continues at once."""

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
    """Yield all legs in order, those of groups too."""
    for node in body:
        if isinstance(node, Leg):
            yield node
        elif isinstance(node, Group):
            yield from legs_of(node.body)


def aims_of(
    body: Iterable[Node], above: Aims, path: str = ""
) -> Iterator[tuple[str, Leg, dict[str, float]]]:
    """Yield each leg with its path and its aims: its own, else those of the groups around it, the
    innermost first, else ``above``."""
    for node in body:
        if isinstance(node, Leg):
            yield path + node.name, node, dict(above) | dict(node.achieve)
        elif isinstance(node, Group):
            inner = tuple((dict(above) | dict(node.achieve)).items())
            yield from aims_of(node.body, inner, f"{path}{node.name}/")


@dataclass(frozen=True, slots=True)
class Safety:
    """The mission's own limits; None: only the vehicle's hard limit."""

    radius: float | None = None  # m from home
    time: float | None = None  # s autonomous
    depth: float | None = None  # m
    voltage: float | None = None  # V, control battery


@dataclass(frozen=True, slots=True)
class Area:
    """A polygon that a mission stays in, or out of (``out``). It counts between two depths, m."""

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
        """Whether it counts at a depth. An unknown depth may be any; one of less than 0 is how a
        sensor reports the surface."""
        return depth is None or self.top <= max(depth, 0.0) <= self.bottom

    def counts_between(self, shallow: float, deep: float) -> bool:
        return self.top <= max(deep, 0.0) and shallow <= self.bottom

    def counts_throughout(self, shallow: float, deep: float) -> bool:
        return self.counts_at(shallow) and self.counts_at(deep)


NEVER_BELOW = "never below"  # a depth with an altitude, one setting
START_WITHIN = 25.0  # m from home, unless the mission assumes another start


@dataclass(frozen=True, slots=True)
class Mission:
    """A mission as read from either text, without comments and with parameters resolved."""

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
        """m from home: the greatest distance at the start, as the check assumes and the start
        requires. It is not less than fixes of one ``sigma`` (m) can resolve."""
        return max(dict(self.assume).get("start", START_WITHIN), 2.0 * sigma)

    def floor(self, allowed: float) -> float:
        """m: the deepest sea floor that it assumes, else ``allowed``, the depth that is allowed."""
        return dict(self.assume).get("floor", allowed)

    def current(self, usual: float) -> float:
        """m/s: the greatest current that it assumes, else ``usual``."""
        return dict(self.assume).get("current", usual)
