"""Laws of a table: a row is there for as long as it is registered, and whatever is derived knows."""

from __future__ import annotations

import pytest

from mission.model.tables import Table, derived


def table() -> Table[int, str]:
    return Table(len, ["a", "bb"], lambda row, others: "odd" if row in "".join(others) else "")


def test_a_row_stays_until_its_block_is_left() -> None:
    rows = table()
    with rows.registered("ccc"):
        assert list(rows.items()) == [(1, "a"), (2, "bb"), (3, "ccc")]
    assert list(rows) == [1, 2]
    rows.register("ccc")
    assert rows[3] == "ccc"


def test_what_is_derived_is_made_once_and_anew_after_a_change() -> None:
    rows, made = table(), []

    @derived(rows)
    def joined() -> str:
        made.append(1)
        return "".join(rows.values())

    assert (joined(), joined(), len(made)) == ("abb", "abb", 1)
    with rows.registered("ccc"):
        assert joined() == "abbccc"
    assert (joined(), len(made)) == ("abb", 3)


@pytest.mark.parametrize(("row", "why"), [("c", "registered already"), ("abb", "odd")])
def test_a_row_that_stands_there_or_contradicts_the_others_is_refused(row: str, why: str) -> None:
    rows = table()
    with pytest.raises(ValueError, match=why):
        rows.register(row)
    assert len(rows) == 2
