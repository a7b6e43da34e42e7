"""Finds which broken rules could have changed a flight: those whose code the flight reaches.

If a flight reaches none of the functions that a break replaces, the flight would be the same with
the rule broken, and is not flown again.

    a function    is reached when it is called; where only its result matters (``Broken.alike``),
                  when the broken one would have returned another result; where it depends on its
                  arguments (``Broken.when``), when it is called with such arguments
    a property    when the broken one would have another value
    LIMITS        when a row that would be left out is breached
    a number      always

What does not live here: how a rule is broken (broken), who asks (noticing).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from mission.verification.campaign.broken import BROKEN
from mission.verification.campaign.surgery import Broken, Surgery, differs, same


@contextmanager
def reached() -> Iterator[set[str]]:
    """Collect the names of the rules in BROKEN that are reached within the context."""
    found: set[str] = set()
    surgeries = []
    try:
        for name, row in BROKEN.items():
            surgeries.append(_Witness(row, functools.partial(found.add, name)))
            row.how(surgeries[-1])
        yield found
    finally:
        for surgery in reversed(surgeries):
            surgery.undo()


class _Witness(Surgery):
    """Replaces each object by one that does the same and tells when it is reached."""

    def __init__(self, row: Broken, tell: Callable[[], None]) -> None:
        super().__init__()
        self._row, self._tell = row, tell

    def put(self, owner: Any, name: str, value: Any) -> None:
        super().put(owner, name, self._watched(self.found(owner, name), value))

    def _watched(self, whole: Any, other: Any) -> Any:
        if isinstance(whole, property):
            return property(self._watched_results(whole.fget, other.fget, same))
        if isinstance(whole, Mapping):
            limits = whole.items()
            return {k: row if k in other else self._watched_limit(row) for k, row in limits}
        if callable(whole):
            return self._watched_results(whole, other, self._row.alike)
        self._tell()
        return whole

    def _watched_results(
        self, whole: Any, other: Any, alike: Callable[[Any, Any], bool]
    ) -> Callable[..., Any]:
        def look(*given: Any, **named: Any) -> Any:
            matters = alike is not differs or self._row.when(*given, **named)
            result = whole(*given, **named)
            if matters and (alike is differs or not alike(result, other(*given, **named))):
                self._tell()
            return result

        return look

    def _watched_limit(self, row: Any) -> Any:
        def breached(watch: Any) -> bool | None:
            result: bool | None = row.breached(watch)
            if result:
                self._tell()
            return result

        return replace(row, breached=breached)
