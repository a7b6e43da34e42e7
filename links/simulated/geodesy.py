"""Positions of the simulated vehicle on the globe: WGS84, independent of the engine's geodesy.

A position is latitude and longitude. It moves in small steps by the radii of curvature (meridian M,
prime vertical N), so no plane and no origin is needed. ``local`` uses earth-centred coordinates
instead. What does not live here: the estimate's projection.
"""

from __future__ import annotations

import math
from functools import lru_cache
from math import cos, sin, sqrt
from typing import Any

SEMI_MAJOR = 6378137.0  # m, WGS84
FLATTENING = 1 / 298.257223563
ECCENTRICITY_2 = FLATTENING * (2 - FLATTENING)


def moved(latitude: float, longitude: float, north: float, east: float) -> tuple[float, float]:
    """The position moved by ``north`` and ``east`` metres; exact for steps of some metres."""
    w2 = 1 - ECCENTRICITY_2 * sin(latitude) ** 2
    prime = SEMI_MAJOR / sqrt(w2)
    meridian = prime * (1 - ECCENTRICITY_2) / w2
    return latitude + north / meridian, longitude + east / (prime * cos(latitude))


def _earth_centred(latitude: Any, longitude: Any, by: Any = math) -> tuple[Any, Any, Any]:
    prime = SEMI_MAJOR / by.sqrt(1 - ECCENTRICITY_2 * by.sin(latitude) ** 2)
    across = prime * by.cos(latitude)
    z = prime * (1 - ECCENTRICITY_2) * by.sin(latitude)
    return across * by.cos(longitude), across * by.sin(longitude), z


@lru_cache(maxsize=16)
def _tangent(origin: tuple[float, float]) -> tuple[float, ...]:
    """Earth-centred coordinates of the origin, and sines and cosines to turn into its plane."""
    latitude, longitude = origin
    turn = sin(latitude), cos(latitude), sin(longitude), cos(longitude)
    return (*_earth_centred(latitude, longitude), *turn)


def local(
    origin: tuple[float, float], latitude: Any, longitude: Any, by: Any = math
) -> tuple[Any, Any]:
    """North and east in the tangent plane at ``origin`` (latitude, longitude), m. For arrays of
    positions ``by`` is numpy."""
    x0, y0, z0, slat, clat, slon, clon = _tangent(origin)
    x1, y1, z1 = _earth_centred(latitude, longitude, by)
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    east = -slon * dx + clon * dy
    north = -slat * (clon * dx + slon * dy) + clat * dz
    return north, east
