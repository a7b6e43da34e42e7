"""The operator of a simulated flight: uploads and starts the mission in real bytes, as a topside.

    line 1 .. n, each after the ACK of the one before  -->  @AQ, digest compared  -->  @AA until
    it is accepted  -->  the bytes of the flight's script, at its times after the start

What does not live here: the real operator's programs (upload), the Pi's answers (topside).
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass

from protocol.messages import Ack, FrameFault, MissionLine, StartMission, StoreQuery, StoreReport
from protocol.topside import Answer, ConsoleCodec, encode

ANSWER_S = 1.0  # network (R1)
TRIES = 3
FIRST_START_S = 5.0  # by then the vehicle has reported its position
START_EVERY_S = 2.0
START_UNTIL_S = 120.0  # a cold GPS receiver needs time for its first fix


@dataclass(frozen=True, slots=True)
class Cue:
    """Bytes that the operator sends ``after`` s of mission."""

    after: float
    data: bytes


class _Phase(enum.Enum):
    UPLOAD = "upload"
    COMPARE = "compare"
    START = "start"
    WATCH = "watch"
    FAILED = "failed"


class Operator:
    """The operator, without IO. ``failure``: why no mission is under way; "" without a failure."""

    def __init__(self, lines: Sequence[str], digest: str, script: Sequence[Cue] = ()) -> None:
        self._lines, self._digest = tuple(lines), digest
        self._script = sorted(script, key=lambda cue: cue.after)
        self._codec = ConsoleCodec()
        self._phase, self._line, self._tries = _Phase.UPLOAD, 1, 0
        self._due = 0.0
        self._refused = ""
        self.failure = ""
        self.started: float | None = None

    def next_timer(self) -> float | None:
        if self._phase is _Phase.FAILED:
            return None
        if self._phase is _Phase.WATCH:
            assert self.started is not None
            return self.started + self._script[0].after if self._script else None
        return self._due

    def handle_timer(self, now: float) -> list[bytes]:
        """Return the bytes that are due: a first try, a retry, or the next of the script."""
        if self._phase is _Phase.FAILED:
            return []
        if self._phase is _Phase.WATCH:
            return [self._script.pop(0).data] if self._script else []
        if self._phase is _Phase.START:
            return self._start(now)
        return self._ask(now)

    def receive(self, data: bytes, now: float) -> list[bytes]:
        out: list[bytes] = []
        for answer in self._codec.receive(data, now):
            if not isinstance(answer, FrameFault):
                out += self._hear(answer, now)
        return out

    def _hear(self, answer: Answer, now: float) -> list[bytes]:
        if isinstance(answer, StoreReport):
            return self._compare(answer, now)
        if not isinstance(answer, Ack) or answer.group != "A":
            return []
        if self._phase is _Phase.UPLOAD and answer.function == "W":
            return self._next_line(now) if answer.ok else self._ask_why(now)
        if self._phase is _Phase.START and answer.function == "A":
            return self._begin(now) if answer.ok else self._ask_why(now)
        return []

    def _next_line(self, now: float) -> list[bytes]:
        self._line, self._tries = self._line + 1, 0
        if self._line > len(self._lines):
            self._phase = _Phase.COMPARE
        return self._ask(now)

    def _ask(self, now: float) -> list[bytes]:
        if self._tries >= TRIES:
            return self._fail(f"no answer to {self._phase.value}, line {self._line}")
        self._tries, self._due = self._tries + 1, now + ANSWER_S
        if self._phase is _Phase.COMPARE:
            return [encode(StoreQuery())]
        return [encode(MissionLine(len(self._lines), self._line, self._lines[self._line - 1]))]

    def _ask_why(self, now: float) -> list[bytes]:
        if self._phase is _Phase.START:
            self._refused = "refused"
        return [encode(StoreQuery())]

    def _compare(self, report: StoreReport, now: float) -> list[bytes]:
        if self._phase is _Phase.UPLOAD:
            return self._fail(f"the upload was refused: {report.refusal}")
        if self._phase is _Phase.START:
            self._refused = report.refusal or self._refused
            return []
        if self._phase is not _Phase.COMPARE:
            return []
        if report.digest != self._digest[:16]:
            return self._fail(f"the store holds {report.digest or 'nothing'}, not this mission")
        self._phase, self._due = _Phase.START, max(now, FIRST_START_S)
        return []

    def _start(self, now: float) -> list[bytes]:
        if now > START_UNTIL_S:
            return self._fail(f"the start was refused: {self._refused or 'no answer'}")
        self._due = now + START_EVERY_S
        return [encode(StartMission())]

    def _begin(self, now: float) -> list[bytes]:
        self._phase, self.started = _Phase.WATCH, now
        return []

    def _fail(self, why: str) -> list[bytes]:
        self._phase, self.failure = _Phase.FAILED, why
        return []
