"""The tidy layout of the YAML form, from the scanner's tokens: only blanks are changed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import yaml
from yaml.tokens import (
    BlockEndToken,
    BlockEntryToken,
    BlockMappingStartToken,
    BlockSequenceStartToken,
    FlowEntryToken,
    FlowMappingEndToken,
    FlowMappingStartToken,
    FlowSequenceEndToken,
    FlowSequenceStartToken,
    KeyToken,
    ScalarToken,
    Token,
    ValueToken,
)

from mission.authoring.language.layout_row import STEP, Row

_OPENING = (FlowMappingStartToken, FlowSequenceStartToken)
_CLOSING = (FlowMappingEndToken, FlowSequenceEndToken)
_BLOCKS = (BlockMappingStartToken, BlockSequenceStartToken)


@dataclass(frozen=True, slots=True)
class _Edit:
    """Columns ``start`` to ``end`` of a line become ``text``."""

    start: int
    end: int
    text: str


@dataclass(slots=True)
class _Block:
    """A block of the source. ``dashes``: its key has a list in the key's own column; the layout
    indents such a list one level more."""

    column: int
    mapping: bool
    dashes: bool = False

    @property
    def inner(self) -> int:
        return self.column + STEP * (2 if self.dashes else 1)


class _Layout:
    def __init__(self, text: str) -> None:
        self.lines = text.split("\n")
        self.indents: dict[int, int] = {}  # line -> column where its first token belongs
        self.edits: dict[int, list[_Edit]] = {}
        self.ends: dict[int, int] = {}  # line -> column where its last token ends
        self.inside: set[int] = set()  # lines that begin within a scalar
        self._blocks: list[_Block] = []
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        self._scan(list(yaml.scan(text, Loader=loader)))

    def _scan(self, tokens: list[Token]) -> None:
        before: Token | None = None
        flow = 0
        for token in tokens:
            if isinstance(token, _BLOCKS):
                inner = self._blocks[-1].inner if self._blocks else 0
                self._blocks.append(_Block(inner, isinstance(token, BlockMappingStartToken)))
            elif isinstance(token, BlockEndToken):
                self._blocks.pop()
            elif not flow and isinstance(token, BlockEntryToken | KeyToken):
                self._starts(token)
            flow += isinstance(token, _OPENING) - isinstance(token, _CLOSING)
            if token.start_mark.index == token.end_mark.index:
                continue
            if before is not None:
                self._gap(before, token)
            self._occupies(token)
            before = token

    def _starts(self, token: Token) -> None:
        block = self._blocks[-1]
        block.dashes = block.mapping and isinstance(token, BlockEntryToken)
        mark = token.start_mark
        if not self.lines[mark.line][: mark.column].strip():
            self.indents[mark.line] = block.column + (STEP if block.dashes else 0)

    def _gap(self, before: Token, token: Token) -> None:
        """Set the gap between two tokens of one line: nothing, or one blank."""
        end, start = before.end_mark, token.start_mark
        if end.line != start.line or "#" in self.lines[end.line][end.column : start.column]:
            return
        tight = isinstance(before, _OPENING) or isinstance(token, (*_CLOSING, FlowEntryToken))
        tight = tight or isinstance(token, ValueToken)
        gap = _Edit(end.column, start.column, "" if tight else " ")
        self.edits.setdefault(end.line, []).append(gap)

    def _occupies(self, token: Token) -> None:
        start, end = token.start_mark, token.end_mark
        if isinstance(token, ScalarToken) and end.line > start.line:
            self.inside |= set(range(start.line + 1, end.line + bool(end.column)))
        self.ends[end.line] = end.column

    def code(self, number: int) -> tuple[str, str]:
        """The tidied code of a line, without its indentation, and the comment behind it."""
        line = self.lines[number]
        end = self.ends.get(number, 0)
        pieces, at = [], 0
        for edit in self.edits.get(number, []):
            pieces += [line[at : edit.start], edit.text]
            at = edit.end
        return "".join([*pieces, line[at:end]]).strip(), line[end:].strip()


def rows(text: str) -> Iterator[Row]:
    layout = _Layout(text)
    shift = 0
    waiting: list[str] = []  # comment lines: they are indented as the next line of code
    for number, line in enumerate(layout.lines):
        old = len(line) - len(line.lstrip())
        if number in layout.inside:
            yield Row(f"{' ' * max(0, old + shift)}{line.strip()}" if line.strip() else "")
            continue
        if number not in layout.ends:
            waiting.append(line.strip())
            continue
        code, comment = layout.code(number)
        indent = layout.indents.get(number, max(STEP, old + shift))
        if number in layout.indents:
            shift = indent - old
        elif not code.strip("{}[]-."):
            indent = max(0, old + shift)
        yield from (Row(" " * indent + text if text else "") for text in waiting)
        waiting = []
        yield Row(" " * indent + code, comment)
    yield from map(Row, waiting)
