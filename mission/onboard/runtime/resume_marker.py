"""The resume marker: what a restart would interrupt, kept durable; the next program surfaces.

    a start      is durable before it happens, or it does not happen
    a region     is written at once; an emergency, the stick and a stop, of a mission too, by the
                 first timer at which the line has no word due: no disk stands before a STOP or an
                 M. An ascent out of a mission ``AGAIN_S`` later: a restart surfaces by either
    a leg        by that timer, too, 30 of them in a row and then one every ``EVERY_S``: an SD card
                 does not bear one a second. Meanwhile no leg is named, rather than the wrong one
    a rest       in which it may have sunk at once; that it was seen again as a leg, for a depth may
                 come and go each second
    a failure    never stops the vehicle; it is tried again until the disk takes it

What does not live here: files (store), what a restart does (engine).
"""

from __future__ import annotations

from mission.engine.restart import STICK, UNANSWERED, UNSEEN
from mission.model import AUTONOMOUS, SURFACING
from mission.model.regions import EMERGENCY, MANUAL
from mission.onboard.store import Store, StoreError

AGAIN_S = 5.0  # until what could not be written is tried again
EVERY_S = 30.0  # between two writes of legs, on the whole
AHEAD_S = 30 * EVERY_S  # that the writes of legs may be ahead of that
UNNAMED = "(changing too often to be named)"


class ResumeMarker:
    def __init__(self, store: Store) -> None:
        self._store, self._kept = store, store.content.under_way
        self._is = self._kept  # by its name
        self._due: float | None = None
        self._booked = 0.0  # time that the writes of legs so far may take

    def next_timer(self) -> float | None:
        return self._due

    def handle_timer(
        self, now: float, line_due: float | None = None, halfway: bool = False
    ) -> None:
        """``line_due``: when the line to the vehicle has a word; no disk stands before that."""
        if self._due is None or now < self._due or (line_due is not None and line_due <= now):
            return
        if halfway and line_due is not None:  # a set, or an ascent's two words: whole first
            self._due = line_due
            return
        if self._kept != self._is and self._may_name(now):
            self._book(self._is, now)
        self._keep(now)

    def follow(self, under_way: str, now: float) -> None:
        """After every step; each state of an emergency is worth a write, for a restart leads back
        to its end."""
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
        if flew and under_way == SURFACING and self._due is None:  # a restart surfaces by either
            self._due = now + AGAIN_S
        elif _region(under_way) in (EMERGENCY, MANUAL) or under_way in (STICK, UNANSWERED):
            self._due = now
        else:
            self._keep(now)

    def foresee(self, leaf: str) -> str:
        """Before a start: why it could not be made durable, or "". A start that is refused then
        is taken back by ``follow``."""
        if self._kept not in ("", STICK, UNANSWERED, UNSEEN):
            return ""
        try:
            self._store.keep_under_way(leaf)
        except StoreError as error:
            return str(error)
        self._kept = self._is = leaf
        return ""

    def _follow_leg(self, now: float) -> None:
        """Keeps the leg's name. Where another one cannot be kept, the old one is removed."""
        if self._may_name(now):
            self._book(self._is, now)
        elif not self._kept.endswith(UNNAMED):
            self._book(f"{_region(self._is)}/{UNNAMED}", now)

    def _follow_sight(self, now: float) -> None:
        """Keeps that it was seen again; until that may be written it may have sunk."""
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
