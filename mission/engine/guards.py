"""Guards in Kleene's three-valued logic: True, False, or None for unknown.

    not unknown = unknown      false and unknown = false      true or unknown = true

Unknown never opens an edge, and it ends ``held``. An expression is compiled once, into closures
over a list of values. A Sheet lists the variables that all guards of one leg need, so that only
those are read, each once.

What does not live here: what a variable is (variables), what is remembered of it (memory), which
guard is evaluated when (run).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from mission.engine.readings import Scope, Value
from mission.engine.variables import (
    Variable,
    difference,
    row_of,
    value_of,
)
from mission.model import And, Back, Comparison, Expression, Guard, Not, Trend, terms
from mission.navigation import distribution
from protocol.vehicles.channels import Source

Test = Callable[[list[Value], Scope], "bool | None"]
STRICT_S = 1e-6  # a strict comparison of a time holds from the next microsecond on


@dataclass(frozen=True, slots=True)
class Compiled:
    """One compiled guard. ``reads``: the indices of its variables on the sheet. ``timed``: the
    indices of those that grow with time, with the values at which the outcome changes."""

    test: Test
    held: float
    reads: tuple[int, ...]
    timed: tuple[tuple[int, float], ...]

    def next_change(self, values: list[Value], now: float) -> float | None:
        """When, by time alone, a comparison of the guard changes; None if none does. Values of
        time are rounded to 1 us (readings), so that a step at that time sees the change."""
        due = None
        for place, bound in self.timed:
            value = values[place]
            if value is not None and value < bound:
                at = now + max(bound - value, STRICT_S)
                due = at if due is None or at < due else due
        return due


class Sheet:
    """The variables of several guards; each is read once, however many guards use it."""

    __slots__ = ("_places", "_sources", "rows", "stale_after")

    def __init__(self, sources: Iterable[tuple[str, Source]] = ()) -> None:
        """``sources``: the sources of the vehicle file's readings, by name."""
        self._sources = dict(sources)
        self.rows: list[Variable] = []
        self._places: dict[str, int] = {}
        self.stale_after: tuple[float, ...] = ()

    def values(self, scope: Scope) -> list[Value]:
        return [value_of(row, scope) for row in self.rows]

    def named(self, guard: Compiled, values: list[Value]) -> tuple[tuple[str, Value], ...]:
        return tuple((self.rows[i].name, values[i]) for i in guard.reads)

    def add(self, guard: Guard) -> Compiled:
        found = list(terms(guard.expression))
        places = tuple(dict.fromkeys(self._place(name) for term in found for name in term.asks))
        timed = tuple(
            (self._place(c.variable), c.bound + (STRICT_S if c.operator in (">", "<=") else 0.0))
            for c in found
            if isinstance(c, Comparison) and self._row(c.variable).timed
        )
        ages = {row.max_age for row in self.rows if row.max_age < math.inf}
        self.stale_after = tuple(sorted(ages))
        return Compiled(self._test(guard.expression), guard.held, places, timed)

    def _place(self, name: str) -> int:
        if name not in self._places:
            self._places[name] = len(self.rows)
            self.rows.append(self._row(name))
        return self._places[name]

    def _row(self, name: str) -> Variable:
        return row_of(name, self._sources)

    def _test(self, expression: Expression) -> Test:
        if isinstance(expression, Comparison):
            return self._comparison(expression)
        if isinstance(expression, Trend):
            return _trend(tuple(self._place(name) for name in expression.asks), expression)
        if isinstance(expression, Back):
            place = self._place(expression.variable)
            return _back(place, self._row(expression.variable), expression)
        if isinstance(expression, Not):
            return _negation(self._test(expression.operand))
        tests = tuple(self._test(part) for part in expression.operands)
        return _all(tests) if isinstance(expression, And) else _any(tests)

    def _comparison(self, c: Comparison) -> Test:
        place, row = self._place(c.variable), self._row(c.variable)
        if c.sure is not None:
            return _sure(place, row, c.operator, c.bound, c.sure)
        if row.circular:
            return _circular(place, c.operator, c.bound)
        return _PLAIN[c.operator](place, c.bound)


def _less(place: int, bound: float) -> Test:
    def test(values: list[Value], scope: Scope) -> bool | None:
        value = values[place]
        return None if value is None else value < bound

    return test


def _at_most(place: int, bound: float) -> Test:
    def test(values: list[Value], scope: Scope) -> bool | None:
        value = values[place]
        return None if value is None else value <= bound

    return test


def _greater(place: int, bound: float) -> Test:
    def test(values: list[Value], scope: Scope) -> bool | None:
        value = values[place]
        return None if value is None else value > bound

    return test


def _at_least(place: int, bound: float) -> Test:
    def test(values: list[Value], scope: Scope) -> bool | None:
        value = values[place]
        return None if value is None else value >= bound

    return test


_PLAIN: dict[str, Callable[[int, float], Test]] = {
    "<": _less,
    "<=": _at_most,
    ">": _greater,
    ">=": _at_least,
}


def _circular(place: int, operator: str, bound: float) -> Test:
    plain = _PLAIN[operator](0, 0.0)

    def test(values: list[Value], scope: Scope) -> bool | None:
        value = values[place]
        return None if value is None else plain([_wrapped(value - bound)], scope)

    return test


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _sure(place: int, row: Variable, operator: str, bound: float, sure: float) -> Test:
    wants_less = operator in ("<", "<=")

    def test(values: list[Value], scope: Scope) -> bool | None:
        value = values[place]
        if value is None:
            return None
        if row.share is not None:
            share = row.share(scope, bound)
            if share is None:
                return None
        else:
            off = difference(row, value, bound)
            sigma = row.sigma(scope)
            if sigma <= 0.0:
                return _PLAIN[operator](0, 0.0)([off], scope)
            share = distribution.below(0.0, off, sigma)
        return (share if wants_less else 1.0 - share) >= sure

    return test


def _trend(places: tuple[int, ...], term: Trend) -> Test:
    sign = 1.0 if term.rises else -1.0

    def test(values: list[Value], scope: Scope) -> bool | None:
        value, extreme = values[places[0]], scope.memory.extreme(term) if scope.memory else None
        if value is None or extreme is None or values[places[-1]] is None:
            return None
        return sign * (value - extreme) >= term.amount

    return test


def _back(place: int, row: Variable, term: Back) -> Test:
    def test(values: list[Value], scope: Scope) -> bool | None:
        value, there = values[place], scope.memory.peak(term) if scope.memory else None
        if value is None or there is None:
            return None
        return abs(difference(row, value, there)) <= term.within

    return test


def _negation(test: Test) -> Test:
    def negated(values: list[Value], scope: Scope) -> bool | None:
        result = test(values, scope)
        return None if result is None else not result

    return negated


def _all(tests: tuple[Test, ...]) -> Test:
    def conjunction(values: list[Value], scope: Scope) -> bool | None:
        outcome: bool | None = True
        for test in tests:
            result = test(values, scope)
            if result is False:
                return False
            if result is None:
                outcome = None
        return outcome

    return conjunction


def _any(tests: tuple[Test, ...]) -> Test:
    def disjunction(values: list[Value], scope: Scope) -> bool | None:
        outcome: bool | None = False
        for test in tests:
            result = test(values, scope)
            if result is True:
                return True
            if result is None:
                outcome = None
        return outcome

    return disjunction
