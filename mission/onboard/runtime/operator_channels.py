"""The two paths between an operator and the Pi (R12): a stream of frames, and modem envelopes.

    StreamChannel   one TCP connection: frames as they come, answers at once
    ModemChannel    half duplex: the answers to one request leave together, in their turn (R15);
                    X and W are found in any bytes (``obeyed``)

A whole frame with an invalid value (G4) becomes ``Unfit``, so that it can be answered N. Bytes that
are no frame, or have the wrong number of fields (E-V2), are a fault alone. An M within a fault is
``Unfit``, too: somebody holds the stick (R6).

What does not live here: envelope and turns (protocol.modem, protocol.arq), the answers
(operator_server).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from links import baud_of
from mission.onboard.runtime.command_target import MODEM, Answer
from mission.onboard.runtime.obeyed import Obeyed
from protocol.arq import Responder
from protocol.messages import Command, FrameFault
from protocol.modem import BAUD, Envelope
from protocol.tolerances import Tolerances
from protocol.topside import TopsideCodec, encode


@dataclass(frozen=True, slots=True)
class Unfit:
    """A command that is refused whole. ``code``: the command that the N answers, such as ``AW``; or
    ``STICK``, which gets no answer."""

    code: str
    fault: FrameFault


Heard = Command | FrameFault | Unfit

STICK = "manual"  # its name in a refusal
_STICK = re.compile(rb"@M[TDMRSP][^@$]*\$")  # whatever its value
_ANSWERED = ("NS", "AW", "AO", "ST", "SP")  # those with values that may be invalid
_UNFIT = ("out_of_range", "bad_enum", "non_numeric", "empty_field")
_LONGEST = 512  # bytes that a fault may reach back


class _Listener:
    """A TopsideCodec that keeps recent bytes, to look into a fault."""

    def __init__(self, tolerances: Tolerances) -> None:
        self._codec = TopsideCodec(tolerances)
        self._recent, self._offset = b"", 0  # the last bytes, and where they begin in the stream

    def receive(self, data: bytes, now: float) -> list[Heard]:
        self._recent += data
        heard = [self._named(item) for item in self._codec.receive(data, now)]
        spare = max(len(self._recent) - _LONGEST, 0)
        self._recent, self._offset = self._recent[spare:], self._offset + spare
        return heard

    def flush(self, now: float) -> list[Heard]:
        return [self._named(item) for item in self._codec.flush(now)]

    def next_timer(self) -> float | None:
        return self._codec.next_timer()

    def _named(self, item: Command | FrameFault) -> Heard:
        if not isinstance(item, FrameFault):
            return item
        begin = item.offset - self._offset
        raw = self._recent[max(begin, 0) : begin + item.length]
        code = raw[1:3].decode("ascii", "replace")
        whole = begin >= 0 and raw.startswith(b"@") and raw.endswith(b"$")
        if whole and code in _ANSWERED and item.kind in _UNFIT:
            return Unfit(code, item)
        return Unfit(STICK, item) if _STICK.search(raw) else item


class OperatorChannel(Protocol):
    def receive(self, data: bytes, now: float) -> list[Heard]: ...

    def handle_timer(self, now: float) -> list[Heard]: ...

    def send(self, answer: Answer, now: float, reason: str, unasked: bool = False) -> None: ...

    def outgoing(self, now: float) -> Sequence[tuple[bytes, str]]:
        """The bytes that leave now, each with its reason."""
        ...

    def next_timer(self) -> float | None: ...


class StreamChannel:
    def __init__(self, tolerances: Tolerances) -> None:
        self._codec, self._tolerances = _Listener(tolerances), tolerances
        self._out: list[tuple[bytes, str]] = []

    def receive(self, data: bytes, now: float) -> list[Heard]:
        return self._codec.receive(data, now)

    def handle_timer(self, now: float) -> list[Heard]:
        due = self._codec.next_timer()
        return self._codec.flush(now) if due is not None and due <= now else []

    def send(self, answer: Answer, now: float, reason: str, unasked: bool = False) -> None:
        self._out.append((encode(answer, self._tolerances), reason))

    def outgoing(self, now: float) -> Sequence[tuple[bytes, str]]:
        if not self._out:
            return ()
        out, self._out = self._out, []
        return out

    def next_timer(self) -> float | None:
        return self._codec.next_timer()


class ModemChannel:
    def __init__(self, tolerances: Tolerances, baud: float) -> None:
        self._responder = Responder(tolerances=tolerances, baud=baud)
        self._tolerances = tolerances
        self._obeyed = Obeyed(tolerances, self._responder.patience)

    def receive(self, data: bytes, now: float) -> list[Heard]:
        found = self._obeyed.found(data)
        heard = self._opened(self._responder.receive(data, now), now)
        return [*self._obeyed.at_once(found, heard, now), *heard]

    def handle_timer(self, now: float) -> list[Heard]:
        return self._opened(self._responder.receive(b"", now), now)

    def send(self, answer: Answer, now: float, reason: str, unasked: bool = False) -> None:
        say = self._responder.unasked if unasked else self._responder.answer
        say(encode(answer, self._tolerances), now)

    def outgoing(self, now: float) -> list[tuple[bytes, str]]:
        return [(data, "answers by modem") for data in self._responder.outgoing(now)]

    def next_timer(self) -> float | None:
        return self._responder.next_timer()

    def _opened(self, items: Sequence[Envelope | FrameFault], now: float) -> list[Heard]:
        heard: list[Heard] = []
        for item in items:
            if isinstance(item, FrameFault):
                heard.append(item)
                continue
            codec = _Listener(self._tolerances)  # whole frames: no state carries over
            content = codec.receive(item.content, item.t) + codec.flush(math.inf)
            heard += self._obeyed.left_of(content, now)
        return heard


def operator_channels(
    tolerances: Tolerances, modem: str | None = None
) -> Callable[[str], OperatorChannel]:
    """Return a function that makes a channel for a link, by its name. ``modem``: its URL."""
    return partial(_channel, tolerances, baud_of(modem or "", BAUD))


def _channel(tolerances: Tolerances, baud: float, link: str) -> OperatorChannel:
    return ModemChannel(tolerances, baud) if link == MODEM else StreamChannel(tolerances)
