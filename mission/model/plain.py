"""Dataclasses as plain JSON values and back, by their type hints."""

from __future__ import annotations

import dataclasses
import enum
import functools
import types
import typing
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar, cast, get_args, get_origin

_D = TypeVar("_D")
# Metadata of a field that is left out if empty: the plain form of older values does not change.
UNSAID = types.MappingProxyType({"unsaid": True})


def to_plain(value: Any) -> Any:
    """Return lists, tables, texts and numbers that ``from_plain`` turns into an equal value."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        told = {f: getattr(value, f.name) for f in dataclasses.fields(value)}
        return {f.name: to_plain(v) for f, v in told.items() if v or "unsaid" not in f.metadata}
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
    read: Callable[[Any], _D] = _reader(cast("Any", kind))
    return read(data)


@functools.cache  # hints are looked up once for a type, not once for a value
def _reader(kind: Any) -> Callable[[Any], Any]:
    origin, args = get_origin(kind), get_args(kind)
    named = dataclasses.is_dataclass(kind) or hasattr(kind, "_fields")  # or a named tuple
    if named and isinstance(kind, type):
        hints = typing.get_type_hints(kind)
        return lambda data: kind(**{name: _reader(hints[name])(v) for name, v in data.items()})
    if origin in (types.UnionType, typing.Union):
        some = next(a for a in args if a is not type(None))
        return lambda data: None if data is None else _reader(some)(data)
    if origin is tuple:
        return _tuple_reader(args)
    if origin in (frozenset, set):
        return lambda data: origin(_reader(args[0])(v) for v in data)
    if origin is Counter:
        return Counter
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return lambda data: {k: _reader(args[1])(v) for k, v in data.items()}
    is_made = isinstance(kind, type) and issubclass(kind, Path | enum.Enum)
    return kind if is_made else lambda data: data


def _tuple_reader(kinds: tuple[Any, ...]) -> Callable[[Any], Any]:
    if kinds[-1] is Ellipsis:
        return lambda data: tuple(_reader(kinds[0])(v) for v in data)
    return lambda data: tuple(_reader(k)(v) for k, v in zip(kinds, data, strict=True))
