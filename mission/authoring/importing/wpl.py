"""QGC WPL 110 (mavlink.io/en/file_formats): a MAVLink item per line, in twelve columns.

    index  current  frame  command  p1 p2 p3 p4  latitude longitude height  autocontinue

An absolute waypoint as the first item is the vehicle's home, as ArduPilot's programs write it. The
order of the lines counts, not the index.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from mission.authoring.importing.mavlink import ABSOLUTE, WAYPOINT, Item, place_of, steps_of
from mission.authoring.importing.route import Findings, Route, Source, number, text_of

HEADER = "QGC WPL"
_COLUMNS = 12


def read(data: bytes, found: Findings) -> Source:
    lines = text_of(data, found).split("\n")
    if lines[0].split() != ["QGC", "WPL", "110"]:
        raise found.refusal("plan-format", 1, "it is not QGC WPL 110")
    items = list(_items(lines[1:], found))
    home = None
    if items and items[0].command == WAYPOINT and items[0].frame == ABSOLUTE:
        home = place_of(items.pop(0), found)
    return Source((Route("", 2, partial(steps_of, items, found)),), home)


def _items(lines: list[str], found: Findings) -> Iterator[Item]:
    index = -1
    for where, text in enumerate(lines, 2):
        columns = text.split()
        if not columns:
            continue
        if len(columns) != _COLUMNS:
            found.refuse("plan-form", where, f"{len(columns)} columns, not {_COLUMNS}")
            continue
        numbers = [number(column, "a column", where, found) for column in columns]
        if None in numbers:
            continue
        whole = [int(n or 0.0) for n in numbers[:4]]
        if whole[0] != index + 1:
            found.leave_out(where, f"index {whole[0]} out of turn: the order of the lines counts")
        index = whole[0]
        yield Item(whole[3], whole[2], numbers[4:11], where)
