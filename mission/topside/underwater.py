"""An operator's conversation with a vehicle behind the acoustic modem. Sans-IO.

    modem+serial:///dev/ttyUSB0?range=800&rate=600      (m, bit/s on the water)
    modem+tcp://10.0.0.7:9000?range=800&rate=600

Timeouts follow from the greatest slant range, the bit rate and the baud rate in the URL, and from
the lengths of the frames (R1, protocol.arq). ``Submerged`` holds the same scripts as
``upload.Conversation``, at most two tries each. ``BatchTalk`` uploads in batches (protocol.batch).

What does not live here: the scripts (upload), sockets and clocks (console), the vehicle's side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlencode

from links import at_rate, baud_of
from mission.topside.upload import NoAnswer, OperatorError, Refused, Script, Scripted
from protocol.arq import TRIES, Acoustics, Answered, Initiator
from protocol.arq import NoAnswer as Unanswered
from protocol.batch import BatchUpload, Declined, Silent, Stored
from protocol.messages import DataQuery, Emergency, FrameFault, Relay, StateQuery, StoreQuery
from protocol.modem import BAUD
from protocol.state_frame import MOST
from protocol.topside import Answer, ConsoleCodec, encode
from protocol.topside_frames import LONG

_MOST = 1e6  # m, bit/s
PREFIX = "modem+"
RANGE_M, BIT_RATE = 1000.0, 300.0  # the slow and far case: too long a timeout only costs time
_ACK = 9  # bytes
LONGEST = {DataQuery: LONG, StoreQuery: LONG, Relay: LONG, StateQuery: MOST}


class WrongAddress(OperatorError):
    """The URL is wrong; the message says what to write."""


@dataclass(frozen=True, slots=True)
class ModemAddress:
    link: str  # the modem's own URL
    acoustics: Acoustics


def modem_address(url: str) -> ModemAddress | None:
    """Return None for a URL without a modem. Raises WrongAddress."""
    if not url.startswith(PREFIX):
        return None
    link, _, query = url.removeprefix(PREFIX).partition("?")
    options = dict(parse_qsl(query, keep_blank_values=True))
    range_m = _number(url, options.pop("range", RANGE_M), "range", "m")
    bit_rate = _number(url, options.pop("rate", BIT_RATE), "rate", "bit/s")
    own = f"?{urlencode(options)}" if options else ""
    at = at_rate(link + own, BAUD)
    return ModemAddress(at, Acoustics(range_m, bit_rate, baud=baud_of(at, BAUD)))


def _number(url: str, text: str | float, option: str, unit: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= _MOST:
        needed = f"a number of {unit} above 0, at most {_MOST:.0f}, is needed"
        raise WrongAddress(f"{url}: {option}={text}: {needed}")
    return value


class Submerged(Scripted):
    """Like ``upload.Conversation``, over an Initiator."""

    def __init__(self, script: Script, acoustics: Acoustics) -> None:
        super().__init__(script)
        self._arq = Initiator(acoustics)
        self._fitting: Answer | None = None

    def begin(self, now: float) -> list[bytes]:
        return self._go(None, now)

    def next_timer(self) -> float | None:
        return self._arq.next_timer()

    def handle_timer(self, now: float) -> list[bytes]:
        return self.receive(b"", now)

    def receive(self, data: bytes, now: float) -> list[bytes]:
        for heard in self._arq.receive(data, now):
            if isinstance(heard, Answered):
                return self._go(self._fitting, now)
            if isinstance(heard, Unanswered):
                return self._go(None, now)
        return self._arq.outgoing(now)

    def _go(self, answer: Answer | None, now: float) -> list[bytes]:
        ask = self._next(answer)
        if ask is None:
            return []
        command = ask.command
        longest = LONGEST.get(type(command), _ACK)
        tries = ask.tries if isinstance(command, Emergency) else min(TRIES, ask.tries)
        self._arq.ask(encode(command), longest, tries=tries, matches=self._fits)
        return self._arq.outgoing(now)

    def _fits(self, content: bytes) -> bool:
        assert self._ask is not None
        for answer in ConsoleCodec().receive(content, 0.0):
            if not isinstance(answer, FrameFault) and self._ask.fits(answer):
                self._fitting = answer
                return True
        return False


class BatchTalk:
    """An upload in batches, held like a conversation. ``progress``: lines held, and all lines."""

    def __init__(
        self,
        lines: Sequence[str],
        digest: str,
        acoustics: Acoustics,
        progress: Callable[[int, int], None],
    ) -> None:
        self._total, self._digest, self._progress = len(lines), digest[:16], progress
        self._batch = BatchUpload(lines, self._digest, acoustics)

    @property
    def over(self) -> bool:
        return self._batch.outcome is not None

    @property
    def result(self) -> str | None:
        stored = isinstance(self._batch.outcome, Stored)
        return f"{self._total} lines stored, digest {self._digest}" if stored else None

    @property
    def failure(self) -> OperatorError | None:
        match self._batch.outcome:
            case Declined(why=why):
                return Refused(why)
            case Silent():
                return NoAnswer("no answer; what the vehicle holds is not known; see status")
            case _:
                return None

    def begin(self, now: float) -> list[bytes]:
        return self._batch.outgoing(now)

    def next_timer(self) -> float | None:
        return self._batch.next_timer()

    def handle_timer(self, now: float) -> list[bytes]:
        return self.receive(b"", now)

    def receive(self, data: bytes, now: float) -> list[bytes]:
        before = self._batch.missing
        self._batch.receive(data, now)
        if self._batch.missing != before:
            self._progress(self._total - len(self._batch.missing), self._total)
        return [] if self.over else self._batch.outgoing(now)
