"""Sensors that were added to the simulated vehicle, on a line of their own.

    $VDVHW    speed log, once a second       :WS, :BS   Doppler log, once a second; :BS where the
    $VDGLL    acoustic position, every 5 s              ground is within REACH; or the same as PD0
    $CAMPR    way from a beacon, every 5 s,
              in turn from each

Noise is white; the draws are the sensors' own, so that without them nothing else is different.
A lie begins at its time: ``frozen`` says the last for ever, ``silent`` nothing, ``wild`` anything;
``offset`` is off by a tenth of what a wild one may be, ``drift`` by as much in 100 s, and ``delay``
says what was true DELAY before.

What does not live here: the decoder.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import cos, degrees, hypot, inf, sin
from random import Random

from links.simulated.firmware.gps import KNOT, sentence
from links.simulated.firmware.uart import Chunk
from links.simulated.geodesy import local, moved
from links.simulated.pd0 import ensemble
from links.simulated.plant import Plant

LIES = ("frozen", "silent", "wild", "offset", "drift", "delay")
REACH = 60.0  # m above the ground
LATENCY, COMPLETE = 0.15, 0.35  # s from the second that is measured: first byte, last byte
PLACES = 5  # s between two positions, and between the ways from two beacons
DELAY = 20  # s
SOUND = 1500.0  # m/s
_WILD_SPEED, _WILD_PLACE = 3.0, 300.0  # m/s, m: at most
_OFFSET, _DRIFT = 0.1, 0.001  # of the same; a second


@dataclass(frozen=True, slots=True)
class SimulatedBeacon:
    number: int
    latitude: float  # rad
    longitude: float
    depth: float  # m


@dataclass(frozen=True, slots=True)
class Fitted:
    """One sigma of what is fitted (m/s, m/s, m, m); None: it is not there. ``binary``: the
    Doppler log says PD0."""

    speed_log: float | None = None
    doppler: float | None = None
    acoustic: float | None = None
    ranges: float | None = None
    binary: bool = False
    beacons: tuple[SimulatedBeacon, ...] = ()
    lie: str = ""
    lies_from: float = inf  # s

    def __bool__(self) -> bool:
        fitted = self.speed_log, self.doppler, self.acoustic, self.ranges
        return any(sigma is not None for sigma in fitted)


class AddedSensors:
    def __init__(self, fitted: Fitted, seed: int) -> None:
        self.fitted, self.queue = fitted, deque[Chunk]()
        self._rng = Random(f"added {seed}")
        self._last = b""
        self._before = deque[bytes](maxlen=DELAY + 1)

    def report(self, now: float, plant: Plant, place: tuple[float, float]) -> None:
        """What was measured at ``now``, a whole second; ``place``: true latitude and longitude."""
        lie = self.fitted.lie if now >= self.fitted.lies_from else ""
        data = self._said(now, plant, place, lie)
        self._before.append(data)
        if lie == "frozen":
            data = self._last
        elif lie == "delay":
            data = self._before[0]
        elif lie == "silent":
            return
        self._last = data
        self.queue.append(Chunk(now + LATENCY, now + COMPLETE, data))

    def take(self, now: float) -> list[Chunk]:
        queue, out = self.queue, []
        while queue and queue[0].end <= now:
            out.append(queue.popleft())
        return out

    def _said(self, now: float, plant: Plant, place: tuple[float, float], lie: str) -> bytes:
        fitted, out = self.fitted, b""
        gone = now - fitted.lies_from
        if fitted.speed_log is not None:
            knots = self._off(plant.u, fitted.speed_log, _WILD_SPEED, lie, gone) / KNOT
            out += sentence(f"VDVHW,,T,,M,{knots:.2f},N,,K")
        if fitted.doppler is not None:
            out += self._doppler(plant, fitted.doppler, lie, gone)
        if fitted.acoustic is not None and round(now) % PLACES == 0:
            off = [self._off(0.0, fitted.acoustic, _WILD_PLACE, lie, gone) for _ in range(2)]
            out += sentence(f"VDGLL,{_angles(*moved(*place, *off))},{_clock(now)},A")
        if fitted.ranges is not None and fitted.beacons and round(now) % PLACES == 2:
            beacon = fitted.beacons[round(now) // PLACES % len(fitted.beacons)]
            across = local(place, beacon.latitude, beacon.longitude)
            way = hypot(*across, plant.depth - beacon.depth)
            heard = max(self._off(way, fitted.ranges, _WILD_PLACE, lie, gone), 1.0)
            out += sentence(f"CAMPR,{beacon.number},1,{heard / SOUND:.5f}")
        return out

    def _doppler(self, plant: Plant, sigma: float, lie: str, gone: float) -> bytes:
        north, east = plant.ground_velocity()
        c, s = cos(plant.yaw), sin(plant.yaw)
        over_ground = north * c + east * s, east * c - north * s
        water, ahead, across = (
            self._off(speed, sigma, _WILD_SPEED, lie, gone) for speed in (plant.u, *over_ground)
        )
        seen = plant.floor - plant.depth < REACH
        if self.fitted.binary:
            return ensemble((across, ahead) if seen else None, (0.0, water))
        return _pd6("WS", 0.0, water, good=True) + _pd6("BS", across, ahead, good=seen)

    def _off(self, value: float, sigma: float, most: float, lie: str, gone: float) -> float:
        """With its noise, or as the lie has it since ``gone`` seconds."""
        noise, anything = self._rng.gauss(0.0, sigma), self._rng.uniform(-most, most)
        if lie == "wild":
            return anything
        off = {"offset": _OFFSET * most, "drift": _DRIFT * most * gone}.get(lie, 0.0)
        return value + noise + off


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
