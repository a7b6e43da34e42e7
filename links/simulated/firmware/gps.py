"""A GPS receiver on the Pi's own port: NMEA 0183 GGA and RMC once a second.

    $GPGGA,hhmmss.00,ddmm.mmmmmm,N,dddmm.mmmmmm,E,1,09,1.0,h.h,M,0.0,M,,*hh
    $GPRMC,hhmmss.00,A,ddmm.mmmmmm,N,dddmm.mmmmmm,E,knots,course,ddmmyy,,,A*hh

A fix needs the antenna out of the water (``ANTENNA``) for some seconds; for one or two after a wave
has just washed over it. Without a fix the sentences continue with the time alone (quality 0, status
V). Noise is white. ``fix_wander`` adds an error that stays for minutes, ``fix_settle`` an error of
the first fixes after a dive, which have few satellites and a large HDOP. Both sentences, or the one
that the receiver is set to, are sent as one piece: the first byte ``LATENCY`` after their second,
the last one by ``COMPLETE``.

The formatter is our own: the library's takes ten times as long. What does not live here: the
decoder.
"""

from __future__ import annotations

from collections import deque
from datetime import UTC, datetime, timedelta
from math import atan2, degrees, exp, hypot, inf, sqrt
from random import Random

from links.simulated.firmware.uart import Chunk, turned_over
from links.simulated.geodesy import moved
from links.simulated.sensors import SensorErrors

ANTENNA = 0.3  # m, depth of the pressure sensor below which the antenna is under water
RECENT = 32  # positions that it can repeat
WANDER = 0.4  # m per second and axis
WASHED = 10.0  # s under water at most after which a fix returns at once
AT_ONCE = 1.0, 2.0  # s until the fix then
SETTLES = 5.0  # s, time constant of ``fix_settle``
CORRELATED = 100.0  # s, time constant of ``fix_wander``
LATENCY = 0.1  # s from the epoch to the first byte
COMPLETE = 0.3  # s from the epoch until all has been sent (150 bytes at 9600 take 0.16)
KNOT = 1852 / 3600
_TWO = tuple(f"{n:02d}" for n in range(60))
_SCALE = 60_000_000  # millionths of a minute in a degree


def checksum(body: bytes) -> int:
    """XOR of all bytes, computed by folding one large number."""
    n = int.from_bytes(body, "little")
    n ^= n >> 512
    n ^= n >> 256
    n ^= n >> 128
    n ^= n >> 64
    n ^= n >> 32
    n ^= n >> 16
    return (n ^ n >> 8) & 0xFF


def sentence(text: str) -> bytes:
    body = text.encode("ascii")
    return b"$%b*%02X\r\n" % (body, checksum(body))


def _angle(radians: float, width: int, letters: str) -> str:
    whole, rest = divmod(round(abs(degrees(radians)) * _SCALE), _SCALE)
    minutes, decimals = divmod(rest, 1_000_000)
    letter = letters[0] if radians >= 0.0 else letters[1]
    return f"{whole:0{width}d}{minutes:02d}.{decimals:06d},{letter}"


class GpsReceiver:
    def __init__(
        self,
        errors: SensorErrors,
        rng: Random,
        start: datetime,
        sentences: tuple[str, ...] = ("GGA", "RMC"),
    ) -> None:
        self.errors, self.rng, self.sentences = errors, rng, sentences
        self.start = start.astimezone(UTC)
        self.queue: deque[Chunk] = deque()
        self.powered = True
        self.blind = False  # no fix, even with a clear view of the sky
        self.silent = False  # sends nothing
        self.stuck = False  # repeats its last fix, under water too
        self.in_turn = 0  # repeats so many of its last fixes in turn, under water too
        self.wanders = False  # makes up plausible positions under water
        self.corrupt = 0.0  # share of epochs with a flipped bit
        self.offset = (0.0, 0.0)  # m north and east, added to all fixes
        self._fix_at: float | None = errors.first_fix
        self._seen = -inf  # when its antenna was last out of the water
        self._beside = _Beside(errors, rng)
        self._last: Look | None = None
        self._said: deque[Look] = deque(maxlen=RECENT)
        self._turn = 0
        self._astray: tuple[float, float] | None = None  # where it has wandered to
        self._day = -1
        self._midnight = datetime(self.start.year, self.start.month, self.start.day, tzinfo=UTC)
        self._seconds = (self.start - self._midnight).total_seconds()
        self._date = ""

    def has_fix(self, depth: float, now: float) -> bool:
        """Whether there is a fix now. Tracks how long the antenna has been out of the water."""
        if depth > ANTENNA or self.blind or not self.powered:
            self._fix_at = None
            return False
        if self._fix_at is None:
            washed = now - self._seen < WASHED
            self._fix_at = now + self.rng.uniform(*(AT_ONCE if washed else self.errors.fix_again))
            if not washed:
                self._beside.begin(self._fix_at)
        self._seen = now
        return now >= self._fix_at

    def report(
        self, now: float, depth: float, position: tuple[float, float], velocity: tuple[float, float]
    ) -> None:
        """Queue the sentences of the epoch ``now``. ``depth``: water over the pressure sensor, m;
        ``position``: latitude and longitude, rad; ``velocity``: north and east over ground, m/s."""
        fixed = self.has_fix(depth, now)
        if self.silent or not self.powered:
            return
        clock = self._clock(now)
        look = self._repeated()
        if look is None and fixed:
            self._astray = position
            look = self._last = self._look(position, velocity, now)
            self._said.append(look)
        elif look is None and self.wanders and self._astray is not None:
            look = self._wandered()
        data = b"".join([sentence(_SAYS[name](clock, self._date, look)) for name in self.sentences])
        if self.corrupt and self.rng.random() < self.corrupt:
            data = turned_over(data, self.rng)
        self.queue.append(Chunk(now + LATENCY, now + COMPLETE, data))

    def _repeated(self) -> Look | None:
        if self.in_turn and self._said:
            self._turn += 1
            return self._said[-1 - self._turn % min(self.in_turn, len(self._said))]
        return self._last if self.stuck else None

    def _wandered(self) -> Look:
        """A made-up fix, a step from the one before, with the matching speed."""
        assert self._astray is not None
        step = self.rng.gauss(0.0, WANDER), self.rng.gauss(0.0, WANDER)
        self._astray = moved(*self._astray, *step)
        return self._look(self._astray, step)

    def take(self, now: float) -> list[Chunk]:
        queue, out = self.queue, []
        while queue and queue[0].end <= now:
            out.append(queue.popleft())
        return out

    def _clock(self, now: float) -> str:
        day, second = divmod(round(self._seconds + now), 86400)
        if day != self._day:
            self._day = day
            self._date = f"{self._midnight + timedelta(days=day):%d%m%y}"
        minute, second = divmod(second, 60)
        return _TWO[minute // 60] + _TWO[minute % 60] + _TWO[second] + ".00"

    def _look(
        self, position: tuple[float, float], velocity: tuple[float, float], now: float | None = None
    ) -> Look:
        """A fix with its errors. Made-up fixes have no ``now``, and no slow errors."""
        gauss, noise, slip = self.rng.gauss, self.errors.fix_noise, self.errors.speed_noise
        beside_north, beside_east = self.offset
        unsettled = 0.0
        if now is not None:
            north, east, unsettled = self._beside.at(now)
            beside_north, beside_east = beside_north + north, beside_east + east
        latitude, longitude = moved(
            *position, beside_north + gauss(0.0, noise), beside_east + gauss(0.0, noise)
        )
        north, east = velocity[0] + gauss(0.0, slip), velocity[1] + gauss(0.0, slip)
        place = f"{_angle(latitude, 2, 'NS')},{_angle(longitude, 3, 'EW')}"
        course = round(degrees(atan2(east, north)), 2) % 360.0
        sky = f"{9 - round(5.0 * unsettled):02d},{1.0 + 3.0 * unsettled:.1f}"
        return place, hypot(north, east) / KNOT, course, 0.3 + gauss(0.0, 2 * noise), sky


class _Beside:
    """The correlated errors of fixes: ``fix_wander`` and ``fix_settle``."""

    def __init__(self, errors: SensorErrors, rng: Random) -> None:
        self._rng, self._wander, self._settle = rng, errors.fix_wander, errors.fix_settle
        self._slow: tuple[float, float] | None = None
        self._first = (0.0, 0.0)
        self._from = -inf
        self._keep = exp(-1.0 / CORRELATED)
        self._renew = self._wander * sqrt(1.0 - self._keep**2)

    def begin(self, at: float) -> None:
        """Draw the error of the first fix after a dive, which comes at ``at``."""
        if self._settle:
            self._first = self._two(self._settle)
            self._from = at

    def at(self, now: float) -> tuple[float, float, float]:
        """Error north and east, m; how unsettled the receiver is: 1 at its first fix, then less."""
        if self._wander:
            if self._slow is None:
                self._slow = self._two(self._wander)
            else:
                north, east = self._two(self._renew)
                self._slow = self._keep * self._slow[0] + north, self._keep * self._slow[1] + east
        north, east = self._slow or (0.0, 0.0)
        unsettled = exp(min(0.0, self._from - now) / SETTLES)
        return north + unsettled * self._first[0], east + unsettled * self._first[1], unsettled

    def _two(self, sigma: float) -> tuple[float, float]:
        return self._rng.gauss(0.0, sigma), self._rng.gauss(0.0, sigma)


Look = tuple[str, float, float, float, str]  # place, knots, course, height; satellites, HDOP


def _gga(clock: str, date: str, look: Look | None) -> str:
    if look is None:
        return f"GPGGA,{clock},,,,,0,00,,,M,0.0,M,,"
    place, _, _, height, sky = look
    return f"GPGGA,{clock},{place},1,{sky},{height:.1f},M,0.0,M,,"


def _rmc(clock: str, date: str, look: Look | None) -> str:
    if look is None:
        return f"GPRMC,{clock},V,,,,,,,{date},,,N"
    place, knots, course, _, _ = look
    return f"GPRMC,{clock},A,{place},{knots:.3f},{course:.2f},{date},,,A"


_SAYS = {"GGA": _gga, "RMC": _rmc}
