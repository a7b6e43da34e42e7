"""The true track of a simulated vehicle in a process of its own, from its file.

    t,latitude_deg,longitude_deg,depth_m     a row a second; linear between two rows

What does not live here: who writes it (links.simulated.process), the estimate (flightlog).
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from links.simulated.geodesy import local
from mission.verification.simulation.flightlog import TruePlace

Home = tuple[float, float]  # latitude and longitude in rad, from which north and east count
_COLUMNS = ("t", "latitude_deg", "longitude_deg", "depth_m")


@dataclass(frozen=True, slots=True)
class Truth:
    """s, rad, rad, m."""

    t: NDArray[np.float64]
    latitude: NDArray[np.float64]
    longitude: NDArray[np.float64]
    depth: NDArray[np.float64]

    @property
    def begin(self) -> Home:
        return float(self.latitude[0]), float(self.longitude[0])

    def place(self, t: float, home: Home) -> TruePlace:
        """Return the true place at ``t``; before the first row that of the first, after the last
        row that of the last."""
        at = (float(np.interp(t, self.t, one)) for one in (self.latitude, self.longitude))
        north, east = local(home, *at)
        return TruePlace(t, north, east, float(np.interp(t, self.t, self.depth)))

    def track(self, home: Home, offset: float) -> tuple[TruePlace, ...]:
        """Return all rows, with their times less ``offset``."""
        return tuple(self.place(t, home)._replace(t=t - offset) for t in self.t.tolist())


def read_truth(path: Path) -> Truth | None:
    """Read a track; None if the file has no row."""
    with path.open(newline="", encoding="ascii") as file:
        rows = [[float(row[name]) for name in _COLUMNS] for row in csv.DictReader(file)]
    if not rows:
        return None
    t, latitude, longitude, depth = np.array(rows).T
    return Truth(t, latitude * math.pi / 180.0, longitude * math.pi / 180.0, depth)
