"""One contract over the rows of the variables: a new row is tested by being there."""

from __future__ import annotations

import re

import pytest

from mission.engine.variables import SOURCES, VARIABLES, Variable
from mission.model.units import UNITS


@pytest.mark.parametrize("row", VARIABLES.values(), ids=lambda row: row.name)
def test_a_variable_has_a_name_a_unit_a_source_and_an_age(row: Variable) -> None:
    assert re.fullmatch(r"[a-z][a-z_]*", row.name)
    assert row.unit in {"", *UNITS}
    assert row.source
    assert set(row.source) <= SOURCES
    assert row.max_age > 0
    assert row.description
    assert row.circular == (row.unit == "deg" and row.name not in ("pitch", "roll"))
