"""What follows a leg's word in both mission texts: its head, and its clauses.

    rows 3  bearing 90  length 100  side port  from home  within 10
    head    Measure     Measure     Choice     Spot       Measure

Each is one parameter of the leg's kind. Grammar, YAML keys, JSON Schema, canonical text and manual
are made of these (mission.authoring.language).
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple


class Shape(enum.Enum):
    """What follows the word of a kind."""

    NOTHING = ""
    TIME = "a time"  # how long it lasts: the leg's duration
    COUNT = "a count"
    PLACE = "a place"
    ABOUT = "a place, or nothing"  # None: where the leg is entered
    PLACES = "places"


@dataclass(frozen=True, slots=True)
class Head:
    """What stands behind the leg's word, and the ``field`` of its kind that gets it."""

    shape: Shape = Shape.NOTHING
    field: str = ""


NO_HEAD = Head()


@dataclass(frozen=True, slots=True)
class Measure:
    """A size, ``low``..``high`` in ``unit``, for the field of the same name, in SI.

    ``usual`` is what it is where the author says nothing; None: it must be said, for instance as
    ``example``. ``circular``: a direction, written as a compass says it. ``silent``: texts do not
    write it where it is as usual.
    """

    word: str
    unit: str
    low: float
    high: float
    description: str
    usual: float | None = None
    example: str = "100"
    circular: bool = False
    silent: bool = False

    @property
    def field(self) -> str:
        return self.word

    @property
    def needed(self) -> bool:
        return self.usual is None

    @property
    def unsaid(self) -> float:
        return self.usual or 0.0


@dataclass(frozen=True, slots=True)
class Spot:
    """A place that may be said; else the field is None, where the leg is entered."""

    word: str
    field: str
    description: str
    needed: bool = False
    unsaid: None = None


@dataclass(frozen=True, slots=True)
class Choice:
    """One of some words, each with what it puts into the field of the clause's name."""

    word: str
    values: Mapping[str, int]
    unsaid: int
    description: str
    needed: bool = False

    @property
    def field(self) -> str:
        return self.word


LegClause = Measure | Spot | Choice


def meaning(clause: LegClause) -> LegClause:
    """What a word says whichever leg has it; whether it must be said there is each leg's own."""
    if isinstance(clause, Measure):
        return replace(clause, usual=None, silent=False)
    return clause


class Misfit(NamedTuple):
    """Measures that contradict each other: the code, the word to blame, and what to write."""

    code: str
    word: str
    message: str
    hint: str
