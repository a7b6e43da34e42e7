"""The vehicle file: limits, rates, calibration, dialect, and what the vehicle can tell and do.

    VehicleError      (the author of the vehicle file must act; says key and what instead)

A key that nobody knows is refused: a misspelt ``depth`` under ``reports`` would disarm the limits
of depth without a word.

What does not live here: frames and dialects themselves (protocol.vehicles).
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from mission.units import UnitError, quantity
from protocol.vehicles import codec

# What a vehicle can report, and the axes it can follow, at all: the keys of those two tables.
REPORTS = frozenset(
    {
        "depth",
        "altitude",
        "heading",
        "attitude",
        "temperature",
        "battery",
        "leak",
        "position",
    }
)
STALE_AFTER = 6.0  # s: three reports missed (design: readings are three-valued)
FOLLOWS = frozenset({"surge", "turn", "heave", "heading", "depth", "altitude", "attitude"})


class VehicleError(ValueError):
    """A vehicle file cannot be used; the message names file, key and remedy."""


@dataclass(frozen=True, slots=True)
class HardLimits:
    radius: float
    time: float
    depth: float
    voltage: float
    descent_rate: float
    roll: float


@dataclass(frozen=True, slots=True)
class Curve:
    """A piecewise linear table, held at its ends; ``x`` rises strictly, ``y`` does not fall."""

    x: tuple[float, ...]
    y: tuple[float, ...]

    def at(self, x: float) -> float:
        if x <= self.x[0]:
            return self.y[0]
        if x >= self.x[-1]:
            return self.y[-1]
        i = bisect_right(self.x, x)
        share = (x - self.x[i - 1]) / (self.x[i] - self.x[i - 1])
        return self.y[i - 1] + share * (self.y[i] - self.y[i - 1])

    def inverse(self, y: float) -> float:
        """The smallest x that reaches y (held at the ends)."""
        for i in range(1, len(self.x)):
            if self.y[i] >= y > self.y[i - 1]:
                share = (y - self.y[i - 1]) / (self.y[i] - self.y[i - 1])
                return self.x[i - 1] + share * (self.x[i] - self.x[i - 1])
        return self.x[0] if y <= self.y[0] else self.x[-1]


@dataclass(frozen=True, slots=True)
class Battery:
    usable: float  # J
    hotel: float  # W
    vertical: float  # W while diving or thrusting up


@dataclass(frozen=True, slots=True)
class Sensors:
    """One sigma of each, and the period of the telemetry in s."""

    depth: float
    altitude: float
    heading: float
    heading_bias: float
    fix: float
    telemetry_period: float


@dataclass(frozen=True, slots=True)
class Deviation:
    """The compass's error over the magnetic heading it shows: the first two harmonics, rad."""

    sin1: float = 0.0
    cos1: float = 0.0
    sin2: float = 0.0
    cos2: float = 0.0

    def at(self, heading: float) -> float:
        return (
            self.sin1 * math.sin(heading)
            + self.cos1 * math.cos(heading)
            + self.sin2 * math.sin(2.0 * heading)
            + self.cos2 * math.cos(2.0 * heading)
        )


@dataclass(frozen=True, slots=True)
class Calibration:
    """How the vehicle moves and errs, beside the planning figures; what `calibrate` writes.

    ``current`` is what earlier dives found in these waters (north, east), ``current_sigma`` how
    far it is from that on another day; None: the vehicle's planning figure. ``turn_loss`` is the
    share of the speed lost, ``turn_slip`` the share of it that goes outward, per rad/s of turn.
    """

    speed_scale: float = 1.0  # on speed_by_gear
    speed_scale_sigma: float = 0.1
    speed_noise: float = 0.05  # m/s, slow
    speed_time: float = 30.0  # s, how slow
    surge_length: float = 2.0  # m: mass over drag
    turn_slip: float = 0.0  # s
    turn_slip_time: float = 6.0  # s, until the slip has come to it, and is gone again
    sway_noise: float = 0.03  # share of the speed, quick, to either side
    turn_loss: float = 0.0  # s
    deviation: Deviation = Deviation()
    deviation_sigma: float = math.radians(2.0)  # of what the harmonics leave
    compass_wander: float = math.radians(1.0)  # comes and goes within compass_wander_time
    compass_wander_time: float = 300.0  # s
    current: tuple[float, float] = (0.0, 0.0)
    current_sigma: float | None = None
    surface_drift: float = 0.03  # m/s per axis, by wind and waves


_CALIBRATION_UNITS = {
    "speed_scale": "",
    "speed_scale_sigma": "",
    "speed_noise": "m/s",
    "speed_time": "s",
    "surge_length": "m",
    "turn_slip": "s",
    "turn_slip_time": "s",
    "sway_noise": "",
    "turn_loss": "s",
    "deviation_sigma": "deg",
    "compass_wander": "deg",
    "compass_wander_time": "s",
    "current_sigma": "m/s",
    "surface_drift": "m/s",
}


@dataclass(frozen=True, slots=True)
class Vehicle:
    name: str
    codec: str
    dialect: str
    tolerances: Mapping[str, str]
    limits: HardLimits
    reports: frozenset[str]
    follows: frozenset[str]
    constant_batteries: bool
    battery_scale: tuple[float, float]
    one_speed: bool
    speed_by_gear: Curve
    dive_rate: float
    ascent_buoyancy: float
    ascent_thrust: float
    turn_rate: float
    current: float
    battery: Battery
    thruster_power: Curve
    sensors: Sensors
    declination: float | None  # rad; None: from the world magnetic model
    compass_bias: float  # rad
    calibration: Calibration = Calibration()
    stale_after: float = STALE_AFTER  # s: an older report is not believed
    glides: bool = False  # no thruster: moves forward by sinking and rising
    drives: bool = False  # on the ground: it is at the surface wherever it is


def missions_folder() -> Path:
    """The shipped missions/: in the wheel inside this package, in a checkout beside it."""
    here = Path(__file__).resolve().parent
    shipped = here / "missions"
    return shipped if shipped.is_dir() else here.parent / "missions"


def load_vehicle(name: str | Path) -> Vehicle:
    """A vehicle by the name of a shipped file or by path. Raises VehicleError."""
    import yaml  # a Pi without it still brings its vehicle up (serve: provision)

    path = Path(name)
    if path.suffix not in (".yaml", ".yml"):
        path = missions_folder() / "vehicles" / f"{name}.yaml"
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        known = ", ".join(sorted(p.stem for p in (missions_folder() / "vehicles").glob("*.yaml")))
        raise VehicleError(f"no vehicle file {path}; shipped ones: {known}") from None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise VehicleError(f"{path}: cannot be read: {error}") from error
    if not isinstance(data, dict):
        raise VehicleError(f"{path}: a vehicle file is a table of keys")
    return _vehicle(_Keys(str(path), data))


class _Keys:
    """Typed access to one table of the file; every failure names file and key."""

    def __init__(self, where: str, data: Mapping[Any, Any]) -> None:
        self.where, self.data = where, data

    def get(self, key: str) -> Any:
        if key not in self.data:
            raise VehicleError(f"{self.where}: the key {key} is missing")
        return self.data[key]

    def number(self, key: str, unit: str) -> float:
        try:
            return quantity(self.get(key), unit)
        except UnitError as error:
            raise VehicleError(f"{self.where}: {key}: {error}") from None

    def flag(self, key: str) -> bool:
        value = self.get(key)
        if not isinstance(value, bool):
            raise VehicleError(f"{self.where}: {key}: write true or false, not {value!r}")
        return value

    def text(self, key: str) -> str:
        return str(self.get(key))

    def table(self, key: str, known: Collection[str] | None = None) -> _Keys:
        """``known``: the keys it may have; None where any will do."""
        value = self.get(key)
        if not isinstance(value, dict):
            raise VehicleError(f"{self.where}: {key}: a table is needed, not {value!r}")
        table = _Keys(f"{self.where}: {key}", value)
        if known is not None:
            table.refuse_unknown(known)
        return table

    def refuse_unknown(self, known: Collection[str]) -> None:
        for key in self.data:
            if key not in known:
                raise VehicleError(
                    f"{self.where}: no key {key}; there are {', '.join(sorted(known))}"
                )

    def true_keys(self, key: str, known: Collection[str]) -> frozenset[str]:
        table = self.table(key, known)
        return frozenset(str(name) for name in table.data if table.flag(name))

    def curve(self, key: str, unit: str) -> Curve:
        table = self.table(key)
        try:
            rows = sorted((float(x), quantity(y, unit)) for x, y in table.data.items())
        except (UnitError, TypeError, ValueError) as error:
            raise VehicleError(f"{self.where}: {key}: {error}") from None
        if len(rows) < 2 or _falls([y for _, y in rows]):
            raise VehicleError(f"{self.where}: {key}: two or more rows that do not fall are needed")
        return Curve(tuple(x for x, _ in rows), tuple(y for _, y in rows))


def _falls(values: Sequence[float]) -> bool:
    return any(b < a for a, b in itertools.pairwise(values))


def _names(kind: type[Any]) -> set[str]:
    return {f.name for f in fields(kind)}


_TABLES = {"name": "vehicle", "declination": "compass", "compass_bias": "compass"}


def _vehicle(keys: _Keys) -> Vehicle:
    keys.refuse_unknown({_TABLES.get(name, name) for name in _names(Vehicle)})
    limits, sensors = (
        keys.table("limits", _names(HardLimits)),
        keys.table("sensors", _names(Sensors)),
    )
    compass = keys.table("compass", {"declination", "bias_deg"})
    battery = keys.table("battery", _names(Battery))
    scale = keys.table("battery_scale", {"control", "power"})
    declination = compass.get("declination")
    vehicle = Vehicle(
        name=keys.text("vehicle"),
        codec=keys.text("codec"),
        dialect=keys.text("dialect"),
        tolerances={str(k): str(v) for k, v in keys.table("tolerances").data.items()},
        limits=HardLimits(
            radius=limits.number("radius", "m"),
            time=limits.number("time", "min"),
            depth=limits.number("depth", "m"),
            voltage=limits.number("voltage", "V"),
            descent_rate=limits.number("descent_rate", "m/s"),
            roll=limits.number("roll", "deg"),
        ),
        reports=keys.true_keys("reports", REPORTS),
        follows=keys.true_keys("follows", FOLLOWS),
        constant_batteries=keys.flag("constant_batteries"),
        battery_scale=(scale.number("control", ""), scale.number("power", "")),
        one_speed=keys.flag("one_speed"),
        speed_by_gear=keys.curve("speed_by_gear", "m/s"),
        dive_rate=keys.number("dive_rate", "m/s"),
        ascent_buoyancy=keys.number("ascent_buoyancy", "m/s"),
        ascent_thrust=keys.number("ascent_thrust", "m/s"),
        turn_rate=keys.number("turn_rate", "deg/s"),
        current=keys.number("current", "m/s"),
        battery=Battery(
            usable=battery.number("usable", "Wh"),
            hotel=battery.number("hotel", "W"),
            vertical=battery.number("vertical", "W"),
        ),
        thruster_power=keys.curve("thruster_power", "W"),
        sensors=Sensors(
            depth=sensors.number("depth", "m"),
            altitude=sensors.number("altitude", "m"),
            heading=sensors.number("heading", "deg"),
            heading_bias=sensors.number("heading_bias", "deg"),
            fix=sensors.number("fix", "m"),
            telemetry_period=sensors.number("telemetry_period", "s"),
        ),
        declination=None if declination == "auto" else compass.number("declination", "deg"),
        compass_bias=compass.number("bias_deg", "deg"),
        calibration=_calibration(keys),
        stale_after=keys.number("stale_after", "s") if "stale_after" in keys.data else STALE_AFTER,
        glides=keys.flag("glides") if "glides" in keys.data else False,
        drives=keys.flag("drives") if "drives" in keys.data else False,
    )
    try:
        codec(vehicle.codec, vehicle.dialect, vehicle.tolerances)
    except ValueError as error:
        raise VehicleError(f"{keys.where}: codec: {error}") from None
    return vehicle


def _calibration(keys: _Keys) -> Calibration:
    """The optional section; what it leaves out keeps the default."""
    if "calibration" not in keys.data:
        return Calibration()
    table = keys.table("calibration", _names(Calibration))
    given: dict[str, Any] = {
        name: table.number(name, unit)
        for name, unit in _CALIBRATION_UNITS.items()
        if name in table.data
    }
    if "deviation" in table.data:
        harmonics = table.table("deviation", _names(Deviation))
        given["deviation"] = Deviation(
            **{str(k): harmonics.number(k, "deg") for k in harmonics.data}
        )
    if "current" in table.data:
        current = table.table("current", {"north", "east"})
        given["current"] = (current.number("north", "m/s"), current.number("east", "m/s"))
    return Calibration(**given)
