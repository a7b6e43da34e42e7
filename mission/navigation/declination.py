"""Magnetic declination: true heading = compass + declination - the compass's own error.

The vehicle file may state it. Otherwise the world magnetic model gives it from place and date
(NOAA/BGS WMM 2010 to 2025, by pygeomag). It drifts by some 0.1 deg a year, so a missing date
costs less than the compass's own error.
"""

from __future__ import annotations

import copy
import functools
import math
from typing import Any

_FIRST, _LAST = 2010.0, 2030.0  # the years that the shipped coefficients cover
_UNDATED = 2026.0
EPOCHS = 2010, 2015, 2020, 2025  # the years of the tables


def declination(latitude: float, longitude: float, date: str | None = None) -> float:
    """Return the declination, rad, east positive; 0 if the model's table cannot be read.

    ``date`` begins with YYYY-MM-DD (None or unreadable: 2026). Near a magnetic pole the figure
    means little. There, and without a table, the filter's compass error has to absorb the rest.
    """
    try:
        return of_model(latitude, longitude, decimal_year(date))
    except OSError:
        return 0.0


@functools.lru_cache(maxsize=16)
def of_model(latitude: float, longitude: float, date: float) -> float:
    year = min(max(date, _FIRST), _LAST - 0.01)
    # a copy: the model computes in place, and another thread may use it at the same time
    model = copy.deepcopy(table(int(_FIRST + 5 * ((year - _FIRST) // 5))))
    result = model.calculate(
        glat=math.degrees(latitude), glon=math.degrees(longitude), alt=0.0, time=year
    )
    return math.radians(result.d)


@functools.cache
def table(epoch: int) -> Any:
    """Read the table of an epoch, once. ``serve`` reads it in advance, in a thread that may wait.
    Raises OSError."""
    from pygeomag import GeoMag

    made = GeoMag(coefficients_file=f"wmm/WMM_{epoch}.COF")
    made.calculate(glat=0.0, glon=0.0, alt=0.0, time=float(epoch))  # this reads the file
    return made


def decimal_year(date: str | None) -> float:
    try:
        year, month, day = (int(part) for part in (date or "")[:10].split("-"))
    except ValueError:
        return _UNDATED
    return year + (month - 1 + (day - 1) / 30.5) / 12.0
