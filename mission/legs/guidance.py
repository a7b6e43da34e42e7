"""Line of sight: the heading that brings a vehicle onto a line and along it, in a current.

    desired course = bearing of the line - atan(cross-track / lookahead)
    heading        = course - asin(current across the course / speed through the water)

Source: T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), section
10.3, lookahead-based steering; the second line is the wind triangle.
"""

from __future__ import annotations

import math
from types import MappingProxyType

from mission.legs.base import Point, Track, wrap
from mission.legs.words import Choice
from mission.model import Axis, Estimate

# For every leg that steers by the estimate: the axes that it sets, the readings that it needs, and
# the guard variables that only such a leg has.
STEERS = frozenset({Axis.HEADING})
NEEDS = frozenset({"position", "heading"})
GIVES = frozenset({"distance", "cross_track"})
# To which side, for the legs that turn.
SIDE = Choice(
    "side",
    MappingProxyType({"port": -1, "starboard": 1}),
    1,
    "of the next rows; of a circle: starboard is clockwise",
)

LOOKAHEAD = 12.0  # m; several times the vehicle's turning radius of 2 m
_MOST_CRAB = math.radians(60.0)


def along(start: Point, end: Point, here: Point) -> Track:
    """The position of ``here`` against the line; past its end the distance is negative."""
    bearing = math.atan2(end[1] - start[1], end[0] - start[0])
    to_end = (end[0] - here[0], end[1] - here[1])
    distance = math.hypot(*to_end)
    ahead = math.atan2(to_end[1], to_end[0])
    left = to_end[0] * math.cos(bearing) + to_end[1] * math.sin(bearing)
    cross = to_end[0] * math.sin(bearing) - to_end[1] * math.cos(bearing)
    return Track(distance if left >= 0.0 else -distance, cross, bearing, ahead)


def course_on(track: Track) -> float:
    """The course over ground that leads back to the line, or to its end once it is passed."""
    if track.distance < 0.0:
        return track.ahead
    return track.bearing - math.atan2(track.cross_track, min(LOOKAHEAD, track.distance + 1.0))


def heading_for(course: float, estimate: Estimate) -> float:
    """The heading, in [0, 2 pi), for a course in the estimated current. If the current is too
    strong, the heading is the one that holds against it best."""
    speed = max(estimate.speed, 0.1)
    across = estimate.current_east * math.cos(course) - estimate.current_north * math.sin(course)
    crab = math.asin(max(-1.0, min(1.0, across / speed)))
    crab = max(-_MOST_CRAB, min(_MOST_CRAB, crab))
    return wrap(course - crab) % (2.0 * math.pi)
