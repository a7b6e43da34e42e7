"""What a worker sends comes over whole, in the compiled build, too: instances of every dataclass of
the modules that are compiled, with a value of its annotation in each field."""

from __future__ import annotations

import copy
import dataclasses
import enum
import importlib
import pickle
import types
import typing
from collections import abc
from typing import Any

import pytest

from mission.model import compiled

SAMPLES: dict[Any, Any] = {float: 1.5, int: 2, str: "x", bytes: b"x", bool: True, Any: None}


def sample(of: Any) -> Any:
    """A value of an annotation, as far as those of the compiled modules need one."""
    if of in SAMPLES:
        return SAMPLES[of]
    origin, within = typing.get_origin(of), typing.get_args(of)
    if origin in (types.UnionType, typing.Union):
        return None if type(None) in within else sample(within[0])
    if origin is tuple:
        return () if within[-1] is ... else tuple(map(sample, within))
    if origin is abc.Callable:
        return len
    if origin is typing.Literal:
        return within[0]
    if origin is not None:
        return {} if origin is abc.Mapping else origin()
    if issubclass(of, enum.Enum):
        return next(iter(of))
    return made(of) if dataclasses.is_dataclass(of) or hasattr(of, "_fields") else of()


def made(of: Any) -> Any:
    types_of = typing.get_type_hints(of)
    names = getattr(of, "_fields", None) or [field.name for field in dataclasses.fields(of)]
    return of(*(sample(types_of[name]) for name in names))


def dataclasses_of(name: str) -> list[Any]:
    of_it = [c for c in vars(importlib.import_module(name)).values() if isinstance(c, type)]
    return [c for c in of_it if c.__module__ == name and dataclasses.is_dataclass(c)]


# Of what is never copied by itself: arrays, a whole engine, a whole flight, counters of strange keys.
OPAQUE = {"BoardLink", "Track", "_Node", "Snapshot", "Trace", "Splice", "Counters"}


@pytest.mark.parametrize("name", compiled.MODULES)
def test_what_a_module_holds_can_be_copied_and_sent_to_another_process(name: str) -> None:
    """mypyc sets the fields of a frozen one, which raises: no worker could tell what it found."""
    for of in dataclasses_of(name):
        if of.__name__ in OPAQUE:
            continue
        one = made(of)
        for again in (pickle.loads(pickle.dumps(one)), copy.copy(one)):
            assert type(again) is of
            assert repr(again) == repr(one)
