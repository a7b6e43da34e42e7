"""One drive as many: a copy of all that decides what it does next, made in a fraction of a ms.

What can change is copied, what cannot is shared: frozen values, tables, functions. The engine has
its own snapshot, which shares machine and navigation: of all copies, the one that was made last is
the one that may be used.

What does not live here: what a copy is used for (run).
"""

from __future__ import annotations

import dataclasses
import enum
from collections import deque
from collections.abc import Callable
from types import MethodType
from typing import Any, Generic, TypeVar

from mission.engine import Engine, Snapshot
from protocol.fields import FrameType

T = TypeVar("T")
_Copy = Callable[[Any, "_Forking"], Any]
_OURS = ("mission.", "protocol.")


class Fork(Generic[T]):
    """``whole`` as it is now; ``copy`` gives it again, any number of times."""

    def __init__(self, whole: T) -> None:
        self._whole: T = _Forking(None).of(whole)
        self._engines = {id(e): e.snapshot() for e in engines_in(self._whole)}

    def copy(self) -> T:
        whole: T = _Forking(self._engines).of(self._whole)
        return whole


def engines_in(whole: object) -> list[Engine]:
    looking = _Forking(None)
    looking.of(whole)
    return looking.engines


class _Forking:
    def __init__(self, snapshots: dict[int, Snapshot] | None) -> None:
        self._done: dict[int, Any] = {}
        self._snapshots = snapshots
        self.engines: list[Engine] = []

    def of(self, value: Any) -> Any:
        kind = type(value)
        copier = _COPIERS.get(kind)
        if copier is None:
            copier = _COPIERS[kind] = _copier(kind)
        if copier is _share:
            return value
        known = self._done.get(id(value))
        return copier(value, self) if known is None else known

    def keep(self, value: Any, copy: Any) -> Any:
        self._done[id(value)] = copy
        return copy

    def engine(self, engine: Engine) -> Engine:
        other = object.__new__(Engine)
        self.keep(engine, other)
        other.__dict__.update(engine.__dict__)
        other.restore((self._snapshots or {}).get(id(engine)) or engine.snapshot())
        self.engines.append(engine)
        return other


def _share(value: Any, forking: _Forking) -> Any:
    return value


def _list(value: list[Any], forking: _Forking) -> list[Any]:
    copy: list[Any] = forking.keep(value, [])
    copy += [forking.of(one) for one in value]
    return copy


def _dict(value: dict[Any, Any], forking: _Forking) -> dict[Any, Any]:
    copy: dict[Any, Any] = forking.keep(value, {})
    copy.update((key, forking.of(one)) for key, one in value.items())
    return copy


def _set(value: set[Any], forking: _Forking) -> set[Any]:
    return forking.keep(value, set(value))  # type: ignore[no-any-return]


def _deque(value: deque[Any], forking: _Forking) -> deque[Any]:
    copy: deque[Any] = forking.keep(value, deque(maxlen=value.maxlen))
    copy.extend(forking.of(one) for one in value)
    return copy


def _method(value: MethodType, forking: _Forking) -> MethodType:
    return MethodType(value.__func__, forking.of(value.__self__))


def _object(value: Any, forking: _Forking) -> Any:
    kind = type(value)
    copy = forking.keep(value, object.__new__(kind))
    for name in _slots(kind):
        if hasattr(value, name):
            setattr(copy, name, forking.of(getattr(value, name)))
    for name, one in getattr(value, "__dict__", {}).items():
        copy.__dict__[name] = forking.of(one)
    return copy


def _slots(kind: type) -> list[str]:
    return [name for base in kind.__mro__ for name in base.__dict__.get("__slots__", ())]


_COPIERS: dict[type, _Copy] = {
    list: _list,
    dict: _dict,
    set: _set,
    deque: _deque,
    MethodType: _method,
    Engine: lambda engine, forking: forking.engine(engine),
}


def _copier(kind: type) -> _Copy:
    frozen = dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    fixed = issubclass(kind, enum.Enum | FrameType | type | tuple | BaseException)
    ours = kind.__module__.startswith(_OURS)
    return _share if frozen or fixed or not ours else _object
