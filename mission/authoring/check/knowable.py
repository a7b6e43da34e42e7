"""Refuse guards that can never be decided, by the vehicle's reports or for want of a leg before.

What does not live here: single comparisons that no believable reading opens (compiler).
"""

from __future__ import annotations

from collections.abc import Iterator

from mission.engine.variables import CLOCK, VARIABLES
from mission.model import (
    AUTONOMOUS,
    And,
    Back,
    Chart,
    Comparison,
    Expression,
    Guard,
    Not,
    Or,
    Trend,
    terms,
)
from mission.model.diagnostics import Diagnostic, Stage
from mission.model.vehicle import Vehicle


def _known(guard: Guard | Expression, vehicle: Vehicle) -> bool:
    """Whether the vehicle's readings can decide the guard (for ``or``, one side is enough)."""
    match guard:
        case Guard(expression):
            return _known(expression, vehicle)
        case Comparison() | Trend() | Back():
            asked = [VARIABLES[name] for name in guard.asks if name in VARIABLES]  # or a reading
            return all(s == CLOCK or s in vehicle.reports for row in asked for s in row.source)
        case Not(operand):
            return _known(operand, vehicle)
        case And(operands):
            return all(_known(o, vehicle) for o in operands)
        case Or(operands):
            return any(_known(o, vehicle) for o in operands)


def unknowable(chart: Chart, vehicle: Vehicle) -> Iterator[Diagnostic]:
    seen = set()
    for edge in chart.edges:
        if edge.guard is None or edge.where in seen or _known(edge.guard, vehicle):
            continue
        seen.add(edge.where)
        names = sorted({name for term in terms(edge.guard.expression) for name in term.asks})
        message = f"{vehicle.name} never reports what this guard needs ({', '.join(names)})"
        hint = "ask what this vehicle reports"
        yield Diagnostic(Stage.CHECK, "unknowable", edge.where, message, hint)


def none_before(chart: Chart) -> Iterator[Diagnostic]:
    if any(edge.target == chart.initial for edge in chart.edges):
        return
    for edge in chart.leaving(chart.initial):
        asked = terms(edge.guard.expression) if edge.guard is not None else ()
        if any(isinstance(term, Back) for term in asked):
            leg = chart.initial.removeprefix(AUTONOMOUS + "/")
            message = f"{leg} is the first leg: none before it has found a peak"
            hint = "let a leg before it look for it"
            yield Diagnostic(Stage.CHECK, "no-leg-before", edge.where, message, hint)
