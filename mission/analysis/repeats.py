"""Repeated events, reported once: held frames, continued ascents, requests without an answer."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from mission.model.shown import clock
from mission.onboard.stream.events import HELD, answers_in, frame_text

_LONG, _MOVED_M = 4, 0.5  # times that an ascent repeats something; m that the depth must change
_TRY = re.compile(r" \(try (\d+) of (\d+)\)$")
_MOST = 5  # frames whose tries are listed
_ADDRESS = 4  # bytes: a CAN identifier, or the head of a board's frame with its command
_MEASURED = re.compile(r"(?<=the depth is )-?[\d.]+ m, no less")
_ASCENT_S = 60.0  # s between two equal commands of an ascent that continues
_WORD = re.compile(rb"@(?:ZA([A-Z])|([A-Z]{2}))[^@$]*\$")  # @ZAX0$ is answered as ZX
_BEGUN = re.compile(r"^entry of (\S+)(?=: after )")  # of an ascent that continues in an emergency
_ROUND_S = 1.0  # s: a frame repeated within this time is held, whatever is sent in between


@dataclass(slots=True)
class _Run:
    """``count`` equal events from ``begin`` to ``end``, s; ``forms``: their different texts."""

    what: str
    why: str
    begin: float
    end: float
    count: int = 1
    forms: set[str] = field(default_factory=set)

    def goes_on(self, t: float) -> None:
        self.end, self.count = t, self.count + 1

    @property
    def when(self) -> str:
        if self.count == 1:
            return f"at {clock(self.begin)}"
        return f"{self.count} times from {clock(self.begin)} to {clock(self.end)}"

    @property
    def row(self) -> tuple[str, str, str]:
        often = f" ({self.count} times{self._differing}, until {clock(self.end)})"
        return clock(self.begin), self.what, self.why + (often if self.count > 1 else "")

    @property
    def _differing(self) -> str:
        return f", in {len(self.forms)} forms" if len(self.forms) > 1 else ""


class Rows:
    """Rows of a table: what, why, how often; the same within ``within`` s is one row."""

    def __init__(self, within: float) -> None:
        self._within = within
        self._runs: list[_Run] = []
        self._last: dict[tuple[str, str], _Run] = {}

    def add(self, t: float, what: str, why: str, same: str = "") -> None:
        """Add an event. ``same``: a key that it shares with other events of its row. A measured
        depth in a reason does not make a new row."""
        key, within = (same or what, _MEASURED.sub("", why)), self._within
        if key[1] != why:
            within = max(within, _ASCENT_S)
        run = self._last.get(key)
        if run is not None and (run is self._runs[-1] or t - run.end <= within):
            run.goes_on(t)
        else:
            self._last[key] = run = _Run(what, why, t, t)
            self._runs.append(run)
        run.forms.add(what)

    def told(self) -> list[tuple[str, ...]]:
        """Return the rows (time of begin, what, why), sorted by begin."""
        return [run.row for run in self._runs]


class Refusals:
    """Answers N; the same within ``within`` s is counted once."""

    def __init__(self, within: float) -> None:
        self._within = within
        self._runs: list[tuple[_Run, str]] = []
        self._last: dict[tuple[str, str, str], _Run] = {}

    def add(self, t: float, answer: str, why: str, to: str) -> None:
        run = self._last.get((answer, why, to))
        if run is not None and t - run.end <= self._within:
            run.goes_on(t)
        else:
            self._last[answer, why, to] = run = _Run(answer, why, t, t)
            self._runs.append((run, to))

    def of(self, to: str) -> Iterator[str]:
        """Describe what ``to`` refused, frame by frame."""
        refused: dict[str, _Run] = {}
        for run, who in self._runs:
            if who == to and run.what in refused:
                before = refused[run.what]
                before.count, before.end = before.count + run.count, run.end
            elif who == to:
                refused[run.what] = replace(run)
        for run in list(refused.values())[:_MOST]:
            yield f"The {to} refused {run.what} {run.when}: it answered N."

    def rows(self) -> list[tuple[str, ...]]:
        """Return the rows (time of begin, answer, why, to whom), sorted by begin."""
        return [(*run.row, to) for run, to in self._runs]


class Commands:
    """The frames to the vehicle. A board gets several frames in each round, and steering values
    change in each round: the frames of one address and one reason share one row."""

    def __init__(self) -> None:
        self._rows = Rows(_ROUND_S)
        self._vain: dict[str, _Run] = {}
        self._silent: dict[str, int] = {}  # how often even the last try had no answer
        self._waiting = ""  # a frame whose last try was sent

    def heard(self, data: bytes) -> None:
        """Take bytes from the vehicle."""
        if b"@ACK_" in data:
            self._waiting = ""

    def add(self, t: float, data: bytes, why: str) -> None:
        frame = frame_text(data)
        self._give_up()
        address = "" if data.startswith(b"@") else data[:_ADDRESS].hex()
        self._rows.add(t, frame, why.removesuffix(HELD), address)
        tried = _TRY.search(why)
        if tried is None or tried[1] != tried[2]:
            return
        if frame in self._vain:
            self._vain[frame].goes_on(t)
        else:
            self._vain[frame] = _Run(frame, tried[2], t, t)
        self._waiting = frame

    def _give_up(self) -> None:
        """Count a request as unanswered when another frame is sent or the recording ends."""
        if self._waiting:
            self._silent[self._waiting] = self._silent.get(self._waiting, 0) + 1
        self._waiting = ""

    def rows(self) -> list[tuple[str, ...]]:
        """Return the rows: time, first frame and reason; repeated ones once."""
        return self._rows.told()

    def in_vain(self) -> Iterator[str]:
        """Describe what the vehicle did not answer at once, the most frequent first."""
        self._give_up()
        some = sorted(self._vain.values(), key=lambda run: -run.count)
        for run in some[:_MOST]:
            yield f"{run.what} took all of its {run.why} tries {run.when}: {self._answered(run)}."
        if len(some) > _MOST:
            yield f"So did {len(some) - _MOST} other frames."

    def _answered(self, run: _Run) -> str:
        """Describe the answers to the last tries; of a board without ``@ACK_`` they are not
        known."""
        silent = self._silent.get(run.what, 0)
        if not run.what.startswith("@"):
            return "no answer to the others"
        if silent == run.count:
            return "no answer to any of them"
        if silent:
            return f"{silent} times not even the last was answered"
        return "only the last was answered"


class Words:
    """Commands of operators that were answered, and how, by operator and command."""

    def __init__(self) -> None:
        self._said_to: dict[tuple[str, str, str], _Run] = {}
        self._first: dict[tuple[str, str, str], float | None] = {}  # when it was first sent
        self._waiting: dict[tuple[str, str], float] = {}  # unanswered commands, since when

    def said(self, t: float, who: str, data: bytes) -> None:
        """Take bytes from an operator. A command that is split over two receptions gets no time."""
        for order, word in _WORD.findall(data):
            self._waiting.setdefault((who, f"Z{order.decode()}" if order else word.decode()), t)

    def add(self, t: float, who: str, data: bytes) -> None:
        for word, refused in answers_in(data):
            answer = "refused" if refused else "accepted"
            key = who, word, answer
            said = self._waiting.pop((who, word), None)
            if key in self._said_to:
                self._said_to[key].goes_on(t)
            else:
                self._said_to[key], self._first[key] = _Run(word, answer, t, t), said

    def rows(self) -> list[tuple[str, ...]]:
        """Return rows: operator, command, answer, count; first sent, first answered, last
        answered."""
        return [self._row(key, run) for key, run in self._said_to.items()]

    def _row(self, key: tuple[str, str, str], run: _Run) -> tuple[str, ...]:
        who, word, answer = key
        said = self._first[key]
        when = "" if said is None else clock(said), clock(run.begin), clock(run.end)
        return who, f"@{word}", answer, str(run.count), *when


class Again:
    """What an ascent, or a limit that acts by commands only, repeats while the state stays."""

    def __init__(self) -> None:
        self._run, self._said = _Run("", "", 0.0, 0.0), dict[str, None]()
        self._place: int | None = None  # index of its sentence
        self._shallow, self._deep = math.inf, -math.inf  # m, by the reports since it began

    def end(self) -> None:
        """Note that another state was entered."""
        self._place = None

    def report(self, depth: float | None) -> None:
        """Take a depth report of the vehicle, m."""
        if depth is not None:
            self._shallow, self._deep = min(self._shallow, depth), max(self._deep, depth)

    def add(self, t: float, what: str, why: str, says: list[str]) -> None:
        """Add a sentence to ``says``, or extend the current one."""
        why = _BEGUN.sub(r"the ascent that \1 began", why)
        root = why.partition(": after ")[0]
        if self._place is not None and self._run.why == root:
            self._run.goes_on(t)
        else:
            self._run, self._said, self._place = _Run(what, root, t, t), {}, len(says)
            self._shallow, self._deep = math.inf, -math.inf
            says.append("")
        self._said[what] = None
        says[self._place] = self._told(why)

    def _told(self, why: str) -> str:
        """``why``: the reason of the last event."""
        run, said = self._run, ", ".join(self._said)
        if run.count == 1:
            return f"{clock(run.begin)}: {why}; said again: {said}."
        often = f"said again {run.count} times, in turn: {said}"
        return f"{clock(run.begin)} to {clock(run.end)}: {run.why}; {often}{self._unmoved}."

    @property
    def _unmoved(self) -> str:
        """A remark if the depth stays the same for long."""
        spread = self._deep - self._shallow
        if self._run.count < _LONG or not 0.0 <= spread < _MOVED_M:
            return ""
        range_ = f"{self._shallow:.1f} to {self._deep:.1f} m"
        return f". All the while its reports said {range_}: it did not rise, or its depth is stuck"
