"""Both directions of the serial line: 9600 8N1 is 10 bits a byte, 1.0417 ms.

A ``Chunk`` is sent without a pause. A reader gets it whole when its last byte has been sent, with
the time of its first byte. Times of chunks are computed: there is no event per byte.

What does not live here: the meaning of the bytes.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import inf
from random import Random

BYTE_TIME = 10 / 9600  # s
BURST_GAP = 0.005  # s of silence that end a burst


def turned_over(data: bytes, rng: Random) -> bytes:
    """``data`` with one random bit flipped."""
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
        self.free = 0.0  # when the last queued byte has been sent
        self.silent = False
        self.corrupt = 0.0  # share of frames with a flipped bit
        self.noise = 0.0  # share of frames with garbage before them

    def send(self, data: bytes, now: float) -> None:
        """Send after everything that is already queued."""
        if self.silent:
            return
        data = self._spoilt(data)
        start = max(now, self.free)
        self.free = start + len(data) * BYTE_TIME
        self.queue.append(Chunk(start, self.free, data))

    def cut_in(self, data: bytes, now: float) -> bool:
        """Insert ``data`` into the chunk that is being sent. False if there is none."""
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
        """Return all chunks whose last byte has been sent by ``now``."""
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
    """The board's RX pin: bytes in, bursts out. ``due``: when the next burst ends."""

    def __init__(self) -> None:
        self._bursts: deque[Chunk] = deque()
        self._free = 0.0
        self.due = inf  # kept, since it is read far more often than it changes

    def feed(self, data: bytes, now: float) -> None:
        """Take bytes that the sender writes at ``now``; they arrive at the line's rate."""
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
