"""The type of a fault of the simulated vehicle, and the parts of a vehicle that faults act upon.

What does not live here: the faults (faults, added_faults), faults of boards (board_faults).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from links.simulated.added import AddedSensors
from links.simulated.firmware.gps import GpsReceiver
from links.simulated.firmware.stm32 import Stm32
from links.simulated.plant import Plant
from links.simulated.sea import Sea
from links.simulated.sensors import Sensors


class Parts(Protocol):
    """The parts of a simulated vehicle that faults act upon."""

    plant: Plant
    sensors: Sensors
    stm32: Stm32
    gps: GpsReceiver
    second_gps: GpsReceiver | None
    added: AddedSensors | None
    usual_splice: float
    sea: Sea
    current: tuple[float, float]  # m/s north, east: the present one

    @property
    def now(self) -> float: ...


Act = Callable[[Parts, float], None]


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault. ``needs``: the key of SETTINGS that fits the faulty part; "": always fitted.
    ``slot``: the part that it changes; "": one that no other fault changes. Of faults with the same
    slot the newest counts. ``adds``: it has no slot, and adds to all others."""

    says: str
    begin: Act
    end: Act
    value: float = 0.0
    unit: str = ""  # of the value; "": the fault has no value
    duration: float = 60.0  # s
    needs: str = ""
    slot: str = ""
    adds: bool = False
