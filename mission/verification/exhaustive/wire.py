"""What the vehicle and its GPS receiver send, in the bytes of their documents.

What does not live here: when they send it (world), how it is decoded (protocol).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

from mission.model import Position
from mission.navigation.geodesy import EARTH
from protocol.checksum import SD_DEFAULT, sd_profile
from protocol.nmea import encode_gga, encode_rmc
from protocol.vehicles.auv import MAGNETOMETERS, SD

_LAYOUT = SD.layout  # NaN: no value
_SUM = sd_profile(SD_DEFAULT)
_MAGNETIC = len(MAGNETOMETERS) * (20.0,)  # uT
_METRE = 1.0 / EARTH  # rad
_BEGIN = datetime(2026, 3, 1, 4, 0, tzinfo=UTC)
RANGE = 70.0  # m from home, where no guard on the range of a shipped mission is open
_NEUTRAL, _AHEAD, _DOWN = 1500, 1700, 1083  # us


@dataclass(slots=True)
class Sea:
    """The true state of the vehicle, and the faults of its sensors.

    ``unknown`` names the values of a report that are NaN, ``frozen`` those that repeat to the bit.
    """

    depth: float = 0.2
    altitude: float = 20.0
    heading_deg: float = 0.0
    roll_deg: float = 1.0
    temperature: float = 15.0
    control_v: float = 12.0
    powered: bool = True
    dives: bool = False  # its vertical thrusters push down with full thrust
    stopped: bool = False  # by X0, which it obeys whether or not it answers
    north: float = RANGE
    east: float = 0.0
    leak: bool = False
    placed: bool = False  # the report has the vehicle's own place
    yaw_offset_deg: float = 0.0  # added to the reported yaw, to put it out of range
    course_deg: float | None = None  # over ground, in fixes; None: they have none
    unknown: set[str] = field(default_factory=set)
    frozen: set[str] = field(default_factory=set)
    _said: dict[str, float] = field(default_factory=dict)
    count: int = 0  # of reports

    @property
    def pushes(self) -> bool:
        """Whether a thruster or a wheel turns."""
        return self.powered and not self.stopped

    def told(self) -> dict[str, float]:
        """Return the readings, NaN where unknown, in the AUV's units (m, C, deg). Their last bits
        change from report to report, as those of real sensors do."""
        self.count += 1
        jitter = (self.count % 5 - 2) * 0.004
        yaw = -math.degrees(math.remainder(math.radians(self.heading_deg), math.tau))
        values = {
            "roll": self.roll_deg + jitter,
            "pitch": jitter,
            "yaw": yaw + jitter + self.yaw_offset_deg,
            "temperature": self.temperature + jitter,
            "depth": self.depth + jitter,
            "altitude": self.altitude + jitter,
        }
        for name in self.frozen:
            values[name] = self._said.get(name, values[name])
        self._said = dict(values)
        return {n: math.nan if n in self.unknown else value for n, value in values.items()}

    def sentences(self, home: Position, now: float) -> bytes:
        """Return GGA and RMC of one epoch."""
        utc = _BEGIN + timedelta(seconds=round(now, 1))
        latitude, longitude = place_of(self, home)
        moving = self.course_deg is not None
        rmc = encode_rmc(
            utc,
            latitude,
            longitude,
            speed=1.0 if moving else 0.0,
            course=None if self.course_deg is None else math.radians(self.course_deg % 360.0),
        )
        return encode_gga(utc, latitude, longitude) + rmc


class Land(Sea):
    """The state of a vehicle that drives on the ground: its depth stays 0."""

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> None:
        super().__setattr__(name, 0.0 if name == "depth" else value)


def place_of(sea: Sea, home: Position) -> tuple[float, float]:
    """Return latitude and longitude, rad."""
    latitude = math.radians(home.latitude_deg) + sea.north * _METRE
    longitude = math.radians(home.longitude_deg) + sea.east * _METRE / math.cos(latitude)
    return latitude, longitude


def sd(sea: Sea) -> bytes:
    """Return one ``@SD``."""
    ahead = _AHEAD if sea.pushes else _NEUTRAL
    vertical = _DOWN if sea.pushes and sea.dives else ahead
    widths = (ahead, ahead, vertical, vertical, vertical, ahead, ahead)
    rest = (*_MAGNETIC, *widths, int(sea.control_v), 48)
    raw = _LAYOUT.pack(SD.lead, *sea.told().values(), *rest, bytes(4), b"$")
    return raw[:-5] + _SUM.compute(raw[_SUM.first : -5]).to_bytes(4, "little") + b"$"


def answer(frame: bytes, letter: str, profile: str) -> bytes:
    """Return the STM32's acknowledgement of a Z frame; as built, all have the same code."""
    code = "A" if profile == "as-built" else chr(frame[3])
    return f"@ACK_Z{code}{letter}$".encode()
