"""What the reckoner takes in: what could be believed of one report, and a fix in the local frame.

What does not live here: how it is believed (health), and what is made of it (reckoner).
"""

from __future__ import annotations

from typing import NamedTuple


class Report(NamedTuple):
    """What could be believed of one Telemetry. ``heading`` is compass + declination."""

    t: float
    heading: float | None
    pitch: float | None
    actuators: tuple[float, ...] | None
    depth: float | None
    altitude: float | None


class GroundFix(NamedTuple):
    """A fix in the local frame; ``velocity`` over ground, north and east."""

    t: float
    north: float
    east: float
    variance: float
    velocity: tuple[float, float] | None


class Aiding(NamedTuple):
    """What an added sensor said; a place in the local frame, a range as the beacon's north, east
    and depth and the way to it, m. ``sigma`` is one of each value; ``source``: which of several."""

    t: float
    kind: str
    values: tuple[float, ...]
    sigma: float
    source: str = ""

    @property
    def key(self) -> str:
        return f"{self.kind} {self.source}" if self.source else self.kind


Item = Report | GroundFix | Aiding
