"""Intervals, and the values at which the rise of a variable opens a guard."""

from __future__ import annotations

import math
from collections.abc import Iterable

from mission.model import And, Comparison, Expression, Or

Interval = tuple[float, float]


def hull(a: Interval, b: Interval) -> Interval:
    return min(a[0], b[0]), max(a[1], b[1])


def hull_of(values: Iterable[float]) -> Interval:
    found = tuple(values)
    return min(found), max(found)


def grown(a: Interval, by: float) -> Interval:
    return a[0] - by, a[1] + by


def plus(a: Interval, b: Interval) -> Interval:
    return a[0] + b[0], a[1] + b[1]


def minus(a: Interval, b: Interval) -> Interval:
    return a[0] - b[1], a[1] - b[0]


def reach(north: Interval, east: Interval) -> float:
    return math.hypot(max(map(abs, north)), max(map(abs, east)))


def scaled(a: Interval, k: float) -> Interval:
    return (a[0] * k, a[1] * k) if k >= 0 else (a[1] * k, a[0] * k)


def opens_at(expression: Expression, variable: str) -> float | None:
    """The value at which the rise of ``variable`` alone opens the guard; None if none does."""
    match expression:
        case Comparison(name, operator, bound, None) if name == variable and operator in (
            ">",
            ">=",
        ):
            return bound
        case Or(operands):
            opens = [b for b in (opens_at(o, variable) for o in operands) if b is not None]
            return min(opens) if opens else None
        case And(operands):
            needs = [opens_at(o, variable) for o in operands]
            if any(b is None for b in needs):
                return None
            return max(b for b in needs if b is not None)
        case _:
            return None


def least(expression: Expression, variable: str) -> float:
    """The least value of ``variable`` when the guard opens; 0 if the guard does not tell."""
    match expression:
        case Comparison(name, operator, bound, _) if name == variable and operator in (">", ">="):
            return bound
        case And(operands):
            return max(least(o, variable) for o in operands)
        case Or(operands):
            return min(least(o, variable) for o in operands)
        case _:
            return 0.0
