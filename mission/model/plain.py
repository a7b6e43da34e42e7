"""Dataclasses as plain JSON values and back, by their type hints."""

from __future__ import annotations

import dataclasses
import enum
import types
import typing
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

_D = TypeVar("_D")


def to_plain(value: Any) -> Any:
    """Lists, tables, texts and numbers that ``from_plain`` turns back into an equal value."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(k): to_plain(v) for k, v in value.items()}
    if isinstance(value, frozenset | set):
        return sorted(to_plain(v) for v in value)
    if isinstance(value, tuple | list):
        return [to_plain(v) for v in value]
    if isinstance(value, enum.Enum):
        return value.value
    return str(value) if isinstance(value, Path) else value


def from_plain(kind: type[_D], data: Any) -> _D:
    result: _D = _from_plain(kind, data)
    return result


def _from_plain(kind: Any, data: Any) -> Any:
    origin, args = get_origin(kind), get_args(kind)
    named = dataclasses.is_dataclass(kind) or hasattr(kind, "_fields")  # or a named tuple
    if named and isinstance(kind, type):
        hints = typing.get_type_hints(kind)
        return kind(**{name: _from_plain(hints[name], value) for name, value in data.items()})
    if origin in (types.UnionType, typing.Union):
        if data is None:
            return None
        return _from_plain(next(a for a in args if a is not type(None)), data)
    if origin is tuple:
        kinds = args[:1] * len(data) if args[-1] is Ellipsis else args
        return tuple(_from_plain(k, v) for k, v in zip(kinds, data, strict=True))
    if origin in (frozenset, set):
        return origin(_from_plain(args[0], v) for v in data)
    if origin is Counter:
        return Counter(data)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {k: _from_plain(args[1], v) for k, v in data.items()}
    return kind(data) if isinstance(kind, type) and issubclass(kind, Path | enum.Enum) else data
