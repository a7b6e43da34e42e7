"""Finds which broken rules could have changed a flight: those whose code the flight reaches.

A rule that was not reached, in every function that would be broken, would have had the same flight:
it need not be flown again with the rule broken.

    a function    reached when it is called; or, where nothing but its result matters
                  (``Broken.alike``), when the broken one would have returned something else;
                  where it depends on what it is given, when it is given that (``Broken.when``)
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
    """Of BROKEN, those that are reached while it lasts."""
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
    """Puts the same in place, which tells when it is reached."""

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
