"""Why a leg ended, for people: the guard as the mission writes it, and the values it saw."""

from __future__ import annotations

from collections.abc import Iterable

from mission.authoring.graph import words
from mission.engine.variables import VARIABLES
from mission.model import Chart
from mission.model.units import UNITS

_SIGNS = str.maketrans({"\u2264": "<=", "\u2265": ">=", "\u00b0": " deg"})  # for any terminal


def ended_by(chart: Chart, trigger: str, seen: Iterable[tuple[str, float | None]]) -> str | None:
    """Describe the edge that fired and its values; None if the mission has no such edge."""
    edge = next((e for e in chart.edges if trigger and e.trigger == trigger), None)
    if edge is None:
        return None
    states = {state.path: state for state in chart.states}
    source = states.get(edge.source)
    text = words.edge(edge, source.leg if source else None)
    told = [(name, value) for name, value in seen if edge.guard or value is None]
    saw = ", ".join(_value(name, value) for name, value in told)
    return (f"{text} ({saw})" if saw else text).translate(_SIGNS)


def _value(name: str, value: float | None) -> str:
    if value is None:
        return f"{name} unknown"
    unit = VARIABLES[name].unit if name in VARIABLES else ""
    return f"{name} {value / UNITS[unit].factor if unit in UNITS else value:.4g} {unit}".rstrip()
