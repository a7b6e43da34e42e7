"""The sensor board of document 002 (tables 4-1 and 4-2), with the motor boards of the same body.

It reports at 10 Hz. The INS (ins.py) has GPS at the surface alone. USBL and DVL data are valid only
while these have power. The drop weight can be released only once.

What does not live here: frames (protocol.vehicles.coreboard), the motor boards (motors).
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, degrees, sin
from random import Random
from typing import Any

from links.simulated.firmware.boards import DEPTH, POWER_V
from links.simulated.firmware.gps import ANTENNA
from links.simulated.firmware.ins import Ins, Place
from links.simulated.firmware.motors import MotorBoards
from links.simulated.plant import Plant
from protocol.framing import Frame
from protocol.tolerances import Tolerances
from protocol.vehicles import coreboard
from protocol.vehicles.keys import Wire

DROPPED_N = 40.0  # buoyancy gained by the drop of the weight (assumed)
_DVL, _GPS, _INS, _USBL = 1, 2, 4, 16  # valid bits
_MOST_OF_A_RECORD = 0x07  # greatest first byte of a CAN record
_OFF: Mapping[str, Any] = dict.fromkeys((*coreboard.SENSOR_SWITCHES, "led1", "led2"), 0)


class SensorBoard(MotorBoards):
    def __init__(self, rng: Random, tolerances: Tolerances, wire: Wire) -> None:
        super().__init__(rng, tolerances, wire)
        self.told: Mapping[str, Any] = _OFF
        self._ins = Ins(rng)
        self.dropped = False
        self._told_framer = coreboard.LINKS[1].framer(tolerances)
        self._frame = coreboard.sensor_to_main(tolerances)

    def receive(self, data: bytes, now: float) -> None:
        """Take CAN records of the bus, or bytes of the line. One call holds only one of the two."""
        if data and data[0] <= _MOST_OF_A_RECORD:
            super().receive(data, now)
            return
        for item in self._told_framer.receive(data, now):
            if isinstance(item, Frame):
                self.told = item.values()
                self._ins.switch(bool(self.told["ins"]), now)

    def control(self, plant: Plant, now: float) -> tuple[int, ...]:
        if self.told["drop_weight"] and not self.dropped:
            self.dropped = True
            plant.buoyancy += DROPPED_N
        return super().control(plant, now)

    def report(self, plant: Plant, place: Place, now: float) -> bytes:
        roll, pitch, yaw, depth = self._pose(plant, now)
        own = self._ins.place(place, plant.depth, now)
        valid = _DVL * self.told["dvl"] + _USBL * self.told["usbl"]
        if own:
            valid |= _INS | (_GPS if plant.depth <= ANTENNA else 0)
        gauss = self.rng.gauss
        wet = bool(self.troubles.leak)
        digit = int(self.tolerances["leak002"])
        older = int(self.tolerances["leak23"])
        values: dict[str, Any] = {
            **dict.fromkeys((f"ad{n}" for n in range(1, 5)), 0),
            **dict.fromkeys(("mx", "my", "mz", "vo_x", "vo_y", "vo_z"), 0.0),
            **dict.fromkeys(("usbl_x_m", "usbl_y_m", *(f"usbl{n}" for n in range(1, 7))), 0.0),
            "reserved12": "00" * 2,
            "reserved18": "00" * 5,
            "reserved124": "00" * 3,
            "temperature_c": 18.0,
            "temperature2_c": 18.0,
            "depth_m": depth,
            "altitude_m": plant.floor - plant.depth + gauss(0.0, DEPTH),
            "leak": digit if wet else 1 - digit,
            "leak_legacy_raw": older if wet else 1 - older,
            "roll_deg": roll,
            "pitch_deg": pitch,
            "yaw_deg": yaw,
            "p": degrees(plant.p),
            "q": degrees(plant.q),
            "r": degrees(plant.r),
            "ax": sin(plant.pitch),
            "ay": -sin(plant.roll) * cos(plant.pitch),
            "az": -cos(plant.roll) * cos(plant.pitch),
            "dvl_x": plant.u if self.told["dvl"] else 0.0,
            "dvl_y": 0.0,
            "dvl_z": 0.0,
            "lat_deg": degrees(own[0]) if own else 0.0,
            "lon_deg": degrees(own[1]) if own else 0.0,
            "control_v": self.control_volts(),
            "power_v": self.volts(POWER_V),
            "ins_aligned": int(own is not None),
            "buf": "00" * 4,
            "valid": valid,
        }
        return self._frame.encode(values)
