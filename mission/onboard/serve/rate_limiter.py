"""The rate limiter: bytes of an address within its allowance pass; beyond it only X and W do.

    allowance of one address:   1000 frames and 256 kB at once, refilled 500 and 64 kB a second
    all addresses together:     four times that

Bytes beyond the allowance are dropped, but searched for ``@ZAX0$`` and ``@ZAWF$`` (R7: accepted
from every admitted connection). The last of these passes at once; the same one again passes only
after 50 ms. Each cut is marked by bytes that no frame contains, so that the ends of two frames
never join to a third.

Sans-IO: the caller gives the times. What does not live here: who may connect (links.admission),
what the frames mean (protocol).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from links.admission import Allowance
from links.base import Rx
from protocol.topside import EMERGENCIES

FRAMES, FRAMES_A_SECOND = 1000.0, 500.0
BYTES, BYTES_A_SECOND = float(1 << 18), float(1 << 16)
ALL = 4.0
SAME_ORDER_S = 0.05
REMEMBERED = 256  # addresses

_ORDER = re.compile(b"|".join(re.escape(frame) for frame in EMERGENCIES.values()))
_LONGEST = max(map(len, EMERGENCIES.values()))
BREAK = b"\xff\xff\xff\xff"  # neither text nor a valid counter of @AW


@dataclass(slots=True)
class _Budget:
    frames: Allowance
    octets: Allowance

    def fits(self, data: bytes, now: float, share: float) -> int:
        """How many of the bytes may pass: whole frames, as far as can be seen here."""
        self.frames.take(now, 0.0, FRAMES * share, FRAMES_A_SECOND * share)
        self.octets.take(now, 0.0, BYTES * share, BYTES_A_SECOND * share)
        parts = data.split(b"@", int(self.frames.left) + 1)
        length = len(data)
        if len(parts) > int(self.frames.left) + 1:
            length -= len(parts[-1]) + 1
        return length if length <= self.octets.left else 0

    def spend(self, data: bytes) -> None:
        self.frames.left -= data.count(b"@")
        self.octets.left -= len(data)


@dataclass(slots=True)
class _Source:
    """The state of one address. ``tails``: the end of the last bytes, by connection."""

    budget: _Budget
    order: bytes = b""
    ordered: float = float("-inf")
    tails: dict[str, bytes] = field(default_factory=dict)
    cut: set[str] = field(default_factory=set)  # connections whose last bytes were dropped


class RateLimiter:
    def __init__(self, now: float) -> None:
        self._all = _Budget(Allowance(FRAMES * ALL, now), Allowance(BYTES * ALL, now))
        self._sources: dict[str, _Source] = {}
        self.dropped = 0  # bytes, of all addresses

    def sift(self, heard: list[Rx], now: float, flooded: Callable[[str], None]) -> list[Rx]:
        """Return the bytes of one instant that pass, those with an X or W first."""
        out = []
        for rx in heard:
            data, dropped = self.passes(rx, now)
            if dropped:
                self.dropped += dropped
                flooded(host_of(rx.address))
            if data:
                out.append(rx._replace(data=data))
        return sorted(out, key=lambda rx: _ORDER.search(rx.data) is None)

    def passes(self, rx: Rx, now: float) -> tuple[bytes, int]:
        """Return the bytes that pass, and how many were dropped."""
        source = self._source(host_of(rx.address), now)
        tail = source.tails.get(rx.address, b"")
        fits = source.budget.fits(rx.data, now, 1.0)
        passed = rx.data[: min(fits, self._all.fits(rx.data[:fits], now, ALL))]
        source.budget.spend(passed)
        self._all.spend(passed)
        rest = rx.data[len(passed) :]
        begun = (passed or tail)[1 - _LONGEST :]
        source.tails[rx.address] = (tail + rx.data)[1 - _LONGEST :]
        if rx.address in source.cut and passed:
            passed = BREAK + _unfinished(tail) + passed
            source.cut.discard(rx.address)
        if rest:
            source.cut.add(rx.address)
            passed += self._order(source, begun + rest, now)
        return passed, len(rest)

    def forget(self, address: str) -> None:
        """Forget a closed connection; its address keeps its allowance."""
        source = self._sources.get(host_of(address))
        if source is not None:
            source.tails.pop(address, None)
            source.cut.discard(address)

    def _order(self, source: _Source, data: bytes, now: float) -> bytes:
        found = _ORDER.findall(data)
        if not found or (found[-1] == source.order and now - source.ordered < SAME_ORDER_S):
            return b""
        source.order, source.ordered = found[-1], now
        return BREAK + source.order

    def _source(self, host: str, now: float) -> _Source:
        if host not in self._sources and len(self._sources) >= REMEMBERED:
            self._sources = {h: s for h, s in self._sources.items() if s.tails}
        budget = _Budget(Allowance(FRAMES, now), Allowance(BYTES, now))
        return self._sources.setdefault(host, _Source(budget))


def host_of(address: str) -> str:
    """``host`` of ``host:port``."""
    return address.rpartition(":")[0]


def _unfinished(tail: bytes) -> bytes:
    """The beginning of an X or W at the end of dropped bytes, b"" if there is none."""
    for length in range(min(len(tail), _LONGEST - 1), 0, -1):
        if any(frame.startswith(tail[-length:]) for frame in EMERGENCIES.values()):
            return tail[-length:]
    return b""
