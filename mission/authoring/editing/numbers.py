"""Coordinates as an author would write them: no finer than a decimetre, unless he was.

Degrees have seven decimals (a centimetre). A number that does not change stays as it is written.
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
    """In the unit that the amount has. Raises UnitError for one that is no length's."""
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
    """Without an exponent, without zeros at its end."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def _decimals(text: str) -> int:
    """Of a number as it is written; one with an exponent is no finer than is usual."""
    return len(text.partition(".")[2]) if "e" not in text.lower() else 0
