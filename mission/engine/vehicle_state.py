"""What the engine knows of the vehicle at an instant: the last reports, and what to believe.

Before navigation is loaded (numpy and filterpy take a while) a finite value is believed while it is
fresh, a depth up to the vehicle's own: a sensor at full scale turns no thruster on deck.

What does not live here: the filter and the health rules (navigation), what follows from them
(engine, limits).
"""

from __future__ import annotations

import math
from typing import Self

from mission.engine.attitude import Attitude
from mission.engine.navigator import Navigator
from mission.engine.standing import Standing
from mission.engine.thrust import downward, with_thrust
from mission.legs.base import Point, wrap
from mission.model import (
    CONTRADICTED,
    Estimate,
    Health,
    Local,
    Place,
    Position,
    Vertical,
)
from mission.model.copies import copied
from mission.model.vehicle import STALE_AFTER
from mission.navigation.belief import EVERY, GAP
from mission.navigation.fixes import FIX_DEPTH, HOME_OF, Receiver, home_of
from protocol.messages import Aid, Fix, Order, Setpoint, Telemetry

SURFACE_DEPTH = 0.5  # m (R7)
IN_AIR = -FIX_DEPTH  # m: no zero of a sensor to go by is off by as much (R5)
SURFACE_TIME = 6.0  # s (R7) ...
_STILL_RISES = 0.25  # m less deep than as these began: it is not at the surface yet
_PUSHED_DOWN = 0.5  # share of full thrust, as reported: nothing stays at the surface
_ALL = 0.75  # share of full thrust: as deep, or as high, as it goes
_POSITION_PERIOD = 1.0  # s: the errors of one second's positions are one error
_ESTIMATE_AGE = 2.5  # s: older, and it is reckoned on to now
FIX_AGE = 5.0  # s: an older fix is none (R9)
WRONG_FOR = 20.0  # s that a depth may have been wrong and was believed (R5)
_NEAR = 1.0  # m: a report before the surface's 0.5 m, on the way up
_TRAVELS = 1.0  # m between two means of _SWELL, by a depth whose zero is wrong: no surface
_SWELL = 15.0  # s: waves even out
_SAME = 1e-6  # s


class VehicleState:
    def __init__(
        self,
        navigation: Navigator | None = None,
        *,
        grounded: bool = False,
        stale_after: float = STALE_AFTER,
        rise: float = math.inf,
        sink: float = 0.0,
        deepest: float = math.inf,
    ) -> None:
        """``grounded``: the vehicle drives on the ground, where the depth is 0. ``stale_after``:
        s, the age at which a report is believed no more. ``rise``: m/s by buoyancy alone;
        ``sink``: m/s at most; ``deepest``: m, its own depth."""
        self.navigation = navigation
        self._grounded, self.stale_after = grounded, stale_after
        self._rise, self._sink, self._deepest = rise, sink, deepest
        self.now = 0.0
        self.telemetry: Telemetry | None = None
        self.fixes: tuple[Fix, ...] = ()  # the last five, not stale nor too deep, oldest first
        self.receiver = Receiver()
        self._fixed_at = -math.inf  # of the last one that proves the surface
        self._taken_at = -math.inf  # of the last one that navigation has taken
        self._received_at = -math.inf  # of the last news that is not the vehicle's own
        self.estimate: Estimate | None = None
        self.attitude = Attitude()
        self._swell: tuple[tuple[float, float], ...] = ()  # s, m: of a depth whose zero is wrong
        self.believed_depth: float | None = None  # the last one that could be believed
        self._believed_at = -math.inf
        self._deep_at = -math.inf  # of the last two reports, believed or not, where a fix is none
        self._deep = False  # the last one
        self.rising_since: float | None = None  # the ascent's first word, and no other leg since
        self.command: Setpoint | None = None  # in force at the vehicle
        self.word: Setpoint | Order | None = None  # that was said last; None under the stick
        self._position_at = -math.inf  # of the vehicle's own positions, the last one used
        self._shallow_since: float | None = -math.inf if grounded else None
        self._shallow_from: float | None = None  # the first such depth, until there is another
        self._shallow_at = 0.0  # m, as that began
        self._told: tuple[float | None, float] = None, -math.inf  # the last depth to believe; s
        self._standing = Standing(stale_after)
        self._moved_at = self._expected = -math.inf  # it changed; from then on it has to
        self._offset: float | None = None  # compass minus true heading
        self._healths: dict[str, Health] = {}  # asked for at this instant
        self._depth: float | None = None
        self._depth_known = False

    def clone(self) -> Self:
        """Without the navigation, which has a snapshot of its own."""
        return copied(self, navigation=self.navigation, _healths={}, _depth_known=False)

    def _forget(self) -> None:
        """What was worked out for an instant that has passed."""
        self._healths, self._depth_known = {}, False

    # --- in ----------------------------------------------------------------------------------

    def at(self, now: float) -> None:
        self.now = now
        self._forget()
        old = self.estimate
        if self.navigation and old is not None and now - old.t > _ESTIMATE_AGE:
            self.estimate = self.navigation.estimate(now)

    def take_telemetry(self, report: Telemetry) -> None:
        silent = self._was_silent(report)
        self.telemetry = report
        self.attitude = self.attitude.after(driven := with_thrust(report, self.word))
        if self.navigation:
            over = self.overturned  # then the same push leads the other way
            push = Vertical(None, None) if over else Vertical(downward(report), self._asked())
            self.navigation.telemetry(driven, push)
            self.estimate = self.navigation.estimate(report.t)
        self._forget()
        if report.position is not None:
            self._take_position(report, report.position)
        depth = self.depth
        self._notice_travel(report.t, self.moving_depth if depth is None else None)
        if self.health("depth").reason == "frozen":  # it thaws by two changes: one is a glitch
            self._expected, self._told = math.inf, (None, -math.inf)
        before = self._told[0] if self.lives else None
        lives = depth is not None and self._has_changed(depth)
        deep = report.depth is not None and report.depth >= FIX_DEPTH
        if deep and self._deep:  # a single one may be garbage on deck
            self._deep_at = report.t
        self._deep = deep
        if lives:
            self.believed_depth, self._believed_at = depth, report.t
        if not self._grounded:
            dives = (downward(report) or 0.0) >= _PUSHED_DOWN and not self.overturned
            shallow = lives and not dives and depth is not None and IN_AIR < depth < SURFACE_DEPTH
            self._notice_surface(report.t, depth if shallow else None, before, silent)
        true = self.estimate.heading if self.estimate else None
        if report.heading is not None and true is not None and self.health("heading").valid:
            self._offset = wrap(report.heading - true)

    def _notice_surface(
        self, now: float, depth: float | None, before: float | None, silent: bool
    ) -> None:
        """``depth`` as at the surface, else None; the one ``before``, if it was believed."""
        if depth is None:
            self._shallow_since = None
        elif self._shallow_since is None or silent:
            near = not silent and SURFACE_DEPTH <= (before or 0.0) < _NEAR  # it came from there
            self._shallow_since, self._shallow_from = now, None if near else depth
            self._shallow_at = depth
        elif depth == self._shallow_from:
            self._shallow_since = now  # what it may have died with proves nothing
        else:
            self._shallow_from = None
            if depth < self._shallow_at - _STILL_RISES:
                self._shallow_since, self._shallow_at = now, depth

    def _was_silent(self, report: Telemetry) -> bool:
        """What it said before is too long ago to go on from (R7)."""
        before = self.telemetry
        return before is not None and report.t - before.t > self.stale_after

    def expect_change(self) -> None:
        """Of a depth that nobody saw before: one that stands still proves no surface."""
        self._expected, self._told = self.now, (None, -math.inf)

    def _has_changed(self, depth: float) -> bool:
        """Notes a depth to believe; whether it lives. Another one behind a silence may not."""
        before, at = self._told
        if depth != before is not None and self.now - at <= self.stale_after:
            self._moved_at = self.now
            self._expected = min(self._expected, math.nextafter(self.now, math.inf))
        self._standing = self._standing.after(self.now, at, depth != before, depth)
        self._told = depth, self.now
        return self.lives

    @property
    def lives(self) -> bool:
        """The depth has changed since the program and the ascent began. One that stands may have
        frozen while nothing moved: some seconds of thrust do not tell yet."""
        begun, moved = self.rising_since, self._moved_at
        return self._grounded or (moved >= self._expected and (begun is None or moved > begun))

    @property
    def repeats(self) -> bool:
        """The depth may have frozen at rest, where nothing turns that would tell."""
        return self._standing.tells(self.now) and not self._grounded and self.depth is not None

    def _asked(self) -> float | None:
        """The depth that the set in force asks for, m."""
        s = self.command
        if s is None or s.heave is None:
            return None if s is None else s.depth
        return math.copysign(math.inf, s.heave) if abs(s.heave) >= _ALL else None

    def _take_position(self, report: Telemetry, place: tuple[float, float]) -> None:
        """The vehicle's own, once a second: under water too, so it proves no surface. Where the
        depth has proved that (R7), it counts as a fix."""
        if report.t - self._position_at < _POSITION_PERIOD:
            return
        self._position_at = report.t
        own = Fix(report.t, *place, accuracy=math.inf)
        shallow = self._shallow_since
        received = report.t - self._received_at <= FIX_AGE  # then that is where it is (R9)
        if shallow is not None and report.t >= shallow + SURFACE_TIME and not received:
            self.take_fix(own)
        elif self.navigation:
            self.navigation.fix(own)
            self.estimate = self.navigation.estimate(report.t)

    def take_fix(self, fix: Fix) -> None:
        self.receiver.take(fix)
        own = fix.accuracy == math.inf
        if self.receiver.fresh and not own:
            self._received_at = fix.t
        if self._proves_surface(fix):
            self._fixed_at = fix.t
        of_before = self.receiver.stale or not (own or self._received_at >= self._deep_at)
        if not of_before and (self.depth is None or self.depth < FIX_DEPTH):
            told = self.navigation.less_off(fix) if own and self.navigation else fix
            self.fixes = (*self.fixes[1 - HOME_OF :], told)
        if self.navigation:
            self.navigation.fix(fix)
            found = self.estimate = self.navigation.estimate(fix.t)
            if found and found.fix_age is not None and abs(found.t - found.fix_age - fix.t) < _SAME:
                self._taken_at = fix.t

    def take_aid(self, aid: Aid) -> None:
        """It helps the estimate, and is no fix: it proves no surface, and starts no mission."""
        if self.navigation:
            self.navigation.aid(aid)
            self.estimate = self.navigation.estimate(aid.t)

    def _proves_surface(self, fix: Fix) -> bool:
        """R7: a place that is news, unless a depth that is believed says otherwise. Where none is
        believed, or it has not changed yet, some seconds of fixes as at the surface while no depth
        goes up or down, its zero right or wrong."""
        depth = self.depth
        if depth is not None and (depth >= FIX_DEPTH or self.lives):
            return self.receiver.fresh and depth < FIX_DEPTH
        stands = self._stands(fix.t)
        return stands and self.receiver.at_surface(fix.t) and self._may_be_up(fix.t)

    def _notice_travel(self, now: float, depth: float | None) -> None:
        if depth is None:
            self._swell = ()
        elif not self._swell or now - self._swell[-1][0] >= EVERY:
            kept = (sample for sample in self._swell if sample[0] >= now - 2.0 * _SWELL)
            self._swell = (*kept, (now, depth))

    def _stands(self, now: float) -> bool:
        """Nothing goes up or down, slowly or in waves, by a depth whose zero is wrong, if reports
        tell one."""
        if not self._swell or now - self._swell[-1][0] > _SWELL:
            return True
        if self._swell[0][0] > now - 2.0 * _SWELL + GAP:
            return False
        older = [depth for t, depth in self._swell if t < now - _SWELL]
        newer = [depth for t, depth in self._swell if t >= now - _SWELL]
        return abs(sum(newer) / len(newer) - sum(older) / len(older)) < _TRAVELS

    def _may_be_up(self, now: float) -> bool:
        """An ascent has had the time that buoyancy takes from the deepest it can have begun at."""
        begun = self.rising_since
        if begun is None or self._rise <= 0.0:
            return begun is not None
        return now - max(begun, self._believed_at) >= self._deepest_at(begun) / self._rise

    def _deepest_at(self, begun: float) -> float:
        """m: it may have sunk, but never beyond its own depth, since what was last believed was
        true, or since that changed; where nothing was believed yet, its own depth."""
        depth = self.believed_depth
        if depth is None:
            return self._deepest
        unseen = WRONG_FOR + max(begun - min(self._believed_at, self._moved_at), 0.0)
        return min(max(depth, depth + self._sink * unseen), self._deepest)

    # --- out ---------------------------------------------------------------------------------

    @property
    def fix(self) -> Fix | None:
        return self.fixes[-1] if self.fixes else None

    def health(self, sensor: str) -> Health:
        known = self._healths.get(sensor)
        if known is None:
            known = self._healths[sensor] = self._ask(sensor)
        return known

    def _ask(self, sensor: str) -> Health:
        if self.navigation:
            return self.navigation.health(sensor, self.now)
        report, most = self.telemetry, self._deepest if sensor == "depth" else math.inf
        value = getattr(report, sensor, None)
        if report is None or not isinstance(value, float):
            return Health(False, "missing", math.inf)
        age = self.now - report.t
        why = "" if math.isfinite(value) and value <= most else "absurd"
        why = "stale" if age > self.stale_after else why
        return Health(not why, why, age)

    @property
    def depth(self) -> float | None:
        """As reported; None while it is not to be believed."""
        if self._grounded:
            return 0.0
        if not self._depth_known:
            self._depth_known, report = True, self.telemetry
            seen = None if report is None else report.depth
            self._depth = seen if seen is not None and self.health("depth").valid else None
        return self._depth

    @property
    def moving_depth(self) -> float | None:
        """What its change can be taken from: the depth, or one whose zero alone is contradicted."""
        if self.depth is not None or self.telemetry is None or not self.health("depth").moves:
            return self.depth
        return self.telemetry.depth

    @property
    def overturned(self) -> bool:
        """Upside down, by three reports that agree."""
        return self.attitude.overturned

    @property
    def seen_rising(self) -> tuple[float, float | None, bool, bool]:
        """For an ascent: s; the depth for its change; whether it is upside down; may be, unseen."""
        told, depth, attitude = self.telemetry, self.moving_depth, self.attitude
        silent = told is None or self.now - told.t > self.stale_after
        over, untold = self.overturned, silent or (attitude.frozen and depth is None)
        doubtful = attitude.doubtful(self.now) or (over and silent)
        return self.now, depth, over and not untold, doubtful

    @property
    def submerged(self) -> bool:
        """As far as is known: the last depth that could be believed, and no fix since that proves
        the surface."""
        if self.believed_depth is None or self.believed_depth < SURFACE_DEPTH:
            return False
        return self._fixed_at <= self._believed_at

    @property
    def contradicted(self) -> str:
        """Why the depth is not believed, where what else is known contradicts it; else ""."""
        reason = "" if self._grounded else self.health("depth").reason
        return reason if reason.startswith(CONTRADICTED) else ""

    def believable(self, need: str) -> bool:
        """A sensor, or ``position``: estimated from anything at all, fixes or dead reckoning."""
        if need == "position":
            return self.estimate is not None and self.estimate.located
        return self.health(need).valid

    def surfaced(self, since: float) -> bool:
        """R7: 6 s of shallow depth, or a fix that proves it; either observed after ``since``."""
        due = self.surface_due(since)
        shallow = due is not None and self.now >= due and self.depth is not None
        return self.fixed(since) or (shallow and self._told_again())

    def _told_again(self) -> bool:
        """The shallow depth, by another report, which differs."""
        return self._shallow_from is None

    def fixed(self, since: float) -> bool:
        """By a fix that proves the surface."""
        return self._fixed_at > since

    def located(self, since: float) -> bool:
        """By a fix that navigation has taken for true."""
        return self._taken_at > since

    def surface_due(self, since: float) -> float | None:
        if self._shallow_since is None or not self.lives:
            return None
        return max(self._shallow_since, since) + SURFACE_TIME

    def place(self, place: Place) -> Point | None:
        """Metres from home; None where the position of home is not known."""
        if isinstance(place, Local):
            return place.north, place.east
        if isinstance(place, str):
            return 0.0, 0.0
        frame = self.navigation.frame if self.navigation else None
        if frame is None:
            return None
        return frame.to_local(math.radians(place.latitude_deg), math.radians(place.longitude_deg))

    def compass(self, heading: float) -> float | None:
        """The heading as this vehicle's compass says it: it holds headings by its compass."""
        return None if self._offset is None else (heading + self._offset) % (2.0 * math.pi)

    def home_from_fixes(self) -> Position | None:
        """That of the last fixes that count for it (R9), None where they do not agree."""
        return home_of(self.fixes)
