"""Helpers to write JSON Schemas: every field with its unit and its meaning.

    table(t=number("s", "the engine's time"), depth_m=number("m", "as reported", known=False))

``known`` False: the value is null if it is unknown. A table has all its fields that are not
optional, and no others. The unit is also a key of its own, which validators ignore.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Schema = Mapping[str, Any]


def table(says: str = "", optional: Sequence[str] = (), /, **fields: Schema) -> Schema:
    return _said(
        {
            "type": "object",
            "properties": fields,
            "required": [name for name in fields if name not in optional],
            "additionalProperties": False,
        },
        says,
    )


def number(unit: str, says: str = "", *, known: bool = True) -> Schema:
    schema: dict[str, Any] = {"type": "number" if known else ["number", "null"]}
    if unit:
        schema["unit"] = unit
    return _said(schema, ": ".join(filter(None, (unit, says))))


def count(says: str) -> Schema:
    return _said({"type": "integer"}, says)


def text(says: str, *, known: bool = True) -> Schema:
    return _said({"type": "string" if known else ["string", "null"]}, says)


def flag(says: str, *, known: bool = True) -> Schema:
    return _said({"type": "boolean" if known else ["boolean", "null"]}, says)


def listed(of: Schema, says: str, *, known: bool = True) -> Schema:
    return _said({"type": "array" if known else ["array", "null"], "items": of}, says)


def named(of: Schema, says: str) -> Schema:
    """A table whose names are not known in advance."""
    return _said({"type": "object", "additionalProperties": of}, says)


def absent(of: Schema) -> Schema:
    """A schema that also allows null."""
    return {"anyOf": [of, {"type": "null"}]}


def _said(schema: dict[str, Any], says: str) -> Schema:
    return schema | ({"description": says} if says else {})
