"""The vehicle file that verification flies, the simulated vehicle of that file, and its home.

What does not live here: the parts of the simulated vehicle (links.simulated).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from types import MappingProxyType

from links.simulated.added import Fitted, SimulatedBeacon
from links.simulated.boards import BOARDS, ON_BUS, SimulatedBoard
from links.simulated.firmware.boards import WaterBoard
from links.simulated.link import HOME, START, SimulatedVehicle
from links.simulated.plant import Body
from links.simulated.settings import SettingError, Settings
from mission.model import Mission
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from protocol.added import GROUND, PLACE, RANGE, WATER

Simulated = SimulatedVehicle | SimulatedBoard
_FITTED: Mapping[str, str] = MappingProxyType(
    {
        WATER: "speed_log",
        GROUND: "doppler",
        PLACE: "acoustic",
        RANGE: "ranges",
    }
)
# The shipped file does not confirm which way its motors push, so it holds nothing (R17). The
# simulated boards push as the file reads them, so campaigns fly it as confirmed on this day.
CONFIRMED = {"mainboard": "2026-11-22"}


@functools.cache
def flown(name: str) -> Vehicle:
    """Return the shipped vehicle of this name, as campaigns fly it. Raises VehicleError."""
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
    """Make the simulated vehicle. ``position``: latitude and longitude, rad; ``heading``: rad;
    ``start``: the receiver's time. Raises SettingError for a fault or a sensor that the vehicle
    cannot have, ValueError for a codec without a simulated board."""
    if vehicle.codec == "auv":
        return SimulatedVehicle(
            vehicle.dialect,
            seed,
            _fitted(vehicle, settings),
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


def body_of(codec: str) -> Body:
    """Return the body of the simulated vehicle or board of this codec."""
    board = BOARDS.get(codec)
    return board.body if board is not None and issubclass(board, WaterBoard) else Body()


def _fitted(vehicle: Vehicle, settings: Settings | None) -> Settings | None:
    """Add the sensors of the vehicle file (``added``), each with the noise that the file states
    unless the settings state its true noise; and likewise the beacons."""
    given = (settings or Settings()).added
    there = given.beacons or tuple(
        SimulatedBeacon(int(number), b.latitude, b.longitude, b.depth)
        for number, b in vehicle.beacons.items()
    )
    if given.ranges is not None and not there:
        raise SettingError("ranges need beacons: write them in the vehicle file, or --set beacon=")
    noises = {
        _FITTED[kind]: sigma
        for kind, sigma in vehicle.added.items()
        if getattr(given, _FITTED[kind]) is None and (kind != RANGE or there)
    }
    if not noises and given.ranges is None:
        return settings
    sensors: Fitted = replace(given, beacons=there, **noises)  # type: ignore[arg-type]
    return replace(settings or Settings(), added=sensors)


def in_dialect(vehicle: Vehicle, profile: str | None) -> Vehicle:
    """Return the vehicle in the dialect of ``profile``; "" or None: as its file says. Only the
    AUV's board has profiles."""
    return replace(vehicle, dialect=profile) if profile and vehicle.codec == "auv" else vehicle


def home_of(mission: Mission) -> tuple[float, float]:
    """Return the mission's home, latitude and longitude in rad; without one, that of the
    demonstration."""
    home = mission.home
    return (
        HOME
        if home is None
        else (math.radians(home.latitude_deg), math.radians(home.longitude_deg))
    )
