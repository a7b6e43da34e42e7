"""Gather soundings and depth areas into cells: each keeps its shallowest and deepest value.

Soundings: the side of a cell is 1.5 times their mean distance, so that a regular survey leaves no
empty cells. Areas: ``_FINEST`` cells along the longer side of their extent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from mission.authoring.bathymetry.grid import (
    READABLE,
    BathymetryError,
    Corner,
    Depths,
    Indices,
    Numbers,
    geographic,
    made,
)

MOST_POINTS = 500_000
_MOST_CELLS = 4_000_000
_FINEST = 300  # cells along the longer side of the extent of areas
_SPREAD = 1.5  # side of a cell, in mean distances between soundings


@dataclass(slots=True)
class Found:
    """Soundings (latitude, longitude, m) and areas (rings, shallowest, deepest)."""

    source: str
    points: list[tuple[float, float, float]] = field(default_factory=list)
    areas: list[tuple[list[list[Corner]], float, float]] = field(default_factory=list)
    heights: set[bool] = field(default_factory=set)  # True: a name says heights; False: depths


def gathered(found: Found, what: str) -> Depths:
    corners = [(lat, lon) for lat, lon, _ in found.points]
    corners += [corner for rings, _, _ in found.areas for ring in rings for corner in ring]
    if not corners:
        raise BathymetryError(f"{found.source}: no depths in it; {READABLE}")
    if len(corners) > MOST_POINTS:
        raise BathymetryError(
            f"{found.source}: more than {MOST_POINTS:,} places; cut out the part that is flown over"
        )
    geographic(corners, found.source)
    first = corners[0][1]
    lats = np.array([lat for lat, _ in corners])
    lons = (
        first + np.remainder(np.array([lon for _, lon in corners]) - first + 180.0, 360.0) - 180.0
    )
    step = _step(lats, lons, areas=bool(found.areas))
    north, west = float(lats.max()), float(lons.min())
    shape = tuple(round(float(np.ptp(a)) / s) + 1 for a, s in zip((lats, lons), step, strict=True))
    shallow, deep = np.full(shape, np.inf), np.full(shape, -np.inf)
    grid = _Cells(north, west, step, shallow, deep)
    for rings, low, high in found.areas:
        grid.area([[(lat, _near(lon, first)) for lat, lon in ring] for ring in rings], low, high)
    count = len(found.points)
    grid.points(lats[:count], lons[:count], np.array([p[2] for p in found.points]))
    unknown = ~np.isfinite(shallow)
    shallow[unknown] = deep[unknown] = np.nan
    heights = None if not found.heights else found.heights == {True}
    return made(found.source, north, west, step, shallow, what, deep, heights)


def _near(longitude: float, first: float) -> float:
    return first + math.remainder(longitude - first, 360.0)


def _step(lats: Numbers, lons: Numbers, *, areas: bool) -> tuple[float, float]:
    """The step in degrees south and east, for cells that are square on the ground."""
    wide = max(math.cos(math.radians(float(lats.mean()))), 0.01)
    sides = (max(float(np.ptp(lats)), 1e-6), max(float(np.ptp(lons)) * wide, 1e-6))
    if areas:
        cell = max(sides) / _FINEST
    else:
        cell = _SPREAD * max(math.sqrt(sides[0] * sides[1] / len(lats)), max(sides) / len(lats))
        cell = max(cell, max(sides) / math.sqrt(_MOST_CELLS))
    return cell, cell / wide


@dataclass(frozen=True, slots=True, eq=False)
class _Cells:
    north: float
    west: float
    step: tuple[float, float]
    shallow: Numbers
    deep: Numbers

    def points(self, lats: Numbers, lons: Numbers, depths: Numbers) -> None:
        rows = np.rint((self.north - lats) / self.step[0]).astype(int)
        columns = np.rint((lons - self.west) / self.step[1]).astype(int)
        np.minimum.at(self.shallow, (rows, columns), depths)
        np.maximum.at(self.deep, (rows, columns), depths)

    def area(self, rings: list[list[Corner]], one: float, other: float) -> None:
        """Fill all cells whose middle is in the area (even-odd rule, so holes stay empty), and all
        cells on its edge, so that a small or thin area is not lost."""
        rows, columns = (np.arange(n) for n in self.shallow.shape)
        lat = self.north - rows * self.step[0]
        lon = (self.west + columns * self.step[1])[None, :]
        odd = np.zeros(self.shallow.shape, dtype=bool)
        for ring in rings:
            for (a, b), (c, d) in zip(ring, (*ring[1:], ring[0]), strict=True):
                meets = np.flatnonzero((a > lat) != (c > lat))
                if len(meets):
                    at = b + (lat[meets, None] - a) * (d - b) / (c - a)
                    odd[meets] ^= lon < at
        for ring in rings:
            for one_end, other_end in zip(ring, (*ring[1:], ring[0]), strict=True):
                odd[self._along(one_end, other_end)] = True
        self.shallow[odd] = np.minimum(self.shallow[odd], min(one, other))
        self.deep[odd] = np.maximum(self.deep[odd], max(one, other))

    def _along(self, one: Corner, other: Corner) -> tuple[Indices, Indices]:
        """Rows and columns of the cells on an edge."""
        (a, b), (c, d) = (self._cell(*corner) for corner in (one, other))
        share = np.linspace(0.0, 1.0, 2 + math.ceil(4.0 * max(abs(c - a), abs(d - b))))
        last = (n - 1 for n in self.shallow.shape)
        rows, columns = (
            np.clip(np.rint(x + (y - x) * share), 0, most).astype(int)
            for x, y, most in zip((a, b), (c, d), last, strict=True)
        )
        return rows, columns

    def _cell(self, latitude: float, longitude: float) -> tuple[float, float]:
        """The position in cells, south and east of the middle of the first cell."""
        return (self.north - latitude) / self.step[0], (longitude - self.west) / self.step[1]
