"""Refuse guards on a direction (heading, course, bearing) that a reader takes for another sector.

Each comparison of a direction uses the shorter way: ``heading > 350`` is the half turn clockwise of
350, so ``heading > 350 or heading < 10`` is all but the 20 degrees behind. A guard is refused if it
means another sector than its numbers suggest on a scale from 0 to 360.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from mission.authoring.compiler.refusing import refused
from mission.engine.variables import VARIABLES
from mission.model import And, Comparison, Expression, Not, Or, Where
from mission.model.diagnostics import Diagnostic

_TURN = 2.0 * math.pi
_Join = Callable[[Iterable[bool]], bool]
_OTHER: dict[_Join, tuple[_Join, str, str]] = {all: (any, "and", "or"), any: (all, "or", "and")}


def direction_problems(expression: Expression, where: Where) -> Iterator[Diagnostic]:
    if isinstance(expression, Not):
        yield from direction_problems(expression.operand, where)
    elif isinstance(expression, And | Or):
        for part in expression.operands:
            yield from direction_problems(part, where)
        join: _Join = all if isinstance(expression, And) else any
        compared = [t for t in expression.operands if isinstance(t, Comparison) and t.sure is None]
        for name in dict.fromkeys(term.variable for term in compared):
            row = VARIABLES.get(name)
            if row is not None and row.circular:
                of_it = [term for term in compared if term.variable == name]
                if len(of_it) > 1:  # one alone tells when a turn has passed its bound
                    yield from _read_otherwise(join, of_it, where)


def _read_otherwise(join: _Join, of_it: Sequence[Comparison], where: Where) -> Iterator[Diagnostic]:
    """Refuse comparisons of one variable if the two meanings differ. If they are true nowhere or
    everywhere on the scale from 0 to 360 (350 to 10), the author can only mean the shorter way."""
    said, meant = _sector(join, of_it, round_=False), _sector(join, of_it, round_=True)
    if said == meant or not any(said) or all(said):
        return
    name, place = of_it[0].variable, of_it[0].where
    other, word, better = _OTHER[join]
    hint = (
        f"write a sector as {name} > 350 and {name} < 10, all but it as {name} > 10 or {name} < 350"
    )
    if _sector(other, of_it, round_=True) == said:
        hint = f"write {better} for {word}"
    yield refused(
        "goes-round",
        place if place.line else where,
        f"{name} goes round: each comparison is true in the half turn beside its bound, "
        f"so with {word!r} these are not the sector that their numbers say",
        hint,
    )


def _sector(join: _Join, of_it: Iterable[Comparison], round_: bool) -> list[bool]:
    """The joined value of the comparisons in each interval between angles where one changes."""
    terms = list(of_it)
    bounds = {term.bound % _TURN for term in terms}
    edges = sorted({0.0, _TURN, *bounds, *((bound + math.pi) % _TURN for bound in bounds)})
    between = [(low + high) / 2.0 for low, high in itertools.pairwise(edges)]
    return [join(_is_true(term, angle, round_) for term in terms) for angle in between]


def _is_true(term: Comparison, angle: float, round_: bool) -> bool:
    off = angle - term.bound
    if round_:
        off = math.remainder(off, _TURN)
    return off > 0.0 if term.operator in (">", ">=") else off < 0.0
