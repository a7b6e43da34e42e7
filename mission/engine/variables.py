"""What a guard may ask about: one row per variable, with unit, greatest age and how it is read.

A row is a name of the mission texts. ``unit`` is what a bare number means (mission.model.units);
``source`` is the sensor, or sensors, without which the variable is never known; ``max_age`` is
the age in s beyond which its reading is stale, and comparisons with it unknown (inf: it is
estimated on, and its sigma grows). ``read`` gives the SI value or None, ``sigma`` one standard
deviation, ``share`` the share of the distribution that fulfils a comparison where that is not one
normal variable. ``heading`` is the vehicle's own compass, as a leg's ``heading`` is; ``course``
and ``bearing`` count from true north.

What does not live here: comparisons and Kleene's logic (guards), how a text is read
(mission.authoring.language), whether a sensor is to be believed (navigation).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Protocol

from mission.legs.base import Track, wrap
from mission.model import Back, Estimate, Health, NavigationMode, Reading, Trend
from mission.model.tables import Table
from mission.model.vehicle import REPORTS, STALE_AFTER
from mission.navigation import distribution
from protocol.messages import Telemetry
from protocol.vehicles.channels import Source

CLOCK = "clock"
SOURCES = REPORTS | {CLOCK}  # what a variable may be known by

_TRACK = ("heading", "position")  # what dead reckoning needs


class Recall(Protocol):
    """What is remembered of readings, in SI; None: not known (mission.engine.memory)."""

    def extreme(self, trend: Trend) -> float | None: ...

    def peak(self, back: Back) -> float | None: ...


@dataclass(slots=True)
class Scope:
    """Everything a reading can be taken from, at one instant. ``track`` is the leg's own."""

    now: float
    estimate: Estimate | None
    telemetry: Telemetry | None
    health: Callable[[str], Health]
    entered: float  # when the leg began
    started: float  # when the mission began
    travelled: float
    round: int
    track: Callable[[], Track | None]
    memory: Recall | None = None


Value = float | None
Read = Callable[[Scope], Value]


def _certain(scope: Scope) -> float:
    return 0.0


@dataclass(frozen=True, slots=True)
class Variable:
    """``circular`` values are compared by their difference, -180..180 deg. ``timed`` ones grow by
    1 a second, so that it can be foretold when a comparison changes. ``trial`` is a guard that the
    campaign flies with what it waits for withheld ("": no vehicle of ours knows the variable);
    ``draw`` makes a random one, for a mission that goes to so many m."""

    name: str
    unit: str  # "" for a pure number; "deg" is rad inside
    source: tuple[str, ...]
    max_age: float  # s
    description: str
    circular: bool = False
    read: Read = lambda scope: None
    sigma: Callable[[Scope], float] = _certain
    share: Callable[[Scope, float], Value] | None = None  # of the part not above the bound
    timed: bool = False
    trial: str = ""
    draw: Callable[[Random, int], str] | None = None


# --- readings ------------------------------------------------------------------------------


def _estimated(name: str) -> Read:
    def read(scope: Scope) -> Value:
        value: Value = getattr(scope.estimate, name, None)
        return value

    return read


def _located(scope: Scope) -> Estimate | None:
    estimate = scope.estimate
    if estimate is None or estimate.mode is NavigationMode.NONE:
        return None
    return estimate


def _position(name: str) -> Read:
    def read(scope: Scope) -> Value:
        value: Value = getattr(_located(scope), name, None)
        return value

    return read


def _reported(name: str) -> Read:
    def read(scope: Scope) -> Value:
        value: Value = getattr(scope.telemetry, name, None)
        return value

    return read


def _battery(index: int) -> Read:
    def read(scope: Scope) -> Value:
        batteries = scope.telemetry.batteries if scope.telemetry else None
        return batteries[index] if batteries and index < len(batteries) else None

    return read


def _leak(scope: Scope) -> Value:
    leak = scope.telemetry.leak if scope.telemetry else None
    return None if leak is None else float(leak)


def _ground(scope: Scope) -> tuple[float, float] | None:
    """Velocity over ground, north and east."""
    e = scope.estimate
    if e is None or e.heading is None:
        return None
    north = e.speed * math.cos(e.heading) + e.current_north
    return north, e.speed * math.sin(e.heading) + e.current_east


def ground_speed(scope: Scope) -> Value:
    velocity = _ground(scope)
    return None if velocity is None else math.hypot(*velocity)


_SLOWEST_COURSE = 0.05  # m/s: below, what is left of the velocity has no direction


def _course(scope: Scope) -> Value:
    velocity = _ground(scope)
    if velocity is None or math.hypot(*velocity) < _SLOWEST_COURSE:
        return None
    return math.atan2(velocity[1], velocity[0]) % (2.0 * math.pi)


def _range(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else math.hypot(e.north, e.east)


def _bearing(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else math.atan2(-e.east, -e.north) % (2.0 * math.pi)


def _distance(scope: Scope) -> Value:
    track = scope.track() if _located(scope) else None
    return None if track is None else track.distance


def _cross_track(scope: Scope) -> Value:
    track = scope.track() if _located(scope) else None
    return None if track is None else track.cross_track


def _current(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else math.hypot(e.current_north, e.current_east)


_PLANE_95 = math.sqrt(-2.0 * math.log(0.05))  # radius in sigmas that holds 95 % in the plane


def _uncertainty(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else _PLANE_95 * distribution.principal(e.covariance)[0]


def _fix_age(scope: Scope) -> Value:
    e = scope.estimate
    if e is None or e.fix_age is None:
        return None
    return round(e.fix_age + scope.now - e.t, 6)


# Times are rounded to the microsecond, so that a deadline computed the other way round is met.
def _elapsed(scope: Scope) -> Value:
    return round(scope.now - scope.entered, 6)


def _mission_time(scope: Scope) -> Value:
    return round(scope.now - scope.started, 6)


# --- how sure ------------------------------------------------------------------------------


def _sigma(name: str) -> Callable[[Scope], float]:
    def sigma(scope: Scope) -> float:
        return scope.estimate.sigmas.get(name, 0.0) if scope.estimate else 0.0

    return sigma


def _toward(bearing: float) -> Callable[[Scope], float]:
    def sigma(scope: Scope) -> float:
        e = scope.estimate
        return distribution.along(e.covariance, bearing) if e else 0.0

    return sigma


def _greatest(scope: Scope) -> float:
    return distribution.principal(scope.estimate.covariance)[0] if scope.estimate else 0.0


def _bearing_sigma(scope: Scope) -> float:
    e, far = scope.estimate, _range(scope)
    if e is None or not far:
        return math.pi
    across = distribution.along(e.covariance, math.atan2(e.east, e.north) + math.pi / 2)
    return min(across / far, math.pi)


def _course_sigma(scope: Scope) -> float:
    speed = ground_speed(scope) or _SLOWEST_COURSE
    return min(math.hypot(_sigma("heading")(scope), _sigma("current")(scope) / speed), math.pi)


def _ground_speed_sigma(scope: Scope) -> float:
    return math.hypot(_sigma("speed")(scope), _sigma("current")(scope))


def _cross_sigma(scope: Scope) -> float:
    track = scope.track()
    return 0.0 if track is None else _toward(track.bearing + math.pi / 2)(scope)


def _range_share(scope: Scope, bound: float) -> Value:
    e = _located(scope)
    return None if e is None else distribution.within(bound, e.north, e.east, e.covariance)


def _distance_share(scope: Scope, bound: float) -> Value:
    e, track = _located(scope), scope.track()
    if e is None or track is None:
        return None
    north, east = (track.distance * f(track.ahead) for f in (math.cos, math.sin))
    return distribution.within(bound, north, east, e.covariance)


def _draw_range(rng: Random, deep: int) -> str:
    return f"range > {rng.randint(20, 300)}{rng.choice(['', ' sure 90%'])}"


def _draw_warmth(n: int) -> str:
    """Of what falls with the depth by 0.05 C a metre."""
    return f"temperature < {n}" if n % 2 else f"temperature falls {0.05 * n:g} within {n} m"


# fmt: off
_ROWS = (
    Variable("depth", "m", ("depth",), STALE_AFTER, "below the surface",
             read=_estimated("depth"), sigma=_sigma("depth"), trial="depth >= 3.5 held 2s",
             draw=lambda rng, deep: f"depth > {rng.randint(1, deep)}"),
    Variable("depth_rate", "m/s", ("depth",), STALE_AFTER, "change of depth, positive downward",
             read=_estimated("depth_rate"), sigma=_sigma("depth_rate"), trial="depth_rate > 2"),
    Variable("altitude", "m", ("altitude",), STALE_AFTER, "above the bottom",
             read=_estimated("altitude"), sigma=_sigma("altitude"), trial="altitude < 1 sure 90%",
             draw=lambda rng, deep: f"altitude < {rng.randint(1, 5)} sure 90%"),
    Variable("heading", "deg", ("heading",), STALE_AFTER, "where the bow points, 0 to 360", True,
             read=_reported("heading"), sigma=_sigma("heading"), trial="heading > 90"),
    Variable("course", "deg", _TRACK, math.inf, "where it goes over ground, 0 to 360", True,
             read=_course, sigma=_course_sigma, trial="course > 120"),
    Variable("pitch", "deg", ("attitude",), STALE_AFTER, "positive nose up",
             read=_reported("pitch"), trial="pitch > 60"),
    Variable("roll", "deg", ("attitude",), STALE_AFTER, "positive to starboard",
             read=_reported("roll"), trial="roll > 60"),
    Variable("speed", "m/s", (CLOCK,), STALE_AFTER, "through the water, estimated",
             read=_estimated("speed"), sigma=_sigma("speed"), trial="speed > 5"),
    Variable("ground_speed", "m/s", ("heading",), STALE_AFTER, "over ground, estimated",
             read=ground_speed, sigma=_ground_speed_sigma, trial="ground_speed > 5"),
    Variable("north", "m", _TRACK, math.inf, "position north of home",
             read=_position("north"), sigma=_toward(0.0), trial="north > 500"),
    Variable("east", "m", _TRACK, math.inf, "position east of home",
             read=_position("east"), sigma=_toward(math.pi / 2), trial="east > 500"),
    Variable("range", "m", _TRACK, math.inf, "distance from home",
             read=_range, sigma=_greatest, share=_range_share, trial="range > 500 sure 90%",
             draw=_draw_range),
    Variable("bearing", "deg", _TRACK, math.inf, "from the vehicle to home, 0 to 360", True,
             read=_bearing, sigma=_bearing_sigma, trial="bearing < 90 and range > 500"),
    Variable("distance", "m", _TRACK, math.inf, "to the place the leg goes to",
             read=_distance, sigma=_greatest, share=_distance_share, trial="distance > 500"),
    Variable("cross_track", "m", _TRACK, math.inf, "off the leg's line, positive to starboard",
             read=_cross_track, sigma=_cross_sigma, trial="cross_track > 500"),
    Variable("travelled", "m", ("heading",), STALE_AFTER, "path over ground since the leg began",
             read=lambda scope: scope.travelled, sigma=_greatest, trial="travelled >= 25",
             draw=lambda rng, deep: f"travelled >= {rng.randint(10, 200)}"),
    Variable("current", "m/s", _TRACK, math.inf, "speed of the estimated current",
             read=_current, sigma=_sigma("current"), trial="current > 3"),
    Variable("uncertainty", "m", (CLOCK,), math.inf, "radius that holds the position to 95 %",
             read=_uncertainty, trial="uncertainty > 900",
             draw=lambda rng, deep: f"uncertainty > {rng.randint(10, 100)}"),
    Variable("fix_age", "s", (CLOCK,), math.inf, "time since the last position fix",
             read=_fix_age, timed=True, trial="fix_age > 900"),
    Variable("temperature", "C", ("temperature",), 30.0, "of the water",
             read=_reported("temperature_c"), trial="temperature < -3",
             draw=lambda rng, deep: _draw_warmth(rng.randint(5, 20))),
    Variable("battery", "V", ("battery",), 30.0, "control battery", read=_battery(0),
             trial="battery < 1"),
    Variable("battery_power", "V", ("battery",), 30.0, "power battery", read=_battery(1),
             trial="battery_power < 1"),
    Variable("leak", "", ("leak",), STALE_AFTER, "1 when water was found inside, else 0",
             read=_leak),
    Variable("elapsed", "s", (CLOCK,), math.inf, "time since the leg began",
             read=_elapsed, timed=True, trial="elapsed > 30 held 5s",
             draw=lambda rng, deep: f"elapsed > {rng.randint(10, 200)}"),
    Variable("mission_time", "s", (CLOCK,), math.inf, "time since the mission was started",
             read=_mission_time, timed=True, trial="mission_time > 900"),
    Variable("round", "", (CLOCK,), math.inf, "round of the innermost repeated group, from 1",
             read=lambda scope: float(scope.round), trial="round > 900"),
)
# fmt: on


def _name_of(row: Variable) -> str:
    return row.name


VARIABLES: Table[str, Variable] = Table(_name_of, _ROWS)


def reading_row(name: str, source: Source) -> Variable:
    """A reading that the vehicle file names: stale like a report, and known by nothing else."""
    read = source.read
    return Variable(
        name,
        "",
        (CLOCK,),
        STALE_AFTER,
        source.meaning,
        read=lambda scope: None if scope.telemetry is None else read(scope.telemetry),
    )


def row_of(name: str, sources: Mapping[str, Source]) -> Variable:
    """``sources``: those of the vehicle's readings, by name."""
    source = sources.get(name)
    return VARIABLES[name] if source is None else reading_row(name, source)


def value_of(row: Variable, scope: Scope) -> Value:
    """None while the reading is not to be believed."""
    if row.max_age < math.inf and _doubt(row, scope):
        return None
    value = row.read(scope)
    return None if value is None or value != value else value


def _doubt(row: Variable, scope: Scope) -> str:
    """Why the sensors behind a row are not to be believed; "" if they are."""
    for sensor in row.source:
        if sensor == CLOCK:
            if scope.telemetry is None or scope.now - scope.telemetry.t > row.max_age:
                return "stale"
            continue
        health = scope.health(sensor)
        if not health.valid:
            return health.reason
        if health.age > row.max_age:
            return "stale"
    return ""


def reading_of(row: Variable, scope: Scope) -> Reading:
    """For people and records; the engine itself only needs ``value_of``."""
    value = value_of(row, scope)
    age = scope.now - scope.telemetry.t if scope.telemetry else math.inf
    if value is None:
        doubt = _doubt(row, scope) if row.max_age < math.inf else ""
        return Reading(math.nan, math.inf, age, False, doubt or "missing")
    return Reading(value, row.sigma(scope), age if row.max_age < math.inf else 0.0, True)


def difference(row: Variable, value: float, bound: float) -> float:
    """``value - bound``; for a circular variable the short way round."""
    return wrap(value - bound) if row.circular else value - bound
