"""A lawnmower area: parallel rows up and down, the way to its start first.

start -> end of row 1, across by the spacing, back along row 2, across, ...
"""

from __future__ import annotations

import math

from mission.legs.base import LegType, Point, View
from mission.legs.guidance import GIVES, NEEDS, STEERS
from mission.legs.waypoints import Waypoints, arrival_fault
from mission.model import Rows
from protocol.messages import Setpoint


def corners(kind: Rows, start: Point) -> tuple[Point, ...]:
    """The points in the order they are visited, the start first."""
    ahead = (math.cos(kind.bearing), math.sin(kind.bearing))
    across = (-kind.side * ahead[1], kind.side * ahead[0])
    points = []
    for row in range(kind.count):
        ends = (0.0, kind.length) if row % 2 == 0 else (kind.length, 0.0)
        offset = row * kind.spacing
        for reach in ends:
            north = start[0] + reach * ahead[0] + offset * across[0]
            east = start[1] + reach * ahead[1] + offset * across[1]
            points.append((north, east))
    return tuple(points)


def _begin(kind: Rows, base: Setpoint, view: View) -> Waypoints:
    start: Point | None
    if kind.start is not None:
        start = view.place(kind.start)
    else:
        start = (view.estimate.north, view.estimate.east) if view.estimate else None
    points = corners(kind, start) if start is not None else (None,)
    return Waypoints(base, points, kind.within, view)


def _fault(kind: Rows) -> str:
    if kind.count < 1:
        return "an area has at least one row"
    if kind.length <= 0.0 or (kind.spacing <= 0.0 and kind.count > 1):
        return "length and spacing of the rows must be greater than 0"
    return arrival_fault(kind.within)


TYPE = LegType(
    name="rows",
    kind=Rows,
    begin=_begin,
    steers=STEERS,
    needs=NEEDS,
    gives=GIVES,
    ends=True,
    makes_way=True,
    fault=_fault,
)
