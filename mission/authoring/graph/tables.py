"""The tables of the chart as JSON, for programs. Guards are trees and text; SI and radians.

{mission, vehicle, digest, initial, states: [...], edges: [...], regions: [...]}
"""

from __future__ import annotations

import json
import math
from typing import Any

from mission.authoring.graph import words
from mission.legs import LEGS
from mission.model import (
    And,
    Back,
    Chart,
    Comparison,
    Edge,
    Expression,
    Guard,
    Not,
    Or,
    State,
    Trend,
)
from mission.model.plain import to_plain
from mission.model.regions import REGION_EDGES


def tables(chart: Chart) -> str:
    mission = chart.mission
    legs = {state.path: state.leg for state in chart.states}
    data = {
        "mission": mission.name,
        "vehicle": mission.vehicle,
        "digest": chart.digest,
        "initial": chart.initial,
        "safety": to_plain(mission.safety),
        "home": to_plain(mission.home),
        "achieve": dict(mission.achieve),
        "states": [_state(state) for state in chart.states],
        "edges": [
            _edge(edge) | {"text": words.edge(edge, legs.get(edge.source))} for edge in chart.edges
        ],
        "regions": [
            {"event": r.name, "source": r.source, "target": r.target or None, "text": r.meaning}
            for r in REGION_EDGES
        ],
    }
    return json.dumps(data, indent=1, ensure_ascii=False) + "\n"


def _state(state: State) -> dict[str, Any]:
    row: dict[str, Any] = {"path": state.path, "parent": state.parent}
    if state.group is not None:
        group = state.group
        return row | {"kind": "group", "repeat": group.repeat, "achieve": dict(group.achieve)}
    if state.leg is None:
        return row | {"kind": "region"}
    leg = state.leg
    return row | {
        "kind": LEGS[type(leg.kind)].name,
        "parameters": to_plain(leg.kind),
        "setpoint": to_plain(state.setpoint),
        "outputs": dict(state.outputs),
        "duration": leg.duration,
        "timeout": leg.timeout,
        "achieve": dict(leg.achieve),
        "line": leg.where.line or None,
        "text": " \u00b7 ".join(
            part
            for part in (words.kind(leg), words.setpoint(state.setpoint), words.outputs(state))
            if part
        ),
    }


def _edge(edge: Edge) -> dict[str, Any]:
    return {
        "trigger": edge.trigger,
        "source": edge.source,
        "target": edge.target,
        "by": edge.by.value,
        "guard": _guard(edge.guard),
        "rounds": [{"group": loop.group, "again": loop.again} for loop in edge.loops],
        "line": edge.where.line or None,
    }


def _guard(guard: Guard | None) -> dict[str, Any] | None:
    if guard is None:
        return None
    return {"expression": _expression(guard.expression), "held": guard.held}


def _expression(value: Expression) -> dict[str, Any]:
    match value:
        case Comparison(variable, operator, bound, sure):
            row: dict[str, Any] = {"variable": variable, "operator": operator, "bound": bound}
            return row if sure is None else row | {"sure": sure}
        case Trend(variable, rises, amount, window, of_depth):
            reach = "depth" if of_depth else "time"
            bounds = {reach: window} if math.isfinite(window) else {}
            return {"variable": variable, "moves": "rises" if rises else "falls",
                    "amount": amount, **bounds}  # fmt: skip
        case Back(variable, highest, peak, within):
            extreme = "highest" if highest else "lowest"
            return {"variable": variable, "back at": extreme, "of": peak, "within": within}
        case Not(operand):
            return {"not": _expression(operand)}
        case And(operands):
            return {"and": [_expression(one) for one in operands]}
        case Or(operands):
            return {"or": [_expression(one) for one in operands]}
