"""How far wind and waves move a vehicle at the surface beside the current, by where dives end.

A current that is learned afloat holds the drift of that hour in it; under water the drift is gone.
So the larger the drift, the less the fixes before a dive tell of the current below. No fix parts
the two, but the end of a dive does. Each of ``SHARES`` of the vehicle file's figure is tried on all
dives, and the figure is the mean of their logarithms by likelihood (all are as likely before: dives
that tell nothing leave it as it was).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from mission.analysis.courses import Inputs
from mission.analysis.missed import likelihood
from mission.model.vehicle import Vehicle

SHARES = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
_LEAST = 1e-3  # m/s: of water that stands
ENOUGH = 4  # dives that may narrow it; any may widen it


@dataclass(frozen=True, slots=True)
class Drift:
    """``vehicle``'s figure times ``share``; ``dives`` tell it."""

    share: float
    dives: int


def with_drift(vehicle: Vehicle, share: float) -> Vehicle:
    known = vehicle.calibration
    drift = max(share * known.surface_drift, _LEAST)
    return replace(vehicle, calibration=replace(known, surface_drift=drift))


def drift(logs: Sequence[Inputs], tried: Sequence[Vehicle]) -> Drift | None:
    """``tried``: what reckons each log. None where no dive tells it."""
    told = [
        likelihood(log, [with_drift(vehicle, share) for share in SHARES])
        for log, vehicle in zip(logs, tried, strict=True)
    ]
    dives = sum(len(each[0]) for each in told)
    if not dives:
        return None
    sums = [sum(sum(each[i]) for each in told) for i in range(len(SHARES))]
    weights = [math.exp(s - max(sums)) for s in sums]
    mean = sum(w * math.log(s) for w, s in zip(weights, SHARES, strict=True)) / sum(weights)
    share = math.exp(mean)
    return Drift(share if dives >= ENOUGH else max(share, 1.0), dives)
