"""How a rule is broken: values in place of others, in the running objects, and back.

What does not live here: the rules (broken), whether a flight reaches one (reached).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


class Surgery:
    """Puts values in place of others, and back."""

    def __init__(self) -> None:
        self._before: list[tuple[Any, str, Any]] = []

    def put(self, owner: Any, name: str, value: Any) -> None:
        """AttributeError or KeyError if there is nothing of this name to break."""
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
    """Two results of a function on which nothing depends but what it returns."""
    return whole == broken


def differs(whole: object, broken: object) -> bool:
    """A function that does something: to call it is the difference."""
    return False


def whenever(*given: Any, **named: Any) -> bool:
    """Whatever a function is given."""
    return True


def as_healthy(whole: Any, broken: Any) -> bool:
    """Valid, and younger than anybody's patience."""
    return bool(whole.valid) == bool(broken.valid) and whole.age < _PATIENCE


@dataclass(frozen=True, slots=True)
class Broken:
    """``rule`` is broken; ``reason``: why no flight can tell, "" if one can. ``alike``: of what a
    function of the rule returns, whole and broken; true for what makes no difference. ``when``: of
    what a function of the rule is given, where it does something; false for what the broken one
    does in the same way."""

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
    """A property."""
    return instead(owner, name, property(lambda self: result))
