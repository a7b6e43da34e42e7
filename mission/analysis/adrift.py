"""How far the water below differs from what fixes afloat told of it, by where dives end.

A current that is learned afloat holds the drift of that hour in it, by wind and waves; under water
the drift is gone, and what is left goes on changing. The larger both, the less the fixes before a
dive tell of the current below. No fix parts them, but the end of a dive tells what they are
together. Each of ``SHARES`` of the vehicle file's figures is tried on all dives, and the share is
the mean of their logarithms by likelihood (all are as likely before: dives that tell nothing leave
it as it was).

What is more than expected is the drift's. What is less is the current's pace, too, but for dives as
long as those that told it, and never steadier than a tide is for so long: in a time t a tide has
changed by 2 sigma^2 (1 - cos(2 pi t / period)), a process of correlation time T by
2 sigma^2 (1 - exp(-t / T)). A quarter of an hour says nothing of hours.
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
_LEAST = 1e-3  # m/s: of water that stands
_PERIOD = 12.42 * 3600.0  # s, of the moon's tide
ENOUGH = 4  # dives that may narrow it; any may widen it


@dataclass(frozen=True, slots=True)
class Drift:
    """``vehicle``'s figure times ``share``; ``dives`` of ``length`` s (the median) tell it."""

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
    """The correlation time of what changes by as much as a tide in ``length`` s."""
    left = math.cos(2.0 * math.pi * min(length / _PERIOD, 0.25))
    return -length / math.log(left) if left > 1e-9 else 0.0


def drift(logs: Sequence[Inputs], tried: Sequence[Vehicle]) -> Drift | None:
    """``tried``: what reckons each log. None where no dive tells it."""
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
    if share < 1.0:  # what a handful of dives leave open
        share = min(FEW * share, 1.0) if ends >= ENOUGH else 1.0
    return Drift(share, ends, length)
