"""Upper bounds on the time of the ascent behind a leg, and on the way that it adds (R7).

What does not live here: the bounds of a leg that ascends by itself (bounds.py).
"""

from __future__ import annotations

import math

from mission.authoring.check.assumptions import (
    ASCENT_TRIES,
    OVERSHOOT,
    SPEED_SHARE,
    STICKS,
    SURFACED,
)
from mission.authoring.check.bounds import Bounds
from mission.model.vehicle import Vehicle
from mission.navigation.fixes import SETTLED


def goes_on(leaving: Bounds, vehicle: Vehicle) -> Bounds:
    """The bounds when a leg changes into an ascent, which begins with W. As built, W does not last:
    the previous setpoint continues, ahead and upward, until this way of the ascent has ended."""
    deeper = max(0.0, leaving.depth[1] - OVERSHOOT - leaving.rises_to)
    time = 2.0 * STICKS + deeper / vehicle.ascent_buoyancy
    power = vehicle.thruster_power.at(vehicle.speed_by_gear.inverse(leaving.way))
    swum = time * leaving.way * (1.0 + SPEED_SHARE)
    return leaving._replace(
        energy=leaving.energy + time * power,
        range=max(leaving.range, min(leaving.range, leaving.ahead) + swum),
        strayed=leaving.strayed + swum,
        error=leaving.error + swum,
        way=0.0,
    )


def ascent_time(depth: float, vehicle: Vehicle) -> float:
    """s to reach the surface and to prove it, by buoyancy alone, after both other ways of R7."""
    return ASCENT_TRIES + max(0.0, depth) / vehicle.ascent_buoyancy + SURFACED


def dark_time(vehicle: Vehicle) -> float:
    """s more if no depth is believed: fixes prove the surface only after the rise from the greatest
    depth of the vehicle (R7). 0 for a vehicle that reports no depth, inf for one that reports no
    position: only an operator ends its ascent."""
    if "depth" not in vehicle.reports:
        return 0.0
    if "position" not in vehicle.reports:
        return math.inf
    return vehicle.limits.depth / vehicle.ascent_buoyancy + SETTLED
