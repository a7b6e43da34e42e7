"""Two ends of a wire inside one process, in virtual time: ``memory://name``.

The first caller to open a name gets one end, the second the other; a third gets LinkBusy. Bytes
arrive in order, ``delay`` after they were sent. With ``baud`` bytes also take time on the wire (10
bits each), one after another; the bytes of one send arrive together with the last of them. What
does not live here: simulated vehicles (links.simulated).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from links import Address, LinkAddressError
from links.base import LinkBusy, LinkClosed, Rx


@dataclass(frozen=True, slots=True)
class _Piece:
    first: float
    there: float
    data: bytes


class MemoryLink:
    """One end. ``peer`` is the other one."""

    def __init__(self, name: str, *, delay: float = 0.0, baud: float | None = None) -> None:
        self.name = name
        self.peer: MemoryLink | None = None
        self._delay = delay
        self._byte_time = 10 / baud if baud else 0.0
        self._free = 0.0
        self.inbox: deque[_Piece] = deque()
        self._closed = False

    def fileno(self) -> int:
        return -1

    def receive(self, now: float) -> list[Rx]:
        self._check_open()
        out = []
        while self.inbox and self.inbox[0].there <= now:
            piece = self.inbox.popleft()
            out.append(Rx(piece.first, self.name, piece.data))
        if not out and not self.inbox and self.peer is not None and self.peer.closed:
            raise LinkClosed(f"{self.name}: the other end was closed")
        return out

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._check_open()
        peer = self.peer
        if peer is not None and peer.closed:
            raise LinkClosed(f"{self.name}: the other end was closed")
        start = max(now, self._free)
        self._free = start + len(data) * self._byte_time
        if peer is not None and data:
            peer.inbox.append(_Piece(start + self._delay, self._free + self._delay, bytes(data)))

    def next_event(self) -> float | None:
        return self.inbox[0].there if self.inbox else None

    def close(self) -> None:
        self._closed = True

    @property
    def closed(self) -> bool:
        return self._closed

    def _check_open(self) -> None:
        if self._closed:
            raise LinkClosed(f"{self.name}: the link was closed")


def memory_pair(
    name: str, other: str, *, delay: float = 0.0, baud: float | None = None
) -> tuple[MemoryLink, MemoryLink]:
    """Two connected ends. ``name`` and ``other`` are the names that the two sides use."""
    one = MemoryLink(name, delay=delay, baud=baud)
    two = MemoryLink(other, delay=delay, baud=baud)
    one.peer, two.peer = two, one
    return one, two


class Exchange:
    """The named wires of a process. The second caller to open a name is connected to the first."""

    def __init__(self) -> None:
        self._wires: dict[str, list[MemoryLink]] = {}

    def open(
        self, wire: str, name: str, *, delay: float = 0.0, baud: float | None = None
    ) -> MemoryLink:
        """Open an end. Raises LinkBusy if both ends are open."""
        ends = self._wires.get(wire, [])
        if any(end.closed for end in ends):
            ends = []
        if len(ends) == 2:
            raise LinkBusy(f"{name}: both ends of memory://{wire} are in use")
        link = MemoryLink(name, delay=delay, baud=baud)
        if ends:
            link.peer, ends[0].peer = ends[0], link
        self._wires[wire] = [*ends, link]
        return link


EXCHANGE = Exchange()


def settings(address: Address) -> tuple[str, float, float | None]:
    """Wire, delay in s, bits per s. Raises LinkAddressError."""
    wire = address.host + address.path
    if not wire:
        raise LinkAddressError(f"{address.url}: give the wire a name, e.g. memory://topside")
    baud = address.number("baud", 0.0, 0.0, 1e9)
    return wire, address.number("delay", 0.0, 0.0, 1e6), baud or None


def open_url(name: str, address: Address) -> MemoryLink:
    wire, delay, baud = settings(address)
    return EXCHANGE.open(wire, name, delay=delay, baud=baud)
