"""Print lines to a descriptor in a thread: the caller never waits, and nothing raises.

    print(line) --queue, at most WAITING--> thread --os.write--> terminal, pipe, system's journal

A terminal over a lost radio link blocks without an error, and a pipe whose reader died raises:
neither may delay a command to the vehicle. Lines that find no room are lost and counted; the count
is printed once a line gets through again.

What does not live here: the lines (journal).
"""

from __future__ import annotations

import os
import queue
import select
import threading

WAITING = 2000  # lines
PATIENCE_S = 1.0  # s that the end of the program waits for the last lines


class Printer:
    def __init__(self, descriptor: int, waiting: int = WAITING) -> None:
        self._descriptor = descriptor
        self.lines: queue.Queue[str | None] = queue.Queue(waiting)
        self._lost = 0
        self.thread = threading.Thread(target=self._run, name="printer", daemon=True)
        self.thread.start()

    def print(self, line: str) -> None:
        try:
            self.lines.put_nowait(line)
        except queue.Full:
            self._lost += 1

    def close(self) -> None:
        """Print what waits, if the descriptor takes it in time."""
        try:
            self.lines.put(None, timeout=PATIENCE_S)
        except queue.Full:
            return
        self.thread.join(PATIENCE_S)

    def _run(self) -> None:
        while (line := self.lines.get()) is not None:
            lost, self._lost = self._lost, 0
            if lost:
                line = f"{lost} lines were lost here\n{line}"
            try:
                self._write(line.encode("utf-8", "replace") + b"\n")
            except OSError:
                self._lost += lost + 1

    def _write(self, data: bytes) -> None:
        while data:
            try:
                data = data[os.write(self._descriptor, data) :]
            except BlockingIOError:  # somebody else made the terminal non-blocking
                select.select([], [self._descriptor], [])
