"""The foot of the picture: the regions idle, autonomous, manual and emergency.

There is one box per region with its states and, in the order of the table, the transitions that all
missions share. What does not live here: the mission's legs (svg.py).
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.authoring.graph.canvas import LINE, NAME, Style, box, lead, leader, text, width
from mission.authoring.graph.regions import REGIONS, SUBSTATES, region, target
from mission.model import AUTONOMOUS
from mission.model.regions import RegionEdge

GAP = 12.0
SHARES = (0.22, 0.26, 0.23, 0.29)  # of the width, if all four stand in one row
COLOURS = {
    "idle": ("#f8fafc", "#64748b"),
    AUTONOMOUS: ("#eef4fb", "#2563a8"),
    "manual": ("#fefce8", "#a16207"),
    "emergency": ("#fef2f2", "#b91c1c"),
}
STATE = Style(9.0, "#10243e", anchor="middle")


@dataclass(frozen=True, slots=True)
class _Entry:
    lines: tuple[str, ...]
    target: str

    @property
    def height(self) -> float:
        return LINE * len(self.lines)


def panel(rows: tuple[RegionEdge, ...], x: float, y: float, room: float) -> tuple[list[str], float]:
    """The SVG elements and their height in px; from (x, y), ``room`` px wide."""
    across = len(REGIONS) if room >= 900 else 2
    shares = SHARES if across == len(REGIONS) else (0.5, 0.5)
    parts: list[str] = []
    top = y
    for start in range(0, len(REGIONS), across):
        names = REGIONS[start : start + across]
        widths = [share * (room - GAP * (across - 1)) for share in shares]
        band = [_entries(name, rows, wide) for name, wide in zip(names, widths, strict=True)]
        height = max(34 + sum(entry.height for entry in entries) for entries in band)
        left = x
        for name, entries, wide in zip(names, band, widths, strict=True):
            parts += _region(name, entries, left, top, wide, height)
            left += wide + GAP
        top += height + GAP
    return parts, top - GAP - y


def _entries(name: str, rows: tuple[RegionEdge, ...], wide: float) -> list[_Entry]:
    found: list[_Entry] = []
    for row in rows:
        if region(row.source) != name:
            continue
        own = f"{row.source.partition('/')[2]}: " if "/" in row.source else ""
        end = target(row)
        end = end.partition("/")[2] if region(end) == name else end
        found.append(_Entry(lead(own + row.meaning, end, wide - 20), end))
    return found


def _region(
    name: str, entries: list[_Entry], x: float, y: float, wide: float, height: float
) -> list[str]:
    fill, stroke = COLOURS[name]
    parts = [box(x, y, wide, height, fill, stroke, 6.0), text(x + 11, y + 17, name, NAME)]
    parts += _states(name, x + 11 + width(name, NAME) + 8, y)
    at = y + 36.0
    for entry in entries:
        parts.append(leader(entry.lines, entry.target, x + 11, x + wide - 8, at, stroke))
        at += entry.height
    return parts


def _states(name: str, x: float, y: float) -> list[str]:
    if name == AUTONOMOUS:
        return [text(x, y + 17, "the legs above", Style(9.0, COLOURS[name][1]))]
    parts: list[str] = []
    for state in SUBSTATES:
        if region(state) == name:
            label = state.partition("/")[2]
            wide = width(label, STATE) + 10
            parts.append(box(x, y + 7, wide, 14, "#ffffff", COLOURS[name][1], 7.0))
            parts.append(text(x + wide / 2, y + 17, label, STATE))
            x += wide + 5
    return parts
