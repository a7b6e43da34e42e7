"""The text of a vehicle file -> Vehicle; every number has its range, and all mistakes are told.

A key that nobody knows is refused: a misspelt ``depth`` under ``reports`` would disarm the limits
of depth without a word. So is a number that no vehicle has: a rise of 0 would make every bound of
the check infinite, or none.

What does not live here: what a Vehicle is (vehicle), frames and dialects (protocol.vehicles).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import date
from types import MappingProxyType
from typing import Any

from yaml.nodes import MappingNode, Node, ScalarNode

from mission.model.units import GEARS, UnitError, quantity, range_text
from mission.model.vehicle import (
    FOLLOWS,
    REPORTS,
    STALE_AFTER,
    Battery,
    Calibration,
    Curve,
    Deviation,
    HardLimits,
    Sensors,
    Vehicle,
    VehicleError,
)
from mission.model.yaml_tree import YamlFault, tree
from protocol.vehicles import codec

LONGEST = 1 << 16  # characters of a vehicle file
_BOOL = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}


@dataclass(frozen=True, slots=True)
class Range:
    """``low``..``high`` in ``unit``; ``above``: low itself is out."""

    unit: str
    low: float
    high: float
    above: bool = False

    def fault(self, value: float) -> str:
        """``value`` in SI. Empty where it is within."""
        low, high = (quantity(bound, self.unit) for bound in (self.low, self.high))
        if (low < value if self.above else low <= value) and value <= high:
            return ""
        return f"out of range: {range_text(self.low, self.high, self.unit, self.above)}"


_RISE = Range("m/s", 0.01, 10)
_SIGMA = Range("m", 0.001, 100)
_ANGLE = Range("deg", 0, 90)
_LAG = Range("s", 0, 600)
_TIME = Range("s", 0, 1e6, above=True)
_FLOW = Range("m/s", 0, 5)
_DRIFT = Range("m/s", -5, 5)
_POWER = Range("W", 0, 1e5)
_GEAR = Range("", 0, GEARS)
_HARMONIC = Range("deg", -60, 60)

# Every number of a vehicle file by its key, those of the calibration with all their words.
RANGES: Mapping[str, Range] = MappingProxyType(
    {
        "limits.radius": Range("m", 1, 100_000),
        "limits.time": Range("min", 0, 65_535, above=True),
        "limits.depth": Range("m", 0, 11_000, above=True),
        "limits.voltage": Range("V", 0, 1000),
        "limits.descent_rate": _RISE,
        "limits.roll": Range("deg", 5, 180),
        "stale_after": Range("s", 0.1, 60),
        "battery_scale.control": Range("", 0, 1000, above=True),
        "battery_scale.power": Range("", 0, 1000, above=True),
        "speed_by_gear": Range("m/s", 0, 20),
        "dive_rate": _RISE,
        "ascent_buoyancy": Range("m/s", -10, 10),  # of a heavy vehicle, too: it is measured
        "ascent_thrust": _RISE,
        "turn_rate": Range("deg/s", 0.1, 360),
        "current": _FLOW,
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
        "calibration.surface_drift": _FLOW,
        "calibration.deviation.sin1": _HARMONIC,
        "calibration.deviation.cos1": _HARMONIC,
        "calibration.deviation.sin2": _HARMONIC,
        "calibration.deviation.cos2": _HARMONIC,
        "calibration.current.north": _DRIFT,
        "calibration.current.east": _DRIFT,
    }
)


@dataclass(frozen=True, slots=True)
class Together:
    """Two numbers of which the second must be above the first, or ``equal`` to it."""

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


_FLAGS = ("constant_batteries", "one_speed", "glides", "drives")
_TEXTS = ("vehicle", "codec", "dialect", "ascent_measured")
_GEARS = ("speed_by_gear", "thruster_power")  # tables of a figure by gear
_FREE = ("tolerances", "wire", *_GEARS)  # tables of any keys


def _known() -> Mapping[str, frozenset[str]]:
    """The keys that each table may have."""
    leaves = [*RANGES, *_FLAGS, *_TEXTS, *_FREE]
    leaves += [f"reports.{name}" for name in REPORTS] + [f"follows.{name}" for name in FOLLOWS]
    tables: dict[str, set[str]] = {"": set()}
    for leaf in leaves:
        table = ""
        for key in leaf.split("."):
            tables.setdefault(table, set()).add(key)
            table = f"{table}.{key}" if table else key
    return MappingProxyType({table: frozenset(keys) for table, keys in tables.items()})


_KNOWN = _known()
_MAY_LACK = (
    "ascent_measured",
    "stale_after",
    "glides",
    "drives",
    "wire",
    "calibration",
)  # and what is below


def read_vehicle(text: str, where: str) -> Vehicle:
    """Raises VehicleError with everything that is wrong, by lines."""
    if len(text) > LONGEST:
        raise VehicleError(f"{where}: more than {LONGEST:,} characters, which no vehicle file has")
    try:
        root = tree(text)
    except YamlFault as fault:
        raise VehicleError(f"{where}:{fault}") from None
    if not isinstance(root, MappingNode):
        raise VehicleError(f"{where}: a vehicle file is a table of keys")
    file = _File(where, root)
    vehicle = _vehicle(file)
    file.complain()
    try:
        codec(*vehicle.speaks)
    except ValueError as error:
        raise VehicleError(f"{where}:{file.line('codec')}: codec: {error}") from None
    return vehicle


class _File:
    """The values of the file by their dotted keys. What is wrong is noted, and a value stands in
    for it, so that reading goes on."""

    def __init__(self, where: str, root: Node) -> None:
        self._where = where
        self._faults: list[tuple[int, str]] = []
        self._leaves: dict[str, ScalarNode] = {}
        self._good: dict[str, float] = {}
        self._take("", root)

    def complain(self) -> None:
        """Raises VehicleError if there is anything to complain about."""
        for pair in TOGETHER:
            self._together(pair)
        if self._faults:
            rows = (f"{self._where}:{line}: {message}" for line, message in sorted(self._faults))
            raise VehicleError("\n".join(rows))

    def line(self, key: str) -> int:
        return _line(self._leaves[key])

    def text(self, key: str) -> str:
        return self._leaves[key].value if key in self._leaves else ""

    def day(self, key: str) -> str:
        """YYYY-MM-DD, or "" where the file has none."""
        text = self.text(key)
        try:
            return date.fromisoformat(text).isoformat() if text else ""
        except ValueError:
            self._says(key, f"{text:.40} is no day; write it as 2026-11-22", self._leaves[key])
            return ""

    def texts(self, table: str) -> dict[str, str]:
        return {key.removeprefix(f"{table}."): self.text(key) for key in self._below(table)}

    def flag(self, key: str) -> bool:
        node = self._leaves.get(key)
        if node is None:
            return False
        if node.style in ("'", '"') or node.value.lower() not in _BOOL:
            self._says(key, f"write true or false, not {_shown(node)}", node)
        return _BOOL.get(node.value.lower(), False)

    def true_keys(self, table: str) -> frozenset[str]:
        return frozenset(key.partition(".")[2] for key in self._below(table) if self.flag(key))

    def number(self, key: str, default: float = math.nan) -> float:
        """In SI; NaN where it is none, or out of its range."""
        node = self._leaves.get(key)
        if node is not None:
            return self._value(key, RANGES[key], node)
        if key in _MAY_LACK:
            self._good[key] = default
        return default

    def curve(self, table: str) -> Curve:
        """By gear, from a standstill on."""
        keys = self._below(table)
        gears = [self._value(key, _GEAR, self._gear_node(key)) for key in keys]
        figures = [self._value(key, RANGES[table], self._leaves[key]) for key in keys]
        rows = sorted(zip(gears, figures, strict=True))
        fault = "" if any(map(math.isnan, (*gears, *figures))) else _curve_fault(rows)
        if keys and fault:
            self._says(table, fault, self._leaves[keys[0]])
        return Curve(tuple(x for x, _ in rows), tuple(y for _, y in rows))

    # --- reading ----------------------------------------------------------------------------

    def _take(self, table: str, node: Node) -> None:
        if not isinstance(node, MappingNode):
            self._says(table, "a table is needed", node)
            return
        seen = set()
        for key, value in node.value:
            name = str(key.value) if isinstance(key, ScalarNode) else "[...]"
            if table not in _FREE and name not in _KNOWN[table]:
                there = ", ".join(sorted(_KNOWN[table]))
                self._says(table, f"no key {name:.40}; there are {there}", key)
            elif name in seen:
                self._says(table, f"{name:.40} appears twice; keep one of them", key)
            else:
                self._put(f"{table}.{name}" if table else name, value)
            seen.add(name)
        for name in sorted(_KNOWN.get(table, frozenset()) - seen):
            if not f"{table}.{name}".lstrip(".").startswith(_MAY_LACK):
                self._says(table, f"the key {name} is missing", node)

    def _put(self, key: str, value: Node) -> None:
        if key in _KNOWN or key in _FREE:
            self._take(key, value)
        elif not isinstance(value, ScalarNode) or not 0 < len(value.value) <= 80:
            self._says(key, f"one value is needed, not {_shown(value)}", value)
        else:
            self._leaves[key] = value

    def _below(self, table: str) -> list[str]:
        return [key for key in self._leaves if key.startswith(f"{table}.")]

    def _gear_node(self, key: str) -> ScalarNode:
        node = self._leaves[key]
        return ScalarNode("", key.partition(".")[2], node.start_mark)

    def _value(self, key: str, wanted: Range, node: ScalarNode) -> float:
        try:
            value = quantity(node.value, wanted.unit)
            fault = wanted.fault(value)
            fault = f"{_shown(node)} is {fault}" if fault else ""
        except UnitError as error:
            value, fault = math.nan, str(error)
        if fault:
            self._says(key, fault, node)
            return math.nan
        self._good[key] = value + 0.0
        return value + 0.0

    def _together(self, pair: Together) -> None:
        less, more = self._good.get(pair.less), self._good.get(pair.more)
        if less is None or more is None or less < more or (pair.equal and less == more):
            return
        word = "below" if pair.equal else "not above"
        node = self._leaves.get(pair.more) or self._leaves[pair.less]
        self._says(pair.more, f"{word} {pair.less.replace('.', ': ')}: {pair.why}", node)

    def _says(self, key: str, message: str, node: Node) -> None:
        self._faults.append((_line(node), ": ".join([*filter(None, key.split(".")), message])))


def _vehicle(file: _File) -> Vehicle:
    number = file.number
    auto = file.text("compass.declination") == "auto"
    return Vehicle(
        name=file.text("vehicle"),
        codec=file.text("codec"),
        dialect=file.text("dialect"),
        tolerances=file.texts("tolerances"),
        limits=HardLimits(**_all(file, "limits", HardLimits)),
        reports=file.true_keys("reports"),
        follows=file.true_keys("follows"),
        constant_batteries=file.flag("constant_batteries"),
        battery_scale=(number("battery_scale.control"), number("battery_scale.power")),
        one_speed=file.flag("one_speed"),
        speed_by_gear=file.curve("speed_by_gear"),
        dive_rate=number("dive_rate"),
        ascent_buoyancy=number("ascent_buoyancy"),
        ascent_measured=file.day("ascent_measured"),
        ascent_thrust=number("ascent_thrust"),
        turn_rate=number("turn_rate"),
        current=number("current"),
        battery=Battery(**_all(file, "battery", Battery)),
        thruster_power=file.curve("thruster_power"),
        sensors=Sensors(**_all(file, "sensors", Sensors)),
        declination=None if auto else number("compass.declination"),
        compass_bias=number("compass.bias_deg"),
        calibration=_calibration(file),
        stale_after=number("stale_after", STALE_AFTER),
        glides=file.flag("glides"),
        drives=file.flag("drives"),
        wire=file.texts("wire"),
    )


def _all(file: _File, table: str, kind: type[Any]) -> dict[str, float]:
    return {f.name: file.number(f"{table}.{f.name}") for f in fields(kind)}


def _calibration(file: _File) -> Calibration:
    """The optional section; what it leaves out keeps the default."""
    default = Calibration()
    given: dict[str, Any] = {
        f.name: file.number(f"calibration.{f.name}", getattr(default, f.name))
        for f in fields(Calibration)
        if f"calibration.{f.name}" in RANGES
    }
    harmonics = {
        f.name: file.number(f"calibration.deviation.{f.name}", 0.0) for f in fields(Deviation)
    }
    given["deviation"] = Deviation(**harmonics)
    given["current"] = tuple(
        file.number(f"calibration.current.{w}", 0.0) for w in ("north", "east")
    )
    return Calibration(**given)


def _curve_fault(rows: list[tuple[float, float]]) -> str:
    if len(rows) < 2 or rows[0][0] != 0.0:
        return "two or more rows are needed, the first for gear 0"
    if any(b[0] <= a[0] for a, b in itertools.pairwise(rows)):
        return "a gear appears twice"
    if any(b[1] < a[1] for a, b in itertools.pairwise(rows)):
        return "two or more rows that do not fall are needed"
    if rows[-1][1] == 0.0:
        return "the highest gear has nothing"
    return ""


def _line(node: Node) -> int:
    return int(node.start_mark.line) + 1


def _shown(node: Node) -> str:
    if not isinstance(node, ScalarNode):
        return "a table" if isinstance(node, MappingNode) else "a list"
    return f"{node.value:.40}" or "nothing"
