"""The registry of leg types, one file for each. docs/how-to/leg.md says what a new one takes."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from mission.legs import follow, goto, hold, loiter, rows, surface, wait, yoyo
from mission.legs.base import LegType, Pilot, Point, Track, View
from mission.model import LegKind

_ROWS = (
    hold.TYPE,
    wait.TYPE,
    goto.TYPE,
    follow.TYPE,
    rows.TYPE,
    yoyo.TYPE,
    loiter.TYPE,
    surface.TYPE,
)
LEGS: Mapping[type[LegKind], LegType] = MappingProxyType({row.kind: row for row in _ROWS})

__all__ = ["LEGS", "LegType", "Pilot", "Point", "Track", "View"]
