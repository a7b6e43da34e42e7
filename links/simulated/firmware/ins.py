"""The inertial navigation (INS) of the boards of document 002.

At the surface it tells the position of its GPS. Under water its error grows from the last one, at a
velocity that stays the same for a dive.
"""

from __future__ import annotations

from math import inf
from random import Random

from links.simulated.firmware.gps import ANTENNA
from links.simulated.geodesy import moved

ALIGNS = 3.0  # s from switching it on until it is aligned (assumed)
PLACE = 2.0  # m, one sigma of GPS along an axis
DRIFT = 0.08  # m/s, one sigma along an axis (assumed): 95 % drift less than 0.2 m/s
Place = tuple[float, float]  # latitude and longitude, rad


class Ins:
    def __init__(self, rng: Random) -> None:
        self._rng = rng
        self._powered = inf  # s, since when it has power
        self._corrected = -inf  # s, when GPS last did; never since it has power: -inf
        self._error = self._drift = 0.0, 0.0  # m, and m/s: north and east

    def switch(self, on: bool, now: float) -> None:
        if on:
            self._powered = min(self._powered, now)
        else:
            self._powered, self._corrected = inf, -inf

    def place(self, true: Place, depth: float, now: float) -> Place | None:
        """Return its position; None while it is not aligned."""
        if now - self._powered < ALIGNS:
            return None
        if depth <= ANTENNA:
            self._corrected = now
            self._error, self._drift = self._drawn(PLACE), self._drawn(DRIFT)
        if self._corrected == -inf:
            return None
        since = now - self._corrected
        north, east = (e + since * v for e, v in zip(self._error, self._drift, strict=True))
        return moved(*true, north, east)

    def _drawn(self, sigma: float) -> tuple[float, float]:
        return self._rng.gauss(0.0, sigma), self._rng.gauss(0.0, sigma)
