"""A topic as columns: its schema flattened, each with kind, unit and meaning; its lines as rows.

    items of a recording --sheets--> Sheet, one for each topic with any line

A table within a value becomes a column for each of its fields (store_limits_depth). This is also so
if only the values know the names (actuators_T1). What does not live here: files (comma, parquet).
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from mission.analysis.journal import Line, Lines, Wanted
from mission.model import Record
from mission.onboard.blackbox import Gap
from mission.onboard.stream.schemas import Schema
from mission.onboard.stream.topics import TOPICS, Topic

TIME, NUMBER, INTEGER, FLAG, TEXT = "time", "number", "integer", "flag", "text"
NUMBERS, TEXTS, JSON = "numbers", "texts", "json"
_SCALARS = {"number": NUMBER, "integer": INTEGER, "boolean": FLAG, "string": TEXT}
_LISTS = {NUMBER: NUMBERS, TEXT: TEXTS}
_NAMES = 256  # names of such a table, at most; a larger table is one JSON text
_INT64 = 2**63


class ExportError(ValueError):
    """The message says what cannot be exported, and where."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column. ``path`` leads to its field in a value; it is empty for the two columns of
    time."""

    name: str
    kind: str
    unit: str
    says: str
    path: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Sheet:
    """One topic. ``rows`` have a cell for each column, None if not known; times in s since 1970."""

    topic: Topic
    columns: tuple[Column, ...]
    rows: tuple[tuple[Any, ...], ...]


_CLOCKS = (
    Column("t_s", NUMBER, "s", "the engine's time, 0 when the program began"),
    Column("time_utc", TIME, "UTC", "wall time"),
)


def sheets(items: Iterable[Record | Gap]) -> Iterator[Sheet]:
    """Yield the sheets of one recording, in the order of the topics. Raises ExportError."""
    reading, found = Lines(Wanted(frozenset(TOPICS))), dict[str, list[Line]]()
    for item in items:
        for line in reading.receive(item):
            found.setdefault(line.topic, []).append(line)
    for topic in TOPICS.values():
        if lines := found.get(topic.name):
            yield _sheet(topic, lines)


def _sheet(topic: Topic, lines: Sequence[Line]) -> Sheet:
    values = [line.value for line in lines]
    fields = [c for c in _columns(topic.schema, values, ()) if c.path != ("t",)]
    rows = ((_t(line), _time(line), *(_cell(column, line) for column in fields)) for line in lines)
    return Sheet(topic, (*_CLOCKS, *fields), tuple(rows))


def _columns(schema: Schema, values: Sequence[Any], path: tuple[str, ...]) -> Iterator[Column]:
    schema = schema["anyOf"][0] if "anyOf" in schema else schema
    for name, field in _fields(schema, values).items():
        within = [one.get(name) if isinstance(one, Mapping) else None for one in values]
        yield from _columns(field, within, (*path, name))
    if path and not _is_table(schema, values):
        unit = schema.get("unit", "")
        says = schema.get("description", "").removeprefix(unit).removeprefix(": ")
        yield Column("_".join(path), _kind(schema), unit, says, path)


def _fields(schema: Schema, values: Sequence[Any]) -> Mapping[str, Schema]:
    if "properties" in schema:
        fields: Mapping[str, Schema] = schema["properties"]
        return fields
    of: Schema = schema.get("additionalProperties") or {}
    return dict.fromkeys(_names(schema, values), of)


def _is_table(schema: Schema, values: Sequence[Any]) -> bool:
    return "properties" in schema or bool(_names(schema, values))


def _names(schema: Schema, values: Sequence[Any]) -> list[str]:
    """Return the sorted names of a table of numbers; none if it is not one, or has too many."""
    of = schema.get("additionalProperties")
    if not isinstance(of, Mapping) or of.get("type") != "number":
        return []
    names = {name for value in values if isinstance(value, Mapping) for name in value}
    return sorted(names) if len(names) <= _NAMES else []


def _kind(schema: Schema) -> str:
    said = schema.get("type")
    named = [said] if isinstance(said, str) else [one for one in said or () if one != "null"]
    if named == ["array"]:
        return _LISTS.get(_kind(schema.get("items", {})), JSON)
    return _SCALARS.get(named[0], JSON) if named else JSON


# --- cells ---------------------------------------------------------------------------------------


def _t(line: Line) -> Any:
    """Return the time with every bit, if the value has it; a message of MCAP has whole ns."""
    return _cell(Column("t", NUMBER, "s", "", ("t",)), line) if "t" in line.value else line.t


def _time(line: Line) -> float:
    try:
        datetime.fromtimestamp(line.wall, UTC)
    except (ValueError, OverflowError, OSError):
        raise ExportError(f"{line.topic} at {line.t:g} s: {line.wall!r} is no wall time") from None
    return line.wall


def _cell(column: Column, line: Line) -> Any:
    value: Any = line.value
    for name in column.path:
        value = value.get(name) if isinstance(value, Mapping) else None
    if value is None:
        return None
    if column.kind == JSON:
        return json.dumps(value)
    if not _fits(column.kind, value):
        where = f"{line.topic} at {line.t:g} s"
        raise ExportError(f"{where}: {column.name} is {value!r:.60}, which is no {column.kind}")
    return float(value) if column.kind == NUMBER else value


def _fits(kind: str, value: Any) -> bool:
    if kind in (NUMBERS, TEXTS):
        of = NUMBER if kind == NUMBERS else TEXT
        return isinstance(value, list) and all(one is None or _fits(of, one) for one in value)
    if kind in (TEXT, FLAG):
        return isinstance(value, str if kind == TEXT else bool)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    whole = isinstance(value, int) and -_INT64 <= value < _INT64
    return whole or (kind == NUMBER and isinstance(value, float))
