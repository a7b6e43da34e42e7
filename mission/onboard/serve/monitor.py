"""The read-only monitor of a running serve: what viewers are sent, and how little. Sans-IO.

    serve -> viewer  {"n": 7, "t": 41.2, "state": {what changed}, "events": [...], "plan": [...],
                      "track": [[t, latitude, longitude, depth], ...], "gap": 0,
                      "past": [[t, depth, altitude, ...], ...]}
    viewer -> serve  {"wish": {"rate": 5, "bytes": 16000, "values": ["state"], "track": true,
                               "past": "" (none), "before" (it came) or "all"}}
                     {"ack": 7}

One JSON object a line. At most ``AHEAD`` frames are unanswered, half of the quickest answer apart:
what happens meanwhile waits here, of a state its newest, of events the newest ``EVENTS`` with the
number of those that are missing as the ``gap``. So nothing is old when it arrives, however thin the
way, and nothing grows. A frame has no more bytes than was wished for: state first, then of events,
plan, track and past what does not delay the next; of what was before the viewer came the newest
first. Who answers none for ``SILENT_S``, or says anything else, is sent away: no word of command is
known here.

What does not live here: the sockets (ports), what a state is made of (view).
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
AHEAD = 2  # frames: one is older by a way back where the way is long, three wait where it is thin
STALLED_S = 2.5  # nothing has left for so long: one more
DELAYED_S = (
    0.3  # s behind the quickest answer: what is told beside the state is halved, else doubled
)
LEAST_ROOM, ROOM = 250, 500  # bytes, for that; the first
EVENTS = 200  # that wait for one viewer
TRACK = 4096  # points that are kept: beyond, every other one
TRACK_EVERY_S = 1.0
BEFORE, ALL = "before", "all"  # of the past
PIECE = 24  # points or lines that are added to a frame at a time
LINE = 4096  # bytes of what a viewer says
FASTEST_HZ, LEAST_BYTES, MOST_BYTES = 5.0, 200, 60_000
_dumps = json.JSONEncoder(separators=(",", ":")).encode

State = Mapping[str, Any]
Point = tuple[float, float, float, float | None]


class Unwelcome(Exception):
    """A viewer who said what no viewer says; the message is for the journal."""


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
    """Where it has been: shared by all viewers, thinned where it grows long."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.thinned = 0
        self._every = TRACK_EVERY_S

    def add(self, t: float, latitude: float, longitude: float, depth: float | None) -> None:
        t = round(t, 1)
        if self.points and 0.0 <= t - self.points[-1][0] < self._every:  # below: of another engine
            return
        self.points.append((t, round(latitude, 7), round(longitude, 7), depth))
        if len(self.points) > TRACK:
            self.points = self.points[::2]
            self._every *= 2.0
            self.thinned += 1


@dataclass(slots=True)
class Viewer:
    wish: Wish = field(default_factory=Wish)
    greeted: bool = False  # it has said what it wishes
    heard: bytes = b""
    number: int = 0
    unanswered: deque[float] = field(default_factory=deque)  # when each was sent
    quickest: float = math.inf  # s, of all answers
    room: int = ROOM  # bytes beside the state
    sent_at: float = -math.inf
    since: float = 0.0  # when it came, or answered last
    known: dict[str, Any] = field(default_factory=dict)
    events: deque[str] = field(default_factory=deque)
    gap: int = 0
    plan: Sequence[str] = ()
    told: int = 0  # points of the track
    thinned: int = 0
    before: Sequence[Row] = ()  # it came, the newest first
    passed: int = 0  # rows of all of the past
    past_thinned: int = 0

    def is_due(self, now: float, ahead: int) -> bool:
        """``ahead``: frames that may be unanswered."""
        apart = min(self.quickest / AHEAD, STALLED_S) if self.unanswered else 0.0
        if len(self.unanswered) >= ahead:
            apart = STALLED_S if len(self.unanswered) == AHEAD else math.inf
        return self.greeted and now >= self.sent_at + max(1.0 / self.wish.rate, apart) - 1e-6

    def answer(self, number: int, now: float) -> bool:
        """False: no such frame is unanswered. Those before it are answered, too."""
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
    """``ahead``: frames that a viewer may leave unanswered; ``room``: bytes of its first beside the
    state."""

    def __init__(self, ahead: int = AHEAD, room: int = ROOM) -> None:
        self._ahead, self._room = ahead, room
        self.viewers: dict[str, Viewer] = {}
        self.track, self.past = Track(), Past()
        self._plan: tuple[str, ...] = ()
        self._recent: deque[str] = deque(maxlen=EVENTS)

    def event(self, text: str) -> None:
        """A line of the journal."""
        self._recent.append(text)
        for viewer in self.viewers.values():
            if len(viewer.events) >= EVENTS:
                viewer.events.popleft()
                viewer.gap += 1
            viewer.events.append(text)

    def load(self, lines: Iterable[str]) -> None:
        """The mission that the store holds."""
        lines = tuple(lines)
        if lines != self._plan:
            self._plan = lines
            for viewer in self.viewers.values():
                viewer.plan = ("", *lines)

    def begin_again(self) -> None:
        """Another engine has begun, with a time of its own: nothing was before it."""
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
        """Raises Unwelcome."""
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
        """Viewers whose connection is to be closed."""
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
        if viewer.thinned != self.track.thinned:  # the points it has are others now
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
    """Parts as long as there is room."""

    def __init__(self, number: int, t: float, most: int) -> None:
        self.number, self._most = number, most
        self._said: dict[str, Any] = {"n": number, "t": round(t, 3)}
        self._size = len(_dumps(self._said)) + 1
        self.is_empty = True

    def leave(self, room: int) -> None:
        """Bytes for all that follows."""
        self._most = min(self._most, self._size + room)

    @property
    def line(self) -> bytes:
        return _dumps(self._said).encode() + b"\n"

    def add(self, name: str, value: Any, key: str = "") -> bool:
        """Whether there was room. ``key``: one value of a table."""
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
        """How many had room, one at least."""
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
    """What has changed, as far as it has room; what had none comes first the next time."""
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
