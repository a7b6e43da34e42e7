"""Depths of the sea floor in a grid, north up, and the checks that all formats share.

What does not live here: the formats (esri, geojson, soundings), gathering into cells (cells).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[np.float64]
Indices = NDArray[np.int_]
Corner = tuple[float, float]  # deg: latitude, longitude
DEEPEST = 12_000.0  # m: no sea on Earth is deeper, and no mountain higher

REPROJECT = "write it in latitudes and longitudes first (gdalwarp -t_srs EPSG:4326)"
READABLE = (
    "an ESRI ASCII grid begins with ncols, GeoJSON with {, a table with a line such as "
    "latitude,longitude,depth (.xyz: longitude latitude depth, without one)"
)
CONVERT = "write it as an ESRI ASCII grid first (gdal_translate -of AAIGrid IN OUT.asc)"


class BathymetryError(ValueError):
    """A file of depths cannot be used; the text has the place, the error and a hint."""


@dataclass(frozen=True, slots=True, eq=False)
class Depths:
    """A grid of cells of ``step`` degrees (south, east).

    ``north`` and ``west``: the middle of the north-western cell, degrees. ``shallow`` and ``deep``:
    m by row and column, nan where there is no depth. ``told``: how the file was read, as text.
    """

    source: str
    north: float
    west: float
    step: tuple[float, float]
    shallow: Numbers
    deep: Numbers
    told: str

    def at(self, latitude: float, longitude: float) -> float | None:
        """The depth in m at a place in degrees, interpolated between the four cells around it; that
        of the nearest cell if one of the four has no depth. None: no depth there."""
        y = (self.north - latitude) / self.step[0]
        x = self._east_of(longitude) / self.step[1]
        if not (self._has(round(y), round(x))):
            return None
        nearest = float(self.shallow[round(y), round(x)])
        if math.isnan(nearest):
            return None
        row, column = math.floor(y), math.floor(x)
        if not (self._has(row, column) and self._has(row + 1, column + 1)):
            return nearest
        four = self.shallow[row : row + 2, column : column + 2]
        p, q = y - row, x - column
        between = float(np.array((1.0 - p, p)) @ four @ np.array((1.0 - q, q)))
        return nearest if math.isnan(between) else between

    def box(self, south: float, north: float, west: float, east: float) -> tuple[slice, slice]:
        """Rows and columns of the cells that touch a box (degrees), and one more to each side."""
        rows = ((self.north - north) / self.step[0], (self.north - south) / self.step[0])
        left = self._east_of(west) / self.step[1]
        columns = (left, left + (east - west) / self.step[1])
        return _slice(rows, self.shallow.shape[0]), _slice(columns, self.shallow.shape[1])

    def middles(self, box: tuple[slice, slice]) -> tuple[Numbers, Numbers]:
        """Latitudes of the rows and longitudes of the columns of a box, degrees."""
        rows, columns = (np.arange(part.start, part.stop) for part in box)
        return self.north - rows * self.step[0], self.west + columns * self.step[1]

    @property
    def known(self) -> float:
        """The share of the cells that have a depth."""
        return float(np.isfinite(self.shallow).mean())

    def _east_of(self, longitude: float) -> float:
        """Degrees east of the first column; within 180 degrees of the middle of the grid."""
        half = self.step[1] * (self.shallow.shape[1] - 1) / 2.0
        return float(math.remainder(longitude - self.west - half, 360.0) + half)

    def _has(self, row: int, column: int) -> bool:
        rows, columns = self.shallow.shape
        return bool(0 <= row < rows and 0 <= column < columns)


def _slice(span: tuple[float, float], count: int) -> slice:
    first = min(max(math.floor(span[0] - 0.5), 0), count)
    return slice(first, max(first, min(math.ceil(span[1] + 1.5), count)))


def geographic(corners: Iterable[Corner], source: str) -> None:
    for lat, lon in corners:
        if not (abs(lat) <= 90.0 and abs(lon) <= 360.0):
            what = f"{lat:g}, {lon:g} is no latitude and longitude"
            raise BathymetryError(f"{source}: {what}; {REPROJECT}")


def made(
    source: str,
    north: float,
    west: float,
    step: tuple[float, float],
    shallow: Numbers,
    what: str,
    deep: Numbers | None = None,
    heights: bool | None = None,
) -> Depths:
    """Check the values and make the grid. ``heights``: the values are heights; None: decide by the
    sign of most values."""
    if not np.isfinite(shallow).any():
        raise BathymetryError(f"{source}: no cell of it knows a depth; is nodata_value right?")
    for values in (shallow, shallow if deep is None else deep):
        absurd = values[np.abs(values) > DEEPEST]
        if absurd.size:
            what = f"{absurd[0]:g} m is no depth; is it what the file says where none is known"
            raise BathymetryError(f"{source}: {what}? Then write nodata_value {absurd[0]:g}")
    if heights is None:
        heights = bool(np.nanmedian(shallow) < 0.0)
    deep = shallow if deep is None else deep
    if heights:
        shallow, deep = -deep, -shallow
    way = "heights, turned into depths" if heights else "depths"
    low, high = float(np.nanmin(shallow)), float(np.nanmax(deep))
    told = (
        f"{what}, {shallow.shape[0]} x {shallow.shape[1]} cells, {way} of {low:.1f} to {high:.1f} m"
    )
    return Depths(source, north, west, step, shallow, deep, told)


def nothing(word: str) -> bool:
    """Whether the word means no data (NaN, as GMT writes it)."""
    return word.lower() == "nan"


def finite(word: str, where: str) -> float:
    try:
        value = float(word)
    except ValueError:
        raise BathymetryError(f"{where}: {word!r} is no number; write one, as in -12.5") from None
    if not math.isfinite(value):
        raise BathymetryError(
            f"{where}: {word} is no depth; write nodata_value where none is known"
        )
    return value
