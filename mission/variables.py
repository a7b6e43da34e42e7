"""What a guard may ask about: one row per variable, with its unit and how old it may be.

A row is a name of the mission texts. ``unit`` is what a bare number means (mission.units);
``source`` is the sensor, or sensors, without which the variable is never known; ``max_age`` is
the age in s beyond which its reading is stale, and comparisons with it unknown.

What does not live here: comparisons and Kleene's logic (the engine), how a text is read
(mission.language).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

# What a vehicle can report at all; the names of a vehicle file's ``reports``, and the clock.
CLOCK = "clock"
SOURCES = frozenset(
    {
        CLOCK,
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

_TRACK = ("heading", "position")  # what dead reckoning needs
_TELEMETRY = 6.0  # s: three reports of the vehicle missed (design: readings are three-valued)


@dataclass(frozen=True, slots=True)
class Variable:
    """``circular`` values are compared by their difference, -180..180 deg."""

    name: str
    unit: str  # "" for a pure number; "deg" is rad inside
    source: tuple[str, ...]
    max_age: float  # s
    description: str
    circular: bool = False


# fmt: off
_ROWS = (
    Variable("depth", "m", ("depth",), _TELEMETRY, "below the surface"),
    Variable("depth_rate", "m/s", ("depth",), _TELEMETRY, "change of depth, positive downward"),
    Variable("altitude", "m", ("altitude",), _TELEMETRY, "above the bottom"),
    Variable("heading", "deg", ("heading",), _TELEMETRY, "where the bow points, 0 to 360", True),
    Variable("course", "deg", _TRACK, math.inf, "where it goes over ground, 0 to 360", True),
    Variable("pitch", "deg", ("attitude",), _TELEMETRY, "positive nose up"),
    Variable("roll", "deg", ("attitude",), _TELEMETRY, "positive to starboard"),
    Variable("speed", "m/s", (CLOCK,), _TELEMETRY, "through the water, estimated"),
    Variable("ground_speed", "m/s", ("heading",), _TELEMETRY, "over ground, estimated"),
    Variable("north", "m", _TRACK, math.inf, "position north of home"),
    Variable("east", "m", _TRACK, math.inf, "position east of home"),
    Variable("range", "m", _TRACK, math.inf, "distance from home"),
    Variable("bearing", "deg", _TRACK, math.inf, "from the vehicle to home, 0 to 360", True),
    Variable("distance", "m", _TRACK, math.inf, "to the place the leg goes to"),
    Variable("cross_track", "m", _TRACK, math.inf, "off the leg's line, positive to starboard"),
    Variable("travelled", "m", ("heading",), _TELEMETRY, "path over ground since the leg began"),
    Variable("current", "m/s", _TRACK, math.inf, "speed of the estimated current"),
    Variable("uncertainty", "m", (CLOCK,), math.inf, "radius that holds the position to 95 %"),
    Variable("fix_age", "s", (CLOCK,), math.inf, "time since the last position fix"),
    Variable("temperature", "C", ("temperature",), 30.0, "of the water"),
    Variable("battery", "V", ("battery",), 30.0, "control battery"),
    Variable("battery_power", "V", ("battery",), 30.0, "power battery"),
    Variable("leak", "", ("leak",), _TELEMETRY, "1 when water was found inside, else 0"),
    Variable("elapsed", "s", (CLOCK,), math.inf, "time since the leg began"),
    Variable("mission_time", "s", (CLOCK,), math.inf, "time since the mission was started"),
    Variable("round", "", (CLOCK,), math.inf, "round of the innermost repeated group, from 1"),
)
# fmt: on
VARIABLES: Mapping[str, Variable] = MappingProxyType({row.name: row for row in _ROWS})
