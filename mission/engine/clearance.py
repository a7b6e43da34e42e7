"""The depth that is sent for a set with a depth and a least height above the bottom.

    depth 8 never below altitude 3      Setpoint(depth=8, altitude=3) in the chart

A vehicle holds one of the two, so it is sent a depth alone: the shallower of the depth asked for
and the bottom less the height, in the steps of its commands. If no altitude is believed for some
seconds (an altimeter misses echoes), the bottom is the sea floor that the mission assumes. A
shallower depth is sent with the report that asks for it. A deeper one is sent only when the echoes
of some seconds leave room, and only to the least room: otherwise noise would steer, and one wrong
echo would lead the vehicle down. A value that repeats is no echo.

What does not live here: what a believed altitude is (navigation's health), the other axes (run).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Self

from mission.engine.vehicle_state import VehicleState
from mission.model import Mission
from mission.model.copies import copied
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint, Telemetry
from protocol.vehicles import vehicle_row

DEEPER_AFTER = 5.0  # s of echoes that leave room, before it goes deeper
DEEPER_ROOM = 0.25  # m of room left below the deeper depth
ECHOES_MISSED = 6.0  # s for which the last bottom counts; a set may be blind as long (run)
_FINE = 0.5  # m: the steps if the vehicle's commands have none


def is_guarded(setpoint: Setpoint) -> bool:
    """Whether a set holds a depth and a height above the bottom at once."""
    return setpoint.depth is not None and setpoint.altitude is not None


def at_depth(setpoint: Setpoint, depth: float | None = None) -> Setpoint:
    """The set that is sent for one with both: at ``depth``, or at the deepest that it may be."""
    return replace(setpoint, depth=setpoint.depth if depth is None else depth, altitude=None)


def step_of(vehicle: Vehicle) -> float:
    """The steps, m, in which a set with both goes down."""
    return vehicle_row(vehicle.codec).granularity.depth or _FINE


class Clearance:
    """The clearance of one vehicle in one mission. ``floor``: the deepest sea floor that is
    assumed, m; ``step``: of the depths that the vehicle can be sent, m."""

    def __init__(self, floor: float, step: float) -> None:
        self._floor, self._step = floor, step
        self._held: float | None = None
        self._begins = True
        self._asked: tuple[float | None, float | None] = None, None  # depth and altitude, m
        self._room_since: float | None = None
        self._room = 0.0  # the least since then
        self._bottom, self._seen = 0.0, -math.inf  # m below the surface, and when it was seen
        self._blind = False
        self._said: float | None = None  # the altitude of the last echo, m, and when it came
        self._echoed = -math.inf

    @classmethod
    def of(cls, mission: Mission, vehicle: Vehicle) -> Self:
        allowed = min(vehicle.limits.depth, mission.safety.depth or math.inf)
        return cls(mission.floor(allowed), step_of(vehicle))

    def clone(self) -> Self:
        return copied(self)

    def begin(self) -> None:
        """Begin a set. Unless it asks for the same as the one before, no depth is held yet. The
        last bottom still counts, but room that was seen before does not."""
        self._begins, self._room_since = True, None

    def blind(self, setpoint: Setpoint) -> float:
        """The depth, m, that a set with both holds without a believed altitude."""
        return self._within(setpoint, self._floor)

    def told(self, setpoint: Setpoint, vehicle_state: VehicleState) -> Setpoint:
        """The set as it is sent to the vehicle now."""
        self._keep(setpoint)
        if not is_guarded(setpoint):
            return setpoint
        now = vehicle_state.now
        echoes = False
        if (bottom := _bottom(vehicle_state)) is not None:
            self._bottom, self._seen = bottom, now
            echoes = self._hears(vehicle_state.telemetry)
        if self._blind is not (blind := now - self._seen > ECHOES_MISSED):
            self._blind, self._room_since = blind, None  # room by one is no room by the other
        if blind:
            most = room = self.blind(setpoint)
            return at_depth(setpoint, self._hold(now, most, room))
        most = self._within(setpoint, self._bottom)
        room = self._within(setpoint, self._bottom - DEEPER_ROOM)
        if not echoes:  # a value that repeats gives no room, but may take some
            room = min(room, self._room) if self._room_since is not None else -math.inf
        return at_depth(setpoint, self._hold(self._echoed, most, room))

    def _keep(self, setpoint: Setpoint) -> None:
        asked = setpoint.depth, setpoint.altitude
        if self._begins and asked != self._asked:
            self._held = self._room_since = None
        self._begins, self._asked = False, asked

    def _hears(self, report: Telemetry | None) -> bool:
        """Whether the report brings an echo: a value that repeats is none."""
        if report is None or report.altitude == self._said:
            return False
        self._said, self._echoed = report.altitude, report.t
        return True

    def _within(self, setpoint: Setpoint, bottom: float) -> float:
        asked, height = setpoint.depth or 0.0, setpoint.altitude or 0.0
        room = bottom - height
        if room >= asked:
            return asked
        return max(0.0, math.floor(room / self._step + 1e-9) * self._step)

    def _hold(self, told: float, most: float, room: float) -> float:
        """Return the depth to hold. ``most``: the deepest allowed; ``room``: the depth that it may
        go down to, by the echo of ``told`` (s)."""
        held = most if self._held is None else min(self._held, most)
        if room <= held:
            self._room_since = None
        elif self._room_since is None:
            self._room_since, self._room = told, room
        else:
            self._room = min(self._room, room)
            if told - self._room_since >= DEEPER_AFTER:
                held, self._room_since = self._room, None
        self._held = held
        return held


def _bottom(vehicle_state: VehicleState) -> float | None:
    """The bottom, m below the surface, by a believed depth and altitude; else None."""
    seen = vehicle_state.estimate
    if seen is None or seen.depth is None or seen.altitude is None:
        return None
    if vehicle_state.depth is None or not vehicle_state.health("altitude").valid:
        return None
    return seen.depth + seen.altitude
