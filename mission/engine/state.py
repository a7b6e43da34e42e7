"""The engine's state, and the two ways to record a Step: with a transition, or without one.

What does not live here: what the engine can do with it (core), when that is due (engine).
"""

from __future__ import annotations

import math
from typing import Self

from mission.engine.ascent import Ascent, Way
from mission.engine.bounds import in_force
from mission.engine.machine import Machine
from mission.engine.monitor import LimitMonitor
from mission.engine.navigator import Navigator
from mission.engine.outputs import OutputKeeper
from mission.engine.rest import Hold, Rest
from mission.engine.run import Run
from mission.engine.vehicle_state import VehicleState
from mission.engine.words import in_words
from mission.model import AUTONOMOUS, Action, By, Chart, Evaluation, Step
from mission.model.copies import copied
from mission.model.regions import IDLE
from mission.model.vehicle import Vehicle
from protocol.messages import Order, Setpoint, SetSafety
from protocol.vehicles import vehicle_row

Moved = tuple[tuple[str, ...], tuple[str, ...]]  # states left, states entered


class EngineState:
    def __init__(self, vehicle: Vehicle, navigation: Navigator | None) -> None:
        self.vehicle = vehicle
        self.vehicle_state = VehicleState(
            navigation,
            grounded=vehicle.drives,
            stale_after=vehicle.stale_after,
            rise=vehicle.ascent_buoyancy,
            sink=vehicle.limits.descent_rate,
            deepest=vehicle.limits.depth,
        )
        row = vehicle_row(vehicle.codec)
        self.ways, self.manual_ends = row.ways, row.manual_ends
        self.machine = Machine()
        self.chart: Chart | None = None
        self.operator = SetSafety()
        self.watch = LimitMonitor(
            vehicle, self.vehicle_state, in_force(vehicle, None, self.operator)
        )
        self.run: Run | None = None  # also while the stick interrupts it
        self.ascent: Ascent | None = None  # the emergency's, only in emergency/surfacing
        self.stop_at: float | None = None  # X0 is sent again then, unless it was acknowledged
        self.stopped_at: float | None = None  # when a stop still in force was acknowledged
        self.doubted_at = -math.inf  # when a report last contradicted a stop, since the last X
        self.stick = -math.inf  # the last M that was obeyed
        self.any_stick = -math.inf  # the last M of anybody, obeyed or not (R6)
        self.push_at: float | None = None  # when the push began that may take an emergency over
        self.push_words = 0  # M in its first moments
        self.clear_refused = -math.inf  # the last @AC that was refused where it may be repeated
        self.outputs = OutputKeeper(vehicle.outputs)
        self.rest = Rest(vehicle.limits.descent_rate)
        self.rested = "rest"  # the kind of rest that is watched; "" while it is under way
        self.moved_blind = False  # no depth was believed at the last change of state
        self._sank = False  # it sank in surfaced: let go, it would sink again
        self.let_go_at = -math.inf  # when an ascent last ended with everything stopped
        self.hold: Hold | None = None  # in surfaced: holds up a vehicle that sank when let go
        self.push: Way | None = None  # the way that held up when a thruster last showed on
        self.neutral = 0  # times in succession that no thruster showed on while held up
        self.auto = True  # node AUTO
        self.emergency_since_idle = False
        self.emergency_at = -math.inf  # when the last one began
        self.ending_since: float | None = None  # the program is to end
        self.out_of_time = False  # the program's last commands were due
        self.deep_since: float | None = None  # while unknown what was under way; inf: not deep
        self.uncertain = False  # answered; again only after the position was certain in between
        self.reason = ""  # of the active state
        self.event = ""
        self.actions: list[Action] = []
        self.steps: list[Step] = []

    def clone(self) -> Self:
        """For snapshots: without the machine and the navigation, which have their own."""
        state = self.vehicle_state.clone()
        return copied(
            self,
            machine=self.machine,
            vehicle_state=state,
            watch=self.watch.clone(state),
            actions=[],
            steps=[],
        )

    @property
    def now(self) -> float:
        return self.vehicle_state.now

    @property
    def region(self) -> str:
        return self.machine.region

    @property
    def active(self) -> str:
        return self.machine.active

    @property
    def flying(self) -> Run | None:
        """The run, while it is not interrupted."""
        return self.run if self.machine.region == AUTONOMOUS else None

    @property
    def leg_ascent(self) -> Ascent | None:
        """The ascent of the active leg, until it has reached the surface."""
        run = self.flying
        return run.ascent if run is not None and run.climbing else None

    # --- records -------------------------------------------------------------------------------

    def _record(
        self,
        actions: tuple[Action, ...],
        moved: Moved = ((), ()),
        *,
        trigger: str = "",
        by: By | None = None,
        evaluations: tuple[Evaluation, ...] = (),
    ) -> None:
        words = tuple(f"{in_words(a.command)}: {a.reason}" for a in actions)
        self.steps.append(
            Step(self.now, self.event, evaluations, moved[0], moved[1], words, trigger, by)
        )
        for action in actions:
            if isinstance(action.command, Setpoint | Order):
                self.vehicle_state.word = action.command
        self.actions += actions
        if moved[1] and (self.region != IDLE or IDLE in moved[1]):  # not for a load within idle
            self.moved_blind = self.vehicle_state.depth is None

    def _move(
        self,
        name: str,
        target: str,
        why: str,
        actions: tuple[Action, ...],
        by: By | None,
        evaluations: tuple[Evaluation, ...] = (),
    ) -> None:
        was_flying = self.region == AUTONOMOUS
        moved = self.machine.move(name, target)
        self.reason = why
        left = by if was_flying else None
        self._record(actions, moved, trigger=name, by=left, evaluations=evaluations)
