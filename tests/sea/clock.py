"""Time of the sea: it advances when the program under test has nothing left to do.

The program's waits (see `timebase/sitecustomize.py`) report here. `advance` moves the time on, `wake` wakes
those whose deadline has come, or all when bytes were written to the program; `settle` returns when
each has answered and, where an answer is due that a thread may have to work out (an upload), no
thread of the process runs. A slow machine makes the flight last longer and
changes nothing else.
"""

from __future__ import annotations

import contextlib
import math
import mmap
import os
import select
import socket
import struct
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

REPORT = struct.Struct("<ddQQ")
PATIENCE = 1800.0  # real seconds that one tick may take before the program counts as hung


class Hung(Exception):
    """The program did not come back from one tick."""


class Waiter:
    """One waiting thread of the program."""

    def __init__(self, line: socket.socket) -> None:
        self.line = line
        self.deadline = -1.0
        self.owes = True  # each thread reports when it begins to wait, unasked
        self.rest = b""
        self.written = 0
        self.taken = 0

    def ask(self) -> None:
        """Have it look at the clock and at its files."""
        if not self.owes:
            self.owes = True
            self.line.send(b"t")

    def read(self, now: float) -> bool:
        """Take its reports (struct REPORT); False when it is gone."""
        try:
            block = self.line.recv(4096)
        except BlockingIOError:
            return True
        except ConnectionError:
            return False
        self.rest += block
        while len(self.rest) >= REPORT.size:
            seen, self.deadline, self.written, self.taken = REPORT.unpack(self.rest[: REPORT.size])
            self.rest = self.rest[REPORT.size :]
            if self.owes and seen < now:  # it looked before the tick: again
                self.line.send(b"t")
            else:
                self.owes = False
        return bool(block)


class Clock:
    """Seconds since the sea began, shared with the program through a file."""

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="sea-"))
        self.now = 1000.0
        self.strict_until = (
            self.now
        )  # s: until then other threads of the program are waited for, too
        with (self.folder / "now").open("w+b") as file:
            file.write(bytes(16))
            file.flush()
            # 8 aligned bytes in one store: no reader sees half of a time
            self._memory = memoryview(mmap.mmap(file.fileno(), 16)).cast("d")
        self._publish()
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.bind(str(self.folder / "waits"))
        self._listener.listen(64)
        self._listener.setblocking(False)
        self._poll = select.poll()
        self._poll.register(self._listener, select.POLLIN)
        self._waiters: dict[int, Waiter] = {}

    def environment(self) -> dict[str, str]:
        """What the program's environment needs."""
        return {
            "SEA_CLOCK": str(self.folder),
            "PYTHONPATH": str(Path(__file__).parent / "timebase"),
        }

    def _publish(self) -> None:
        self._memory[0] = self.now

    def set_wall(self, shift: float) -> None:
        """Move the program's wall clock `shift` s from the true time, from now on."""
        self._memory[1] = shift

    def begin(self, pid: int, alive: Callable[[], bool]) -> bool:
        """Wait until a new process waits for the first time; False if it ended before that."""
        self._forget()
        until = time.monotonic() + PATIENCE
        while not self._waiters or any(waiter.owes for waiter in self._waiters.values()):
            self._take(0.02)
            if not alive():
                return False
            if time.monotonic() > until:
                raise Hung("the program never began to wait")
        self.strict_until = max(self.strict_until, self.now + 3.0)
        self.settle(pid, alive)
        return True

    def _forget(self) -> None:
        for fd, waiter in list(self._waiters.items()):
            self._drop(fd, waiter)

    def _drop(self, fd: int, waiter: Waiter) -> None:
        self._poll.unregister(fd)
        waiter.line.close()
        self._waiters.pop(fd, None)

    def _take(self, wait: float) -> None:
        for fd, _ in self._poll.poll(wait * 1000):
            if fd == self._listener.fileno():
                with contextlib.suppress(BlockingIOError):
                    line, _ = self._listener.accept()
                    line.setblocking(False)
                    self._waiters[line.fileno()] = Waiter(line)
                    self._poll.register(line, select.POLLIN)
            elif fd in self._waiters and not self._waiters[fd].read(self.now):
                self._drop(fd, self._waiters[fd])

    def advance(self, dt: float) -> None:
        """Move the time on by dt seconds; nobody is woken."""
        self.now = round(self.now + dt, 6)
        self._publish()

    def wake(self, wrote: bool, pid: int, alive: Callable[[], bool]) -> None:
        """Wake whose deadline has come, and all if bytes were written; until they wait again."""
        woken = False
        for waiter in self._waiters.values():
            if wrote or waiter.deadline <= self.now or waiter.owes:
                woken = True
                with contextlib.suppress(OSError):
                    waiter.ask()
        if woken:
            self.settle(pid, alive)

    def settle(self, pid: int, alive: Callable[[], bool]) -> None:
        """Until every wait is a true one and no thread of the process is at work."""
        until = time.monotonic() + PATIENCE
        while alive():
            self._take(0)
            if any(waiter.owes for waiter in self._waiters.values()):
                self._take(0.05)
            elif self.now > self.strict_until or not busy(pid):
                return
            else:
                os.sched_yield()
            if time.monotonic() > until:
                raise Hung(f"the program works for more than {PATIENCE:.0f} s at one instant")

    def taken(self) -> float:
        """Bytes that the program has read from serial ports since it began."""
        self._take(0)
        return max((waiter.taken for waiter in self._waiters.values()), default=0)

    def written(self) -> int:
        """Bytes that the program has written to serial ports since it began."""
        return max((waiter.written for waiter in self._waiters.values()), default=0)

    def close(self) -> None:
        """Give everything back."""
        self._forget()
        self._listener.close()
        for name in ("now", "waits"):
            (self.folder / name).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.folder.rmdir()


class WallClock(Clock):
    """The machine's own time, and a program whose clocks nobody touches: the check on all this."""

    def __init__(self) -> None:
        super().__init__()
        self._began = time.monotonic() - self.now

    def environment(self) -> dict[str, str]:
        """Nothing."""
        return {}

    def begin(self, pid: int, alive: Callable[[], bool]) -> bool:
        """A start takes its time."""
        return alive()

    def advance(self, dt: float) -> None:
        """Sleep until then."""
        super().advance(dt)
        time.sleep(max(0.0, self._began + self.now - time.monotonic()))

    def wake(self, wrote: bool, pid: int, alive: Callable[[], bool]) -> None:
        """It wakes by itself."""

    def taken(self) -> float:
        """Unknown: nobody waits for it."""
        return math.inf


def busy(pid: int) -> bool:
    """Whether a thread of the process runs or waits for a disk (proc(5), field 3 of stat)."""
    for path in Path(f"/proc/{pid}/task").glob("*/stat"):
        with contextlib.suppress(OSError):
            if path.read_text().rpartition(")")[2].split()[0] in "RD":
                return True
    return False
