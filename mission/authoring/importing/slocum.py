"""Slocum gliders' goto lists (goto_lNN.ma): arguments, then waypoints, longitude first.

    b_arg: list_when_wpt_dist(m) 10
    <start:waypoints>
    -7411.587  3927.437     DDDMM.mmm: 74 deg 11.587' west, 39 deg 27.437' north

The list is flown once, from its first point.
"""

from __future__ import annotations

import math
from functools import partial

from mission.authoring.importing.route import (
    At,
    Findings,
    Point,
    Route,
    Source,
    Step,
    along,
    number,
    position,
    text_of,
)

_START, _END = "<start:waypoints>", "<end:waypoints>"


def read(data: bytes, found: Findings) -> Source:
    lines = text_of(data, found, "latin-1").split("\n")
    return Source((Route("", "the list", partial(_steps, lines, found)),))


def _steps(lines: list[str], found: Findings) -> tuple[Step, ...]:
    plain = [line.partition("#")[0].strip() for line in lines]
    if "behavior_name=goto_list" not in (line.replace(" ", "").lower() for line in plain):
        found.refuse(
            "plan-format", "", "no behavior_name=goto_list", "a .mi has no points, its .ma has"
        )
    if _START not in plain or _END not in plain:
        raise found.refusal("plan-format", "", f"no {_START} ... {_END}")
    first, last = plain.index(_START) + 1, plain.index(_END)
    within = _arguments(plain[:first], last - first, found)
    return along(
        _point(line, row, within, found) for row, line in enumerate(plain[:last], 1) if row > first
    )


def _arguments(lines: list[str], most: int, found: Findings) -> float | None:
    within = None
    for where, line in enumerate(lines, 1):
        words = line.split()
        if len(words) != 3 or words[0] != "b_arg:":
            continue
        name = words[1].partition("(")[0]
        value = number(words[2], name, where, found)
        if name == "list_when_wpt_dist" and value:
            within = value
        elif name == "num_legs_to_run" and value not in (None, -2.0):
            found.leave_out(where, f"{name} {words[2]}: the list is flown once")
        elif name == "initial_wpt" and value not in (None, 0.0):
            found.leave_out(where, f"{name} {words[2]}: the list is flown from its first point")
    return within


def _point(line: str, where: At, within: float | None, found: Findings) -> Point | None:
    words = line.split()
    if not words:
        return None
    if len(words) != 2:
        found.refuse("position", where, f"{line[:40]!r} is not a longitude and a latitude")
        return None
    longitude, latitude = (_degrees(word, where, found) for word in words)
    if longitude is None or latitude is None:
        return None
    place = position(latitude, longitude, where, found)
    return Point(place, where, within=within) if place is not None else None


def _degrees(text: str, where: At, found: Findings) -> float | None:
    """DDDMM.mmm: the last two digits before the point are minutes."""
    value = number(text, "a coordinate", where, found)
    if value is None:
        return None
    degrees, minutes = divmod(abs(value), 100.0)
    if minutes >= 60.0:
        found.refuse("position", where, f"{text}: minutes go to 60", "write DDDMM.mmm")
        return None
    return math.copysign(degrees + minutes / 60.0, value)
