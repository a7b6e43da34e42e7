"""The places that a leg's own text names, in metres from home: between them lies where it leads.

What does not live here: how far the vehicle may be from them (bounds.py).
"""

from __future__ import annotations

import math

from mission.legs import LEGS
from mission.legs.base import Point
from mission.legs.pattern import Pattern
from mission.model import LegKind, Local, Place, Position
from mission.navigation.geodesy import LocalFrame


def places_named(kind: LegKind) -> tuple[Place, ...]:
    """As the author wrote them."""
    return LEGS[type(kind)].places(kind)


def places_of(kind: LegKind, frame: LocalFrame | None) -> tuple[Point, ...]:
    """Corners of what is steered along; none for a leg that is not steered to places, or that
    begins wherever it is entered. ``frame`` None: no home is named, and no latitude."""
    named = tuple(local_of(place, frame) for place in places_named(kind))
    return LEGS[type(kind)].corners(kind, named) if named else ()


def pattern_of(kind: LegKind, frame: LocalFrame | None, here: Point) -> Pattern | None:
    """The rows of a leg that is entered ``here``; None where it is no survey."""
    row = LEGS[type(kind)]
    if row.pattern is None:
        return None
    return row.pattern(kind, tuple(local_of(place, frame) for place in row.places(kind)), here)


def local_of(place: Place, frame: LocalFrame | None) -> Point:
    """m from home."""
    if isinstance(place, Local):
        return place.north, place.east
    if isinstance(place, Position) and frame is not None:
        return frame.to_local(math.radians(place.latitude_deg), math.radians(place.longitude_deg))
    return 0.0, 0.0
