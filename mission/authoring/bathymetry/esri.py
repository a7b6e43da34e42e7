"""ESRI ASCII grids: ncols, nrows, xllcorner or xllcenter, ..., cellsize or dx and dy, nodata_value.

Source: Esri, "Esri ASCII raster format" (ArcGIS documentation).
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from mission.authoring.bathymetry.grid import (
    REPROJECT,
    BathymetryError,
    Depths,
    Numbers,
    finite,
    geographic,
    made,
)

MOST_CELLS = 4_000_000
_NODATA = -9999.0

_KEYS = (
    "ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy",
    "nodata_value",
)  # fmt: skip
_HEADER = re.compile(r"\s*([A-Za-z_]+)\s+(\S+)\s*\Z")


def from_esri(text: str, source: str) -> Depths:
    lines = text.splitlines()
    head: dict[str, float] = {}
    while len(head) < len(lines) and (found := _HEADER.match(lines[len(head)])):
        line, key = len(head) + 1, found[1].lower()
        if key not in _KEYS or key in head:
            what = "appears twice" if key in head else "is no key of an ESRI ASCII grid"
            raise BathymetryError(f"{source}:{line}: {key} {what}; there are {', '.join(_KEYS)}")
        unknown = key == "nodata_value" and found[2].lower() == "nan"
        head[key] = _NODATA if unknown else finite(found[2], f"{source}:{line}: {key}")
    rows, columns = (_whole(head, key, source) for key in ("nrows", "ncols"))
    if rows * columns > MOST_CELLS:
        what = f"{rows:,} x {columns:,} cells are more than {MOST_CELLS:,}"
        raise BathymetryError(f"{source}: {what}; cut out the part that is flown over")
    east = _key(head, ("dx", "cellsize"), source)
    south = _key(head, ("dy", "cellsize"), source)
    if not (0.0 < east < 180.0 and 0.0 < south < 90.0):
        raise BathymetryError(
            f"{source}: cells of {south:g} x {east:g} are not of degrees; {REPROJECT}"
        )
    west = _corner(head, "x", east, source)
    low = _corner(head, "y", south, source)
    north = low + (rows - 1) * south
    geographic(((low, west), (north, west + (columns - 1) * east)), source)
    values = _values(lines, len(head), (rows, columns), source)
    values[values == head.get("nodata_value", _NODATA)] = np.nan
    return made(source, north, west, (south, east), values, "ESRI ASCII grid")


def _key(head: dict[str, float], keys: Sequence[str], source: str) -> float:
    for key in keys:
        if key in head:
            return head[key]
    raise BathymetryError(f"{source}: no {' or '.join(keys)}; an ESRI ASCII grid begins with it")


def _whole(head: dict[str, float], key: str, source: str) -> int:
    value = _key(head, (key,), source)
    if not value.is_integer() or value < 1:
        raise BathymetryError(f"{source}: {key} {value:g} is no number of cells; write 1 or more")
    return int(value)


def _corner(head: dict[str, float], axis: str, cell: float, source: str) -> float:
    """The coordinate of the middle of the lower left cell along an axis, degrees."""
    keys = (f"{axis}llcenter", f"{axis}llcorner")
    value = _key(head, keys, source)
    return value if keys[0] in head else value + cell / 2.0


def _values(lines: list[str], first: int, shape: tuple[int, int], source: str) -> Numbers:
    words = " ".join(lines[first:]).split()
    if len(words) != shape[0] * shape[1]:
        odd = next((n for n, line in enumerate(lines[first:], first + 1)
                    if line.strip() and len(line.split()) != shape[1]), len(lines))  # fmt: skip
        what = f"{len(words):,} values, not nrows x ncols = {shape[0] * shape[1]:,}"
        where = f"the first line with another number than {shape[1]} is {odd}"
        raise BathymetryError(f"{source}: {what}; {where}")
    try:
        values = np.array(words, dtype=np.float64).reshape(shape)
    except ValueError:
        values = np.array([np.inf])
    if not np.isinf(values).any():
        return values
    for number, line in enumerate(lines[first:], first + 1):
        for word in line.split():
            if word.lower() != "nan":  # some programs write nan for no data
                finite(word, f"{source}:{number}")
    raise AssertionError("one of them is no number")
