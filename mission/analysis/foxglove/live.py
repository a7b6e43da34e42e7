"""A monitor's frames of a vehicle under way, as messages of the same topics as its black box.

A monitor sends less than is recorded, at most five times a second. What it does not send is null.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import MissionErrors, digest, parse_script
from mission.model import Position
from mission.model.shipped import load_vehicle
from mission.model.vehicle import VehicleError
from mission.navigation.distribution import PLANE_95, of_principal
from mission.navigation.geodesy import LocalFrame
from mission.onboard.stream import topics, wellknown
from mission.onboard.stream.derived import VEHICLE_FRAME, Message
from mission.onboard.stream.places import fix_place, pose_value
from mission.onboard.stream.plan import plan_geojson
from mission.topside.monitor import Frame, Watched

TOPICS = (
    topics.STATE, topics.TELEMETRY, topics.POSITION, topics.POSE, topics.FIX, topics.FIXES,
    topics.JOURNAL, topics.PLAN,
)  # fmt: skip
_LIMITS = ("depth", "radius", "time", "voltage")


class Live:
    """Turns frames into messages. ``wall``: when the frame came, s since 1970 UTC."""

    def __init__(self) -> None:
        self._reported: float | None = None
        self._fixed: float | None = None
        self._plan: Sequence[str] = ()
        self._state, self._since = "", 0.0

    def receive(self, watched: Watched, frame: Frame, wall: float) -> Iterator[Message]:
        """``watched`` has already taken the frame."""
        t, seen = float(frame["t"]), watched.state
        for line in frame.get("events", ()):
            yield Message(topics.JOURNAL, t, wellknown.log(wall, wellknown.INFO, "vehicle", line))
        if watched.plan != self._plan:
            self._plan = watched.plan
            yield from _planned(t, self._plan)
        if "state" not in frame:
            return
        if seen.get("state", "") != self._state:
            self._state, self._since = seen.get("state", ""), t
        yield Message(topics.STATE, t, self._situation(t, seen))
        yield from _placed(t, wall, seen)
        yield from self._fix(t, wall, seen)
        if (at := seen.get("report_at")) is not None and at != self._reported:
            self._reported = at
            yield Message(topics.TELEMETRY, t, _telemetry(at, seen))

    def _fix(self, t: float, wall: float, seen: Mapping[str, Any]) -> Iterator[Message]:
        fix = seen.get("fix")
        if fix is None or fix["t"] == self._fixed:
            return
        self._fixed = fix["t"]
        yield Message(topics.FIX, fix["t"], fix)
        yield Message(topics.FIXES, fix["t"], fix_place(fix, wall + fix["t"] - t))

    def _situation(self, t: float, seen: Mapping[str, Any]) -> Mapping[str, Any]:
        began, fixed = seen.get("mission_began"), seen.get("fix_at")
        north, east = seen.get("current") or (None, None)
        ellipse = seen.get("ellipse")
        nothing = dict.fromkeys(topics.TOPICS[topics.STATE].schema["properties"])
        return nothing | {
            "t": t,
            "state": self._state,
            "leg": seen.get("leg") or "",
            "since_s": t - self._since,
            "mission_time_s": None if began is None else t - began,
            "digest": seen.get("mission") or "",
            "latitude_deg": seen.get("latitude"),
            "longitude_deg": seen.get("longitude"),
            **dict(zip(("north_m", "east_m"), _local(seen) or (None, None), strict=True)),
            "depth_m": seen.get("depth"),
            "altitude_m": seen.get("altitude"),
            "heading_deg": seen.get("heading"),
            "speed_m_s": seen.get("speed"),
            "current_north_m_s": north,
            "current_east_m_s": east,
            "radius_95_m": ellipse[0] if ellipse else None,
            "fix_age_s": None if fixed is None else t - fixed,
            **_margins(seen),
            "commander": seen.get("commander") or "",
        }


def _margins(seen: Mapping[str, Any]) -> Mapping[str, Any]:
    left = {name: (seen.get(f"to_{name}") or [None])[0] for name in _LIMITS}
    minutes = left["time"]
    return {
        "to_depth_m": left["depth"],
        "to_radius_m": left["radius"],
        "to_time_s": None if minutes is None else 60.0 * minutes,
        "to_voltage_v": left["voltage"],
        "breached": [name for name in _LIMITS if (left[name] or 0.0) < 0.0],
    }


def _telemetry(at: float, seen: Mapping[str, Any]) -> Mapping[str, Any]:
    nothing = dict.fromkeys(topics.TOPICS[topics.TELEMETRY].schema["properties"])
    return nothing | {
        "t": at,
        "depth_m": seen.get("depth"),
        "altitude_m": seen.get("altitude"),
        "heading_deg": seen.get("heading"),
        "pitch_deg": seen.get("pitch"),
        "roll_deg": seen.get("roll"),
        "control_v": seen.get("battery"),
        "actuators": {},
        "faults": [],
    }


def _placed(t: float, wall: float, seen: Mapping[str, Any]) -> Iterator[Message]:
    latitude, longitude = seen.get("latitude"), seen.get("longitude")
    if latitude is None or longitude is None:
        return
    covariance = None
    if (ellipse := seen.get("ellipse")) is not None:
        great, small = (axis / PLANE_95 for axis in ellipse[:2])
        covariance = of_principal(great, small, math.radians(ellipse[2]))
    depth = seen.get("depth") or 0.0
    said = wellknown.location(wall, VEHICLE_FRAME, latitude, longitude, -depth, covariance)
    yield Message(topics.POSITION, t, said)
    heading, pitch, roll = (_radians(seen.get(name)) for name in ("heading", "pitch", "roll"))
    if heading is not None and (local := _local(seen)) is not None:
        yield Message(topics.POSE, t, pose_value(wall, *local, depth, heading, pitch, roll))


def _local(seen: Mapping[str, Any]) -> tuple[float, float] | None:
    """Return north and east of home, m."""
    latitude, longitude, origin = (seen.get(n) for n in ("latitude", "longitude", "origin"))
    if latitude is None or longitude is None or origin is None:
        return None
    return LocalFrame(Position(*origin)).to_local(math.radians(latitude), math.radians(longitude))


def _radians(value: float | None) -> float | None:
    return None if value is None else math.radians(value)


def _planned(t: float, lines: Sequence[str]) -> Iterator[Message]:
    """Yield the plan; nothing while it is incomplete or is for a vehicle that is not known here."""
    with contextlib.suppress(MissionErrors, VehicleError, OSError):
        mission = parse_script(lines)
        if mission.home is not None:
            vehicle = load_vehicle(mission.vehicle)
            chart = compile_mission(mission, vehicle, digest(mission))
            plan = plan_geojson(chart, vehicle, mission.home)
            yield Message(topics.PLAN, t, {"geojson": json.dumps(plan)})
