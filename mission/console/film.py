"""A recording that was run again and kept as frames: any time is found without running it.

    records --Playback, ``EVERY_S`` at a time--> frames --at(t)--> Watched, as it was then

A frame has about 100 bytes: 20 MB for a day. What does not live here: the playing position
(recording).
"""

from __future__ import annotations

import json
import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any

from mission.analysis.replay.playback import Playback
from mission.model import Record
from mission.model.past import Past
from mission.topside.monitor import EVENTS, TRACK, Watched

EVERY_S = 0.5  # s of the recording between two frames
KEY = 200  # frames between two whole states


class Film:
    """Raises ValueError if the records do not begin with a start of this version."""

    def __init__(self, records: Sequence[Record]) -> None:
        self._playback = Playback(records)
        self.end = self._playback.end
        self.problem = ""  # why it ends before ``end``
        self.until = 0.0  # it has been run up to here
        self._times: list[float] = []
        self._frames: list[bytes] = []
        self._sizes: list[tuple[int, int, int]] = []  # events, track and plan so far
        self._keys: list[dict[str, Any]] = []  # the state before every ``KEY``th frame
        self._events: list[str] = []
        self._track: list[list[float]] = []
        self._plan: list[str] = []
        self._past = Past()
        self._state: dict[str, Any] = {}
        self._run_to(0.0)

    @property
    def over(self) -> bool:
        return self.until >= self.end or bool(self.problem)

    def extend(self) -> None:
        """Add a frame. If the recording cannot be run, ``problem`` says so and the film ends
        there."""
        if not self.over:
            self._run_to(min(self.end, self.until + EVERY_S))

    def _run_to(self, t: float) -> None:
        try:
            line = self._playback.until(t)
        except Exception as error:
            self.problem = f"it cannot be run beyond {self.until:.1f} s: {error!r}"
            return
        self.until = t
        if line:
            frame = json.loads(line)
            self._playback.answer(b'{"ack":%d}\n' % frame["n"])
            self._keep(t, frame, line)

    def _keep(self, t: float, frame: Mapping[str, Any], line: bytes) -> None:
        if len(self._frames) % KEY == 0:
            self._keys.append(dict(self._state))
        self._state.update(frame.get("state", {}))
        self._past.take(self._state)
        self._events += frame.get("events", ())
        self._track += frame.get("track", ())
        self._plan += frame.get("plan", ())
        self._times.append(t)
        self._frames.append(line)
        self._sizes.append((len(self._events), len(self._track), len(self._plan)))

    def seen(self, t: float) -> float:
        """Return the time of the first frame that shows what happens at ``t``."""
        return min(math.ceil(t / EVERY_S) * EVERY_S, self.end)

    # --- what stood then -----------------------------------------------------------------------

    def at(self, t: float, now: float) -> Watched:
        """Return what a viewer knew at ``t``. ``now``: this computer's time."""
        watched, count = Watched(), bisect_right(self._times, t)
        if not count:
            return watched
        events, track, plan = self._sizes[count - 1]
        state = self._state_of(count)
        watched.past = Past(self._past.until(state.get("report_at") or 0.0))
        watched.take({"t": self._times[count - 1], "state": state}, now)
        watched.take({"t": self._times[count - 1], "plan": self._plan[:plan]}, now)
        watched.events.extend(self._events[max(0, events - EVENTS) : events])
        watched.told = events
        watched.track = self._track[max(0, track - TRACK) : track]
        return watched

    def _state_of(self, count: int) -> dict[str, Any]:
        key = (count - 1) // KEY
        state = dict(self._keys[key])
        for line in self._frames[key * KEY : count]:
            state.update(json.loads(line).get("state", {}))
        return state

    def between(self, before: float, t: float) -> list[dict[str, Any]]:
        """Return the frames after ``before`` up to ``t``."""
        first, last = bisect_right(self._times, before), bisect_right(self._times, t)
        return [json.loads(line) for line in self._frames[first:last]]
