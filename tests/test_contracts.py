"""One contract for each table that is made to be added to, and every row keeps it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from contracts import LAWS, all_of_them

CASES = list(all_of_them())


@pytest.mark.parametrize(("law", "row"), [case[1:] for case in CASES], ids=[c[0] for c in CASES])
def test_every_row_of_every_table_keeps_its_contract(
    law: Callable[[Any], None], row: object
) -> None:
    law(row)


def test_every_table_has_rows_and_laws() -> None:
    assert all(rows() and laws for rows, laws in LAWS.values())
