"""The proof of a calibration: how far the estimate is from the first fix after each dive.

A dive is ``LONG`` s without a fix. What it missed, normalised by what the estimate said of itself,
tells how far to trust the figures (``trust``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

from mission.analysis.courses import Inputs
from mission.model import Estimate
from mission.model.vehicle import Vehicle
from mission.navigation.navigator import Navigation
from protocol.messages import Fix, Telemetry

LONG = 60.0  # s without a fix
_FIGURED = 4.0  # the figures count as so many dives
_MEDIAN = 0.6931  # of chi-square with two degrees of freedom, over them


@dataclass(frozen=True, slots=True)
class Stretch:
    """A dive from one fix to another: what was missed at its end, of what was swum (m); ``miss``:
    the normalised square of that after calibration over its degrees of freedom."""

    log: int
    begin: float
    end: float
    distance: float
    before: float
    after: float
    miss: float


@dataclass(frozen=True, slots=True)
class _Dive:
    begin: float
    end: float
    distance: float
    error: float
    miss: float


def compare(log_number: int, log: Inputs, before: Vehicle, after: Vehicle) -> list[Stretch]:
    fixes = [item.t for item in log if isinstance(item, Fix)]
    if not any(b - a >= LONG for a, b in pairwise(fixes)):
        return []
    one, two = (_missed(log, vehicle) for vehicle in (before, after))
    return [
        Stretch(log_number, a.begin, a.end, a.distance, a.error, b.error, b.miss)
        for a, b in zip(one, two, strict=True)
    ]


def trust(misses: Sequence[float]) -> float:
    """What sigmas are to be multiplied by: the median of the misses against that of figures that
    are right, so that one wild dive changes nothing."""
    if not misses:
        return 1.0
    n, found = len(misses), median(misses) / _MEDIAN
    return math.sqrt((_FIGURED + n * found) / (_FIGURED + n))


def _missed(log: Inputs, vehicle: Vehicle) -> list[_Dive]:
    """Compares the estimate with the first fix after each dive, before the filter takes that in."""
    nav, found = Navigation(vehicle), []
    last, swum, seen = -math.inf, 0.0, 0.0
    for item in log:
        if isinstance(item, Telemetry):
            nav.telemetry(item)
            estimate = nav.estimate(item.t)
            swum += abs(estimate.speed) * (item.t - seen) if estimate and seen else 0.0
            seen = item.t
            continue
        estimate = nav.estimate(item.t)
        if estimate is not None and nav.frame is not None and -math.inf < last <= item.t - LONG:
            place = nav.frame.to_local(item.latitude, item.longitude)
            sigma = item.accuracy if item.accuracy < math.inf else vehicle.sensors.fix
            found.append(_Dive(last, item.t, swum, *_off(estimate, place, sigma)))
        nav.fix(item)
        last, swum = item.t, 0.0
    return found


def _off(e: Estimate, place: tuple[float, float], sigma: float) -> tuple[float, float]:
    """Returns the distance, m, and the normalised error squared, d^T (P + sigma^2 I)^-1 d / 2."""
    dn, de = place[0] - e.north, place[1] - e.east
    a, b, d = e.covariance[0] + sigma**2, e.covariance[1], e.covariance[2] + sigma**2
    nees = (d * dn * dn - 2.0 * b * dn * de + a * de * de) / (a * d - b * b)
    return math.hypot(dn, de), 0.5 * nees
