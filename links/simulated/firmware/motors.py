"""The motor boards of document 002 on their bus: a force frame, a torque frame, no answer.

The motors stop when neither frame has come for 200 ms (R16).

What does not live here: frames (protocol.vehicles.motorcan), the water (plant.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from random import Random
from typing import Any

from links.simulated.firmware.boards import WaterBoard, pwms
from links.simulated.firmware.ins import Place
from links.simulated.firmware.stm32 import GEAR_MAX
from links.simulated.plant import NEUTRAL, Plant
from protocol.tolerances import Tolerances
from protocol.vehicles import motorcan
from protocol.vehicles.keys import Wire


class MotorBoards(WaterBoard):
    hears = motorcan.LINKS[0]
    period = 0.1  # s between reports, which are empty
    silence = motorcan.SILENCE

    def __init__(self, rng: Random, tolerances: Tolerances, wire: Wire) -> None:
        super().__init__(rng, tolerances, wire)
        self.asked = {"fx_g": 0.0, "fz_g": 0.0, "mz_nm": 0.0}

    def take(self, values: Mapping[str, Any]) -> None:
        self.asked |= {name: values[name] for name in self.asked if name in values}

    def control(self, plant: Plant, now: float) -> tuple[int, ...]:
        if not self.awake(now):
            return NEUTRAL
        asked, full = self.asked, self.wire
        surge = asked["fx_g"] / full["surge_g"]
        down = asked["fz_g"] / full["heave_g"]
        turn = asked["mz_nm"] * full["torque_step"] / full["turn_nm"]
        return pwms(GEAR_MAX * surge, GEAR_MAX * turn, -GEAR_MAX * down)

    def report(self, plant: Plant, place: Place, now: float) -> bytes:
        return b""
