"""The engine's actions on a mission: begin it, enter its legs, send their sets, end it.

Every command sent is recorded in a Step, with its reason. A set beyond the limits is not sent.

What does not live here: emergencies, the stick, rest (core), what a leg asks for (run).
"""

from __future__ import annotations

import math

from mission.engine.areas import fences
from mission.engine.bounds import admit
from mission.engine.clearance import Clearance
from mission.engine.limits import Limit
from mission.engine.run import Run
from mission.engine.state import EngineState, Moved
from mission.model import (
    IDLE_READY,
    IMPLICIT_SURFACE,
    Action,
    By,
    Chart,
    Edge,
    Evaluation,
)
from protocol.messages import Order, Setpoint

REPEAT_STOP = 0.5  # s (R7)


class Flying(EngineState):
    def begin(self, chart: Chart) -> None:
        """Start the mission at its first leg."""
        clearance = Clearance.of(chart.mission, self.vehicle)
        self.run = Run(chart, self.now, self.ways, clearance)
        self.watch.started = self.now
        self.watch.fences = fences(chart.mission.areas, self.vehicle_state.place)
        self._fly("mission started", chart.initial)

    def resume(self, run: Run) -> None:
        """Enter the interrupted leg from its beginning. Rounds and the mission's clock continue."""
        self._fly("mission resumed", run.leaf)

    def _fly(self, why: str, leaf: str) -> None:
        """Enter a leg from idle or manual, with the run's history (a new run has none)."""
        assert self.run is not None
        self.watch.begin(self.now)
        self.stop_at = self.stopped_at = None
        self.let_go_at = -math.inf
        self.reason = why
        moved = self.machine.move("start", leaf)
        self._enter(leaf, moved, "start", None, (), history=True)

    def follow(self, edge: Edge, evaluations: tuple[Evaluation, ...]) -> None:
        """Follow an edge of the mission, to another leg or to the mission's end."""
        assert self.run is not None
        if edge.target == IDLE_READY:
            moved = self.machine.fire(edge.trigger)
            self.halt_run()
            self.let_go_at = self.now
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
        """Enter a leg as if its set had been sent and acknowledged; nothing is sent."""
        assert self.run is not None
        self._gate(self.run.enter(leaf, (), self.vehicle_state, history=True))
        self.watch.accepted_at = self.now

    def _gate(self, actions: tuple[Action, ...]) -> tuple[Action, ...]:
        """Return the actions that may be sent. A set beyond the limits counts as refused by the
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
        if self.run is None or not self.run.at_surface:
            self.stop_at = self.stopped_at = None
            self.let_go_at = -math.inf
        elif passed:
            self.stop_at, self.stopped_at = self.now + REPEAT_STOP, None
            self.let_go_at = self.now
        return tuple(passed)

    def say(self, action: Action) -> None:
        """Send a command that does not affect the motion."""
        self._record((action,))

    def fly_on(self) -> None:
        """Send what the active leg has to send now."""
        run = self.flying
        if run is not None and (actions := self._gate(run.steer(self.vehicle_state))):
            self._record(actions)

    def repeat_set(self, why: str) -> None:
        run = self.flying
        if run is not None and (actions := self._gate(run.again(why))):
            self._record(actions)

    def halt_run(self) -> None:
        if self.run is not None and self.run.at_surface:
            self.let_go_at = self.now
        self.run = None
        self.watch.started, self.watch.fences = None, ()
        self.watch.blind_since = None

    def take_uncertain(self, row: Limit) -> None:
        """Follow the mission's ``on uncertain``, once each time the position becomes uncertain.
        It does not act in the leg that it leads to."""
        run = self.flying
        if run is None or self.uncertain or run.leaf == IMPLICIT_SURFACE:
            return
        edge = run.uncertain()
        if edge is not None:
            self.uncertain = True
            seen = Evaluation(
                f"limit {row.name}", True, (("range", run.value("range", self.vehicle_state)),)
            )
            self.reason = f"limit {row.name}: {row.why(self.watch)}"
            self.follow(edge, (seen,))

    def _stop(self, why: str) -> tuple[Action, ...]:
        self.stop_at, self.stopped_at = self.now + REPEAT_STOP, None
        self.watch.set_sent(None)
        return (Action(Order.STOP, why),)
