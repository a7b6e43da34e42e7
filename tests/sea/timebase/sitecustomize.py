"""The other end of `tests.sea.clock`, inside the program under test.

Python imports `sitecustomize` before anything else (module `site`). Where SEA_CLOCK names the
folder of a sea, the clocks and the waits of this process become the sea's: `time.monotonic`,
`time.time`, `time.sleep`, `select.select` and `selectors.EpollSelector.select`; `os.write` and
`os.read` count what passes serial ports. Nothing else of the program is touched, and none of its
modules is named here.

SEA_BOOT says at which of the sea's times the Pi was switched on: `time.monotonic` counts from there.
The second number of the sea's file moves `time.time` alone: a wall clock that was set, or lost its date.

SEA_WITHOUT names a module whose import shall fail, as on a card with a broken file.
SEA_READ_ONLY names a folder in which nothing can be changed, as on a medium that was remounted so.

A wait tells the sea "at this time nothing is left to do, wake me at that time", and then really waits:
for a file descriptor, or for the sea's tick. So the sea's time stands still while the program works,
and no result depends on the speed of the machine.
"""

from __future__ import annotations

import errno
import mmap
import os
import select
import selectors
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

REPORT = struct.Struct("<ddQQ")  # times of the last look and the next deadline (s), bytes out, in
FOREVER = float("inf")
written = 0  # bytes that this process has written to serial ports
taken = 0  # and read from them


class Waiter:
    """One thread's line to the sea; made at the thread's first wait."""

    def __init__(self, folder: Path, now: Callable[[], float]) -> None:
        self.now = now
        self.line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.line.connect(str(folder / "waits"))
        self.line.setblocking(False)
        self.asked = True

    def wait(self, deadline: float, reads: Iterable[Any], writes: Iterable[Any], ready: Any) -> Any:
        """What `ready` returns once it is true, or whatever it returns at the deadline."""
        poll = select.poll()
        for file in writes:
            poll.register(file, select.POLLOUT)
        for file in (self.line, *reads):
            poll.register(file, select.POLLIN)
        self.asked = True
        while True:
            seen = self.now()
            events = ready()
            if seen >= deadline or (any(events) if isinstance(events, tuple) else events):
                return events
            if self.asked:
                self.asked = False
                self.line.setblocking(True)
                self.line.sendall(REPORT.pack(seen, deadline, written, taken))
                self.line.setblocking(False)
            poll.poll()
            self._ticks()

    def _ticks(self) -> None:
        try:
            ticks = self.line.recv(4096)
        except BlockingIOError:
            return
        if not ticks:  # the sea is gone, and with it all time
            os._exit(97)
        self.asked = True


def install(folder: Path) -> None:
    """Replace clocks and waits."""
    with (folder / "now").open("rb") as file:
        memory = memoryview(mmap.mmap(file.fileno(), 16, access=mmap.ACCESS_READ)).cast("d")
    own = threading.local()
    really = selectors.EpollSelector.select
    start = time.time()
    boot = float(os.environ.get("SEA_BOOT", "0"))
    really_write, really_read, really_some = os.write, os.read, select.select

    def now() -> float:
        return float(memory[0])

    def waiter() -> Waiter:
        if not hasattr(own, "waiter"):
            own.waiter = Waiter(folder, now)
        return own.waiter  # type: ignore[no-any-return]

    def sleep(seconds: float) -> None:
        waiter().wait(now() + seconds, (), (), lambda: None)

    def choose(self: selectors.EpollSelector, timeout: float | None = None) -> Any:
        if timeout is not None and timeout <= 0:
            return really(self, 0)
        deadline = FOREVER if timeout is None else now() + timeout
        return waiter().wait(deadline, (self.fileno(),), (), lambda: really(self, 0))

    def some(reads: Any, writes: Any, odd: Any, timeout: float | None = None) -> Any:
        deadline = FOREVER if timeout is None else now() + timeout
        return waiter().wait(deadline, reads, writes, lambda: really_some(reads, writes, odd, 0))

    def write(fd: int, data: Any) -> int:
        global written
        count = really_write(fd, data)
        if os.isatty(fd):
            written += count
        return count

    def read(fd: int, count: int) -> bytes:
        global taken
        data = really_read(fd, count)
        if os.isatty(fd):
            taken += len(data)
        return data

    os.write, os.read = write, read
    time.monotonic = lambda: now() - boot
    time.monotonic_ns = lambda: int((now() - boot) * 1e9)
    time.time = lambda: start + now() + memory[1]
    time.time_ns = lambda: int((start + now() + memory[1]) * 1e9)
    time.sleep = sleep  # type: ignore[assignment]
    select.select = some
    selectors.EpollSelector.select = choose  # type: ignore[method-assign,assignment]


def freeze(folder: str) -> None:
    """Nothing in this folder can be written, made, renamed or removed (PEP 578; EROFS)."""
    change = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
    acts = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate", "os.link", "os.chmod"}

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        opens = event == "open" and isinstance(arguments[2], int) and arguments[2] & change
        if not (opens or event in acts):
            return
        paths = [str(path) for path in arguments[:2] if isinstance(path, (str, os.PathLike))]
        if any(path.startswith(folder) and not Path(path).is_char_device() for path in paths):
            raise OSError(errno.EROFS, os.strerror(errno.EROFS), paths[0])

    sys.addaudithook(watch)


if "SEA_CLOCK" in os.environ and "serve" in sys.orig_argv:
    install(Path(os.environ["SEA_CLOCK"]))
    if os.environ.get("SEA_WITHOUT"):
        sys.modules[os.environ["SEA_WITHOUT"]] = None  # type: ignore[assignment]
    if os.environ.get("SEA_READ_ONLY"):
        freeze(os.environ["SEA_READ_ONLY"])
