"""The read-only monitor of a running serve: what viewers are sent, in few bytes. Sans-IO.

    serve -> viewer  {"n": 7, "t": 41.2, "state": {what changed}, "events": [...], "plan": [...],
                      "track": [[t, latitude, longitude, depth], ...], "gap": 0,
                      "past": [[t, depth, altitude, ...], ...]}
    viewer -> serve  {"wish": {"rate": 5, "bytes": 16000, "values": ["state"], "track": true,
                               "past": "" (none), "before" (it connected) or "all"}}
                     {"ack": 7}

One JSON object a line. At most ``AHEAD`` frames are unanswered, half of the quickest answer apart.
Meanwhile news waits here: of the state the newest values, of events the newest ``EVENTS``, with the
number of dropped ones as the ``gap``. So data is fresh when it arrives, however slow the link, and
no queue grows. A frame has no more bytes than the viewer wished: state first, then as much of
events, plan, track and past as does not delay the next frame; of the past before the viewer
connected, the newest first. A viewer that acknowledges nothing for ``SILENT_S``, or sends anything
else, is disconnected: the monitor knows no commands.

What does not live here: the sockets (ports), the content of a state (view).
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from mission.model.past import Past, Row

SILENT_S = 20.0
AHEAD = 2  # frames: with 1, data is a round trip older on a long link; 3 queue up on a slow one
STALLED_S = 2.5  # s without a sent frame: one more may leave
DELAYED_S = (
    0.3  # s later than the quickest answer: the bytes beside the state are halved, else doubled
)
LEAST_ROOM, ROOM = 250, 500  # bytes beside the state: the least, the first
EVENTS = 200  # that wait for one viewer
TRACK = 4096  # points that are kept; beyond, every other one is dropped
TRACK_EVERY_S = 1.0
BEFORE, ALL = "before", "all"  # of the past
PIECE = 24  # points or lines that are added to a frame at a time
LINE = 4096  # bytes of a line from a viewer
FASTEST_HZ, LEAST_BYTES, MOST_BYTES = 5.0, 200, 60_000
_dumps = json.JSONEncoder(separators=(",", ":")).encode

State = Mapping[str, Any]
Point = tuple[float, float, float, float | None]


class Unwelcome(Exception):
    """A viewer has sent something that no viewer sends; the message is for the journal."""


@dataclass(frozen=True, slots=True)
class Wish:
    """``values``: names of the state, () for all."""

    rate: float = FASTEST_HZ
    bytes: int = 16_000
    values: tuple[str, ...] = ()
    track: bool = True
    plan: bool = True
    past: str = ""


class Track:
    """Where the vehicle has been: shared by all viewers, thinned as it grows long."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.thinned = 0
        self._every = TRACK_EVERY_S

    def add(self, t: float, latitude: float, longitude: float, depth: float | None) -> None:
        t = round(t, 1)
        if self.points and 0.0 <= t - self.points[-1][0] < self._every:  # < 0: a new engine
            return
        self.points.append((t, round(latitude, 7), round(longitude, 7), depth))
        if len(self.points) > TRACK:
            self.points = self.points[::2]
            self._every *= 2.0
            self.thinned += 1


@dataclass(slots=True)
class Viewer:
    wish: Wish = field(default_factory=Wish)
    greeted: bool = False  # it has sent its wish
    heard: bytes = b""
    number: int = 0
    unanswered: deque[float] = field(default_factory=deque)  # when each was sent
    quickest: float = math.inf  # s, the quickest of all answers
    room: int = ROOM  # bytes beside the state
    sent_at: float = -math.inf
    since: float = 0.0  # when it connected, was sent a frame, or answered last
    known: dict[str, Any] = field(default_factory=dict)
    events: deque[str] = field(default_factory=deque)
    gap: int = 0
    plan: Sequence[str] = ()
    told: int = 0  # points of the track that were sent
    thinned: int = 0
    before: Sequence[Row] = ()  # the past before it connected, the newest first
    passed: int = 0  # rows of all of the past that were sent
    past_thinned: int = 0

    def is_due(self, now: float, ahead: int) -> bool:
        """Whether a frame may leave. ``ahead``: frames that may be unanswered."""
        apart = min(self.quickest / AHEAD, STALLED_S) if self.unanswered else 0.0
        if len(self.unanswered) >= ahead:
            apart = STALLED_S if len(self.unanswered) == AHEAD else math.inf
        return self.greeted and now >= self.sent_at + max(1.0 / self.wish.rate, apart) - 1e-6

    def answer(self, number: int, now: float) -> bool:
        """Take an acknowledgement, which covers earlier frames, too. False if no such frame is
        unanswered."""
        if not self.number - len(self.unanswered) < number <= self.number:
            return False
        while len(self.unanswered) > self.number - number:
            took = now - self.unanswered.popleft()
        self.quickest = min(self.quickest, took)
        is_late = took > self.quickest + DELAYED_S
        self.room = max(LEAST_ROOM, self.room // 2) if is_late else min(2 * self.room, MOST_BYTES)
        self.since = now
        return True


class Monitor:
    """``ahead``: frames that a viewer may leave unanswered. ``room``: bytes beside the state in its
    first frame."""

    def __init__(self, ahead: int = AHEAD, room: int = ROOM) -> None:
        self._ahead, self._room = ahead, room
        self.viewers: dict[str, Viewer] = {}
        self.track, self.past = Track(), Past()
        self._plan: tuple[str, ...] = ()
        self._recent: deque[str] = deque(maxlen=EVENTS)

    def event(self, text: str) -> None:
        """Queue a line of the journal for all viewers."""
        self._recent.append(text)
        for viewer in self.viewers.values():
            if len(viewer.events) >= EVENTS:
                viewer.events.popleft()
                viewer.gap += 1
            viewer.events.append(text)

    def load(self, lines: Iterable[str]) -> None:
        """Take the lines of the stored mission; viewers get them if they have changed."""
        lines = tuple(lines)
        if lines != self._plan:
            self._plan = lines
            for viewer in self.viewers.values():
                viewer.plan = ("", *lines)

    def begin_again(self) -> None:
        """Another engine has started, with its own time: forget the past."""
        self.past = Past()
        for viewer in self.viewers.values():
            viewer.before, viewer.passed, viewer.past_thinned = (), 0, 0

    def connected(self, address: str, now: float) -> None:
        plan = ("", *self._plan) if self._plan else ()
        recent = deque(self._recent)
        self.viewers[address] = Viewer(since=now, events=recent, plan=plan, room=self._room)

    def disconnected(self, address: str) -> None:
        self.viewers.pop(address, None)

    def receive(self, address: str, data: bytes, now: float) -> None:
        """Take in bytes of a viewer. Raises Unwelcome."""
        viewer = self.viewers.get(address)
        if viewer is None:
            return
        *lines, viewer.heard = (viewer.heard + data).split(b"\n")
        if len(viewer.heard) > LINE:
            raise Unwelcome("a line without end")
        for line in lines:
            self._obey(viewer, line, now)

    def _obey(self, viewer: Viewer, line: bytes, now: float) -> None:
        try:
            said = json.loads(line)
            if list(said) == ["ack"] and viewer.answer(said["ack"], now):
                return
            if list(said) != ["wish"]:
                raise Unwelcome("it said what no viewer says")
            viewer.wish, viewer.greeted = _wish(said["wish"]), True
            viewer.before = self.past.rows[::-1] if viewer.wish.past == BEFORE else ()
            viewer.since = now
        except (
            AttributeError, ValueError, TypeError, KeyError, OverflowError, RecursionError
        ) as error:  # fmt: skip
            raise Unwelcome("it said what no viewer says") from error

    def silent(self, now: float) -> list[str]:
        """Viewers that have been silent too long: their connection has to be closed."""
        return [
            address
            for address, viewer in self.viewers.items()
            if (viewer.unanswered or not viewer.greeted) and now > viewer.since + SILENT_S
        ]

    def due(self, now: float) -> list[str]:
        """Viewers that could be sent something now."""
        return [
            address for address, viewer in self.viewers.items() if viewer.is_due(now, self._ahead)
        ]

    def frame(self, address: str, state: State, t: float, now: float) -> bytes:
        """The next frame for this viewer, b"" if there is nothing new. ``t`` is the engine's
        time."""
        viewer = self.viewers[address]
        made = _Frame(viewer.number + 1, t, viewer.wish.bytes)
        _add_state(made, viewer, state)
        made.leave(viewer.room)
        made.add_lines("events", viewer.events.popleft, lambda: len(viewer.events))
        if viewer.gap and made.add("gap", viewer.gap):
            viewer.gap = 0
        if viewer.wish.plan:
            viewer.plan = viewer.plan[made.add_pieces("plan", viewer.plan) :]
        if viewer.wish.track:
            self._add_track(made, viewer)
        self._add_past(made, viewer)
        if made.is_empty:
            return b""
        viewer.number = made.number
        viewer.unanswered.append(now)
        viewer.sent_at = viewer.since = now
        return made.line

    def _add_track(self, made: _Frame, viewer: Viewer) -> None:
        if viewer.thinned != self.track.thinned:  # points were dropped since
            viewer.told >>= self.track.thinned - viewer.thinned
            viewer.thinned = self.track.thinned
        viewer.told += made.add_pieces("track", self.track.points[viewer.told :])

    def _add_past(self, made: _Frame, viewer: Viewer) -> None:
        if viewer.wish.past == BEFORE:
            viewer.before = viewer.before[made.add_pieces("past", viewer.before) :]
        elif viewer.wish.past == ALL:
            if viewer.past_thinned != self.past.thinned:
                viewer.passed, viewer.past_thinned = 0, self.past.thinned
            viewer.passed += made.add_pieces("past", self.past.news[viewer.passed :])


class _Frame:
    """A frame that takes parts as long as there is room."""

    def __init__(self, number: int, t: float, most: int) -> None:
        self.number, self._most = number, most
        self._said: dict[str, Any] = {"n": number, "t": round(t, 3)}
        self._size = len(_dumps(self._said)) + 1
        self.is_empty = True

    def leave(self, room: int) -> None:
        """Leave ``room`` bytes for all that follows."""
        self._most = min(self._most, self._size + room)

    @property
    def line(self) -> bytes:
        return _dumps(self._said).encode() + b"\n"

    def add(self, name: str, value: Any, key: str = "") -> bool:
        """Add a value; whether there was room. ``key``: its name, if it is one value of a table."""
        added = len(_dumps(value)) + len(key or name) + 4 + (0 if key else 2)
        if key and name not in self._said:
            added += len(name) + 6
        if self._size + added > self._most and not self.is_empty:
            return False
        self._size += added
        self.is_empty = False
        if key:
            self._said.setdefault(name, {})[key] = value
        else:
            self._said[name] = value
        return True

    def add_lines(self, name: str, take: Any, left: Any) -> None:
        while left():
            text = take()
            self._said.setdefault(name, []).append(text)
            self._size += len(_dumps(text)) + 1
            self.is_empty = False
            if self._size >= self._most:
                return

    def add_pieces(self, name: str, values: Sequence[Any]) -> int:
        """Add values in order; return how many had room, at least one if any room is left."""
        count = 0
        while count < len(values) and (self._size < self._most or self.is_empty):
            piece = list(values[count : count + PIECE])
            while len(piece) > 1 and self._size + len(_dumps(piece)) > self._most:
                piece = piece[: len(piece) // 2]
            self._said.setdefault(name, []).extend(piece)
            self._size += len(_dumps(piece))
            self.is_empty, count = False, count + len(piece)
        return count


def _add_state(made: _Frame, viewer: Viewer, state: State) -> None:
    """Add the values that have changed, as far as there is room; first those never sent yet."""
    wanted = viewer.wish.values or tuple(state)
    changed = [
        name for name in wanted if name in state and viewer.known.get(name, made) != state[name]
    ]
    fresh = [name for name in changed if name not in viewer.known]
    for name in (*fresh, *(name for name in changed if name in viewer.known)):
        if made.add("state", state[name], name):
            viewer.known[name] = state[name]


def _wish(said: Mapping[str, Any]) -> Wish:
    unknown = set(said) - {"rate", "bytes", "values", "track", "plan", "past"}
    values = said.get("values", [])
    if unknown or not isinstance(values, list) or not all(isinstance(v, str) for v in values):
        raise Unwelcome("it wished for what there is not")
    return Wish(
        min(max(float(said.get("rate", FASTEST_HZ)), 0.01), FASTEST_HZ),
        min(max(int(said.get("bytes", 16_000)), LEAST_BYTES), MOST_BYTES),
        tuple(values[:100]),
        bool(said.get("track", True)),
        bool(said.get("plan", True)),
        str(said.get("past", "")),
    )
