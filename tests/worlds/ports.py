"""Ports for programs that tests start a moment later."""

from __future__ import annotations

import random
import socket
from contextlib import suppress


def free_port() -> int:
    """A port on which nobody listens, below those that the system hands to clients.

    One of the system's own choice may belong to another test's client a moment later."""
    while True:
        port = random.SystemRandom().randrange(10_000, 32_000)
        with suppress(OSError), socket.create_server(("127.0.0.1", port)):
            return port
