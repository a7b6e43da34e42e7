"""Who may connect: addresses, connections in total and from one address, and how often.

    allow=192.168.1.0/24,10.0.0.5   only these addresses; default: everybody who reaches the port
    connections=32  each=8          at the same time: in total, from one address
    idle=600                        s without a byte, then a connection is dropped
    handshake=5                     s that a peer has to show its certificate
    viewers=yes                     admit viewers too (a role in the certificate)
    (fixed)                         50 new connections at once from one address, then 10 a second;
                                    with TLS no limit on these, but 256 handshakes at a time

When no place is free, the connection that has been silent longest is dropped, if it has been silent
for ``GIVES_WAY`` seconds: an idle connection never keeps an operator out. A peer that has not
proved itself (no certificate, no valid frame) can be dropped ``PROVES`` seconds after it came, no
matter how many bytes it sends.

With TLS a peer first waits in the lobby, until it has shown a certificate. ``each`` does not count
there: an address may have 50 handshakes that never end, and the boat. If the lobby is full, the
oldest handshake from the address with the most handshakes is dropped at once. ``connections`` and
``each`` count peers that have shown a certificate.

Sans-IO: the caller gives the times. What does not live here: sockets (tcp), certificates (tls),
who commands (mission).
"""

from __future__ import annotations

import ipaddress
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from links import Address, LinkAddressError

GIVES_WAY = 10.0  # s
PROVES = 1.0  # s
AT_ONCE, PER_SECOND = 50.0, 10.0  # new connections from one address
HANDSHAKE = 5.0  # s
LOBBY = 256  # handshakes at a time: at 500 a second, 0.5 s for an answer by a slow radio
_REMEMBERED = 1024  # addresses; with more, addresses without new connections are forgotten

Network = ipaddress.IPv4Network | ipaddress.IPv6Network


@dataclass(frozen=True, slots=True)
class Admission:
    allow: tuple[Network, ...] = ()
    connections: int = 32
    each: int = 8
    idle: float = 600.0  # s
    handshake: float = HANDSHAKE  # s that a peer has to prove who it is
    viewers: bool = False  # viewers' certificates are admitted too


@dataclass(frozen=True, slots=True)
class Refusal:
    """A connection that was not admitted, or dropped."""

    host: str
    why: str


@dataclass(frozen=True, slots=True)
class Present:
    """A connected peer, as admission sees it. ``heard``: when its last byte came; until it has
    ``proved`` itself, when it connected."""

    address: str
    host: str
    heard: float
    proved: bool = True

    @property
    def gives_way(self) -> float:
        """The time from which on it may be dropped for another, s."""
        return self.heard + (GIVES_WAY if self.proved else PROVES)


@dataclass(slots=True)
class Allowance:
    """A token bucket with ``left`` tokens at time ``t``."""

    left: float
    t: float

    def take(self, now: float, amount: float, at_once: float, per_second: float) -> bool:
        self.left = min(at_once, self.left + max(0.0, now - self.t) * per_second)
        self.t = now
        if self.left < amount:
            return False
        self.left -= amount
        return True


class Gate:
    def __init__(self, admission: Admission) -> None:
        self._admission = admission
        self.arrivals: dict[str, Allowance] = {}

    def forbids(self, host: str) -> str:
        """Why ``host`` may never connect; "" if it may."""
        allow = self._admission.allow
        if allow and not any(_plain(host) in network for network in allow):
            return "its address is not among those allowed"
        return ""

    def hurries(self, host: str, now: float) -> str:
        """Why ``host`` may not connect now; "" if it may, provided that a place is free."""
        if len(self.arrivals) > _REMEMBERED:
            self.arrivals = {h: a for h, a in self.arrivals.items() if now - a.t < 2.0}
        arrivals = self.arrivals.setdefault(host, Allowance(AT_ONCE, now))
        if not arrivals.take(now, 1.0, AT_ONCE, PER_SECOND):
            return f"more than {PER_SECOND:g} connections a second from there"
        return ""

    def room(self, host: str, present: Sequence[Present], now: float) -> tuple[str, str]:
        """Return the peer to drop ("": none), and why no place is free ("": one is)."""
        admission = self._admission
        neighbours = [one for one in present if one.host == host]
        if len(neighbours) >= admission.each:
            full, crowd = f"{admission.each} connections from there already", neighbours
        elif len(present) >= admission.connections:
            full, crowd = f"{admission.connections} connections already", list(present)
        else:
            return "", ""
        first = min(crowd, key=lambda one: one.gives_way, default=None)
        if first is None or now < first.gives_way:
            return "", full
        return first.address, ""

    def lobby(self, waiting: Sequence[Present]) -> str:
        """The peer to drop from the lobby for one more handshake; "": none."""
        if len(waiting) < LOBBY:
            return ""
        crowd = Counter(one.host for one in waiting)
        return min(waiting, key=lambda one: (-crowd[one.host], one.heard)).address


def _plain(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """The address; an IPv4 address that came over IPv6 as an IPv4 address."""
    address = ipaddress.ip_address(host.partition("%")[0])
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        return address.ipv4_mapped
    return address


def admission_of(address: Address) -> Admission:
    """The admission options of a URL. Raises LinkAddressError."""
    networks = []
    for text in filter(None, address.options.get("allow", "").split(",")):
        try:
            networks.append(ipaddress.ip_network(text.strip(), strict=False))
        except ValueError:
            raise LinkAddressError(
                f"{address.url}: allow: {text!r} is neither an address nor a network; "
                "write e.g. allow=192.168.1.0/24,10.0.0.5"
            ) from None
    usual = Admission()
    return Admission(
        tuple(networks),
        int(address.number("connections", usual.connections, 1, 1000)),
        int(address.number("each", usual.each, 1, 1000)),
        address.number("idle", usual.idle, 1.0, 1e6),
        address.number("handshake", usual.handshake, 1.0, 120.0),
        address.options.get("viewers") == "yes",
    )
