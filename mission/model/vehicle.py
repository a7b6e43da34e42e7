"""The vehicle file: limits, rates, calibration, dialect, and what the vehicle reports and can do.

    VehicleError      (the author of the vehicle file must act; says the key and what to write)

What does not live here: how the file is read and the range of each number (vehicle_file), frames
and dialects themselves (protocol.vehicles).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field

from mission.model.diagnostics import Diagnosed
from mission.model.plain import UNSAID
from mission.model.units import GEARS

TIDE = 12.0 * 3600.0  # s, correlation time of a current
# All that a vehicle can report, and (FOLLOWS) all axes that it can control: keys of these tables.
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
SAMPLED = 0.9  # s between two samples at least: a fast board repeats each value of its sensor
STALE_AFTER = 6.0  # s: three reports missed (design: readings are three-valued)
FOLLOWS = frozenset({"surge", "turn", "heave", "heading", "depth", "altitude", "attitude"})


class VehicleError(Diagnosed):
    """A vehicle file cannot be used."""


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
    """A piecewise linear table, constant beyond its ends; ``x`` rises, ``y`` does not fall."""

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
        """Return the smallest x that reaches y (constant beyond the ends)."""
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
    """How the vehicle moves and errs, besides the planning figures; `calibrate` writes this.

    ``current`` is what earlier dives found in these waters (north, east), m/s. ``current_sigma`` is
    how far it is from that on another day; None: the vehicle's planning figure. ``turn_loss`` is
    the share of the speed lost, ``turn_slip`` the share that goes outward, per rad/s of turn.
    """

    speed_scale: float = 1.0  # on speed_by_gear
    speed_scale_sigma: float = 0.1
    speed_noise: float = 0.05  # m/s, slow
    speed_time: float = 30.0  # s, how slow
    surge_length: float = 2.0  # m: mass over drag
    turn_slip: float = 0.0  # s
    turn_slip_time: float = 6.0  # s, in which the slip builds up, and fades again
    sway_noise: float = 0.03  # share of the speed, fast, to either side
    turn_loss: float = 0.0  # s
    deviation: Deviation = Deviation()
    deviation_sigma: float = math.radians(2.0)  # of the rest beyond the harmonics
    compass_wander: float = math.radians(1.0)  # comes and goes within compass_wander_time
    compass_wander_time: float = 300.0  # s
    current: tuple[float, float] = (0.0, 0.0)
    current_sigma: float | None = None
    current_time: float = TIDE  # s, its correlation time for the time after a fix
    current_time_for: float = 0.0  # s, that time; later it is 12 h, the pace of a tide
    surface_drift: float = 0.03  # m/s per axis, by wind and waves
    fix_velocity: float = 0.1  # m/s per axis, of a receiver's speed and course


@dataclass(frozen=True, slots=True)
class Output:
    """Something besides the motion that legs and operators set, in ``unit``, by its ``name``.

    ``safe``: its value from the start, in every emergency, and after the mission that held it.
    ``needed``: what it would take away, so that no mission may set it ("": nothing).
    ``excludes``: axes of a setpoint beside which it stays at rest. ``choices``: its possible
    values, if not all between the bounds are. ``irreversible``: only operators may set it, and no
    emergency does; but an ascent that gains nothing sets it to ``ascent``, if given.
    """

    name: str
    channel: str
    low: float
    high: float
    safe: float
    unit: str = ""
    whole: bool = False
    needed: str = ""
    excludes: tuple[str, ...] = ()
    irreversible: bool = False
    ascent: float | None = None
    choices: tuple[float, ...] = ()

    def fault(self, value: float) -> str:
        """Return why it cannot have this value, "" if it can."""
        said = f"{self.name} {value:.9g}"
        if not self.low <= value <= self.high:
            return f"{said} is outside {self.low:.9g} to {self.high:.9g} {self.unit}".rstrip()
        if self.whole and value != int(value):
            return f"{said} is not a whole number"
        if self.choices and value not in self.choices:
            return f"{said} is none of {', '.join(f'{c:g}' for c in self.choices)}"
        return ""


@dataclass(frozen=True, slots=True)
class AxisLoop:
    """A control loop on the Pi: the effort (share of full) by error, rate and integral, plus the
    constant ``trim``. Errors and rates: m and m/s for depth, rad and rad/s for heading."""

    gain: float
    rate: float
    integral: float
    integral_most: float
    trim: float
    most: float


@dataclass(frozen=True, slots=True)
class Beacon:
    """An acoustic beacon at a known place: rad, m. ``sound``: speed of sound from it, m/s."""

    latitude: float
    longitude: float
    depth: float
    sound: float = 1500.0


CLOSED = ("depth", "heading")  # the axes of an outer loop
CLOSED_S = 0.5  # s: if the report of one is older, the Pi sends neutral (R17)


@dataclass(frozen=True, slots=True)
class OuterLoop:
    """For a board that takes only efforts. ``confirmed``: the day (YYYY-MM-DD) on which somebody
    saw that axes and signs are as we read them; "": nobody has, and nothing is held."""

    depth: AxisLoop
    heading: AxisLoop
    confirmed: str = ""


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
    ascent_buoyancy: float  # m/s with nothing turning; 0 or less: it does not rise
    ascent_thrust: float
    turn_rate: float
    current: float
    battery: Battery
    thruster_power: Curve
    sensors: Sensors
    declination: float | None  # rad; None: from the world magnetic model
    compass_bias: float  # rad
    calibration: Calibration = Calibration()
    ascent_measured: str = ""  # YYYY-MM-DD of the float test; "": ascent_buoyancy is planned
    stale_after: float = STALE_AFTER  # s: an older report is not believed
    glides: bool = False  # no thruster: moves forward by sinking and rising
    drives: bool = False  # on the ground: it always counts as at the surface
    wire: Mapping[str, str] = field(default_factory=dict)  # what its document leaves open
    outer_loop: OuterLoop | None = None  # holds depth and heading if the board does not
    outputs: tuple[Output, ...] = ()
    readings: Mapping[str, str] = field(default_factory=dict)  # guards' names -> sources
    added: Mapping[str, float] = field(  # one sigma of added sensors, by kind
        default_factory=dict, metadata=UNSAID
    )
    beacons: Mapping[str, Beacon] = field(default_factory=dict, metadata=UNSAID)  # by number
    reckoning: float | None = field(default=None, metadata=UNSAID)  # m/s, drift of its own position

    @property
    def reckoned(self) -> float:
        """How fast the vehicle's own position drifts under water, m/s: as if it saw no current,
        unless the vehicle file says less or more."""
        return self.current if self.reckoning is None else self.reckoning

    def output(self, name: str) -> Output | None:
        return next((output for output in self.outputs if output.name == name), None)

    @property
    def safe_levels(self) -> Mapping[str, float]:
        """The value of every output that nobody has set, by channel."""
        return {output.channel: output.safe for output in self.outputs}

    def gear_near(self, speed: float) -> int:
        """The gear whose speed is nearest to ``speed`` (m/s), the lower of two."""
        curve = self.speed_by_gear
        return min(range(GEARS + 1), key=lambda gear: (abs(curve.at(gear) - speed), gear))

    @property
    def speaks(
        self,
    ) -> tuple[str, str, Mapping[str, str], tuple[float, float], Mapping[str, str]]:
        """The arguments from which ``protocol.vehicles.codec`` makes the codec."""
        return self.codec, self.dialect, self.tolerances, self.battery_scale, self.wire
