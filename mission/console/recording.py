"""A recording that the page controls: play, pause, seek. It runs in a thread of its own.

    records --Film (run again, once)--> Watched, as if it were a vehicle's monitor

The film is run ahead while there is nothing else to do; times that it has passed are available at
once. What does not live here: what a recording is (replay).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Any

from mission.console.film import Film
from mission.model import Record
from mission.onboard.runtime.records import read_start
from mission.onboard.stream.events import events_of
from mission.topside.monitor import Watched

STEP_S = 0.2  # s, real time
SLOWEST, FASTEST = 1.0, 100.0


class Recording:
    """Raises ValueError if the records do not begin with a start of this version."""

    def __init__(self, records: Sequence[Record]) -> None:
        self.records = records
        self._film = Film(records)
        self.wall = read_start(records[0]).wall
        self.end = self._film.end
        self.shown = 0.0, Watched()  # the position, s, and what a viewer knew then
        self.playing, self.speed = True, SLOWEST
        self._failed = ""
        self._wanted: float | None = 0.0
        self._stirred, self._over = threading.Event(), False

    @property
    def t(self) -> float:
        return self.shown[0]

    @property
    def watched(self) -> Watched:
        return self.shown[1]

    @property
    def problem(self) -> str:
        return self._failed or self._film.problem

    def as_object(self) -> dict[str, Any]:
        return {
            "begin": 0.0,
            "end": self.end,
            "playing": self.playing,
            "speed": self.speed,
            "wall": self.wall,
        }

    def events(self) -> list[dict[str, Any]]:
        """Return the events, each with the time of the frame that shows it."""
        found = (event for record in self.records for event in events_of(record))
        seen = self._film.seen
        return [{"t": seen(e.t), "level": e.level, "of": e.of, "says": e.says} for e in found]

    # --- from other threads --------------------------------------------------------------------

    def play(self, speed: float) -> None:
        if not SLOWEST <= speed <= FASTEST:
            raise ValueError(f"speed {speed:g}: from {SLOWEST:g} to {FASTEST:g}")
        if self.t >= self.end:
            self._wanted = 0.0
        self.speed, self.playing = speed, True
        self._stirred.set()

    def pause(self) -> None:
        self.playing = False

    def seek(self, t: float) -> None:
        self._wanted = min(max(0.0, t), self.end)
        self._stirred.set()

    def stop(self) -> None:
        self._over = True
        self._stirred.set()

    # --- in its own ------------------------------------------------------------------------------

    def run(self) -> None:
        try:
            self._run()
        except Exception as error:
            self._failed, self.playing = f"the recording stands still: {error!r}", False

    def _run(self) -> None:
        before = time.monotonic()
        while not self._over:
            self._ahead(STEP_S)
            self._stirred.clear()
            now = time.monotonic()
            passed, before = now - before, now
            if (wanted := self._wanted) is not None:
                self._wanted = None
                self._jump(wanted)
                before = time.monotonic()
            elif self.playing:
                self._play(self.t + passed * self.speed)

    def _ahead(self, seconds: float) -> None:
        """Extend the film, or wait if it is complete, until ``_stirred`` is set or ``seconds``
        pass."""
        end = time.monotonic() + seconds
        while not self._stirred.is_set() and time.monotonic() < end:
            if self._film.over:
                self._stirred.wait(end - time.monotonic())
            self._film.extend()

    def _reach(self, t: float) -> float:
        """Extend the film up to ``t``; return how far it got before another time was wanted."""
        film = self._film
        while film.until < t and not (film.over or self._over or self._wanted is not None):
            film.extend()
        return min(t, film.until)

    def _jump(self, t: float) -> None:
        reached = self._reach(t)
        self.shown = reached, self._film.at(reached, time.monotonic())

    def _play(self, t: float) -> None:
        reached = self._reach(min(t, self.end))
        for frame in self._film.between(self.t, reached):
            self.watched.take(frame, time.monotonic())
        self.shown = reached, self.watched
        if self._film.over and reached >= self._film.until:
            self.playing = False
