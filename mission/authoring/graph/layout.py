"""The layout of the picture: the outline as rows, the rows in columns of a page.

    Outline --rows--> [open group | card with its ways | close group] --columns--> Placed

A group stays in one column if possible; if not, its frame is cut and continues in the next column.
Heights follow from the wrapped texts. What does not live here: colours and SVG.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from mission.authoring.graph.canvas import (
    BADGE,
    DETAIL,
    LINE,
    NAME,
    WAY,
    lead,
    pill_width,
    width,
    wrap,
)
from mission.authoring.graph.outline import Node, Outline, Way

INSET = 9.0  # px from a group's frame to its content
STEM = 13.0  # px from a card's left edge to the arrow to the next leg
BRANCH = 11.0  # px, length of a jump's arrow
MIN_COLUMN, MAX_COLUMN = 210.0, 330.0
GAP = 22.0  # px between columns
CUT = 7.0  # px above the first row of a column, for each group that continues in it
A4 = 210 / 297
NARROWEST = 560.0  # px: a small mission need not fill its page


@dataclass(frozen=True, slots=True)
class WayLines:
    """A way's text, wrapped so that the last line leaves room for the target's box."""

    way: Way
    lines: tuple[str, ...]
    target: str


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the picture. ``kind``: open, card or close. ``level`` 0 is the mission's own level.
    ``fall``: an arrow leads down from it to the next row."""

    kind: str
    node: Node
    level: int
    height: float
    lines: tuple[str, ...] = ()
    ways: tuple[WayLines, ...] = ()
    fall: bool = False


@dataclass(frozen=True, slots=True)
class Placed:
    row: Row
    column: int
    x: float
    y: float
    w: float


@dataclass(frozen=True, slots=True)
class Layout:
    rows: tuple[Placed, ...]
    column_width: float
    columns: int
    height: float
    cuts: int  # levels of groups that column ends cut through

    @property
    def width(self) -> float:
        return self.columns * (self.column_width + GAP) - GAP


def arrange(outline: Outline, above: float) -> Layout:
    """The layout with the number of columns that prints largest on an A4 page; head and foot take
    ``above`` px of its height."""
    column = _wanted_width(outline)
    rows = _rows(outline, column)
    total = sum(row.height for row in rows)
    most = 2 + int((total / column) ** 0.5)
    layouts = [_columns(rows, column, count) for count in range(1, most + 1)]
    return min(layouts, key=lambda layout: _cost(layout, above))


def _cost(layout: Layout, above: float) -> float:
    """Width in px of the A4 page that holds the layout, plus 10 % for each cut group."""
    page = max(layout.width, (layout.height + above) * A4, NARROWEST)
    return page * (1 + 0.1 * layout.cuts)


def _wanted_width(outline: Outline) -> float:
    need = MIN_COLUMN
    for node in outline.walk():
        indent = 2 * INSET * node.path.count("/")
        if len(node.lines) == 1 and _one_line(node) + indent < MAX_COLUMN:
            need = max(need, _one_line(node) + indent)
        for line in node.lines:
            need = max(need, width(line, DETAIL) + 30 + indent)
        for way in node.ways:
            pill = 0.0 if way.falls else pill_width(outline.label(way.target)) + 16
            need = max(need, width(way.text, WAY) + pill + STEM + BRANCH + 6 + indent)
    return min(need, MAX_COLUMN)


def beside(node: Node, room: float) -> bool:
    """Whether the leg's one line of details fits behind its name."""
    return len(node.lines) == 1 and node.repeat == 1 and _one_line(node) <= room


def badge_width(node: Node) -> float:
    return width(node.number, BADGE) + 9


def _one_line(node: Node) -> float:
    details = sum(width(line, DETAIL) for line in node.lines)
    return badge_width(node) + width(node.name, NAME) + details + 30


def _rows(outline: Outline, column: float) -> list[Row]:
    rows: list[Row] = []
    for node in outline.nodes:
        _node_rows(outline, node, 0, column, rows)
    return rows


def _node_rows(outline: Outline, node: Node, level: int, column: float, rows: list[Row]) -> None:
    room = column - 2 * INSET * level
    hang = STEM + BRANCH + 4 if not node.children else 18
    ways = tuple(way_lines(outline, way, room - hang) for way in node.ways)
    if not node.children:
        lines = tuple(line for text in node.lines for line in wrap(text, DETAIL, room - 18))
        lines = () if beside(node, room) else lines
        height = 21.0 + 12 * len(lines) + 4
        branch = sum(LINE * len(way.lines) for way in ways)
        fall = any(way.way.falls for way in ways)
        rows.append(Row("card", node, level, height + max(branch + 5, 10), lines, ways, fall))
        return
    height = 24 + sum(LINE * len(way.lines) for way in ways) + (2 if ways else 0)
    rows.append(Row("open", node, level, height, (), ways))
    for child in node.children:
        _node_rows(outline, child, level + 1, column, rows)
    falls = rows[-1].fall
    rows.append(Row("close", node, level, 18.0 if falls else 12.0, fall=falls))


def way_lines(outline: Outline, way: Way, room: float) -> WayLines:
    target = "" if way.falls else outline.label(way.target)
    return WayLines(way, lead(way.text, target, room), target)


def _columns(rows: list[Row], column: float, count: int) -> Layout:
    """Arrange the rows in at most ``count`` columns, as low as possible."""
    room = sum(row.height for row in rows) / count
    while len(breaks := _breaks(rows, room)) >= count:
        room *= 1.03
    placed: list[Placed] = []
    tallest = 0.0
    for index, (start, end) in enumerate(pairwise([0, *breaks, len(rows)])):
        x0, y = index * (column + GAP), CUT * depth_at(rows[start])
        for row in rows[start:end]:
            inset = INSET * row.level
            placed.append(Placed(row, index, x0 + inset, y, column - 2 * inset))
            y += row.height
        tallest = max(tallest, y)
    cuts = sum(depth_at(rows[index]) for index in breaks)
    return Layout(tuple(placed), column, len(breaks) + 1, tallest, cuts)


def _breaks(rows: list[Row], room: float) -> list[int]:
    """The first rows of the second and later columns; full columns are cut near their end, at the
    outermost level."""
    result: list[int] = []
    start, used, index = 0, 0.0, 0
    while index < len(rows):
        if used + rows[index].height > room and index > start:
            index = _best_cut(rows, start, index)
            result.append(index)
            start, used = index, 0.0
            continue
        used += rows[index].height
        index += 1
    return result


def _best_cut(rows: list[Row], start: int, full: int) -> int:
    """The cut at the outermost level in the last 40 % of the column, and the last of these."""
    filled = sum(row.height for row in rows[start:full])
    best, height = full, 0.0
    for index in range(full, start, -1):
        if height > 0.4 * filled:
            break
        if depth_at(rows[index]) < depth_at(rows[best]) or not _may_cut(rows, best):
            best = index
        height += rows[index - 1].height
    return best


def depth_at(row: Row) -> int:
    return row.level + (1 if row.kind == "close" else 0)


def _may_cut(rows: list[Row], index: int) -> bool:
    """Whether a column may end here: not directly after a group's head, nor before its foot."""
    return rows[index - 1].kind != "open" and rows[index].kind != "close"
