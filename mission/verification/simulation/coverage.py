"""How much of their area rows with a swath have seen, by truth and by estimate.

    area      length x ((count - 1) spacing + min(swath, spacing)), about the rows; or a polygon
    seen      at each step along the rows, half a swath to either side, across them

A step more across the rows than along them is a turn, and sees nothing. The vehicle would report
the coverage by the estimate; the true coverage is what the author gets.
"""

from __future__ import annotations

import functools
import math
from bisect import bisect_left
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from mission.authoring.check.places import pattern_of
from mission.legs.base import Point
from mission.legs.pattern import Pattern
from mission.model import Mission, aims_of
from mission.navigation.geodesy import LocalFrame
from mission.navigation.polygons import inside
from mission.verification.simulation.flightlog import Flight, Sample

_CELLS = 200  # along the longer side of the area, at most
_FINE = 20  # cells in a swath, at least


@dataclass(frozen=True, slots=True)
class Coverage:
    """Shares (0..1) of the area of the rows called ``leg``."""

    leg: str
    true: float
    estimated: float


def coverage_of(flight: Flight, mission: Mission) -> tuple[Coverage, ...]:
    """Return the coverage of each leg of rows that states a swath, in the mission's order."""
    frame = LocalFrame(mission.home) if mission.home is not None else None
    found = []
    for path, leg, _ in aims_of(mission.body, ()):
        begun = next((leg for leg in flight.legs if is_of(leg.name, path)), None)
        here = _entered(flight, begun.entered if begun else math.inf)
        pattern = pattern_of(leg.kind, frame, here)
        if pattern is None or not pattern.swath:
            continue
        runs = [
            [s for s in flight.samples if leg.entered <= s.t <= leg.left]
            for leg in flight.legs
            if is_of(leg.name, path)
        ]
        true, estimated = (seen(pattern, runs, place) for place in (_truth, _belief))
        found.append(Coverage(path, true, estimated))
    return tuple(found)


def seen(
    pattern: Pattern,
    runs: Iterable[Iterable[Sample]],
    place: Callable[[Sample], Point],
) -> float:
    """Return the share of the area that was seen from the places of the samples of all runs."""
    import numpy as np

    along, across, area = _cells(pattern)
    starts = along.tolist()
    grid = np.zeros((len(along), len(across)), dtype=bool)
    for run in runs:
        for (a, b), (c, d) in pairwise(pattern.framed(place(s)) for s in run):
            if abs(c - a) <= abs(d - b):
                continue
            first, last = bisect_left(starts, min(a, c)), bisect_left(starts, max(a, c))
            if first == last:
                continue
            middle = b + (d - b) * (along[first:last] - a) / (c - a)
            grid[first:last] |= np.abs(across - middle[:, None]) <= pattern.swath / 2.0
    if area is None:
        return float(grid.mean())
    return float(grid[area].mean()) if area.any() else 0.0


@functools.lru_cache(maxsize=8)
def _cells(pattern: Pattern) -> tuple[Any, Any, Any]:
    """Return the middles of the cells along and across the rows, m, and which cells (along x
    across) lie in the area; None: all. Cached, since many flights have the same rows."""
    import numpy as np

    long, wide = (axis[1] - axis[0] for axis in (pattern.along, pattern.across))
    cell = max(max(long, wide) / _CELLS, min(pattern.swath / _FINE, 1.0))
    along = (np.arange(max(1, int(long / cell))) + 0.5) * cell + pattern.along[0]
    across = (np.arange(max(1, int(wide / cell))) + 0.5) * cell + pattern.across[0]
    if pattern.whole:
        return along, across, None
    outline = [pattern.framed(corner) for corner in pattern.outline]
    return along, across, np.array([[inside(outline, (a, b)) for b in across] for a in along])


def is_of(name: str, path: str) -> bool:
    """Whether ``name`` is the leg at ``path`` or one of its rows, in any round."""
    plain = name.partition("#")[0]
    return plain == path or plain.startswith(f"{path}/row")


def _entered(flight: Flight, begun: float) -> Point:
    """Return the place where a leg was entered, by the estimate."""
    here = next((s for s in flight.samples if s.t >= begun), None)
    return _belief(here) if here is not None else (0.0, 0.0)


def _truth(sample: Sample) -> Point:
    return sample.true.north, sample.true.east


def _belief(sample: Sample) -> Point:
    return sample.estimate.north, sample.estimate.east


def as_json_of(found: Iterable[Coverage]) -> list[dict[str, str | float]]:
    return [
        {"leg": c.leg, "true": round(c.true, 4), "estimated": round(c.estimated, 4)} for c in found
    ]


def told(found: Iterable[Coverage]) -> list[str]:
    """Return one line of text for each."""
    return [
        f"coverage          {c.leg}: {c.true:.0%} of its area, {c.estimated:.0%} by the estimate"
        for c in found
    ]
