"""How long the ascent behind a leg takes, and what of the way it adds: R7, at most.

What does not live here: the bounds of a leg that ascends by itself (bounds.py).
"""

from __future__ import annotations

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
    """Continues into an ascent, which begins with W. As built W does not stick: what was asked for
    last goes on, ahead and upward, until that way of the ascent has ended."""
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
    """s to the surface and to know it, by buoyancy alone, after both ways of R7."""
    return ASCENT_TRIES + max(0.0, depth) / vehicle.ascent_buoyancy + SURFACED


def dark_time(vehicle: Vehicle) -> float:
    """Without a depth fixes prove the surface, after the way from its own depth (R7); a vehicle
    without a receiver never knows it."""
    if "depth" not in vehicle.reports:
        return 0.0
    return vehicle.limits.depth / vehicle.ascent_buoyancy + SETTLED
