"""What a vehicle reported in a flight, as the laws of limits and commands read it.

    AUV        every whole @SD
    a board    of documents 002 to 004: one report every 2 s, as of the AUV, so that a law's number
               of reports lasts as long; thrusters where the board reports them

What does not live here: the laws, what the engine takes from a report.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from mission.model.vehicle import Vehicle
from mission.verification.rig.trace import Heard
from protocol.messages import Telemetry
from protocol.vehicles import codec
from protocol.vehicles.auv import ACTUATORS, SD

EVERY_S = 2.0
_REPORT = re.compile(rb"@SD.{82}\$", re.DOTALL)
_ANGLES = ("roll_deg", "pitch_deg", "yaw_deg")
_THRUSTERS = tuple(f"pwm_{name}" for name in ACTUATORS[:5])
_NEUTRAL_US, _FULL_US, _ON_US = 1500.0, 500.0, 10.0
_VERTICALS = slice(2, 5)  # of the thrusters


class Report(NamedTuple):
    """deg, yaw to port positive; m; us of the thrusters, empty where none is reported."""

    t: float
    roll: float
    pitch: float
    yaw: float
    depth: float
    pwm: tuple[float, ...]

    @property
    def turning(self) -> bool:
        """Whether the report shows a thruster on."""
        return any(abs(pwm - _NEUTRAL_US) > _ON_US for pwm in self.pwm)

    @property
    def pushing(self) -> bool:
        """Whether the report shows a vertical at more than half of full thrust, up or down."""
        return any(abs(pwm - _NEUTRAL_US) > 0.5 * _FULL_US for pwm in self.pwm[_VERTICALS])

    @property
    def may_turn(self) -> bool:
        return self.turning or not self.pwm


@functools.lru_cache(maxsize=4096)
def decoded(report: bytes) -> Mapping[str, Any]:
    """Decode an @SD, cached since several laws ask for it."""
    return SD.decode(report)


def reports(heard: Sequence[Heard], vehicle: Vehicle) -> Iterator[Report]:
    """Yield the reports that arrived whole and undamaged."""
    return _of_auv(heard) if vehicle.codec == "auv" else _of_board(heard, vehicle)


def _of_auv(heard: Sequence[Heard]) -> Iterator[Report]:
    for one in heard:
        for found in _REPORT.finditer(one.data):
            if SD.check(found[0]) is not None:
                continue
            values = decoded(found[0])
            roll, pitch, yaw = (values[name] for name in _ANGLES)
            if None not in (roll, pitch, yaw):
                depth = math.nan if values["depth_m"] is None else values["depth_m"]
                widths = tuple(values[name] for name in _THRUSTERS)
                yield Report(one.t, roll, pitch, yaw, depth, widths)


def _of_board(heard: Sequence[Heard], vehicle: Vehicle) -> Iterator[Report]:
    due = -math.inf
    for one in heard:
        if one.t < due:
            continue
        for told in codec(*vehicle.speaks).receive(one.data, one.t):
            if isinstance(told, Telemetry) and not told.faults:
                due = one.t + EVERY_S
                yield _report(told, one.t)


def _report(told: Telemetry, t: float) -> Report:
    angles = (told.roll, told.pitch, told.heading)
    roll, pitch, heading = (
        math.nan if a is None else math.degrees(math.remainder(a, math.tau)) for a in angles
    )
    widths = tuple(_NEUTRAL_US + _FULL_US * share for share in told.actuators or ())
    return Report(t, roll, pitch, -heading, math.nan if told.depth is None else told.depth, widths)
