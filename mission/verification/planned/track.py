"""The planned track: the mission flown once in still water.

The real program flies it, so every leg, guard and fix is as at sea. The uncertainty is that of the
vehicle's own estimate: with the current of the vehicle file, whatever the mission assumes. Beside
it stands what the check expects of dives in the assumed current. There are no disturbances, so the
drawn track is the intended one. The sea floor is that which the mission assumes, or that of a file
of depths.

    Unplanned         (the author must act: the mission does not come to its end in still water)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from links.simulated.plant import Body
from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors
from links.simulated.settings import Settings
from mission.authoring.bathymetry import Depths
from mission.authoring.check.fenced import fenced
from mission.authoring.check.outlook import TooManyError, outlooks
from mission.authoring.check.places import local_of, pattern_of, places_of
from mission.engine.areas import Fence
from mission.legs import Follow, Loiter
from mission.legs.base import Point
from mission.model import IMPLICIT_SURFACE, Leg, LegKind, Mission, Position, State
from mission.model.chart import Chart
from mission.model.vehicle import Vehicle
from mission.navigation.distribution import PLANE_95
from mission.navigation.geodesy import LocalFrame
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight, Sample
from mission.verification.simulation.seafloor import Clearance, over

_CIRCLE = 36  # corners of a drawn circle
_TRUE = SensorErrors(  # noise only; without noise a sensor would count as frozen
    compass_bias=0.0, compass_slow=0.0, deviation=0.0, depth_bias=0.0
)


class Unplanned(ValueError):
    """The mission has no planned track; the message says how its flight in still water ended."""


@dataclass(frozen=True, slots=True)
class Spot:
    """The vehicle at ``t`` s: m from home, m deep. ``axes``: the half axes (m) of the 95 % ellipse;
    ``bearing``: of the longer axis, rad; ``floor``: depth (m) of the sea floor below, if a file has
    it."""

    t: float
    north: float
    east: float
    depth: float
    axes: tuple[float, float]
    bearing: float
    floor: float | None = None

    @property
    def water(self) -> float | None:
        """m under the vehicle."""
        return None if self.floor is None else self.floor - self.depth


@dataclass(frozen=True, slots=True)
class Stretch:
    """One leg as planned, with its turning points (times and places among its spots)."""

    name: str
    begin: float
    end: float
    spots: tuple[Spot, ...]
    turns: tuple[Spot, ...]
    area: tuple[Point, ...]  # its outline, m from home; empty without an area
    expected: float | None = None  # m within which 95 % of dives stay, as the check expects

    @property
    def water(self) -> float | None:
        """The least m under the vehicle; None if the floor is not known."""
        return min((spot.water for spot in self.spots if spot.water is not None), default=None)


@dataclass(frozen=True, slots=True)
class Plan:
    mission: str
    home: Position | None
    radius: float
    seconds: float
    stretches: tuple[Stretch, ...]
    fences: tuple[Fence, ...] = ()
    clearance: Clearance | None = None  # the least water under it, if a file has the floor
    unflown: tuple[str, ...] = ()  # legs that were not reached in still water


@dataclass(frozen=True, slots=True)
class _Ground:
    """The frame of the plan, and the depths of its sea floor, as far as known."""

    frame: LocalFrame | None
    depths: Depths | None

    def floor(self, north: float, east: float) -> float | None:
        if self.depths is None or self.frame is None:
            return None
        return self.depths.at(*map(math.degrees, self.frame.to_geodetic(north, east)))

    def clearance(self, stretches: tuple[Stretch, ...]) -> Clearance | None:
        spots = [spot for leg in stretches for spot in leg.spots if spot.water is not None]
        if self.frame is None or not spots:
            return None
        spot = min(spots, key=lambda spot: spot.water or 0.0)
        place = map(math.degrees, self.frame.to_geodetic(spot.north, spot.east))
        return Clearance(spot.water or 0.0, spot.t, *place)


def planned(mission: Mission, chart: Chart, vehicle: Vehicle, depths: Depths | None = None) -> Plan:
    """Plan a mission, over the sea floor of ``depths`` as far as they have it. Raises
    Unplanned."""
    if depths is not None and mission.home is None:
        raise Unplanned("the mission names no home, so that no depth lies under it; write home")
    flight = fly(mission, vehicle, settings=_still(mission, depths))
    ground = _Ground(LocalFrame(mission.home) if mission.home is not None else None, depths)
    legs = {state.path.partition("/")[2]: state for state in chart.states if state.leg}
    expects = _expected(mission, vehicle)
    stretches = tuple(
        replace(leg, expected=expects.get(leg.name.partition("#")[0]))
        for leg in _stretches(flight, legs, ground)
    )
    near = ground.clearance(stretches)
    if flight.outcome != "completed":
        under = "" if near is None else f"; {near.told}"
        raise Unplanned(f"in still water it is not completed: {flight.reason}{under}")
    radius = min(vehicle.limits.radius, mission.safety.radius or math.inf)
    seconds, fences = flight.mission_time, fenced(mission)
    flown = {leg.name.partition("#")[0] for leg in stretches}
    own = (name for name in legs if legs[name].path != IMPLICIT_SURFACE)
    unflown = tuple(name for name in own if name not in flown)
    return Plan(mission.name, mission.home, radius, seconds, stretches, fences, near, unflown)


def _expected(mission: Mission, vehicle: Vehicle) -> dict[str, float]:
    """Return what the check expects in m, by the name of a leg or of its row; of several rounds the
    worst."""
    try:
        surveys, legs, _ = outlooks(mission, vehicle)
    except TooManyError:
        return {}
    rows = {
        f"{path}/row{number}": error
        for path, survey in surveys.items()
        for number, error in enumerate(survey.errors, 1)
    }
    return legs | rows


def _still(mission: Mission, depths: Depths | None) -> Settings:
    """Return settings of still water. The vehicle sees the floor of a file but does not touch it,
    so that the track stays the intended one."""
    floor = dict(mission.assume).get("floor")
    still = Settings(sea=Sea() if floor is None else Sea(floor=floor), errors=_TRUE)
    if depths is None:
        return still
    return over(replace(still, body=Body(floor_clearance=-math.inf)), mission, depths)


def _stretches(flight: Flight, legs: dict[str, State], ground: _Ground) -> Iterator[Stretch]:
    frame = ground.frame
    for flown in flight.legs:
        inside = [s for s in flight.samples if flown.entered <= s.t <= flown.left]
        spots = tuple(_spot(sample, ground) for sample in inside)
        state = legs.get(flown.name.partition("#")[0])
        kind = state.leg.kind if state is not None and isinstance(state.leg, Leg) else None
        begin = (spots[0].north, spots[0].east) if spots else (0.0, 0.0)
        turns = (
            tuple(_nearest(spots, point) for point in _turns(kind, begin, frame)) if spots else ()
        )
        area = _area(kind, begin, frame)
        yield Stretch(flown.name, flown.entered, flown.left, spots, turns, area)


def _spot(sample: Sample, ground: _Ground) -> Spot:
    """Return the planned place: that of the estimate, which has no errors in still water."""
    estimate = sample.estimate
    nn, ne, ee = estimate.covariance
    middle, spread = (nn + ee) / 2.0, math.hypot((nn - ee) / 2.0, ne)
    axes = (PLANE_95 * math.sqrt(middle + spread), PLANE_95 * math.sqrt(max(middle - spread, 0.0)))
    bearing = 0.5 * math.atan2(2.0 * ne, nn - ee)
    floor = ground.floor(sample.true.north, sample.true.east)
    north, east, depth = estimate.north, estimate.east, sample.true.depth
    return Spot(sample.t, north, east, depth, axes, bearing, floor)


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
