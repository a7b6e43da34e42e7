"""The check of a calibration: the distance between the estimate and the first fix after each dive.

A dive is ``LONG`` s without a fix. Its error, normalised by the covariance of the estimate, shows
how far to trust the figures (``trust``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from statistics import median

from mission.analysis.courses import Inputs
from mission.model import Estimate
from mission.model.vehicle import Vehicle
from mission.navigation.navigator import Navigation
from protocol.messages import Fix, Telemetry

LONG = 60.0  # s without a fix
_NARROWS = 4  # dives; fewer may only widen the figures
# The prior trust in the figures, as a number of dives: a median of n has a relative variance of
# 1 / (n ln(2)^2). Before any dive the figures are right within a factor of about 1.5 (a variance
# of 0.66 of the square's logarithm).
_FIGURED = 3.0
_TAILS = 4.0  # degrees of freedom of Student's t: one outlier dive changes little
_EVEN = 1.376  # factor on the squares: normal errors make figures neither wider nor narrower
_MEDIAN = 0.6931  # median of chi-square with two degrees of freedom, divided by two


@dataclass(frozen=True, slots=True)
class Stretch:
    """A dive from one fix to the next: ``distance`` m swum, the position error before and after
    calibration, m. ``miss``: the normalised error squared after calibration over its degrees of
    freedom."""

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
    spread: float  # logarithm of the determinant of the expected covariance, m^4


def dives(log: Inputs) -> list[float]:
    """Return the length of each dive, s."""
    fixes = [item.t for item in log if isinstance(item, Fix)]
    return [b - a for a, b in pairwise(fixes) if b - a >= LONG]


def compare(log_number: int, log: Inputs, before: Vehicle, after: Vehicle) -> list[Stretch]:
    if not dives(log):
        return []
    one, two = (_missed(log, vehicle) for vehicle in (before, after))
    return [
        Stretch(log_number, a.begin, a.end, a.distance, a.error, b.error, b.miss)
        for a, b in zip(one, two, strict=True)
    ]


def trust(misses: Sequence[float]) -> float:
    """Return the factor for the sigmas: the median of the misses against that of correct figures.
    The median, so that one outlier dive changes nothing."""
    if not misses:
        return 1.0
    n, found = len(misses), median(misses) / _MEDIAN
    return math.sqrt((_FIGURED + n * found) / (_FIGURED + n))


def share_of(stretches: Sequence[Stretch], *, proves: bool) -> float:
    """``proves``: nothing that moves a position was learned from these dives. Else, or with few
    dives, the figures never become narrower."""
    share = trust([s.miss for s in stretches])
    return share if proves and len(stretches) >= _NARROWS else max(share, 1.0)


def widened(vehicle: Vehicle, share: float) -> Vehicle:
    """Multiply all sigmas that move a position by ``share``."""
    known = vehicle.calibration
    current = vehicle.current if known.current_sigma is None else known.current_sigma
    if share == 1.0:
        return vehicle
    return replace(
        vehicle,
        sensors=replace(vehicle.sensors, heading_bias=share * vehicle.sensors.heading_bias),
        calibration=replace(
            known,
            speed_scale_sigma=share * known.speed_scale_sigma,
            speed_noise=share * known.speed_noise,
            sway_noise=share * known.sway_noise,
            deviation_sigma=share * known.deviation_sigma,
            compass_wander=share * known.compass_wander,
            current_sigma=share * current,
            surface_drift=share * known.surface_drift,
        ),
    )


def likelihood(log: Inputs, vehicles: Sequence[Vehicle]) -> list[list[float]]:
    """Return, for each vehicle file, the log likelihood of where each dive ended."""
    if not dives(log):
        return [[] for _ in vehicles]
    return [[_likely(dive) for dive in _missed(log, vehicle)] for vehicle in vehicles]


def _likely(dive: _Dive) -> float:
    """Use Student's t in two dimensions (Lange, Little, Taylor, J. Am. Stat. Assoc. 84, 1989)."""
    far = math.log1p(_EVEN * 2.0 * dive.miss / _TAILS)
    return -0.5 * dive.spread - 0.5 * (_TAILS + 2.0) * far


def _missed(log: Inputs, vehicle: Vehicle) -> list[_Dive]:
    """Compare the estimate with the first fix after each dive, before the filter uses that fix."""
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


def _off(e: Estimate, place: tuple[float, float], sigma: float) -> tuple[float, float, float]:
    """Return the distance, m, the normalised error squared, d^T (P + sigma^2 I)^-1 d / 2, and the
    logarithm of the determinant of P + sigma^2 I."""
    dn, de = place[0] - e.north, place[1] - e.east
    a, b, d = e.covariance[0] + sigma**2, e.covariance[1], e.covariance[2] + sigma**2
    det = a * d - b * b
    nees = (d * dn * dn - 2.0 * b * dn * de + a * de * de) / det
    return math.hypot(dn, de), 0.5 * nees, math.log(det)
