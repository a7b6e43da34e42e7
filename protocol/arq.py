"""Stop-and-wait over the acoustic modem: topside asks, the vehicle answers (R1, R15).

    topside   Initiator  --- content (whole frames) --->  Responder   vehicle
                         <-- one content of answers ----

Rules:
  * One request at a time is outstanding. It is repeated if no answer has arrived within
        2 x slant range / 1500 m/s + way of request and of the longest answer + 2 s
    (way: the airtime, and the time on the serial lines of both modems). After ``tries`` the result
    is ``NoAnswer``; nothing is assumed. A request must be harmless if it is received twice: the
    envelope has no sequence number that would show a repetition.
  * A request may be several contents in one burst, each in its own envelope. A bit error then
    spoils one of them only. The vehicle does not answer while the next content is arriving. A
    content still unfinished ``HELD`` after the last request is noise, and delays no answer.
  * The vehicle sends when it is asked. Frames that are ready within ``FLOOR`` of a request go out
    as one content; later frames wait for the next request. The one exception is R11's status on
    surfacing (``unasked``): it waits until the line is quiet, in noise for ``NOISE`` at most.
  * If an answer contains an ``@AR``, the ``@ACK_AW`` frames beside it are left out (R4).

Time is a parameter: call ``outgoing`` and ``receive`` when bytes arrive and at ``next_timer``.

What does not live here: the envelope (protocol.modem), the requests (protocol.batch, mission).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from protocol.messages import FrameFault
from protocol.modem import (
    BAUD,
    BITS_PER_BYTE,
    MOST,
    OVERHEAD,
    Envelope,
    ModemCodec,
    Sender,
    wrap,
)
from protocol.tolerances import Tolerances

SOUND_SPEED = 1500.0  # m/s
TURNAROUND = 2.0  # s: R1's allowance for modems and programs at both ends
TRIES = 2
FLOOR = 1.5  # s after a request: until then it may be answered; less than TURNAROUND
GATHER = 0.2  # s without a further frame: the answer is complete
HELD = FLOOR - GATHER  # s after a request; the longest content takes 0.3 s at the line's rate
NOISE = 60.0  # s without a request: noise delays an unasked frame no longer than this
WAITING = 256  # frames of the vehicle that wait for a request; beyond, the oldest are dropped


@dataclass(frozen=True, slots=True)
class Acoustics:
    """The parameters of the timeouts. ``range_m``: greatest slant range expected. ``preamble``:
    seconds that a modem needs before the data. ``baud``: rate of the serial lines, assumed to be
    the same at both ends."""

    range_m: float
    bit_rate: float  # bit/s on the water
    preamble: float = 0.0
    baud: float = BAUD

    def airtime(self, content: int) -> float:
        """Return the airtime, s, of ``content`` bytes with their envelope."""
        return self.preamble + 8.0 * (content + OVERHEAD) / self.bit_rate

    def way(self, content: int) -> float:
        """Return the time, s, through both modems; each stores a content whole before it sends."""
        return self.airtime(content) + 2.0 * BITS_PER_BYTE * (content + OVERHEAD) / self.baud

    def patience(self, request: int, answer: int) -> float:
        travel = 2.0 * self.range_m / SOUND_SPEED
        return travel + self.way(request) + self.way(answer) + TURNAROUND


# --- what an Initiator reports ---


@dataclass(frozen=True, slots=True)
class Answered:
    request: bytes
    content: bytes
    t: float


@dataclass(frozen=True, slots=True)
class NoAnswer:
    request: bytes
    t: float


@dataclass(frozen=True, slots=True)
class Unasked:
    """The other side sent a content that answers no outstanding request, or came too late."""

    content: bytes
    t: float


Heard = Answered | NoAnswer | Unasked | FrameFault


@dataclass(slots=True)
class _Outstanding:
    content: bytes
    burst: bytes
    wait: float
    matches: Callable[[bytes], bool]
    tries: int  # left
    deadline: float = 0.0
    sent: bool = False


class Initiator:
    """The side that sends requests."""

    def __init__(
        self,
        acoustics: Acoustics,
        *,
        address: Sender = Sender.TOPSIDE,
        tolerances: Tolerances | None = None,
    ) -> None:
        self.acoustics = acoustics
        self._address = address
        self._codec = ModemCodec(tolerances, acoustics.baud)
        self._request: _Outstanding | None = None

    @property
    def idle(self) -> bool:
        return self._request is None

    def ask(
        self,
        content: bytes,
        longest_answer: int,
        *,
        tries: int = TRIES,
        matches: Callable[[bytes], bool] = bool,
        ahead: Sequence[bytes] = (),
    ) -> None:
        """Take a request; only while ``idle``, else ValueError. ``longest_answer``: bytes. A
        content for which ``matches`` is false is no answer to it. ``ahead``: contents sent before
        it in the same burst, each in its own envelope."""
        if self._request is not None:
            raise ValueError("one request at a time: the one before is not answered yet")
        burst = b"".join(wrap(each, self._address) for each in (*ahead, content))
        wait = self.acoustics.patience(len(burst) - OVERHEAD, longest_answer)
        self._request = _Outstanding(content, burst, wait, matches, tries)

    def outgoing(self, now: float) -> list[bytes]:
        """Return what to send now. ``receive`` reports a request that is out of tries."""
        request = self._request
        if request is None or request.tries == 0 or (request.sent and now < request.deadline):
            return []
        request.sent, request.tries = True, request.tries - 1
        request.deadline = now + request.wait
        return [request.burst]

    def receive(self, data: bytes, now: float) -> list[Heard]:
        out: list[Heard] = []
        for item in self._codec.receive(data, now) + self._codec.flush(now):
            if isinstance(item, FrameFault):
                out.append(item)
            elif item.address != self._address:  # not our own echo
                out.append(self._heard(item))
        request = self._request
        if request is not None and request.sent and request.tries == 0 and now >= request.deadline:
            self._request = None
            out.append(NoAnswer(request.content, now))
        return out

    def next_timer(self) -> float | None:
        """Return when ``receive`` (with b"" if nothing came) and then ``outgoing`` are due."""
        request = self._request
        due = None if request is None or not request.sent else request.deadline
        return _first(due, self._codec.next_timer())

    def _heard(self, envelope: Envelope) -> Heard:
        request = self._request
        if request is None or not request.sent or not request.matches(envelope.content):
            return Unasked(envelope.content, envelope.t)
        self._request = None
        return Answered(request.content, envelope.content, envelope.t)


class Responder:
    """The side that answers requests."""

    def __init__(
        self,
        *,
        address: Sender = Sender.VEHICLE,
        tolerances: Tolerances | None = None,
        baud: float = BAUD,
    ) -> None:
        self._address = address
        self._codec = ModemCodec(tolerances, baud)
        self._waiting: deque[bytes] = deque(maxlen=WAITING)
        self._floor = -1.0  # until when an answer may be sent
        self._complete = 0.0  # when the answer counts as complete
        self._unasked: bytes | None = None
        self._quiet = 0.0  # from when on an unasked frame may be sent
        self._latest = 0.0  # when it is sent in spite of noise

    @property
    def patience(self) -> float:
        """Seconds after which an unfinished content is given up (G3)."""
        return self._codec.framer.patience

    def receive(self, data: bytes, now: float) -> list[Envelope | FrameFault]:
        """Return the requests. The caller reads their content and calls ``answer`` per frame."""
        if data:
            self._quiet = now + FLOOR
        out: list[Envelope | FrameFault] = []
        for item in self._codec.receive(data, now) + self._codec.flush(now):
            if isinstance(item, FrameFault):
                out.append(item)
            elif item.address != self._address:
                self._floor, self._complete = now + FLOOR, now + GATHER
                self._latest = now + NOISE
                out.append(item)
        return out

    def answer(self, frame: bytes, now: float) -> None:
        self._waiting.append(frame)
        self._complete = max(self._complete, now + GATHER)

    def unasked(self, frame: bytes, now: float) -> None:
        """Take a frame that does not wait for a request (R11); a newer one replaces it."""
        if self._unasked is None:
            self._latest = now + NOISE
        self._unasked = frame
        self._quiet = max(self._quiet, now)

    def outgoing(self, now: float) -> list[bytes]:
        if now > self._floor:
            self._floor = -1.0  # too late: the other side may be asking again
        if self._waiting and self._answered_at() <= now <= self._floor:
            self._floor = -1.0
            return [wrap(self._take(), self._address)]
        if self._unasked is not None and now >= self._unasked_at():
            frame, self._unasked = self._unasked, None
            return [wrap(frame, self._address)]
        return []

    def next_timer(self) -> float | None:
        due = None
        if self._waiting and self._answered_at() <= self._floor:
            due = self._answered_at()
        elif self._unasked is not None:
            due = self._unasked_at()
        return _first(due, self._codec.next_timer())

    def _answered_at(self) -> float:
        """When the answer may go out: it is complete, and no further content is arriving. Bytes
        that are still unfinished ``HELD`` after the request are noise."""
        if self._codec.next_timer() is None:
            return self._complete
        return max(self._complete, self._floor - FLOOR + HELD)

    def _unasked_at(self) -> float:
        return max(min(self._quiet, self._latest), self._floor)

    def _take(self) -> bytes:
        """Take as many whole frames as fit into one content, oldest first."""
        if any(frame.startswith(b"@AR,") for frame in self._waiting):
            kept = [frame for frame in self._waiting if not frame.startswith(b"@ACK_AW")]
            self._waiting = deque(kept, maxlen=WAITING)
        content = b""
        while self._waiting and len(content) + len(self._waiting[0]) <= MOST:
            content += self._waiting.popleft()
        return content


def _first(*times: float | None) -> float | None:
    return min((t for t in times if t is not None), default=None)
