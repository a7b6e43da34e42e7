"""The figures that the filter believes, and how the vehicle moves between two reports.

    x = north, east | current north, east | speed scale, speed deviation | compass error
        | depth, depth rate | bottom depth

    forward speed through the water  = scale * expected(thrusters) + deviation
    true heading                     = compass + declination - compass error

Currents, deviation, compass error and depth rate are first-order Gauss-Markov processes (Gelb,
Applied Optimal Estimation, 1974, ch. 3.8): steady sigma, correlation time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mission.vehicle import Vehicle

N, E, CN, CE, SCALE, DEVIATION, COMPASS, DEPTH, RATE, BOTTOM = range(10)
STATES = 10


@dataclass(frozen=True, slots=True)
class Markov:
    """Steady standard deviation and correlation time in s."""

    sigma: float
    time: float

    def decay(self, dt: float) -> float:
        return math.exp(-dt / self.time)


@dataclass(frozen=True, slots=True)
class Figures:
    """One sigma of everything, SI. Those that the vehicle file has come from it."""

    current: Markov
    scale: float  # relative
    deviation: Markov  # m/s
    compass: Markov  # rad
    heading: float  # rad, white, per report
    period: float  # s, of the reports
    rate: Markov  # m/s, of the depth
    depth: float
    altitude: float
    slope: float = 0.15  # of the bottom, rise over run
    slope_length: float = 20.0  # m over which the slope persists
    surge_length: float = 4.0  # m: mass over drag; v' = (v_end^2 - v^2) / surge_length
    ground_velocity: float = 0.15  # m/s, of a receiver's speed and course


def figures(vehicle: Vehicle) -> Figures:
    sensors = vehicle.sensors
    return Figures(
        current=Markov(max(vehicle.current, 0.02), 4.0 * 3600.0),
        scale=0.1,
        deviation=Markov(0.04, 30.0),
        compass=Markov(max(sensors.heading_bias, 1e-3), 6.0 * 3600.0),
        heading=sensors.heading,
        period=sensors.telemetry_period,
        rate=Markov(0.3, 15.0),
        depth=sensors.depth,
        altitude=sensors.altitude,
    )


class Thrust:
    """Forward speed through still water that the two main thrusters are expected to give."""

    __slots__ = ("_curve", "_length", "speed")

    def __init__(self, vehicle: Vehicle, length: float) -> None:
        self._curve, self._length = vehicle.speed_by_gear, length
        self.speed = 0.0

    def advance(self, actuators: tuple[float, ...] | None, dt: float) -> float:
        """The mean speed over ``dt`` under these fractions of thrust (left, right main first)."""
        if not actuators:
            return self.speed
        end = self._drive(actuators[0]) + self._drive(actuators[min(1, len(actuators) - 1)])
        drive, v, total = 0.5 * end, self.speed, 0.0
        steps = min(max(1, math.ceil(dt / 0.5)), 40)
        h = min(dt, 20.0) / steps
        for _ in range(steps):
            before = v
            v += h * (drive - v * abs(v)) / (self._length + h * abs(v))
            total += 0.5 * (before + v)
        self.speed = v
        return total / steps

    def _drive(self, fraction: float) -> float:
        """Thrust, as the signed square of the speed that it keeps up."""
        v = self._curve.at(12.0 * abs(fraction))
        return math.copysign(v * v, fraction)
