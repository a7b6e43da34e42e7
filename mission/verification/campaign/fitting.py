"""What is fitted to the vehicle of a flight, so that what is drawn for it can go wrong there.

Sensors that were added, and the beacons of ranges, which stand within hearing of home and are where
the vehicle file says. Noises are the usual ones.

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
    """``settings`` with the faults, and with what they need; ``home`` in rad."""
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
    """Its file knows where the beacons of the settings are."""
    there = settings.added.beacons
    beacons = {str(b.number): Beacon(b.latitude, b.longitude, b.depth) for b in there}
    return replace(vehicle, beacons=beacons) if beacons else vehicle
