"""The places that a leg names, in metres from home; the leg leads between them.

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
    """The places as the author wrote them."""
    return LEGS[type(kind)].places(kind)


def places_of(kind: LegKind, frame: LocalFrame | None) -> tuple[Point, ...]:
    """The corners of the steered way, m from home. None for a leg that does not steer to places, or
    that begins wherever it is entered. ``frame`` None: the mission names no home, and the leg no
    latitude."""
    named = tuple(local_of(place, frame) for place in places_named(kind))
    return LEGS[type(kind)].corners(kind, named) if named else ()


def pattern_of(kind: LegKind, frame: LocalFrame | None, here: Point) -> Pattern | None:
    """The rows of a leg that is entered at ``here``; None if the leg has no rows."""
    row = LEGS[type(kind)]
    if row.pattern is None:
        return None
    return row.pattern(kind, tuple(local_of(place, frame) for place in row.places(kind)), here)


def local_of(place: Place, frame: LocalFrame | None) -> Point:
    """A place in m from home; home itself for a position without a ``frame``."""
    if isinstance(place, Local):
        return place.north, place.east
    if isinstance(place, Position) and frame is not None:
        return frame.to_local(math.radians(place.latitude_deg), math.radians(place.longitude_deg))
    return 0.0, 0.0
