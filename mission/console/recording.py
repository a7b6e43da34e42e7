"""A recording under the page's hand: it plays, stands, and goes to any time. A thread of its own.

    records --Playback (run again)--> Watched, as if it were a vehicle's monitor

Backward is from the beginning again. What does not live here: what a recording is (replay).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Any

from mission.analysis.replay.playback import Playback
from mission.model import Record
from mission.onboard.runtime.records import read_start
from mission.onboard.stream.events import events_of
from mission.topside.monitor import Watched

STEP_S = 0.2  # real
STRIDE_S = 1.0  # of the recording, on the way to a time: a point of the track each
SLOWEST, FASTEST = 1.0, 100.0


class Recording:
    """Raises ValueError where the records begin with no start of this version."""

    def __init__(self, records: Sequence[Record]) -> None:
        self._records = records
        self._playback = Playback(records)
        self.wall = read_start(records[0]).wall
        self.end = self._playback.end
        self.watched = Watched()
        self.playing, self.speed = True, SLOWEST
        self.t = 0.0
        self._wanted: float | None = None
        self._stirred, self._over = threading.Event(), False

    def as_object(self) -> dict[str, Any]:
        return {
            "begin": 0.0,
            "end": self.end,
            "playing": self.playing,
            "speed": self.speed,
            "wall": self.wall,
        }

    def events(self) -> list[dict[str, Any]]:
        found = (event for record in self._records for event in events_of(record))
        return [{"t": e.t, "level": e.level, "of": e.of, "says": e.says} for e in found]

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
        before = time.monotonic()
        while not self._over:
            self._stirred.wait(STEP_S)
            self._stirred.clear()
            now = time.monotonic()
            passed, before = now - before, now
            if (wanted := self._wanted) is not None:
                self._wanted = None
                self._go(wanted)
                before = time.monotonic()
            elif self.playing:
                self._go(min(self.end, self.t + passed * self.speed))
                self.playing = self.playing and self.t < self.end

    def _go(self, t: float) -> None:
        if t < self.t:
            self._playback, self.watched, self.t = Playback(self._records), Watched(), 0.0
        while self.t < t and not self._over and self._wanted is None:
            then = min(t, self.t + STRIDE_S)
            self._take(self._playback.until(then))
            self.t = then
        if t == 0.0:
            self._take(self._playback.until(0.0))

    def _take(self, frame: bytes) -> None:
        _, answers = self.watched.receive(frame, time.monotonic())
        if answers:
            self._playback.answer(answers)
