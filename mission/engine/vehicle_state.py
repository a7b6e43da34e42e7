"""The vehicle at an instant: its last reports and fixes, and which of their values are believed.

Until navigation is loaded (numpy and filterpy take a while) a fresh finite value is believed, a
depth only down to the vehicle's own limit: a sensor at full scale starts no thruster on deck.

What does not live here: the filter and the health rules (navigation), what follows from them
(engine, limits).
"""

from __future__ import annotations

import math
from typing import Self

from mission.engine.attitude import Attitude
from mission.engine.navigator import Navigator
from mission.engine.standing import Standing
from mission.engine.thrust import dives, downward, with_thrust
from mission.engine.travel import Travel
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
from mission.navigation.fixes import FIX_DEPTH, HOME_OF, Receiver, home_of
from protocol.messages import Aid, Fix, Order, Setpoint, Telemetry

SURFACE_DEPTH = 0.5  # m (R7)
IN_AIR = -FIX_DEPTH  # m: the zero of a usable sensor is not off by as much (R5)
SURFACE_TIME = 6.0  # s (R7) ...
_STILL_RISES = 0.25  # m less deep than when these began: it is not at the surface yet
_ALL = 0.75  # share of full thrust: asks for as deep, or as high, as the vehicle goes
_POSITION_PERIOD = 1.0  # s: positions within it share one error
_ESTIMATE_AGE = 2.5  # s: an older estimate is predicted to now
FIX_AGE = 5.0  # s: an older fix does not count (R9)
WRONG_FOR = 20.0  # s for which a wrong depth may have been believed (R5)
_NEAR = 1.0  # m: a depth from here to the surface's 0.5 m is one on the way up
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
        s, the greatest age of a believed report. ``rise``: m/s, by buoyancy alone; ``sink``: m/s,
        at most; ``deepest``: m, the vehicle's own depth limit."""
        self.navigation = navigation
        self._grounded, self.stale_after = grounded, stale_after
        self._rise, self._sink, self._deepest = rise, sink, deepest
        self.now = 0.0
        self.telemetry: Telemetry | None = None
        self.fixes: tuple[Fix, ...] = ()  # the last five, not stale nor too deep, oldest first
        self.receiver = Receiver()
        self._fixed_at = -math.inf  # of the last fix that proves the surface
        self._taken_at = -math.inf  # of the last fix that navigation has accepted
        self._received_at = -math.inf  # of the last new position that is not the vehicle's own
        self.estimate: Estimate | None = None
        self.attitude = Attitude()
        self.travel = Travel()  # of a depth whose zero is wrong
        self.believed_depth: float | None = None  # the last one that could be believed
        self._believed_at = -math.inf
        self._deep_at = -math.inf  # of the last two reports too deep for a fix, believed or not
        self._deep = False  # the last report was
        self.rising_since: float | None = None  # the ascent's first command, if no leg followed it
        self.command: Setpoint | None = None  # in force at the vehicle
        self.word: Setpoint | Order | None = None  # the last one sent; None under the stick
        self._position_at = -math.inf  # of the vehicle's own positions, the last one used
        self._shallow_since: float | None = -math.inf if grounded else None
        self._shallow_from: float | None = None  # the first such depth, until a different one comes
        self._shallow_at = 0.0  # m, when that began
        self._told: tuple[float | None, float] = None, -math.inf  # the last believed depth; s
        self._standing = Standing(stale_after)
        self._moved_at = self._expected = -math.inf  # when it changed; from when on it has to
        self._offset: float | None = None  # compass minus true heading
        self._healths: dict[str, Health] = {}  # looked up at this instant
        self._depth: float | None = None
        self._depth_known = False

    def clone(self) -> Self:
        """A copy that shares the navigation, which has a snapshot of its own."""
        return copied(self, navigation=self.navigation, _healths={}, _depth_known=False)

    def _forget(self) -> None:
        """Drop the values that were worked out for an earlier instant."""
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
            aside = self.attitude.pushes_sideways  # upside down it leads the other way
            push = Vertical(None, None) if aside else Vertical(downward(report), self._asked())
            self.navigation.telemetry(driven, push)
            self.estimate = self.navigation.estimate(report.t)
        self._forget()
        if report.position is not None:
            self._take_position(report, report.position)
        depth = self.depth
        self.travel = self.travel.after(report.t, self.moving_depth if depth is None else None)
        if self.health("depth").reason == "frozen":  # until two changes: one may be a glitch
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
            kept = lives and (not dives(report) or self.overturned)  # not left by a push down
            shallow = kept and depth is not None and IN_AIR < depth < SURFACE_DEPTH
            self._notice_surface(report.t, depth if shallow else None, before, silent)
        true = self.estimate.heading if self.estimate else None
        if report.heading is not None and true is not None and self.health("heading").valid:
            self._offset = wrap(report.heading - true)

    def _notice_surface(
        self, now: float, depth: float | None, before: float | None, silent: bool
    ) -> None:
        """Follow since when ``depth`` is shallow (None: it is not); ``before``: the last depth."""
        if depth is None:
            self._shallow_since = None
        elif self._shallow_since is None or silent:
            near = not silent and SURFACE_DEPTH <= (before or 0.0) < _NEAR  # it came from there
            self._shallow_since, self._shallow_from = now, None if near else depth
            self._shallow_at = depth
        elif depth == self._shallow_from:
            self._shallow_since = now  # the sensor may have died with it: it proves nothing
        else:
            self._shallow_from = None
            if depth < self._shallow_at - _STILL_RISES:
                self._shallow_since, self._shallow_at = now, depth

    def _was_silent(self, report: Telemetry) -> bool:
        """Whether the report before is too old to continue from (R7)."""
        before = self.telemetry
        return before is not None and report.t - before.t > self.stale_after

    def expect_change(self) -> None:
        """Require a change of the depth before it proves the surface: it may have frozen unseen."""
        self._expected, self._told = self.now, (None, -math.inf)

    def _has_changed(self, depth: float) -> bool:
        """Note a believed depth; return ``lives``. A change across a silence does not count."""
        before, at = self._told
        if depth != before is not None and self.now - at <= self.stale_after:
            self._moved_at = self.now
            self._expected = min(self._expected, math.nextafter(self.now, math.inf))
        self._standing = self._standing.after(self.now, at, depth != before, depth)
        self._told = depth, self.now
        return self.lives

    @property
    def lives(self) -> bool:
        """Whether the depth has changed since the program and the ascent began. If not, it may have
        frozen while nothing moved; a few seconds of thrust do not show that yet."""
        begun, moved = self.rising_since, self._moved_at
        return self._grounded or (moved >= self._expected and (begun is None or moved > begun))

    @property
    def repeats(self) -> bool:
        """Whether the depth may have frozen at rest, where no thruster is on that would show it."""
        return self._standing.tells(self.now) and not self._grounded and self.depth is not None

    def _asked(self) -> float | None:
        """The depth that the set in force asks for, m; infinite for nearly full vertical thrust."""
        s = self.command
        if s is None or s.heave is None:
            return None if s is None else s.depth
        return math.copysign(math.inf, s.heave) if abs(s.heave) >= _ALL else None

    def _take_position(self, report: Telemetry, place: tuple[float, float]) -> None:
        """Take the vehicle's own position, once a second. It comes under water too, so it proves no
        surface. Once the depth has proved the surface (R7), it counts as a fix."""
        if report.t - self._position_at < _POSITION_PERIOD:
            return
        self._position_at = report.t
        own = Fix(report.t, *place, accuracy=math.inf)
        shallow = self._shallow_since
        received = report.t - self._received_at <= FIX_AGE  # the receiver's counts then (R9)
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
        """An aid helps the estimate. It is no fix: it proves no surface and starts no mission."""
        if self.navigation:
            self.navigation.aid(aid)
            self.estimate = self.navigation.estimate(aid.t)

    def _proves_surface(self, fix: Fix) -> bool:
        """R7: a new position proves it, unless a believed depth contradicts it. If no depth is
        believed, or it has not changed yet, some seconds of fixes as at the surface prove it while
        no depth, its zero right or wrong, goes up or down."""
        depth = self.depth
        if depth is not None and (depth >= FIX_DEPTH or self.lives):
            return self.receiver.fresh and depth < FIX_DEPTH
        stands = self.travel.stands(fix.t)
        return stands and self.receiver.at_surface(fix.t) and self._may_be_up(fix.t)

    def _may_be_up(self, now: float) -> bool:
        """Whether the ascent has lasted as long as the rise by buoyancy from its deepest start."""
        begun = self.rising_since
        if begun is None or self._rise <= 0.0:
            return begun is not None
        return now - max(begun, self._believed_at) >= self._deepest_at(begun) / self._rise

    def _deepest_at(self, begun: float) -> float:
        """The deepest that the vehicle can have been at ``begun``, m. It may have sunk since the
        last believed depth was true, or since that changed, but not beyond its own limit. If no
        depth was believed yet: its own limit."""
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
        """The reported depth, m; None while it is not believed."""
        if self._grounded:
            return 0.0
        if not self._depth_known:
            self._depth_known, report = True, self.telemetry
            seen = None if report is None else report.depth
            self._depth = seen if seen is not None and self.health("depth").valid else None
        return self._depth

    @property
    def moving_depth(self) -> float | None:
        """The depth, m, if its changes are believed: also one whose zero alone is contradicted."""
        if self.depth is not None or self.telemetry is None or not self.health("depth").moves:
            return self.depth
        return self.telemetry.depth

    @property
    def overturned(self) -> bool:
        """Whether the vehicle is upside down, by three reports that agree."""
        return self.attitude.overturned

    @property
    def seen_rising(self) -> tuple[float, float | None, bool, bool]:
        """For an ascent: now, s; ``moving_depth``; whether upside down; whether it may be."""
        told, depth, attitude = self.telemetry, self.moving_depth, self.attitude
        silent = told is None or self.now - told.t > self.stale_after
        over, untold = self.overturned, silent or (attitude.frozen and depth is None)
        doubtful = attitude.doubtful(self.now) or (over and silent)
        return self.now, depth, over and not untold, doubtful

    @property
    def submerged(self) -> bool:
        """Whether the vehicle is under water as far as is known: by the last believed depth, if no
        fix since has proved the surface."""
        if self.believed_depth is None or self.believed_depth < SURFACE_DEPTH:
            return False
        return self._fixed_at <= self._believed_at

    @property
    def contradicted(self) -> str:
        """Why other evidence contradicts the depth; "" if none does."""
        reason = "" if self._grounded else self.health("depth").reason
        return reason if reason.startswith(CONTRADICTED) else ""

    def believable(self, need: str) -> bool:
        """Whether a sensor is believed, or ``position`` estimated, by fixes or dead reckoning."""
        if need == "position":
            return self.estimate is not None and self.estimate.located
        return self.health(need).valid

    def surfaced(self, since: float) -> bool:
        """Whether the surface is proved after ``since``: by 6 s of shallow depth, or a fix (R7)."""
        due = self.surface_due(since)
        shallow = due is not None and self.now >= due and self.depth is not None
        return self.fixed(since) or (shallow and self._told_again())

    def _told_again(self) -> bool:
        """Whether a shallow depth came that differs from the first one."""
        return self._shallow_from is None

    def fixed(self, since: float) -> bool:
        """Whether a fix after ``since`` has proved the surface."""
        return self._fixed_at > since

    def located(self, since: float) -> bool:
        """Whether navigation has accepted a fix after ``since``."""
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
        """A true heading, rad, as this vehicle's compass shows it; None: not known."""
        return None if self._offset is None else (heading + self._offset) % (2.0 * math.pi)

    def home_from_fixes(self) -> Position | None:
        """Home by the last fixes that count for it (R9); None if they do not agree."""
        return home_of(self.fixes)
