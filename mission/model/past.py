"""A vehicle's values over time: one row per report, of which a limited number is kept.

    a displayed state (a flat table) --row_of--> [t, depth, altitude, ...] --> Past

The vehicle keeps a Past for viewers that connect later, and each viewer keeps one. Beyond ``ROWS``
every other row is dropped, and new rows are taken half as often. What does not live here: who
receives the rows (monitor).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping
from typing import Any

Row = list[Any]
"""The vehicle's time of the report, s; then the values of ``NAMES``, None: not known."""

NAMES = (
    "depth", "altitude", "heading", "pitch", "roll", "battery", "ellipse",
    "to_depth", "to_radius", "to_time", "to_voltage",
)  # fmt: skip
ROWS = 4096
EVERY_S = 1.0  # between two rows at least, until ``ROWS`` is reached


def row_of(state: Mapping[str, Any]) -> Row | None:
    """Return the row of a state, None if nothing is known. It has the long half axis of an ellipse,
    and what is left of a margin."""
    t = state.get("report_at")
    values = [_number(state.get(name)) for name in NAMES]
    known = _is_number(t) and any(value is not None for value in values)
    return [t, *values] if known else None


def _number(value: Any) -> Any:
    first = value[0] if isinstance(value, list | tuple) and value else value
    return first if _is_number(first) else None


class Past:
    """``rows`` are in order of time, ``news`` are the same rows in order of arrival. Once
    ``thinned`` has changed, a viewer has to be sent all of ``news`` again."""

    def __init__(self, rows: Iterable[Row] = ()) -> None:
        self.rows, self.thinned = list(rows), 0
        self.news = list(self.rows)
        self._every = EVERY_S

    def take(self, state: Mapping[str, Any]) -> None:
        """Add the report that a state shows, if it is enough later than the last row."""
        row = row_of(state)
        if row is not None and (not self.rows or row[0] >= self.rows[-1][0] + self._every):
            self.add((row,))

    def add(self, rows: Iterable[Row]) -> None:
        """Add rows in any order; rows that are known already are ignored."""
        for row in rows:
            at = bisect_left(self.rows, row[0], key=_time)
            if at == len(self.rows) or self.rows[at][0] != row[0]:
                self.rows.insert(at, row)
                self.news.append(row)
        while len(self.rows) > ROWS:
            self.rows = self.rows[::2]
            self.news = list(self.rows)
            self._every *= 2.0
            self.thinned += 1

    def until(self, t: float) -> list[Row]:
        """Return the rows up to a time."""
        return self.rows[: bisect_left(self.rows, t + 1e-9, key=_time)]


def is_row(said: object) -> bool:
    if not isinstance(said, list) or len(said) != len(NAMES) + 1:
        return False
    t, *values = said
    return _is_number(t) and all(value is None or _is_number(value) for value in values)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _time(row: Row) -> float:
    return float(row[0])
