"""JSON Schemas that Foxglove and similar programs know by name, and values of these schemas.

Source: the JSON Schemas of the package @foxglove/schemas, reduced to the fields used here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from mission.onboard.stream.schemas import Schema, count, listed, number, table, text

Value = Mapping[str, Any]

LOCATION_FIX, POSE_IN_FRAME = "foxglove.LocationFix", "foxglove.PoseInFrame"
LOG, GEO_JSON = "foxglove.Log", "foxglove.GeoJSON"
INFO, WARNING, ERROR = 2, 3, 4  # levels of a Log
_UNKNOWN, _KNOWN = 0, 3  # types of a covariance

_STAMP = table("wall time", sec=count("s since 1970 UTC"), nsec=count("ns"))
_NUMBER: Schema = {"type": "number"}


def _numbers(*names: str) -> Schema:
    return table("", **dict.fromkeys(names, _NUMBER))


SCHEMAS: Mapping[str, Schema] = {
    LOCATION_FIX: table(
        "a place on the earth",
        timestamp=_STAMP,
        frame_id=text("of the sensor"),
        latitude=number("deg", "north positive, WGS 84"),
        longitude=number("deg", "east positive, WGS 84"),
        altitude=number("m", "above the surface"),
        position_covariance=listed(_NUMBER, "m^2, of east, north, up, row by row"),
        position_covariance_type=count("0 unknown, 3 known"),
    ),
    POSE_IN_FRAME: table(
        "place and attitude in a frame",
        timestamp=_STAMP,
        frame_id=text("the frame: x east, y north, z up of home"),
        pose=table(
            "m, and a quaternion from the body (x forward, y port, z up) to the frame",
            position=_numbers("x", "y", "z"),
            orientation=_numbers("x", "y", "z", "w"),
        ),
    ),
    LOG: table(
        "a line of a journal",
        timestamp=_STAMP,
        level=count("1 debug, 2 info, 3 warning, 4 error, 5 fatal"),
        message=text("what happened"),
        name=text("of what"),
        file=text("empty"),
        line=count("0"),
    ),
    GEO_JSON: table("features of a map", geojson=text("a GeoJSON text (RFC 7946)")),
}


def stamp(wall: float) -> Value:
    """A timestamp. ``wall``: s since 1970 UTC."""
    sec = math.floor(wall)
    return {"sec": sec, "nsec": min(int((wall - sec) * 1e9), 999_999_999)}


def location(
    wall: float,
    frame: str,
    latitude_deg: float,
    longitude_deg: float,
    altitude: float,
    covariance: tuple[float, float, float] | None,
) -> Value:
    """A LocationFix. ``covariance``: (nn, ne, ee) of north and east, m^2."""
    nn, ne, ee = covariance or (0.0, 0.0, 0.0)
    return {
        "timestamp": stamp(wall),
        "frame_id": frame,
        "latitude": latitude_deg,
        "longitude": longitude_deg,
        "altitude": altitude,
        "position_covariance": [ee, ne, 0.0, ne, nn, 0.0, 0.0, 0.0, 0.0],
        "position_covariance_type": _KNOWN if covariance else _UNKNOWN,
    }


def pose(wall: float, frame: str, place: Sequence[float], angles: Sequence[float]) -> Value:
    """A PoseInFrame. ``place``: north, east, depth in m; ``angles``: heading (clockwise from
    north), pitch (nose up) and roll (starboard down) in rad."""
    north, east, depth = place
    return {
        "timestamp": stamp(wall),
        "frame_id": frame,
        "pose": {
            "position": {"x": east, "y": north, "z": -depth},
            "orientation": dict(zip("xyzw", _quaternion(*angles), strict=True)),
        },
    }


def _quaternion(heading: float, pitch: float, roll: float) -> tuple[float, float, float, float]:
    """(x, y, z, w). Yaw counts from east to north; nose up is a negative turn about port."""
    yaw, tilt = math.pi / 2.0 - heading, -pitch
    cy, sy = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    cp, sp = math.cos(tilt / 2.0), math.sin(tilt / 2.0)
    cr, sr = math.cos(roll / 2.0), math.sin(roll / 2.0)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def log(wall: float, level: int, name: str, message: str) -> Value:
    head = {"timestamp": stamp(wall), "level": level, "message": message}
    return head | {"name": name, "file": "", "line": 0}
