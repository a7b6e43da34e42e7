"""The bounds in force, and the last check before a setpoint is sent.

The tightest of three is in force: the mission's bound, the operator's (@SP), or the vehicle file's
hard limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mission.model import Safety
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint, SetSafety


@dataclass(frozen=True, slots=True)
class Bounds:
    radius: float
    time: float
    depth: float
    voltage: float


def in_force(vehicle: Vehicle, mission: Safety | None, operator: SetSafety) -> Bounds:
    """The tightest of the three; the voltage is a lower bound."""
    hard, own = vehicle.limits, mission or Safety()

    def least(*values: float | None) -> float:
        return min(v for v in values if v is not None)

    voltages = [v for v in (hard.voltage, own.voltage, operator.voltage) if v is not None]
    return Bounds(
        radius=least(hard.radius, own.radius, operator.radius),
        time=least(hard.time, own.time, operator.time),
        depth=least(hard.depth, own.depth, operator.depth),
        voltage=max(voltages),
    )


def admit(setpoint: Setpoint, bounds: Bounds, vehicle: Vehicle) -> str:
    """Why a setpoint must not be sent; "" if it may."""
    s = setpoint
    for name in ("surge", "turn", "heave"):
        value = getattr(s, name)
        if value is not None and not -1.0 <= value <= 1.0:
            return f"{name} {value:g} is beyond full thrust"
    for name in ("heading", "depth", "altitude", "pitch", "roll"):
        value = getattr(s, name)
        if value is not None and not math.isfinite(value):
            return f"{name} is not a number"
    if s.depth is not None and s.depth > bounds.depth:
        return f"depth {s.depth:g} m is beyond the limit in force, {bounds.depth:g} m"
    if sum(axis is not None for axis in (s.depth, s.altitude, s.heave)) > 1:
        return "depth, altitude and heave exclude each other"
    return ""
