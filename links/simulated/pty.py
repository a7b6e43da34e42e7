"""A simulated vehicle in real time, or a multiple of it, behind pseudo-terminals.

    SimulatedVehicle --9600 8N1 pace----> pty --> serial:///dev/pts/N  (STM32)
                                          pty --> serial:///dev/pts/M  (GPS)
    SimulatedBoard   --115200 8N1 pace--> pty --> serial:///dev/pts/N  (core board, ROV, robot)

With ``speed`` 8 everything, bytes included, is eight times as fast. Bytes are written in slices
(``SLICE_S``), each at the time at which the real line would deliver it; the loop sleeps in between.
Faster than real time a chunk is written whole, when its last byte is due. Otherwise scheduling
delays could exceed the 50 ms after which a decoder gives up an unfinished frame (G3). Bytes from
the other side get the time at which they are read here. They then take their time on the simulated
line.

What does not live here: the vehicles themselves (link.py, boards.py).
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

from links.simulated import boards
from links.simulated.boards import SimulatedBoard
from links.simulated.firmware import uart
from links.simulated.firmware.uart import Chunk
from links.simulated.link import SimulatedVehicle

SLICE_S = 0.008  # s of line time in one write
READ = 4096
SHORTEST_SLEEP, LONGEST_SLEEP = 0.0005, 0.2  # s, real


Simulated = SimulatedVehicle | SimulatedBoard


@dataclass(frozen=True, slots=True)
class Wire:
    """One line of a vehicle. ``hear`` takes the bytes that come in; None: they are dropped."""

    name: str
    queue: deque[Chunk]
    byte_time: float  # s
    hear: Callable[[bytes, float], None] | None


def wires(vehicle: Simulated) -> tuple[Wire, ...]:
    """The lines of the board, of GPS receivers and of added sensors, as far as fitted."""
    if isinstance(vehicle, SimulatedBoard):
        return (Wire("vehicle", vehicle.queue, boards.BYTE_TIME, vehicle.vehicle_link.send),)
    said = {"gps": vehicle.gps, "sensors": vehicle.added, "gps2": vehicle.second_gps}
    return (
        Wire("vehicle", vehicle.stm32.tx.queue, uart.BYTE_TIME, vehicle.vehicle_link.send),
        *(Wire(n, one.queue, uart.BYTE_TIME, None) for n, one in said.items() if one is not None),
    )


def ports(vehicle: Simulated) -> tuple[str, ...]:
    """The names of its lines, in the order of the paths."""
    return tuple(wire.name for wire in wires(vehicle))


@dataclass(slots=True)
class _Out:
    """Output to one pseudo-terminal: the board's own queue, written slice by slice.

    The queue is read again each time, because an answer may still be spliced into its first chunk.
    """

    fd: int
    queue: deque[Chunk]
    byte_time: float
    slice: float  # bytes that go out in one write
    sent: int = 0  # bytes of the first chunk

    @property
    def due(self) -> float:
        """When the next slice is due."""
        if not self.queue:
            return inf
        chunk = self.queue[0]
        return chunk.start + min(self.sent + self.slice, len(chunk.data)) * self.byte_time

    def write(self, now: float) -> None:
        while self.queue and self.due <= now:
            chunk = self.queue[0]
            through = min(int((now - chunk.start) / self.byte_time + 1e-6), len(chunk.data))
            piece = chunk.data[self.sent : through]
            self.sent = through
            if through == len(chunk.data):
                self.queue.popleft()
                self.sent = 0
            try:
                os.write(self.fd, piece)
            except BlockingIOError:
                continue  # nobody reads: a real line would lose it too


class PtyVehicle:
    """A vehicle behind pseudo-terminals, which it owns. ``paths`` are for the other process."""

    def __init__(self, vehicle: Simulated, speed: float = 1.0) -> None:
        if not speed > 0.0:
            raise ValueError(f"speed must be above 0, not {speed}")
        self.vehicle, self.speed = vehicle, speed
        self._wires = wires(vehicle)
        ends = [open_pty() for _ in self._wires]  # master, slave of each
        self._fds = [fd for pair in ends for fd in pair]
        self._masters = [master for master, _ in ends]
        self._outs = tuple(
            _Out(master, wire.queue, wire.byte_time, _slice(wire, speed))
            for master, wire in zip(self._masters, self._wires, strict=True)
        )
        self.paths = tuple(os.ttyname(slave) for _, slave in ends)
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
        """Run until this simulated time (None: no end), or until ``stop`` returns True."""
        if self._zero is None:
            self._zero = time.monotonic() - self.vehicle.now / self.speed
        while stop is None or not stop():
            now = self._now() if until is None else min(self._now(), until)
            self.step(now)
            if now == until:
                return
            self._wait(now)

    def step(self, now: float) -> None:
        """Do everything that is due by the simulated time ``now``."""
        self.vehicle.advance(now)
        self._take_in(now)
        for out in self._outs:
            out.write(now)

    def _take_in(self, now: float) -> None:
        for master, wire in zip(self._masters, self._wires, strict=True):
            try:
                data = os.read(master, READ)
            except BlockingIOError:
                continue
            if data and wire.hear is not None:
                wire.hear(data, now)

    def _now(self) -> float:
        assert self._zero is not None
        return (time.monotonic() - self._zero) * self.speed

    def _wait(self, now: float) -> None:
        """Wait for the next slice, the next event, or a byte from the other side."""
        due = min(*(out.due for out in self._outs), _next_start(self.vehicle))
        pause = min(max((due - now) / self.speed, SHORTEST_SLEEP), LONGEST_SLEEP)
        select.select(self._masters, [], [], pause)


def _slice(wire: Wire, speed: float) -> float:
    return max(1, round(SLICE_S / wire.byte_time)) if speed <= 1.0 else inf


def _next_start(vehicle: Simulated) -> float:
    if isinstance(vehicle, SimulatedBoard):
        return vehicle.next_report
    return vehicle.next_start()


def open_pty() -> tuple[int, int]:
    """Open a raw pty without echo. The slave stays open, so that a reader may come and go."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    return master, slave


def run_on_ptys(
    vehicle: Simulated,
    speed: float = 1.0,
    *,
    ready: Callable[..., None],
    until: float | None = None,
    stop: Callable[[], bool] | None = None,
) -> None:
    """Open the pseudo-terminals, pass their paths (in the order of ``ports``) to ``ready``, run."""
    with PtyVehicle(vehicle, speed) as served:
        ready(*served.paths)
        served.run(until, stop)
