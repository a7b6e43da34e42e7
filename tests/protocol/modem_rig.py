"""A vehicle that only takes missions, behind a simulated acoustic channel, in virtual time.

Shared by the tests of the modem and by its bench.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from links.acoustic import Tally, Water, acoustic_pair
from links.base import Link
from mission.onboard.runtime.staging import Staging, Whole
from protocol.arq import Acoustics, Answered, Initiator, NoAnswer, Responder
from protocol.batch import SILENCE, Outcome, Silent, Stored
from protocol.messages import FrameFault, MissionLine, StoreQuery, StoreReport
from protocol.modem import Envelope
from protocol.topside import TopsideCodec, answer, encode


def digest(lines: Sequence[str]) -> str:
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


def acoustics_of(water: Water) -> Acoustics:
    return Acoustics(water.range_m, water.bit_rate, water.preamble)


class Vehicle:
    """Stages @AW lines, answers them and @AQ; ``refusal``: what it says of a whole mission."""

    def __init__(self, refusal: str = "") -> None:
        self.responder = Responder()
        self.stored: tuple[str, ...] = ()
        self.requests: list[bytes] = []
        self._staging, self._refusal, self._said = Staging(), refusal, ""

    def receive(self, data: bytes, now: float) -> None:
        for item in self.responder.receive(data, now):
            if isinstance(item, Envelope):
                self.requests.append(item.content)
                self.read(item.content, now)

    def read(self, content: bytes, now: float) -> None:
        for command in TopsideCodec().receive(content, now):
            if isinstance(command, MissionLine):
                self.responder.answer(encode(answer("AW", self._line(command, now), now)), now)
            elif isinstance(command, StoreQuery):
                self.responder.answer(encode(self._report(now)), now)

    def _line(self, line: MissionLine, now: float) -> bool:
        offer = self._staging.offer(line, self.stored, now)
        if isinstance(offer, Whole):
            if self._refusal:
                self._said = self._refusal
                return False
            self.stored = offer.lines
            self._staging.clear()
        return True

    def _report(self, now: float) -> StoreReport:
        if self._staging.incomplete(self.stored, now):
            held = self._staging
            return StoreReport("staging", held.total, held.have, held.missing, "", self._said)
        n = len(self.stored)
        return StoreReport(
            "ready" if n else "empty", n, n, "", digest(self.stored) if n else "", self._said
        )


class Sender(Protocol):
    outcome: Outcome | None

    def outgoing(self, now: float) -> list[bytes]: ...
    def next_timer(self) -> float | None: ...
    def receive(self, data: bytes, now: float) -> list[FrameFault]: ...


class OneLineUpload:
    """What there was before: one line, one frame, one acknowledgement, and again."""

    def __init__(self, lines: Sequence[str], acoustics: Acoustics) -> None:
        total = len(lines)
        self.frames = [encode(MissionLine(total, n, text)) for n, text in enumerate(lines, 1)]
        self._arq, self._at, self._silence = Initiator(acoustics), 0, 0
        self.outcome: Outcome | None = None
        self._ask()

    def _ask(self) -> None:
        self._arq.ask(self.frames[self._at], 9, tries=1)

    def outgoing(self, now: float) -> list[bytes]:
        return self._arq.outgoing(now)

    def next_timer(self) -> float | None:
        return self._arq.next_timer()

    def receive(self, data: bytes, now: float) -> list[FrameFault]:
        for heard in self._arq.receive(data, now):
            if isinstance(heard, Answered):
                self._silence, self._at = 0, self._at + 1
                if self._at == len(self.frames):
                    self.outcome = Stored()
                else:
                    self._ask()
            elif isinstance(heard, NoAnswer):
                self._silence += 1
                if self._silence == SILENCE:
                    self.outcome = Silent()
                else:
                    self._ask()
        return []


@dataclass(frozen=True, slots=True)
class Flight:
    seconds: float
    topside: Tally
    vehicle: Tally

    @property
    def size(self) -> int:
        """Bytes on the water, both ways."""
        return self.topside.size + self.vehicle.size


def fly(sender: Sender, vehicle: Vehicle, water: Water, seed: int, most: float = 1e6) -> Flight:
    """Until the sender has its outcome, or ``most`` seconds are over."""
    boat, diver = acoustic_pair(water, seed)
    now = 0.0
    while True:
        for rx in boat.receive(now):
            sender.receive(rx.data, now)
        for rx in diver.receive(now):
            vehicle.receive(rx.data, now)
        sender.receive(b"", now)
        vehicle.receive(b"", now)
        if sender.outcome is not None:
            return Flight(now, boat.tally, diver.tally)
        _send(boat, sender.outgoing(now), now)
        _send(diver, vehicle.responder.outgoing(now), now)
        timers = (
            boat.next_event(),
            diver.next_event(),
            sender.next_timer(),
            vehicle.responder.next_timer(),
        )
        due = min((t for t in timers if t is not None), default=None)
        assert due is not None, "nothing is under way and nothing has been decided"
        assert due > now or now == 0.0 or due >= now
        now = max(due, now)
        if now > most:
            raise AssertionError(f"no outcome within {most} s")


def _send(link: Link, frames: Sequence[bytes], now: float) -> None:
    for frame in frames:
        link.send(frame, now)
