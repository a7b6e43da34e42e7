"""Faults of the boards of documents 002 to 004: rows as in faults.

Faults of the body are the AUV's own rows. A fault of a board has the name of the AUV's similar one.

What does not live here: when faults begin and end (schedule).
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from typing import Any

from links.simulated.fault import Fault
from links.simulated.faults import FAULTS

_BODY = (
    "left_main_weak",
    "right_main_weak",
    "verticals_weak",
    "mains_dead",
    "verticals_dead",
    "heavy",
    "light",
)


def _switch(part: str, says: str, duration: float = 60.0) -> Fault:
    return _set(part, says, 1.0, 0.0, duration=duration)


def _set(
    part: str, says: str, value: float, usual: float, unit: str = "", duration: float = 60.0
) -> Fault:
    """A fault that sets ``part`` of the board's troubles."""

    def begin(vehicle: Any, value: float) -> None:
        setattr(vehicle.board.troubles, part, value)

    def end(vehicle: Any, _: float) -> None:
        setattr(vehicle.board.troubles, part, usual)

    return Fault(says, begin, end, value, unit, duration)


LINE = {
    "stm32_silent": _switch("silent", "the board is heard no more, and goes on", 10.0),
    "command_lost": _switch("deaf", "commands do not arrive", 5.0),
    "bytes_corrupted": _set("corrupt", "a bit turned over in a frame", 0.3, 0.0, "share of frames"),
}
IN_WATER = {
    **{name: FAULTS[name] for name in _BODY},
    "capsized": FAULTS["capsized"],
    "depth_frozen": _switch("depth_frozen", "depth is frozen"),
    "depth_wild": _set("wild", "some depths are anywhere", 0.02, 0.0, "share of readings"),
    "sensors_slow": _set("slow", "its sensors say another so seldom", 0.5, 0.0, "s"),
}
BATTERY = {"battery_low": _set("volts", "low control battery", 9.0, 0.0, "V")}
LEAK = {"leak": _switch("leak", "water inside")}
OF_BOARDS = {
    "coreboard": LINE | IN_WATER | BATTERY | LEAK,
    "rov": LINE | IN_WATER,
    "robot": LINE | BATTERY,
    "mainboard": LINE | IN_WATER | BATTERY | LEAK,
    "motorcan": {name: IN_WATER[name] for name in _BODY},
}
ANY: Mapping[str, Fault] = ChainMap(FAULTS, *OF_BOARDS.values())  # the AUV's own rows first
