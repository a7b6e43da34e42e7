"""The filter's states and figures, and the vehicle's speed through the water between two reports.

    x = north, east | current north, east | surface drift north, east
        | speed scale, speed deviation
        | compass error: lasting, over the heading (sin, cos), wandering
        | depth, depth rate | bottom depth

    forward speed through the water = scale * expected(thrusters) + deviation
    true heading             = compass + declination - error - a sin(m) - b cos(m) - wander
    velocity over ground     = water + current (+ surface drift while at the surface)

The surface drift (wind, waves, Stokes) is the part of a current learned at the surface that does
not act below. Current, drift, deviation, compass error, its wander and depth rate are first-order
Gauss-Markov processes (Gelb, Applied Optimal Estimation, 1974, ch. 3.8): steady sigma, correlation
time. The deviation over the heading is a random function of the heading with covariance
sigma^2 cos(difference). Its second harmonic, half as large, wanders with each turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

from mission.model.vehicle import TIDE, Vehicle

N, E, CN, CE, WN, WE, SCALE, DEVIATION, COMPASS, SIN, COS, WANDER = range(12)
DEPTH, RATE, BOTTOM = range(12, 15)
STATES = 15


@dataclass(frozen=True, slots=True)
class Markov:
    """Steady standard deviation and correlation time in s."""

    sigma: float
    time: float

    def decay(self, dt: float) -> float:
        return math.exp(-dt / self.time)

    def times(self, share: float) -> Markov:
        return Markov(share * self.sigma, self.time)


@dataclass(frozen=True, slots=True)
class Figures:
    """One sigma of everything, SI. Figures that the vehicle file has come from there."""

    current: Markov
    fresh: Markov  # the current, for ``fresh_for`` s after a fix
    fresh_for: float
    current_mean: tuple[float, float]
    drift: Markov  # m/s
    scale: float  # relative, one sigma at the start
    pace: float  # relative, by how much the scale changes in an hour
    deviation: Markov  # m/s
    compass: Markov  # rad
    wander: Markov  # rad
    harmonic: float  # rad, of the deviation's first
    second: float  # rad, of its second
    heading: float  # rad, white, per report
    period: float  # s, of the reports
    sway: Markov  # share of the speed
    rate: Markov  # m/s, of the depth
    depth: float  # m, half of its variance white, half lasting
    altitude: float
    slope: float = 0.15  # of the bottom, rise over run
    slope_length: float = 20.0  # m over which the slope persists
    ground_velocity: float = 0.1  # m/s, of a receiver's speed and course

    def times(self, share: float) -> Figures:
        """Return these figures with all that makes a position under water wrong ``share`` times as
        large."""
        moved = (self.drift, self.deviation, self.compass, self.wander, self.sway)
        drift, deviation, compass, wander, sway = (m.times(share) for m in moved)
        return replace(
            self,
            current=self.current.times(share),
            fresh=self.fresh.times(share),
            drift=drift,
            deviation=deviation,
            compass=compass,
            wander=wander,
            sway=sway,
            scale=share * self.scale,
            pace=share * self.pace,
            harmonic=share * self.harmonic,
            second=share * self.second,
            heading=share * self.heading,
        )


def figures(vehicle: Vehicle) -> Figures:
    sensors, known = vehicle.sensors, vehicle.calibration
    current = vehicle.current if known.current_sigma is None else known.current_sigma
    current = max(current, 1e-4)
    return Figures(
        current=Markov(current, TIDE),
        fresh=Markov(current, known.current_time),
        fresh_for=known.current_time_for,
        current_mean=known.current,
        drift=Markov(known.surface_drift, 1800.0),
        scale=known.speed_scale_sigma,
        pace=0.1 * known.speed_scale_sigma,
        deviation=Markov(known.speed_noise, known.speed_time),
        compass=Markov(max(sensors.heading_bias, 1e-3), 8.0 * 3600.0),
        wander=Markov(known.compass_wander, known.compass_wander_time),
        harmonic=known.deviation_sigma,
        second=0.5 * known.deviation_sigma,
        heading=sensors.heading,
        period=sensors.telemetry_period,
        sway=Markov(known.sway_noise, 10.0),
        rate=Markov(0.12, 200.0),
        depth=sensors.depth,
        altitude=sensors.altitude,
        ground_velocity=known.fix_velocity,
    )


class Propulsion(Protocol):
    """The forward speed through still water that the vehicle's own data predict."""

    speed: float
    fastest: float  # m/s by full thrust; 0 where it has none

    def advance(
        self, actuators: tuple[float, ...] | None, dt: float, pitch: float, rate: float
    ) -> float:
        """Return the mean speed over the last ``dt`` s (inf: the motion has long been steady)."""
        ...


def propulsion(vehicle: Vehicle) -> Propulsion:
    return Glide(vehicle) if vehicle.glides else Thrust(vehicle)


class Thrust:
    """Speed by the main thrusters: v' = (drive - v |v|) / surge length; drive is the end speed^2.

    ``actuators`` are fractions of full thrust, those of the left and right main first.
    """

    __slots__ = ("_curve", "_length", "_scale", "fastest", "speed")

    def __init__(self, vehicle: Vehicle) -> None:
        self._curve, self._length = vehicle.speed_by_gear, vehicle.calibration.surge_length
        self._scale = vehicle.calibration.speed_scale
        self.fastest = self._scale * self._curve.at(12.0)
        self.speed = 0.0

    def advance(
        self, actuators: tuple[float, ...] | None, dt: float, pitch: float, rate: float
    ) -> float:
        if not actuators:
            return self.speed
        port, starboard = actuators[0], actuators[min(1, len(actuators) - 1)]
        drive = self._drive(port)
        if starboard != port:
            drive = 0.5 * (drive + self._drive(starboard))
        if dt == math.inf:
            self.speed = math.copysign(math.sqrt(abs(drive)), drive)
            return self.speed
        v, total, steps = self.speed, 0.0, min(max(1, math.ceil(2.0 * dt)), 40)
        h = min(dt, 20.0) / steps
        for _ in range(steps):
            before = v
            v += h * (drive - v * abs(v)) / (self._length + h * abs(v))
            total += 0.5 * (before + v)
        self.speed = v
        return total / steps

    def _drive(self, fraction: float) -> float:
        """Return the thrust as the signed square of its steady speed, (m/s)^2."""
        v = self._scale * self._curve.at(12.0 * abs(fraction))
        return math.copysign(v * v, fraction)


class Glide:
    """Speed by gliding down and up: horizontal speed = depth rate / tan(path angle).

    The path is steeper than the pitch by the angle of attack, about 3 deg near the pitches flown
    (Merckelbach, Smeed, Griffiths, J. Atmos. Oceanic Technol. 27, 2010, 547-563).
    """

    _ATTACK = math.radians(3.0)
    _LEAST = math.radians(8.0)  # a flatter pitch is no glide: inflecting, or at the surface
    _SLOWEST = 0.03  # m/s of depth rate
    _FASTEST = 0.6  # m/s forward

    __slots__ = ("_scale", "fastest", "speed")

    def __init__(self, vehicle: Vehicle) -> None:
        self._scale = vehicle.calibration.speed_scale
        self.speed = self.fastest = 0.0

    def advance(
        self, actuators: tuple[float, ...] | None, dt: float, pitch: float, rate: float
    ) -> float:
        if abs(rate) < self._SLOWEST or abs(pitch) < self._LEAST:
            self.speed = 0.0
        else:
            path = math.sin(abs(pitch) + self._ATTACK)
            self.speed = self._scale * min(abs(rate) / path, self._FASTEST)
        return self.speed
