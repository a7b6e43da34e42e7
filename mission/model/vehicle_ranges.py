"""The range of every number of a vehicle file, and pairs that must not contradict each other.

What does not live here: how the file is read (vehicle_file).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from mission.model.units import GEARS, quantity, range_text


@dataclass(frozen=True, slots=True)
class Range:
    """``low``..``high`` in ``unit``; ``above``: low itself is excluded."""

    unit: str
    low: float
    high: float
    above: bool = False

    def excludes(self, value: float) -> bool:
        """Whether ``value`` (SI) is out of range."""
        low, high = (quantity(bound, self.unit) for bound in (self.low, self.high))
        return not ((low < value if self.above else low <= value) and value <= high)

    @property
    def text(self) -> str:
        return range_text(self.low, self.high, self.unit, self.above)


_DEEPEST = 990.0  # m: a limit acts beyond its depth, and navigation believes depths up to 1000 m
_RISE = Range("m/s", 0.01, 1.0)  # navigation does not believe a depth that changes faster
_SIGMA = Range("m", 0.001, 100)
_ANGLE = Range("deg", 0, 90)
_LAG = Range("s", 0, 600)
_TIME = Range("s", 0, 1e6, above=True)
_FLOW = Range("m/s", 0, 5)
_ADDED_SPEED = Range("m/s", 0.001, 5)
_DRIFT = Range("m/s", -5, 5)
_POWER = Range("W", 0, 1e5)
GEAR = Range("", 0, GEARS)
_HARMONIC = Range("deg", -60, 60)

# Every number of a vehicle file by its full, dotted key.
RANGES: Mapping[str, Range] = MappingProxyType(
    {
        "limits.radius": Range("m", 1, 100_000),
        "limits.time": Range("min", 0, 65_535, above=True),
        "limits.depth": Range("m", 0, _DEEPEST, above=True),
        "limits.voltage": Range("V", 0, 1000),
        "limits.descent_rate": Range("m/s", 0.01, 1.25),
        "limits.roll": Range("deg", 5, 180),
        "stale_after": Range("s", 0.1, 60),
        "battery_scale.control": Range("", 0, 1000, above=True),
        "battery_scale.power": Range("", 0, 1000, above=True),
        "speed_by_gear": Range("m/s", 0, 20),
        "dive_rate": _RISE,
        "ascent_buoyancy": Range("m/s", -10, 1),  # of a heavy vehicle, too: it is measured
        "ascent_thrust": _RISE,
        "turn_rate": Range("deg/s", 0.1, 360),
        "current": _FLOW,
        "reckoning": _FLOW,
        "battery.usable": Range("Wh", 0, 1e6, above=True),
        "battery.hotel": _POWER,
        "battery.vertical": _POWER,
        "thruster_power": _POWER,
        "sensors.depth": _SIGMA,
        "sensors.altitude": _SIGMA,
        "sensors.heading": Range("deg", 0.01, 90),
        "sensors.heading_bias": _ANGLE,
        "sensors.fix": Range("m", 0.01, 1000),
        "sensors.telemetry_period": Range("s", 0.01, 60),
        "added.water": _ADDED_SPEED,
        "added.ground": _ADDED_SPEED,
        "added.place": Range("m", 0.01, 1000),
        "added.range": Range("m", 0.01, 1000),
        "compass.declination": Range("deg", -180, 180),
        "compass.bias_deg": Range("deg", -180, 180),
        "calibration.speed_scale": Range("", 0.2, 5),
        "calibration.speed_scale_sigma": Range("", 0.001, 1),
        "calibration.speed_noise": _FLOW,
        "calibration.speed_time": _TIME,
        "calibration.surge_length": Range("m", 0, 1000, above=True),
        "calibration.turn_slip": _LAG,
        "calibration.turn_slip_time": _TIME,
        "calibration.sway_noise": Range("", 0, 1),
        "calibration.turn_loss": _LAG,
        "calibration.deviation_sigma": _ANGLE,
        "calibration.compass_wander": _ANGLE,
        "calibration.compass_wander_time": _TIME,
        "calibration.current_sigma": _FLOW,
        "calibration.current_time": _TIME,
        "calibration.current_time_for": Range("s", 0, 1e6),
        "calibration.surface_drift": _FLOW,
        "calibration.fix_velocity": Range("m/s", 0.001, 5),
        "calibration.deviation.sin1": _HARMONIC,
        "calibration.deviation.cos1": _HARMONIC,
        "calibration.deviation.sin2": _HARMONIC,
        "calibration.deviation.cos2": _HARMONIC,
        **{
            f"outer_loop.{axis}.{key}": Range("", low, high)
            for axis in ("depth", "heading")
            for key, low, high in (
                ("gain", 0, 20),
                ("rate", 0, 20),
                ("integral", 0, 5),
                ("integral_most", 0, 1),
                ("trim", -1, 1),
                ("most", 0.01, 1),
            )
        },
        "calibration.current.north": _DRIFT,
        "calibration.current.east": _DRIFT,
    }
)


@dataclass(frozen=True, slots=True)
class Together:
    """Two numbers: ``more`` must be above ``less``, or may be ``equal`` to it."""

    less: str
    more: str
    why: str
    equal: bool = True


TOGETHER = (
    Together("ascent_buoyancy", "ascent_thrust", "thrust is added to the buoyancy"),
    Together("dive_rate", "limits.descent_rate", "each dive would be an unexplained descent",
             equal=False),
    Together("sensors.telemetry_period", "stale_after", "each report would be too old to believe",
             equal=False),
)  # fmt: skip
