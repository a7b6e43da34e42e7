"""The robot's channels (document 004): side moves, gimbal, power module, handshake.

    side 3..8      robot     moves that no setpoint asks for, while it neither drives nor spins
    gimbal_*       gimbal    both angles in one frame; both 0: the command "centre"
    *_v *_a *_w    power     one text to the power module each

A side move is sent with the motion, and repeated with it. The others have frames of their own, made
once for each change. What does not live here: the frames (protocol.vehicles.robot).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from protocol.messages import Telemetry
from protocol.vehicles.channels import Channel, Source

GIMBAL, POWER, ROBOT = 2, 4, 1
HANDSHAKE = 0xFF
SIDES = (0, *range(3, 9))
_STATED = math.nan  # at rest: only the builder knows it, so the vehicle file states ``safe``
_DRIVES = ("surge", "turn")


def _alarm(name: str, unit: str, most: float, what: str) -> Channel:
    return Channel(name, unit, 0, most, f"alarm of the power module: {what}", _STATED, False)


CHANNELS: tuple[Channel, ...] = (
    Channel("side", "", 0, 8, "3 right up, 4 left up, 5 right down, 6 left down, 7 right, 8 left",
            excludes=_DRIVES, choices=SIDES),
    Channel("side_speed_mm_s", "mm/s", 0, 32_767, "speed of a side move", excludes=_DRIVES),
    Channel("gimbal_yaw_deg", "deg", -180, 180, "angle of the gimbal", whole=False),
    Channel("gimbal_pitch_deg", "deg", -180, 180, "angle of the gimbal", whole=False),
    Channel("zoom", "", 0, 255, "of the camera"),
    Channel("video", "", 1, 3, "1 visible, 2 infrared, 3 both", 1),
    Channel("power_query", "", 0, 4, "1 to 4: asks the power module AT, AT+V, AT+C, AT+P"),
    Channel("max_current_a", "A", 0, 255, "of the power module", _STATED),
    Channel("alarm_mode", "", 1, 5, "1 OVERV, 2 UNDERV, 3 OVERC, 4 UNDERC, 5 OVERP", _STATED),
    _alarm("over_voltage_v", "V", 36, "voltage above"),
    _alarm("under_voltage_v", "V", 36, "voltage below"),
    _alarm("over_current_a", "A", 40, "current above"),
    _alarm("under_current_a", "A", 40, "current below"),
    _alarm("over_power_w", "W", 1080, "power above"),
    Channel("handshake", "", 0, 1, "1: asks for one report at once"),
)  # fmt: skip

_ANGLES = ("gimbal_yaw_deg", "gimbal_pitch_deg")
_ONE = (  # commands that set the same thing: centre and angles, the queries to the power module
    ((GIMBAL, 0), (GIMBAL, 2)),
    ((POWER, 0), (POWER, 1), (POWER, 2), (POWER, 3)),
)
_THOUSANDTHS = (
    *("over_voltage_v", "under_voltage_v", "over_current_a", "under_current_a", "over_power_w"),
)
_PLAIN = {
    "video": (GIMBAL, 1),
    "zoom": (GIMBAL, 3),
    "max_current_a": (POWER, 4),
    "alarm_mode": (POWER, 5),
}


def _speed(report: Telemetry) -> float | None:
    return None if report.velocity is None else round(1000.0 * report.velocity[0], 6)


SOURCES: tuple[Source, ...] = (
    Source("speed_mm_s", "mm/s", "its own speed, ahead positive", _speed),
)


def commands(given: Iterable[str], levels: Mapping[str, float]) -> Iterator[Mapping[str, Any]]:
    """Yield values of ``robot.DOWN`` for the channels ``given``, but for those of a side move,
    which is sent with the motion."""
    names = list(given)
    if any(name in _ANGLES for name in names):
        yield _gimbal(*(levels[name] for name in _ANGLES))
    for name in names:
        level = levels[name]
        if name in _PLAIN:
            address, command = _PLAIN[name]
            yield {"address": address, "command": command, name: int(level)}
        elif name == "power_query" and level:
            yield {"address": POWER, "command": int(level) - 1}
        elif name in _THOUSANDTHS:
            command = 6 + _THOUSANDTHS.index(name)
            yield {"address": POWER, "command": command, "thousandths": round(1000 * level)}
        elif name == "handshake" and level:
            yield {"address": ROBOT, "command": HANDSHAKE}


def sets(values: Mapping[str, Any]) -> str:
    """Return a name of what these values set; commands that set the same thing have one name."""
    address, command = values["address"], values["command"]
    first = next((row[0] for row in _ONE if (address, command) in row), (address, command))
    return f"{first[0]} {first[1]}"


def _gimbal(yaw: float, pitch: float) -> Mapping[str, Any]:
    if not (yaw or pitch):
        return {"address": GIMBAL, "command": 0}
    angles = {"yaw_cdeg": round(100 * yaw), "pitch_cdeg": round(100 * pitch)}
    return {"address": GIMBAL, "command": 2, **angles}
