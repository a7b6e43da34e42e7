"""Operators: raw bytes over TCP, and by acoustic modem.

No retry and no politeness that a script does not ask for. What is sent and when is on record; the
laws compare it with what reaches the board.
"""

from __future__ import annotations

import contextlib
import re
import socket
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field

from tests.sea.wire import Line, modem_frame

Script = Generator[None, None, None]
Answer = Generator[None, None, str]


def line_frames(text: str) -> list[bytes]:
    """A mission script as `@AW` frames: counters binary, low byte first, counted from 1 (E-F3)."""
    lines = [line.strip() for line in text.strip().splitlines() if line.strip()]
    total = len(lines).to_bytes(2, "little")
    return [
        b"@AW" + total + (index + 1).to_bytes(2, "little") + line.encode() + b"$"
        for index, line in enumerate(lines)
    ]


@dataclass
class Operator:
    """One connection of a topside. `sent` has (time, frame), `heard` all bytes that came."""

    port: int
    clock: Callable[[], float]
    name: str = "boat"
    sent: list[tuple[float, bytes]] = field(default_factory=list)
    heard: bytes = b""
    wrote: bool = False
    waits_until: float = 0.0
    reads: bool = True  # whether it takes what comes

    def __post_init__(self) -> None:
        self.socket: socket.socket | None = None
        self.wanted = True
        self._retry = 0.0
        self._from = 0

    def keep(self) -> None:
        """Connect again, once a second, unless the script has closed the connection."""
        if self.wanted and self.socket is None and self.clock() >= self._retry:
            self._retry = self.clock() + 1.0
            self.connect()

    def connect(self) -> bool:
        """Open the connection, if the program listens."""
        line = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            line.connect(("127.0.0.1", self.port))
        except OSError:
            line.close()
            return False
        line.setblocking(False)
        self.socket, self.wrote = line, True
        return True

    def close(self) -> None:
        """Drop the connection, for good."""
        self.wanted = False
        self._drop()

    def _drop(self) -> None:
        if self.socket:
            self.socket.close()
            self.socket, self.wrote = None, True

    def send(self, frame: str | bytes) -> None:
        """Write one frame now."""
        data = frame.encode() if isinstance(frame, str) else frame
        if self.socket is None:
            return
        with contextlib.suppress(OSError):
            self.socket.send(data)
            self.sent.append((self.clock(), data))
            self.wrote = True

    def receive(self) -> None:
        """Take what has come."""
        if self.socket is None or not self.reads:
            return
        try:
            data = self.socket.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._drop()
        self.heard += data

    def await_ack(self, letters: str, within: float) -> Answer:
        """The third letter of the next `@ACK_` of this kind, or nothing after `within` s."""
        until = self.waits_until = self.clock() + within
        pattern = re.compile(rb"@ACK_" + letters.encode() + rb"(.)\$", re.DOTALL)
        while self.clock() < until:
            if match := pattern.search(self.heard, self._from):
                self._from = match.end()
                self.waits_until = 0.0
                return match[1].decode("latin-1")
            yield
        return ""

    def ask(self, frame: str | bytes, letters: str, within: float = 3.0) -> Answer:
        """Send a frame and wait for its acknowledgement."""
        self._from = len(self.heard)
        self.send(frame)
        return (yield from self.await_ack(letters, within))

    def upload(self, text: str) -> Answer:
        """Send a mission line by line; the last acknowledgement's letter (W when it is stored)."""
        letter = ""
        for frame in line_frames(text):
            letter = yield from self.ask(frame, "AW", 120.0)
            if letter != "W":
                return letter
        return letter

    def repeat(
        self, frame: str | Callable[[int], str], every: float, until: float = 1e9
    ) -> Iterator[None]:
        """Send a frame over and over until a time: a held stick, a slider, a poll."""
        due, count = self.clock(), 0
        while self.clock() < until:
            while due <= self.clock():
                self.send(frame if isinstance(frame, str) else frame(count))
                due, count = due + every, count + 1
            yield


@dataclass
class ModemOperator:
    """The same by acoustic modem: contents in envelopes, `delay` s of water and modem between."""

    line: Line
    clock: Callable[[], float]
    delay: float = 1.5
    sent: list[tuple[float, bytes]] = field(default_factory=list)
    heard: bytes = b""
    _under_way: list[tuple[float, bytes]] = field(default_factory=list)

    def send(self, frame: str | bytes) -> None:
        """One frame in one envelope."""
        data = frame.encode() if isinstance(frame, str) else frame
        self.sent.append((self.clock() + self.delay, data))
        self._under_way.append((self.clock() + self.delay, modem_frame(data)))

    def noise(self, data: bytes) -> None:
        """Bytes that no operator has sent."""
        self.line.send(self.clock(), data)

    def tick(self, now: float) -> None:
        """Let arrive what is due."""
        for at, data in [pair for pair in self._under_way if pair[0] <= now]:
            self._under_way.remove((at, data))
            self.line.send(now, data)

    def receive(self) -> None:
        """Take what has come."""
        self.heard += self.line.receive()
