"""What the engine can do beside a mission: stop, surface, hold up, mind the rest and the stick.

Every verb leaves a Step; every command that leaves stands in a Step, with its reason.

What does not live here: what it can do with a mission (flying), the state that verbs change
(state), when a verb is due (engine), which operator may ask for it (orders).
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

_LATER = 0.5  # s behind a report's age, and it is not believed


class Core(Flying):
    def load(self, chart: Chart | None) -> None:
        """Takes over the store's mission; machine and limits follow. Not allowed while a mission
        runs."""
        active, self.chart = self.active, chart
        self.machine = Machine(chart)
        self.machine.restore(active)
        self.renew_bounds()
        if chart is not None and active == IDLE_EMPTY:
            self._move("load", IDLE_READY, "a mission is stored", (), None)
        elif chart is None and active == IDLE_READY:
            self._move("clear", IDLE_EMPTY, "no mission is stored", (), None)

    def clear(self) -> None:
        """Clears the mission; only called where no run is under way. A stop that is not
        acknowledged yet goes on; thrust that held up a vehicle at the surface is stopped."""
        self.chart, why = None, "cleared by the operator"
        if self.active != IDLE_EMPTY:
            self._move("clear", IDLE_EMPTY, why, self._stop(why) if self.hold else (), By.OPERATOR)
        self._let_go()
        self.machine = Machine()
        self.emergency_since_idle = False
        self._forget_sinking()
        self.renew_bounds()

    def renew_bounds(self) -> None:
        """Recomputes the limits in force. To be called when the mission's or the operator's limits
        change."""
        own = self.chart.mission.safety if self.chart else None
        self.watch.bounds = in_force(self.vehicle, own, self.operator)

    def stop_again(self) -> None:
        """Repeats a stop every 500 ms until it is acknowledged."""
        if self.stop_at is not None and self.now >= self.stop_at:
            self._record(self._stop(f"{self.reason}: no acknowledgement yet"))

    def stop_quietly(self, why: str) -> None:
        """Stops everything without a change of state, also what the stick asked for: not every
        board has a dead man's switch."""
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
        """Stops again if a report shows a thruster on after an acknowledged stop, where everything
        is stopped. An acknowledgement alone proves nothing."""
        if self.stopped_at is not None and self._stands and self.watch.turning(self.stopped_at):
            self.doubted_at = self.now
            seen = "it has way" if self.vehicle.drives else "a thruster turns"
            self._record(self._stop(f"{self.reason}: {seen} after it was stopped"))

    def doubt_line(self) -> None:
        """Sends again, after the line to the vehicle was away, a stop that was acknowledged, the
        leg's set, an ascent's way, or what holds it up: another board may have acknowledged it, or
        nobody heard it. Words of the stick are sent all the time anyway."""
        self.outputs.doubt()
        ascent = self.leg_ascent or self.ascent
        if ascent is not None:
            ascent.doubt()
            self._record((Action(ascent.way, f"{ascent.why}: the line to the vehicle was away"),))
        elif self.hold is not None:
            self.hold_up("the line to the vehicle was away")
        elif self._stands and self.stopped_at is not None:
            self._record(self._stop(f"{self.reason}: the line to the vehicle was away"))
        else:
            self.repeat_set("the line to the vehicle was away: the whole set again")

    def stop_in(self, name: str, state: str, why: str, by: By = By.LIMIT) -> None:
        """emergency/stopped or surfaced; ``name`` as for ``surface``."""
        self._let_go()
        lifted = self.active == SURFACING or state == SURFACED
        if lifted and self.vehicle_state.surfaced(self.now - SURFACE_TIME):
            self.let_go_at = self.now  # what thrust may have held up there
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
        """emergency/surfacing, from anywhere; ``name`` is the row of the region table, ``sinks``:
        it goes down though everything is stopped. An ascent
        that is under way, or that a leg has begun, goes on: to begin it anew would undo what it has
        found out. An operator's W leaves as it is, and behind it the way in use. Where that is not
        W it does so once a turn: said again and again it would keep that way from the board."""
        vehicle_state = self.vehicle_state
        sinking = sinks or (name == "limit" and self.rests)
        self._sank = self._sank or (sinking and self.active == SURFACED)
        begun = self.ascent if self.active == SURFACING else self.leg_ascent
        held = self.hold.way if self.hold and vehicle_state.depth is not None else None
        self._to_emergency()
        self.stop_at = self.stopped_at = None
        self.rested = ""  # what ended in between was another rest
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
        """Ends the mission; from here the operator has to clear, or to take the stick."""
        self.ascent = self.hold = self.deep_since = None
        self.halt_run()
        self.emergency_since_idle, self.emergency_at = True, self.now

    def say_last(self, action: Action) -> None:
        """Enters emergency/surfacing with this one command; no ascent goes on from it."""
        if self.active == SURFACING:
            self._record((action,))
        else:
            self._to_emergency()
            self._move("end", SURFACING, action.reason, (action,), By.LIMIT)
        self.ascent = self.stop_at = self.stopped_at = None

    def climb(self) -> None:
        """Goes on with the emergency's ascent, or ends it at the surface; what sinks when it is let
        go is held up there, where AUTO is open."""
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
        """Of what was held up at the surface."""
        if self.hold is not None:
            self.let_go_at, self.hold = self.now, None

    def _forget_sinking(self) -> None:
        """That it would sink again, and which way holds it up then."""
        self._sank, self.push, self.neutral = False, None, 0

    def hold_up(self, why: str, way: Way | None = None) -> None:
        """Says again what holds it up at the surface, or says this way."""
        if self.hold is not None:
            self.hold = Hold(way or self.hold.way, self.hold.since, self.now)
            self._record((Action(self.hold.way, f"{self.reason}: {why}"),))

    def _mind_hold(self, hold: Hold) -> None:
        """Where its thrusters are off the word was lost, or its board has begun anew, and it is
        said again; once more, and the board is deaf to it: the other one that pushes up."""
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
        """An ascent answers a descent, and the stick asks for it; to be called first in every step:
        reports may be missing."""
        if self.leg_ascent or self.active in (SURFACING, MANUAL_DRIVING):
            self.watch.descent.excuse()

    def mind_rest(self) -> None:
        """Looks, with each report, for a vehicle that sinks although everything is stopped, or that
        stays deep after X; brings it up, each time that happens (R7)."""
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
        unsure = state.depth is None and not state.receiver.settled(report.t)
        self.rest.follow(report.t, state.moving_depth if unsure else None)
        stays = self.rest.stays_down() if kind == "stopped" or self.rest.unseen else ""
        why = stays if kind == "stopped" else self.rest.sinks or stays
        why = "" if state.depth is None else why  # it may be on deck by now
        if (why := why or self.rest.goes_down) and self.auto:
            self.surface("limit", why, By.LIMIT, sinks=True)
        elif self.hold is not None:
            self._mind_hold(self.hold)

    def mind_fixes(self) -> None:
        """Brings up what is taken to sink though no depth tells: the fixes that proved the surface
        have ended, with reports or without (R7)."""
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
        """Whether it would show that the vehicle sinks. One that stands or is above the water does
        not, where fixes may say otherwise: the vehicle's own are fixes by that depth alone."""
        state, fix, depth = self.vehicle_state, self.vehicle_state.fix, self.vehicle_state.depth
        own = fix is not None and fix.accuracy == math.inf
        return depth is not None and (own or not (state.repeats or depth <= IN_AIR))

    @property
    def is_heard(self) -> bool:
        """Whether reports come."""
        told = self.vehicle_state.telemetry
        return told is not None and self.now - told.t <= self.vehicle.stale_after

    @property
    def _fixes_end(self) -> tuple[float, str]:
        """When the fixes that proved the surface count as ended, and which; never where it was let
        go a minute before: it floats. What is held up may lose that long after."""
        state, since = self.vehicle_state, self.let_go_at if self.hold is None else self.hold.since
        in_leg = self._stands and self.region == AUTONOMOUS
        if not (self.active == SURFACED or self.region == IDLE or in_leg):
            return math.inf, ""
        due, ended = fixes_end(state.receiver, since, RECENT if in_leg else ENDED)
        nears = NEARS_GROUND in state.contradicted  # what floats and loses its fixes does not
        if self.hold is None and not nears and max(due, self.now) > since + UNSEEN:
            return math.inf, ""
        return due, ended

    def rest_due(self) -> float | None:
        """When the end of the fixes is to be looked for, if nothing is heard any more."""
        due, told = self._fixes_end[0], self.vehicle_state.telemetry
        if due < math.inf and told is not None and self._depth_tells:
            return max(due, told.t + self.vehicle.stale_after + _LATER)
        return due if due < math.inf else None

    def take_stick(self) -> None:
        """Enters manual/driving; a mission stays where it was interrupted."""
        self.ascent = self.hold = None
        self.rested = ""  # what it was before the stick says nothing behind it
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
        """Ends manual a minute after the last M: idle at the surface, and where the vehicle never
        tells a depth; surfacing where it is deeper, or where the depth is not known or has not
        changed since before the stick, once AUTO is open: until then nothing turns by itself."""
        depth = self.vehicle_state.depth if self.vehicle_state.lives else None
        tells = "depth" in self.vehicle.reports  # else nothing could end an ascent
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
        """Ends the mission when node AUTO is closed (R13), and lets go of what is held up; either
        way everything is stopped."""
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
        """Takes in what became of a frame: counts lost ones, notes acknowledged stops that still
        stand, and refused, late or lost sets."""
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
