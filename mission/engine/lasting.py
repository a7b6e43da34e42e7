"""For how long each of several conditions has lasted, with tolerance for noise.

Time in which a condition does not hold takes twice its length back, and does not end the condition
by itself. So a condition that holds for more than two thirds of the time lasts in the end. One that
holds without a break lasts exactly from its beginning.
"""

from __future__ import annotations

from collections.abc import Container
from typing import Self

from mission.model.copies import copied

BACK = 2.0  # s that each second in which a condition does not hold takes back


class Lasting:
    __slots__ = ("_gone", "_since")

    def __init__(self) -> None:
        self._since: dict[str, float] = {}  # when it would have begun, without its breaks
        self._gone: dict[str, float] = {}  # since when one that held does not hold

    def __bool__(self) -> bool:
        return bool(self._since)

    def clone(self) -> Self:
        return copied(self)

    def holds(self, name: str, now: float) -> float:
        """Note that the condition holds; return since when."""
        since = self._since.setdefault(name, now)
        gone = self._gone.pop(name, None)
        if gone is not None:
            since = self._since[name] = min(now, since + (1.0 + BACK) * (now - gone))
        return since

    def breaks(self, name: str, now: float) -> None:
        """Note that the condition does not hold now."""
        since = self._since.get(name)
        if since is None:
            return
        gone = self._gone.setdefault(name, now)
        if since + (1.0 + BACK) * (now - gone) >= now:
            self.forget(name)

    def unseen(self, name: str, seconds: float) -> None:
        """Note so many seconds in which the condition was unknown: they count neither way."""
        for times in (self._since, self._gone):
            if name in times:
                times[name] += seconds

    def forget(self, name: str) -> None:
        self._since.pop(name, None)
        self._gone.pop(name, None)

    def keep(self, names: Container[str]) -> None:
        """Forget all conditions but these."""
        for name in [n for n in self._since if n not in names]:
            self.forget(name)
