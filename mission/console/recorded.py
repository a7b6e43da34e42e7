"""A recording in the place of a vehicle: the same frames, and no commands."""

from __future__ import annotations

import asyncio
import threading
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

from mission.console import plans
from mission.console.board import Board
from mission.console.hindsight import hindsight
from mission.console.recording import Recording
from mission.topside.contacts import SILENT_S

EVERY_S = 0.2


def told_apart(files: Sequence[str]) -> list[str]:
    """Return a name for each file: as much of its path as is unique; equal paths get a number."""
    parts = [PurePath(file).parts for file in files]
    found = [_among(own, parts) for own in parts]
    seen, names = Counter[str](), list[str]()
    for name in found:
        seen[name] += 1
        names.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return names


def _among(own: Sequence[str], others: Sequence[Sequence[str]]) -> str:
    like = [other for other in others if other != own]
    most = len(own)
    kept = next((n for n in range(1, most) if all(o[-n:] != own[-n:] for o in like)), most)
    return str(PurePath(*own[-kept:]))


class Recorded:
    def __init__(self, ident: str, name: str, recording: Recording, vehicle: str | None) -> None:
        self.ident, self.name, self.recording = ident, name, recording
        self.board = Board()
        self.vehicle = vehicle
        self._plan = dict(plans.EMPTY)
        self._planned: tuple[str, ...] | None = None
        self._hindsight: dict[str, Any] | None = None
        self._asked = threading.Lock()

    def about(self) -> dict[str, Any]:
        return {
            "id": self.ident,
            "name": self.name,
            "to": "",
            "source": "recording",
            "under_water": False,
            "simulated": False,
            "speed": 1.0,
            "silent_s": SILENT_S,
            "checklist": [],
        }

    def plan(self) -> dict[str, Any]:
        return self._plan

    def hindsight(self) -> dict[str, Any]:
        """Compute it once; for a long dive it takes some time."""
        with self._asked:
            if self._hindsight is None:
                self._hindsight = hindsight(self.recording.records)
            return self._hindsight

    def frame(self, page: str, now: float) -> bytes:
        """b"" if nothing is new."""
        recording = self.recording
        extras = {
            "wall": int(time.time()),
            "silence": 0,
            "problem": recording.problem,
            "plan": self._plan["digest"],
            "review": recording.as_object(),
        }
        t, watched = recording.shown
        state = {**watched.state, **extras}
        return self.board.frame(page, watched, state, t, now)

    def steer(self, said: dict[str, Any]) -> None:
        """Raises ValueError, KeyError, TypeError for a malformed message."""
        match said:
            case {"do": "play", "speed": speed}:
                self.recording.play(float(speed))
            case {"do": "pause"}:
                self.recording.pause()
            case {"do": "seek", "t": t}:
                self.recording.seek(float(t))
            case _:
                raise ValueError("a review knows play with a speed, pause, and seek with t")

    async def run(self) -> None:
        """Run until cancelled."""
        threading.Thread(target=self.recording.run, daemon=True).start()
        try:
            while True:
                lines = self.recording.watched.plan
                if lines != self._planned:
                    self._planned = lines
                    self._plan = await asyncio.to_thread(plans.on_board, lines, self.vehicle)
                await asyncio.sleep(EVERY_S)
        finally:
            self.recording.stop()
