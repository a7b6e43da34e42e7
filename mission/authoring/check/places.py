"""The places that a leg's own text names, in metres from home: between them lies where it leads.

What does not live here: how far the vehicle may be from them (bounds.py).
"""

from __future__ import annotations

import math

from mission.model import Follow, Goto, LegKind, Local, Loiter, Place, Position, Rows
from mission.navigation.geodesy import LocalFrame

Point = tuple[float, float]  # m north and east of home


def places_named(kind: LegKind) -> tuple[Place, ...]:
    """As the author wrote them."""
    match kind:
        case Goto(place):
            return (place,)
        case Follow(places):
            return places
        case Rows(start) if start is not None:
            return (start,)
        case Loiter(place) if place is not None:
            return (place,)
        case _:
            return ()


def places_of(kind: LegKind, frame: LocalFrame | None) -> tuple[Point, ...]:
    """Corners of what is steered along; none for a leg that is not steered to places, or that
    begins wherever it is entered. ``frame`` None: no home is named, and no latitude."""
    match kind:
        case Goto(place):
            return (_local(place, frame),)
        case Follow(places):
            return tuple(_local(p, frame) for p in places)
        case Rows(start) as rows if start is not None:
            return _corners(rows, *_local(start, frame))
        case Loiter(place, radius) if place is not None:
            n, e = _local(place, frame)
            return ((n - radius, e - radius), (n + radius, e + radius))
        case _:
            return ()


def room_around(kind: LegKind) -> float:
    """m about where it is entered that rows or a loiter without a place may need."""
    match kind:
        case Rows(None) as rows:
            return math.hypot(rows.length, rows.spacing * (rows.count - 1))
        case Loiter(None, radius):
            return 2.0 * radius
        case _:
            return 0.0


def _local(place: Place, frame: LocalFrame | None) -> Point:
    if isinstance(place, Local):
        return place.north, place.east
    if isinstance(place, Position) and frame is not None:
        return frame.to_local(math.radians(place.latitude_deg), math.radians(place.longitude_deg))
    return 0.0, 0.0


def _corners(rows: Rows, north: float, east: float) -> tuple[Point, ...]:
    c, s = math.cos(rows.bearing), math.sin(rows.bearing)
    wide = rows.spacing * (rows.count - 1) * rows.side
    return tuple(
        (north + a * c - b * s, east + a * s + b * c)
        for a in (0.0, rows.length)
        for b in (0.0, wide)
    )
