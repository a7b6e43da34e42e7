"""Bounds of one leg: on time, energy, place, depth and error.

``Bounds`` holds for every flight that reaches a place in the mission. The intended position is in
the box ``north`` x ``east``; the true position is within ``error`` of it, and never farther than
``range`` from home. A speed scale and a compass bias are constant, so they act on the way made good
since the last fix, not on the path. The current acts on the time, the compass's deviation on the
path. ``LegBounds`` turns the bounds on entering a leg into those on leaving it, for each way to
leave. It uses as bounds the clocks, a depth that ends the leg (a vehicle that does not know its
depth surfaces) and places that the leg steers to; any other guard may open at any time.

``Assumptions`` has the worst case for the sea and the vehicle.

What does not live here: where a leg leads by its text (places.py), the order of legs (flow.py),
what is refused (rules.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from mission.authoring.check.assumptions import (
    FROZEN,
    LATE,
    OVERSHOOT,
    SPEED_SHARE,
    STICKS,
    TURNED,
    TWO_SIGMA,
    Assumptions,
)
from mission.authoring.check.intervals import (
    Interval,
    grown,
    hull,
    hull_of,
    least,
    minus,
    opens_at,
    plus,
    reach,
    scaled,
)
from mission.authoring.check.places import places_of
from mission.engine.clearance import is_guarded, step_of
from mission.legs import LEGS
from mission.model import Axis, By, Expression, State
from mission.model.units import GEARS
from mission.model.vehicle import Vehicle
from mission.navigation.geodesy import LocalFrame
from protocol.messages import Setpoint

_AFLOAT: Interval = (0.0, 0.5)  # m (R7)


@dataclass(frozen=True, slots=True)
class Trail:
    """The way to a worst-case figure: the last leg, how it was left, and the trail before it."""

    leg: str
    by: By
    time: float  # s
    energy: float  # J
    before: Trail | None


class Bounds(NamedTuple):
    """Bounds at a moment of the mission. A tuple for speed: five are made for each leg walked."""

    time: float  # s since the start, at most
    energy: float  # J used, at most
    north: Interval  # m from home, intended position
    east: Interval
    depth: Interval  # m
    range: float  # m from home, true
    error: float  # m, true against intended position
    fixed_north: Interval  # m from home, at the last fix
    fixed_east: Interval
    made_north: Interval  # m made good since the last fix
    made_east: Interval
    since: float = 0.0  # s since the last fix
    path: float = 0.0  # m through the water since the last fix
    fastest: float = 0.0  # m/s through the water since the last fix
    strayed: float = 0.0  # m since the last fix, to any side of the intended position
    way: float = 0.0  # m/s through the water by the last setpoint
    ahead: float = math.inf  # m from home of the place it steers to; inf if there is none
    rises_to: float = math.inf  # m deep: the last setpoint lets the vehicle rise to here
    blind: float = 0.0  # m, greatest true depth if the sensor of a hold fails unnoticed
    trail: Trail | None = None  # the way with the greatest time
    spent: Trail | None = None  # the way with the greatest energy

    @staticmethod
    def start(within: float, fix: float, depth: float) -> Bounds:
        box, none = (-within, within), (0.0, 0.0)
        return Bounds(0.0, 0.0, box, box, (0.0, depth), within + fix, fix, box, box, none, none)

    def join(self, other: Bounds) -> Bounds:
        later = self if self.time >= other.time else other
        return Bounds(
            time=later.time,
            energy=max(self.energy, other.energy),
            north=hull(self.north, other.north),
            east=hull(self.east, other.east),
            depth=hull(self.depth, other.depth),
            range=max(self.range, other.range),
            error=max(self.error, other.error),
            fixed_north=hull(self.fixed_north, other.fixed_north),
            fixed_east=hull(self.fixed_east, other.fixed_east),
            made_north=hull(self.made_north, other.made_north),
            made_east=hull(self.made_east, other.made_east),
            since=max(self.since, other.since),
            path=max(self.path, other.path),
            fastest=max(self.fastest, other.fastest),
            strayed=max(self.strayed, other.strayed),
            way=max(self.way, other.way),
            ahead=max(self.ahead, other.ahead),
            rises_to=min(self.rises_to, other.rises_to),
            blind=max(self.blind, other.blind),
            trail=later.trail,
            spent=(self if self.energy >= other.energy else other).spent,
        )


class LegBounds:
    """The bounds of one leg on one vehicle; made once, used for every way to enter the leg."""

    def __init__(
        self, state: State, vehicle: Vehicle, assume: Assumptions, frame: LocalFrame | None
    ):
        assert state.leg is not None
        self.path, self.leg = state.path, state.leg
        self.row = LEGS[type(state.leg.kind)]
        self.setpoint = state.setpoint or Setpoint()
        self.vehicle, self.assume = vehicle, assume
        gear = GEARS * max(abs(self.setpoint.surge), abs(self.setpoint.turn))
        self.speed = vehicle.speed_by_gear.at(gear) if self.setpoint.surge else 0.0
        self.level = self.speed * math.cos(self.setpoint.pitch or 0.0)  # m/s, at least
        self.power = vehicle.battery.hotel + vehicle.thruster_power.at(gear) + self._vertical()
        self.places = places_of(self.leg.kind, frame)
        self.ascends = self.row.ascends
        self.depths = self.row.depths(self.leg.kind)  # m, depths that the leg may steer to itself
        self.dives = Axis.VERTICAL in self.row.steers and not self.ascends
        self.nose_down = self._nose_down()
        self.holds = self.nose_down <= vehicle.ascent_buoyancy  # buoyancy can lift it to its hold
        self.sinks = self._sinks()
        self.leans_on_floor = False  # some bound uses the assumed floor

    # --- time, power, rates ------------------------------------------------------------

    @property
    def duration(self) -> float:
        """Greatest s in this leg: the events that it waits for may never come; its clock does."""
        leg = self.leg
        limits = [t for t in (leg.duration, leg.timeout) if t is not None]
        for way in leg.exits:
            clock = opens_at(way.guard.expression, "elapsed")
            if clock is not None:
                limits.append(clock + way.guard.held)
        return min(limits)

    def _vertical(self) -> float:
        s = self.setpoint
        held = s.depth is not None or s.altitude is not None or bool(s.heave)
        active = held or Axis.VERTICAL in self.row.steers
        return self.vehicle.battery.vertical if active else 0.0

    def _nose_down(self) -> float:
        """Greatest m/s downward by the way along the bow; negative: upward."""
        s = self.setpoint
        along = math.copysign(self.speed * (1.0 + SPEED_SHARE), s.surge)
        return -along * math.sin(s.pitch or 0.0)

    def _sinks(self) -> float:
        """Greatest m/s downward: by verticals and way; without verticals, way less buoyancy."""
        s, lifts = self.setpoint, self.vehicle.ascent_buoyancy
        held = s.depth is not None or s.altitude is not None or self.dives
        pushes = held or (s.heave is not None and s.heave > 0)
        by_way = max(0.0, self.nose_down)
        return by_way + self.vehicle.dive_rate if pushes else max(0.0, by_way - lifts)

    # --- from entry to exit ----------------------------------------------------------------

    def sweep(self, entry: Bounds) -> Bounds:
        """The bounds at every moment of the leg, not only at its end."""
        after = self.leave(entry, By.ON)
        return after._replace(
            north=hull(entry.north, after.north),
            east=hull(entry.east, after.east),
            made_north=hull(entry.made_north, after.made_north),
            made_east=hull(entry.made_east, after.made_east),
            depth=hull(entry.depth, after.depth),
            range=max(entry.range, after.range),
        )

    def leave(self, entry: Bounds, by: By, *, guard: Expression | None = None) -> Bounds:
        time = self.duration
        after = entry._replace(
            time=entry.time + time,
            energy=entry.energy + time * self.power,
            depth=self._depth(entry, time),
            since=entry.since + time,
            path=entry.path + self.speed * time,
            fastest=max(entry.fastest, self.speed),
            way=self.speed,
            ahead=math.inf,
            rises_to=self._rises_to(),
            blind=self._blind(entry, time),
            trail=Trail(self.path, by, time, time * self.power, entry.trail),
            spent=Trail(self.path, by, time, time * self.power, entry.spent),
        )
        if self.ascends:
            return self._surfaced(after, time, by)
        if self.places:
            return self._steered(entry, after, time, by)
        return self._held(after, time, by, guard)

    def _rises_to(self) -> float:
        """m deep: the depth to which buoyancy or way may lift it while its set is in force."""
        s = self.setpoint
        if self.nose_down < 0.0:
            return 0.0
        if self.depths:
            return min(self.depths)
        if s.depth is not None:
            return 0.0 if is_guarded(s) else s.depth
        return math.inf if s.heave is not None and s.heave > 0 else 0.0

    def _error(self, at: Bounds) -> float:
        """m, two sigma; the speed scale acts along the way made good, the bias across it."""
        sensors = self.vehicle.sensors
        made = reach(at.made_north, at.made_east)
        constant = math.hypot(SPEED_SHARE, TWO_SIGMA * sensors.heading_bias)
        drift = self.assume.current * at.since
        lost = at.fastest * min(at.since, FROZEN + LATE)  # the compass fails, until that is known
        noise = TWO_SIGMA * sensors.fix + at.path * sensors.heading
        return noise + made * constant + at.strayed + lost + drift

    def _surfaced(self, after: Bounds, time: float, by: By) -> Bounds:
        farthest = after.range + self.assume.current * time
        if by is not By.END:
            return after._replace(error=self._error(after), range=farthest)
        if not self.row.awaits_fix(self.leg.kind):
            up = after._replace(range=farthest, depth=_AFLOAT, blind=_AFLOAT[1])
            return up._replace(error=self._error(up))
        error = self._error(after)
        north, east = grown(after.north, error), grown(after.east, error)
        fresh = Bounds.start(0.0, TWO_SIGMA * self.vehicle.sensors.fix, _AFLOAT[1])
        return fresh._replace(
            time=after.time,
            energy=after.energy,
            trail=after.trail,
            spent=after.spent,
            north=north,
            east=east,
            fixed_north=north,
            fixed_east=east,
            range=min(farthest, reach(north, east) + fresh.error),
        )

    def _depth(self, entry: Bounds, time: float) -> Interval:
        s = self.setpoint
        low, high = entry.depth
        deepest = high + self.sinks * (time + STICKS)
        if self.ascends or not self.sinks:
            return 0.0, high
        if self.holds and self.depths:
            shallowest, deepest = self._rises_to() - OVERSHOOT, max(self.depths) + OVERSHOOT
            return min(low, shallowest), max(high, deepest)
        if self.dives:
            return 0.0, max(high, deepest)
        if self.holds and s.depth is not None:
            return min(low, self._rises_to()), max(high, min(deepest, s.depth) + OVERSHOOT)
        for way in self.leg.exits:
            bound = opens_at(way.guard.expression, "depth")
            if bound is not None:
                late = self.sinks * (LATE + way.guard.held + STICKS)
                deepest = min(deepest, max(high, bound) + late)
        if self.holds and s.altitude is not None and deepest > self.assume.depth_without_floor:
            self.leans_on_floor = True
            deepest = min(deepest, max(high, self.assume.floor - s.altitude + OVERSHOOT))
        return 0.0, max(high, deepest)

    def blind(self, entry: Bounds) -> float:
        """Greatest depth in m if the sensor of a hold fails: the hold pushes down until the failure
        is known and the ascent has reversed the dive."""
        deepest = max(self._depth(entry, self.duration)[1], entry.blind)
        if not self.sinks:
            return deepest
        failed = max(self.duration, FROZEN + LATE) + STICKS + TURNED
        return self._above_floor(deepest, deepest + self.sinks * failed)

    def _blind(self, entry: Bounds, time: float) -> float:
        """``blind`` at the end of the leg. Near the commanded depth nothing detects a frozen
        reading: the hold pushes down until the leg ends, and the next hold starts from there."""
        if not self.sinks:
            return entry.blind
        deepest = max(entry.blind, self._depth(entry, time)[1])
        return self._above_floor(deepest, deepest + self.sinks * time)

    @property
    def holds_depth(self) -> bool:
        """Whether it goes down to a commanded depth, whatever the floor is there."""
        clears = self.holds and self.setpoint.altitude is not None
        return self.sinks > 0.0 and not self.ascends and not clears

    @property
    def least_floor(self) -> float:
        """m of water that a set with an altitude needs to have a depth to hold; else 0."""
        step = step_of(self.vehicle) if is_guarded(self.setpoint) else 0.0
        return step + (self.setpoint.altitude or 0.0)

    def _above_floor(self, deepest: float, deeper: float) -> float:
        """``deeper``, but not below the floor if the mission assumes one."""
        floor = math.inf if self.assume.depth_without_floor else self.assume.floor
        return max(deepest, min(deeper, floor))

    def _held(self, after: Bounds, time: float, by: By, guard: Expression | None) -> Bounds:
        """Leave a leg without places: along a heading, or around the place of entry."""
        around, heading = self.row.room(self.leg.kind), self.setpoint.heading
        if around or (self.speed and heading is None):
            free = around + self.row.within(self.leg.kind) if around else self.speed * time
            north = east = (-free, free)
        elif not self.speed or heading is None:
            north = east = (0.0, 0.0)
        else:
            bow = heading + self.assume.declination
            bow += 0.0 if self.setpoint.surge > 0 else math.pi
            along = self._along(time, by, guard)
            # until the bow has turned, it may move in any direction; half a turn at most
            turning = self.speed * min(time, math.pi / 2.0 / self.vehicle.turn_rate)
            north = grown(scaled(along, math.cos(bow)), turning)
            east = grown(scaled(along, math.sin(bow)), turning)
        moved = after._replace(
            north=plus(after.north, north),
            east=plus(after.east, east),
            made_north=plus(after.made_north, north),
            made_east=plus(after.made_east, east),
        )
        error = self._error(moved)
        swum = self.speed * (1.0 + SPEED_SHARE) * time + self.assume.current * time
        about = free + error if around else math.inf  # by the estimate, around the place of entry
        farthest = min(after.range + min(swum, about), reach(moved.north, moved.east) + error)
        return moved._replace(error=error, range=farthest)

    def _along(self, time: float, by: By, guard: Expression | None) -> Interval:
        """m through the water along the heading, if the leg is left by ``by``."""
        most = self.speed * time
        if by in (By.TIMEOUT, By.FOR):
            return self.level * time, most
        travelled = least(guard, "travelled") if by is By.UNTIL and guard is not None else 0.0
        # travelled counts over ground: a following current leaves less way through the water
        return min(most, travelled * self.speed / (self.speed + self.assume.current)), most

    def _steered(self, entry: Bounds, after: Bounds, time: float, by: By) -> Bounds:
        """Leave a leg to places, steered by the estimate: the true position is within the error.

        On a straight way the distance from home is greatest at one of its ends.
        """
        within = self.row.within(self.leg.kind)
        ends = self.places[-1:] if self.row.ends_at_last else self.places
        north = grown(hull_of(n for n, _ in ends), within)
        east = grown(hull_of(e for _, e in ends), within)
        after = after._replace(ahead=reach(north, east))
        arrived = self._at(after, north, east)
        share = self._share_of_way(entry, time)
        far = max(math.hypot(n, e) for n, e in self.places) + within + arrived.error
        stopped = (1.0 - share) * entry.range + share * far + (1.0 - share) * arrived.error
        turning = self.speed * math.pi / self.vehicle.turn_rate / 2.0
        if by is By.END:
            return arrived._replace(range=far)
        between = self._at(
            after,
            hull(entry.north, hull_of(n for n, _ in self.places)),
            hull(entry.east, hull_of(e for _, e in self.places)),
        )
        if by in (By.TIMEOUT, By.FOR) and share < 1.0:
            return between._replace(range=max(stopped, far if share else 0.0))
        return between._replace(range=max(entry.range + turning, stopped, far))

    def _at(self, after: Bounds, north: Interval, east: Interval) -> Bounds:
        there = after._replace(
            north=north,
            east=east,
            made_north=minus(north, after.fixed_north),
            made_east=minus(east, after.fixed_east),
        )
        error = self._error(there)
        return there._replace(error=error, ahead=after.ahead + error)

    def _share_of_way(self, entry: Bounds, time: float) -> float:
        """The share of the straight way to a single place that is certainly made in ``time``."""
        if len(self.places) != 1:
            return 1.0
        north, east = self.places[0]
        far = reach(minus(entry.north, (north, north)), minus(entry.east, (east, east)))
        made = max(0.0, self.level - self.assume.current) * time
        return 1.0 if far <= made else made / far
