"""Offsets where statements and places begin and end in a text of either form, for edits.

YAML            by the marks of the YAML parser's nodes
line script     by the places of tokens, and the lines that continue a statement

EditError      (the author must act: it tells why an edit cannot be made, and what to do instead)
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from mission.authoring.editing.handles import Handle, Lines
from mission.authoring.language.clauses import AreaText, Coordinates, LegText, Offset, PlaceText
from mission.authoring.language.clauses import Places as Row
from mission.authoring.language.lines import code_and_comment
from mission.authoring.language.values import whole_place
from mission.model import Where
from mission.model.yaml_tree import tree

_NORTH = re.compile(r"north\s*\Z")
_DASH = re.compile(r"[ \t]*-[ \t]+\Z")
_IN_TEXT = "write it in the text"


class EditError(ValueError):
    pass


@dataclass(frozen=True, slots=True)
class Span:
    begin: int
    end: int


@dataclass(frozen=True, slots=True)
class Block:
    """A statement: its code, and the whole lines around it without the last line break."""

    code: Span
    lines: Span


class LineLayout:
    """The layout of a line script."""

    def __init__(self, text: str) -> None:
        self.text, self.lines = text, Lines(text)

    def places(self, handle: Handle) -> tuple[list[Span], bool]:
        """The places of the handle's row, and whether each stands in lines of its own."""
        return [self._place(place) for place in _row(handle)], False

    def statement(self, where: Where) -> Block:
        last, line = where.line, where.line + 1
        while line <= self.lines.count:
            code = self._code(line)
            if code.startswith("+"):
                last = line
            elif code:
                break
            line += 1
        first = self.lines.start(where.line)
        end = self.lines.end(last)
        ends = self.lines.start(last) + len(self._raw(last).rstrip())
        return Block(Span(first, ends), Span(first, end))

    def _raw(self, line: int) -> str:
        text = self.text[self.lines.start(line) : self.lines.end(line)]
        return code_and_comment(text)[0]

    def _code(self, line: int) -> str:
        return self._raw(line).strip()

    def _place(self, place: PlaceText) -> Span:
        if not isinstance(place, Coordinates | Offset):
            where = whole_place(place)
            begin = _at(self.lines, where)
            return Span(begin, begin + where.length)
        one, other = (
            (place.latitude, place.longitude)
            if isinstance(place, Coordinates)
            else (place.north, place.east)
        )
        begin, end = _at(self.lines, one.where), _at(self.lines, other.where) + other.where.length
        if isinstance(place, Offset):
            before = _NORTH.search(self.text[:begin])
            if before is None:
                raise EditError(f"the place is continued in another line: {_IN_TEXT}")
            begin = before.start()
        return Span(begin, end)


class YamlLayout:
    """The layout of a YAML text. Raises YamlFault if YAML cannot read it."""

    def __init__(self, text: str) -> None:
        self.text, self.lines = text, Lines(text)
        root = tree(text.removeprefix("\ufeff").replace("\r\n", "\n"))
        if root is None:
            raise EditError("there is no mission here")
        self.root = root

    def places(self, handle: Handle) -> tuple[list[Span], bool]:
        above = self._above(handle.numbers[0].where)
        inner = above[-1] if isinstance(handle.place, Offset | Coordinates) else None
        depth = -1 if self._is_text(handle) else -2
        place, row = above[depth], above[depth - 1]
        if inner is None or not isinstance(row, SequenceNode):
            return [self.span(place)], False
        spans = [self.span(one) for one in row.value]
        if any(a.end > b.begin for a, b in pairwise(spans)):
            raise EditError(f"an alias stands among these places: {_IN_TEXT}")
        return spans, not row.flow_style

    def _is_text(self, handle: Handle) -> bool:
        """Whether the place is one value (``north 0 east 0``), not a table."""
        one, other = handle.numbers
        return self._above(one.where)[-1] is self._above(other.where)[-1]

    def statement(self, where: Where) -> Block:
        """The item of a block list that contains ``where``."""
        above = self._above(where)
        items = [i for i, node in enumerate(above) if isinstance(node, SequenceNode)]
        if not items or _flows(above[items[-1]]):
            raise EditError(f"it has no line of its own: {_IN_TEXT}")
        code = self.span(above[items[-1] + 1])
        first = self.line_of(code.begin)
        if not _DASH.match(self.text[self.lines.start(first) : code.begin]):
            raise EditError(f"something else stands before it: {_IN_TEXT}")
        last = self.line_of(code.end)
        return Block(code, Span(self.lines.start(first), self.lines.end(last)))

    def value(self, *keys: str) -> Node | None:
        """The node under a path of keys; None if there is none."""
        found: Node | None = self.root
        for key in keys:
            pairs = found.value if isinstance(found, MappingNode) else ()
            found = next((v for k, v in pairs if k.value == key), None)
        return found

    def line_of(self, offset: int) -> int:
        return self.text.count("\n", 0, offset) + 1

    def span(self, node: Node) -> Span:
        """The span of a node, without the blanks and comments behind a block."""
        begin = self._offset(node.start_mark)
        return Span(begin, max(begin, *(self._offset(mark) for mark in _ends(node))))

    def _offset(self, mark: object) -> int:
        line, column = mark.line + 1, mark.column + 1  # type: ignore[attr-defined]
        found = self.lines.offset(line, column)
        if found is None:
            raise EditError(f"its lines end in an unusual way: {_IN_TEXT}")
        return found

    def _above(self, where: Where) -> list[Node]:
        """The nodes around the place, the outermost first."""
        at, found = (where.line - 1, where.column - 1), [self.root]
        while True:
            inner = [
                n for n in _children(found[-1]) if _holds(n, at) and _holds(found[-1], _start(n))
            ]
            if not inner:
                return found
            found.append(inner[0])


Layout = LineLayout | YamlLayout


def _row(handle: Handle) -> tuple[PlaceText, ...]:
    statement = handle.statement
    if isinstance(statement, AreaText):
        return statement.corners
    rows = statement.clauses if isinstance(statement, LegText) else ()
    return next(
        (r.places for r in rows if isinstance(r, Row) and handle.place in r.places),
        (handle.place,),
    )


def _at(lines: Lines, where: Where) -> int:
    found = lines.offset(where.line, where.column)
    if found is None:
        raise EditError(f"its place in the text is not known: {_IN_TEXT}")
    return found


def _children(node: Node) -> Iterator[Node]:
    if isinstance(node, SequenceNode):
        yield from node.value
    elif isinstance(node, MappingNode):
        for key, value in node.value:
            yield from (key, value)


def _flows(node: Node) -> bool:
    return isinstance(node, SequenceNode | MappingNode) and bool(node.flow_style)


def _start(node: Node) -> tuple[int, int]:
    return node.start_mark.line, node.start_mark.column


def _holds(node: Node, at: tuple[int, int]) -> bool:
    return _start(node) <= at < (node.end_mark.line, node.end_mark.column)


def _ends(node: Node) -> Iterator[object]:
    """The ends of the parts of a node. YAML puts the end of a block where the next one begins."""
    if isinstance(node, ScalarNode) or _flows(node):
        yield node.end_mark
        return
    for child in _children(node):
        if _holds(node, _start(child)):
            yield from _ends(child)
