"""What was, by time: complete, in order, bounded, and the same by whatever way it came."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mission.model.past import NAMES, ROWS, Past, Row, is_row, row_of


def row(t: float) -> Row:
    return [t, *(t + n for n in range(len(NAMES)))]


@given(st.permutations(range(12)), st.integers(1, 5))
def test_rows_are_in_order_once_each_however_they_come(order: list[int], size: int) -> None:
    past, rows = Past(), [row(float(n)) for n in range(12)]
    for piece in _pieces(order, size):
        past.add([rows[n] for n in piece])
        past.add([rows[n] for n in piece])
    assert past.rows == rows
    assert [told[0] for told in past.news] == order


def _pieces(order: list[int], size: int) -> list[list[int]]:
    return [order[n : n + size] for n in range(0, len(order), size)]


def test_a_row_is_of_a_report_with_what_is_left_and_the_half_axis() -> None:
    state = {"report_at": 9.0, "depth": 3.5, "ellipse": [4.0, 2.0, 90], "to_radius": [250.0, 300.0],
             "to_time": [None, 30.0], "state": "idle/ready"}  # fmt: skip
    known = {"depth": 3.5, "ellipse": 4.0, "to_radius": 250.0}
    assert row_of(state) == [9.0, *(known.get(name) for name in NAMES)]
    assert row_of({**state, "report_at": None}) is None
    assert row_of({"report_at": 9.0}) is None


def test_a_report_is_one_row_and_reports_lie_a_second_apart() -> None:
    past = Past()
    for t in (0.0, 0.0, 0.4, 0.9, 1.0, 1.2, 2.1):
        past.take({"report_at": t, "depth": t})
    assert [r[0] for r in past.rows] == [0.0, 1.0, 2.1]


def test_a_long_past_is_thinned_evenly_and_goes_from_end_to_end() -> None:
    past, most = Past(), 5 * ROWS
    for t in range(most):
        past.take({"report_at": float(t), "depth": 1.0})
    times = [r[0] for r in past.rows]
    assert len(times) <= ROWS
    assert (times[0], past.thinned) == (0.0, 3)
    assert most - times[-1] <= 8.0
    assert {b - a for a, b in itertools.pairwise(times)} == {8.0}
    assert past.news == past.rows


def test_what_was_until_a_time_has_the_row_of_that_time() -> None:
    past = Past([row(1.0), row(2.0), row(3.0)])
    assert past.until(2.0) == [row(1.0), row(2.0)]
    assert past.until(0.5) == []


@pytest.mark.parametrize(
    "said", [None, [], [1.0], [None, *NAMES], row(float("nan")), [1.0, *("x" for _ in NAMES)]]
)
def test_what_is_no_row_is_none(said: object) -> None:
    assert not is_row(said)
    assert is_row([1.0, *(None for _ in NAMES)])
