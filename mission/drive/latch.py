"""The latch: what a restart would interrupt, kept durable, so that the next program surfaces.

    a start      is durable before it happens, or it does not happen
    a change     is written at once, an emergency's and the stick's by the timer that follows at
                 once: no disk stands before a STOP or an M
    a failure    never stops the vehicle; it is tried again until the disk takes it

What does not live here: files (store), what a restart does (engine).
"""

from __future__ import annotations

from mission.engine.engine import STICK, UNANSWERED
from mission.store import Store, StoreError

AGAIN_S = 5.0  # until what could not be written is tried again


class Latch:
    def __init__(self, store: Store) -> None:
        self._store, self._kept = store, store.content.under_way
        self._due: float | None = None

    def next_timer(self) -> float | None:
        return self._due

    def handle_timer(self, now: float) -> None:
        if self._due is not None and self._due <= now:
            self._keep(now)

    def follow(self, under_way: str, now: float) -> None:
        """After every step; worth a write are another region, and each state of an emergency."""
        kept = self._kept
        ended = under_way.startswith("emergency")
        if under_way == kept or (_region(under_way) == _region(kept) and not ended):
            return
        self._kept = under_way
        if under_way == STICK or under_way.startswith("emergency"):
            self._due = now
        else:
            self._keep(now)

    def foresee(self, leaf: str) -> str:
        """Before a start: why it could not be made durable, or "". A start that is refused then
        is taken back by ``follow``."""
        if self._kept not in ("", STICK, UNANSWERED):
            return ""
        try:
            self._store.keep_under_way(leaf)
        except StoreError as error:
            return str(error)
        self._kept = leaf
        return ""

    def _keep(self, now: float) -> None:
        self._due = None
        try:
            self._store.keep_under_way(self._kept)
        except StoreError:
            self._due = now + AGAIN_S


def _region(path: str) -> str:
    return path.partition("/")[0]
