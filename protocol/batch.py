"""A mission over the acoustic modem: whole batches of lines, one question, then what is missing.

    content = @AW line 1, @AW ..., as many as pay, @AQ$      -->
                                                             <-- @AR state, missing, digest

Rules:
  * Line 1 goes first until the vehicle has reported our set: what it holds is ours only after that
    (R3), and a line that is already held has no effect.
  * No answer leaves open whether request or answer was lost. Where the content takes longer on the
    water than asking, a short question comes first.
  * A content is as long as pays (protocol.sizing): up to 3200 bytes on a channel that loses frames
    whatever their length, shorter on one that spoils bits.
  * The vehicle's report is waited for as long as it should take, and after three silences as long
    as the longest one (with a refusal in it) takes.
  * Done is what the vehicle's digest proves, nothing else.

What does not live here: when to repeat one request (protocol.arq), the mission's text and digest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from protocol.arq import Acoustics, Answered, Initiator, NoAnswer
from protocol.framing import Framer
from protocol.messages import FrameFault, MissionLine, StoreQuery, StoreReport
from protocol.sizing import Channel
from protocol.tolerances import Tolerances
from protocol.topside import encode, to_topside_frames
from protocol.topside_frames import LONG

SILENCE = 24  # requests in a row without an answer: nobody is there (1 in 10^4 at 40 % loss)
_QUESTION = encode(StoreQuery())
_USUAL = 50  # bytes of an @AR beside its list of missing lines
_GROWTH = 12  # bytes: the next report's list may have one range more
_DOUBTS = 3  # silences after which the answer may have been longer than expected


@dataclass(frozen=True, slots=True)
class Stored:
    """The vehicle holds exactly this mission."""


@dataclass(frozen=True, slots=True)
class Declined:
    """The vehicle holds all lines, or is busy, and says why it does not store them."""

    why: str


@dataclass(frozen=True, slots=True)
class Silent:
    """No answer; what the vehicle holds is not known."""


Outcome = Stored | Declined | Silent


class BatchUpload:
    """Drive it like an Initiator until ``outcome`` is there. ``digest``: 16 hex digits."""

    def __init__(
        self,
        lines: Sequence[str],
        digest: str,
        acoustics: Acoustics,
        *,
        tolerances: Tolerances | None = None,
    ) -> None:
        total = len(lines)
        self.frames = [encode(MissionLine(total, n, text)) for n, text in enumerate(lines, 1)]
        self._digest = digest
        self._arq = Initiator(acoustics, tolerances=tolerances)
        self._channel = Channel(acoustics)
        self._silence = 0
        self._usual = _USUAL  # bytes of answer to reckon with
        self._ours = False  # the vehicle has reported a set that began with our line 1
        self._content = b""  # the last one with lines
        self._asking = False  # the outstanding request is the short question
        self.missing: tuple[int, ...] = tuple(range(1, total + 1))
        self.outcome: Outcome | None = None
        self._send_lines()

    def outgoing(self, now: float) -> list[bytes]:
        return self._arq.outgoing(now)

    def next_timer(self) -> float | None:
        return self._arq.next_timer()

    def receive(self, data: bytes, now: float) -> list[FrameFault]:
        faults = []
        for heard in self._arq.receive(data, now):
            if isinstance(heard, FrameFault):
                faults.append(heard)
            elif isinstance(heard, Answered):
                self._channel.learn(len(heard.request), len(heard.content), came=True)
                self._answered(heard.request, heard.content)
            elif isinstance(heard, NoAnswer):
                self._channel.learn(len(heard.request), self._usual, came=False)
                self._unanswered()
        return faults

    # --- what to send ---------------------------------------------------------------------

    def _head(self) -> bytes:
        return b"" if self._ours else self.frames[0]

    def _send_lines(self) -> None:
        content = self._head()
        wanted = [self.frames[n - 1] for n in self.missing if n > 1 or self._ours]
        left, overhead = sum(map(len, wanted)), len(content) + len(_QUESTION)
        size = self._channel.best_size(left, overhead, self._usual, self._longest())
        for frame in wanted:
            room = size - len(content) - len(frame)
            if frame is not wanted[0] and room < len(_QUESTION):
                break
            content += frame
        self._content = content + _QUESTION
        self._ask(self._content, asking=False)

    def _send_question(self) -> None:
        self._ask(self._head() + _QUESTION, asking=True)

    def _ask(self, content: bytes, *, asking: bool) -> None:
        self._asking = asking
        self._arq.ask(content, self._longest(), tries=1, matches=lambda a: b"@AR," in a)

    def _longest(self) -> int:
        return LONG if self._silence >= _DOUBTS else self._usual

    def _costs_more_than_asking(self) -> bool:
        acoustics = self._arq.acoustics
        question = len(self._head()) + len(_QUESTION)
        return acoustics.airtime(len(self._content)) > acoustics.patience(question, self._longest())

    # --- what came ------------------------------------------------------------------------

    def _answered(self, request: bytes, content: bytes) -> None:
        self._silence, self._usual = 0, max(_USUAL, len(content) + _GROWTH)
        report = _report(content)
        if report is not None:
            self._judge(report, self._ours or request.startswith(self.frames[0]))
        if self.outcome is None:
            self._send_lines()

    def _judge(self, report: StoreReport, heard_line_1: bool) -> None:
        total = len(self.frames)
        if report.digest == self._digest and report.state in ("ready", "running"):
            self.missing, self.outcome = (), Stored()
        elif report.state == "running":
            self.outcome = Declined("the vehicle is not idle")
        elif report.state == "staging" and report.total == total and heard_line_1:
            self._ours, self.missing = True, _numbers(report.missing, total)
        elif report.refusal and not self._ours:
            self.outcome = Declined(report.refusal)
        else:  # the set was dropped: from the beginning
            self._ours, self.missing = False, tuple(range(1, total + 1))

    def _unanswered(self) -> None:
        self._silence += 1
        if self._silence >= SILENCE:
            self.outcome = Silent()
        elif self._asking or self._costs_more_than_asking():
            self._send_question()
        else:
            self._send_lines()


def _report(content: bytes) -> StoreReport | None:
    framer = Framer(to_topside_frames(Tolerances()))
    for item in framer.receive(content, 0.0):
        if not isinstance(item, FrameFault) and item.type.name == "auv.AR":
            return StoreReport(**item.values())
    return None


def _numbers(ranges: str, most: int) -> tuple[int, ...]:
    """``3-5.9`` to 3, 4, 5, 9."""
    numbers: list[int] = []
    for text in ranges.split(".") if ranges else ():
        first, _, last = text.partition("-")
        numbers += range(max(1, int(first)), min(most, int(last or first)) + 1)
    return tuple(numbers)
