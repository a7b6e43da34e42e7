"""Copies of an object's state in which no attribute can be forgotten.

    other = copied(self, machine=self.machine)      # every attribute; those named are given

Values that can change are copied: containers, and objects by their own ``clone``. Values that
cannot are shared. An attribute of neither kind raises TypeError, so that a new attribute cannot be
shared by accident.
"""

from __future__ import annotations

import dataclasses
import enum
import types
from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")

_FIXED = (enum.Enum, tuple, frozenset, str, bytes, int, float, type, types.MappingProxyType)
_CALLED = (types.FunctionType, types.BuiltinFunctionType, types.NoneType)
_CONTAINERS: dict[type, Callable[[Any], Any]] = {
    dict: dict.copy,
    list: list.copy,
    set: set.copy,
    deque: deque.copy,
}
_HOW: dict[type, Callable[[Any], Any] | None] = {}  # None: shared
_NAMES: dict[type, tuple[str, ...]] = {}


def is_fixed(kind: type) -> bool:
    """Whether no value of the type can change, so that it may be shared."""
    frozen = dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    return frozen or issubclass(kind, (*_FIXED, *_CALLED))


def copied(whole: T, /, **given: Any) -> T:
    """Return another object of the type with the attributes ``given``, and copies of all others.
    Raises TypeError for an attribute that can change and has no ``clone``."""
    kind = type(whole)
    other = kind.__new__(kind)
    for name in _NAMES.get(kind) or _attributes(kind, whole):
        if name in given:
            value = given[name]
        else:
            value = getattr(whole, name)
            how = _HOW.get(type(value), _classify)
            if how is not None:
                value = how(value)
        setattr(other, name, value)
    return other


def held(whole: object) -> dict[str, Any]:
    """Return all attributes by name, of dictionary and slots, without slots that are not set."""
    slots = {name: getattr(whole, name) for name in slots_of(type(whole)) if hasattr(whole, name)}
    own: dict[str, Any] = getattr(whole, "__dict__", {})
    return own | slots


def slots_of(kind: type) -> tuple[str, ...]:
    """Return the names of its slots; a compiled class has them in another table."""
    tables = [vars(base) for base in kind.__mro__]
    return tuple(
        name
        for table in tables
        for name in (*table.get("__slots__", ()), *table.get("__mypyc_attrs__", ()))
    )


def _attributes(kind: type, whole: object) -> tuple[str, ...]:
    slots = slots_of(kind)
    if not hasattr(whole, "__dict__"):  # slots alone: all objects of the type have these names
        _NAMES[kind] = slots
    return (*slots, *getattr(whole, "__dict__", ()))


def _classify(value: Any) -> Any:
    """Find how values of this type are copied, and copy the value, the first of its type."""
    kind = type(value)
    if kind in _CONTAINERS:
        _HOW[kind] = _CONTAINERS[kind]
    elif is_fixed(kind):
        _HOW[kind] = None
        return value
    elif hasattr(kind, "clone"):
        _HOW[kind] = kind.clone
    else:
        raise TypeError(f"a copy needs {kind.__name__} to be frozen, or to have a clone()")
    return _HOW[kind](value)  # type: ignore[misc]
