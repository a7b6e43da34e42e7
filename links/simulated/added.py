"""Sensors that are added to the simulated vehicle, on a serial line of their own.

    $VDVHW    speed log, once a second       :WS, :BS   Doppler log, once a second; :BS valid if the
    $VDGLL    acoustic position, every 5 s              ground is within REACH; or the same as PD0
    $CAMPR    range to a beacon, every 5 s,
              each beacon in turn

Noise is white. The sensors have a random generator of their own: with or without them everything
else is the same. From a given time on a sensor may report wrong values, each independently:

    frozen   the last value           silent  nothing              wild   random values
    offset   off by 10 % of WILD      drift   as much in 100 s     delay  the values of DELAY before

What does not live here: the decoder.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from math import cos, degrees, hypot, inf, sin
from random import Random

from links.simulated.firmware.gps import KNOT, sentence
from links.simulated.firmware.uart import Chunk
from links.simulated.geodesy import local, moved
from links.simulated.pd0 import ensemble
from links.simulated.plant import Plant

SENSORS = ("speed_log", "doppler", "acoustic", "ranges")
LIES = ("frozen", "silent", "wild", "offset", "drift", "delay")
REACH = 60.0  # m above the ground
LATENCY, COMPLETE = 0.15, 0.35  # s from the second that is measured: first byte, last byte
PLACES = 5  # s between two positions, and between the ranges to two beacons
DELAY = 20.0  # s
SOUND = 1500.0  # m/s
WILD = {"speed_log": 3.0, "doppler": 3.0, "acoustic": 300.0, "ranges": 300.0}  # m/s, m: at most
_USUAL = {"offset": 0.1, "drift": 0.001}  # shares of WILD; drift: per second


@dataclass(frozen=True, slots=True)
class SimulatedBeacon:
    number: int
    latitude: float  # rad
    longitude: float
    depth: float  # m


@dataclass(frozen=True, slots=True)
class Lie:
    """Wrong values of kind ``how`` (LIES), from ``since`` s on. ``value``: the offset, the drift
    per second, the greatest wild value, or the delay in s."""

    how: str
    since: float
    value: float


def usual(sensor: str, how: str) -> float:
    """The default value of a lie."""
    return DELAY if how == "delay" else _USUAL.get(how, 1.0) * WILD[sensor]


@dataclass(slots=True)
class _Memory:
    """What one sensor sent last, and its true measurements before, with their times."""

    last: bytes = b""
    before: deque[tuple[float, bytes]] = field(default_factory=deque)


@dataclass(frozen=True, slots=True)
class Fitted:
    """The added sensors, by their noise: one sigma (m/s, m/s, m, m); None: not fitted. ``binary``:
    the Doppler log sends PD0. ``lie``: what all of them do from ``lies_from`` on."""

    speed_log: float | None = None
    doppler: float | None = None
    acoustic: float | None = None
    ranges: float | None = None
    binary: bool = False
    beacons: tuple[SimulatedBeacon, ...] = ()
    lie: str = ""
    lies_from: float = inf  # s

    def __bool__(self) -> bool:
        return any(self.has(sensor) for sensor in SENSORS)

    def has(self, sensor: str) -> bool:
        return getattr(self, sensor) is not None


class AddedSensors:
    """The added sensors. ``lies``: by sensor; they take priority over the lie of ``fitted``."""

    def __init__(self, fitted: Fitted, seed: int) -> None:
        self.fitted, self.queue = fitted, deque[Chunk]()
        self.lies: dict[str, Lie] = {}
        self._rng = Random(f"added {seed}")
        self._memory = {sensor: _Memory() for sensor in SENSORS}

    def report(self, now: float, plant: Plant, place: tuple[float, float]) -> None:
        """Queue the measurements of ``now``, a whole second. ``place``: true position, rad."""
        says = {
            "speed_log": lambda: self._speed_log(now, plant),
            "doppler": lambda: self._doppler(now, plant),
            "acoustic": lambda: self._acoustic(now, place),
            "ranges": lambda: self._range(now, plant, place),
        }
        fitted = [sensor for sensor in SENSORS if self.fitted.has(sensor)]
        data = b"".join(self._said(sensor, now, says[sensor]()) for sensor in fitted)
        if data:
            self.queue.append(Chunk(now + LATENCY, now + COMPLETE, data))

    def take(self, now: float) -> list[Chunk]:
        queue, out = self.queue, []
        while queue and queue[0].end <= now:
            out.append(queue.popleft())
        return out

    def lie(self, sensor: str, now: float) -> Lie | None:
        fitted = self.fitted
        if sensor not in self.lies and fitted.lie and now >= fitted.lies_from:
            return Lie(fitted.lie, fitted.lies_from, usual(sensor, fitted.lie))
        return self.lies.get(sensor)

    def _said(self, sensor: str, now: float, data: bytes) -> bytes:
        """What the sensor sends: ``data`` as measured, or what its lie makes of it."""
        if not data:
            return b""
        memory, lie = self._memory[sensor], self.lie(sensor, now)
        memory.before.append((now, data))
        late = lie.value if lie is not None and lie.how == "delay" else DELAY
        while len(memory.before) > 1 and memory.before[1][0] <= now - late:
            memory.before.popleft()
        if lie is not None and lie.how == "silent":
            return b""
        if lie is not None and lie.how == "frozen":
            return memory.last
        memory.last = memory.before[0][1] if lie is not None and lie.how == "delay" else data
        return memory.last

    def _speed_log(self, now: float, plant: Plant) -> bytes:
        knots = self._off("speed_log", plant.u, now) / KNOT
        return sentence(f"VDVHW,,T,,M,{knots:.2f},N,,K")

    def _doppler(self, now: float, plant: Plant) -> bytes:
        north, east = plant.ground_velocity()
        c, s = cos(plant.yaw), sin(plant.yaw)
        over_ground = north * c + east * s, east * c - north * s
        water, ahead, across = (
            self._off("doppler", speed, now) for speed in (plant.u, *over_ground)
        )
        seen = plant.floor - plant.depth < REACH
        if self.fitted.binary:
            return ensemble((across, ahead) if seen else None, (0.0, water))
        return _pd6("WS", 0.0, water, good=True) + _pd6("BS", across, ahead, good=seen)

    def _acoustic(self, now: float, place: tuple[float, float]) -> bytes:
        if round(now) % PLACES:
            return b""
        north, east = (self._off("acoustic", 0.0, now) for _ in range(2))
        return sentence(f"VDGLL,{_angles(*moved(*place, north, east))},{_clock(now)},A")

    def _range(self, now: float, plant: Plant, place: tuple[float, float]) -> bytes:
        beacons = self.fitted.beacons
        if not beacons or round(now) % PLACES != 2:
            return b""
        beacon = beacons[round(now) // PLACES % len(beacons)]
        across = local(place, beacon.latitude, beacon.longitude)
        way = hypot(*across, plant.depth - beacon.depth)
        heard = max(self._off("ranges", way, now), 1.0)
        return sentence(f"CAMPR,{beacon.number},1,{heard / SOUND:.5f}")

    def _off(self, sensor: str, value: float, now: float) -> float:
        """``value`` with the sensor's noise, and with its wild, offset or drift error."""
        lie = self.lie(sensor, now)
        most = lie.value if lie is not None and lie.how == "wild" else WILD[sensor]
        noise = self._rng.gauss(0.0, getattr(self.fitted, sensor))
        anything = self._rng.uniform(-most, most)
        match lie:
            case Lie(how="wild"):
                return anything
            case Lie(how="offset"):
                return value + noise + lie.value
            case Lie(how="drift"):
                return value + noise + lie.value * (now - lie.since)
        return value + noise


def _pd6(kind: str, starboard: float, ahead: float, *, good: bool) -> bytes:
    speeds = (starboard, ahead, 0.0) if good else (-32.768,) * 3
    numbers = ",".join(f"{round(1000 * speed):+06d}" for speed in speeds)
    return f":{kind},{numbers},{'A' if good else 'V'}\r\n".encode()


def _angles(latitude: float, longitude: float) -> str:
    fields = []
    for radians, width, letters in ((latitude, 2, "NS"), (longitude, 3, "EW")):
        whole, minutes = divmod(round(abs(degrees(radians)) * 60e6), 60_000_000)
        letter = letters[0] if radians >= 0.0 else letters[1]
        fields.append(f"{whole:0{width}d}{minutes / 1e6:09.6f},{letter}")
    return ",".join(fields)


def _clock(now: float) -> str:
    minute, second = divmod(round(now) % 86400, 60)
    return f"{minute // 60:02d}{minute % 60:02d}{second:02d}.00"
