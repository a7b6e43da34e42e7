"""A simulated acoustic channel between two modems, in virtual time.

    a ))) |<------- range / sound speed ------->| ((( b
    acoustic://name?range=1000&rate=1000&loss=0.1&errors=1e-5&seed=1    (connects the first and
                                                                        second to open a name)
    one send = one burst on the water: [preamble + 8 n / bit rate]; delivered whole, at its end

Rules:
  * Data sent while the modem still transmits waits until it has finished.
  * Half duplex: a burst that overlaps a transmission of its receiver is lost. A share ``loss`` of
    all bursts is lost too. In the others each bit is wrong with probability ``bit_error_rate``.
  * The same seed and the same sends give the same bytes.

What does not live here: the envelope and the retries (protocol), real modems (links.serial).
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

from links import Address, LinkAddressError
from links.base import LinkBusy, LinkClosed, LinkError, Rx

SOUND_SPEED = 1500.0  # m/s
MTU = 3207  # bytes: one full modem frame (document 000, table 1.3)


@dataclass(frozen=True, slots=True)
class Water:
    """The channel. ``range_m``: slant range; ``preamble``: s that a modem sends before the data."""

    range_m: float = 1000.0
    bit_rate: float = 1000.0  # bit/s on the water
    loss: float = 0.0  # share of bursts that vanish
    bit_error_rate: float = 0.0
    preamble: float = 0.0

    def __post_init__(self) -> None:
        if not (self.range_m >= 0.0 and self.bit_rate > 0.0 and self.preamble >= 0.0):
            raise ValueError(f"range {self.range_m} m, {self.bit_rate} bit/s: not a channel")
        if not (0.0 <= self.loss <= 1.0 and 0.0 <= self.bit_error_rate <= 1.0):
            raise ValueError(f"loss {self.loss}, errors {self.bit_error_rate}: not shares of 1")

    @property
    def delay(self) -> float:
        return self.range_m / SOUND_SPEED

    def airtime(self, size: int) -> float:
        return self.preamble + 8.0 * size / self.bit_rate


@dataclass(slots=True)
class Tally:
    """What one modem has sent, and what became of it."""

    bursts: int = 0
    size: int = 0  # bytes
    airtime: float = 0.0  # s
    lost: int = 0
    collided: int = 0
    damaged: int = 0


@dataclass(slots=True)
class _Burst:
    begin: float  # at the receiver
    end: float
    data: bytes
    lost: bool


@dataclass(slots=True)
class AcousticLink:
    """One end. ``acoustic_pair`` and ``open_url`` connect two of them."""

    name: str
    water: Water
    tally: Tally = field(default_factory=Tally)
    chance: random.Random = field(default_factory=random.Random)
    peer: AcousticLink | None = None
    _free: float = -math.inf  # when our own last transmission ends
    _spoken: list[tuple[float, float]] = field(default_factory=list)
    coming: list[_Burst] = field(default_factory=list)
    closed: bool = False

    def fileno(self) -> int:
        return -1

    def send(self, data: bytes, now: float, address: str = "") -> None:
        if self.closed:
            raise LinkClosed(f"{self.name}: the link was closed")
        peer = self.peer
        if len(data) > MTU:
            raise LinkError(f"{self.name}: {len(data)} bytes; one burst carries at most {MTU}")
        begin = max(now, self._free)
        self._free = begin + self.water.airtime(len(data))
        since = min(now, self.coming[0].begin) if self.coming else now
        self._spoken = [s for s in self._spoken if s[1] > since]
        self._spoken.append((begin, self._free))
        self.tally.bursts += 1
        self.tally.size += len(data)
        self.tally.airtime += self._free - begin
        lost = self.chance.random() < self.water.loss
        self.tally.lost += lost
        delay = self.water.delay
        heard = data if lost else self._damage(data)
        if peer is not None and not peer.closed:  # else nobody receives it, and no error is raised
            peer.coming.append(_Burst(begin + delay, self._free + delay, heard, lost))

    def receive(self, now: float) -> list[Rx]:
        if self.closed:
            raise LinkClosed(f"{self.name}: the link was closed")
        out = []
        while self.coming and self.coming[0].end <= now:
            burst = self.coming.pop(0)
            if burst.lost:
                continue
            if self._talked_over(burst):
                assert self.peer is not None
                self.peer.tally.collided += 1
            else:
                out.append(Rx(burst.end, self.name, burst.data))
        return out

    def next_event(self) -> float | None:
        return self.coming[0].end if self.coming else None

    def close(self) -> None:
        self.closed = True

    def _talked_over(self, burst: _Burst) -> bool:
        self._spoken = [s for s in self._spoken if s[1] > burst.begin]
        return any(begin < burst.end for begin, _ in self._spoken)

    def _damage(self, data: bytes) -> bytes:
        """Flip bits at random, by drawing the gaps between wrong bits."""
        rate, out, bit = self.water.bit_error_rate, bytearray(data), -1
        if rate == 0.0:
            return data
        while True:
            gap = 0.0
            if rate < 1.0:
                gap = math.log(1.0 - self.chance.random()) / math.log1p(-rate)
            if gap >= 8 * len(out):
                break
            bit += 1 + int(gap)
            if bit >= 8 * len(out):
                break
            out[bit >> 3] ^= 1 << (bit & 7)
        self.tally.damaged += out != data
        return bytes(out)


def acoustic_pair(
    water: Water, seed: int, names: tuple[str, str] = ("topside", "modem")
) -> tuple[AcousticLink, AcousticLink]:
    """Two modems at the two ends of the water."""
    one, other = (
        AcousticLink(name, water, chance=random.Random(f"{seed}/{name}")) for name in names
    )
    one.peer, other.peer = other, one
    return one, other


_WATERS: dict[str, list[AcousticLink]] = {}


def settings(address: Address) -> tuple[str, Water, int]:
    """Name, parameters and seed of the water. Raises LinkAddressError."""
    place = address.host + address.path
    if not place:
        raise LinkAddressError(f"{address.url}: give the water a name, e.g. acoustic://bay")
    water = Water(
        range_m=address.number("range", 1000.0, 0.0, 1e5),
        bit_rate=address.number("rate", 1000.0, 1.0, 1e6),
        loss=address.number("loss", 0.0, 0.0, 1.0),
        bit_error_rate=address.number("errors", 0.0, 0.0, 1.0),
    )
    return place, water, int(address.number("seed", 0.0, 0.0, 2.0**31))


def open_url(name: str, address: Address) -> AcousticLink:
    """Open an end. The options of the second end are ignored. Raises LinkBusy for a third end."""
    place, water, seed = settings(address)
    ends = [end for end in _WATERS.get(place, []) if not end.closed]
    if len(ends) == 2:
        raise LinkBusy(f"{name}: acoustic://{place} has its two modems")
    if ends:
        (one,) = ends
        link = AcousticLink(name, one.water, chance=random.Random(one.chance.random()))
        link.peer, one.peer = one, link
    else:
        link = AcousticLink(name, water, chance=random.Random(f"{seed}/1"))
    _WATERS[place] = [*ends, link]
    return link
