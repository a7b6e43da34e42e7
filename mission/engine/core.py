"""What the engine can do: go to a state, stop, surface, fly a leg.

Every verb leaves a Step; every command that leaves stands in a Step, with its reason.

What does not live here: the state that verbs change (state), when a verb is due (engine), which
operator may ask for it (orders).
"""

from __future__ import annotations

import math

from mission.engine.areas import fences
from mission.engine.ascent import Ascent
from mission.engine.bounds import admit, in_force
from mission.engine.clearance import Clearance
from mission.engine.limits import Limit
from mission.engine.machine import Machine
from mission.engine.rest import DEEP, DEEP_AGAIN, ENDED, UNSEEN
from mission.engine.run import Run
from mission.engine.state import EngineState, Moved
from mission.engine.vehicle_state import SURFACE_DEPTH
from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    IMPLICIT_SURFACE,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    Action,
    By,
    Chart,
    Edge,
    Evaluation,
    Outcome,
    Result,
)
from mission.model.regions import IDLE, MANUAL
from mission.navigation.fixes import RECENT, SETTLED
from protocol.messages import Order, Setpoint

REPEAT_STOP = 0.5  # s (R7)


class Core(EngineState):
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
        held_up = self.active == SURFACED and self.stop_at is self.stopped_at is None
        if self.active != IDLE_EMPTY:
            self._move("clear", IDLE_EMPTY, why, self._stop(why) if held_up else (), By.OPERATOR)
        self.machine = Machine()
        self.emergency_since_idle = self._sank = False
        self.renew_bounds()

    def renew_bounds(self) -> None:
        """Recomputes the limits in force. To be called when the mission's or the operator's limits
        change."""
        own = self.chart.mission.safety if self.chart else None
        self.watch.bounds = in_force(self.vehicle, own, self.operator)

    def begin(self, chart: Chart) -> None:
        """Starts the mission at its first leg."""
        clearance = Clearance.of(chart.mission, self.vehicle)
        self.run = Run(chart, self.now, self.ways, clearance)
        self.watch.started = self.now
        self.watch.fences = fences(chart.mission.areas, self.vehicle_state.place)
        self._fly("mission started", chart.initial)

    def resume(self, run: Run) -> None:
        """Enters the interrupted leg anew; its rounds and the mission's clock have gone on."""
        self._fly("mission resumed", run.leaf)

    def _fly(self, why: str, leaf: str) -> None:
        """Enters a leg out of idle or manual, with the history that the run has (a new run has
        none)."""
        assert self.run is not None
        self.watch.begin(self.now)
        self.stop_at = self.stopped_at = None
        self.reason = why
        moved = self.machine.move("start", leaf)
        self._enter(leaf, moved, "start", None, (), history=True)

    def follow(self, edge: Edge, evaluations: tuple[Evaluation, ...]) -> None:
        """Follows an edge of the mission, to another leg or to the mission's end."""
        assert self.run is not None
        if edge.target == IDLE_READY:
            moved = self.machine.fire(edge.trigger)
            self.halt_run()
            self.reason = "the mission is over"
            stop = self._stop("the mission is over")
            self._record(stop, moved, trigger=edge.trigger, by=edge.by, evaluations=evaluations)
            return
        if edge.by is By.TIMEOUT and (missed := self.run.missed_depth(self.vehicle_state)):
            self.event = f"{self.event}: {missed}"
        self.run.count(edge)
        moved = self.machine.fire(edge.trigger)
        self._enter(edge.target, moved, edge.trigger, edge.by, evaluations)

    def _enter(
        self,
        leaf: str,
        moved: Moved,
        trigger: str,
        by: By | None,
        evaluations: tuple[Evaluation, ...],
        *,
        history: bool = False,
    ) -> None:
        assert self.run is not None
        actions = self.run.enter(leaf, moved[1], self.vehicle_state, history=history)
        actions = self._gate(actions)
        self._record(actions, moved, trigger=trigger, by=by, evaluations=evaluations)

    def enter_quietly(self, leaf: str) -> None:
        """Enters a leg as if its set had been sent and acknowledged; nothing is sent."""
        assert self.run is not None
        self._gate(self.run.enter(leaf, (), self.vehicle_state, history=True))
        self.watch.accepted_at = self.now

    def _gate(self, actions: tuple[Action, ...]) -> tuple[Action, ...]:
        """Returns the actions that may leave. A set beyond the limits counts as refused by the
        vehicle."""
        passed = []
        for action in actions:
            if isinstance(action.command, Setpoint):
                fault = admit(action.command, self.watch.bounds, self.vehicle)
                if fault and self.run is not None:
                    self.run.refused = True
                    self.reason = fault
                    continue
                self.watch.set_sent(action.command)
            else:
                self.watch.set_sent(None)
            passed.append(action)
        return tuple(passed)

    def say(self, action: Action) -> None:
        """Sends a command that does not touch the motion."""
        self._record((action,))

    def fly_on(self) -> None:
        """Sends what the active leg has to send now."""
        run = self.flying
        if run is not None and (actions := self._gate(run.steer(self.vehicle_state))):
            self._record(actions)

    def repeat_set(self, why: str) -> None:
        run = self.flying
        if run is not None and (actions := self._gate(run.again(why))):
            self._record(actions)

    def halt_run(self) -> None:
        self.run = None
        self.watch.started, self.watch.fences = None, ()
        self.watch.blind_since = None

    def _stop(self, why: str) -> tuple[Action, ...]:
        self.stop_at, self.stopped_at = self.now + REPEAT_STOP, None
        self.watch.set_sent(None)
        return (Action(Order.STOP, why),)

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
    def _rests(self) -> bool:
        """Whether the state is one in which everything is stopped."""
        return self.region == IDLE or self.active in (STOPPED, SURFACED, MANUAL_WAITING)

    def doubt_stop(self) -> None:
        """Stops again if a report shows a thruster on after an acknowledged stop, in a state where
        everything is stopped. An acknowledgement alone proves nothing."""
        if self.stopped_at is not None and self._rests and self.watch.turning(self.stopped_at):
            self.doubted_at = self.now
            seen = "it has way" if self.vehicle.drives else "a thruster turns"
            self._record(self._stop(f"{self.reason}: {seen} after it was stopped"))

    def doubt_line(self) -> None:
        """Sends again, after the line to the vehicle was away, a stop that was acknowledged, the
        leg's set, or an ascent's way: another board may have acknowledged it, or nobody heard it.
        Words of the stick are sent all the time anyway."""
        self.outputs.doubt()
        run = self.flying
        ascent = run.ascent if run is not None and run.climbing else self.ascent
        if ascent is not None:
            ascent.doubt()
            self._record((Action(ascent.way, f"{ascent.why}: the line to the vehicle was away"),))
        elif self._rests and self.stopped_at is not None:
            self._record(self._stop(f"{self.reason}: the line to the vehicle was away"))
        else:
            self.repeat_set("the line to the vehicle was away: the whole set again")

    def stop_in(self, name: str, state: str, why: str, by: By = By.LIMIT) -> None:
        """emergency/stopped or surfaced; ``name`` as for ``surface``."""
        self._to_emergency()
        self.doubted_at = -math.inf
        self.vehicle_state.rising_since = None
        self._move(name, state, why, self._stop(why), by)

    def surface(
        self, name: str, why: str, by: By, evaluations: tuple[Evaluation, ...] = ()
    ) -> None:
        """emergency/surfacing, from anywhere; ``name`` is the row of the region table. An ascent
        that is under way, or that a leg has begun, goes on: to begin it anew would undo what it has
        found out. An operator's W leaves as it is, and behind it the way in use. Where that is not
        W it does so once a turn: said again and again it would keep that way from the board."""
        run, vehicle_state = self.flying, self.vehicle_state
        sinking = name == "limit" and self._rests
        self._sank = self._sank or (sinking and self.active == SURFACED)
        begun = self.ascent if self.active == SURFACING else None
        if run is not None and run.climbing and by is By.LIMIT:
            begun = run.ascent
        self._to_emergency()
        self.stop_at = self.stopped_at = None
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
        )
        way = self.ascent.way
        said = by is By.OPERATOR and (way is Order.SURFACE or self.ascent.hear(self.now))
        words = [Order.SURFACE] * (said and way is not Order.SURFACE) + [way] * (said or not begun)
        self._move(name, SURFACING, why, tuple(Action(w, why) for w in words), by, evaluations)

    def _to_emergency(self) -> None:
        """Ends the mission; from here the operator has to clear, or to take the stick."""
        self.ascent = self.deep_reports = None
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
        """Goes on with the emergency's ascent, or ends it at the surface."""
        if self.ascent is None:
            return
        now, depth, overturned, doubtful = self.vehicle_state.seen_rising
        if not self.vehicle_state.surfaced(self.ascent.began):
            if actions := self.ascent.act(now, depth, overturned, doubtful):
                self._record(actions)
        elif self._sank and (lift := self.ascent.lifts(now, depth, overturned or doubtful)):
            self._record(lift)
        elif self.ascent.is_up(now):
            why = f"{self.reason}; at the surface"
            if held := self._sank and self.ascent.pushes_up:
                why = f"{why}, and held up: it sank when it was let go"
                self.stop_at = self.stopped_at = None  # of an earlier turn of the ascent
            self.let_go_at = -math.inf if held else self.now
            stop = () if held else self._stop("the surface is reached")
            self._move("surfaced", SURFACED, why, stop, None)
            self.ascent = None

    def mind_rest(self) -> None:
        """Looks, with each report, for a vehicle that sinks although everything is stopped, or that
        stays deep after X; brings it up, each time that happens (R7)."""
        kind = ("stopped" if self.active == STOPPED else "rest") if self._rests else ""
        if kind != self.rested:
            self.rested = kind
            proved = self.active == SURFACED and self.let_go_at > -math.inf
            unseen = self.vehicle_state.depth is None and not proved
            self.rest.begin(SURFACE_DEPTH if proved else math.nan, unseen=unseen)
        report = self.vehicle_state.telemetry
        if not kind or report is None:
            return
        state, surfaced = self.vehicle_state, self.active == SURFACED
        self.rest.take(report.t, state.depth, DEEP_AGAIN if surfaced else DEEP)
        unsure = state.depth is None and not state.receiver.settled(report.t)
        self.rest.follow(report.t, state.moving_depth if unsure else None)
        stays = self.rest.stays_down() if kind == "stopped" or self.rest.unseen else ""
        why = stays if kind == "stopped" else self.rest.sinks or stays
        if (why := why or self.rest.goes_down or self._goes_under) and self.auto:
            self.surface("limit", why, By.LIMIT)

    @property
    def _goes_under(self) -> str:
        """Why it is taken to sink though no depth is believed, "" if it is not: the fixes that
        proved the surface have ended since it was let go, or say no new place any more."""
        state, let_go = self.vehicle_state, self.now - self.let_go_at
        if state.depth is not None or let_go > UNSEEN or self.active != SURFACED:
            return ""
        receiver, longest = state.receiver, let_go + SETTLED
        for missing, since, ended in (
            ("fix", receiver.quiet(self.now), ENDED),
            ("new place", receiver.no_news(self.now), RECENT),
        ):
            if since is not None and ended <= since <= longest:
                said = f"no {missing} for {since:.0f} s since it was let go"
                return f"{said}, and no depth is believed"
        return ""

    def take_stick(self) -> None:
        """Enters manual/driving; a mission stays where it was interrupted."""
        self.ascent = self.stop_at = self.stopped_at = None
        self._sank = False
        self.watch.set_sent(None)
        self.vehicle_state.rising_since = None
        self._move("stick", MANUAL_DRIVING, "the stick was moved", (), By.OPERATOR)

    def stick_silent(self) -> None:
        back = f"{self.manual_ends} with " if self.manual_ends else ""
        why = f"no M for 2 s: {back}everything stopped"
        self._move("silent", MANUAL_WAITING, why, self._stop(why), None)

    def stick_forgotten(self) -> None:
        """Ends manual a minute after the last M: idle at the surface; surfacing where it is deeper,
        or where the depth is not known, once AUTO is open: until then nothing turns by itself."""
        depth = self.vehicle_state.depth
        if depth is None or depth >= SURFACE_DEPTH:
            seen = "the depth is not known" if depth is None else f"{depth:.1f} m deep"
            if self.auto:
                self.surface("forgotten", f"no M for a minute, and {seen}", By.LIMIT)
            return
        self.halt_run()
        self.emergency_since_idle = False
        target = IDLE_READY if self.chart else IDLE_EMPTY
        self._move("forgotten", target, "no M for a minute, at the surface", (), None)

    def auto_off(self) -> None:
        """Ends the mission when node AUTO is closed (R13); in autonomous everything is stopped."""
        why = "node AUTO was closed"
        if self.region == AUTONOMOUS:
            self._move("auto off", IDLE_READY, why, self._stop(why), By.OPERATOR)
            self.halt_run()
        elif self.region == MANUAL:
            self.halt_run()

    def limit(self, row: Limit) -> None:
        why = f"limit {row.name}: {row.why(self.watch)}"
        seen = (Evaluation(f"limit {row.name}", True, (("depth", self.vehicle_state.depth),)),)
        self.surface("limit", why, By.LIMIT, seen)

    def take_uncertain(self, row: Limit) -> None:
        """Follows the mission's ``on uncertain``, once each time the position becomes uncertain."""
        run = self.flying
        if run is None or self.uncertain or run.leaf == IMPLICIT_SURFACE:
            return
        self.uncertain = True
        edge = run.uncertain()
        if edge is not None:
            seen = Evaluation(
                f"limit {row.name}", True, (("range", run.value("range", self.vehicle_state)),)
            )
            self.reason = f"limit {row.name}: {row.why(self.watch)}"
            self.follow(edge, (seen,))

    def take_outcome(self, outcome: Outcome) -> None:
        """Takes in what became of a frame: counts lost ones, notes acknowledged stops, and refused,
        late or lost sets."""
        watch, run = self.watch, self.flying
        if outcome.result is not Result.LATE:
            watch.lost = watch.lost + 1 if outcome.result is Result.LOST else 0
        if outcome.command is Order.STOP and outcome.result is Result.ACCEPTED:
            self.stop_at, self.stopped_at = None, self.now
        if outcome.command != watch.sent or run is None or run.sent is None:
            return
        if outcome.result is Result.ACCEPTED:
            watch.accepted_at = self.now
        elif outcome.result in (Result.REFUSED, Result.LATE):
            run.refused = True
        else:
            self.repeat_set("no answer to one of its frames: the whole set again")
