"""The Link protocol: the interface of everything that moves bytes.

LinkError                 (the operator or the hardware must act)
+-- LinkBusy              another program has the port
+-- LinkAbsent            the port or host is not there (now)
+-- LinkClosed            the link was open and is gone
"""

from __future__ import annotations

from typing import NamedTuple, Protocol


class LinkError(OSError):
    """Something outside the program must be repaired; the message says what."""


class LinkBusy(LinkError):
    pass


class LinkAbsent(LinkError):
    pass


class LinkClosed(LinkError):
    pass


class Rx(NamedTuple):
    """Bytes that arrived: ``t`` is the engine's time of the first of them."""

    t: float
    link: str  # its name in the configuration: vehicle, gps, topside, modem
    data: bytes
    address: str = ""  # the peer, if the link has several ("127.0.0.1:50214")


class Link(Protocol):
    """Non-blocking bytes in and out.

    An event loop watches ``fileno`` (-1: nothing to watch, ask ``next_event``).
    """

    name: str

    def fileno(self) -> int: ...

    def receive(self, now: float) -> list[Rx]:
        """Return all that has arrived by ``now``. Raises LinkClosed when the peer is gone."""
        ...

    def send(self, data: bytes, now: float, address: str = "") -> None:
        """Queue or write ``data``. Raises LinkClosed when the peer is gone."""
        ...

    def next_event(self) -> float | None:
        """When the next bytes will arrive, if this is known (memory and simulated links)."""
        ...

    def close(self) -> None: ...
