"""Navigation: Telemetry and Fix in, Estimate and Health out.

It holds the frame (origin, declination), and asks health which values are believed. It keeps the
last input: for an item that arrives late, the filter goes back to the item's time, processes it,
and then processes the later items again.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mission.model import Estimate, Health, NavigationMode, Position, Vertical
from mission.model.vehicle import Vehicle
from mission.navigation.added import ADDED
from mission.navigation.belief import UNPUSHED, DepthBelief
from mission.navigation.declination import declination
from mission.navigation.distribution import PLANE_95
from mission.navigation.geodesy import LocalFrame
from mission.navigation.health import SensorHealth
from mission.navigation.items import Aiding, GroundFix, Item, Report
from protocol.added import PLACE, RANGE
from protocol.messages import Aid, Fix, Telemetry

if TYPE_CHECKING:
    from mission.navigation.model import Figures

_LATEST = 15.0  # s: an item that is later is dropped
_APART = 0.8  # s between two values of a sensor that count: one a second, with jitter
_FIX = "fix"  # the source of the receivers' fixes, beside the kinds of added sensors
_KEEP = 64  # items of input that the filter can go back over
_NEARLY = 1.0  # s: an item that is at most so much older than those counts as of the first
_FAR = 100_000.0  # m from the origin: up to there the plane is accurate enough
_FRESH = 5.0  # s: a younger fix means that fixes are coming in (R9)


class Navigation:
    """The position estimate and sensor health of one vehicle. ``date`` (YYYY-MM-DD) is for the
    magnetic model until a fix brings a date."""

    def __init__(
        self,
        vehicle: Vehicle,
        origin: Position | None = None,
        *,
        date: str | None = None,
        figures: Figures | None = None,
    ) -> None:
        from mission.navigation.model import figures as believed
        from mission.navigation.reckoner import Reckoner

        self._vehicle = vehicle
        self._date = date
        self._health = SensorHealth(vehicle.reports, vehicle.stale_after)
        self.core = Reckoner(vehicle, figures or believed(vehicle))
        self._history: deque[tuple[Item, tuple[Any, ...]]] = deque(maxlen=_KEEP)
        self._heard: Mapping[str, float] = {}  # times of values; replaced, never written to
        self.dropped = 0  # items that came too late
        self._own_off = 0.0, 0.0  # m: error of the vehicle's own position when fixes last came
        self._placed_at = -math.inf  # s: of the last fix, or own position at the surface
        self.frame: LocalFrame | None = None
        self._counted = origin is not None  # positions count from there, or from a mission's start
        self._declination = vehicle.declination or 0.0
        if origin is not None:
            self._settle(LocalFrame(origin))

    # --- frame -----------------------------------------------------------------------------------

    def set_origin(self, position: Position, now: float) -> None:
        """Set home. The vehicle's estimated position is kept, and expressed in the new frame."""
        core, new = self.core, LocalFrame(position)
        if core.located and self.frame is not None:
            x = core.filter.x
            here = self.frame.to_geodetic(float(x[0]), float(x[1]))
            north, east = new.to_local(*here)
            core.filter.shift(north - float(x[0]), east - float(x[1]))
            core.settle()
        self._counted = True
        self._settle(new)

    def start_here(self, now: float, within: float = 0.0) -> None:
        """Start without a fix: the vehicle is at the origin, and positions count from the start.
        The next fix then places the origin on the earth, or a home that is set, from which the
        vehicle is ``within`` m (95 %). An earlier frame is forgotten."""
        sigma = max(within / PLANE_95, 0.1)
        self.core.place(now, 0.0, 0.0, sigma * sigma, assumed=within > 0.0)
        self.frame, self._own_off, self._counted = None, (0.0, 0.0), True
        self._history.clear()

    def assume_current(self, most: float) -> None:
        """Take the current at the start of a mission as up to ``most`` m/s, whatever was learned
        before. A vehicle that is held or moored has found no current; one that was carried or towed
        has found a greater one."""
        self.core.filter.doubt_current(max(most, self.core.filter.current_found) / PLANE_95)
        self.core.settle()
        self._history.clear()

    def _settle(self, frame: LocalFrame) -> None:
        self.frame = frame
        self._history.clear()
        self._decline()

    def _decline(self) -> None:
        if self._vehicle.declination is None and self.frame is not None:
            o = self.frame.origin
            lat, lon = math.radians(o.latitude_deg), math.radians(o.longitude_deg)
            found = declination(lat, lon, self._date and self._date[:10])
            if found != self._declination:
                self.core.decline(found - self._declination)
                self._declination = found
                self._history.clear()  # its reports contain the old declination

    @property
    def declination(self) -> float:
        return self._declination

    # --- in --------------------------------------------------------------------------------------

    def telemetry(self, t: Telemetry, push: Vertical = UNPUSHED) -> None:
        good = self._health.telemetry(t, push)
        heading = t.heading if "heading" in good else None
        self._take(
            Report(
                t.t,
                None if heading is None else self._straighten(heading),
                t.pitch if "pitch" in good else None,
                t.actuators,
                t.depth if "depth" in good else None,
                t.altitude
                if "altitude" in good and not self._health.repeated("altitude")
                else None,
            )
        )

    def _straighten(self, compass: float) -> float:
        """Subtract the known error from a compass heading, and add the declination; rad."""
        vehicle = self._vehicle
        known = vehicle.compass_bias + vehicle.calibration.deviation.at(compass)
        return compass + self._declination - known

    def forget_depth(self) -> None:
        """Compare later depths with nothing from before."""
        self._health.forget("depth")
        self._health.belief = DepthBelief()

    def fix(self, f: Fix) -> None:
        """Take a fix, or the position that the vehicle computes itself, which is no fix. While a
        receiver sends new places, that position is only compared; later it counts less its
        error."""
        own = f.accuracy == math.inf
        if own and self._health.receives(f.t):
            self._compare(f)
            return
        if not self._health.fix(f):
            return
        if not own and not self._due(_FIX, f.t):
            return
        if self._date is None and f.utc is not None:
            self._date = f.utc
            self._decline()
        if self.frame is None:
            self._settle(self._frame_through(f))
        assert self.frame is not None
        north, east = self.frame.to_local(f.latitude, f.longitude)
        if own:
            north, east = north - self._own_off[0], east - self._own_off[1]
        if own and not self._health.afloat(f.t):
            self._reckoned(f.t, north, east)
            return
        self._placed_at = f.t
        sigma = f.accuracy if 0.0 < f.accuracy < math.inf else self._vehicle.sensors.fix
        velocity = None
        if f.speed is not None and f.course is not None:
            velocity = f.speed * math.cos(f.course), f.speed * math.sin(f.course)
        self._take(GroundFix(f.t, north, east, sigma * sigma, velocity))
        if not self._counted and math.hypot(north, east) > _FAR:
            self._go_there(f, sigma)

    def _reckoned(self, t: float, north: float, east: float) -> None:
        """Take a position that the vehicle reckons, not known to be at the surface. It is no fix:
        it may see no current. Its error lasts: all since the surface tell what the last does."""
        since = max(t - self._placed_at, 1.0)
        if since < math.inf:
            sigma = math.hypot(self._vehicle.sensors.fix, self._vehicle.reckoned * since)
            self._take(Aiding(t, PLACE, (north, east), sigma * math.sqrt(since), "own"))

    def _go_there(self, f: Fix, sigma: float) -> None:
        """Move the frame to a fix that was used, if the frame cannot express its place: then the
        first fix was wild."""
        assert self.frame is not None
        used = self.core.last_fix == self.core.t == f.t
        if used and not self.frame.reaches(f.latitude, f.longitude):
            self.core.place(f.t, 0.0, 0.0, sigma * sigma)
            self._own_off = 0.0, 0.0
            self._settle(LocalFrame(Position(math.degrees(f.latitude), math.degrees(f.longitude))))

    def less_off(self, own: Fix) -> Fix:
        """Return the vehicle's own position less its error when fixes last came."""
        if self.frame is None or self._own_off == (0.0, 0.0):
            return own
        north, east = self.frame.to_local(own.latitude, own.longitude)
        there = self.frame.to_geodetic(north - self._own_off[0], east - self._own_off[1])
        return replace(own, latitude=there[0], longitude=there[1])

    def _compare(self, own: Fix) -> None:
        if self.frame is not None and self.core.located:
            x = self.core.filter.x
            north, east = self.frame.to_local(own.latitude, own.longitude)
            self._own_off = north - float(x[0]), east - float(x[1])

    def _due(self, source: str, t: float) -> bool:
        """Whether a value counts: one a second of each source does, however often it reports."""
        if abs(t - self._heard.get(source, -math.inf)) < _APART:
            return False
        self._heard = {**self._heard, source: t}
        return True

    def aid(self, a: Aid) -> None:
        """Take a value of an added sensor. Without a frame, a place or a range is ignored; so is
        the range to a beacon that the vehicle file does not have. However often a sensor reports,
        one value a second counts: all of them share the errors of heading and report."""
        source = f"{a.values[0]:g}" if a.kind == RANGE else ""
        sigma = self._vehicle.added.get(a.kind, ADDED[a.kind].sigma)
        item = Aiding(a.t, a.kind, a.values, sigma, source)
        if not self._due(item.key, a.t):
            return
        if a.kind in (PLACE, RANGE):
            if self.frame is None:
                return
            beacon = self._vehicle.beacons.get(source)
            if a.kind == PLACE:
                item = item._replace(values=self.frame.to_local(*a.values))
            elif beacon is not None:
                place = self.frame.to_local(beacon.latitude, beacon.longitude)
                item = item._replace(values=(*place, beacon.depth, a.values[1] * beacon.sound))
            else:
                return
        self._take(item)

    def _frame_through(self, f: Fix) -> LocalFrame:
        """Return the frame in which a vehicle that started without a fix is at its estimate."""
        here = LocalFrame(Position(math.degrees(f.latitude), math.degrees(f.longitude)))
        if not self.core.located:
            return here
        x = self.core.filter.x
        lat, lon = here.to_geodetic(-float(x[0]), -float(x[1]))
        return LocalFrame(Position(math.degrees(lat), math.degrees(lon)))

    def _take(self, item: Item) -> None:
        """Process an item at its own time. An item that is too late is dropped, and counted."""
        core, history = self.core, self._history
        if core.t is None or item.t >= core.t:
            history.append((item, core.save()))
            core.take(item)
            return
        if core.t - item.t > _LATEST or not self._reaches(item.t):
            self.dropped += 1
            return
        again: list[Item] = []
        while history and history[-1][0].t > item.t:
            later, before = history.pop()
            core.load(before)
            again.append(later)
        for one in (item, *reversed(again)):
            history.append((one, core.save()))
            core.take(one)

    def _reaches(self, t: float) -> bool:
        """Whether the filter can go back to ``t``. A new frame, start or declination empties the
        memory, and the first fix often comes after its report: it counts as of the beginning."""
        began = self.core.t
        if self._history:
            _, _, (began, *_) = self._history[0][1]  # the core's ``t`` before that item
        return began is None or t >= began - _NEARLY

    # --- out -------------------------------------------------------------------------------------

    def health(self, sensor: str, now: float) -> Health:
        return self._health.of(sensor, now)

    def estimate(self, now: float) -> Estimate | None:
        """Return the estimate at ``now``, None before any input. It predicts from the last input,
        and changes nothing."""
        core = self.core
        if core.t is None:
            return None
        dt = now - core.t
        if dt <= 0.0:
            return self._estimate(now, *core.filter.told())
        before = core.filter.save()
        core.filter.predict(dt, core.run(core.t, core.t + dt))
        told = core.filter.told()
        core.filter.load(before)
        return self._estimate(now, *told)

    def _estimate(self, now: float, x: list[float], p: list[float]) -> Estimate:
        """Make the estimate from what ``Filter.told`` returned."""
        core = self.core
        nn, ne, ee, cn, ce, aa, ab, bb, dd, dg, gg, rr, *compass = p
        u, shown = core.expected, core.heading
        deep, high = core.depth_seen, core.depth_seen and core.altitude_seen
        heading, heading_var = None, math.pi**2
        if shown is not None:
            s, c = math.sin(shown), math.cos(shown)
            heading = (shown - x[8] - x[9] * s - x[10] * c - x[11]) % (2.0 * math.pi)
            heading_var = self._heading_variance(compass, s, c) + core.heading_loss(now) ** 2
        w = core.driven
        speed_var = aa * u * u + 2.0 * u * w * ab + bb * w * w
        return Estimate(
            t=now,
            north=x[0],
            east=x[1],
            depth=x[12] if deep else None,
            depth_rate=x[13] if deep else None,
            altitude=x[14] - x[12] if high else None,
            heading=heading,
            speed=x[6] * u + x[7] * w,
            current_north=x[2],
            current_east=x[3],
            covariance=(nn, ne, ee),
            sigmas={
                "depth": math.sqrt(dd + 0.5 * core.figures.depth**2),
                "depth_rate": math.sqrt(rr),
                "altitude": math.sqrt(max(dd + gg - 2.0 * dg, 0.0)),
                "heading": math.sqrt(heading_var),
                "speed": math.sqrt(max(speed_var, 0.0)),
                "current": math.sqrt(0.5 * (cn + ce)),
            },
            nis=core.nis,
            fix_age=None if core.last_fix is None else now - core.last_fix,
            mode=self._mode(now),
        )

    def _heading_variance(self, compass: list[float], s: float, c: float) -> float:
        """Of one report, rad^2: the compass's error at this heading, and its noise."""
        e, es, ec, ew, ss, sc, sw, cc, cw, ww = compass
        once = e + ww + s * s * ss + c * c * cc
        twice = ew + s * (es + sw) + c * (ec + cw) + s * c * sc
        return max(once + 2.0 * twice, 0.0) + self.core.figures.heading**2

    def _mode(self, now: float) -> NavigationMode:
        if not self.core.located:
            return NavigationMode.NONE
        last = self.core.last_fix
        fresh = last is not None and now - last <= _FRESH
        return NavigationMode.FIX if fresh else NavigationMode.DEAD_RECKONING

    # --- whole -----------------------------------------------------------------------------------

    def snapshot(self) -> Any:
        """Return all that ``restore`` needs to continue from here, to the last bit."""
        monitors = {name: copy(m) for name, m in self._health.monitors.items()}
        kept = (self.frame, self._counted, self._own_off, self._date, self._declination)
        health = self._health
        judges = health.receiver.clone(), health.own.clone(), health.belief.clone()
        seen = health.moving, *judges
        late = self._heard, self.dropped, self._placed_at
        return self.core.save(), monitors, tuple(self._history), kept, seen, late

    def restore(self, snapshot: Any) -> None:
        core, monitors, history, kept, seen, late = snapshot
        self._heard, self.dropped, self._placed_at = late
        self.core.load(core)
        self._health.monitors = {name: copy(m) for name, m in monitors.items()}
        self._health.moving, receiver, own, belief = seen
        self._health.receiver, self._health.own = receiver.clone(), own.clone()
        self._health.belief = belief.clone()
        self._history = deque(history, maxlen=_KEEP)
        self.frame, self._counted, self._own_off, self._date, self._declination = kept
