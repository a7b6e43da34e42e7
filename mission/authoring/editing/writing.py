"""Write new legs and areas for a text that has none of the kind to copy.

    timeout = 1.5 d / (v - c) + 60 s, rounded up to 10 s, as for imported plans

A new leg gets the depth and the gear of the mission's last leg that states them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from yaml.nodes import MappingNode

from mission.authoring.editing.handles import Handle, frame_of
from mission.authoring.editing.layout import EditError, Layout, Span, YamlLayout
from mission.authoring.editing.numbers import plain
from mission.authoring.language import Draft
from mission.authoring.language.clauses import (
    AreaText,
    Clause,
    End,
    HomeAt,
    LegText,
    MissionHead,
    Opening,
    Value,
)
from mission.model import Where
from mission.model.shipped import load_vehicle

# What can be added, each with the word before its place.
LEGS: Mapping[str, str] = MappingProxyType({"goto": "goto", "rows": "from", "loiter": "loiter"})
AREAS: Mapping[str, str] = MappingProxyType({"keep_out": "keep out", "keep_in": "keep in"})

_ROWS = (("rows", "4"), ("bearing", "90"), ("length", "100 m"), ("spacing", "20 m"),
         ("side", "starboard"))  # fmt: skip
_ROWS_WAY = 4 * (100.0 + 20.0)  # m
_CIRCLES = (("radius", "25 m"), ("side", "starboard"))
_HALF = 25.0  # m, half of a new area's side
_GEAR, _DEPTH = "6", "3 m"
_STEP = 10.0  # s


def fresh_name(read: Draft, stem: str) -> str:
    taken = {s.name.text for s in read.statements if isinstance(s, LegText | Opening | AreaText)
             and s.name is not None}  # fmt: skip
    return next(name for n in range(1, len(taken) + 2) if (name := f"{stem}_{n}") not in taken)


def last_leg(read: Draft) -> Where:
    """Where the last leg or group of the mission begins; a new leg comes before it."""
    depth, found = 0, None
    for statement in read.statements:
        if isinstance(statement, End):
            depth -= 1
        elif isinstance(statement, LegText | Opening) and not depth:
            found = statement.where if statement.name is None else statement.name.where
        depth += isinstance(statement, Opening)
    if found is None:
        raise EditError("the mission has no leg yet: write one, for instance up")
    return found


def timeout(read: Draft, what: str, to: tuple[float, float], near: Handle | None) -> float:
    """s for a leg to ``to``, from the place of ``near`` or from home."""
    frame = frame_of(read)
    way = 0.0
    if frame is not None:
        there = frame.to_local(math.radians(to[0]), math.radians(to[1]))
        from_ = None if near is None else near.position
        here = frame.to_local(*map(math.radians, from_)) if from_ is not None else (0.0, 0.0)
        way = math.dist(here, there)
    vehicle = load_vehicle(read.mission.vehicle)
    speed = max(vehicle.speed_by_gear.at(_gear(read)), 0.01)
    way += _ROWS_WAY if what == "rows" else 0.0
    seconds = 1.5 * way / max(speed - vehicle.current, 0.2 * speed) + 60.0
    return math.ceil(seconds / _STEP) * _STEP


def leg(
    read: Draft, layout: Layout, what: str, name: str, to: tuple[float, float], seconds: float
) -> str:
    is_yaml = isinstance(layout, YamlLayout)
    place = place_text(read, to, is_yaml)
    held = [("gear", str(_said(read, "gear") or _GEAR)), _vertical(read)]
    ends = [("timeout", f"{seconds:.0f} s")]
    if what == "rows":
        pairs = [*_ROWS, ("from", place), *held, *ends]
    elif what == "loiter":
        pairs = [("loiter", place), *_CIRCLES, *held, ("for", "4 min")]
    else:
        pairs = [("goto", place), ("within", "15 m"), *held, *ends]
    if is_yaml:
        return f"{name}: {{{', '.join(f'{key}: {value}' for key, value in pairs)}}}"
    return f"{name}: {' '.join(f'{key} {value}' for key, value in pairs)}"


def place_text(read: Draft, at: tuple[float, float], is_yaml: bool) -> str:
    """A place as text: in metres from home if the text names home, else in degrees."""
    frame = frame_of(read)
    if frame is None:
        words, values, decimals, unit = ("latitude", "longitude"), at, 7, ""
    else:
        there = frame.to_local(math.radians(at[0]), math.radians(at[1]))
        words, values, decimals, unit = ("north", "east"), there, 1, " m"
    texts = [plain(value, decimals) + unit for value in values]
    if is_yaml:
        return f"{{{words[0]}: {texts[0]}, {words[1]}: {texts[1]}}}"
    return " ".join(texts) if frame is None else f"north {texts[0]} east {texts[1]}"


def _clauses(read: Draft) -> Iterator[Clause]:
    for statement in read.statements:
        if isinstance(statement, LegText):
            yield from statement.clauses


def _said(read: Draft, word: str) -> str:
    """The amount behind a word in the last leg that has the word; "" if none has it."""
    found = ""
    for clause in _clauses(read):
        if isinstance(clause, Value) and clause.word.text == word and clause.amount is not None:
            found = f"{clause.amount.text} {clause.amount.unit}".strip()
    return found


def _vertical(read: Draft) -> tuple[str, str]:
    return "depth", _said(read, "depth") or _DEPTH


def _gear(read: Draft) -> float:
    try:
        return abs(float(_said(read, "gear") or _GEAR))
    except ValueError:  # a parameter
        return float(_GEAR)


# --- areas ----------------------------------------------------------------------------------------


def area(read: Draft, layout: Layout, what: str, to: tuple[float, float]) -> tuple[Span, str]:
    """Add a square area around the place."""
    frame = frame_of(read)
    if frame is None:
        raise EditError("an area needs a home: write home in the text first")
    here = frame.to_local(math.radians(to[0]), math.radians(to[1]))
    sides = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    around = [(here[0] + n * _HALF, here[1] + e * _HALF) for n, e in sides]
    corners = [f"north {plain(north, 0)} east {plain(east, 0)}" for north, east in around]
    name, lead = fresh_name(read, "area"), "\r\n" if "\r\n" in layout.text else "\n"
    if isinstance(layout, YamlLayout):
        return _yaml_area(layout, what, f"{name}: {{corners: [{', '.join(corners)}]}}", lead)
    line = max(s.where.line for s in read.statements if isinstance(s, HomeAt | MissionHead))
    end = layout.statement(Where(line, 1)).lines.end
    return Span(end, end), f"{lead}{AREAS[what]} {name}: {', '.join(corners)}"


def _yaml_area(layout: YamlLayout, what: str, item: str, lead: str) -> tuple[Span, str]:
    """Add an area to the table of its kind; if there is none, to safety; else behind home."""
    kind, safety = layout.value("safety", what), layout.value("safety")
    if isinstance(kind, MappingNode):
        return _into(layout, kind, item, lead)
    if isinstance(safety, MappingNode):
        return _into(layout, safety, f"{what}: {{{item}}}", lead)
    home = layout.value("home") or layout.value("mission")
    if home is None or safety is not None:
        raise EditError("write safety: {} in the text first")
    end = layout.lines.end(layout.line_of(layout.span(home).end))
    return Span(end, end), f"{lead}safety: {{{what}: {{{item}}}}}"


def _into(layout: YamlLayout, table: MappingNode, item: str, lead: str) -> tuple[Span, str]:
    span = layout.span(table)
    if table.flow_style:
        last = layout.span(table.value[-1][1]).end if table.value else span.begin + 1
        return Span(last, last), f", {item}" if table.value else item
    end = layout.lines.end(layout.line_of(span.end))
    return Span(end, end), f"{lead}{' ' * table.start_mark.column}{item}"
