"""The vehicle that verification flies, the simulated one that it describes, and where it lies.

What does not live here: what it is made of (links.simulated).
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from datetime import datetime

from links.simulated.added import SimulatedBeacon
from links.simulated.boards import BOARDS, ON_BUS, SimulatedBoard
from links.simulated.link import HOME, START, SimulatedVehicle
from links.simulated.settings import SettingError, Settings
from mission.model import Mission
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle

Simulated = SimulatedVehicle | SimulatedBoard
# The shipped file leaves open which way its motors push, so that it holds nothing (R17). The
# simulated boards push as it reads them: there it is as if somebody had seen it on this day.
CONFIRMED = {"mainboard": "2026-11-22"}


@functools.cache
def flown(name: str) -> Vehicle:
    """The shipped vehicle of this name as campaigns fly it. Raises VehicleError."""
    vehicle = load_vehicle(name)
    loop = vehicle.outer_loop
    if loop is None or vehicle.name not in CONFIRMED:
        return vehicle
    return replace(vehicle, outer_loop=replace(loop, confirmed=CONFIRMED[vehicle.name]))


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
            vehicle.dialect,
            seed,
            _in_place(vehicle, settings),
            position=position,
            heading=heading,
            start=start,
        )
    if vehicle.codec not in (*BOARDS, *ON_BUS):
        raise ValueError(f"{vehicle.name}: there is no simulated board for {vehicle.codec}")
    if settings is not None and settings.added:
        raise SettingError("sensors are added to the simulated AUV alone")
    return SimulatedBoard(
        vehicle.codec,
        seed,
        settings,
        position=position,
        heading=heading,
        tolerances=vehicle.tolerances,
        wire=vehicle.wire,
    )


def _in_place(vehicle: Vehicle, settings: Settings | None) -> Settings | None:
    """Beacons are where the vehicle file says, unless the settings say where they truly are."""
    if settings is None or settings.added.ranges is None or settings.added.beacons:
        return settings
    beacons = tuple(
        SimulatedBeacon(int(number), b.latitude, b.longitude, b.depth)
        for number, b in vehicle.beacons.items()
    )
    if not beacons:
        raise SettingError("ranges need beacons: write them in the vehicle file, or --set beacon=")
    return replace(settings, added=replace(settings.added, beacons=beacons))


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
