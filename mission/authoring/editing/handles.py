"""The places that a text names: where their numbers stand in the text, and their positions.

What does not live here: the change of the text when a place is moved (edits).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from mission.authoring.language import Draft
from mission.authoring.language.clauses import (
    Amount,
    AreaText,
    Coordinates,
    End,
    HomeAt,
    LegText,
    Offset,
    Opening,
    Parameter,
    Places,
    PlaceText,
    Statement,
)
from mission.model import Position
from mission.model.units import UnitError, quantity
from mission.navigation.geodesy import LocalFrame

_LINE = re.compile(r"\r?\n")


@dataclass(frozen=True, slots=True)
class Handle:
    """A place in the text. ``kind``: home, corner (of an area) or place (of a leg). ``word``: the
    word before it. It is number ``at`` (from 0) of ``count`` in a row of places. ``position``: in
    degrees; None if it is in metres from an unknown home. ``fixed``: why it cannot be moved, or
    ""."""

    path: str
    kind: str
    word: str
    place: Coordinates | Offset
    statement: Statement
    position: tuple[float, float] | None
    fixed: str = ""
    at: int = 0
    count: int = 1

    @property
    def numbers(self) -> tuple[Amount, Amount]:
        return amounts_of(self.place)

    def as_object(self) -> dict[str, Any]:
        """The object that the page uses (docs/design/console.md)."""
        spans = [[a.where.line, a.where.column, a.where.length] for a in self.numbers]
        return {
            "path": self.path,
            "kind": self.kind,
            "word": self.word,
            "at": None if self.position is None else list(self.position),
            "row": [self.at, self.count],
            "spans": spans,
            "fixed": self.fixed,
        }


class Lines:
    """Offsets in a text by line and column, both from 1."""

    def __init__(self, text: str) -> None:
        self._text = text
        first = 1 if text.startswith("\ufeff") else 0
        self._starts = [first, *(match.end() for match in _LINE.finditer(text))]

    @property
    def count(self) -> int:
        return len(self._starts)

    def offset(self, line: int, column: int) -> int | None:
        """The offset of a line and column; None if the text has no such place."""
        if not 0 < line <= len(self._starts):
            return None
        found = self._starts[line - 1] + column - 1
        return found if found <= self.end(line) else None

    def start(self, line: int) -> int:
        return self._starts[line - 1]

    def end(self, line: int) -> int:
        """The offset of the end of a line, before its line break."""
        if line >= len(self._starts):
            return len(self._text)
        end = self._starts[line] - 1
        return end - 1 if self._text[end - 1 : end] == "\r" else end

    def of(self, amount: Amount) -> int | None:
        """The offset of a number; None if other text is there."""
        found = self.offset(amount.where.line, amount.where.column)
        there = found is not None and self._text.startswith(amount.text, found)
        return found if there else None


def amounts_of(place: Coordinates | Offset) -> tuple[Amount, Amount]:
    if isinstance(place, Coordinates):
        return place.latitude, place.longitude
    return place.north, place.east


def frame_of(read: Draft) -> LocalFrame | None:
    """The frame around the home that the text names; None if there is no readable home."""
    for statement in read.statements:
        if isinstance(statement, HomeAt):
            position = _degrees(statement.place)
            return None if position is None else LocalFrame(Position(*position))
    return None


def handles(read: Draft, text: str) -> tuple[Handle, ...]:
    """The places in the order of the text; a place that legs share by a YAML alias stands once."""
    lines, frame = Lines(text), frame_of(read)
    named = {s.name.text: s.amount for s in read.statements if isinstance(s, Parameter)}
    found: dict[tuple[int, int], Handle] = {}
    for path, kind, word, statement, places in _named(read.statements):
        for at, place in enumerate(places):
            if not isinstance(place, Coordinates | Offset):
                continue
            if (fixed := _fixed(place, lines)) is None:
                continue
            where = amounts_of(place)[0].where
            position = _position(place, frame, named)
            row = at, len(places)
            one = Handle(path, kind, word, place, statement, position, fixed, *row)
            found.setdefault((where.line, where.column), one)
    return tuple(found.values())


_Row = tuple[str, str, str, Statement, tuple[PlaceText, ...]]


def _named(statements: tuple[Statement, ...]) -> Iterator[_Row]:
    groups: list[str] = []
    for statement in statements:
        match statement:
            case HomeAt(place):
                yield "home", "home", "home", statement, (place,)
            case AreaText(name, out, corners):
                word = "keep out" if out else "keep in"
                yield name.text, "corner", word, statement, corners
            case Opening(name):
                groups.append(name.text)
            case End() if groups:
                groups.pop()
            case LegText(name):
                leaf = name.text if name is not None else f"line {statement.where.line}"
                path = "/".join([*groups, leaf])
                for clause in statement.clauses:
                    if isinstance(clause, Places):
                        yield path, "place", clause.word.text, statement, clause.places


def _fixed(place: Coordinates | Offset, lines: Lines) -> str | None:
    """Why the place cannot be moved, or ""; None if its numbers do not stand in the text."""
    amounts = amounts_of(place)
    if any(lines.of(amount) is None for amount in amounts):
        return None
    names = [amount.text for amount in amounts if amount.is_name]
    return f"the parameter {' and '.join(names)} sets it: change that in the text" if names else ""


def _position(
    place: Coordinates | Offset, frame: LocalFrame | None, named: Mapping[str, Amount]
) -> tuple[float, float] | None:
    if isinstance(place, Coordinates):
        return _degrees(place)
    metres = metres_of(place, named)
    if frame is None or metres is None:
        return None
    latitude, longitude = frame.to_geodetic(*metres)
    return math.degrees(latitude), math.degrees(longitude)


def metres_of(
    place: Offset, named: Mapping[str, Amount] = MappingProxyType({})
) -> tuple[float, float] | None:
    """m north and east of home; ``named``: the parameters. None if they cannot be read."""
    given = [named.get(a.text, a) if a.is_name else a for a in (place.north, place.east)]
    try:
        north, east = (quantity(f"{a.text} {a.unit}", "m") for a in given)
    except UnitError:
        return None
    return north, east


def _degrees(place: Coordinates) -> tuple[float, float] | None:
    if place.latitude.is_name or place.longitude.is_name:
        return None
    found = float(place.latitude.text), float(place.longitude.text)
    return found if abs(found[0]) <= 90.0 and abs(found[1]) <= 180.0 else None
