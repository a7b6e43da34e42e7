"""The quantities that limits check, and that must be remembered between reports.

    descent    a depth that grows faster than the vehicle may dive, or while no command asks for it
    steering   a heading that moves away from the one that was asked for
    progress   a depth that was asked for and does not come nearer
    course     the course over ground against the heading
    closing    the readings by which the Pi itself holds an axis: without them it sends neutral

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

_ALLOWANCE = 2.0  # m by momentum, waves and noise that are no descent
_SINKING = 0.1  # m/s: less is no descent, ...
_SLOWLY = 20.0  # s: ... unless it is deeper for longer than a wave, and the set holds no depth
_RATE_TIME = 1.0  # s: over a shorter time two depths give noise, not a rate
_BEYOND = 0.5  # m deeper than a dive at the greatest rate: less is noise
_STALE = 10.0  # s: two depths farther apart give no rate
_TURNING_TIME = 10.0  # s of growing heading error (design: limits)
_GROWTH, _LARGE, _NOISE = (math.radians(a) for a in (20.0, 30.0, 10.0))
_ROUND = math.radians(720.0)  # no turn to a heading goes round twice
_NEW_HEADING = math.radians(15.0)
_STUCK_TIME = 120.0  # s without coming nearer: even a dive at a tenth of its rate comes nearer
_NEARER, _OFF = 0.5, 2.0  # m: nearer in that time; from the depth asked for, and not there yet
_APART = math.radians(60.0)
_UNDER_WAY = 0.4  # m/s through the water and over ground: slower, the course tells nothing
_SETTLE = 0.5  # s from an ACK to thrusters that turn
_OWN_END = 8.0  # s without a depth, within which a leg that holds one ends by itself
_BACK = 3.0  # s from a thrust command to a report that shows it, and one more report
_LOST_WITHIN = 60.0  # s: a command that is never answered is sent again every few seconds
_ROLLS_OUT, _STANDS = 2.0, 0.05  # s to come to rest, and m/s at rest: a vehicle that drives


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
        """Do not count depth gained until the next depth that counts, reported or not."""
        self._shallowest = None

    def take(
        self, t: float, depth: float | None, asked: bool, fastest: float, driven: bool = False
    ) -> None:
        """Take a report. ``asked``: a descent is asked for; ``driven``: the set holds no depth."""
        if depth is None:
            self.unexplained = None
            return
        since, before = t - self._t, self._depth
        if 0.0 < since < _RATE_TIME:
            self.unexplained = None
            return
        self._t, self._depth = t, depth
        seen = max(depth, before)  # a single shallower one may be an outlier
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
        """Whether the vehicle was deeper for longer than a wave, without a break: it descends."""
        begun = t if self._deeper_since is None else self._deeper_since
        self._deeper_since = begun if deeper else None
        return t - begun >= _SLOWLY


class Steering:
    __slots__ = ("_from", "_off", "_peak", "_since", "_turned", "_wanted", "astray", "words")

    words: str

    def __init__(self) -> None:
        self._wanted: float | None = None
        self._since, self._from, self._peak = 0.0, 0.0, 0.0
        self._off = self._turned = 0.0  # rad to starboard: from the one wanted; in all since then
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
        """Whether the time continues with a newly asked depth: it is near the one before, and in
        the same direction. Above an uneven bottom a new depth comes every few seconds."""
        before = self._wanted
        if before is None or before == wanted or abs(wanted - before) > _OFF:
            return False
        return min(before, wanted) > depth + _OFF or max(before, wanted) < depth - _OFF


class Closing:
    """The readings by which the Pi holds axes. ``_since``: s, since when each has no gap."""

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
        """Whether the Pi, which holds axes by its readings, can have thrusters on in a report of
        ``t`` (s)."""
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
        self.accepted_at: float | None = None  # when the set in force was acknowledged
        self.started: float | None = None  # the mission's clock
        self.heard = -math.inf  # the last report, or when its age was reset
        self.topside_silence: float | None = None  # s allowed; None: no limit
        self.topside_heard = -math.inf
        self.lost = 0
        self.lost_words: dict[bytes, tuple[int, float]] = {}  # times since an answer; s, the last
        self.blind_since: float | None = None
        self.led_down = -math.inf  # when a set or the stick last led down without a believed depth
        self._dark_since = math.inf  # since when no depth is believed
        self.repeated = False  # after a brown-out the set was sent again
        self.descent, self.steering, self.progress = Descent(), Steering(), Progress()
        self.closing = Closing()

    def clone(self, vehicle_state: VehicleState) -> Self:
        return copied(self, vehicle_state=vehicle_state)

    def begin(self, now: float) -> None:
        """Reset ages and counts: a mission starts or resumes. ``led_down`` stays: a start requires
        a believed depth, but to resume does not."""
        self.heard, self.lost, self.lost_words, self.blind_since = now, 0, {}, None
        self.topside_heard = now
        self.repeated = False
        self.descent, self.steering, self.progress = Descent(), Steering(), Progress()

    def set_sent(self, setpoint: Setpoint | None) -> None:
        self.sent, self.accepted_at = setpoint, None
        self.vehicle_state.command = self.vehicle_state.word = setpoint

    def count(self, outcome: Outcome) -> None:
        """Count lost frames: in succession, and each command of the legs' sets by itself, since an
        answer to another command is none to it. A command counts even if a newer set has replaced
        its set: a leg that steers has a new set each second."""
        lost, word = outcome.result is Result.LOST, outcome.frame[:4]
        self.lost = self.lost + 1 if lost else 0
        if isinstance(outcome.command, Setpoint):
            before, at = self.lost_words.get(word, (0, -math.inf))
            now = self.vehicle_state.now
            times = before if now - at <= _LOST_WITHIN else 0
            self.lost_words |= {word: (times + 1 if lost else 0, now)}

    @property
    def unanswered(self) -> int:
        """How many commands in succession, or times one command of the sets, had no answer (R8)."""
        return max(self.lost, *(times for times, _ in self.lost_words.values()), 0)

    def take_report(self) -> None:
        report = self.vehicle_state.telemetry
        assert report is not None
        self.heard = report.t
        self.closing.take(report)
        depth, fastest = self.vehicle_state.depth, self.vehicle.limits.descent_rate
        driven = self.sent is not None and self.sent.depth is None  # else Progress watches it
        self.descent.take(report.t, depth, self._dive_asked(), fastest, driven)
        heading = report.heading if self.vehicle_state.health("heading").valid else None
        self.progress.take(report.t, depth, self.sent.depth if self.sent else None)
        self.steering.take(report.t, heading, self.sent.heading if self.sent else None)

    def look_for_depth(self) -> None:
        """Note since when the vehicle is, or may be, submerged without a believed depth."""
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
        """Whether the vehicle may be under water although the last believed depth was at the
        surface. Either it was led down since, and no fix has proved the surface after that. (A leg
        that holds a depth ends by itself, but others may follow it.) Or fixes came in this mission
        and have ended."""
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
        """Whether, at the surface and under way ahead, course and heading are over 60 deg apart."""
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
            return None  # a fix came all the same: the depth may be a wave's
        return abs(wrap(fix.course - e.heading)) > _APART

    def turning(self, since: float) -> bool:
        """Whether a report long enough after ``since`` shows a thruster on; for a vehicle that
        drives, whether it still moves."""
        report = self.vehicle_state.telemetry
        if report is None or report.t < since + _SETTLE:
            return False
        if self.vehicle.drives and report.velocity is not None:
            return report.t >= since + _ROLLS_OUT and abs(report.velocity[0]) > _STANDS
        return turns(report)

    def neutral(self, since: float) -> bool | None:
        """Whether no thruster is on, by a report long enough after ``since`` for two to have shown
        it. None if no report shows it."""
        report = self.vehicle_state.telemetry
        if report is None or not report.actuators or report.t < since + _BACK:
            return None
        return all(abs(a) <= NEUTRAL for a in report.actuators[:THRUSTERS])

    def powerless(self) -> bool | None:
        """Whether thrust is set and acknowledged, but every thruster is neutral. None if this is
        unknown, or if the Pi has sent neutral by itself."""
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
        """Whether the Pi has not sent neutral by itself; it may where it holds the set's axes."""
        loop = self.vehicle.outer_loop
        return loop is None or not loop.confirmed or self.closing.acts(t, sent)


def leads_down(sent: Setpoint | None) -> bool:
    """Whether the set leads a vehicle at the surface under water."""
    if sent is None:
        return False
    below = sent.depth is not None and sent.depth > SURFACE_DEPTH
    nose_first = (sent.pitch or 0.0) * sent.surge < 0.0
    return below or nose_first or sent.altitude is not None or (sent.heave or 0.0) > 0.0
