"""One file per leg type, and the table: a new leg type is one file and one row here.

``LEGS.register(TYPE)`` adds one from another package. Texts, schema, manual, check, pictures,
engine and campaign use the table.
"""

from __future__ import annotations

from collections.abc import Iterable

from mission.legs import cover, follow, goto, hold, loiter, rows, surface, wait, yoyo
from mission.legs.base import Author, LegType, Pilot, Point, Track, View
from mission.legs.cover import Cover
from mission.legs.follow import Follow
from mission.legs.goto import Goto
from mission.legs.hold import Hold
from mission.legs.loiter import Loiter
from mission.legs.rows import Rows
from mission.legs.surface import Surface
from mission.legs.wait import Wait
from mission.legs.words import meaning
from mission.legs.yoyo import Yoyo
from mission.model import LegKind
from mission.model.tables import Table

_ROWS = (
    hold.TYPE,
    wait.TYPE,
    goto.TYPE,
    follow.TYPE,
    rows.TYPE,
    cover.TYPE,
    yoyo.TYPE,
    loiter.TYPE,
    surface.TYPE,
)


def _kind_of(row: LegType) -> type[LegKind]:
    return row.kind


def _fault(row: LegType, others: Iterable[LegType]) -> str:
    """Why a row cannot be added: a word has to mean the same in every leg. "" if it can."""
    known = {clause.word: clause for other in others for clause in other.clauses}
    if row.name in {*known, *(other.name for other in others)}:
        return f"{row.name} is a word already"
    twice = [c.word for c in row.clauses if meaning(known.get(c.word, c)) != meaning(c)]
    return f"{twice[0]} means something else already" if twice else ""


LEGS: Table[type[LegKind], LegType] = Table(_kind_of, _ROWS, _fault)

__all__ = [
    "LEGS",
    "Author",
    "Cover",
    "Follow",
    "Goto",
    "Hold",
    "LegType",
    "Loiter",
    "Pilot",
    "Point",
    "Rows",
    "Surface",
    "Track",
    "View",
    "Wait",
    "Yoyo",
]
