"""The variables of guards: one row each, with unit, greatest age and how it is read.

The name of a row stands in mission texts. ``unit``: of a number without one (mission.model.units).
``source``: the sensors without which the variable is never known. ``max_age``: the age in s beyond
which its reading is stale, and comparisons with it are unknown (inf: it is predicted, and its sigma
grows). ``read`` returns the SI value or None, ``sigma`` one standard deviation, ``share`` the share
of the distribution that fulfils a comparison, if the variable is not a single normal one.
``heading`` is by the vehicle's own compass, as a leg's ``heading`` is; ``course`` and ``bearing``
count from true north.

What does not live here: how a reading is taken (readings), comparisons and Kleene's logic (guards),
how a text is read (mission.authoring.language), whether a sensor is to be believed (navigation).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

from mission.engine.readings import (
    Read,
    Scope,
    Value,
    battery,
    bearing,
    bearing_sigma,
    course,
    course_sigma,
    cross_sigma,
    cross_track,
    current,
    distance,
    distance_share,
    elapsed,
    estimated,
    fix_age,
    greatest,
    ground_speed,
    ground_speed_sigma,
    leak,
    mission_time,
    position,
    range_home,
    range_share,
    reported,
    sigma_of,
    toward,
    uncertainty,
)
from mission.legs.base import wrap
from mission.model import Reading
from mission.model.tables import Table
from mission.model.vehicle import REPORTS, STALE_AFTER
from protocol.vehicles.channels import Source

CLOCK = "clock"
SOURCES = REPORTS | {CLOCK}  # the sources that a variable may have

_TRACK = ("heading", "position")  # what dead reckoning needs


def _certain(scope: Scope) -> float:
    return 0.0


@dataclass(frozen=True, slots=True)
class Variable:
    """``circular``: compared by the difference, -180..180 deg. ``timed``: grows by 1 per second, so
    that the time at which a comparison changes can be computed. ``trial``: a guard that the
    campaign flies while it withholds what the guard waits for ("": no vehicle here knows the
    variable). ``draw``: makes a random guard, for a mission that goes down to so many m."""

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


def _draw_range(rng: Random, deep: int) -> str:
    return f"range > {rng.randint(20, 300)}{rng.choice(['', ' sure 90%'])}"


def _draw_warmth(n: int) -> str:
    """A guard for a temperature that falls with the depth by 0.05 C per metre."""
    return f"temperature < {n}" if n % 2 else f"temperature falls {0.05 * n:g} within {n} m"


# fmt: off
_ROWS = (
    Variable("depth", "m", ("depth",), STALE_AFTER, "below the surface",
             read=estimated("depth"), sigma=sigma_of("depth"), trial="depth >= 3.5 held 2s",
             draw=lambda rng, deep: f"depth > {rng.randint(1, deep)}"),
    Variable("depth_rate", "m/s", ("depth",), STALE_AFTER, "change of depth, positive downward",
             read=estimated("depth_rate"), sigma=sigma_of("depth_rate"), trial="depth_rate > 2"),
    Variable("altitude", "m", ("altitude",), STALE_AFTER, "above the bottom",
             read=estimated("altitude"), sigma=sigma_of("altitude"), trial="altitude < 1 sure 90%",
             draw=lambda rng, deep: f"altitude < {rng.randint(1, 5)} sure 90%"),
    Variable("heading", "deg", ("heading",), STALE_AFTER, "where the bow points, 0 to 360", True,
             read=reported("heading"), sigma=sigma_of("heading"), trial="heading > 90"),
    Variable("course", "deg", _TRACK, math.inf, "where it goes over ground, 0 to 360", True,
             read=course, sigma=course_sigma, trial="course > 120"),
    Variable("pitch", "deg", ("attitude",), STALE_AFTER, "positive nose up",
             read=reported("pitch"), trial="pitch > 60"),
    Variable("roll", "deg", ("attitude",), STALE_AFTER, "positive to starboard",
             read=reported("roll"), trial="roll > 60"),
    Variable("speed", "m/s", (CLOCK,), STALE_AFTER, "through the water, estimated",
             read=estimated("speed"), sigma=sigma_of("speed"), trial="speed > 5"),
    Variable("ground_speed", "m/s", ("heading",), STALE_AFTER, "over ground, estimated",
             read=ground_speed, sigma=ground_speed_sigma, trial="ground_speed > 5"),
    Variable("north", "m", _TRACK, math.inf, "position north of home",
             read=position("north"), sigma=toward(0.0), trial="north > 500"),
    Variable("east", "m", _TRACK, math.inf, "position east of home",
             read=position("east"), sigma=toward(math.pi / 2), trial="east > 500"),
    Variable("range", "m", _TRACK, math.inf, "distance from home",
             read=range_home, sigma=greatest, share=range_share, trial="range > 500 sure 90%",
             draw=_draw_range),
    Variable("bearing", "deg", _TRACK, math.inf, "from the vehicle to home, 0 to 360", True,
             read=bearing, sigma=bearing_sigma, trial="bearing < 90 and range > 500"),
    Variable("distance", "m", _TRACK, math.inf, "to the place the leg goes to",
             read=distance, sigma=greatest, share=distance_share, trial="distance > 500"),
    Variable("cross_track", "m", _TRACK, math.inf, "off the leg's line, positive to starboard",
             read=cross_track, sigma=cross_sigma, trial="cross_track > 500"),
    Variable("travelled", "m", ("heading",), STALE_AFTER, "path over ground since the leg began",
             read=lambda scope: scope.travelled, sigma=greatest, trial="travelled >= 25",
             draw=lambda rng, deep: f"travelled >= {rng.randint(10, 200)}"),
    Variable("current", "m/s", _TRACK, math.inf, "speed of the estimated current",
             read=current, sigma=sigma_of("current"), trial="current > 3"),
    Variable("uncertainty", "m", (CLOCK,), math.inf, "radius that holds the position to 95 %",
             read=uncertainty, trial="uncertainty > 900",
             draw=lambda rng, deep: f"uncertainty > {rng.randint(10, 100)}"),
    Variable("fix_age", "s", (CLOCK,), math.inf, "time since the last position fix",
             read=fix_age, timed=True, trial="fix_age > 900"),
    Variable("temperature", "C", ("temperature",), 30.0, "of the water",
             read=reported("temperature_c"), trial="temperature < -3",
             draw=lambda rng, deep: _draw_warmth(rng.randint(5, 20))),
    Variable("battery", "V", ("battery",), 30.0, "control battery", read=battery(0),
             trial="battery < 1"),
    Variable("battery_power", "V", ("battery",), 30.0, "power battery", read=battery(1),
             trial="battery_power < 1"),
    Variable("leak", "", ("leak",), STALE_AFTER, "1 when water was found inside, else 0",
             read=leak),
    Variable("elapsed", "s", (CLOCK,), math.inf, "time since the leg began",
             read=elapsed, timed=True, trial="elapsed > 30 held 5s",
             draw=lambda rng, deep: f"elapsed > {rng.randint(10, 200)}"),
    Variable("mission_time", "s", (CLOCK,), math.inf, "time since the mission was started",
             read=mission_time, timed=True, trial="mission_time > 900"),
    Variable("round", "", (CLOCK,), math.inf, "round of the innermost repeated group, from 1",
             read=lambda scope: float(scope.round), trial="round > 900"),
)
# fmt: on


def _name_of(row: Variable) -> str:
    return row.name


VARIABLES: Table[str, Variable] = Table(_name_of, _ROWS)


def reading_row(name: str, source: Source) -> Variable:
    """The row of a reading that the vehicle file names: as stale as the report it comes from."""
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
    """The row of a name. ``sources``: the sources of the vehicle file's readings, by name."""
    source = sources.get(name)
    return VARIABLES[name] if source is None else reading_row(name, source)


def value_of(row: Variable, scope: Scope) -> Value:
    """The SI value of a variable; None while it is not believed."""
    if row.max_age < math.inf and _doubt(row, scope):
        return None
    value = row.read(scope)
    return None if value is None or value != value else value


def _doubt(row: Variable, scope: Scope) -> str:
    """Why the sensors behind a row are not believed; "" if they are."""
    for sensor in row.source:
        if sensor == CLOCK:
            age = math.inf if scope.telemetry is None else scope.now - scope.telemetry.t
            if age > min(row.max_age, scope.stale_after):
                return "stale"
            continue
        health = scope.health(sensor)
        if not health.valid:
            return health.reason
        if health.age > row.max_age:
            return "stale"
    return ""


def reading_of(row: Variable, scope: Scope) -> Reading:
    """The value with sigma and age, for operators and records; the engine uses ``value_of``."""
    value = value_of(row, scope)
    age = scope.now - scope.telemetry.t if scope.telemetry else math.inf
    if value is None:
        doubt = _doubt(row, scope) if row.max_age < math.inf else ""
        return Reading(math.nan, math.inf, age, False, doubt or "missing")
    return Reading(value, row.sigma(scope), age if row.max_age < math.inf else 0.0, True)


def difference(row: Variable, value: float, bound: float) -> float:
    """``value - bound``; for a circular variable the short way round."""
    return wrap(value - bound) if row.circular else value - bound
