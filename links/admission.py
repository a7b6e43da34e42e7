"""Who may connect: addresses, connections in total and from one address, and how often.

    allow=192.168.1.0/24,10.0.0.5   nobody else; not given: everybody who can reach the port
    connections=32  each=8          at once: in total, from one address
    idle=600                        s without a byte, then a connection is dropped
    handshake=5                     s that a peer has to show its certificate
    viewers=yes                     who may only look is let in, too (a role of its certificate)
    (fixed)                         50 connections at once from one address, then 10 a second;
                                    with TLS as many as come, and 256 handshakes at a time

Where there is no room, the connection that has been silent longest gives way, if it has been
silent for ``GIVES_WAY`` seconds: who only holds a place never keeps an operator out. Who has said
nothing so far that makes sense, however many bytes, gives way after ``PROVES`` seconds.

Who has still to show a certificate waits in a lobby of its own, whatever comes from the same
address: that may be half a hundred handshakes that never end, and the boat. Where the lobby is
full the first to come gives way at once, of those from the address that fills it. Rate and places
by address count for who has shown one.

Sans-IO: times are given by who calls. What does not live here: sockets (tcp), certificates (tls),
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
LOBBY = 256  # handshakes at a time: half a second of 500 a second, for an answer by a slow radio
_REMEMBERED = 1024  # addresses; beyond, those that have been quiet are forgotten

Network = ipaddress.IPv4Network | ipaddress.IPv6Network


@dataclass(frozen=True, slots=True)
class Admission:
    allow: tuple[Network, ...] = ()
    connections: int = 32
    each: int = 8
    idle: float = 600.0  # s
    handshake: float = HANDSHAKE  # s that a peer has to prove who it is
    viewers: bool = False  # certificates of viewers are let in, too


@dataclass(frozen=True, slots=True)
class Refusal:
    """A connection that was not admitted, or dropped."""

    host: str
    why: str


@dataclass(frozen=True, slots=True)
class Present:
    """One of those who are connected, as admission sees it. ``heard``: when its last byte came;
    of who has ``proved`` nothing yet, when it came itself."""

    address: str
    host: str
    heard: float
    proved: bool = True

    @property
    def gives_way(self) -> float:
        """From when on."""
        return self.heard + (GIVES_WAY if self.proved else PROVES)


@dataclass(slots=True)
class Allowance:
    """``left`` of so many at once, refilled so many a second."""

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
        """Why nobody from there may ever connect; "" if he may."""
        allow = self._admission.allow
        if allow and not any(_plain(host) in network for network in allow):
            return "its address is not among those allowed"
        return ""

    def hurries(self, host: str, now: float) -> str:
        """Why nobody from there may connect now; "" if he may, where there is room."""
        if len(self.arrivals) > _REMEMBERED:
            self.arrivals = {h: a for h, a in self.arrivals.items() if now - a.t < 2.0}
        arrivals = self.arrivals.setdefault(host, Allowance(AT_ONCE, now))
        if not arrivals.take(now, 1.0, AT_ONCE, PER_SECOND):
            return f"more than {PER_SECOND:g} connections a second from there"
        return ""

    def room(self, host: str, present: Sequence[Present], now: float) -> tuple[str, str]:
        """Who gives way ("": nobody need), and why there is no room ("": there is)."""
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
        """Who of those without a certificate so far gives way to one more; "": nobody need."""
        if len(waiting) < LOBBY:
            return ""
        crowd = Counter(one.host for one in waiting)
        return min(waiting, key=lambda one: (-crowd[one.host], one.heard)).address


def _plain(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """An IPv4 address that came over IPv6 is an IPv4 address."""
    address = ipaddress.ip_address(host.partition("%")[0])
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        return address.ipv4_mapped
    return address


def admission_of(address: Address) -> Admission:
    """Raises LinkAddressError."""
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
