"""Fixes, poses and readings of added sensors as values of their topics, for black boxes and views.

What does not live here: which record gives which message (derived).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mission.onboard.stream import wellknown
from protocol.added import GROUND, PLACE, RANGE, WATER
from protocol.messages import Aid, Fix

HOME, GPS = "home", "gps"  # frames
_DIGITS: Mapping[str, int] = {
    **dict.fromkeys(("latitude", "longitude", "latitude_deg", "longitude_deg"), 8),
    "orientation": 6,
    "t": 9,
    "travel_s": 6,
}


def fix_value(fix: Fix) -> Mapping[str, Any]:
    """A value of the topic ``fix``: degrees and metres, null if unknown."""
    return {
        "t": fix.t,
        "latitude_deg": math.degrees(fix.latitude),
        "longitude_deg": math.degrees(fix.longitude),
        "accuracy_m": finite(fix.accuracy),
        "speed_m_s": finite(fix.speed),
        "course_deg": degrees(fix.course),
        "hdop": finite(fix.hdop),
        "elevation_m": finite(fix.elevation),
        "satellites": fix.satellites,
        "utc": fix.utc,
    }


_AIDS: Mapping[str, tuple[str, ...]] = {
    WATER: ("ahead_m_s",),
    GROUND: ("ahead_m_s", "starboard_m_s"),
    PLACE: ("latitude_deg", "longitude_deg"),
    RANGE: ("beacon", "travel_s"),
}


def aid_value(aid: Aid) -> Mapping[str, Any]:
    """A value of the topic ``aid``; fields of other kinds of sensors are null."""
    names = [name for kind in _AIDS.values() for name in kind]
    told = aid.values if aid.kind != PLACE else map(math.degrees, aid.values)
    said = dict(zip(_AIDS[aid.kind], told, strict=True))
    return {"t": aid.t, "kind": aid.kind, **dict.fromkeys(names), **said}


def fix_place(said: Mapping[str, Any], wall: float) -> wellknown.Value:
    """A value of the topic ``fixes``, from a value of ``fix``; ``wall`` in s since 1970 UTC."""
    accuracy = said["accuracy_m"]
    spread = None if accuracy is None else (accuracy**2, 0.0, accuracy**2)
    place = said["latitude_deg"], said["longitude_deg"]
    return wellknown.location(wall, GPS, *place, 0.0, spread)


def pose_value(
    wall: float,
    north: float,
    east: float,
    depth: float | None,
    heading: float,
    pitch: float | None,
    roll: float | None,
) -> wellknown.Value:
    """A value of the topic ``pose``: m from home, rad. Depth, pitch or roll that is not reported
    counts as 0."""
    return wellknown.pose(
        wall, HOME, (north, east, depth or 0.0), (heading, pitch or 0.0, roll or 0.0)
    )


def finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def degrees(value: float | None) -> float | None:
    """Convert rad to degrees; None if the value is missing or not finite."""
    return None if value is None or not math.isfinite(value) else math.degrees(value)


def rounded(value: Any, digits: int = 4) -> Any:
    """Round to 0.1 mm, 0.0001 deg; positions, attitudes and times more finely (_DIGITS)."""
    if isinstance(value, float):
        return round(value, digits)
    if isinstance(value, Mapping):
        return {name: rounded(one, _DIGITS.get(name, digits)) for name, one in value.items()}
    if isinstance(value, list):
        return [rounded(one, digits) for one in value]
    return value
