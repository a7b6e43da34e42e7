"""What a fault of the simulated vehicle is, and what of a vehicle it acts upon.

What does not live here: the faults (faults, added_faults), those of boards (board_faults).
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
    """What of a simulated vehicle a fault acts upon."""

    plant: Plant
    sensors: Sensors
    stm32: Stm32
    gps: GpsReceiver
    second_gps: GpsReceiver | None
    added: AddedSensors | None
    usual_splice: float
    sea: Sea
    current: tuple[float, float]  # m/s north, east: what sets now

    @property
    def now(self) -> float: ...


Act = Callable[[Parts, float], None]


@dataclass(frozen=True, slots=True)
class Fault:
    """``needs``: the key of SETTINGS without which the vehicle has no such part, "" if it has.
    ``slot``: what it takes hold of, "" for a part of its own: of those that take hold of the same
    the newest counts. ``adds``: it takes hold of nothing, and acts beside all others."""

    says: str
    begin: Act
    end: Act
    value: float = 0.0
    unit: str = ""  # of the value; empty: it has none
    duration: float = 60.0  # s
    needs: str = ""
    slot: str = ""
    adds: bool = False
