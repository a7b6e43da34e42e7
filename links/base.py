"""The Link protocol: what the runtime asks of anything that moves bytes.

LinkError                 (the operator or the hardware must act)
+-- LinkBusy              somebody else has the port
+-- LinkAbsent            the port or host is not there (now)
+-- LinkClosed            it was there and went away
"""

from __future__ import annotations

from typing import NamedTuple, Protocol


class LinkError(OSError):
    """Something outside the program must be mended; the message says what."""


class LinkBusy(LinkError):
    pass


class LinkAbsent(LinkError):
    pass


class LinkClosed(LinkError):
    pass


class Rx(NamedTuple):
    """Bytes that arrived: ``t`` is the engine's time of the first of them."""

    t: float
    link: str  # the name it has in the configuration: vehicle, gps, topside, modem
    data: bytes
    address: str = ""  # which peer, where a link has several ("127.0.0.1:50214")


class Link(Protocol):
    """Non-blocking bytes in and out.

    ``fileno`` is what an event loop watches (-1: nothing to watch, ask ``next_event``).
    """

    name: str

    def fileno(self) -> int: ...

    def receive(self, now: float) -> list[Rx]:
        """All that has arrived by ``now``; raises LinkClosed when the peer is gone."""
        ...

    def send(self, data: bytes, now: float, address: str = "") -> None:
        """Queue or write; raises LinkClosed when the peer is gone."""
        ...

    def next_event(self) -> float | None:
        """When bytes will be there that can be foretold (memory and simulated links), or None."""
        ...

    def close(self) -> None: ...
