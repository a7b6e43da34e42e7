"""Render the parts of a Mission as pairs of word and value, for lines and for YAML.

Numbers are the shortest that read back as the same bits, in the unit of their word; headings are
0 to 360 degrees. With ``units`` (YAML) the unit follows the number, else the number is bare.

What does not live here: how the pairs are laid out (canonical.py, yaml_text.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from mission.authoring.language.words import (
    AIMS,
    GENERATED,
    GUARDED,
    HOLD,
    LIMITS,
    SETTINGS,
)
from mission.engine.variables import VARIABLES
from mission.legs import LEGS, LegType
from mission.legs.words import Choice, LegClause, Measure, Shape
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
from mission.model.texts import NEVER_BELOW
from mission.model.units import GEARS, degrees_text, number_text

Pair = tuple[str, str]


def quantity_text(value: float, unit: str, units: bool) -> str:
    """``value`` (SI) as text; ``unit`` is the unit of a bare number."""
    if unit == "deg":
        return degrees_text(value) + (" deg" if units else "")
    if units and unit == "s" and value >= 60 and value % 60 == 0:
        return f"{number_text(value / 60)} min"
    return number_text(value) + (f" {unit}" if units and unit else "")


def setting_pair(setting: Setting, units: bool) -> Pair:
    value = setting.value
    match setting.word:
        case "surge":
            return ("stop", "") if value == 0 else ("gear", _gears(value))
        case "turn":
            return ("right", _gears(value)) if value >= 0 else ("left", _gears(-value))
        case "heave":
            return ("down", _gears(value)) if value >= 0 else ("up", _gears(-value))
        case "heading":
            return "heading", degrees_text(value)
        case word:
            return word, quantity_text(value, SETTINGS[word].unit, units)


def _gears(fraction: float) -> str:
    near = round(fraction * GEARS)
    return number_text(near if near / GEARS == fraction else fraction * GEARS)


# --- guards ---------------------------------------------------------------------------------------


def guard_text(guard: Guard, units: bool) -> str:
    held = f" held {quantity_text(guard.held, 's', units)}" if guard.held else ""
    return expression_text(guard.expression, units) + held


def expression_text(expression: Expression, units: bool) -> str:
    match expression:
        case Comparison(variable, operator, bound, sure):
            unit = VARIABLES[variable].unit if variable in VARIABLES else ""
            text = f"{variable} {operator} {quantity_text(bound, unit, units)}"
            return text if sure is None else f"{text} sure {share_text(sure, units)}"
        case Trend() | Back():
            return trend_text(expression, units)
        case Not(operand):
            inner = expression_text(operand, units)
            return f"not ({inner})" if isinstance(operand, And | Or) else f"not {inner}"
        case And(operands):
            return " and ".join(_within(o, units, Or) for o in operands)
        case Or(operands):
            return " or ".join(expression_text(o, units) for o in operands)


def trend_text(term: Trend | Back, units: bool) -> str:
    unit = VARIABLES[term.variable].unit if term.variable in VARIABLES else ""
    if isinstance(term, Back):
        extreme, within = "highest" if term.highest else "lowest", term.within
        near = quantity_text(within, unit, units)
        return f"{term.variable} back at {extreme} {term.peak} within {near}"
    moves, amount = "rises" if term.rises else "falls", quantity_text(term.amount, unit, units)
    reach = f" within {number_text(term.window)} {'m' if term.of_depth else 's'}"
    return f"{term.variable} {moves} {amount}{reach if term.window < math.inf else ''}"


def _within(operand: Expression, units: bool, weaker: type[Or]) -> str:
    text = expression_text(operand, units)
    return f"({text})" if isinstance(operand, weaker) else text


def share_text(share: float, units: bool) -> str:
    percent = number_text(round(share * 100, 9))
    return f"{percent}%" if units and float(percent) / 100 == share else number_text(share)


def exit_text(exit_: Exit, units: bool) -> str:
    target = f" -> {exit_.target}" if exit_.target is not None else ""
    return guard_text(exit_.guard, units) + target


# --- legs -----------------------------------------------------------------------------------------


def place_text(place: Place | None) -> str:
    match place:
        case None:
            return "here"
        case Position(latitude, longitude):
            return f"{number_text(latitude)} {number_text(longitude)}"
        case Local(north, east):
            return f"north {number_text(north)} east {number_text(east)}"
        case name:
            return name


def node_pairs(node: Leg | Set, units: bool) -> Iterator[Pair]:
    """The words of a leg in their canonical order; ``until`` comes once for each exit."""
    if isinstance(node, Leg):
        yield from _kind_pairs(node, units)
    yield from _setting_pairs(node.settings, units)
    for output in node.outputs:
        yield "output", f"{output.name} {number_text(output.value)}"
    if isinstance(node, Leg):
        for exit_ in node.exits:
            yield "until", exit_text(exit_, units)
        if node.duration is not None and LEGS[type(node.kind)].head.shape is not Shape.TIME:
            yield "for", quantity_text(node.duration, "s", units)
        if node.timeout is not None:
            yield "timeout", quantity_text(node.timeout, "s", units)
        if node.otherwise is not None:
            yield "else", node.otherwise
        if node.achieve:
            yield "achieve", " ".join(f"{n} {v}" for n, v in aim_pairs(node.achieve, units))


def _setting_pairs(settings: tuple[Setting, ...], units: bool) -> Iterator[Pair]:
    """The settings as pairs. A depth with an altitude is one pair; the two stand first."""
    pairs = [setting_pair(setting, units) for setting in settings]
    if {setting.word for setting in settings[:2]} == GUARDED:
        (word, value), least, *pairs = pairs
        yield word, f"{value} {NEVER_BELOW} {' '.join(least)}"
    yield from pairs


def _kind_pairs(leg: Leg, units: bool) -> Iterator[Pair]:
    row = LEGS[type(leg.kind)]
    if row.name == HOLD and not _says_hold(leg):
        return
    yield row.name, _head(leg, row, units)
    for clause in row.clauses:
        text = _clause(clause, getattr(leg.kind, clause.field), units)
        if text:
            yield clause.word, text
    if row.awaits_fix(leg.kind):
        yield "until", "fix"


def _says_hold(leg: Leg) -> bool:
    """Whether the word ``hold`` is needed; it is left out if the text reads the same without it."""
    bounds = leg.exits or leg.otherwise or leg.duration is not None
    bare = GENERATED.match(leg.name) and not bounds and leg.timeout is None
    return bool(bare) or not leg.settings


def _head(leg: Leg, row: LegType, units: bool) -> str:
    match row.head.shape:
        case Shape.NOTHING:
            return ""
        case Shape.TIME:
            return "" if leg.duration is None else quantity_text(leg.duration, "s", units)
        case Shape.COUNT:
            return str(getattr(leg.kind, row.head.field))
        case Shape.PLACE | Shape.ABOUT:
            return place_text(getattr(leg.kind, row.head.field))
        case Shape.PLACES:
            return ", ".join(map(place_text, getattr(leg.kind, row.head.field)))


def _clause(clause: LegClause, value: Any, units: bool) -> str:
    """The value of a clause as text; empty if the clause is left out."""
    match clause:
        case Measure(silent=True) if value == clause.unsaid:
            return ""
        case Measure():
            circular = clause.circular
            return degrees_text(value) if circular else quantity_text(value, clause.unit, units)
        case Choice():
            return next(word for word, meant in clause.values.items() if meant == value)
        case _:
            return "" if value is None else place_text(value)


# --- headers --------------------------------------------------------------------------------------


def safety_pairs(safety: Safety, units: bool) -> Iterator[Pair]:
    for row in LIMITS.values():
        value = getattr(safety, row.name)
        if value is not None:
            yield row.name, quantity_text(value, row.unit, units)


def area_text(area: Area) -> str:
    """The area as a statement of the line script."""
    keep, corners = "out" if area.out else "in", ", ".join(map(place_text, area.corners))
    between = "" if not area.limited else " between " + " and ".join(depths_of(area, False))
    return f"keep {keep} {area.name}: {corners}{between}"


def depths_of(area: Area, units: bool) -> list[str]:
    return [quantity_text(depth, "m", units) for depth in (area.top, area.bottom)]


def aim_pairs(aims: Aims, units: bool) -> Iterator[Pair]:
    for name, value in aims:
        unit = AIMS[name].unit
        yield name, quantity_text(value, unit, units) if unit else share_text(value, units)


def handlers_of(mission: Mission) -> Iterator[Pair]:
    """The targets of ``on uncertain`` and ``on timeout``, where they are not the default."""
    for word, target in (("uncertain", mission.on_uncertain), ("timeout", mission.on_timeout)):
        if target != "surface":
            yield word, target


def label(node: Node) -> str:
    """The name of a leg or group; empty for a leg that its author did not name."""
    if isinstance(node, Group) or not (node.name == "" or GENERATED.match(node.name)):
        return node.name
    return ""


def handler_text(handler: Handler, units: bool) -> str:
    return guard_text(handler.guard, units)
