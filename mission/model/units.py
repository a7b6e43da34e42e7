"""Units a text may write, the SI unit each stands for, and numbers as texts write them.

One table serves missions and vehicle files. Conversions are exact to the last bit (57 % reads as
0.57), so that a text made from a value reads back as the same value.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

GEARS = 12  # full thrust, as a gear of missions and vehicle files; a Setpoint has shares of it


@dataclass(frozen=True, slots=True)
class Unit:
    """``si`` names the SI unit it is measured in ("" for a pure number)."""

    name: str
    si: str
    factor: float


_ROWS = (
    Unit("m", "m", 1.0),
    Unit("km", "m", 1000.0),
    Unit("cm", "m", 0.01),
    Unit("nmi", "m", 1852.0),
    Unit("s", "s", 1.0),
    Unit("min", "s", 60.0),
    Unit("h", "s", 3600.0),
    Unit("m/s", "m/s", 1.0),
    Unit("kn", "m/s", 1852.0 / 3600.0),
    Unit("deg", "rad", math.pi / 180.0),
    Unit("rad", "rad", 1.0),
    Unit("deg/s", "rad/s", math.pi / 180.0),
    Unit("V", "V", 1.0),
    Unit("C", "C", 1.0),
    Unit("%", "", 0.01),
    Unit("Wh", "J", 3600.0),
    Unit("W", "W", 1.0),
)
UNITS: Mapping[str, Unit] = MappingProxyType({row.name: row for row in _ROWS})

# A text means decimal fractions, not binary ones: 0.01 is 1/100. Angles have no such fraction.
_EXACT = {
    row.name: Fraction(row.factor).limit_denominator(10**6) for row in _ROWS if row.si != "rad"
}
_PLAIN = re.compile(r"-?\d{1,15}(?:\.\d{1,15})?")

_QUANTITY = re.compile(r"\s*(-?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z/%]*)\s*\Z")


class UnitError(ValueError):
    """The author must act: not a number, an unknown unit, or a unit of something else."""


def quantity(text: str | float, default: str) -> float:
    """Return the value of ``text`` in SI; a bare number is in the unit ``default``.

    Raises UnitError, which says what was written and which units fit.
    """
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise UnitError(f"{text!r} is not a number")
    match = _QUANTITY.match(str(text))
    if match is None:
        raise UnitError(f"{text!r} is not a number with a unit; write for instance 10 {default}")
    unit = UNITS.get(match[2] or default) if (match[2] or default) else Unit("", "", 1.0)
    wanted = UNITS[default].si if default else ""
    if unit is None or unit.si != wanted:
        fits = ", ".join(u.name for u in _ROWS if u.si == wanted) or "none"
        raise UnitError(f"{match[2]!r} does not fit here; units that do: {fits}")
    value = _scaled(match[1], unit)
    if not math.isfinite(value):
        raise UnitError(f"{text!r} is not a finite number")
    return value


def _scaled(number: str, unit: Unit) -> float:
    exact = _EXACT.get(unit.name)
    if exact is None or unit.factor == 1.0 or not _PLAIN.fullmatch(number):
        return float(number) * unit.factor
    return float(Fraction(number) * exact)


def range_text(low: float, high: float, unit: str, above: bool = False) -> str:
    """``low``..``high`` in words; ``above``: low itself is excluded."""
    least = f"more than {number_text(low)}" if above else f"{number_text(low)} or more"
    return f"{least}, up to {number_text(high)}{f' {unit}' if unit else ''}"


def compass(degrees: float) -> float:
    """A compass heading in rad, [0, 2 pi)."""
    turned = math.radians(degrees % 360.0)
    return turned if turned < math.tau else 0.0


def number_text(value: float) -> str:
    """The shortest decimal that reads back as ``value``; whole numbers without a point."""
    text = repr(value + 0.0)
    return text.removesuffix(".0")


def degrees_text(radians: float) -> str:
    """The shortest number of degrees that reads back (``math.radians``) as the same bits."""
    guess = math.degrees(radians)
    for digits in range(1, 18):
        text = f"{guess:.{digits}g}"
        if math.radians(float(text)) == radians:
            return number_text(float(text))
    near = [guess]
    for way in (-math.inf, math.inf):
        step = guess
        for _ in range(4):
            step = math.nextafter(step, way)
            near.append(step)
    fits = [n for n in near if math.radians(n) == radians]
    return number_text(min(fits, key=lambda n: (len(repr(n)), n)) if fits else guess)
