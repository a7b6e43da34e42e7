"""The notify protocol of systemd: READY=1, STOPPING=1, and WATCHDOG=1 after steps of the runtime.

Each is a datagram to the socket in NOTIFY_SOCKET; without that variable nothing is sent. The caller
gives the times. What does not live here: the unit file (deploy).
"""

from __future__ import annotations

import contextlib
import os
import socket


class Watchdog:
    """Notifies systemd: READY, and WATCHDOG after steps of the runtime. Does nothing without
    NOTIFY_SOCKET."""

    def __init__(self) -> None:
        self._address = os.environ.get("NOTIFY_SOCKET", "")
        period = os.environ.get("WATCHDOG_USEC", "") if self._address else ""
        self._every = int(period) / 3e6 if period.isdigit() and int(period) else float("inf")
        self._last, self._owed = float("-inf"), False

    def ready(self) -> None:
        """Send READY; repeat it with each step of the runtime until it is received."""
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
        """Seconds until the runtime must have made a step, inf without a watchdog."""
        if self._every == float("inf"):
            return self._every
        return max(0.0, self._last + self._every - monotonic)

    def _notify(self, state: bytes) -> bool:
        """Send a state; whether it was received."""
        if not self._address:
            return True
        address = "\0" + self._address[1:] if self._address[0] == "@" else self._address
        with (
            contextlib.suppress(OSError),
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as out,
        ):
            out.setblocking(False)  # the reader may have died
            out.sendto(state, address)
            return True
        return False
