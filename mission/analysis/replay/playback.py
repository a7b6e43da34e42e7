"""Run a recording again and show it as a viewer saw it: the same state, from the same table.

    records --inputs, up to a time--> Runtime --view--> Monitor --frames--> viewer

What does not live here: whether the result is the same (replay), who watches (topside).
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from mission.analysis.replay.rerun import failed_writes, runtime_from
from mission.analysis.replay.rerun import feed as feed_again
from mission.model import Record
from mission.model.alarms import alarms_of, mask_of, standing
from mission.onboard.runtime import records as rec
from mission.onboard.serve.journal import Journal
from mission.onboard.serve.monitor import Monitor
from mission.onboard.serve.view import view

VIEWER = "here"


class Playback:
    """Raises ValueError if the records do not begin with a start of this version."""

    def __init__(self, records: Sequence[Record]) -> None:
        if not records or records[0].kind != rec.START:
            raise ValueError("there is no whole start record: nothing can be shown of it")
        self._records = [r for r in records if r.kind in rec.INPUTS or r.kind == rec.MISSION]
        self._next, self._now = 0, 0.0
        self._monitor = Monitor()
        self._monitor.connected(VIEWER, 0.0)
        self._monitor.receive(VIEWER, b'{"wish":{"bytes":60000}}\n', 0.0)
        journal = Journal(self._event, lambda: self._now)
        start = rec.read_start(records[0])
        self._runtime = runtime_from(start, failed_writes(records), observer=journal)

    @property
    def over(self) -> bool:
        return self._next >= len(self._records)

    @property
    def end(self) -> float:
        return self._records[-1].t if self._records else 0.0

    def until(self, t: float) -> bytes:
        """Return the frame at the engine's time ``t``; b"" if nothing is new."""
        while not self.over and self._records[self._next].t <= t:
            record = self._records[self._next]
            self._next, self._now = self._next + 1, record.t
            feed_again(self._runtime, record)
            if record.kind == rec.MISSION:
                self._monitor.load(json.loads(record.payload)["lines"])
        self._now = max(self._now, min(t, self.end))
        known = self._runtime.situation
        stand = standing(self._runtime.condition(self._now))
        state = view(self._runtime, (*stand, *alarms_of(mask_of(known.of_serve))), self._now)
        if state["latitude"] is not None and state["report_at"] is not None:
            place = state["latitude"], state["longitude"], state["depth"]
            self._monitor.track.add(state["report_at"], *place)
        return self._monitor.frame(VIEWER, state, self._now, self._now)

    def answer(self, said: bytes) -> None:
        self._monitor.receive(VIEWER, said, self._now)

    def _event(self, line: str) -> None:
        self._monitor.event(f"{self._now:8.1f} s  {line}")
