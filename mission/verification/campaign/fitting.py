"""What is fitted to the vehicle of a flight, so that the drawn faults can happen there.

This is added sensors, and the beacons of ranges. The beacons are within range of home, and the
vehicle file has their places. Noises are the usual ones.

What does not live here: what goes wrong (links.simulated.added_faults), when (draw).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from random import Random

from links.simulated.added import SimulatedBeacon
from links.simulated.faults import FAULTS
from links.simulated.geodesy import moved
from links.simulated.settings import FaultEvent, Settings, parse_settings
from mission.model.vehicle import Beacon, Vehicle

SIGMAS: Mapping[str, str] = {  # m/s, m/s, m, m, m
    "speed_log": "0.05",
    "doppler": "0.03",
    "acoustic": "3",
    "ranges": "2",
    "second_gps": "3",
}
_BEACONS, _WITHIN, _DEEP = 2, (100.0, 400.0), (2.0, 20.0)  # m from home


def fit(
    settings: Settings, faults: Iterable[FaultEvent], home: tuple[float, float], rng: Random
) -> Settings:
    """Return ``settings`` with the faults and the sensors that they need; ``home`` in rad."""
    faults = tuple(faults)
    needed = {FAULTS[event.name].needs for event in faults if event.name in FAULTS} - {""}
    fitted = parse_settings([f"{part}={SIGMAS[part]}" for part in sorted(needed)], settings)
    if "ranges" in needed:
        beacons = tuple(_beacon(number, home, rng) for number in range(1, _BEACONS + 1))
        fitted = replace(fitted, added=replace(fitted.added, beacons=beacons))
    return replace(fitted, faults=faults)


def _beacon(number: int, home: tuple[float, float], rng: Random) -> SimulatedBeacon:
    far, bearing = rng.uniform(*_WITHIN), rng.uniform(0.0, math.tau)
    place = moved(*home, far * math.cos(bearing), far * math.sin(bearing))
    return SimulatedBeacon(number, *place, rng.uniform(*_DEEP))


def beaconed(vehicle: Vehicle, settings: Settings) -> Vehicle:
    """Return the vehicle with the beacons of the settings in its file."""
    there = settings.added.beacons
    beacons = {str(b.number): Beacon(b.latitude, b.longitude, b.depth) for b in there}
    return replace(vehicle, beacons=beacons) if beacons else vehicle
