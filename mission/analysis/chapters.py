"""The structure of a dive's story: chapters of sentences and tables.

What does not live here: their contents (story), how they are printed (tell).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Table:
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Chapter:
    title: str
    says: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()


Rows = Sequence[tuple[str, ...]]

# title, head, and the sentence for an empty table
_TABLES: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("Legs", ("leg", "from", "for", "ended by"), "No leg was flown."),
    ("Limits", ("limit", "in force", "least left", "at"), "None was in question."),
    (
        "Sensors",
        ("sensor", "was", "from", "noticed", "to", "times", "in all"),
        "None was found that could not be believed.",
    ),
    ("Alarms", ("at", "of", "what"), "There was none."),
    (
        "Words of operators",
        ("from", "word", "was", "times", "first said", "answered", "last"),
        "None was answered.",
    ),
    ("Refusals", ("at", "answer", "why", "to"), "Nothing was refused."),
    ("Commands to the vehicle", ("at", "frame", "why"), "None was sent."),
)


def tabled(*rows: Rows) -> Iterator[Chapter]:
    """Yield the tables of a story in order; each of ``rows`` fills one."""
    for (title, head, none), some in zip(_TABLES, rows, strict=True):
        yield Chapter(title, (), (Table(head, tuple(some)),)) if some else Chapter(title, (none,))
