"""Rows and levels of indentation, as both layouts use them."""

from __future__ import annotations

from dataclasses import dataclass

STEP = 2


@dataclass(frozen=True, slots=True)
class Row:
    """One line: what it says and the comment behind it, ``#`` included. Either may be empty."""

    code: str
    comment: str = ""
