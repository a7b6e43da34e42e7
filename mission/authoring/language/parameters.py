"""Parameters: numbers with a name, set by the author or the caller; they are read first.

    param row_length 200 m          in the mission
    --param row_length=150          on the command line, overrides it; the unit may be left out

What does not live here: where a parameter is used (values.py).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from mission.authoring.language.clauses import Amount, Parameter, Statement
from mission.authoring.language.words import CLAUSES, SETTINGS, kinds
from mission.engine.variables import VARIABLES
from mission.legs import LEGS
from mission.model.diagnostics import Diagnostics
from mission.model.likeness import suggestion
from mission.model.tables import derived
from mission.model.units import UNITS, UnitError, quantity


@derived(LEGS, VARIABLES)
def _reserved() -> frozenset[str]:
    return frozenset({*VARIABLES, *UNITS, *SETTINGS, *kinds(), *CLAUSES, "home", "here"})


def read_parameters(
    statements: Iterable[Statement], given: Mapping[str, str], problems: Diagnostics
) -> dict[str, Amount]:
    """All parameters by name. ``given``: name -> text of those that the caller overrides."""
    found: dict[str, Amount] = {}
    for statement in statements:
        if isinstance(statement, Parameter):
            _check_name(statement, found, problems)
            found[statement.name.text] = statement.amount
            _check_unit(statement.amount, problems)
    for name, text in given.items():
        _override(found, name, text, problems)
    return found


def _check_name(statement: Parameter, found: Mapping[str, Amount], problems: Diagnostics) -> None:
    name = statement.name
    if name.text in found:
        message = f"parameter {name.text} appears twice"
        problems.add("twice", name.where, message, "keep one of them")
    elif name.text in _reserved():
        message = f"{name.text} is a word of the language"
        problems.add("taken-name", name.where, message, f"call it for instance {name.text}_1")


def _check_unit(amount: Amount, problems: Diagnostics) -> None:
    if amount.unit and amount.unit not in UNITS:
        hint = suggestion(amount.unit, list(UNITS), "units")
        problems.add("unknown-unit", amount.where, f"unknown unit {amount.unit!r}", hint)


def _override(found: dict[str, Amount], name: str, text: str, problems: Diagnostics) -> None:
    default = found.get(name)
    if default is None:
        hint = suggestion(name, list(found), "parameters") or "this mission has no parameters"
        problems.add_outside("unknown-parameter", f"there is no parameter {name!r}", hint)
        return
    match = re.fullmatch(r"\s*(-?[\d.]+(?:[eE][-+]?\d+)?)\s*([A-Za-z/%]*)\s*", text)
    unit = match[2] or default.unit if match else ""
    try:
        quantity(f"{match[1]} {unit}" if match else text, unit)
    except (UnitError, KeyError) as error:
        message = f"parameter {name}: {text!r} is no value for it"
        problems.add_outside("parameter-value", message, str(error))
        return
    if match is not None:
        found[name] = Amount(match[1], unit, default.where)
