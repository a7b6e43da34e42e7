"""Rows over an area, of any leg type: what is flown, what is to be seen, and in which frame.

    framed    m along the first row from the origin, m across it to the side of the next ones

What does not live here: how a leg gives its rows (rows.py, cover.py), their pilot (waypoints.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Point = tuple[float, float]  # m north and east of home
Span = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Pattern:
    """``rows``: the beginning and end of each, m from home, in the order in which they are flown.

    The area extends over ``along`` and ``across`` in the frame. ``whole``: it is all of this, else
    the polygon ``outline`` (m from home). Pictures show ``outline`` in both cases.
    """

    origin: Point
    bearing: float  # rad
    side: int  # +1 starboard, -1 port
    rows: tuple[tuple[Point, Point], ...]
    spacing: float
    swath: float  # m seen, half to either side; 0: not given
    within: float
    along: Span
    across: Span
    outline: tuple[Point, ...]
    whole: bool = True

    @property
    def points(self) -> tuple[Point, ...]:
        """The ends of the rows, in the order in which they are visited."""
        return tuple(point for row in self.rows for point in row)

    def framed(self, point: Point) -> Point:
        north, east = point[0] - self.origin[0], point[1] - self.origin[1]
        c, s = math.cos(self.bearing), math.sin(self.bearing)
        return north * c + east * s, self.side * (east * c - north * s)
