"""What the limits look at: what must be remembered between reports.

    descent    a depth that grows faster than the vehicle may dive, or while no command asked for it
    steering   a heading that runs away from the one that was asked for
    progress   a depth that was asked for and does not come nearer
    course     where it goes over ground against where the bow points
    closing    the readings that the Pi itself holds an axis by: without them it says neutral

What does not live here: the rows (limits), their counters (monitor), responses (engine).
"""

from __future__ import annotations

import math
from typing import Self

from mission.engine.areas import Fence
from mission.engine.bounds import Bounds
from mission.engine.thrust import NEUTRAL, THRUSTERS, turns
from mission.engine.vehicle_state import SURFACE_DEPTH, VehicleState
from mission.legs.base import wrap
from mission.model import Outcome, Result
from mission.model.copies import copied
from mission.model.units import GEARS
from mission.model.vehicle import CLOSED, CLOSED_S, Vehicle
from mission.navigation.fixes import FIX_DEPTH, RECENT
from mission.navigation.health import doubted
from protocol.messages import Fix, Setpoint, Telemetry

_ALLOWANCE = 2.0  # m of momentum, waves and noise that are no descent
_SINKING = 0.1  # m/s: less is no descent, ...
_SLOWLY = 20.0  # s: ... but to be deeper for longer than a wave, under a set that holds no depth
_RATE_TIME = 1.0  # s: over less, the noise of two depths is no rate
_BEYOND = 0.5  # m deeper than a dive at the greatest rate: less is noise
_STALE = 10.0  # s: two depths farther apart give no rate
_TURNING_TIME = 10.0  # s of growing heading error (design: limits)
_GROWTH, _LARGE, _NOISE = (math.radians(a) for a in (20.0, 30.0, 10.0))
_ROUND = math.radians(720.0)  # no turn to a heading goes round twice
_NEW_HEADING = math.radians(15.0)
_STUCK_TIME = 120.0  # s without coming nearer: a dive at a tenth of its pace does
_NEARER, _OFF = 0.5, 2.0  # m: of that time, and what is not there yet
_APART = math.radians(60.0)
_UNDER_WAY = 0.4  # m/s through the water and over ground: a weaker one is no course
_SETTLE = 0.5  # s from an ACK to thrusters that turn
_OWN_END = 8.0  # s without a depth in which a leg that holds one is left
_BACK = 3.0  # s from thrust that is said to a report that shows it, and one more
_LOST_WITHIN = 60.0  # s: one that is not answered again and again is said every few seconds
_ROLLS_OUT, _STANDS = 2.0, 0.05  # s, m/s: of what drives, from a stop on


class Descent:
    __slots__ = ("_beyond", "_deeper_since", "_depth", "_shallowest", "_t", "unexplained", "words")

    words: str

    def __init__(self) -> None:
        self._t, self._depth, self._beyond = -math.inf, 0.0, 0.0
        self._shallowest: float | None = None
        self._deeper_since: float | None = None
        self.unexplained: bool | None = None
        self.words = ""

    def clone(self) -> Self:
        return copied(self)

    def excuse(self) -> None:
        """What it goes down until the next depth that counts is no descent, told or not."""
        self._shallowest = None

    def take(
        self, t: float, depth: float | None, asked: bool, fastest: float, driven: bool = False
    ) -> None:
        """One report; ``asked``: for a descent, ``driven``: by a set that holds no depth."""
        if depth is None:
            self.unexplained = None
            return
        since, before = t - self._t, self._depth
        if 0.0 < since < _RATE_TIME:
            self.unexplained = None
            return
        self._t, self._depth = t, depth
        seen = max(depth, before)  # one alone that is shallower may be wild
        if asked or self._shallowest is None:
            asked, self._shallowest = True, seen
        self._shallowest = min(self._shallowest, seen)
        if not 0.0 < since <= _STALE:
            self._beyond, self.unexplained, self._deeper_since = 0.0, None, None
            return
        rate, deeper = (depth - before) / since, depth - self._shallowest
        self._beyond = max(0.0, self._beyond + (rate - fastest) * since)
        below = not asked and deeper > _ALLOWANCE
        slowly = self._lasts(t, below and driven)
        sinks = below and (rate > _SINKING or slowly)
        self.unexplained = sinks or (rate > fastest and self._beyond > _BEYOND)
        if self.unexplained:
            asked_words = "" if asked else ", and nothing asked for it"
            self.words = f"sinking at {rate:.2f} m/s at {depth:.1f} m{asked_words}"

    def _lasts(self, t: float, deeper: bool) -> bool:
        """Whether it has been deeper for longer than a wave, without a break: a slow descent."""
        begun = t if self._deeper_since is None else self._deeper_since
        self._deeper_since = begun if deeper else None
        return t - begun >= _SLOWLY


class Steering:
    __slots__ = ("_from", "_off", "_peak", "_since", "_turned", "_wanted", "astray", "words")

    words: str

    def __init__(self) -> None:
        self._wanted: float | None = None
        self._since, self._from, self._peak = 0.0, 0.0, 0.0
        self._off = self._turned = 0.0  # of what is wanted, and in all since it is: right positive
        self.astray: bool | None = None
        self.words = ""

    def clone(self) -> Self:
        return copied(self)

    def take(self, t: float, heading: float | None, wanted: float | None) -> None:
        self.astray = None
        if wanted is None:
            self._wanted = None
        if wanted is None or heading is None:
            return
        off = wrap(heading - wanted)
        error = abs(off)
        fresh = self._wanted is None or abs(wrap(wanted - self._wanted)) > _NEW_HEADING
        self._turned = 0.0 if fresh else self._turned + wrap(off - self._off)
        self._off = off
        if fresh or error < self._peak - _NOISE:
            self._wanted, self._since, self._from, self._peak = wanted, t, error, error
        self._peak = max(error, self._peak)
        grown = error - self._from
        self.astray = t - self._since >= _TURNING_TIME and grown >= _GROWTH and error > _LARGE
        if self.astray:
            self.words = f"heading {math.degrees(error):.0f} deg off what was set, and growing"
        elif abs(self._turned) >= _ROUND:
            self.astray = True
            self.words = "it turns round and round, past the heading that was set"


class Progress:
    __slots__ = ("_nearest", "_since", "_wanted", "stuck", "words")

    words: str

    def __init__(self) -> None:
        self._wanted: float | None = None
        self._since, self._nearest = 0.0, 0.0
        self.stuck: bool | None = None
        self.words = ""

    def clone(self) -> Self:
        return copied(self)

    def take(self, t: float, depth: float | None, wanted: float | None) -> None:
        self.stuck = None
        if wanted is None:
            self._wanted = None
        if wanted is None or depth is None:
            return
        off = abs(depth - wanted)
        if self._goes_on(depth, wanted):
            self._nearest += off - abs(depth - (self._wanted or 0.0))
            self._wanted = wanted
        if wanted != self._wanted or off <= self._nearest - _NEARER:
            self._wanted, self._since, self._nearest = wanted, t, off
        self.stuck = off > _OFF and t - self._since >= _STUCK_TIME
        if self.stuck:
            self.words = f"for {_STUCK_TIME:g} s no nearer to {wanted:g} m, at {depth:.1f} m"

    def _goes_on(self, depth: float, wanted: float) -> bool:
        """Another depth is asked for, near the one before and the same way off (above an uneven
        bottom each few seconds): the time goes on."""
        before = self._wanted
        if before is None or before == wanted or abs(wanted - before) > _OFF:
            return False
        return min(before, wanted) > depth + _OFF or max(before, wanted) < depth - _OFF


class Closing:
    """``_since``: from when on an axis' reading has come without a gap."""

    __slots__ = ("_last", "_since")

    def __init__(self) -> None:
        self._last: dict[str, float] = {}
        self._since: dict[str, float] = {}

    def clone(self) -> Self:
        return copied(self)

    def take(self, report: Telemetry) -> None:
        doubtful = doubted(report)
        for name in CLOSED:
            if name not in doubtful and getattr(report, name) is not None:
                if report.t - self._last.get(name, -math.inf) > CLOSED_S:
                    self._since[name] = report.t
                self._last[name] = report.t

    def acts(self, t: float, sent: Setpoint) -> bool:
        """Thrusters can turn by what the Pi said before a report of then."""
        held = [name for name in CLOSED if getattr(sent, name) is not None]
        return all(
            t - self._last.get(name, -math.inf) <= CLOSED_S and t >= self._since[name] + _SETTLE
            for name in held
        )


class Watch:
    """``sent`` is the set in force at the vehicle (None: nothing, or an order)."""

    vehicle: Vehicle
    vehicle_state: VehicleState
    bounds: Bounds
    lost: int
    descent: Descent
    steering: Steering
    progress: Progress
    closing: Closing

    def __init__(self, vehicle: Vehicle, vehicle_state: VehicleState, bounds: Bounds) -> None:
        self.vehicle, self.vehicle_state, self.bounds = vehicle, vehicle_state, bounds
        self.fences: tuple[Fence, ...] = ()  # of the mission under way
        self.sent: Setpoint | None = None
        self.accepted_at: float | None = None  # of the set in force
        self.started: float | None = None  # the mission's clock
        self.heard = -math.inf  # the last report, or when its age began anew
        self.topside_silence: float | None = None  # s that may pass; None: as long as it likes
        self.topside_heard = -math.inf
        self.lost = 0
        self.lost_words: dict[bytes, tuple[int, float]] = {}  # since it was answered; s, the last
        self.blind_since: float | None = None
        self.led_down = -math.inf  # without a depth to believe, by a set or the stick: when last
        self._dark_since = math.inf  # without one
        self.repeated = False  # after a brown-out the set was sent again
        self.descent, self.steering, self.progress = Descent(), Steering(), Progress()
        self.closing = Closing()

    def clone(self, vehicle_state: VehicleState) -> Self:
        return copied(self, vehicle_state=vehicle_state)

    def begin(self, now: float) -> None:
        """A mission starts, or goes on: ages and counts begin anew. What has led down since a depth
        was believed stands: the start demands one, and what goes on does not."""
        self.heard, self.lost, self.lost_words, self.blind_since = now, 0, {}, None
        self.topside_heard = now
        self.repeated = False
        self.descent, self.steering, self.progress = Descent(), Steering(), Progress()

    def set_sent(self, setpoint: Setpoint | None) -> None:
        self.sent, self.accepted_at = setpoint, None
        self.vehicle_state.command = self.vehicle_state.word = setpoint

    def count(self, outcome: Outcome) -> None:
        """Of the legs' sets each word counts by itself, too: another's answer is none to it. So it
        does of one that a newer set has replaced meanwhile: what steers has one each second."""
        lost, word = outcome.result is Result.LOST, outcome.frame[:4]
        self.lost = self.lost + 1 if lost else 0
        if isinstance(outcome.command, Setpoint):
            before, at = self.lost_words.get(word, (0, -math.inf))
            now = self.vehicle_state.now
            times = before if now - at <= _LOST_WITHIN else 0
            self.lost_words |= {word: (times + 1 if lost else 0, now)}

    @property
    def unanswered(self) -> int:
        """Commands in succession, or of one word of the sets, without an answer (R8)."""
        return max(self.lost, *(times for times, _ in self.lost_words.values()), 0)

    def take_report(self) -> None:
        report = self.vehicle_state.telemetry
        assert report is not None
        self.heard = report.t
        self.closing.take(report)
        depth, fastest = self.vehicle_state.depth, self.vehicle.limits.descent_rate
        driven = self.sent is not None and self.sent.depth is None  # one that is held: Progress
        self.descent.take(report.t, depth, self._dive_asked(), fastest, driven)
        heading = report.heading if self.vehicle_state.health("heading").valid else None
        self.progress.take(report.t, depth, self.sent.depth if self.sent else None)
        self.steering.take(report.t, heading, self.sent.heading if self.sent else None)

    def look_for_depth(self) -> None:
        """Note since when the vehicle is, or may be, submerged without a depth to believe."""
        vehicle_state = self.vehicle_state
        if vehicle_state.depth is not None:
            self.blind_since, self.led_down, self._dark_since = None, -math.inf, math.inf
            return
        self._dark_since = min(self._dark_since, vehicle_state.now)
        if leads_down(self.sent):
            self.led_down = vehicle_state.now
        if not (vehicle_state.submerged or self._may_be_under()):
            self.blind_since = None
        elif self.blind_since is None:
            self.blind_since = vehicle_state.now

    def _may_be_under(self) -> bool:
        """Though the last depth that was believed was the surface's: it was led down since, and no
        fix has proved the surface behind it (a leg that holds a depth has an end of its own, but
        others may follow it), or fixes came in this mission and have ended."""
        sent, now = self.sent, self.vehicle_state.now
        led = self.led_down > -math.inf and not self.vehicle_state.fixed(self.led_down)
        own_end = sent is not None and sent.depth is not None
        if led and (not own_end or now - self._dark_since >= _OWN_END):
            return True
        news_at = self.vehicle_state.receiver.news_at
        return self.started is not None and self.started < news_at < now - RECENT

    def _dive_asked(self) -> bool:
        sent, depth, report = self.sent, self.vehicle_state.depth, self.vehicle_state.telemetry
        if sent is None or depth is None or report is None:
            return False
        if sent.depth is not None:
            return depth < sent.depth + SURFACE_DEPTH
        if sent.altitude is not None:
            above = report.altitude if self.vehicle_state.health("altitude").valid else None
            return above is None or above > sent.altitude - SURFACE_DEPTH
        return leads_down(sent)

    def course_apart(self) -> bool | None:
        """At the surface and under way ahead, the course more than 60 deg off the heading."""
        fix: Fix | None = self.vehicle_state.fix if self.vehicle_state.receiver.fresh else None
        e, depth = self.vehicle_state.estimate, self.vehicle_state.depth
        if fix is None or fix.course is None or fix.speed is None or e is None or e.heading is None:
            return None
        if self.sent is None or depth is None or not self.vehicle_state.health("heading").valid:
            return None
        ahead = self.vehicle.speed_by_gear.at(GEARS * self.sent.surge)
        if ahead < _UNDER_WAY or fix.speed < _UNDER_WAY:
            return False
        if depth >= FIX_DEPTH:
            return None  # the fix says otherwise: a wave
        return abs(wrap(fix.course - e.heading)) > _APART

    def turning(self, since: float) -> bool:
        """A report from well after then says that a thruster is on, or that what drives has way."""
        report = self.vehicle_state.telemetry
        if report is None or report.t < since + _SETTLE:
            return False
        if self.vehicle.drives and report.velocity is not None:
            return report.t >= since + _ROLLS_OUT and abs(report.velocity[0]) > _STANDS
        return turns(report)

    def neutral(self, since: float) -> bool | None:
        """Whether no thruster is on, by a report from well after then; two can have said so. None
        where none tells."""
        report = self.vehicle_state.telemetry
        if report is None or not report.actuators or report.t < since + _BACK:
            return None
        return all(abs(a) <= NEUTRAL for a in report.actuators[:THRUSTERS])

    def powerless(self) -> bool | None:
        """Thrust is set and acknowledged, and every thruster is neutral. None, too, where the Pi
        has said neutral by itself."""
        report, sent = self.vehicle_state.telemetry, self.sent
        if report is None or not report.actuators or sent is None or self.accepted_at is None:
            return None
        if not (sent.surge or sent.turn or sent.heave):
            return False
        if report.t < self.accepted_at + _SETTLE or not self._closes(report.t, sent):
            return None
        if turns(report):
            self.repeated = False
            return False
        return True

    def _closes(self, t: float, sent: Setpoint) -> bool:
        """Where the Pi holds the axes of the set: it has not said neutral by itself."""
        loop = self.vehicle.outer_loop
        return loop is None or not loop.confirmed or self.closing.acts(t, sent)


def leads_down(sent: Setpoint | None) -> bool:
    """A vehicle that is at the surface, to below it."""
    if sent is None:
        return False
    below = sent.depth is not None and sent.depth > SURFACE_DEPTH
    nose_first = (sent.pitch or 0.0) * sent.surge < 0.0
    return below or nose_first or sent.altitude is not None or (sent.heave or 0.0) > 0.0
