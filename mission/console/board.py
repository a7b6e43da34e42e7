"""The frames for a vehicle's pages: the monitor's own, with what the console knows. Sans-IO.

    Watched, and what the console itself knows --> Monitor --> a frame for each page

When the vehicle restarts, or a recording goes back, the frames start again at number 1.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from mission.onboard.serve.monitor import MOST_BYTES, Monitor
from mission.topside.monitor import Watched

_WISH = json.dumps({"wish": {"bytes": MOST_BYTES, "plan": False, "past": "all"}}).encode() + b"\n"
BACK_S = 1.0  # the vehicle's time may go back so far within one run


class Board:
    def __init__(self) -> None:
        self._monitor = Monitor(ahead=1, room=MOST_BYTES)
        self._of: Watched | None = None
        self._t, self._told = -math.inf, 0

    @property
    def pages(self) -> int:
        return len(self._monitor.viewers)

    def come(self, page: str, now: float) -> None:
        self._monitor.connected(page, now)
        self._monitor.receive(page, _WISH, now)

    def go(self, page: str) -> None:
        self._monitor.disconnected(page)

    def answer(self, page: str, number: object, now: float) -> None:
        """Take an acknowledgement. Another number than the newest is from before a restart."""
        viewer = self._monitor.viewers.get(page)
        if viewer is not None and viewer.unanswered and number == viewer.number:
            self._monitor.receive(page, b'{"ack":%d}\n' % viewer.number, now)

    def is_due(self, page: str, now: float) -> bool:
        return page in self._monitor.due(now)

    def is_silent(self, page: str, now: float) -> bool:
        return page in self._monitor.silent(now)

    def event(self, line: str) -> None:
        self._monitor.event(line)

    def frame(
        self, page: str, watched: Watched, state: Mapping[str, Any], t: float, now: float
    ) -> bytes:
        """b"" if nothing is new. ``state``: that of ``watched``, and more. ``t``: the vehicle's
        time now, read after the state, so that no age is too small."""
        self._follow(watched, now)
        return self._monitor.frame(page, state, t, now)

    def _follow(self, watched: Watched, now: float) -> None:
        t = -math.inf if watched.at is None else watched.at[0]
        if watched is not self._of or t < self._t - BACK_S:
            self._anew(now)
            self._of = watched
        self._t, self._monitor.past = t, watched.past
        fresh, self._told = watched.told - self._told, watched.told
        for line in list(watched.events)[-fresh:] if fresh > 0 else ():
            self._monitor.event(line)
        for point in reversed(_fresh(watched.track, self._monitor.track.points)):
            self._monitor.track.add(*point)

    def _anew(self, now: float) -> None:
        pages = list(self._monitor.viewers)
        self._monitor = Monitor(ahead=1, room=MOST_BYTES)
        self._told = 0
        for page in pages:
            self.come(page, now)


def _fresh(track: list[Any], known: list[Any]) -> list[Any]:
    """Return the points after the known ones, newest first, of the newest run only."""
    last = known[-1][0] if known else -math.inf
    found: list[Any] = []
    for point in reversed(track):
        if point[0] <= last or (found and point[0] >= found[-1][0]):
            break
        found.append(point)
    return found
