"""The readings of the simulated sensors: noise, bias, slow errors, range, dropouts, dead sensors.

SI and radians; one seeded generator for everything. ``sample`` is called once for every ``@SD``.
Between two samples the firmware's control loops read the truth with the errors of the last sample,
without its white noise. So they see what was reported, without a random draw per loop.

    compass = true heading - declination + bias + slow error
              + deviation * sin(heading) + deviation / 2 * cos(2 heading) + noise

The health of a sensor:

    frozen        repeats its last value        absurd      random values anywhere in its range
    intermittent  half of the samples repeat    full_scale  the end of its range
    silent        no value: the documented board reports NaN, the board as built its last value

A value may also be bent (a factor and an offset, for a compass with the wrong sign or a sensor that
came loose), or wrong but plausible (wrong.py): stuck with noise, drifting, late.

What does not live here: the bytes (firmware), the GPS (firmware/gps.py), when a fault begins.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from math import cos, exp, log, nan, pi, radians, remainder, sin, sqrt
from random import Random

from links.simulated.plant import Plant
from links.simulated.waves import Felt, Waves, felt
from links.simulated.wrong import Wrong

PERIOD = 2.0  # s between samples, the period of @SD
TWO_PI = 2 * pi
FIELD_NORTH, FIELD_DOWN = 33e-6, 35e-6  # T, magnetic north and down at 30 N


class Sensor(enum.Enum):
    """A sensor. Its value: places in the list that ``sample`` returns, in the order of @SD."""

    ATTITUDE = (0, 1)
    HEADING = (2,)
    TEMPERATURE = (3,)
    DEPTH = (4,)
    ALTITUDE = (5,)
    MAGNETOMETER = (6, 7, 8, 9, 10, 11, 12, 13, 14)
    BATTERY = (15, 16)


class Health(enum.Enum):
    HEALTHY = "healthy"
    FROZEN = "frozen"
    SILENT = "silent"
    ABSURD = "absurd"
    INTERMITTENT = "intermittent"
    FULL_SCALE = "full_scale"


FULL_SCALE = {  # greatest wrong value of each sensor, in its own unit
    Sensor.ATTITUDE: 4 * pi,
    Sensor.HEADING: 4 * pi,
    Sensor.TEMPERATURE: 327.67,
    Sensor.DEPTH: 6553.5,
    Sensor.ALTITUDE: 6553.5,
    Sensor.MAGNETOMETER: 1e-3,
    Sensor.BATTERY: 65535.0,
}


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """Values are one sigma unless stated otherwise. A bias of ``None`` is drawn from the seed."""

    declination: float | None = None  # rad, east positive; None: that of the place
    compass_bias: float | None = None  # rad; drawn with sigma 4 deg
    compass_noise: float = radians(1.0)
    compass_slow: float = radians(1.0)  # Gauss-Markov error, time constant 300 s
    deviation: float = radians(2.0)  # amplitude, as a function of the heading
    attitude_noise: float = radians(0.5)
    depth_bias: float | None = None  # m; drawn with sigma 0.05 m
    depth_noise: float = 0.05
    altitude_noise: float = 0.05
    altitude_range: float = 50.0  # m, no echo beyond
    altitude_drop: float = 0.1  # share of samples without an echo
    temperature: float = 18.0  # deg C at the surface, 0.05 less per metre
    temperature_noise: float = 0.02
    thermocline: tuple[float, float] = (0.0, 0.0)  # deg C colder below, m
    warm_layer: tuple[float, float] = (0.0, 0.0)  # deg C warmer at its middle, m
    magnetic_noise: float = 0.1e-6  # T
    fix_noise: float = 2.5  # m per axis
    fix_wander: float = 0.0  # m per axis, correlated over 100 s
    fix_settle: float = 0.0  # m per axis, of the first fix after a dive; a third of it 5 s later
    speed_noise: float = 0.05  # m/s per axis, of the GPS
    first_fix: float = 3.0  # s at the surface after power-on
    fix_again: tuple[float, float] = (3.0, 8.0)  # s after surfacing, uniform between these


def _half_circle(angle: float) -> float:
    """The angle within half a turn either way, as a sensor reports it."""
    return angle if -pi <= angle <= pi else remainder(angle, TWO_PI)


def turned(by: Felt) -> float:
    """The compass error in waves, rad: the compass tilts with the hull."""
    return by.roll * FIELD_DOWN / FIELD_NORTH


def warmth(errors: SensorErrors, depth: float) -> float:
    """Water temperature at a depth, deg C. A thermocline is 4 m thick, a warm layer 10 m."""
    degrees = errors.temperature - 0.05 * depth
    colder, below = errors.thermocline
    if colder:
        degrees -= colder / (1.0 + exp(min(2.0 * (below - depth), 700.0)))
    warmer, middle = errors.warm_layer
    if warmer:
        degrees += warmer * exp(-(((depth - middle) / 2.5) ** 2))
    return degrees


def normals(rng: Random, count: int) -> list[float]:
    """The same as ``count`` calls of ``rng.gauss()``, to the bit, in a third of the time. The
    generator draws in pairs and keeps the second half of the last pair."""
    random = rng.random
    kept: float | None = rng.gauss_next  # type: ignore[attr-defined]
    out = [] if kept is None else [kept]
    while len(out) < count:
        angle = random() * TWO_PI
        radius = sqrt(-2.0 * log(1.0 - random()))
        out.append(cos(angle) * radius)
        out.append(sin(angle) * radius)
    rng.gauss_next = out.pop() if len(out) > count else None  # type: ignore[attr-defined]
    return out


class Sensors:
    """All sensors behind the STM32."""

    def __init__(
        self,
        errors: SensorErrors,
        rng: Random,
        *,
        repeats_when_silent: bool,
        declination: float = 0.0,  # of the place; ``errors`` may have another
    ) -> None:
        self.errors, self.rng = errors, rng
        stated = errors.declination
        self.declination = declination if stated is None else stated
        bias, depth_bias = errors.compass_bias, errors.depth_bias
        self.compass_bias = rng.gauss(0.0, radians(4.0)) if bias is None else bias
        self.depth_bias = rng.gauss(0.0, 0.05) if depth_bias is None else depth_bias
        self.health: dict[Sensor, Health] = {}  # only those that are not healthy
        self.bent: dict[int, tuple[float, float]] = {}  # slot: factor and offset
        self.wrong: dict[int, Wrong] = {}  # by slot
        self.battery_noise = 0.0  # V, one sigma, added to the override
        self.battery_override: float | None = None  # V of the control battery
        self.last: list[float] = [0.0] * 15 + [12.0, 48.0]
        self._silent = Health.FROZEN if repeats_when_silent else Health.SILENT
        self._heading_error = -self.declination + self.compass_bias
        self._slow = rng.gauss(0.0, errors.compass_slow)
        self._keep = exp(-PERIOD / 300.0)
        self._renew = errors.compass_slow * sqrt(1 - self._keep**2)
        self._echo = False
        self.used = 0.0  # J taken from the power battery
        self.age = 0  # number of samples
        self.waves: Waves | None = None

    # --- what the control loops read -------------------------------------------------------

    def depth(self, plant: Plant) -> float:
        depth = plant.depth + self.depth_bias
        if not (self.health or self.bent or self.wrong):
            return depth
        known = Sensor.DEPTH not in self.health and 4 not in self.wrong
        return self._as_bent(4, depth) if known else self.last[4]

    def felt(self, plant: Plant, now: float) -> Felt:
        """What the sensors feel of the waves at the vehicle's depth."""
        return felt(self.waves, now, plant.depth)

    def altitude(self, plant: Plant) -> float:
        if not self._echo or 5 in self.wrong or (self.health and Sensor.ALTITUDE in self.health):
            return self.last[5]
        return plant.floor - plant.depth

    def heading(self, plant: Plant) -> float:
        """rad, not wrapped."""
        heading = plant.yaw + self._heading_error
        if not (self.health or self.bent or self.wrong):
            return heading
        known = Sensor.HEADING not in self.health and 2 not in self.wrong
        return self._as_bent(2, heading) if known else self.last[2]

    # --- what is reported ------------------------------------------------------------------

    def sample(self, plant: Plant, now: float = 0.0) -> list[float]:
        """Return roll, pitch, heading, temperature (deg C), depth, altitude, 9 x T, 2 x V."""
        errors = self.errors
        self._slow = self._keep * self._slow + self.rng.gauss(0.0, self._renew)
        yaw = plant.yaw
        deviation = errors.deviation * (sin(yaw) + 0.5 * cos(2 * yaw))
        error = -self.declination + self.compass_bias + self._slow + deviation
        self._heading_error = error
        noise, height = errors.attitude_noise, plant.floor - plant.depth
        self._echo = height < errors.altitude_range and self.rng.random() >= errors.altitude_drop
        high, roll, pitch, compass, warm, deep, *magnetic = normals(self.rng, 15)
        values = [
            _half_circle(plant.roll + roll * noise),
            plant.pitch + pitch * noise,
            (yaw + error + compass * errors.compass_noise) % TWO_PI,
            warmth(errors, plant.depth) + warm * errors.temperature_noise,
            plant.depth + self.depth_bias + deep * errors.depth_noise,
            height + high * errors.altitude_noise if self._echo else self._without(5),
            *self._magnetic(plant, magnetic),
            *self._batteries(plant),
        ]
        if self.waves is not None:
            self._rock(values, self.felt(plant, now))
        for slot in self.bent:
            values[slot] = self._as_bent(slot, values[slot])
        for slot, wrong in self.wrong.items():
            values[slot] = wrong.says(values[slot], self.age * PERIOD, self.rng)
        if self.health:
            self._break(values)
        self.last = values
        return values

    def _rock(self, values: list[float], by: Felt) -> None:
        values[0] = _half_circle(values[0] + by.roll)
        values[1] += by.pitch
        values[2] = (values[2] + turned(by)) % TWO_PI
        values[4] += by.head

    def _without(self, slot: int) -> float:
        return self.last[slot] if self._silent is Health.FROZEN else nan

    def _as_bent(self, slot: int, value: float) -> float:
        factor, offset = self.bent.get(slot, (1.0, 0.0))
        return factor * value + offset

    def _break(self, values: list[float]) -> None:
        for sensor, health in self.health.items():
            known = health if health is not Health.SILENT else self._silent
            if known is Health.INTERMITTENT:
                if self.rng.random() < 0.5:
                    continue
                known = Health.FROZEN
            for slot in sensor.value:
                if known is Health.FROZEN:
                    values[slot] = self.last[slot]
                elif known is Health.SILENT:
                    values[slot] = nan
                elif known is Health.FULL_SCALE:
                    values[slot] = FULL_SCALE[sensor]
                else:
                    values[slot] = FULL_SCALE[sensor] * (2 * self.rng.random() - 1)

    def _magnetic(self, plant: Plant, normal: list[float]) -> list[float]:
        """Earth's field in body axes, T, three times, each with its own noise."""
        magnetic = plant.yaw - self.declination
        ahead, across = FIELD_NORTH * cos(magnetic), -FIELD_NORTH * sin(magnetic)
        sp, cp, sr, cr = sin(plant.pitch), cos(plant.pitch), sin(plant.roll), cos(plant.roll)
        lean = ahead * sp + FIELD_DOWN * cp
        x, y, z = ahead * cp - FIELD_DOWN * sp, across * cr + lean * sr, lean * cr - across * sr
        noise, n = self.errors.magnetic_noise, normal
        return [
            *(x + n[0] * noise, y + n[1] * noise, z + n[2] * noise),
            *(x + n[3] * noise, y + n[4] * noise, z + n[5] * noise),
            *(x + n[6] * noise, y + n[7] * noise, z + n[8] * noise),
        ]

    def _batteries(self, plant: Plant) -> tuple[float, float]:
        """Voltages: control battery (300 Wh, load 35 W), power battery (900 Wh, thrusters)."""
        body, thrust = plant.body, plant.thrust
        port, starboard, rear, left, right = thrust
        pair = (abs(port) + abs(starboard)) / (2 * body.main_thrust)
        three = (abs(rear) + abs(left) + abs(right)) / (3 * body.vertical_thrust)
        self.used += PERIOD * (600.0 * pair * sqrt(pair) + 300.0 * three)
        self.age += 1
        control = 12.8 - 2.5 * self.age * PERIOD * 35.0 / (300.0 * 3600.0)
        if self.battery_override is not None:
            control = self.battery_override
            if self.battery_noise:
                control += self.rng.gauss(0.0, self.battery_noise)
        return max(control, 0.0), max(50.0 - 9.0 * self.used / (900.0 * 3600.0), 0.0)
