"""The texts of a chart's parts on pictures: guards, setpoints, kinds of legs, times.

They use plain characters only (ASCII, Latin-1 and the signs for "at least" and "at most"), because
a picture is shown in any font of the machine. What does not live here: the canonical text of a
mission (mission.authoring.language).
"""

from __future__ import annotations

import math

from mission.authoring.language.render import trend_text
from mission.authoring.language.words import AIMS, ASSUMPTIONS
from mission.engine.variables import VARIABLES
from mission.legs import LEGS
from mission.model import (
    Aims,
    And,
    Area,
    Back,
    By,
    Comparison,
    Edge,
    Expression,
    Guard,
    Leg,
    Mission,
    Not,
    Or,
    State,
    Trend,
)
from mission.model.shown import bearing, duration, number
from mission.model.texts import NEVER_BELOW
from mission.model.units import GEARS, UNITS
from protocol.messages import Setpoint

_SIGNS = {"<": "<", "<=": "\u2264", ">": ">", ">=": "\u2265"}


def expression(value: Expression) -> str:
    match value:
        case Comparison():
            return _comparison(value)
        case Trend() | Back():
            return trend_text(value, units=True)
        case Not(operand):
            return f"not ({expression(operand)})"
        case And(operands):
            return " and ".join(_part(one) for one in operands)
        case Or(operands):
            return " or ".join(_part(one) for one in operands)


def _part(value: Expression) -> str:
    return f"({expression(value)})" if isinstance(value, And | Or) else expression(value)


def _comparison(value: Comparison) -> str:
    row = VARIABLES.get(value.variable)
    unit = row.unit if row is not None else ""
    bound = value.bound / UNITS[unit].factor if unit in UNITS else value.bound
    if unit == "s":
        text = duration(bound)
    else:
        text = number(bound) + ("\u00b0" if unit == "deg" else f" {unit}" if unit else "")
    sure = f" ({number(value.sure * 100)} % sure)" if value.sure is not None else ""
    return f"{value.variable} {_SIGNS.get(value.operator, value.operator)} {text}{sure}"


def guard(value: Guard) -> str:
    held = f" for {duration(value.held)}" if value.held else ""
    return expression(value.expression) + held


def kind(leg: Leg) -> str:
    """What the leg does in addition to its set; "" for a plain hold."""
    return LEGS[type(leg.kind)].shown(leg.kind)


def setpoint(value: Setpoint | None) -> str:
    """The leg's complete set, axis by axis; axes at rest are left out."""
    if value is None:
        return ""
    words = []
    if value.heading is not None:
        words.append(f"heading {bearing(value.heading)}")
    if value.surge:
        words.append(f"gear {number(value.surge * GEARS)}")
    if value.turn:
        side = "starboard" if value.turn > 0 else "port"
        words.append(f"turn {side} {number(abs(value.turn) * GEARS)}")
    held = [
        f"{w} {number(m)} m" for w in ("depth", "altitude") if (m := getattr(value, w)) is not None
    ]
    if held:
        words.append(f", {NEVER_BELOW} ".join(held))
    if value.heave:
        word = "down" if value.heave > 0 else "up"
        words.append(f"{word} {number(abs(value.heave) * GEARS)}")
    if value.pitch is not None:
        words.append(f"pitch {number(math.degrees(value.pitch))}\u00b0")
    if value.roll is not None:
        words.append(f"roll {number(math.degrees(value.roll))}\u00b0")
    return " \u00b7 ".join(words) or "at rest"


def outputs(value: State) -> str:
    """The values of all outputs that the mission names, also the safe ones."""
    return ", ".join(f"{name} {number(level)}" for name, level in value.outputs)


def edge(value: Edge, leg: Leg | None) -> str:
    """The condition of a way, as text for an arrow."""
    if value.guard is not None:
        return guard(value.guard)
    match value.by:
        case By.FOR:
            return f"after {duration(leg.duration)}" if leg and leg.duration else "time over"
        case By.TIMEOUT:
            return f"timeout {duration(leg.timeout)}" if leg and leg.timeout else "timeout"
        case By.ELSE:
            return "refused or blind"
        case By.UNCERTAIN:
            return "position uncertain"
        case By.END:
            return _end(leg)
        case _:
            return str(value.by.value)


def _end(leg: Leg | None) -> str:
    return LEGS[type(leg.kind)].done(leg.kind) if leg is not None else "done"


def assumption(name: str, value: float) -> str:
    return f"{name} {number(value)} {ASSUMPTIONS[name].unit}"


def achieve(aims: Aims) -> str:
    return ", ".join(
        f"{name} {number(value)} m" if AIMS[name].unit else f"{name} {number(100 * value)} %"
        for name, value in aims
    )


def safety(mission: Mission) -> str:
    own = mission.safety
    words = []
    if own.radius is not None:
        words.append(f"radius {number(own.radius)} m")
    if own.time is not None:
        words.append(f"time {duration(own.time)}")
    if own.depth is not None:
        words.append(f"depth {number(own.depth)} m")
    if own.voltage is not None:
        words.append(f"battery {number(own.voltage)} V")
    words += map(area, mission.areas)
    return ", ".join(words) or "the vehicle's hard limits alone"


def area(value: Area) -> str:
    """The name of an area, and the depths between which it counts."""
    between = f" ({number(value.top)} to {number(value.bottom)} m)" if value.limited else ""
    return f"keep {'out' if value.out else 'in'} {value.name}{between}"
