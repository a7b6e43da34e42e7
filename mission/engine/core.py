"""The engine's actions outside a mission: stop, surface, hold up, watch the vehicle at rest, stick.

Every action records a Step. Every command sent is recorded in a Step, with its reason. "Let go"
means: everything is stopped (X0), and buoyancy alone moves the vehicle.

What does not live here: actions on a mission (flying), the state that actions change (state),
when an action is due (engine), which operator may ask for it (orders).
"""

from __future__ import annotations

import math

from mission.engine.ascent import Ascent, Way
from mission.engine.bounds import in_force
from mission.engine.flying import Flying
from mission.engine.limits import Limit
from mission.engine.machine import Machine
from mission.engine.rest import DEEP, DEEP_AGAIN, ENDED, UNSEEN, Hold, fixes_end
from mission.engine.vehicle_state import IN_AIR, SURFACE_DEPTH, SURFACE_TIME
from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    NEARS_GROUND,
    STOPPED,
    SURFACED,
    SURFACING,
    Action,
    By,
    Chart,
    Evaluation,
    Outcome,
    Result,
)
from mission.model.regions import IDLE, MANUAL
from mission.navigation.fixes import RECENT
from protocol.messages import UPWARD, Order

_LATER = 0.5  # s beyond the greatest age of a report: by then it is surely not believed


class Core(Flying):
    def load(self, chart: Chart | None) -> None:
        """Load the stored mission (None: there is none), and rebuild machine and limits. Not to be
        called while a mission is under way."""
        active, self.chart = self.active, chart
        self.machine = Machine(chart)
        self.machine.restore(active)
        self.renew_bounds()
        if chart is not None and active == IDLE_EMPTY:
            self._move("load", IDLE_READY, "a mission is stored", (), None)
        elif chart is None and active == IDLE_READY:
            self._move("clear", IDLE_EMPTY, "no mission is stored", (), None)

    def clear(self) -> None:
        """Clear the mission. Not to be called while one is under way. A stop that is not yet
        acknowledged is still repeated. Thrust that holds the vehicle up at the surface is
        stopped."""
        self.chart, why = None, "cleared by the operator"
        if self.active != IDLE_EMPTY:
            self._move("clear", IDLE_EMPTY, why, self._stop(why) if self.hold else (), By.OPERATOR)
        self._let_go()
        self.machine = Machine()
        self.emergency_since_idle = False
        self._forget_sinking()
        self.renew_bounds()

    def renew_bounds(self) -> None:
        """Recompute the limits in force. Call it when the mission's or the operator's limits
        change."""
        own = self.chart.mission.safety if self.chart else None
        self.watch.bounds = in_force(self.vehicle, own, self.operator)

    def stop_again(self) -> None:
        """Repeat a stop every 500 ms until it is acknowledged."""
        if self.stop_at is not None and self.now >= self.stop_at:
            self._record(self._stop(f"{self.reason}: no acknowledgement yet"))

    def stop_quietly(self, why: str) -> None:
        """Stop everything without a change of state. This includes what the stick asked for: not
        every board goes neutral by itself when commands end."""
        self.reason = why
        self._record(self._stop(why))

    @property
    def rests(self) -> bool:
        """Whether the state is one in which everything is stopped."""
        return self.region == IDLE or self.active in (STOPPED, SURFACED, MANUAL_WAITING)

    @property
    def _stands(self) -> bool:
        """Whether everything is stopped: at rest, or where a leg's ascent has ended."""
        return self.rests or (self.flying is not None and self.flying.at_surface)

    def doubt_stop(self) -> None:
        """Stop again if a report shows a thruster on after a stop was acknowledged, in a state in
        which everything is stopped. An acknowledgement alone proves nothing."""
        if self.stopped_at is not None and self._stands and self.watch.turning(self.stopped_at):
            self.doubted_at = self.now
            seen = "it has way" if self.vehicle.drives else "a thruster turns"
            self._record(self._stop(f"{self.reason}: {seen} after it was stopped"))

    def doubt_line(self) -> None:
        """Send the command in force again after the line to the vehicle was disconnected: a stop,
        the leg's set, an ascent's way, or the thrust that holds the vehicle up. Another board may
        have acknowledged it, or none received it; and an answer that comes now may be a late one to
        a command before it. Commands of the stick are sent continuously anyway."""
        self.outputs.doubt()
        ascent = self.leg_ascent or self.ascent
        if ascent is not None:
            ascent.doubt()
            self._record((Action(ascent.way, f"{ascent.why}: the line to the vehicle was away"),))
        elif self.hold is not None:
            self.hold_up("the line to the vehicle was away")
        elif self._stands and (self.stop_at is not None or self.stopped_at is not None):
            self._record(self._stop(f"{self.reason}: the line to the vehicle was away"))
        else:
            self.repeat_set("the line to the vehicle was away: the whole set again")

    def stop_in(self, name: str, state: str, why: str, by: By = By.LIMIT) -> None:
        """Enter emergency/stopped or emergency/surfaced; ``name`` as for ``surface``."""
        self._let_go()
        lifted = self.active == SURFACING or state == SURFACED
        if lifted and self.vehicle_state.surfaced(self.now - SURFACE_TIME):
            self.let_go_at = self.now  # thrust may have held it up there
        self._to_emergency()
        self.doubted_at, self.rested = -math.inf, ""
        self._forget_sinking()
        self.vehicle_state.rising_since = None
        self._move(name, state, why, self._stop(why), by)

    def surface(
        self,
        name: str,
        why: str,
        by: By,
        evaluations: tuple[Evaluation, ...] = (),
        *,
        sinks: bool = False,
    ) -> None:
        """Enter emergency/surfacing, from any state. ``name`` is the row of the region table.
        ``sinks``: the vehicle sinks although everything is stopped.

        An ascent that is under way, here or in a leg, continues: a new one would lose what it has
        found out. An operator's W is sent, and then the way in use. If that way is not W, only the
        first W of its turn is sent: more of them would keep that way from the board."""
        vehicle_state = self.vehicle_state
        sinking = sinks or (name == "limit" and self.rests)
        self._sank = self._sank or (sinking and self.active == SURFACED)
        begun = self.ascent if self.active == SURFACING else self.leg_ascent
        held = self.hold.way if self.hold and vehicle_state.depth is not None else None
        self._to_emergency()
        self.stop_at = self.stopped_at = None
        self.rested = ""  # a rest after this ascent is a new one
        self.watch.set_sent(None)
        if begun is None:
            vehicle_state.rising_since = self.now
        self.ascent = begun or Ascent(
            self.now,
            vehicle_state.moving_depth,
            why,
            self.ways,
            overturned=vehicle_state.overturned,
            upward=sinking or vehicle_state.depth is None,
            sank=self._sank,
            push=self.push or held,
        )
        vehicle_state.word = way = self.ascent.way
        said = by is By.OPERATOR and (way is Order.SURFACE or self.ascent.hear(self.now))
        words = [Order.SURFACE] * (said and way is not Order.SURFACE) + [way] * (said or not begun)
        self._move(name, SURFACING, why, tuple(Action(w, why) for w in words), by, evaluations)

    def _to_emergency(self) -> None:
        """End the mission. From here the operator has to clear, or to take the stick."""
        self.ascent = self.hold = self.deep_since = None
        self.halt_run()
        self.emergency_since_idle, self.emergency_at = True, self.now

    def say_last(self, action: Action) -> None:
        """Enter emergency/surfacing and send this one command; no ascent follows it."""
        if self.active == SURFACING:
            self._record((action,))
        else:
            self._to_emergency()
            self._move("end", SURFACING, action.reason, (action,), By.LIMIT)
        self.ascent = self.stop_at = self.stopped_at = None

    def climb(self) -> None:
        """Continue the emergency's ascent, or end it at the surface. A vehicle that sank when it
        was let go is held up there while node AUTO is open."""
        if self.ascent is None:
            return
        holds = self._sank and self.auto
        now, depth, overturned, doubtful = self.vehicle_state.seen_rising
        if not self.vehicle_state.surfaced(max(self.ascent.began, now - SURFACE_TIME)):
            if actions := self.ascent.act(now, depth, overturned, doubtful):
                self._record(actions)
        elif holds and (lift := self.ascent.lifts(now, depth, overturned or doubtful)):
            self._record(lift)
        elif self.ascent.is_up(now):
            why = f"{self.reason}; at the surface"
            words: tuple[Action, ...] = ()
            if holds and self.ascent.pushes_up:
                why = f"{why}, and held up: it sank when it was let go"
                self.hold, self.let_go_at = Hold(self.ascent.push, now, now), -math.inf
                if self.ascent.way != self.hold.way:
                    words = (Action(self.hold.way, why),)
            else:
                self.let_go_at, words = now, self._stop("the surface is reached")
            self._move("surfaced", SURFACED, why, words, None)
            self.ascent = None

    def _let_go(self) -> None:
        """Note that thrust no longer holds the vehicle up at the surface."""
        if self.hold is not None:
            self.let_go_at, self.hold = self.now, None

    def _forget_sinking(self) -> None:
        """Forget that the vehicle would sink again, and which way holds it up."""
        self._sank, self.push, self.neutral = False, None, 0

    def hold_up(self, why: str, way: Way | None = None) -> None:
        """Send again the thrust that holds the vehicle up at the surface, or send this way."""
        if self.hold is not None:
            self.hold = Hold(way or self.hold.way, self.hold.since, self.now)
            self._record((Action(self.hold.way, f"{self.reason}: {why}"),))

    def _mind_hold(self, hold: Hold) -> None:
        """Send the thrust again if reports show no thruster on: the command was lost, or the board
        restarted. The second time in succession send the other way that pushes up: the board may
        ignore the first."""
        off = self.watch.neutral(hold.said_at)
        if off is None:
            return
        if not off:
            self.neutral, self.push = 0, hold.way
            return
        self.neutral, way = self.neutral + 1, hold.way
        if self.neutral > 1:
            pushes = [push for push in self.ways if push in (Order.SURFACE, UPWARD)]
            way, self.neutral = next((push for push in pushes if push != way), way), 0
        self.hold_up("its thrusters are off", way)

    def excuse_descent(self) -> None:
        """Do not count depth gained in an ascent or under the stick as an unexplained descent.
        Call this first in every step, since reports may be missing."""
        if self.leg_ascent or self.active in (SURFACING, MANUAL_DRIVING):
            self.watch.descent.excuse()

    def mind_rest(self) -> None:
        """Look, with each report, whether the vehicle sinks although everything is stopped, or
        stays deep after X. Bring it up each time this happens (R7)."""
        kind = ("stopped" if self.active == STOPPED else "rest") if self._stands else ""
        kind = "leg" if kind and self.region == AUTONOMOUS else kind
        state, surfaced = self.vehicle_state, self.active == SURFACED
        if kind != self.rested:
            self.rested = kind
            proved = (surfaced or kind == "leg") and self.let_go_at > -math.inf
            unseen = (state.depth is None or self.moved_blind) and not proved
            self.rest.begin(SURFACE_DEPTH if proved else math.nan, unseen=unseen)
        report = state.telemetry
        if not kind or report is None:
            return
        self.rest.take(report.t, state.depth, DEEP_AGAIN if surfaced else DEEP)
        unsure = not state.receiver.settled(report.t) or state.travel.descends(report.t)
        doubted = state.moving_depth if state.depth is None and unsure else None
        self.rest.follow(report.t, doubted)
        stays = self.rest.stays_down() if kind == "stopped" or self.rest.unseen else ""
        why = stays if kind == "stopped" else self.rest.sinks or stays
        why = "" if state.depth is None else why  # it may be on deck by now
        if (why := why or self.rest.goes_down) and self.auto:
            self.surface("limit", why, By.LIMIT, sinks=True)
        elif self.hold is not None:
            self._mind_hold(self.hold)

    def mind_fixes(self) -> None:
        """Bring the vehicle up when the fixes that proved the surface have ended and no depth shows
        whether it sinks. Reports may come or not (R7)."""
        due, ended = self._fixes_end
        if self.now >= due and not self._depth_tells and self.auto:
            done = "let go" if self.hold is None else "held up"
            depth, told = self.vehicle_state.depth, "no depth is believed"
            if depth is not None:
                told = "the depth stands" if depth > IN_AIR else "the depth is above the water"
            why = f"{ended} since it was {done}, and {told}"
            self.surface("limit", why, By.LIMIT, sinks=True)

    @property
    def _depth_tells(self) -> bool:
        """Whether the depth would show that the vehicle sinks. A depth that may have frozen, or is
        above the water, would not. It still counts where the fixes are the vehicle's own: those
        are fixes by that depth alone, so they cannot contradict it."""
        state, fix, depth = self.vehicle_state, self.vehicle_state.fix, self.vehicle_state.depth
        own = fix is not None and fix.accuracy == math.inf
        return depth is not None and (own or not (state.repeats or depth <= IN_AIR))

    @property
    def is_heard(self) -> bool:
        """Whether the last report is not older than ``stale_after``."""
        told = self.vehicle_state.telemetry
        return told is not None and self.now - told.t <= self.vehicle.stale_after

    @property
    def _fixes_end(self) -> tuple[float, str]:
        """When the fixes that proved the surface count as ended (s), and which ones, in words.

        inf more than a minute after the vehicle was let go: by then it floats. The minute does not
        count while thrust holds the vehicle up, or while the ground comes nearer."""
        state, since = self.vehicle_state, self.let_go_at if self.hold is None else self.hold.since
        in_leg = self._stands and self.region == AUTONOMOUS
        if not (self.active == SURFACED or self.region == IDLE or in_leg):
            return math.inf, ""
        due, ended = fixes_end(state.receiver, since, RECENT if in_leg else ENDED)
        nears = NEARS_GROUND in state.contradicted  # one that floats and loses fixes does not
        if self.hold is None and not nears and max(due, self.now) > since + UNSEEN:
            return math.inf, ""
        return due, ended

    def rest_due(self) -> float | None:
        """When to check whether the fixes have ended, if no more input comes; None if never."""
        due, told = self._fixes_end[0], self.vehicle_state.telemetry
        if due < math.inf and told is not None and self._depth_tells:
            return max(due, told.t + self.vehicle.stale_after + _LATER)
        return due if due < math.inf else None

    def take_stick(self) -> None:
        """Enter manual/driving; a mission stays where it was interrupted."""
        self.ascent = self.hold = None
        self.rested = ""  # the rest before the stick says nothing about the one after it
        self._forget_sinking()
        self.let_go_at = -math.inf
        self.watch.set_sent(None)
        self.vehicle_state.rising_since = None
        self.vehicle_state.expect_change()
        self._move("stick", MANUAL_DRIVING, "the stick was moved", (), By.OPERATOR)

    def stick_silent(self) -> None:
        back = f"{self.manual_ends} with " if self.manual_ends else ""
        why = f"no M for 2 s: {back}everything stopped"
        self._move("silent", MANUAL_WAITING, why, self._stop(why), None)

    def stick_forgotten(self) -> None:
        """End manual a minute after the last M (R6): idle at the surface, and where the vehicle
        never reports a depth. Otherwise surfacing: the vehicle is deeper, or its depth is unknown
        or has not changed since the stick took over. Surfacing waits until node AUTO is open: no
        thruster may start by itself before."""
        depth = self.vehicle_state.depth if self.vehicle_state.lives else None
        tells = "depth" in self.vehicle.reports  # without a depth nothing could end an ascent
        if tells and (depth is None or depth >= SURFACE_DEPTH):
            seen = "the depth is not known" if depth is None else f"{depth:.1f} m deep"
            if self.auto:
                self.surface("forgotten", f"no M for a minute, and {seen}", By.LIMIT)
            return
        self.halt_run()
        self.emergency_since_idle = False
        target = IDLE_READY if self.chart else IDLE_EMPTY
        where = "at the surface" if tells else "and no depth is ever told"
        self._move("forgotten", target, f"no M for a minute, {where}", (), None)

    def auto_off(self) -> None:
        """End the mission when node AUTO is closed (R13), or let go of a vehicle that is held up;
        both stop everything. A mission that the stick interrupts ends without a stop."""
        why = "node AUTO was closed"
        if self.region == AUTONOMOUS:
            self._move("auto off", IDLE_READY, why, self._stop(why), By.OPERATOR)
            self.halt_run()
        elif self.region == MANUAL:
            self.halt_run()
        elif self.hold is not None:
            self.stop_quietly(f"{why}: what was held up is let go")
            self._let_go()

    def limit(self, row: Limit) -> None:
        why = f"limit {row.name}: {row.why(self.watch)}"
        seen = (Evaluation(f"limit {row.name}", True, (("depth", self.vehicle_state.depth),)),)
        self.surface("limit", why, By.LIMIT, seen)

    def take_outcome(self, outcome: Outcome) -> None:
        """Take in the outcome of a frame: count lost frames, note the acknowledgement of a stop
        or set in force, and a set that was refused or late; send a lost set again."""
        watch, run = self.watch, self.flying
        if outcome.result is not Result.LATE:
            watch.count(outcome)
        stopped = outcome.command is Order.STOP and outcome.result is Result.ACCEPTED
        if stopped and self.stop_at is not None:
            self.stop_at, self.stopped_at = None, self.now
        if outcome.command != watch.sent or run is None or run.sent is None:
            return
        if outcome.result is Result.ACCEPTED:
            watch.accepted_at = self.now
        elif outcome.result in (Result.REFUSED, Result.LATE):
            run.refused = True
        else:
            self.repeat_set("no answer to one of its frames: the whole set again")
