"""The planned track: the mission flown once in still water.

The product itself flies it, so that every leg, guard and fix is as at sea, and the uncertainty is
what the vehicle's own estimate will say. Nothing is disturbed: the way that is drawn is the way
that is meant.

    Unplanned         (the author must act: the mission does not come to its end in still water)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors
from links.simulated.settings import Settings
from mission.authoring.check.fenced import fenced
from mission.authoring.check.places import local_of, pattern_of, places_of
from mission.engine.areas import Fence
from mission.legs import Follow, Loiter
from mission.legs.base import Point
from mission.model import Leg, LegKind, Mission, Position, State
from mission.model.chart import Chart
from mission.model.vehicle import Vehicle
from mission.navigation.distribution import PLANE_95
from mission.navigation.geodesy import LocalFrame
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight, Sample

_CIRCLE = 36  # corners of a circle that is drawn
_TRUE = SensorErrors(  # noise alone, without which a sensor counts as frozen
    compass_bias=0.0, compass_slow=0.0, deviation=0.0, depth_bias=0.0
)


class Unplanned(ValueError):
    """The mission has no planned track; says how its flight in still water ended."""


@dataclass(frozen=True, slots=True)
class Spot:
    """The vehicle at ``t`` s: m from home, m deep; ``axes`` are the half axes (m) of the 95 %
    ellipse and ``bearing`` that of the longer one (rad)."""

    t: float
    north: float
    east: float
    depth: float
    axes: tuple[float, float]
    bearing: float


@dataclass(frozen=True, slots=True)
class Stretch:
    """One leg as planned, with its turning points (times and places among its spots)."""

    name: str
    begin: float
    end: float
    spots: tuple[Spot, ...]
    turns: tuple[Spot, ...]
    area: tuple[Point, ...]  # its outline, m from home; empty where it has none


@dataclass(frozen=True, slots=True)
class Plan:
    mission: str
    home: Position | None
    radius: float
    seconds: float
    stretches: tuple[Stretch, ...]
    fences: tuple[Fence, ...] = ()


def planned(mission: Mission, chart: Chart, vehicle: Vehicle) -> Plan:
    """Raises Unplanned."""
    floor = dict(mission.assume).get("floor")
    sea = Sea() if floor is None else Sea(floor=floor)
    flight = fly(mission, vehicle, settings=Settings(sea=sea, errors=_TRUE))
    if flight.outcome != "completed":
        raise Unplanned(f"in still water it is not completed: {flight.reason}")
    frame = LocalFrame(mission.home) if mission.home is not None else None
    legs = {state.path.partition("/")[2]: state for state in chart.states if state.leg}
    radius = min(vehicle.limits.radius, mission.safety.radius or math.inf)
    stretches = tuple(_stretches(flight, legs, frame))
    return Plan(mission.name, mission.home, radius, flight.mission_time, stretches, fenced(mission))


def _stretches(
    flight: Flight, legs: dict[str, State], frame: LocalFrame | None
) -> Iterator[Stretch]:
    for flown in flight.legs:
        inside = [s for s in flight.samples if flown.entered <= s.t <= flown.left]
        spots = tuple(_spot(sample) for sample in inside)
        state = legs.get(flown.name.partition("#")[0])
        kind = state.leg.kind if state is not None and isinstance(state.leg, Leg) else None
        begin = (spots[0].north, spots[0].east) if spots else (0.0, 0.0)
        turns = (
            tuple(_nearest(spots, point) for point in _turns(kind, begin, frame)) if spots else ()
        )
        area = _area(kind, begin, frame)
        yield Stretch(flown.name, flown.entered, flown.left, spots, turns, area)


def _spot(sample: Sample) -> Spot:
    """Where it means to be: the estimate, which has nothing to be wrong about in still water."""
    estimate = sample.estimate
    nn, ne, ee = estimate.covariance
    middle, spread = (nn + ee) / 2.0, math.hypot((nn - ee) / 2.0, ne)
    axes = (PLANE_95 * math.sqrt(middle + spread), PLANE_95 * math.sqrt(max(middle - spread, 0.0)))
    bearing = 0.5 * math.atan2(2.0 * ne, nn - ee)
    return Spot(sample.t, estimate.north, estimate.east, sample.true.depth, axes, bearing)


def _nearest(spots: tuple[Spot, ...], point: Point) -> Spot:
    return min(spots, key=lambda spot: math.dist((spot.north, spot.east), point))


def _turns(kind: LegKind | None, begin: Point, frame: LocalFrame | None) -> tuple[Point, ...]:
    if kind is not None and (pattern := pattern_of(kind, frame, begin)) is not None:
        return pattern.points
    return places_of(kind, frame) if isinstance(kind, Follow) else ()


def _area(kind: LegKind | None, begin: Point, frame: LocalFrame | None) -> tuple[Point, ...]:
    if kind is not None and (pattern := pattern_of(kind, frame, begin)) is not None:
        return pattern.outline
    match kind:
        case Loiter(place, radius):
            centre = begin if place is None else local_of(place, frame)
            turns = (math.tau * step / _CIRCLE for step in range(_CIRCLE))
            return tuple(
                (centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in turns
            )
        case _:
            return ()
