"""The client of a vehicle's read-only monitor: a wish, then frames, each answered. Sans-IO.

    bytes --receive--> frames (tables)          out: bytes that leave
    ``state`` holds what is known so far; ``age`` how long ago the vehicle measured a value

What does not live here: sockets (console), how it is shown (watch).
"""

from __future__ import annotations

import json
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from typing import Any

from mission.model.past import Past, is_row

MOST = 1 << 20  # bytes of one frame
EVENTS, TRACK = 1000, 10_000  # numbers of them that are kept
SPARE = 1000  # points in excess before the oldest are dropped


Frame = Mapping[str, Any]
_PARTS: Mapping[str, tuple[type, ...]] = {
    "n": (int,), "t": (int, float), "state": (dict,), "gap": (int,),
    "events": (list,), "track": (list,), "plan": (list,), "past": (list,),
}  # fmt: skip


class NoMonitor(ValueError):
    """The peer that answers is not a monitor."""


def wish(
    rate: float = 5.0, most: int = 16_000, values: tuple[str, ...] = (), **more: bool | str
) -> bytes:
    """Return a viewer's first message; ``more``: ``track``, ``plan``, ``past``."""
    said = {"rate": rate, "bytes": most, "values": list(values), **more}
    return json.dumps({"wish": said}).encode() + b"\n"


class Watched:
    """All that a viewer knows of a vehicle. ``at``: the engine's time of the newest frame, and this
    computer's time at which it came."""

    def __init__(self) -> None:
        self.state: dict[str, Any] = {}
        self.events: deque[str] = deque(maxlen=EVENTS)
        self.track: list[list[float]] = []
        self.plan: tuple[str, ...] = ()
        self.past = Past()
        self.gap = self.told = 0  # events that are missing; events that came
        self.at: tuple[float, float] | None = None
        self._heard = b""
        self._told_before: Counter[str] = Counter()  # lines that may be repeated

    def connected(self) -> None:
        """A new connection begins with a whole frame and sends the whole plan. It also repeats the
        newest events, which do not count again."""
        self._heard, self.plan = b"", ()
        self._told_before = Counter(self.events)

    def receive(self, data: bytes, now: float) -> tuple[list[Frame], bytes]:
        """Return the complete frames, and the answers to send. Raises NoMonitor."""
        *lines, self._heard = (self._heard + data).split(b"\n")
        if len(self._heard) > MOST:
            raise NoMonitor("no monitor: a line without end")
        frames = [_frame(line) for line in lines]
        for frame in frames:
            self.take(frame, now)
        return frames, b"".join(b'{"ack":%d}\n' % frame["n"] for frame in frames)

    def take(self, frame: Mapping[str, Any], now: float) -> None:
        if self.at is not None and frame["t"] < self.at[0]:
            self._told_before.clear()  # the program restarted, and so do its lines
            self.past = Past()
        self.at = (frame["t"], now)
        self.state.update(frame.get("state", {}))
        self.past.take(self.state)
        self.past.add(frame.get("past", ()))
        events = self._new(frame.get("events", ()))
        self.events += events
        self.told += len(events)
        self.gap += frame.get("gap", 0)
        self.track += frame.get("track", ())
        if len(self.track) > TRACK + SPARE:
            self.track = self.track[-TRACK:]
        for line in frame.get("plan", ()):  # "" begins another plan
            self.plan = (*self.plan, line) if line else ()

    def _new(self, events: Sequence[str]) -> Sequence[str]:
        """Return the events from the first new one on."""
        for number, line in enumerate(events):
            if not self._told_before[line]:
                self._told_before.clear()
                return events[number:]
            self._told_before[line] -= 1
        return ()

    def silence(self, now: float) -> float | None:
        """Return the time since the last frame, s; None if none came."""
        return None if self.at is None else max(0.0, now - self.at[1])

    def age(self, name: str, now: float) -> float | None:
        """Return the time since the vehicle measured it, s; ``name``: report_at, fix_at, leg_began,
        ..."""
        measured = self.state.get(name)
        if self.at is None or measured is None:
            return None
        return max(0.0, self.at[0] - float(measured)) + max(0.0, now - self.at[1])


def _frame(line: bytes) -> Frame:
    try:
        said: dict[str, Any] = {"n": None, "t": None} | json.loads(line)
        whole = all(isinstance(said[name], kind) for name, kind in _PARTS.items() if name in said)
        if whole and all(map(is_row, said.get("past", ()))):
            return said
    except (ValueError, TypeError, KeyError, RecursionError):
        pass
    raise NoMonitor("no monitor answers there: is it the operator's port?")
