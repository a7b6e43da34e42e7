"""The time that ways take in a current from the worst direction.

What does not live here: the ways of a leg, and its clock (outlook).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from mission.legs.base import Point

_AROUND = 16  # directions of the current that are tried, beside those directly against a way


def slowest(ways: Sequence[Point], speed: float, current: float) -> float:
    """s for all ``ways`` (m north and east) in turn, with the current from the direction in which
    they take longest; inf if the vehicle makes no way against it."""
    bearings = {round(math.atan2(east, north), 2) for north, east in ways}
    opposed = {bearing + math.pi for bearing in bearings}
    around = {2.0 * math.pi * k / _AROUND for k in range(_AROUND)}
    lengths = [(math.hypot(*way), math.atan2(way[1], way[0])) for way in ways]
    return max(
        sum(length / made if (made := _made(speed, current, to - bearing)) > 0.0 else math.inf
            for length, bearing in lengths)
        for to in opposed | around
    )  # fmt: skip


def _made(speed: float, current: float, angle: float) -> float:
    """m/s over ground along a line; ``angle``: from the line to the flow of the current, rad."""
    across = current * math.sin(angle)
    return math.sqrt(max(speed**2 - across**2, 0.0)) + current * math.cos(angle)
