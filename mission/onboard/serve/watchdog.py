"""systemd's protocol: READY=1, STOPPING=1, and WATCHDOG=1 fed by the steps of the runtime.

A datagram to the socket that NOTIFY_SOCKET names; without it, everything here is mute. Times are
given by who calls. What does not live here: the unit file (docs).
"""

from __future__ import annotations

import contextlib
import os
import socket


class Watchdog:
    """Speaks to systemd: READY, and WATCHDOG after steps of the runtime. Does nothing without
    NOTIFY_SOCKET."""

    def __init__(self) -> None:
        self._address = os.environ.get("NOTIFY_SOCKET", "")
        period = os.environ.get("WATCHDOG_USEC", "") if self._address else ""
        self._every = int(period) / 3e6 if period.isdigit() and int(period) else float("inf")
        self._last, self._owed = float("-inf"), False

    def ready(self) -> None:
        """Said again with each step of the runtime, until somebody takes it."""
        self._owed = not self._notify(b"READY=1")

    def stopping(self) -> None:
        self._notify(b"STOPPING=1")

    def fed(self, monotonic: float) -> None:
        if self._owed:
            self.ready()
        if monotonic - self._last >= self._every / 2:
            self._last = monotonic
            self._notify(b"WATCHDOG=1")

    def remaining(self, monotonic: float) -> float:
        """s until the runtime must have made a step, inf without a watchdog."""
        if self._every == float("inf"):
            return self._every
        return max(0.0, self._last + self._every - monotonic)

    def _notify(self, state: bytes) -> bool:
        """Whether it was taken."""
        if not self._address:
            return True
        address = "\0" + self._address[1:] if self._address[0] == "@" else self._address
        with (
            contextlib.suppress(OSError),
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as out,
        ):
            out.setblocking(False)  # who does not read it may have died
            out.sendto(state, address)
            return True
        return False
