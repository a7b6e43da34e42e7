"""A GPS receiver: NMEA 0183 sentences once a second, at the surface only.

GGA, RMC and GSA of several talkers. The antenna stays wet for some seconds after it comes up; fixes
have 1.5 m of noise that wanders, 5 to 11 satellites and a dilution to match. Under water it says
"no fix", or, where a scene wants it, lies: the last place again (`stuck`), two, three or five places in turn
(`alternating`, `cycling`, `ring`), what it kept of yesterday until it has a fix (`yesterday`), plausible places that wander (`wandering`).
"""

from __future__ import annotations

import math
import random
import re
from dataclasses import dataclass

from tests.sea.body import Body
from tests.sea.wire import Line

HOME = (30.2874595, 120.1535765)  # deg, where north 0, east 0 is (example of seed 000)
EARTH = 6371008.8  # m, mean radius


def sentence(body: str) -> bytes:
    """`$body*XX` with the XOR of the body."""
    check = 0
    for char in body:
        check ^= ord(char)
    return f"${body}*{check:02X}\r\n".encode()


def _angle(degrees: float, width: int) -> str:
    whole = int(abs(degrees))
    return f"{whole:0{width}d}{(abs(degrees) - whole) * 60:08.5f}"


@dataclass
class Receiver:
    """The receiver on `line`; `mode` says what it does under water."""

    body: Body
    line: Line
    seed: int = 0
    mode: str = (
        "honest"  # honest, silent, stuck, alternating, cycling, ring, yesterday, wandering, dead
    )
    talker: str = "GN"
    period: float = 1.0  # s between places
    date: str = "010625"  # of RMC, day month year
    checked: bool = True  # whether sentences have their checksum

    def __post_init__(self) -> None:
        self.random = random.Random(f"receiver {self.seed}")
        self.next = 1000 + self.random.uniform(0, 1)
        self.dry_since: float | None = 990.0
        self.wet_for = self.random.uniform(2, 6)
        self.error = [0.0, 0.0]
        self.last = (0.0, 0.0)
        self.told = 0

    def tick(self, now: float) -> None:
        """Say what is due."""
        if self.body.depth > 0.25:
            self.dry_since = None
        elif self.dry_since is None:
            self.dry_since, self.wet_for = now, self.random.uniform(2, 6)
        if now < self.next or self.mode == "dead":
            return
        self.next += self.period
        place, satellites = self._place(now)
        if place is None and self.mode == "silent":
            return
        data = self._sentences(now, place, satellites)
        self.line.send(now, data if self.checked else re.sub(rb"\*..\r", b"\r", data))
        self.told += 1

    def _place(self, now: float) -> tuple[tuple[float, float] | None, int]:
        draw = self.random
        if self.mode == "yesterday":
            return (2600.0 + draw.gauss(0, 0.3), -1900.0 + draw.gauss(0, 0.3)), draw.randint(5, 8)
        if self.dry_since is not None and now - self.dry_since >= self.wet_for:
            self.error = [0.95 * e + draw.gauss(0, 0.4) for e in self.error]
            self.last = (self.body.pose.x + self.error[0], self.body.pose.y + self.error[1])
            return self.last, draw.randint(7, 11)
        if self.mode == "stuck":
            return self.last, 9
        if self.mode == "alternating":
            return (self.last[0] + (1.5 if self.told % 2 else 0.0), self.last[1]), 9
        if self.mode in ("cycling", "ring"):
            step = self.told % (3 if self.mode == "cycling" else 5)
            return (self.last[0] + 1.1 * step, self.last[1] - 0.7 * step), 9
        if self.mode == "wandering":
            self.last = (self.last[0] + draw.gauss(0, 0.6), self.last[1] + draw.gauss(0, 0.6))
            return self.last, draw.randint(6, 9)
        return None, 0

    def _sentences(self, now: float, place: tuple[float, float] | None, satellites: int) -> bytes:
        second = now % 86400
        clock = f"{int(second // 3600):02d}{int(second // 60) % 60:02d}{second % 60:05.2f}"
        if place is None:
            empty = sentence(f"{self.talker}GGA,{clock},,,,,0,00,99.9,,M,,M,,")
            return empty + sentence(f"{self.talker}RMC,{clock},V,,,,,,,{self.date},,,N")
        latitude = HOME[0] + math.degrees(place[0] / EARTH)
        longitude = HOME[1] + math.degrees(place[1] / EARTH) / math.cos(math.radians(HOME[0]))
        where = f"{_angle(latitude, 2)},N,{_angle(longitude, 3)},E"
        hdop = round(9.0 / satellites, 1)
        used = ",".join(f"{n:02d}" for n in range(1, satellites + 1)) + "," * (12 - satellites)
        speed = max(0.0, 0.05 + 0.03 * self.random.gauss(0, 1))
        return (
            sentence(f"{self.talker}GGA,{clock},{where},1,{satellites:02d},{hdop},2.1,M,9.0,M,,")
            + sentence(f"{self.talker}GSA,A,3,{used},{hdop + 0.8:.1f},{hdop},{hdop + 0.4:.1f}")
            + sentence(f"{self.talker}RMC,{clock},A,{where},{speed:.2f},0.0,{self.date},,,A")
        )
