"""Upload a mission over the acoustic modem: many lines in one burst, one question, then the rest.

    burst = [@AW line 1, @AW ...] [@AW ...] [@AW line 1, @AQ$]   -->
                                                                 <-- @AR state, missing, digest
    each [ ] is a block: a modem frame with its own CRC

Rules:
  * Line 1 goes first until the vehicle has reported our set: only then are the lines that it holds
    ours (R3). A line that it already holds has no effect. With several blocks line 1 is repeated in
    the last one, beside the question: a report is of our set only if line 1 has surely arrived.
  * Without an answer, either the request or the answer was lost. Lines that were in no burst yet go
    with the next question. If there are none, a short question goes first, if it takes less time
    than a repeated burst would probably waste.
  * protocol.sizing chooses the lengths of burst and blocks: up to 3200 bytes, in long blocks on a
    channel that loses whole bursts of any length, one line per block on a channel with bit errors.
    A bit error costs one block only: the vehicle reports which lines it lacks.
  * The timeout fits the expected report; after three silences it fits the longest one (with a
    refusal in it).
  * Only the vehicle's digest proves that the upload is done.

What does not live here: when to repeat one request (protocol.arq), the mission's text and digest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from protocol.arq import Acoustics, Answered, Initiator, NoAnswer
from protocol.framing import Framer
from protocol.messages import FrameFault, MissionLine, StoreQuery, StoreReport
from protocol.modem import OVERHEAD
from protocol.sizing import Channel, Plan, Task
from protocol.tolerances import Tolerances
from protocol.topside import encode, to_topside_frames
from protocol.topside_frames import LONG

SILENCE = 24  # requests in a row without an answer: give up (1 in 10^4 at 40 % loss)
NOT_IDLE = (
    "the vehicle is not in idle, where alone a mission can be uploaded: "
    "stop it and clear it at the surface first"
)
_QUESTION = encode(StoreQuery())
_USUAL = 50  # bytes of an @AR beside its list of missing lines
_GROWTH = 12  # bytes: the next report's list may have one range more
_AHEAD = 2  # silences in a row up to which lines that were in no burst yet still go out
_DOUBTS = 3  # silences after which the answer may be longer than expected


@dataclass(frozen=True, slots=True)
class Stored:
    """The vehicle holds exactly this mission."""


@dataclass(frozen=True, slots=True)
class Declined:
    """The vehicle does not store the mission; ``why``: its refusal, or that it is not in idle."""

    why: str


@dataclass(frozen=True, slots=True)
class Silent:
    """No answer; it is not known which lines the vehicle holds."""


Outcome = Stored | Declined | Silent


@dataclass(frozen=True, slots=True)
class Block:
    """Frames for one envelope. ``numbers``: their lines, without a line 1 that leads the burst."""

    numbers: tuple[int, ...]
    content: bytes


class BatchUpload:
    """One upload. Call it like an Initiator until ``outcome`` is set. ``digest``: 16 hex digits."""

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
        self._usual = _USUAL  # bytes of answer to expect
        self._ours = False  # the vehicle has reported a set that began with our line 1
        self._bursts: list[list[Block]] = []  # with lines, since the last report
        self._asking = False  # the outstanding request is the short question
        self.missing: tuple[int, ...] = tuple(range(1, total + 1))
        self.outcome: Outcome | None = None
        self._send_lines(self.missing)

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
                self._answered(heard.content)
            elif isinstance(heard, NoAnswer):
                self._channel.learn(len(heard.request), self._usual, came=False)
                self._unanswered()
        return faults

    # --- what to send ---------------------------------------------------------------------

    def _head(self) -> bytes:
        return b"" if self._ours else self.frames[0]

    def _send_lines(self, numbers: Sequence[int]) -> None:
        """Send as many of these lines, in blocks as long, as is best for the channel."""
        head = self._head()
        wanted = [n for n in numbers if n > 1 or not head]
        left = sum(len(self.frames[n - 1]) for n in wanted)
        line = left // max(len(wanted), 1) or 1
        task = Task(left, line, len(head), self._usual, self._longest())
        plan = self._channel.best(task)
        blocks = self._packed(wanted, plan)
        self._bursts.append(blocks)
        self._asking = False
        if len(blocks) == 1:
            self._ask([], blocks[0].content + _QUESTION)
        else:  # line 1 again, in the same block: it proves that the report is of our set
            self._ask([block.content for block in blocks], head + _QUESTION)

    def _packed(self, wanted: Sequence[int], plan: Plan) -> list[Block]:
        head = self._head()
        blocks = [Block((), head)]
        room = plan.size - len(head) - len(_QUESTION)
        room -= (len(head) + OVERHEAD) * (plan.block < plan.size)
        for n in wanted:
            frame, last = self.frames[n - 1], blocks[-1]
            fits = len(last.content) + len(frame) // 2 <= plan.block
            room -= len(frame) + (0 if fits else OVERHEAD)
            if room < 0 and n != wanted[0]:
                break
            if fits or not last.content:
                blocks[-1] = Block((*last.numbers, n), last.content + frame)
            else:
                blocks.append(Block((n,), frame))
        return blocks

    def _send_question(self) -> None:
        self._asking = True
        self._ask([], self._head() + _QUESTION)

    def _ask(self, ahead: list[bytes], content: bytes) -> None:
        longest = self._longest()
        self._arq.ask(content, longest, tries=1, matches=lambda a: b"@AR," in a, ahead=ahead)

    def _longest(self) -> int:
        return LONG if self._silence >= _DOUBTS else self._usual

    # --- what came ------------------------------------------------------------------------

    def _answered(self, content: bytes) -> None:
        self._silence, self._usual = 0, max(_USUAL, len(content) + _GROWTH)
        report = _report(content)
        if report is not None:
            self._judge(report)
        if self.outcome is None:
            self._send_lines(self.missing)

    def _judge(self, report: StoreReport) -> None:
        """Decide what follows from a report. Its question was in one block with line 1, unless the
        vehicle's set is known to be ours."""
        total = len(self.frames)
        if report.digest == self._digest and report.state in ("ready", "running"):
            self.missing, self.outcome = (), Stored()
        elif report.state == "running":
            self.outcome = Declined(NOT_IDLE)
        elif report.state == "staging" and report.total == total:
            self._ours, self.missing = True, _numbers(report.missing, total)
            self._learn_blocks(report.have)
        elif report.refusal and not self._ours:
            self.outcome = Declined(report.refusal)
        else:  # the vehicle has dropped the set: start again
            self._ours, self.missing = False, tuple(range(1, total + 1))
        self._bursts = []

    def _learn_blocks(self, have: int) -> None:
        """Learn which blocks arrived, as far as the report shows it. ``have``: lines held."""
        missing = set(self.missing)
        is_whole = have + len(missing) == len(self.frames)  # else the list of the rest is cut
        known = len(self.frames) if is_whole else max(missing, default=0)
        for burst in self._bursts:
            told = [block for block in burst if block.numbers and block.numbers[-1] <= known]
            came = [not missing.intersection(block.numbers) for block in told]
            if have == 1 or not any(came):
                continue  # line 1 or the burst was lost: no evidence about blocks
            for block, whole in zip(told, came, strict=True):
                self._channel.learn_block(len(block.content), came=whole)

    def _unanswered(self) -> None:
        self._silence += 1
        if self._silence >= SILENCE:
            self.outcome = Silent()
        elif self._silence <= _AHEAD and (unsent := self._unsent()):
            self._send_lines(unsent)
        elif not self._bursts or self._asking_pays():
            self._send_question()
        else:
            self._send_lines([n for block in self._bursts[-1] for n in block.numbers])

    def _asking_pays(self) -> bool:
        """Whether to send a short question before the last burst is repeated."""
        last = self._bursts[-1]
        size, sent = sum(len(block.content) for block in last), self._bursts.count(last)
        task = Task(size, size, len(self._head()), self._usual, self._longest())
        return self._channel.asking_pays(size + OVERHEAD * len(last), sent, task)

    def _unsent(self) -> list[int]:
        """Missing lines that no burst had since the last report."""
        sent = {n for blocks in self._bursts for block in blocks for n in block.numbers}
        return [n for n in self.missing if n not in sent and (n > 1 or self._ours)]


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
