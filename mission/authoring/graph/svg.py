"""The state graph as SVG: nested boxes in columns on one page, readable with forty legs.

- A card is a leg: its number and name, what it does, its complete set. Below it are its ways out in
  the order in which they are tested. The arrow downward leads to the next leg; every other way
  leads to the right, to the name of its target.
- A group is a frame; an arrow upward at its left edge shows that the group repeats.
- Idle, manual and emergency stand at the foot (panel.py).
- Cards and frames have their state's path as ``data-path``, so a viewer can highlight the active
  one.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from mission.authoring.graph import words
from mission.authoring.graph.canvas import (
    BADGE,
    DETAIL,
    LINE,
    NAME,
    Style,
    arrow,
    box,
    document,
    element,
    leader,
    line,
    text,
    wrap,
)
from mission.authoring.graph.layout import (
    BRANCH,
    CUT,
    GAP,
    NARROWEST,
    STEM,
    Layout,
    Placed,
    WayLines,
    arrange,
    badge_width,
    beside,
    depth_at,
)
from mission.authoring.graph.outline import Outline
from mission.authoring.graph.panel import panel
from mission.authoring.graph.regions import shared
from mission.model import IMPLICIT_SURFACE, By, shown

MARGIN = 26.0
NO_BREAK = "\u00a0"
INK, MUTED, FLOW, LOOP = "#10243e", "#64748b", "#475569", "#2563a8"
TINTS = ("#eef4fb", "#dfeaf7", "#cfdff2", "#bed4ec")
WARM, RED = "#b45309", "#b91c1c"
COLOURS = {By.TIMEOUT: WARM, By.ELSE: WARM, By.ON: RED, By.UNCERTAIN: RED}
TITLE = Style(20.0, INK, bold=True)
ROUNDS = Style(9.0, LOOP, anchor="end")


def svg(outline: Outline, safety: bool = False) -> str:
    """Draw the picture. ``safety``: draw all transitions that missions share, not only the usual
    ones."""
    layout = arrange(outline, 380.0 if safety else 250.0)
    page = max(layout.width, NARROWEST) + 2 * MARGIN
    shift = (page - layout.width) / 2
    body, head = _head(outline, page)
    body.append(f'<g transform="translate({shift:.6g} {head:.6g})">')
    body += [*_frames(layout), *_cards(layout), *_onward(layout), "</g>"]
    strip, height = panel(shared(safety), MARGIN, head + layout.height + 26, page - 2 * MARGIN)
    title = f"Mission {outline.chart.mission.name}"
    return document(page, head + layout.height + height + 46, title, body + strip)


def _head(outline: Outline, page: float) -> tuple[list[str], float]:
    """Title, conditions and the mission's own handlers; and the y at which the legs begin."""
    mission, chart = outline.chart.mission, outline.chart
    legs = sum(1 for s in chart.states if s.leg is not None and s.path != IMPLICIT_SURFACE)
    home = shown.place(mission.home) if mission.home is not None else "where it starts"
    conditions = [f"home {home}", f"safety: {words.safety(mission)}"]
    conditions += [f"assumed {words.assumption(name, v)}" for name, v in mission.assume]
    conditions += [f"to achieve {words.achieve(mission.achieve)}"] if mission.achieve else []
    note = Style(9.5, MUTED)
    conditions += [f"vehicle {mission.vehicle}", f"{legs} legs", f"digest {chart.digest[:16]}"]
    whole = [part.replace(" ", NO_BREAK) for part in conditions]
    lines = wrap(" \u00b7 ".join(whole), note, page - 2 * MARGIN)
    parts = [text(MARGIN, 38, mission.name, TITLE)]
    parts += [text(MARGIN, 55 + LINE * i, content, note) for i, content in enumerate(lines)]
    y = 62 + LINE * (len(lines) - 1)
    if not outline.handlers:
        return parts, y + 14
    high = 8 + LINE * len(outline.handlers)
    parts.append(box(MARGIN, y + 6, page - 2 * MARGIN, high, "#fff7f7", "#f0b4b4"))
    for index, way in enumerate(outline.handlers):
        row = WayLines(way, (f"in any leg: {way.text}",), outline.label(way.target))
        right = min(page - MARGIN - 6, MARGIN + 400)
        parts.append(_way(row, MARGIN + 9, right, y + 19 + LINE * index))
    return parts, y + high + 20


def _onward(layout: Layout) -> list[str]:
    """Below the last arrow of a column, the number of the first leg of the next column."""
    parts: list[str] = []
    for before, after in pairwise(layout.rows):
        if before.column != after.column and before.row.fall:
            end = before.y + before.row.height + 10
            style = Style(8.5, FLOW, anchor="middle")
            parts.append(text(before.x + STEM, end, after.row.node.number.split("-")[0], style))
    return parts


# --- groups ------------------------------------------------------------------------------------


def _frames(layout: Layout) -> list[str]:
    """One frame for each group and each of its columns, outer ones first."""
    parts: list[tuple[int, str]] = []
    for index, placed in enumerate(layout.rows):
        if placed.row.kind != "open":
            continue
        path = placed.row.node.path
        inside = [p for p in layout.rows[index:] if f"{p.row.node.path}/".startswith(f"{path}/")]
        for column in range(inside[0].column, inside[-1].column + 1):
            piece = [p for p in inside if p.column == column]
            x = placed.x + (column - placed.column) * (layout.column_width + GAP)
            parts.append((placed.row.level, _named(path, _frame(placed, piece, x))))
    return [part for _, part in sorted(parts, key=lambda pair: pair[0])]


def _frame(group: Placed, piece: list[Placed], x: float) -> str:
    """Draw a frame. ``piece``: the rows of the group in one column, with its head and foot."""
    node, level = group.row.node, group.row.level
    first, last = piece[0], piece[-1]
    opened, closed = first is group, last.row.kind == "close" and last.row.node is node
    top, end = first.y, last.y + last.row.height
    if not opened:
        top -= CUT * (depth_at(first.row) - level)
    bottom = last.y + 6 if closed else end
    dash = {} if opened and closed else {"stroke_dasharray": "4 3"}
    tint = TINTS[min(level, len(TINTS) - 1)]
    parts = [box(x, top, group.w, bottom - top, tint, "#8fb0d3", 6.0, **dash)]
    if opened:
        parts += _group_head(group)
    if node.repeat > 1:
        head = [(x + 4.5, bottom - 5), (x + 4.5, top + 24)]
        parts.append(arrow(head, LOOP, 1.4) if opened else line(head, LOOP, 1.4))
    if closed and last.row.fall:
        parts.append(arrow([(x + STEM, bottom), (x + STEM, end)], FLOW))
    return "".join(parts)


def _group_head(group: Placed) -> list[str]:
    node, x = group.row.node, group.x
    rounds = "".join(f"{line} \u00b7 " for line in node.lines)
    rounds += f"{node.repeat} times \u00b7 " if node.repeat > 1 else ""
    parts = [
        text(x + 11, group.y + 16, node.name, NAME),
        text(x + group.w - 8, group.y + 16, f"{rounds}{node.number}", ROUNDS),
    ]
    y = group.y + 29
    for way in group.row.ways:
        parts.append(_way(way, x + 11, x + group.w - 7, y))
        y += LINE * len(way.lines)
    return parts


# --- legs --------------------------------------------------------------------------------------


def _cards(layout: Layout) -> list[str]:
    cards = (placed for placed in layout.rows if placed.row.kind == "card")
    return [_named(placed.row.node.path, _card(placed)) for placed in cards]


def _named(path: str, drawn: str) -> str:
    return element("g", drawn, data_path=path.partition("/")[2])


def _card(placed: Placed) -> str:
    row, node, x, y, w = placed.row, placed.row.node, placed.x, placed.y, placed.w
    height = 21 + 12 * len(row.lines)
    last = node.path == IMPLICIT_SURFACE
    badge = badge_width(node)
    parts = [
        box(x, y, w, height, *(("#ecfdf5", "#059669") if last else ("#ffffff", "#7891ad"))),
        box(x + 5, y + 4.5, badge, 13, "#d1fae5" if last else "#e2e8f0", "none", 6.5),
        text(x + 5 + badge / 2, y + 14, node.number, BADGE),
        text(x + 10 + badge, y + 15, node.name, NAME),
    ]
    if node.repeat > 1:
        parts.append(text(x + w - 8, y + 15, f"{node.repeat} times", ROUNDS))
    if beside(node, w):
        style = replace(DETAIL, anchor="end")
        parts.append(text(x + w - 8, y + 15, node.lines[0], style))
    for index, content in enumerate(row.lines):
        parts.append(text(x + 9, y + 28 + 12 * index, content, DETAIL))
    return "".join([*parts, *_stem(placed, y + height)])


def _stem(placed: Placed, top: float) -> list[str]:
    """The ways out below a card, along one vertical line."""
    row, x = placed.row, placed.x + STEM
    parts: list[str] = []
    y, reach = top + 11, top
    for way in row.ways:
        if way.way.falls:
            parts.append(_way(way, x + 7, placed.x + placed.w, y))
        else:
            colour = COLOURS.get(way.way.by, FLOW)
            parts.append(line([(x, y - 3), (x + BRANCH - 3, y - 3)], colour))
            parts.append(_way(way, x + BRANCH, placed.x + placed.w - 1, y))
            reach = y - 3
        y += LINE * len(way.lines)
    if row.fall:
        parts.insert(0, arrow([(x, top), (x, placed.y + row.height)], FLOW))
    elif reach > top:
        parts.insert(0, line([(x, top), (x, reach)], FLOW))
    return parts


def _way(way: WayLines, x: float, right: float, y: float) -> str:
    return leader(way.lines, way.target, x, right, y, COLOURS.get(way.way.by, FLOW))
