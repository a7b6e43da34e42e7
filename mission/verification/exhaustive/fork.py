"""Copy a runtime with everything that decides what it does next, in a fraction of a ms.

Objects that can change are copied. Those that cannot are shared: frozen values, tables, functions.
The object graph is walked once and kept as a recipe: empty objects to create, then the content of
each. The engine has its own snapshot, which shares machine and navigation. So only the copy that
was made last may be used.

What does not live here: what a copy is used for (run).
"""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from types import FunctionType, MethodType
from typing import Any, Generic, TypeVar, cast

from mission.engine.engine import Engine
from mission.model.copies import held, is_fixed, slots_of
from protocol.fields import FrameType

T = TypeVar("T")
_OURS = ("mission.", "protocol.")
_Key = Any
_Link = tuple[_Key, int, FunctionType | None]  # a part's key, its node, or a method of that


@dataclasses.dataclass(slots=True)
class _Node:
    """One object of the recipe: ``make`` creates it empty (the shell), ``fill`` puts the shared
    and the linked parts into it."""

    make: Callable[[], Any]
    fill: Callable[[Any, list[tuple[_Key, Any]]], None]
    links: list[_Link]


class Fork(Generic[T]):
    """The state of ``whole`` now; ``copy`` recreates it any number of times."""

    def __init__(self, whole: T) -> None:
        self._nodes: list[_Node] = []
        self._places: dict[int, int] = {}
        self._whole = whole  # kept alive, so that no id() is used again
        self._note(whole)

    def copy(self) -> T:
        shells = [node.make() for node in self._nodes]
        for node, shell in zip(self._nodes, shells, strict=True):
            node.fill(
                shell,
                [
                    (key, shells[i] if method is None else MethodType(method, shells[i]))
                    for key, i, method in node.links
                ],
            )
        return cast("T", shells[0])

    def _note(self, value: Any) -> int:
        """Return the number of the value's node, which is made if it is new."""
        if (place := self._places.get(id(value))) is not None:
            return place
        place = self._places[id(value)] = len(self._nodes)
        node = _Node(list, _nothing, [])
        self._nodes.append(node)
        kind = type(value)
        if kind is Engine:
            node.make, node.fill = partial(Engine.__new__, Engine), _engine(value)
        elif kind is list or kind is deque:
            shared = self._parts(enumerate(value), node)
            ends = value.maxlen if kind is deque else None
            node.make = partial(deque, maxlen=ends) if kind is deque else list
            node.fill = partial(_fill_sequence, [shared.get(i) for i in range(len(value))])
        elif kind is dict:
            node.make, node.fill = dict, partial(_fill_dict, self._parts(value.items(), node))
        elif kind is set:
            node.make, node.fill = partial(set, frozenset(value)), _nothing
        else:
            node.make = partial(kind.__new__, kind)
            fill = _fill_slots if slots_of(kind) else _fill_object
            node.fill = partial(fill, self._parts(held(value).items(), node))
        return place

    def _parts(self, items: Iterable[tuple[_Key, Any]], node: _Node) -> dict[_Key, Any]:
        """Return the parts that are shared, by key; the others become links of the node."""
        shared = {}
        for key, value in items:
            if isinstance(value, MethodType):
                function = cast("FunctionType", value.__func__)
                node.links.append((key, self._note(value.__self__), function))
            elif _is_shared(type(value)):
                shared[key] = value
            else:
                node.links.append((key, self._note(value), None))
        return shared


def _nothing(shell: Any, linked: list[tuple[_Key, Any]]) -> None:
    pass


def _fill_sequence(shared: list[Any], shell: Any, linked: list[tuple[_Key, Any]]) -> None:
    shell.extend(shared)
    for place, value in linked:
        shell[place] = value


def _fill_dict(
    shared: dict[Any, Any], shell: dict[Any, Any], linked: list[tuple[_Key, Any]]
) -> None:
    shell.update(shared)
    shell.update(linked)


def _fill_object(shared: dict[str, Any], shell: Any, linked: list[tuple[_Key, Any]]) -> None:
    shell.__dict__.update(shared)
    shell.__dict__.update(linked)


def _fill_slots(shared: dict[str, Any], shell: Any, linked: list[tuple[_Key, Any]]) -> None:
    for name, value in (*shared.items(), *linked):
        setattr(shell, name, value)


def _engine(engine: Engine) -> Callable[[Any, list[tuple[_Key, Any]]], None]:
    snapshot, own = engine.snapshot(), held(engine)

    def fill(shell: Any, linked: list[tuple[_Key, Any]]) -> None:
        _fill_slots(own, shell, linked)
        shell.restore(snapshot)

    return fill


_KNOWN: dict[type, bool] = {}


def _is_shared(kind: type) -> bool:
    if kind not in _KNOWN:
        fixed = is_fixed(kind) or issubclass(kind, FrameType | BaseException)
        copied = kind in (list, dict, set, deque, Engine) or kind.__module__.startswith(_OURS)
        _KNOWN[kind] = fixed or not copied
    return _KNOWN[kind]
