"""Where the vehicle is when a proof begins: a place where no guard on the range is open and no leg
ends.

What does not live here: the bytes that report it (wire), the ways from there (configurations).
"""

from __future__ import annotations

import math
from dataclasses import replace

from mission.authoring.check.places import places_of
from mission.authoring.prepare import Prepared
from mission.legs import LEGS
from mission.legs.base import Point
from mission.model import Mission, Position
from mission.model.texts import legs_of
from mission.navigation.geodesy import LocalFrame
from mission.verification.exhaustive.wire import RANGE

_BEARINGS = tuple(map(math.radians, range(0, 360, 30)))
_CLEAR = 5.0  # m from a place where a leg would end


def mooring(prepared: Prepared, home: Position) -> Point:
    """Return a place in m north and east of home: RANGE to the north, unless a leg would end
    there; then another bearing at this range."""
    frame = LocalFrame(home)
    ends = [
        (place, LEGS[type(leg.kind)].within(leg.kind))
        for leg in legs_of(prepared.mission.body)
        for place in places_of(leg.kind, frame)
    ]

    def clear(here: Point) -> float:
        return min((math.dist(here, there) - within for there, within in ends), default=math.inf)

    circle = [(RANGE * math.cos(b), RANGE * math.sin(b)) for b in _BEARINGS]
    return next((here for here in circle if clear(here) > _CLEAR), max(circle, key=clear))


def from_afar(prepared: Prepared) -> Mission:
    """Return the mission, with an assumed start and a radius that let it start at ``mooring``."""
    mission = replace(prepared.mission, vehicle=prepared.vehicle.name)
    if "position" not in prepared.vehicle.reports:
        return mission
    away = RANGE + 2.0
    given = [(name, value) for name, value in mission.assume if name != "start"]
    safety = mission.safety
    if safety.radius is not None:
        safety = replace(safety, radius=safety.radius + away)
    return replace(mission, safety=safety, assume=(*given, ("start", away)))
