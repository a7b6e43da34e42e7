"""The reckoner's input: the believed values of a report, a fix in the local frame, a value of an
added sensor. Also what the reckoner keeps of the last report.

What does not live here: which values are believed (health), how they are used (reckoner).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

_FASTEST = 4.0  # m/s, between two fixes that agree


class Report(NamedTuple):
    """The believed values of one Telemetry. ``heading`` is compass + declination."""

    t: float
    heading: float | None
    pitch: float | None
    actuators: tuple[float, ...] | None
    depth: float | None
    altitude: float | None


class Reported(NamedTuple):
    """Heading, turn and thrust as of the last report."""

    t: float
    heading: float | None = None
    heading_t: float = -math.inf
    yaw_rate: float = 0.0
    along: float = 1.0
    expected: float = 0.0  # m/s, mean since the report before
    surfaced: bool = False
    sway: float = 0.0  # share of the speed, mean since the report before
    skidding: float = 0.0  # the same, at the report
    heave: float = 0.0  # m/s ahead, of a pitched hull that sinks or rises upright
    gap: float = 0.0  # s between this heading and the one before
    turns_from: tuple[float, float] | None = None  # s, heading: the next yaw rate counts from there
    told_after: float = 0.0  # s since the report before


class GroundFix(NamedTuple):
    """A fix in the local frame; ``velocity`` over ground, north and east."""

    t: float
    north: float
    east: float
    variance: float
    velocity: tuple[float, float] | None


class Aiding(NamedTuple):
    """A value of an added sensor: a place in the local frame; a range as the beacon's north, east
    and depth and the distance to it, m. ``sigma``: of each value; ``source``: which of several."""

    t: float
    kind: str
    values: tuple[float, ...]
    sigma: float
    source: str = ""

    @property
    def key(self) -> str:
        return f"{self.kind} {self.source}" if self.source else self.kind


Item = Report | GroundFix | Aiding


def agree(fixes: Sequence[GroundFix]) -> bool:
    """Whether each fix is within what receiver and vehicle can have moved since the one before."""
    return all(
        math.hypot(b.north - a.north, b.east - a.east)
        < 4.0 * math.sqrt(a.variance + b.variance) + _FASTEST * (b.t - a.t)
        for a, b in itertools.pairwise(fixes)
    )
