"""Waiting for what the operating system does in its own time: sockets, pseudo-terminals."""

from __future__ import annotations

import time
from collections.abc import Callable

LONG = 30.0  # s; not a law about time: only how long a busy machine is waited for


def until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + LONG
    while not holds():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.002)
