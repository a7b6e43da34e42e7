"""Missions out of hypothesis, in the normal form that reading a text yields.

A strategy is made once: hypothesis looks through each new one before it draws from it, which takes
ten times as long as drawing.
"""

from __future__ import annotations

import functools
import itertools
import math

from hypothesis import strategies as st

from mission.authoring.language.canonical import numbered
from mission.authoring.language.words import FIELD_ORDER, LIMITS
from mission.engine.variables import VARIABLES, Variable
from mission.legs import Follow, Goto, Hold, Loiter, Rows, Surface, Wait, Yoyo
from mission.model import (
    Aims,
    And,
    Area,
    Back,
    Comparison,
    Exit,
    Expression,
    Group,
    Guard,
    Handler,
    Leg,
    LegKind,
    Local,
    Mission,
    Node,
    Not,
    Or,
    Place,
    Position,
    Safety,
    Set,
    Setting,
    Trend,
)
from mission.model.units import GEARS, compass

# Names that are words of the language, or of YAML, on purpose.
NAMES = (
    "dive",
    "rows",
    "turn",
    "on",
    "yes",
    "null",
    "until",
    "end",
    "up",
    "a-b",
    "x_1",
    "ZAF6",
    "home",
)


@functools.cache
def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.one_of(
        st.integers(math.ceil(low), math.floor(high)).map(float),
        st.floats(low, high, allow_subnormal=False).map(lambda x: x + 0.0),
    )


seconds = st.one_of(st.integers(1, 7200).map(float), st.floats(0.1, 1e5))
headings = st.one_of(st.integers(0, 359), st.floats(0, 359.99)).map(compass)
aims: st.SearchStrategy[Aims] = st.builds(
    lambda found: tuple(sorted(found.items())),
    st.fixed_dictionaries(
        {}, optional={"coverage": numbers(1e-6, 1.0), "position": numbers(1e-6, 20000)}
    ),
)
positions = st.builds(Position, numbers(-90, 90), numbers(-180, 180))
locals_ = st.builds(Local, numbers(-20000, 20000), numbers(-20000, 20000))
places: st.SearchStrategy[Place] = st.one_of(st.just("home"), positions, locals_)


coins = st.booleans()
tenths = st.integers(0, 9)
gears = st.integers(-GEARS, GEARS).map(lambda n: n / GEARS)
gears_ahead = st.integers(1, GEARS).map(lambda n: n / GEARS)
variables = st.sampled_from(list(VARIABLES.values()))
operators = st.sampled_from(["<", "<=", ">", ">="])
sureness = st.one_of(st.none(), st.integers(1, 99).map(lambda p: p / 100), st.floats(0.01, 0.99))


@st.composite
def comparisons(draw: st.DrawFn) -> Comparison:
    row = draw(variables)
    bound = draw(headings) if row.circular else draw(numbers(-1000, 1000))
    if row.unit == "deg" and not row.circular:
        bound = math.radians(bound)
    return Comparison(row.name, draw(operators), bound, draw(sureness))


steady = st.sampled_from([v for v in VARIABLES.values() if not (v.circular or v.timed)])
returning = st.sampled_from([v for v in VARIABLES.values() if not v.timed])


@functools.cache
def windows(of_depth: bool) -> st.SearchStrategy[tuple[float, bool]]:
    """Lengths in s, or in m of depth where ``of_depth`` allows them."""
    return st.one_of(
        st.just((math.inf, False)),
        st.tuples(numbers(2, 3600), st.just(False)),
        st.tuples(numbers(0.5, 1000), st.just(of_depth)),
    )


@functools.cache
def differences(row: Variable) -> st.SearchStrategy[float]:
    return numbers(1e-3, 150).map(math.radians if row.unit == "deg" else float)


@st.composite
def trends(draw: st.DrawFn) -> Trend:
    row, rises = draw(steady), draw(coins)
    amount = draw(differences(row))
    window, of_depth = draw(windows(row.name != "depth"))
    return Trend(row.name, rises, amount, max(window, 2.0), of_depth)


@st.composite
def backs(draw: st.DrawFn) -> Back:
    row, peak = draw(returning), draw(steady)
    return Back(row.name, draw(coins), peak.name, draw(differences(row)))


def _joined(kind: type[And] | type[Or], operands: list[Expression]) -> Expression:
    flat: list[Expression] = []
    for operand in operands:
        flat.extend(operand.operands if isinstance(operand, kind) else [operand])
    return kind(tuple(flat))


def _combined(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    several = st.lists(inner, min_size=2, max_size=3)
    return st.one_of(
        inner.map(Not),
        several.map(lambda o: _joined(And, o)),
        several.map(lambda o: _joined(Or, o)),
    )


expressions: st.SearchStrategy[Expression] = st.recursive(
    st.one_of(comparisons(), trends(), backs()), _combined, max_leaves=4
)
guards = st.builds(Guard, expressions, st.one_of(st.just(0.0), seconds))
waits = st.one_of(st.none(), seconds)
verticals = st.sampled_from(["", "depth", "altitude", "heave"])
horizontals = st.sampled_from(["", "heading", "turn"])


@st.composite
def settings_of(
    draw: st.DrawFn, vertical: bool = True, steering: bool = True
) -> tuple[Setting, ...]:
    chosen: dict[str, float] = {}
    if vertical:
        word = draw(verticals)
        if word:
            chosen[word] = draw(gears if word == "heave" else numbers(0, 9999))
        if word == "depth" and draw(coins):
            chosen["altitude"] = draw(numbers(0, 9999))
    if steering:
        word = draw(horizontals)
        if word:
            chosen[word] = draw(gears if word == "turn" else headings)
    if draw(coins):
        chosen["surge"] = draw(gears if steering else gears_ahead)
    for word in ("pitch", "roll"):
        if draw(tenths) == 0:
            chosen[word] = math.radians(draw(numbers(-90, 90)))
    return tuple(Setting(w, chosen[w]) for w in FIELD_ORDER if w in chosen)


sides = st.sampled_from([-1, 1])
somewhere = st.one_of(st.none(), places)
within = numbers(0.5, 1000)
kinds: st.SearchStrategy[LegKind] = st.one_of(
    st.just(Hold()),
    st.just(Wait()),
    st.builds(Goto, places, within),
    st.lists(places, min_size=2, max_size=9)
    .filter(lambda p: all(a != b for a, b in itertools.pairwise(p)))
    .map(lambda p: Follow(tuple(p), 10.0)),
    st.builds(
        Rows, somewhere, headings, numbers(1, 20000), numbers(0.5, 2000),
        st.integers(1, 99), sides, within,
    ),
    st.builds(Yoyo, numbers(0, 4999), numbers(5000, 9999), st.integers(1, 99)),
    st.builds(Loiter, somewhere, numbers(1, 5000), sides),
    st.builds(Surface, st.booleans()),
)  # fmt: skip
Targets = tuple[str, ...]


@functools.cache
def ends(targets: Targets) -> st.SearchStrategy[str | None]:
    return st.one_of(st.none(), st.sampled_from(targets))


@functools.cache
def exits(targets: Targets) -> st.SearchStrategy[list[Exit]]:
    return st.lists(st.builds(Exit, guards, ends(targets)), max_size=2)


@functools.cache
def handlers(targets: Targets, most: int) -> st.SearchStrategy[list[Handler]]:
    return st.lists(st.builds(Handler, guards, st.sampled_from(targets)), max_size=most)


@st.composite
def legs(draw: st.DrawFn, name: str, targets: Targets) -> Node:
    """``name`` empty: a leg without one, or a bare line."""
    kind = draw(kinds)
    steered = not isinstance(kind, Hold | Yoyo)
    settings: tuple[Setting, ...] = ()
    if not isinstance(kind, Wait | Surface):
        settings = draw(settings_of(vertical=not isinstance(kind, Yoyo), steering=not steered))
    if not name and isinstance(kind, Hold) and settings and draw(coins):
        return Set("", settings)
    return Leg(
        name,
        kind,
        settings,
        tuple(draw(exits(targets))),
        draw(seconds) if isinstance(kind, Wait) or draw(coins) else None,
        draw(waits),
        draw(ends(targets)),
        achieve=draw(aims) if isinstance(kind, Rows) else (),
    )


def _ordered(found: list[Area]) -> tuple[Area, ...]:
    return tuple(sorted(found, key=lambda area: (area.out, area.name)))


_corners = st.lists(places, min_size=3, max_size=12).map(tuple)
_depths = st.sampled_from([(0.0, math.inf), (4.0, 12.5), (0.0, 3.0)])
areas = st.lists(
    st.builds(
        lambda name, out, corners, depths: Area(name, out, corners, *depths),
        st.sampled_from(["harbour", "wreck", "cable-1", "no"]),
        st.booleans(),
        _corners,
        _depths,
    ),
    max_size=3,
    unique_by=lambda area: area.name,
).map(_ordered)


namings = st.lists(st.sampled_from(NAMES), min_size=1, max_size=2, unique=True)
thirds = st.integers(0, 2)
rounds = st.sampled_from([1, 2, 9999])


@st.composite
def bodies(draw: st.DrawFn, depth: int, outer: Targets) -> tuple[Node, ...]:
    names = draw(namings)
    targets = (*outer, *names)
    nodes: list[Node] = []
    for name in names:
        if depth and draw(thirds) == 0:
            body = draw(bodies(depth - 1, targets))
            handled = tuple(draw(handlers(targets, 1)))
            nodes.append(Group(name, draw(rounds), body, handled, achieve=draw(aims)))
        else:
            nodes.append(draw(legs(name, targets)))
        if draw(coins):
            nodes.append(draw(legs("", targets)))
    return (*nodes, Leg("last", Wait(), (), (), draw(seconds)))


ENDS = ("surface", "last")
titles = st.sampled_from(["m", "harbour-survey", "x_1", "no"])
bounds = st.one_of(st.none(), numbers(1e-6, 65535))
homes = st.one_of(st.none(), positions)
last = st.sampled_from(ENDS)
assumptions: st.SearchStrategy[tuple[tuple[str, float], ...]] = st.sampled_from(
    [(), (("current", 0.2),), (("current", 0.0), ("floor", 30.5))]
)


@st.composite
def missions(draw: st.DrawFn) -> Mission:
    limits = {row.name: draw(bounds) for row in LIMITS.values()}
    mission = Mission(
        name=draw(titles),
        vehicle="auv",
        body=draw(bodies(2, ENDS)),
        home=draw(homes),
        safety=Safety(**limits),
        assume=draw(assumptions),
        handlers=tuple(draw(handlers(ENDS, 2))),
        on_uncertain=draw(last),
        on_timeout=draw(last),
        start_without_fix=draw(coins),
        achieve=draw(aims),
        areas=draw(areas),
    )
    return numbered(mission)
