"""The resume marker: what a restart would interrupt, kept durable; the next program surfaces.

    a start      is written before it happens; if that fails, it does not happen
    a region     is written at once. An emergency, the stick and a stop, also of a mission, are
                 written by the first timer at which the line has no command due: no disk delays a
                 STOP or an M. An ascent that ends a mission is written ``AGAIN_S`` later: a restart
                 surfaces in both cases
    a leg        is written by that timer, too: 30 in a row, then one every ``EVERY_S``, because an
                 SD card does not bear one a second. In between the marker names no leg, rather than
                 a wrong one
    a rest       in which the vehicle may have sunk is written at once. That its depth is known
                 again is written like a leg, because a depth may come and go each second
    a failure    never stops the vehicle; the write is tried again until it succeeds

What does not live here: files (store), what a restart does (engine).
"""

from __future__ import annotations

from mission.engine.restart import STICK, UNANSWERED, UNSEEN
from mission.model import AUTONOMOUS, SURFACING
from mission.model.regions import EMERGENCY, MANUAL
from mission.onboard.store import Store, StoreError

AGAIN_S = 5.0  # s until a failed write is tried again
EVERY_S = 30.0  # s between two writes of legs, on average
AHEAD_S = 30 * EVERY_S  # s that the writes of legs may be ahead of the average
UNNAMED = "(changing too often to be named)"


class ResumeMarker:
    def __init__(self, store: Store) -> None:
        self._store, self._kept = store, store.content.under_way
        self._is = self._kept  # what is under way now
        self._due: float | None = None
        self._booked = 0.0  # s: time used up by the writes of legs so far

    def next_timer(self) -> float | None:
        return self._due

    def handle_timer(
        self, now: float, line_due: float | None = None, halfway: bool = False
    ) -> None:
        """``line_due``: when a command to the vehicle is due; no write may delay it."""
        if self._due is None or now < self._due or (line_due is not None and line_due <= now):
            return
        if halfway and line_due is not None:  # first complete a set, or an ascent's two frames
            self._due = line_due
            return
        if self._kept != self._is and self._may_name(now):
            self._book(self._is, now)
        self._keep(now)

    def follow(self, under_way: str, now: float) -> None:
        """Follow the engine after every step. Each state of an emergency is written, because a
        restart returns to the one in which it ended."""
        if under_way == self._is:
            return
        self._is = under_way
        if self._kept == UNSEEN and under_way in ("", UNSEEN):
            self._follow_sight(now)
            return
        ended = _region(under_way) == EMERGENCY
        if _region(under_way) == _region(self._kept) and not ended:
            self._follow_leg(now)
            return
        flew, self._kept = _region(self._kept) == AUTONOMOUS, under_way
        if flew and under_way == SURFACING and self._due is None:  # either way a restart surfaces
            self._due = now + AGAIN_S
        elif _region(under_way) in (EMERGENCY, MANUAL) or under_way in (STICK, UNANSWERED):
            self._due = now
        else:
            self._keep(now)

    def foresee(self, leaf: str) -> str:
        """Write the marker of a start in advance: why that failed, or "". If the start is refused
        afterwards, ``follow`` takes the marker back."""
        if self._kept not in ("", STICK, UNANSWERED, UNSEEN):
            return ""
        try:
            self._store.keep_under_way(leaf)
        except StoreError as error:
            return str(error)
        self._kept = self._is = leaf
        return ""

    def _follow_leg(self, now: float) -> None:
        """Write the leg's name. If it may not be written yet, remove the old name."""
        if self._may_name(now):
            self._book(self._is, now)
        elif not self._kept.endswith(UNNAMED):
            self._book(f"{_region(self._is)}/{UNNAMED}", now)

    def _follow_sight(self, now: float) -> None:
        """Write that the depth is known again; until then the marker says that it may have sunk."""
        if self._is == self._kept:
            return
        if self._may_name(now):
            self._book(self._is, now)
        else:
            self._due = self._booked - AHEAD_S

    def _may_name(self, now: float) -> bool:
        return now >= self._booked - AHEAD_S

    def _book(self, name: str, now: float) -> None:
        self._kept, self._due = name, now
        self._booked = max(self._booked, now) + EVERY_S

    def _keep(self, now: float) -> None:
        try:
            self._store.keep_under_way(self._kept)
            self._due = None if self._kept == self._is else self._booked - AHEAD_S
        except StoreError:
            self._due = now + AGAIN_S


def _region(path: str) -> str:
    return path.partition("/")[0]
