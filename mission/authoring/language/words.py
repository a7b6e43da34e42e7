"""The words of both mission texts, as tables: a new word is a new row.

    SETTINGS    what a leg holds            depth 10      {depth: 10 m}
    ZA          the commands of the wire    ZAS10         (line script, and items of plain text)
    kinds()     what a leg does             goto home     {goto: home}
    measures(), spots(), choices()          within 15     {within: 15 m}
    LIMITS, ASSUMPTIONS, AIMS   names with values behind safety, assume and achieve

A word of the line script is also the key of the YAML form.
What does not live here: how clauses combine (grammar.lark), what they make (legs.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeVar

from mission.legs import LEGS, LegType
from mission.legs.words import Choice, Measure, Spot
from mission.model import Axis
from mission.model.tables import derived
from mission.model.units import GEARS

C = TypeVar("C", Measure, Spot, Choice)


@dataclass(frozen=True, slots=True)
class SettingRow:
    """A setting: ``low``..``high`` are in ``unit``; the field of the setpoint gets
    ``sign * value`` (for gears ``/ 12``)."""

    word: str
    field: str
    unit: str  # "" for a gear
    low: float
    high: float
    description: str
    sign: int = 1
    gear: bool = False


_SETTINGS = (
    SettingRow(
        "depth",
        "depth",
        "m",
        0,
        9999,
        "hold this depth below the surface, or `never below altitude 3`",
    ),
    SettingRow("altitude", "altitude", "m", 0, 9999, "hold this height above the bottom"),
    SettingRow("up", "heave", "", 0, GEARS, "vertical thrusters upward, by gear", -1, True),
    SettingRow("down", "heave", "", 0, GEARS, "vertical thrusters downward, by gear", 1, True),
    SettingRow("heading", "heading", "deg", 0, 360, "hold this heading, as a compass says it"),
    SettingRow("gear", "surge", "", -GEARS, GEARS, "ahead by gear; negative: back", 1, True),
    SettingRow("speed", "surge", "m/s", 0, 20, "ahead, by the gear nearest to this speed"),
    SettingRow("left", "turn", "", 0, GEARS, "turn to port, by gear", -1, True),
    SettingRow("right", "turn", "", 0, GEARS, "turn to starboard, by gear", 1, True),
    SettingRow("pitch", "pitch", "deg", -90, 90, "hold this pitch, nose up positive"),
    SettingRow("roll", "roll", "deg", -90, 90, "hold this roll, positive to starboard"),
)
SETTINGS: Mapping[str, SettingRow] = MappingProxyType({row.word: row for row in _SETTINGS})
STOP = "stop"  # surge 0, the same as gear 0

# The order of a leg's settings, in the model and in every text made from it.
FIELD_ORDER = ("depth", "altitude", "heave", "heading", "surge", "turn", "pitch", "roll")
VERTICAL = frozenset({"depth", "altitude", "heave"})
GUARDED = frozenset({"depth", "altitude"})  # one setting together, as in depth never below altitude
STEERING = frozenset({"heading", "turn"})


@dataclass(frozen=True, slots=True)
class WireRow:
    """A code of ``ZA``: whole numbers from ``low`` to ``high`` become the setting ``word``.

    ``sign`` is -1 where the wire counts the other way (ZAB4 is gear -4; ZAH90 is west).
    """

    code: str
    word: str
    low: int
    high: int
    description: str
    sign: int = 1


_ZA = (
    WireRow("F", "gear", 0, GEARS, "forward"),
    WireRow("B", "gear", 0, GEARS, "back", -1),
    WireRow("L", "left", 0, GEARS, "turn left"),
    WireRow("R", "right", 0, GEARS, "turn right"),
    WireRow("U", "up", 0, GEARS, "up"),
    WireRow("D", "down", 0, GEARS, "down"),
    WireRow("S", "depth", 0, 9999, "depth in m"),
    WireRow("E", "altitude", 0, 9999, "altitude in m"),
    WireRow("H", "heading", -180, 180, "heading in deg, positive to WEST: ZAH-90 is east", -1),
)
ZA: Mapping[str, WireRow] = MappingProxyType({row.code: row for row in _ZA})
ATTITUDE = "A"  # ZAA5;-3: pitch, then roll

# Codes that a mission may not use, and what to write instead.
REFUSED_ZA: Mapping[str, str] = MappingProxyType(
    {
        "V": "the vehicle has no speed sensor and refuses it; write speed 0.5 m/s, or gear 6",
        "X": "the emergency stop is the operator's; write stop",
        "W": "the emergency surfacing is the operator's; write surface",
    }
)


# The kinds of legs are a table of their own (mission.legs); these are its words.
HOLD = "hold"  # the kind of a leg that names no other


@derived(LEGS)
def kinds() -> Mapping[str, LegType]:
    return MappingProxyType({row.name: row for row in LEGS.values()})


@derived(LEGS)
def measures() -> Mapping[str, Measure]:
    return _clauses(Measure)


@derived(LEGS)
def spots() -> Mapping[str, Spot]:
    return _clauses(Spot)


@derived(LEGS)
def choices() -> Mapping[str, Choice]:
    return _clauses(Choice)


def _clauses(kind: type[C]) -> Mapping[str, C]:
    found = [c for row in LEGS.values() for c in row.clauses if isinstance(c, kind)]
    return MappingProxyType({clause.word: clause for clause in found})


@derived(LEGS)
def leg_words() -> tuple[str, ...]:
    """Every word that a leg may have; these are the keys of a YAML leg, too."""
    own = (*kinds(), *measures(), *spots(), *choices())
    return (*SETTINGS, STOP, *own, *CLAUSES)


_FIELDS: Mapping[Axis, frozenset[str]] = MappingProxyType(
    {
        Axis.HORIZONTAL: frozenset({"surge", "turn"}),
        Axis.HEADING: STEERING,
        Axis.VERTICAL: VERTICAL,
        Axis.ATTITUDE: frozenset({"pitch", "roll"}),
    }
)


def steered(row: LegType) -> frozenset[str]:
    """The fields of the setpoint that a leg of this kind may not set."""
    axes = Axis if row.keeps else row.steers
    return frozenset(field for axis in axes for field in _FIELDS[axis])


GENERATED = re.compile(r"line\d+\Z")  # the name of a leg without a name: its line


@dataclass(frozen=True, slots=True)
class NamedValue:
    name: str
    unit: str
    low: float
    high: float
    description: str
    above: bool = True  # the value must be above ``low``


_LIMITS = (
    NamedValue("radius", "m", 0, 65535, "farthest from home"),
    NamedValue("time", "s", 0, 65535 * 60, "longest autonomous run"),
    NamedValue("depth", "m", 0, 65535, "greatest depth"),
    NamedValue("voltage", "V", 0, 65535, "lowest control battery"),
)
LIMITS: Mapping[str, NamedValue] = MappingProxyType({row.name: row for row in _LIMITS})
_ASSUMPTIONS = (
    NamedValue("current", "m/s", 0, 5, "greatest current of the water", above=False),
    NamedValue("floor", "m", 0, 11000, "deepest sea floor; the depth allowed unless said"),
    NamedValue(
        "start", "m", 0, 20000, "farthest from home that the mission is started", above=False
    ),
)
ASSUMPTIONS: Mapping[str, NamedValue] = MappingProxyType({row.name: row for row in _ASSUMPTIONS})

_AIMS = (
    NamedValue("coverage", "", 0, 1, "share of the rows' area that is seen, as in `90%`"),
    NamedValue(
        "position",
        "m",
        0,
        20000,
        "95 % of the position error along the rows, or at the end of a leg without",
    ),
)
AIMS: Mapping[str, NamedValue] = MappingProxyType({row.name: row for row in _AIMS})

# The window of a trend, by its unit: s, or m of depth.
WINDOWS: Mapping[str, NamedValue] = MappingProxyType(
    {
        "s": NamedValue("s", "s", 2, 3600, "of the leg's last time", above=False),
        "m": NamedValue("m", "m", 0.5, 1000, "of the depth that it is at", above=False),
    }
)

# The other words of a leg's clauses, with their descriptions.
CLAUSES: Mapping[str, str] = MappingProxyType(
    {
        "until": "a guard that ends the leg: to the next one, or `-> name`; several may stand",
        "for": "the leg ends after this time",
        "timeout": "the leg is given up after this time",
        "else": "where to go then, and when the vehicle cannot follow; unless said as `on timeout`",
        "achieve": "what rows are flown for, of themselves, a group's or the mission's (`position` "
        "of any leg): the check refuses what is not expected to",
        "output": "an output of the vehicle file and its value there: `output lamp 80`",
    }
)
