"""Sensors that were added to the simulated vehicle, on a line of their own.

    $VDVHW    speed log, once a second       :WS, :BS   Doppler log, once a second; :BS where the
    $VDGLL    acoustic position, every 5 s              ground is within REACH

Noise is white; the draws are the sensors' own, so that without them nothing else is different. A
lie begins at its time: ``frozen`` says the last for ever, ``silent`` nothing, ``wild`` anything.

What does not live here: the decoder.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import cos, degrees, inf, sin
from random import Random

from links.simulated.firmware.gps import KNOT, sentence
from links.simulated.firmware.uart import Chunk
from links.simulated.geodesy import moved
from links.simulated.plant import Plant

LIES = ("frozen", "silent", "wild")
REACH = 60.0  # m above the ground
LATENCY, COMPLETE = 0.15, 0.35  # s from the second that is measured: first byte, last byte
PLACES = 5  # s between two positions
_WILD_SPEED, _WILD_PLACE = 3.0, 300.0  # m/s, m: at most


@dataclass(frozen=True, slots=True)
class Fitted:
    """One sigma of what is fitted (m/s, m/s, m); None: it is not there."""

    speed_log: float | None = None
    doppler: float | None = None
    acoustic: float | None = None
    lie: str = ""
    lies_from: float = inf  # s

    def __bool__(self) -> bool:
        return not (self.speed_log is self.doppler is self.acoustic is None)


class AddedSensors:
    def __init__(self, fitted: Fitted, seed: int) -> None:
        self.fitted, self.queue = fitted, deque[Chunk]()
        self._rng = Random(f"added {seed}")
        self._last = b""

    def report(self, now: float, plant: Plant, place: tuple[float, float]) -> None:
        """What was measured at ``now``, a whole second; ``place``: true latitude and longitude."""
        lie = self.fitted.lie if now >= self.fitted.lies_from else ""
        data = self._said(now, plant, place, wild=lie == "wild")
        if lie == "frozen":
            data = self._last
        elif lie == "silent":
            return
        self._last = data
        self.queue.append(Chunk(now + LATENCY, now + COMPLETE, data))

    def take(self, now: float) -> list[Chunk]:
        queue, out = self.queue, []
        while queue and queue[0].end <= now:
            out.append(queue.popleft())
        return out

    def _said(self, now: float, plant: Plant, place: tuple[float, float], *, wild: bool) -> bytes:
        fitted, out = self.fitted, b""
        north, east = plant.ground_velocity()
        c, s = cos(plant.yaw), sin(plant.yaw)
        over_ground = north * c + east * s, east * c - north * s
        if fitted.speed_log is not None:
            knots = self._off(plant.u, fitted.speed_log, _WILD_SPEED, wild) / KNOT
            out += sentence(f"VDVHW,,T,,M,{knots:.2f},N,,K")
        if fitted.doppler is not None:
            sigma = fitted.doppler
            water, ahead, across = (
                self._off(speed, sigma, _WILD_SPEED, wild) for speed in (plant.u, *over_ground)
            )
            seen = plant.floor - plant.depth < REACH
            out += _doppler("WS", 0.0, water, good=True)
            out += _doppler("BS", across, ahead, good=seen)
        if fitted.acoustic is not None and round(now) % PLACES == 0:
            off = [self._off(0.0, fitted.acoustic, _WILD_PLACE, wild) for _ in range(2)]
            out += sentence(f"VDGLL,{_angles(*moved(*place, *off))},{_clock(now)},A")
        return out

    def _off(self, value: float, sigma: float, most: float, wild: bool) -> float:
        """With its noise, or, wild, anything."""
        noise, anything = self._rng.gauss(0.0, sigma), self._rng.uniform(-most, most)
        return anything if wild else value + noise


def _doppler(kind: str, starboard: float, ahead: float, *, good: bool) -> bytes:
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
