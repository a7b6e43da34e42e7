"""The surface drift, estimated from the position errors at the ends of dives.

A current that is learned at the surface includes the drift of that hour by wind and waves. Under
water the drift is gone, and the remaining current keeps changing. The larger both are, the less the
fixes before a dive tell about the current below. No fix separates the two, but the error at the end
of a dive shows both together. Each of ``SHARES`` of the vehicle file's figures is tried on all
dives. The share is the mean of their logarithms, weighted by likelihood. All are equally likely a
priori, so dives that show nothing leave the share as it is.

If the error is larger than expected, only the drift grows. If it is smaller, the current also
changes more slowly, but only over dives as long as those in the logs, and never more slowly than a
tide does over that time. In a time t a tide changes by 2 sigma^2 (1 - cos(2 pi t / period)), a
process of correlation time T by 2 sigma^2 (1 - exp(-t / T)). A quarter of an hour says nothing
about hours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

from mission.analysis.courses import Inputs
from mission.analysis.missed import dives, likelihood
from mission.analysis.pooling import FEW
from mission.model.vehicle import TIDE, Vehicle

SHARES = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
_LEAST = 1e-3  # m/s: the least drift, still water
_PERIOD = 12.42 * 3600.0  # s, of the moon's tide
ENOUGH = 4  # dives that may reduce the drift; any number may increase it


@dataclass(frozen=True, slots=True)
class Drift:
    """The surface drift: the vehicle file's figure times ``share``, found from ``dives`` dives of
    ``length`` s (the median)."""

    share: float
    dives: int
    length: float


def with_drift(vehicle: Vehicle, share: float, length: float) -> Vehicle:
    known = vehicle.calibration
    known = replace(known, surface_drift=max(share * known.surface_drift, _LEAST))
    steady = min(known.current_time / share**2, _tide(length))
    steady = max(steady, min(known.current_time, TIDE))
    if steady != known.current_time:
        known = replace(known, current_time=steady, current_time_for=length)
    return replace(vehicle, calibration=known)


def _tide(length: float) -> float:
    """Return the correlation time, s, of a process that changes in ``length`` s as much as a
    tide."""
    left = math.cos(2.0 * math.pi * min(length / _PERIOD, 0.25))
    return -length / math.log(left) if left > 1e-9 else 0.0


def drift(logs: Sequence[Inputs], tried: Sequence[Vehicle]) -> Drift | None:
    """Estimate the surface drift; None if no dive shows it. ``tried``: the vehicle file that each
    log is reckoned with."""
    lengths = [length for log in logs for length in dives(log)]
    if not lengths:
        return None
    length = median(lengths)
    told = [
        likelihood(log, [with_drift(vehicle, share, length) for share in SHARES])
        for log, vehicle in zip(logs, tried, strict=True)
    ]
    ends = sum(len(each[0]) for each in told)
    if not ends:
        return None
    sums = [sum(sum(each[i]) for each in told) for i in range(len(SHARES))]
    weights = [math.exp(s - max(sums)) for s in sums]
    mean = sum(w * math.log(s) for w, s in zip(weights, SHARES, strict=True)) / sum(weights)
    share = math.exp(mean)
    if share < 1.0:  # a handful of dives leaves the spread uncertain
        share = min(FEW * share, 1.0) if ends >= ENOUGH else 1.0
    return Drift(share, ends, length)
