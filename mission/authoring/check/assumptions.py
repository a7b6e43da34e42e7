"""What the sea and the vehicle are taken to do at most, and the constants behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mission.model import Mission
from mission.model.vehicle import Vehicle
from mission.navigation.declination import declination

TWO_SIGMA = 2.0
SPEED_SHARE = 0.2  # two sigma of the thruster model, as a share of the speed
OVERSHOOT = 1.0  # m beyond a depth that is held; R5 acts at 1 m beyond
FROZEN = 10.0  # s until a reading is known to be frozen: five reports alike, 2 s apart
LATE = 8.0  # s until a change of depth is known: one report (2 s) after 6 s without
TURNED = 3.0  # s until thrusters and buoyancy have turned a dive round
STICKS = 10.0  # s that a descent may go on after it was ended: as built, W does not stick (R7)
ASCENT_TRIES = 20.0  # s: W and X0 with U12, 10 s each, until the better is known (R7)
SURFACED = 8.0  # s: depth below 0.5 m for 6 s, and the report that says so (R7)


@dataclass(frozen=True, slots=True)
class Assumptions:
    """SI; from the mission's ``assume`` or the vehicle file."""

    current: float
    start: float
    depth: float  # m, at the start (R7)
    floor: float  # m, the deepest there is; where none is assumed, the depth allowed
    depth_without_floor: float  # m, up to which an altitude hold is bounded by clocks alone
    heading: float  # rad, two sigma
    declination: float  # rad, at home: a heading that is held is the compass's

    @staticmethod
    def of(mission: Mission, vehicle: Vehicle, allowed: float) -> Assumptions:
        """``allowed``: the depth in force, m."""
        given = dict(mission.assume)
        sensors = vehicle.sensors
        return Assumptions(
            current=mission.current(vehicle.current),
            start=mission.start_within(sensors.fix),
            depth=2.0 if mission.start_without_fix else 0.5,
            floor=given.get("floor", allowed),
            depth_without_floor=0.0 if "floor" in given else allowed,
            heading=TWO_SIGMA * math.hypot(sensors.heading, sensors.heading_bias),
            declination=_declination(mission, vehicle),
        )


def _declination(mission: Mission, vehicle: Vehicle) -> float:
    """rad; where home is not known, all directions turn alike and it does not matter."""
    if vehicle.declination is not None or mission.home is None:
        return vehicle.declination or 0.0
    home = mission.home
    return declination(math.radians(home.latitude_deg), math.radians(home.longitude_deg))
