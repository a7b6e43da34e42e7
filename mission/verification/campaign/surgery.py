"""How a rule is broken: values in the running objects are replaced, and put back.

What does not live here: the rules (broken), whether a flight reaches one (reached).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


class Surgery:
    """Replaces values, and puts them back."""

    def __init__(self) -> None:
        self._before: list[tuple[Any, str, Any]] = []

    def put(self, owner: Any, name: str, value: Any) -> None:
        """Replace a value. Raises AttributeError or KeyError if there is none of this name."""
        self._before.append((owner, name, self.found(owner, name)))
        setattr(owner, name, value)

    def found(self, owner: Any, name: str) -> Any:
        return vars(owner)[name] if isinstance(owner, type) else getattr(owner, name)

    def undo(self) -> None:
        for owner, name, value in reversed(self._before):
            setattr(owner, name, value)
        self._before.clear()


Break = Callable[[Surgery], None]
_PATIENCE = 5.0  # s: less than any reading's greatest age


def same(whole: object, broken: object) -> bool:
    """Whether two results are equal, for a function of which only the result matters."""
    return whole == broken


def differs(whole: object, broken: object) -> bool:
    """Never alike, for a function with effects: any call of it makes a difference."""
    return False


def whenever(*given: Any, **named: Any) -> bool:
    """True for all arguments of a function."""
    return True


def as_healthy(whole: Any, broken: Any) -> bool:
    """Whether both are valid or both not, and the reading is younger than any age limit."""
    return bool(whole.valid) == bool(broken.valid) and whole.age < _PATIENCE


@dataclass(frozen=True, slots=True)
class Broken:
    """How ``rule`` is broken. ``reason``: why no flight can notice, "" if one can.

    ``alike``: takes the results of a function of the rule, whole and broken; true if they make no
    difference. ``when``: takes the arguments of a function with effects; false if the broken one
    does the same.
    """

    rule: str
    how: Break
    reason: str = ""
    alike: Callable[[Any, Any], bool] = differs
    when: Callable[..., bool] = whenever


def instead(owner: Any, name: str, other: Any) -> Break:
    return lambda s: s.put(owner, name, other)


def nothing(owner: Any, name: str, result: Any = None) -> Break:
    return instead(owner, name, lambda *_args, **_named: result)


def always(owner: type, name: str, result: Any) -> Break:
    """Replace a property by one that is always ``result``."""
    return instead(owner, name, property(lambda self: result))
