"""Both directions of the serial line: 9600 8N1 is 10 bits a byte, 1.0417 ms.

A ``Chunk`` is what leaves without a pause; a reader gets it whole when its last byte is through,
with the time of its first one. Whole chunks are scheduled by arithmetic: no event per byte.

What does not live here: what the bytes mean.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import inf
from random import Random

BYTE_TIME = 10 / 9600  # s
BURST_GAP = 0.005  # s of silence that end a burst


def turned_over(data: bytes, rng: Random) -> bytes:
    """One bit of it, any one."""
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1 :]


@dataclass(slots=True)
class Chunk:
    start: float  # first bit of the first byte
    end: float  # last bit of the last byte
    data: bytes


class Transmitter:
    """The board's TX pin, with the faults that a line can have."""

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.queue: deque[Chunk] = deque()
        self.free = 0.0  # when the last queued byte is through
        self.silent = False
        self.corrupt = 0.0  # share of frames with a bit turned over
        self.noise = 0.0  # share of frames with garbage in front of them

    def send(self, data: bytes, now: float) -> None:
        """Behind everything that is already on its way."""
        if self.silent:
            return
        data = self._spoilt(data)
        start = max(now, self.free)
        self.free = start + len(data) * BYTE_TIME
        self.queue.append(Chunk(start, self.free, data))

    def cut_in(self, data: bytes, now: float) -> bool:
        """Into the middle of the chunk that is being sent; False if there is none."""
        if self.silent or not self.queue:
            return False
        chunk = self.queue[-1]
        if not chunk.start < now < chunk.end:
            return False
        at = min(int((now - chunk.start) / BYTE_TIME) + 1, len(chunk.data))
        chunk.data = chunk.data[:at] + data + chunk.data[at:]
        chunk.end += len(data) * BYTE_TIME
        self.free = chunk.end
        return True

    def take(self, now: float) -> list[Chunk]:
        """Everything whose last byte is through by ``now``."""
        queue, out = self.queue, []
        while queue and queue[0].end <= now:
            out.append(queue.popleft())
        return out

    def _spoilt(self, data: bytes) -> bytes:
        rng = self.rng
        if self.corrupt and rng.random() < self.corrupt:
            data = turned_over(data, rng)
        if self.noise and rng.random() < self.noise:
            data = rng.randbytes(rng.randint(1, 40)) + data
        return data


class Receiver:
    """The board's RX pin: bytes in, bursts out. ``due`` is when the next burst is closed."""

    def __init__(self) -> None:
        self._bursts: deque[Chunk] = deque()
        self._free = 0.0
        self.due = inf  # asked for much more often than anything is sent

    def feed(self, data: bytes, now: float) -> None:
        """The sender writes at ``now``; its UART sends at the line's pace."""
        start = max(now, self._free)
        self._free = end = start + len(data) * BYTE_TIME
        if self._bursts and start - self._bursts[-1].end < BURST_GAP:
            last = self._bursts[-1]
            last.data += data
            last.end = end
        else:
            self._bursts.append(Chunk(start, end, data))
        self._look()

    def take(self) -> bytes:
        burst = self._bursts.popleft()
        self._look()
        return burst.data

    def clear(self) -> None:
        self._bursts.clear()
        self._look()

    def _look(self) -> None:
        self.due = self._bursts[0].end + BURST_GAP if self._bursts else inf
