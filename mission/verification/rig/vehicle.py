"""The simulated vehicle that a vehicle file describes, and where it lies.

What does not live here: what it is made of (links.simulated).
"""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import datetime

from links.simulated.boards import BOARDS, ON_BUS, SimulatedBoard
from links.simulated.link import HOME, START, SimulatedVehicle
from links.simulated.settings import SettingError, Settings
from mission.model import Mission
from mission.model.vehicle import Vehicle

Simulated = SimulatedVehicle | SimulatedBoard


def simulated(
    vehicle: Vehicle,
    seed: int = 0,
    settings: Settings | None = None,
    *,
    position: tuple[float, float] = HOME,
    heading: float = 0.0,
    start: datetime = START,
) -> Simulated:
    """``position``: latitude and longitude, rad; ``start``: the receiver's time. Raises
    SettingError for a fault or a sensor that it cannot have, ValueError for a codec without a
    board."""
    if vehicle.codec == "auv":
        return SimulatedVehicle(
            vehicle.dialect, seed, settings, position=position, heading=heading, start=start
        )
    if vehicle.codec not in (*BOARDS, *ON_BUS):
        raise ValueError(f"{vehicle.name}: there is no simulated board for {vehicle.codec}")
    if settings is not None and settings.added:
        raise SettingError("speed_log, doppler and acoustic are fitted to the simulated AUV alone")
    return SimulatedBoard(
        vehicle.codec,
        seed,
        settings,
        position=position,
        heading=heading,
        tolerances=vehicle.tolerances,
        wire=vehicle.wire,
    )


def in_dialect(vehicle: Vehicle, profile: str | None) -> Vehicle:
    """As ``profile`` says; "" or None: as its file does. Only the AUV's board has profiles."""
    return replace(vehicle, dialect=profile) if profile and vehicle.codec == "auv" else vehicle


def home_of(mission: Mission) -> tuple[float, float]:
    """Latitude and longitude, rad; that of the demonstration where the mission states none."""
    home = mission.home
    return (
        HOME
        if home is None
        else (math.radians(home.latitude_deg), math.radians(home.longitude_deg))
    )
