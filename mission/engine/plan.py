"""The data of one leg that do not change in a mission: its edges in order, its guards compiled.

What does not live here: which edge is next (run), what a guard means (guards).
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.engine.guards import Compiled, Sheet
from mission.legs import LEGS, LegType
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, By, Chart, Edge, Leg, Trend, terms
from protocol.messages import Setpoint


@dataclass(frozen=True, slots=True)
class Plan:
    """The data of one leg that do not change; compiled when the leg is first entered."""

    path: str
    leg: Leg
    base: Setpoint
    kind: LegType
    guarded: tuple[tuple[Edge, Compiled], ...]  # handlers and exits, in the order of evaluation
    plain: tuple[Edge, ...]  # end, for, timeout, else
    sheet: Sheet
    groups: tuple[str, ...]  # around it, innermost first
    repeated: str  # the innermost that repeats, or ""
    trends: tuple[Trend, ...]  # that its guards watch


def plan_of(chart: Chart, path: str) -> Plan:
    state = chart.state(path)
    assert state.leg is not None
    groups = []
    parent = state.parent
    while parent != AUTONOMOUS:
        groups.append(parent)
        parent = chart.state(parent).parent
    edges = list(chart.leaving(path))
    if path != IMPLICIT_SURFACE:
        handlers = [e for g in (*groups, AUTONOMOUS) for e in chart.leaving(g)]
        edges = [e for e in handlers if e.by is By.ON] + edges
    sheet = Sheet(chart.sources)
    watched = [e.guard for e in edges if e.guard is not None]
    asked = dict.fromkeys(t for guard in watched for t in terms(guard.expression))
    guarded = tuple((e, sheet.add(e.guard)) for e in edges if e.guard is not None)
    return Plan(
        path,
        state.leg,
        state.setpoint or Setpoint(),
        LEGS[type(state.leg.kind)],
        guarded,
        tuple(e for e in edges if e.guard is None),
        sheet,
        tuple(groups),
        next((g for g in groups if repeat_of(chart, g) > 1), ""),
        tuple(term for term in asked if isinstance(term, Trend)),
    )


def repeat_of(chart: Chart, path: str) -> int:
    group = chart.state(path).group
    return group.repeat if group else 1


def name_of(handler: Edge) -> str:
    """A handler's name: its trigger without the number of the outcome of rounds; all share it."""
    head, _, tail = handler.trigger.rpartition(":")
    return f"{head}:{tail.partition('.')[0]}"
