"""The loop around a stick: terminal, pad and link, with a safe end whatever is lost.

    keys, pad --> Helm --M--> link --> serve        @DU and @AQ in turn, every 0.5 s <-- answers
               --X, every second until it is acknowledged, or the hand moves it again-->

While an X is not acknowledged, @AE takes the place of @AQ. If the terminal, the pad or this program
is lost, no further M is sent, and the Pi stops the vehicle 2 s after the last one (R6). A link
without any answer for ``LOST_S`` is given up, and commands that have not arrived are dropped: the
stick of some seconds ago is no command.

    Lost        (the operator must act: says what is lost)

What does not live here: what is sent when (helm), what keys mean (keyboard), pads (joystick).
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import socket
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from links import open_link
from links.base import Link, LinkError
from mission.model import STOPPED
from mission.topside.console import Unreachable
from mission.topside.helm import PERIOD_S, Helm, Push
from mission.topside.joystick import Joystick
from mission.topside.keyboard import Keyboard, Wish
from mission.topside.showing import bearing
from mission.topside.upload import OperatorError
from protocol.messages import (
    Ack,
    DataQuery,
    FrameFault,
    Order,
    SetOutput,
    StateQuery,
    StateReport,
    Status,
    StoreQuery,
    StoreReport,
)
from protocol.topside import EMERGENCIES, Answer, ConsoleCodec, encode

ASK_S = 0.5
AGAIN_S = 1.0  # X (R1)
LOST_S = 2.0
_READ = 512
_ABORT = struct.pack("ii", 1, 0)  # SO_LINGER: waiting data are dropped


class Lost(OperatorError):
    pass


@dataclass(slots=True)
class Seen:
    """The values on the terminal's line; times in s of the monotonic clock."""

    gear: int = 0
    sent: bytes = b""
    answered: float = 0.0
    stop: str = ""
    output: str = ""
    status: Status | None = None
    store: StoreReport | None = None

    def line(self, now: float) -> str:
        own = self.status.telemetry if self.status is not None else None
        depth = "" if own is None or own.depth is None else f"{own.depth:.1f} m deep"
        heading = None if own is None else bearing(own.heading, 0)
        refusal = self.store.refusal if self.store is not None else ""
        old = refusal.endswith(" ago")  # R4: an earlier refusal
        parts = (
            f"gear {self.gear:2}",
            f"sent {self.sent.decode('ascii'):14}",
            f"answer {now - self.answered:.1f} s ago",
            self.stop,  # news first: a narrow terminal cuts the rest
            self.output,
            "" if old else refusal,
            depth,
            "" if heading is None else f"heading {heading:.0f}",
            f"of {self.status.time[11:]}" if self.status is not None and self.status.time else "",
            refusal if old else "",
        )
        return "  ".join(part for part in parts if part)


@dataclass(slots=True)
class Stick:
    """``keys``: descriptor of the terminal; ``pad``: descriptor and reader of a joystick."""

    keys: int
    keyboard: Keyboard
    show: Callable[[str], None]
    pad: tuple[int, Joystick] | None = None
    _helm: Helm = field(default_factory=Helm)
    _seen: Seen = field(default_factory=Seen)
    _codec: ConsoleCodec = field(default_factory=ConsoleCodec)
    _outputs: list[SetOutput] = field(default_factory=list)  # outputs that wait to be sent
    _asked: int = 0
    _ask_at: float = 0.0
    _stop_at: float = math.inf  # when X is sent again

    def steer(self, url: str) -> None:
        """Steer until the operator ends it. Raises Lost, Unreachable."""
        try:
            link = open_link("vehicle", url)
        except LinkError as error:
            raise Unreachable(str(error)) from error
        self._seen.answered = self._ask_at = time.monotonic()
        gone = False
        try:
            while self._step(link):
                pass
        except LinkError as error:
            gone = True
            stays = "; outputs stay as it last heard them, until that makes them safe"
            raise Lost(f"{error}; {self._left()}{stays * bool(self._seen.output)}") from error
        finally:
            if not gone:
                self._end(link)
            link.close()

    def _left(self) -> str:
        """Say what becomes of a vehicle that can no longer be reached."""
        if self._stop_at < math.inf:
            return "your X was NOT acknowledged: `auvmission stop`"
        if self._seen.sent:
            return "the vehicle stops 2 s after the last word"
        return "nothing was said to the vehicle: it goes on with what it does"

    def _step(self, link: Link) -> bool:
        """Return False when the operator has ended it."""
        now = time.monotonic()
        self._hear(link, now)
        if now - self._seen.answered > LOST_S:
            forget(link)
            raise LinkError("the vehicle does not answer")
        self._outputs += self.keyboard.let_go(now)
        self._helm.hold(self._push(now))
        if words := self._helm.words(now):
            link.send(b"".join(words), now)
            self._seen.sent, self._seen.stop, self._stop_at = b" ".join(words), "", math.inf
        if now >= self._stop_at and self._helm.is_silent:
            self._say_stop(link, now)
        self._set_outputs(link)
        if now >= self._ask_at:
            self._ask_at = now + ASK_S
            self._asked += 1
            known = StoreQuery() if self._stop_at == math.inf else StateQuery()
            link.send(encode(DataQuery() if self._asked % 2 else known), now)
        self._seen.gear = self.keyboard.gear
        self.show(self._seen.line(now))
        return self._wait(link)

    def _push(self, now: float) -> Push | None:
        typed = self.keyboard.push(now)
        if self.pad is None or (typed is not None and not typed.aside):
            return typed
        return self.pad[1].push(now) or typed

    def _wait(self, link: Link) -> bool:
        """Wait for the next event; return False to end."""
        now = time.monotonic()
        due = min(self._helm.next_timer() or self._ask_at, self._ask_at, now + PERIOD_S / 4)
        pads = [] if self.pad is None else [self.pad[0]]
        watched = [self.keys, link.fileno(), *pads]
        ready, _, _ = select.select(watched, [], [], max(0.0, due - now))
        now = time.monotonic()
        if self.pad is not None and self.pad[0] in ready:
            self.pad[1].receive(_read(self.pad[0], "the pad is gone"), now)
        if self.keys not in ready:
            return True
        for wish in self.keyboard.press(_read(self.keys, "the terminal is gone"), now):
            if isinstance(wish, SetOutput):
                self._outputs.append(wish)
            elif wish is Wish.QUIT:
                return False
            else:
                self._stop(link)
        return True

    def _stop(self, link: Link) -> None:
        self._helm.drop()
        self._outputs.clear()  # an emergency makes all outputs safe
        self._seen.output = ""
        self._say_stop(link, time.monotonic())

    def _say_stop(self, link: Link, now: float) -> None:
        link.send(EMERGENCIES[Order.STOP], now)
        self._seen.sent, self._stop_at = EMERGENCIES[Order.STOP], now + AGAIN_S

    def _set_outputs(self, link: Link) -> None:
        """Send the outputs, each once (R4), after the stick's commands, which some of them need."""
        for one in self._outputs:
            link.send(encode(one), time.monotonic())
            self._seen.output = f"{one.name} {one.value:g}"
        self._outputs.clear()

    def _hear(self, link: Link, now: float) -> None:
        for rx in link.receive(now):
            for answer in self._codec.receive(rx.data, now):
                if not isinstance(answer, FrameFault):
                    self._take(answer, now)

    def _take(self, answer: Answer, now: float) -> None:
        self._seen.answered = now
        match answer:
            case Status():
                self._seen.status = answer
            case StoreReport():
                self._seen.store = answer
            case StateReport(state=state) if state == STOPPED and self._stop_at < math.inf:
                self._seen.stop, self._stop_at = "X: the Pi has it, its board is silent", math.inf
            case Ack(group="Z"):
                self._seen.stop = "X acknowledged" if answer.ok else "X NOT acknowledged"
                self._stop_at = math.inf if answer.ok else self._stop_at
            case Ack(group="A", function="O") if self._seen.output:
                said = self._seen.output.partition(":")[0]
                self._seen.output = f"{said}: {'set' if answer.ok else 'REFUSED'}"

    def _end(self, link: Link) -> None:
        """Reset outputs whose key was held, and send neutral twice (R1); not on a link that is
        lost."""
        self._outputs += self.keyboard.let_go(math.inf)
        self._helm.hold(None)
        with contextlib.suppress(LinkError):
            self._set_outputs(link)
            while not self._helm.is_silent:
                if words := self._helm.words(time.monotonic()):
                    link.send(b"".join(words), time.monotonic())
                else:
                    time.sleep(PERIOD_S / 10)


def _read(descriptor: int, otherwise: str) -> bytes:
    """Raises Lost."""
    try:
        data = os.read(descriptor, _READ)
    except OSError as error:
        raise Lost(f"{otherwise}: {error.strerror}") from error
    if not data:
        raise Lost(otherwise)
    return data


def forget(link: Link) -> None:
    """Drop commands in the system's buffers, so that they are not sent when the radio is back."""
    with contextlib.suppress(OSError), socket.socket(fileno=os.dup(link.fileno())) as same:
        same.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _ABORT)
