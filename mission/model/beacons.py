"""The table ``beacons`` of a vehicle file: acoustic beacons whose places are known, by numbers.

    beacons: {3: 30.28800 120.15400 4 m, 4: 30.28600 120.15200 6 m 1480 m/s}

A beacon has latitude and longitude in degrees, its depth, and the speed of sound from it unless
that is 1500 m/s. What does not live here: YAML (vehicle_file), the use of a range (navigation).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from mission.model.units import UnitError, quantity
from mission.model.vehicle import Beacon
from mission.model.vehicle_outputs import Tables

MOST = 127  # the highest number of a modem
SLOWEST, FASTEST = 1300.0, 1700.0  # m/s, of sound in water
DEEPEST = 11_000.0  # m
_NUMBER = re.compile(r"0|[1-9]\d{0,2}")
_PLACE = re.compile(
    r"(-?\d{1,2}(?:\.\d+)?),? +(-?\d{1,3}(?:\.\d+)?),? +(\d+(?:\.\d+)? ?m)"
    r"(?:,? +(\d+(?:\.\d+)? ?m/s))?"
)


def read_beacons(file: Tables) -> Mapping[str, Beacon]:
    found: dict[str, Beacon] = {}
    for name in file.names("beacons"):
        key = f"beacons.{name}"
        if _NUMBER.fullmatch(name) is None or int(name) > MOST:
            file.refuse(key, f"{name:.40} is no number of a beacon", f"0 to {MOST}")
        elif (beacon := _beacon(file.text(key))) is not None:
            found[name] = beacon
        else:
            said = f"{file.text(key):.40} is no place of a beacon"
            file.refuse(key, said, "write latitude, longitude, depth: 30.28800 120.15400 4 m")
    return found


def _beacon(text: str) -> Beacon | None:
    match = _PLACE.fullmatch(text.strip())
    if match is None:
        return None
    try:
        depth = quantity(match[3], "m")
        sound = quantity(match[4], "m/s") if match[4] else Beacon(0.0, 0.0, 0.0).sound
    except UnitError:
        return None
    latitude, longitude = float(match[1]), float(match[2])
    if abs(latitude) > 90.0 or abs(longitude) > 180.0 or depth > DEEPEST:
        return None
    if not SLOWEST <= sound <= FASTEST:
        return None
    return Beacon(math.radians(latitude), math.radians(longitude), depth, sound)
