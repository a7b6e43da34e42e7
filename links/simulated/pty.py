"""The simulated vehicle in real time, or a multiple of it, behind two pseudo-terminals.

    SimulatedVehicle --9600 8N1 pace--> pty --> serial:///dev/pts/N  (STM32)
                                        pty --> serial:///dev/pts/M  (GPS)

With ``speed`` 8 everything, the bytes included, is eight times as fast. Bytes go out in slices
(``SLICE``), each when the real line would have brought it; the loop sleeps in between. Faster than
real time a chunk goes out whole, when its last byte would be through: the 50 ms after which a
decoder gives up on an unfinished frame (G3) would be shorter than a scheduler's whim. What the
other side writes is timed when it is read here, and then takes its time on the simulated line.

What does not live here: the vehicle itself (link.py).
"""

from __future__ import annotations

import os
import select
import time
import tty
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from types import TracebackType

from links.simulated.firmware.uart import BYTE_TIME, Chunk
from links.simulated.link import SimulatedVehicle

SLICE = 8  # bytes
READ = 4096
SHORTEST_SLEEP, LONGEST_SLEEP = 0.0005, 0.2  # s, real


@dataclass(slots=True)
class _Out:
    """What is on its way to one pseudo-terminal: the board's own queue, written byte by byte.

    The queue is looked at anew each time, because an answer may still land in the head of it.
    """

    fd: int
    queue: deque[Chunk]
    slice: float = SLICE  # bytes that go out in one write
    sent: int = 0  # bytes of the first chunk

    @property
    def due(self) -> float:
        """When the next slice is through."""
        if not self.queue:
            return inf
        chunk = self.queue[0]
        return chunk.start + min(self.sent + self.slice, len(chunk.data)) * BYTE_TIME

    def write(self, now: float) -> None:
        while self.queue and self.due <= now:
            chunk = self.queue[0]
            through = min(int((now - chunk.start) / BYTE_TIME + 1e-6), len(chunk.data))
            piece = chunk.data[self.sent : through]
            self.sent = through
            if through == len(chunk.data):
                self.queue.popleft()
                self.sent = 0
            try:
                os.write(self.fd, piece)
            except BlockingIOError:
                continue  # nobody reads: a real line would lose it as well


class PtyVehicle:
    """Owns both pseudo-terminals; ``paths`` are for the other process."""

    def __init__(self, vehicle: SimulatedVehicle, speed: float = 1.0) -> None:
        if not speed > 0.0:
            raise ValueError(f"speed must be above 0, not {speed}")
        self.vehicle, self.speed = vehicle, speed
        self._fds = [*_open_pty(), *_open_pty()]  # master, slave of each
        piece = SLICE if speed <= 1.0 else inf
        self._outs = (
            _Out(self._fds[0], vehicle.stm32.tx.queue, piece),
            _Out(self._fds[2], vehicle.gps.queue, piece),
        )
        self.paths = (os.ttyname(self._fds[1]), os.ttyname(self._fds[3]))
        self._zero: float | None = None

    def __enter__(self) -> PtyVehicle:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        for fd in self._fds:
            os.close(fd)
        self._fds = []

    def run(self, until: float | None = None, stop: Callable[[], bool] | None = None) -> None:
        """Until this simulated time (None: for ever), or until ``stop`` says so."""
        if self._zero is None:
            self._zero = time.monotonic() - self.vehicle.now / self.speed
        while stop is None or not stop():
            now = self._now() if until is None else min(self._now(), until)
            self.step(now)
            if now == until:
                return
            self._wait(now)

    def step(self, now: float) -> None:
        """Everything that is due by the simulated time ``now``."""
        self.vehicle.advance(now)
        self._take_in(now)
        for out in self._outs:
            out.write(now)

    def _take_in(self, now: float) -> None:
        for master, listens in ((self._fds[0], True), (self._fds[2], False)):
            try:
                data = os.read(master, READ)
            except BlockingIOError:
                continue
            if data and listens:
                self.vehicle.stm32.receive(data, now)

    def _now(self) -> float:
        assert self._zero is not None
        return (time.monotonic() - self._zero) * self.speed

    def _wait(self, now: float) -> None:
        """Until the next slice, the next event, or a byte from the other side."""
        due = min(*(out.due for out in self._outs), self.vehicle.next_start())
        pause = min(max((due - now) / self.speed, SHORTEST_SLEEP), LONGEST_SLEEP)
        select.select([self._fds[0], self._fds[2]], [], [], pause)


def _open_pty() -> tuple[int, int]:
    """Raw, without echo; the slave stays open so that a reader may come and go."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    return master, slave


def run_on_ptys(
    vehicle: SimulatedVehicle,
    speed: float = 1.0,
    *,
    ready: Callable[[str, str], None],
    until: float | None = None,
    stop: Callable[[], bool] | None = None,
) -> None:
    """Open both pseudo-terminals, say their paths (STM32, GPS) to ``ready``, and run."""
    with PtyVehicle(vehicle, speed) as served:
        ready(*served.paths)
        served.run(until, stop)
