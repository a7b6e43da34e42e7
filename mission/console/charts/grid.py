"""A grid of depths, or soundings collected into one, as the check reads it (bathymetry).

The page gets the shallowest depth of each cell.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from mission.authoring.bathymetry import BathymetryError, read_bathymetry
from mission.console.charts.layer import ChartError, Layer


def read_grid(path: Path) -> Layer:
    """Raises ChartError."""
    try:
        depths = read_bathymetry(path)
    except BathymetryError as error:
        raise ChartError(str(error)) from None
    values = depths.shallow
    least, greatest = float(np.nanmin(values)), float(np.nanmax(values))
    (rows, columns), (high, wide) = values.shape, depths.step
    middle = depths.west + wide * (columns - 1) / 2
    west = math.remainder(middle, 360.0) - wide * columns / 2
    north = depths.north + high / 2
    bounds = west, north - high * rows, west + wide * columns, north
    more = {"columns": columns, "rows": rows, "least": least, "greatest": greatest}
    data = values.astype("<f4").tobytes()
    return Layer(path.name, "depths", bounds, depths.told, data, "application/octet-stream", more)
