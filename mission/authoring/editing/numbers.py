"""Write coordinates with sensible decimals: decimetres, or finer if the author wrote finer.

Degrees have seven decimals (a centimetre). A number that does not change stays as written.
"""

from __future__ import annotations

import math

from mission.authoring.language.clauses import Amount
from mission.model.units import UNITS, quantity

_METRES = 0.1
_DEGREES = 7  # decimals


def degrees(amount: Amount, value: float) -> str:
    return _written(amount, value, _DEGREES)


def metres(amount: Amount, value: float) -> str:
    """The value in the unit of ``amount``. Raises UnitError if it is no unit of length."""
    quantity(f"0 {amount.unit}", "m")
    factor = UNITS[amount.unit or "m"].factor
    return _written(amount, value / factor, max(0, math.ceil(-math.log10(_METRES / factor) - 1e-9)))


def _written(amount: Amount, value: float, decimals: int) -> str:
    fine = max(decimals, _decimals(amount.text))
    before = float(amount.text)
    if abs(value - before) <= 0.5000001 * 10.0**-fine:
        return amount.text
    return plain(value, fine)


def plain(value: float, decimals: int) -> str:
    """A number as text, without exponent and without trailing zeros."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def _decimals(text: str) -> int:
    """The decimals of a number as written; 0 for a number with an exponent."""
    return len(text.partition(".")[2]) if "e" not in text.lower() else 0
