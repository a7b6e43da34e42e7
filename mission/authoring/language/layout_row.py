"""Rows and levels of indentation, as both layouts use them."""

from __future__ import annotations

from dataclasses import dataclass

STEP = 2


@dataclass(frozen=True, slots=True)
class Row:
    """One line: its code and the comment behind it, with ``#``. Either may be empty."""

    code: str
    comment: str = ""
