"""Derive topics from the records: decoded values, positions on the earth, margins to limits, texts.

    Derivation: every record of one run of the program, in order --receive--> Messages

This module decides and estimates nothing. It decodes, converts and combines values, and rounds them
to the resolution of a sensor (the records keep every bit). The rows of the topics, with the unit of
each field, are in ``topics``; a method here makes the values of each.

What does not live here: files (blackbox), texts of events (events), maps (plan).
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import MissionErrors, parse_script
from mission.model import Chart, Estimate, NavigationMode, Record
from mission.navigation.distribution import PLANE_95
from mission.navigation.geodesy import LocalFrame
from mission.onboard.runtime import records as rec
from mission.onboard.stream import topics, wellknown
from mission.onboard.stream.events import events_of
from mission.onboard.stream.places import (
    aid_value,
    degrees,
    finite,
    fix_place,
    fix_value,
    pose_value,
    rounded,
)
from mission.onboard.stream.plan import plan_geojson
from mission.onboard.stream.senses import Senses
from protocol.messages import Aid, Fix, Telemetry
from protocol.vehicles import auv, rov

VEHICLE_FRAME = "vehicle"
_ACTUATORS: Mapping[str, tuple[str, ...]] = {"auv": auv.ACTUATORS, "rov": rov.THRUSTERS}


@dataclass(frozen=True, slots=True)
class Message:
    """A message of a derived topic; ``value`` follows the topic's schema."""

    topic: str
    t: float  # s, the engine's time
    value: Mapping[str, Any]


class Derivation:
    """Derives the messages of one run. ``start``: its first record. Raises ValueError, KeyError or
    TypeError if this version cannot read it."""

    def __init__(self, start: Record) -> None:
        self.start = rec.read_start(start)
        self._senses = Senses(self.start.vehicle)
        self._standing: rec.Standing | None = None
        self._frame: LocalFrame | None = None
        self._chart: Chart | None = None
        self._report: Telemetry | None = None
        self._state, self._since = "", 0.0
        self._began: float | None = None  # the mission under way

    def remember(self, record: Record) -> None:
        """Take in a record for the values that stay in force, without deriving messages."""
        if record.kind == rec.STEP:
            self._step(record)
        elif record.kind in (rec.STANDING, rec.MISSION):
            for _ in self._made(record):
                pass

    def receive(self, record: Record) -> Iterator[Message]:
        for message in self._made(record):
            yield Message(message.topic, message.t, rounded(message.value))

    def _made(self, record: Record) -> Iterator[Message]:
        yield from self._events(record)
        for sensed in self._senses.hear(record):
            if isinstance(sensed, Telemetry):
                self._report = sensed
                yield Message(topics.TELEMETRY, sensed.t, self._telemetry(sensed))
            elif isinstance(sensed, Aid):
                yield Message(topics.AID, sensed.t, aid_value(sensed))
            else:
                yield from self._fix(sensed)
        if record.kind == rec.STEP:
            self._step(record)
        elif record.kind == rec.STANDING:
            yield from self._stand(record)
        elif record.kind == rec.MISSION:
            yield from self._load(record)
        elif record.kind == rec.ESTIMATE:
            yield from self._estimate(rec.estimate_of(record.payload))

    @property
    def chart(self) -> Chart | None:
        """The mission in the store; None if there is none that this version can read."""
        return self._chart

    @property
    def standing(self) -> rec.Standing | None:
        return self._standing

    def wall(self, t: float) -> float:
        return self.start.wall + t

    # --- what is remembered ----------------------------------------------------------------------

    def _step(self, record: Record) -> None:
        step = rec.step_of(record.payload)
        if not step.entered:
            return
        self._state, self._since = step.entered[-1], step.t
        if step.trigger == "start" and self._began is None:
            self._began = step.t
        elif not self._state.startswith(("autonomous", "manual")):
            self._began = None

    def _stand(self, record: Record) -> Iterator[Message]:
        self._standing = rec.read_standing(record)
        origin = self._standing.origin
        if origin is None:
            self._frame = None
        elif self._frame is None or self._frame.origin != origin:
            self._frame = LocalFrame(origin)
            yield from self._plan(record.t)

    def _load(self, record: Record) -> Iterator[Message]:
        said = json.loads(record.payload)
        self._chart = None
        with contextlib.suppress(MissionErrors):  # this version cannot read it
            if said["digest"]:
                mission = parse_script(said["lines"], self.start.vehicle)
                self._chart = compile_mission(mission, self.start.vehicle, said["digest"])
        yield from self._plan(record.t)

    # --- what is made ----------------------------------------------------------------------------

    def _plan(self, t: float) -> Iterator[Message]:
        home = self._chart.mission.home if self._chart else None
        origin = home or (self._frame.origin if self._frame else None)
        if self._chart is not None and origin is not None:
            features = plan_geojson(self._chart, self.start.vehicle, origin)
            yield Message(topics.PLAN, t, {"geojson": json.dumps(features)})

    def _events(self, record: Record) -> Iterator[Message]:
        for event in events_of(record):
            said = wellknown.log(self.wall(event.t), event.level, event.of, event.says)
            yield Message(topics.JOURNAL, event.t, said)

    def _telemetry(self, seen: Telemetry) -> Mapping[str, Any]:
        volts = seen.batteries or (None, None)
        place = seen.position or (None, None)
        return {
            "t": seen.t,
            "depth_m": finite(seen.depth),
            "altitude_m": finite(seen.altitude),
            "heading_deg": degrees(seen.heading),
            "pitch_deg": degrees(seen.pitch),
            "roll_deg": degrees(seen.roll),
            "temperature_c": finite(seen.temperature_c),
            "control_v": finite(volts[0]),
            "power_v": finite(volts[1]),
            "actuators": self._actuators(seen),
            "magnetic_ut": _list(seen.magnetic, 1e6),
            "latitude_deg": degrees(place[0]),
            "longitude_deg": degrees(place[1]),
            "velocity_m_s": _list(seen.velocity),
            "leak": seen.leak,
            "faults": list(seen.faults),
        }

    def _actuators(self, seen: Telemetry) -> Mapping[str, float]:
        shares = seen.actuators or ()
        names = _ACTUATORS.get(self.start.vehicle.codec, ())
        if len(names) != len(shares):
            names = tuple(str(number + 1) for number in range(len(shares)))
        return {n: s for n, s in zip(names, shares, strict=True) if math.isfinite(s)}

    def _fix(self, fix: Fix) -> Iterator[Message]:
        said = fix_value(fix)
        yield Message(topics.FIX, fix.t, said)
        yield Message(topics.FIXES, fix.t, fix_place(said, self.wall(fix.t)))

    def _estimate(self, seen: Estimate) -> Iterator[Message]:
        place = self._place(seen)
        yield Message(topics.STATE, seen.t, self._situation(seen, place))
        if place is None:
            return
        wall, depth = self.wall(seen.t), seen.depth or 0.0
        where = wellknown.location(wall, VEHICLE_FRAME, *place, -depth, seen.covariance)
        yield Message(topics.POSITION, seen.t, where)
        if seen.heading is not None:
            report = self._report
            tilt = (report.pitch, report.roll) if report else (None, None)
            pose = pose_value(wall, seen.north, seen.east, seen.depth, seen.heading, *tilt)
            yield Message(topics.POSE, seen.t, pose)

    def _place(self, seen: Estimate) -> tuple[float, float] | None:
        """Latitude and longitude in degrees; None if no position is known."""
        if self._frame is None or seen.mode is NavigationMode.NONE:
            return None
        latitude, longitude = self._frame.to_geodetic(seen.north, seen.east)
        return math.degrees(latitude), math.degrees(longitude)

    def _situation(self, seen: Estimate, place: tuple[float, float] | None) -> Mapping[str, Any]:
        standing, located = self._standing, seen.mode is not NavigationMode.NONE
        mission_time = None if self._began is None else seen.t - self._began
        autonomous = self._state.startswith("autonomous/")
        return {
            "t": seen.t,
            "state": self._state,
            "leg": self._state.partition("/")[2] if autonomous else "",
            "since_s": seen.t - self._since,
            "mission_time_s": mission_time,
            "digest": standing.digest if standing else "",
            "latitude_deg": place[0] if place else None,
            "longitude_deg": place[1] if place else None,
            "north_m": seen.north if located else None,
            "east_m": seen.east if located else None,
            "depth_m": seen.depth,
            "altitude_m": seen.altitude,
            "heading_deg": degrees(seen.heading),
            "speed_m_s": seen.speed,
            "current_north_m_s": seen.current_north,
            "current_east_m_s": seen.current_east,
            "radius_95_m": radius_95(seen.covariance) if located else None,
            "fix_age_s": seen.fix_age,
            "nis": seen.nis[0] if seen.nis else None,
            **self._margins(seen, mission_time, located),
            "breached": list(standing.breached) if standing else [],
            "commander": standing.commander if standing else "",
        }

    def _margins(
        self, seen: Estimate, mission_time: float | None, located: bool
    ) -> Mapping[str, float | None]:
        standing, report = self._standing, self._report
        volts = report.batteries[0] if report and report.batteries else None
        if self.start.vehicle.constant_batteries:
            volts = None
        if standing is None:
            return dict.fromkeys(MARGINS)
        far = math.hypot(seen.north, seen.east)
        return {
            "to_depth_m": None if seen.depth is None else standing.depth - seen.depth,
            "to_radius_m": standing.radius - far if located else None,
            "to_time_s": None if mission_time is None else standing.time - mission_time,
            "to_voltage_v": None if volts is None else finite(volts - standing.voltage),
        }


MARGINS = ("to_depth_m", "to_radius_m", "to_time_s", "to_voltage_v")


def radius_95(covariance: tuple[float, float, float]) -> float:
    """Semi-major axis of the 95 % ellipse, m, from the covariance (nn, ne, ee), m^2."""
    nn, ne, ee = covariance
    middle, spread = (nn + ee) / 2.0, math.hypot((nn - ee) / 2.0, ne)
    return PLANE_95 * math.sqrt(max(middle + spread, 0.0))


def _list(values: tuple[float, ...] | None, scale: float = 1.0) -> list[float] | None:
    if values is None or not all(map(math.isfinite, values)):
        return None
    return [value * scale for value in values]
