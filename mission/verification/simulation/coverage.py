"""What rows with a swath have really seen of their area, by truth and by estimate.

    area      length x ((count - 1) spacing + min(swath, spacing)), about the rows
    seen      at each step along the rows, half a swath to either side, across them

A step that leads more across the rows than along them turns, and sees nothing. What the estimate
says is what the vehicle would report; what is true is what the author brings home.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from mission.legs import Rows
from mission.legs.base import Point
from mission.model import Local, Mission, Position, aims_of
from mission.navigation.geodesy import LocalFrame
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
    """For each leg of rows that says a swath, in the mission's order."""
    frame = LocalFrame(mission.home) if mission.home is not None else None
    found = []
    for path, kind in _surveys(mission):
        begun = next((leg for leg in flight.legs if is_of(leg.name, path)), None)
        start = _start(kind, frame, flight, begun.entered if begun else math.inf)
        runs = [
            [s for s in flight.samples if leg.entered <= s.t <= leg.left]
            for leg in flight.legs
            if is_of(leg.name, path)
        ]
        true, estimated = (seen(kind, start, runs, place) for place in (_truth, _belief))
        found.append(Coverage(path, true, estimated))
    return tuple(found)


def seen(
    kind: Rows,
    start: Point,
    runs: Iterable[Iterable[Sample]],
    place: Callable[[Sample], Point],
) -> float:
    """The share of the area that was seen from the places of the samples of each run."""
    import numpy as np

    edge = min(kind.swath, kind.spacing) if kind.count > 1 else kind.swath
    wide = (kind.count - 1) * kind.spacing + edge
    cell = max(max(kind.length, wide) / _CELLS, min(kind.swath / _FINE, 1.0))
    along = (np.arange(max(1, int(kind.length / cell))) + 0.5) * cell
    across = (np.arange(max(1, int(wide / cell))) + 0.5) * cell - edge / 2.0
    across += kind.skip * kind.spacing
    grid = np.zeros((len(along), len(across)), dtype=bool)
    for run in runs:
        for (a, b), (c, d) in pairwise(_in_rows(kind, start, place(s)) for s in run):
            if abs(c - a) <= abs(d - b):
                continue
            inside = (along >= min(a, c)) & (along < max(a, c))
            middle = b + (d - b) * (along[inside] - a) / (c - a)
            grid[inside] |= np.abs(across[None, :] - middle[:, None]) <= kind.swath / 2.0
    return float(grid.mean())


def _in_rows(kind: Rows, start: Point, here: Point) -> Point:
    """Metres along the first row, and from it to the side of the next ones."""
    north, east = here[0] - start[0], here[1] - start[1]
    c, s = math.cos(kind.bearing), math.sin(kind.bearing)
    return north * c + east * s, kind.side * (east * c - north * s)


def _surveys(mission: Mission) -> Iterator[tuple[str, Rows]]:
    for path, leg, _ in aims_of(mission.body, ()):
        if isinstance(leg.kind, Rows) and leg.kind.swath > 0.0:
            yield path, leg.kind


def is_of(name: str, path: str) -> bool:
    """Whether it is that leg, or one of its parts, in whatever round."""
    plain = name.partition("#")[0]
    return plain == path or plain.startswith(f"{path}/row")


def _start(kind: Rows, frame: LocalFrame | None, flight: Flight, begun: float) -> Point:
    place = kind.start
    if isinstance(place, Local):
        return place.north, place.east
    if isinstance(place, Position) and frame is not None:
        return frame.to_local(math.radians(place.latitude_deg), math.radians(place.longitude_deg))
    if place is None:  # where the leg was entered, as the vehicle took it
        here = next((s for s in flight.samples if s.t >= begun), None)
        return _belief(here) if here is not None else (0.0, 0.0)
    return 0.0, 0.0


def _truth(sample: Sample) -> Point:
    return sample.true.north, sample.true.east


def _belief(sample: Sample) -> Point:
    return sample.estimate.north, sample.estimate.east


def as_json_of(found: Iterable[Coverage]) -> list[dict[str, str | float]]:
    return [
        {"leg": c.leg, "true": round(c.true, 4), "estimated": round(c.estimated, 4)} for c in found
    ]


def told(found: Iterable[Coverage]) -> list[str]:
    """A line each, for people."""
    return [
        f"coverage          {c.leg}: {c.true:.0%} of its area, {c.estimated:.0%} by the estimate"
        for c in found
    ]
