"""The sea floor of a file under a simulated vehicle, and how near the vehicle came to it.

What does not live here: the formats (authoring.bathymetry), the simulated sea (links).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from links.simulated.settings import Settings
from mission.authoring.bathymetry import Depths
from mission.model import Mission
from mission.navigation.geodesy import LocalFrame
from mission.verification.simulation.flightlog import Flight

TOUCHES = 0.3  # m: the height of the altimeter of a vehicle on the floor, and a margin


def over(settings: Settings, mission: Mission, depths: Depths) -> Settings:
    """Return the settings with the floor of the file; where the file has no depth, with the floor
    that the mission assumes, else that of the settings."""
    floor = dict(mission.assume).get("floor", settings.sea.floor)

    def at(latitude: float, longitude: float) -> float | None:
        return depths.at(math.degrees(latitude), math.degrees(longitude))

    return replace(
        settings, sea=replace(settings.sea, floor=floor, floor_at=at, floor_from=depths.source)
    )


@dataclass(frozen=True, slots=True)
class Clearance:
    """The least m of water under the true vehicle, where the file has the floor. ``t``: s from the
    beginning of the flight; latitude and longitude in degrees."""

    least: float
    t: float
    latitude: float
    longitude: float

    @property
    def aground(self) -> bool:
        return self.least < TOUCHES

    def as_object(self) -> dict[str, float]:
        return {
            "least_m": round(self.least, 2),
            "t": self.t,
            "latitude": round(self.latitude, 7),
            "longitude": round(self.longitude, 7),
        }

    @property
    def told(self) -> str:
        place = f"{self.latitude:.6f} {self.longitude:.6f}"
        touched = ": aground" if self.aground else ""
        return f"least clearance   {self.least:.1f} m at {self.t:.0f} s, {place}{touched}"


def clearance(flight: Flight, mission: Mission, depths: Depths) -> Clearance | None:
    """Return the clearance of a flight; None if the file has no floor under its track, or the
    mission names no home."""
    if mission.home is None:
        return None
    frame, least = LocalFrame(mission.home), None
    for at in flight.track:
        latitude, longitude = map(math.degrees, frame.to_geodetic(at.north, at.east))
        floor = depths.at(latitude, longitude)
        if floor is not None and (least is None or floor - at.depth < least.least):
            least = Clearance(floor - at.depth, at.t, latitude, longitude)
    return least
