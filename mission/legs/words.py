"""What follows a leg's word in both mission texts: its head, and its clauses.

    rows 3  bearing 90  length 100  side port  from home  within 10
    head    Measure     Measure     Choice     Spot       Measure

Each is one parameter of the leg's kind. Grammar, YAML keys, JSON Schema, canonical text and manual
are generated from these (mission.authoring.language).
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple


class Shape(enum.Enum):
    """What follows the word of a leg type."""

    NOTHING = ""
    TIME = "a time"  # how long it lasts: the leg's duration
    COUNT = "a count"
    PLACE = "a place"
    ABOUT = "a place, or nothing"  # None: where the leg is entered
    PLACES = "places"


@dataclass(frozen=True, slots=True)
class Head:
    """What follows the leg's word, and the ``field`` of its kind that gets it."""

    shape: Shape = Shape.NOTHING
    field: str = ""


NO_HEAD = Head()


@dataclass(frozen=True, slots=True)
class Measure:
    """A quantity, ``low``..``high`` in ``unit``, for the field of the same name, in SI.

    ``usual``: its value if the author does not give it; None: it must be given, for instance as
    ``example``. ``circular``: a direction, written as on a compass. ``silent``: texts leave it out
    if it has its usual value.
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
    """A place that may be given; else the field is None: where the leg is entered."""

    word: str
    field: str
    description: str
    needed: bool = False
    unsaid: None = None


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several words, each with its value for the field of the clause's name."""

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
    """What a word means in every leg; whether it must be given there, each leg type decides."""
    if isinstance(clause, Measure):
        return replace(clause, usual=None, silent=False)
    return clause


class Misfit(NamedTuple):
    """Measures that contradict each other: the code, the word at fault, and what to write."""

    code: str
    word: str
    message: str
    hint: str
