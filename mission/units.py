"""Units a text may write, and the SI unit each stands for.

One table for missions and vehicle files.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


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

_QUANTITY = re.compile(r"\s*(-?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z/%]*)\s*\Z")


class UnitError(ValueError):
    """The author must act: not a number, an unknown unit, or a unit of something else."""


def quantity(text: str | float, default: str) -> float:
    """The value of ``text`` in SI; a bare number is in the unit ``default``.

    Raises UnitError, saying what was written and which units fit.
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
    value = float(match[1]) * unit.factor
    if not math.isfinite(value):
        raise UnitError(f"{text!r} is not a finite number")
    return value
