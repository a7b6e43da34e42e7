"""The text of a vehicle file -> Vehicle. Every number has a range, and all errors are reported.

An unknown key is refused: a misspelt ``depth`` under ``reports`` would silently disable the limits
of depth. A number that no vehicle has is refused, too: a rise of 0 would make every bound of the
check infinite, or none.

What does not live here: what a Vehicle is (vehicle), frames and dialects (protocol.vehicles).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import astuple, fields, replace
from datetime import date
from types import MappingProxyType
from typing import Any

from yaml.nodes import MappingNode, Node, ScalarNode

from mission.model.beacons import read_beacons
from mission.model.diagnostics import Diagnostics, Stage
from mission.model.likeness import suggestion
from mission.model.texts import NOWHERE, Where
from mission.model.units import UnitError, quantity
from mission.model.vehicle import (
    CLOSED,
    FOLLOWS,
    REPORTS,
    STALE_AFTER,
    AxisLoop,
    Battery,
    Calibration,
    Curve,
    Deviation,
    HardLimits,
    OuterLoop,
    Sensors,
    Vehicle,
    VehicleError,
)
from mission.model.vehicle_outputs import OUTPUT, OUTPUT_KEYS, read_outputs, read_readings
from mission.model.vehicle_ranges import GEAR, RANGES, TOGETHER, Range, Together
from mission.model.yaml_tree import YamlFault, tree, where_of
from protocol.vehicles import codec

LONGEST = 1 << 16  # characters of a vehicle file
_BOOL = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}


_FLAGS = ("constant_batteries", "one_speed", "glides", "drives")
_TEXTS = ("vehicle", "codec", "dialect", "ascent_measured", "outer_loop.confirmed")
_GEARS = ("speed_by_gear", "thruster_power")  # tables of a figure by gear
_FREE = ("tolerances", "wire", "outputs", "readings", "beacons", *_GEARS)  # tables of any keys


def _known() -> Mapping[str, frozenset[str]]:
    """Return the keys that each table may have."""
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
    "reckoning",
    "glides",
    "drives",
    "wire",
    "outer_loop",
    "outputs",
    "readings",
    "calibration",
    "added",
    "beacons",
)  # and the keys below them


def read_vehicle(text: str, where: str) -> Vehicle:
    """Read a vehicle file. Raises VehicleError with all errors, by lines."""
    found = Diagnostics(Stage.VEHICLE, text, where, VehicleError)
    if len(text) > LONGEST:
        message = f"more than {LONGEST:,} characters, which no vehicle file has"
        raise found.refusal("too-long", NOWHERE, message, "give a vehicle file")
    try:
        root = tree(text)
    except YamlFault as fault:
        raise found.refusal(*fault.said("the vehicle file")) from None
    if not isinstance(root, MappingNode):
        hint = "write keys and values, for instance vehicle: auv"
        raise found.refusal("yaml-type", Where(1, 1), "a vehicle file is a table of keys", hint)
    for key in (key for key, _ in root.value if key.value == "mission"):
        hint = "give a vehicle file, or the name of a shipped vehicle"
        raise found.refusal(
            "unknown-word", where_of(key), "this is a mission, no vehicle file", hint
        )
    file = _File(found, root)
    vehicle = _vehicle(file)
    file.complain()
    outputs = read_outputs(file, vehicle.codec, codec(*vehicle.speaks))
    readings = read_readings(file, vehicle.codec)
    beacons = read_beacons(file)
    found.complain()
    return replace(vehicle, outputs=outputs, readings=readings, beacons=beacons)


class _File:
    """The values of the file by their dotted keys. An error is noted and a value is put in its
    place, so that reading continues."""

    def __init__(self, found: Diagnostics, root: Node) -> None:
        self._found = found
        self._leaves: dict[str, ScalarNode] = {}
        self._good: dict[str, float] = {}
        self._take("", root)

    def complain(self) -> None:
        """Raise VehicleError if there are errors."""
        for pair in TOGETHER:
            self._together(pair)
        self._spoken()
        self._found.complain()

    def _spoken(self) -> None:
        """Ask the codec whether it exists, with this dialect, these tolerances and this wire."""
        if "codec" in self._leaves and "dialect" in self._leaves:
            said = (self.text("codec"), self.text("dialect"))
            try:
                codec(*said, self.texts("tolerances"), wire=self.texts("wire"))
            except ValueError as error:
                what, _, instead = str(error).partition("; ")
                self._says("codec", "codec", what, self._leaves["codec"], instead)

    def text(self, key: str) -> str:
        return self._leaves[key].value if key in self._leaves else ""

    def day(self, key: str) -> str:
        """YYYY-MM-DD, or "" where the file has none."""
        text = self.text(key)
        try:
            return date.fromisoformat(text).isoformat() if text else ""
        except ValueError:
            node = self._leaves[key]
            self._says(key, "number", f"{text:.40} is no day", node, "write it as 2026-11-22")
            return ""

    def texts(self, table: str) -> dict[str, str]:
        return {key.removeprefix(f"{table}."): self.text(key) for key in self._below(table)}

    def flag(self, key: str) -> bool:
        node = self._leaves.get(key)
        if node is None:
            return False
        if node.style in ("'", '"') or node.value.lower() not in _BOOL:
            self._says(key, "flag", f"{_shown(node)} is no flag", node, "write true or false")
        return _BOOL.get(node.value.lower(), False)

    def true_keys(self, table: str) -> frozenset[str]:
        return frozenset(key.partition(".")[2] for key in self._below(table) if self.flag(key))

    def number(self, key: str, default: float = math.nan) -> float:
        """Return a number in SI, ``default`` if missing; NaN if it is none, or out of range."""
        node = self._leaves.get(key)
        if node is not None:
            return self._value(key, RANGES[key], node)
        if key in _MAY_LACK:
            self._good[key] = default
        return default

    def number_in(self, key: str, wanted: Range, default: float) -> float:
        """The same for a table whose keys are the file's own."""
        node = self._leaves.get(key)
        return default if node is None else self._value(key, wanted, node)

    def names(self, table: str) -> list[str]:
        """Return the names directly in a table, in the order of the file."""
        inner = (key.removeprefix(f"{table}.").partition(".")[0] for key in self._below(table))
        return list(dict.fromkeys(inner))

    def refuse(self, key: str, message: str, hint: str) -> None:
        """Note an error at ``key``: a leaf, or a table that has one."""
        node = self._leaves.get(key) or self._leaves[self._below(key)[0]]
        self._says(key, "output", message, node, hint)

    def curve(self, table: str) -> Curve:
        """Return a table by gear, from gear 0 on."""
        keys = self._below(table)
        gears = [self._value(key, GEAR, self._gear_node(key)) for key in keys]
        figures = [self._value(key, RANGES[table], self._leaves[key]) for key in keys]
        rows = sorted(zip(gears, figures, strict=True))
        fault = "" if any(map(math.isnan, (*gears, *figures))) else _curve_fault(rows)
        if keys and fault:
            hint = "write a figure for gear 0, and one for each gear that was measured"
            self._says(table, "curve", fault, self._leaves[keys[0]], hint)
        return Curve(tuple(x for x, _ in rows), tuple(y for _, y in rows))

    # --- reading ----------------------------------------------------------------------------

    def _take(self, table: str, node: Node) -> None:
        if not isinstance(node, MappingNode):
            hint = "write keys and values below it"
            self._says(table, "yaml-type", "a table is needed", node, hint)
            return
        seen = set()
        for key, value in node.value:
            name = str(key.value) if isinstance(key, ScalarNode) else "[...]"
            known = OUTPUT_KEYS if OUTPUT.fullmatch(table) else _KNOWN.get(table, frozenset())
            if table not in _FREE and name not in known:
                hint = suggestion(name, sorted(known), "there are")
                self._says(table, "unknown-word", f"no key {name:.40}", key, hint)
            elif name in seen:
                self._says(table, "twice", f"{name:.40} appears twice", key, "keep one of them")
            else:
                self._put(f"{table}.{name}" if table else name, value)
            seen.add(name)
        for name in sorted(_KNOWN.get(table, frozenset()) - seen):
            if not f"{table}.{name}".lstrip(".").startswith(_MAY_LACK):
                self._says(
                    table,
                    "missing-word",
                    f"the key {name} is missing",
                    node,
                    self._example(table, name),
                )

    @staticmethod
    def _example(table: str, name: str) -> str:
        row = RANGES.get(f"{table}.{name}".lstrip("."))
        figure = f"a number of {row.unit}" if row is not None and row.unit else "what it is"
        return f"add {name}: and {figure}; the shipped vehicle files have it"

    def _put(self, key: str, value: Node) -> None:
        if key in _KNOWN or key in _FREE or OUTPUT.fullmatch(key):
            self._take(key, value)
        elif not isinstance(value, ScalarNode) or not 0 < len(value.value) <= 80:
            self._says(
                key,
                "yaml-type",
                f"one value is needed, not {_shown(value)}",
                value,
                "write one value",
            )
        else:
            self._leaves[key] = value

    def _below(self, table: str) -> list[str]:
        return [key for key in self._leaves if key.startswith(f"{table}.")]

    def _gear_node(self, key: str) -> ScalarNode:
        node = self._leaves[key]
        return ScalarNode("", key.partition(".")[2], node.start_mark, node.end_mark)

    def _value(self, key: str, wanted: Range, node: ScalarNode) -> float:
        try:
            value = quantity(node.value, wanted.unit)
            fault, hint = ("out of range", wanted.text) if wanted.excludes(value) else ("", "")
            code, fault = "range", f"{_shown(node)} is {fault}" if fault else ""
        except UnitError as error:
            code, fault, hint = (
                "number",
                str(error),
                f"write for instance {wanted.high:g} {wanted.unit}",
            )
        if fault:
            self._says(key, code, fault, node, hint)
            return math.nan
        self._good[key] = value + 0.0
        return value + 0.0

    def _together(self, pair: Together) -> None:
        less, more = self._good.get(pair.less), self._good.get(pair.more)
        if less is None or more is None or less < more or (pair.equal and less == more):
            return
        word = "below" if pair.equal else "not above"
        node = self._leaves.get(pair.more) or self._leaves[pair.less]
        message = f"{word} {pair.less.replace('.', ': ')}: {pair.why}"
        self._says(pair.more, "contradiction", message, node, "correct one of the two")

    def _says(self, key: str, code: str, message: str, node: Node, hint: str) -> None:
        said = ": ".join([*filter(None, key.split(".")), message])
        self._found.add(code, where_of(node), said, hint)


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
        ascent_buoyancy=_buoyancy(file),
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
        outer_loop=_outer_loop(file),
        added={kind: file.number(f"added.{kind}") for kind in file.names("added")},
        reckoning=None if math.isnan(drift := number("reckoning")) else drift,
    )


def _all(file: _File, table: str, kind: type[Any]) -> dict[str, float]:
    return {f.name: file.number(f"{table}.{f.name}") for f in fields(kind)}


def _buoyancy(file: _File) -> float:
    """A vehicle that drives need not rise, but the check divides by the figure."""
    rate = file.number("ascent_buoyancy")
    if rate <= 0.0 and file.flag("drives"):
        message = "not above 0: a vehicle that drives is checked with it, too"
        file.refuse("ascent_buoyancy", message, "write 0.1 m/s")
    return rate


def _outer_loop(file: _File) -> OuterLoop | None:
    if not file.names("outer_loop"):
        return None
    axes = {name: AxisLoop(**_all(file, f"outer_loop.{name}", AxisLoop)) for name in CLOSED}
    for name, axis in axes.items():
        if any(math.isnan(figure) for figure in astuple(axis)):
            file.refuse("outer_loop", f"{name} is not whole", "write all keys of both axes")
    return OuterLoop(axes["depth"], axes["heading"], file.day("outer_loop.confirmed"))


def _calibration(file: _File) -> Calibration:
    """Read the optional section; a missing key has its default."""
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


def _shown(node: Node) -> str:
    if not isinstance(node, ScalarNode):
        return "a table" if isinstance(node, MappingNode) else "a list"
    return f"{node.value:.40}" or "nothing"
