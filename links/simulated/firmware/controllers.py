"""Heading, depth and attitude hold as in small firmware: proportional and rate terms, in gears.

Gains are tuned so that a turn runs at about 12 deg/s and a depth is held within about 0.1 m with
the trim of ``Body``. What does not live here: modes, limits of a profile.
"""

from __future__ import annotations

from math import pi, radians

TURN_RATE = radians(12.0)  # rad/s commanded while the error is large
TWO_PI = 2 * pi
TRIM_GEAR = 4.85  # verticals at this gear just balance the buoyancy


def turn_gear(wanted: float, heading: float, rate: float) -> float:
    """Gears to add on the left and subtract on the right main thruster; starboard positive."""
    error = (wanted - heading + pi) % TWO_PI - pi
    asked = 0.8 * error
    if asked > TURN_RATE:
        asked = TURN_RATE
    elif asked < -TURN_RATE:
        asked = -TURN_RATE
    return 16.0 * asked + 12.0 * (asked - rate)


def dive_gear(below: float, descent: float) -> float:
    """Gears downward to get ``below`` metres deeper; ``descent`` is the present rate, m/s."""
    return TRIM_GEAR + 8.0 * below - 14.0 * descent


def lean_gear(wanted: float, angle: float, rate: float) -> float:
    """Gears to add at one end of an axis and subtract at the other, for pitch and roll."""
    return 20.0 * (wanted - angle) - 12.0 * rate
