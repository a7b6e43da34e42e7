"""Dead reckoning between reports and fixes, in time order, with the gate for fixes.

    Report  -> predict to its time along its own heading -> correct depth and altitude
    GroundFix -> predict to its time -> gate -> correct position -> correct velocity
    Aiding -> a place, a range: the same; a speed: wait for the next report -> gate -> correct

A fix whose normalised innovation squared is beyond the gate is rejected. Three rejected fixes in a
row that agree with each other open the gate: they widen the covariance of all that moves the
position until the fix fits, so the jump also teaches current, scale and compass. The filter's state
before the first fix after a dive, and before the gate opened, is kept for a while. If it fits the
fixes that agree, the fixes between were wrong, and the filter goes back to that state instead.

What does not live here: sensors' health, frames, late input.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from mission.model.vehicle import Vehicle
from mission.navigation.added import Seen
from mission.navigation.filter import Filter, Motion
from mission.navigation.hull import correct, fits, innovation
from mission.navigation.items import Aiding, GroundFix, Item, Report, Reported, agree
from mission.navigation.model import RATE, Figures, propulsion
from mission.navigation.seaway import Seaway
from protocol.added import PLACE, RANGE

GATE = 13.816  # chi-square, 2 degrees of freedom, 99.9 %
_AGREEING = 3  # rejected fixes in a row that open the gate
_GAP, _MEMORY = 60.0, 120.0  # s without a fix; s for which the state before the next one is kept
_WIDEST = 25.0  # factor on the covariance; what is missing then is added to the position alone
_TURN_TIME = 1.0  # s: over less time, two headings give noise and no yaw rate
_EXTRAPOLATE = 1.0  # s beyond a report for which its yaw rate is believed
_SURFACE = 0.7  # m of depth: above it wind and waves move the vehicle
_UNDER_WAY = 0.3  # m/s: slower, the speed's deviation fades with the speed
_DRIVES = 0.05  # m/s: a lower speed is residual
_STEADY_SPEED, _STEADY_TURN = 0.1, 0.05  # steady course: m/s since the report before; rad/s
_STEEP = 1.0  # rad of pitch: steeper, a depth rate tells nothing of the speed ahead
_PENDING = 4  # velocities that wait for a report
_WAITING = 16  # the same, of added sensors
_SKID = 0.3  # share of the slip that differs from turn to turn, after one rad
_LOST_TIME, _LOST_GROWTH, _LOST_MOST = 20.0, 0.05, 1.8  # without a compass: s; rad/s; rad

_KEPT = (  # besides the filter and the speed
    *("t", "located", "last_fix", "nis", "fix_nis", "depth_seen", "altitude_seen", "_motion"),
    *("_driven_at", "_rejected", "_assumed", "_pending", "_used", "_before", "_added", "_waiting"),
    "_sea",
)
_kept = operator.attrgetter(*_KEPT)


class Reckoner:
    """Items must come in the order of their times; ``t`` is the time that it has reached."""

    def __init__(self, vehicle: Vehicle, figures: Figures) -> None:
        self.filter = Filter(figures)
        self.figures = figures
        self.t: float | None = None
        self.located = self._assumed = False
        self.last_fix: float | None = None
        self.nis: tuple[float, int] | None = None
        self.fix_nis: float | None = None  # of the last fix that was used
        self.depth_seen = self.altitude_seen = False
        self._propulsion = propulsion(vehicle)
        self._calibration, self._stale_after = vehicle.calibration, vehicle.stale_after
        self._driven_at = -math.inf  # of the last report with speed by thrust
        self._motion = Reported(-math.inf)
        self._rejected: tuple[GroundFix, ...] = ()
        self._pending: tuple[GroundFix, ...] = ()  # velocities wait for the next report
        self._used: GroundFix | None = None
        self._before: tuple[float, Any, bool] | None = None  # when, the filter, whether assumed
        self._added: Mapping[str, Seen] = {}  # replaced, never written to
        self._waiting: tuple[Aiding, ...] = ()
        self._sea = Seaway()

    def save(self) -> tuple[Any, ...]:
        return self.filter.save(), self._propulsion.speed, _kept(self)

    def load(self, saved: tuple[Any, ...]) -> None:
        arrays, self._propulsion.speed, kept = saved
        self.filter.load(arrays)
        for name, value in zip(_KEPT, kept, strict=True):
            setattr(self, name, value)

    def take(self, item: Item) -> None:
        if isinstance(item, Report):
            self._report(item)
        elif isinstance(item, Aiding):
            self._aid(item)
        else:
            self._fix(item)

    # --- reports -----------------------------------------------------------------------------

    def _report(self, r: Report) -> None:
        last = self._motion
        since, before = r.t - last.t, self._propulsion.speed
        pitch = r.pitch or 0.0
        sinking = float(self.filter.x[RATE])
        expected = self._propulsion.advance(r.actuators, since, pitch, sinking)
        heading, heading_t, rate, turns_from = self._turn(r)
        kept = 1.0 / (1.0 + self._calibration.turn_loss * abs(rate))
        surfaced = last.surfaced if r.depth is None else r.depth < _SURFACE
        along = math.cos(pitch) * kept
        heave = (sinking + expected * math.sin(pitch)) * math.tan(min(max(pitch, -_STEEP), _STEEP))
        sway, skidding = self._skid(rate, since)
        gap = 0.0 if last.heading is None else heading_t - last.heading_t
        self._motion = Reported(
            *(r.t, heading, heading_t, rate, along, expected, surfaced),
            *(sway, skidding, heave, gap, turns_from, since),
        )
        self._driven_at = r.t if abs(expected) > _DRIVES else self._driven_at
        self._advance(r.t)
        self._velocities(before)
        nis = self.filter.vertical(r.depth, r.altitude)
        self.depth_seen = self.depth_seen or r.depth is not None
        self.altitude_seen = self.altitude_seen or r.altitude is not None
        self.nis = nis or self.nis

    def _turn(self, r: Report) -> tuple[float | None, float, float, tuple[float, float] | None]:
        """Return the heading, its time, the yaw rate, and the report from which the next yaw rate
        counts: the one before, or an older one if that is less than a second ago."""
        last = self._motion
        if r.heading is None:
            return last.heading, last.heading_t, 0.0, last.turns_from
        here, since, begun = (r.t, r.heading), r.t - last.heading_t, last.turns_from
        longest = 3.0 * max(self.figures.period, _TURN_TIME)
        if last.heading is None or begun is None or since >= longest:
            return r.heading, r.t, 0.0, here
        if since >= _TURN_TIME:
            begun = last.heading_t, last.heading
        if r.t - begun[0] < _TURN_TIME:
            return r.heading, r.t, last.yaw_rate, begun
        rate = math.remainder(r.heading - begun[1], 2.0 * math.pi) / (r.t - begun[0])
        return r.heading, r.t, rate, here

    def _skid(self, rate: float, since: float) -> tuple[float, float]:
        """Return the slip outward in a turn and some s after it: its mean, and its last value."""
        known, began = self._calibration, self._motion.skidding
        end = -known.turn_slip * rate
        lag = since / max(known.turn_slip_time, 1e-3)
        if not 0.0 < lag < 20.0:
            return end, end
        kept = math.exp(-lag)
        return end + (began - end) * (1.0 - kept) / lag, end + (began - end) * kept

    def _advance(self, t: float) -> None:
        """Predict to ``t`` along the straight line of headings through the last two reports."""
        if self.t is None:
            self.t = t
            return
        dt = t - self.t
        if dt <= 0.0:
            return
        self.filter.predict(dt, self.run(self.t, t))
        self.t = t

    def run(self, t0: float, t1: float) -> Motion:
        """Return how the vehicle moves between two times."""
        m = self._motion
        driven = min(abs(m.expected) / _UNDER_WAY, 1.0)
        late = self._late(t1)
        if m.heading is None:  # any direction is possible; the mean motion is 0
            skid = 2.0 * _LOST_MOST**2 * _LOST_TIME
            return Motion(
                *(0.0, m.expected, 0.0, 0.0, 0.0, driven, 0.0, m.surfaced, skid, 0.0, late),
                self._untold(t1),
            )
        turned = m.yaw_rate * min(0.5 * (t0 + t1) - m.heading_t, _EXTRAPOLATE)
        arc = m.yaw_rate * (t1 - t0)
        along = m.along * (1.0 - min(arc * arc, 4.0) / 24.0)  # the chord of the arc
        slip = self._calibration.turn_slip
        skid = (_SKID * slip) ** 2 * abs(m.yaw_rate)
        lost, heading = self._lost(t1), m.heading + turned
        if lost > 0.0:  # the less is known of the heading, the more error along it, too
            gone = 1.0 - math.exp(-lost / _LOST_TIME)
            skid += 2.0 * lost * gone * gone
        return Motion(
            *(heading, m.expected, along, m.sway, lost, driven, arc, m.surfaced, skid, m.heave),
            *(late, self._untold(t1)),
        )

    def _untold(self, t: float) -> float:
        """Variance (m^2/s) of unreported motion. When reports end, the stick may drive the vehicle
        (as built, the AUV reports nothing then), and that motion is no current."""
        quiet = t - self._motion.t if t > self._motion.t else self._motion.told_after
        if not self._stale_after < quiet < math.inf:
            return 0.0
        return 2.0 * _LOST_TIME * self._propulsion.fastest**2

    def _late(self, t: float) -> bool:
        return self.last_fix is None or t - self.last_fix > self.filter.figures.fresh_for

    def _lost(self, t: float) -> float:
        """Extra heading variance times its correlation time, rad^2 s: loss^2 * _LOST_TIME, loss by
        ``heading_loss``. Before the last heading, loss is that half-way between the last two."""
        m = self._motion
        loss = self.heading_loss(t if t > m.heading_t else m.heading_t + 0.5 * m.gap)
        return loss * loss * _LOST_TIME

    def heading_loss(self, t: float) -> float:
        """Extra sigma of the heading, rad, if the compass has not been believed for a while."""
        over = t - self._motion.heading_t - 2.0 * self.figures.period
        return min(max(over, 0.0) * _LOST_GROWTH, _LOST_MOST)

    @property
    def heading(self) -> float | None:
        """The last believed heading: compass + declination, rad."""
        return self._motion.heading

    @property
    def expected(self) -> float:
        return self._propulsion.speed

    @property
    def driven(self) -> float:
        return min(abs(self._propulsion.speed) / _UNDER_WAY, 1.0)

    def decline(self, change: float) -> None:
        """Turn the last heading by a change of the declination, so that this counts as no turn."""
        heading, begun = self._motion.heading, self._motion.turns_from
        if heading is not None and begun is not None:
            turns_from = begun[0], begun[1] + change
            self._motion = self._motion._replace(heading=heading + change, turns_from=turns_from)

    # --- fixes -------------------------------------------------------------------------------

    def place(
        self, t: float, north: float, east: float, variance: float, assumed: bool = False
    ) -> None:
        """Set the position at ``t``. ``assumed``: it is not measured, so its difference to the
        first fix is no current."""
        self._advance(max(t, self.t if self.t is not None else t))
        self.filter.place(north, east, variance)
        self.located, self._assumed = True, assumed
        self._rejected = ()
        self.settle()

    def settle(self) -> None:
        """Forget the state that was kept to go back to: the frame or the current has changed."""
        self._before = None

    def _fix(self, f: GroundFix) -> None:
        self._advance(f.t)
        self._pending = (*self._pending, f)[-_PENDING:]
        if self._repeats(f):
            return
        if self._assumed or (self.last_fix is not None and f.t - self.last_fix >= _GAP):
            self._before = f.t, self.filter.save(), self._assumed
        if not self.located:
            self.place(f.t, f.north, f.east, f.variance)
        elif not self._admit(f):
            self._pending = self._pending[:-1]
            return
        self._used, self.last_fix, self._rejected = f, f.t, ()

    def _repeats(self, f: GroundFix) -> bool:
        """The same position from a second sentence of the same second."""
        u = self._used
        return u is not None and f.t - u.t < 0.5 and (f.north, f.east) == (u.north, u.east)

    def _admit(self, f: GroundFix) -> bool:
        """Correct the position, or keep the fix among the rejected ones."""
        if self.filter.innovation(f.north, f.east, f.variance)[2] > GATE:
            self._rejected = (*self._rejected, f)[-_AGREEING:]
            if len(self._rejected) < _AGREEING or not agree(self._rejected):
                return False
            self._open_gate(f)
        self._give_way(f)
        nis = self.filter.innovation(f.north, f.east, f.variance)[2]
        self.filter.fix(f.north, f.east, f.variance)
        self.nis, self.fix_nis = (nis, 2), nis
        return True

    def _goes_back(self, f: GroundFix) -> bool:
        """Restore the state that was kept and return True, if ``f`` fits it after the motion that
        is possible since."""
        if self._before is None or f.t - self._before[0] > _MEMORY:
            return False
        (began, before, assumed), now = self._before, self.filter.save()
        self.filter.load(before)
        if f.t > began:
            run = self.run(began, f.t)
            self.filter.predict(f.t - began, run)
            self.filter.loosen((run.expected * (f.t - began)) ** 2)  # in any direction
        self.filter.load_vertical(now)  # a fix tells nothing of the depth
        if self.filter.innovation(f.north, f.east, f.variance)[2] <= GATE:
            self._before, self._assumed = None, assumed
            return True
        self.filter.load(now)
        return False

    @property
    def _still(self) -> bool:
        """Nothing has driven since the last fix that was used."""
        return self.last_fix is not None and self._driven_at < self.last_fix

    def _open_gate(self, f: GroundFix) -> None:
        if self._assumed or self._goes_back(f):
            self._give_way(f)
            return
        self._before = f.t, self.filter.save(), False
        there = f.north, f.east, f.variance
        if not self._widens_to(lambda: self.filter.innovation(*there)[2] < 3.0):
            self._loosen_to(f)

    def _give_way(self, f: GroundFix) -> None:
        """Let the first fix move an assumed position: the difference is no current."""
        if self._assumed:
            self._loosen_to(f)
        self._assumed = False

    def _loosen_to(self, f: GroundFix) -> None:
        dn, de, _ = self.filter.innovation(f.north, f.east, f.variance)
        self.filter.loosen(dn * dn + de * de)

    def _widens_to(self, fits: Callable[[], bool]) -> bool:
        factor = 1.0
        while factor < _WIDEST:
            self.filter.widen(1.5, still=self._still)
            factor *= 1.5
            if fits():
                return True
        return False

    # --- sensors that were added -------------------------------------------------------------

    def _aid(self, a: Aiding) -> None:
        """A place and a range are used at once, a speed with the next report."""
        self._advance(a.t)
        if a.kind == RANGE and not self.located:
            return
        if a.kind not in (PLACE, RANGE):
            self._waiting = (*self._waiting, a)[-_WAITING:]
        else:
            self._use(a)

    def _use(self, a: Aiding, *, steady: bool = True) -> None:
        """Use a value. Off a ``steady`` course it is only noted, in case the sensor freezes in the
        turn, and teaches nothing."""
        run = self.run(a.t, a.t)
        seen = self._added.get(a.key, Seen()).heard(a, run, steady=steady)
        if steady and not seen.frozen(a.kind, run):
            seen = seen.noted(a.t, tuple(innovation(self.filter, a, run).y.tolist()))
            if seen.confirmed(a):
                seen = seen._replace(refused=self._corrected(a, run, seen))
        self._added = {**self._added, a.key: seen}

    def _corrected(self, a: Aiding, run: Motion, seen: Seen) -> int:
        """Correct by a value if the gate allows; return how many in a row are now beyond it."""
        if a.kind == PLACE:
            north, east = a.values
            if self.filter.innovation(north, east, a.sigma**2)[2] <= GATE:
                self._give_way(_as_fix(a))
        if correct(self.filter, a, run):
            self.located = self.located or a.kind == PLACE
            return 0
        if not seen._replace(refused=seen.refused + 1).insists(a):
            return seen.refused + 1
        if a.kind == PLACE:
            self._open_gate(_as_fix(a))
        elif a.kind == RANGE:
            self._open_to(a, run)
        else:
            self.filter.doubt_current(self.figures.current.sigma)
        return 0 if correct(self.filter, a, run) else seen.refused + 1

    def _open_to(self, a: Aiding, run: Motion) -> None:
        """Open the gate as for fixes; there is no earlier state to go back to."""
        if not self._widens_to(lambda: fits(self.filter, a, run)):
            self.filter.loosen(float(innovation(self.filter, a, run).y[0]) ** 2)

    def _speeds(self, steady: bool) -> None:
        waiting, self._waiting = self._waiting, ()
        steady = steady and self._motion.heading is not None
        for a in waiting:
            self._use(a, steady=steady and self.run(a.t, a.t).lost == 0.0)

    def _velocities(self, before: float) -> None:
        """Use the receivers' speeds and courses since the report before, unless the vehicle has
        gathered way or turned since: then their times are not known well enough."""
        pending, self._pending = self._pending, ()
        steady = abs(self._propulsion.speed - before) < _STEADY_SPEED
        steady = steady and abs(self._motion.yaw_rate) <= _STEADY_TURN
        self._speeds(steady)
        if not steady:
            return
        for f in pending:
            run = self.run(f.t, f.t)
            if self._motion.heading is not None and run.lost == 0.0:
                self._sea = self._sea.used(self.filter, f, run)


def _as_fix(place: Aiding) -> GroundFix:
    return GroundFix(place.t, place.values[0], place.values[1], place.sigma**2, None)
