"""The engine: step(now, inputs) -> outputs. No IO, no clock, no threads.

Order within one step:

    reports -> X and W -> other commands -> limits -> handlers, exits, timeouts -> steering

Each call takes all transitions that are due (one macrostep), at most 200; the next call takes the
rest. The caller gives the time. ``next_timer`` tells when to call again if no input comes.

What does not live here: the actions (core), operators' commands (orders), limits (limits, monitor),
the mission under way (run), bytes, retries and channels (onboard.runtime).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mission.engine import ending
from mission.engine.auxiliary import mind_outputs
from mission.engine.bounds import Bounds
from mission.engine.core import Core
from mission.engine.limits import Limit, Response
from mission.engine.machine import Machine
from mission.engine.navigator import Navigator
from mission.engine.orders import STICK_QUIET, obey, why_not_clear
from mission.engine.readings import Scope
from mission.engine.restart import begin_again, doubt, under_way
from mission.engine.variables import VARIABLES, reading_of, reading_row
from mission.engine.words import event_of, short
from mission.model import (
    AUTONOMOUS,
    MANUAL_DRIVING,
    Action,
    AutoNode,
    By,
    Chart,
    Ending,
    Estimate,
    LineOpened,
    Loaded,
    Outcome,
    Reading,
    Restarted,
    Step,
    Verdict,
)
from mission.model.regions import MANUAL
from mission.model.vehicle import Vehicle
from protocol.messages import (
    Aid,
    Command,
    Emergency,
    Fix,
    SetSafety,
    Telemetry,
)

MICROSTEPS = 200
GOES_ON = 0.1  # s after a step of MICROSTEPS transitions, until the step that takes the rest
FORGOTTEN = 60.0  # s without M, until manual ends (R6)

Input = (
    Telemetry | Fix | Aid | Outcome | Loaded | AutoNode | LineOpened | Restarted | Ending | Command
)


@dataclass(frozen=True, slots=True)
class Outputs:
    """Results of a step. ``verdicts``: one per operator's command, in the commands' order."""

    actions: tuple[Action, ...] = ()
    steps: tuple[Step, ...] = ()
    verdicts: tuple[Verdict, ...] = ()


NOTHING = Outputs()


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything that decides what the engine does next. Opaque; may be restored many times."""

    core: Core
    active: str
    machine: Machine
    navigation: Any


class Engine:
    """One vehicle's engine. ``navigation`` may be attached later; no mission starts before it."""

    def __init__(
        self,
        vehicle: Vehicle,
        navigation: Navigator | None = None,
        *,
        forgotten_after: float = FORGOTTEN,
    ) -> None:
        self.core = Core(vehicle, navigation)
        self._forgotten_after = forgotten_after
        self._timer: float | None = None

    def attach(self, navigation: Navigator) -> None:
        self.core.vehicle_state.navigation = navigation

    def limit_topside_silence(self, seconds: float | None) -> None:
        """Set the ``topside`` limit (R5): s without a frame from an operator; None: off."""
        self.core.watch.topside_silence = seconds

    def hear_stick(self, now: float) -> None:
        """Note a refused M (R6), refused by the engine or before it. It ends any push."""
        if self.core.any_stick != now:
            self.core.any_stick, self.core.push_at = now, None

    def hear_topside(self, now: float) -> None:
        """Note that an operator sent a good frame."""
        self.core.watch.topside_heard = now

    def step(self, now: float, inputs: Sequence[Input] = ()) -> Outputs:
        """Advance to ``now`` (s) with these inputs, in any state. ValueError if time goes back."""
        core = self.core
        if now < core.vehicle_state.now:
            raise ValueError(f"time went back from {core.vehicle_state.now} to {now}")
        core.actions, core.steps = [], []
        core.vehicle_state.at(now)
        core.event = event_of(inputs)
        core.excuse_descent()
        reported, fixed, told = self._hear(inputs)
        verdicts = self._obey(inputs) if told else ()
        self._guard_limits(reported, fixed)
        self._run_mission()
        self._mind_stick()
        if reported:
            doubt(core)
        if core.ending_since is not None:
            ending.go_on(core)
        core.climb()
        core.fly_on()
        if reported:
            core.mind_rest()
            core.doubt_stop()
        core.mind_fixes()
        core.stop_again()
        mind_outputs(core)
        self._timer = self._next_timer()
        if not (core.actions or core.steps or verdicts):
            return NOTHING
        return Outputs(tuple(core.actions), tuple(core.steps), tuple(verdicts))

    # --- the parts of a step, in their order ---------------------------------------------------

    def _hear(self, inputs: Sequence[Input]) -> tuple[bool, bool, bool]:
        """Take in reports, fixes and outcomes. Return whether there were reports, fixes, and
        other inputs, which ``_obey`` handles."""
        core = self.core
        reported = fixed = told = False
        for one in inputs:
            if isinstance(one, Telemetry):
                core.vehicle_state.take_telemetry(one)
                core.watch.take_report()
                reported = True
            elif isinstance(one, Fix):
                core.vehicle_state.take_fix(one)
                fixed = True
            elif isinstance(one, Aid):
                core.vehicle_state.take_aid(one)
            elif isinstance(one, Outcome):
                core.take_outcome(one)
            else:
                told = True
        if (reported or fixed) and (run := core.flying) is not None:
            run.reckon(core.vehicle_state)
        return reported, fixed, told

    def _obey(self, inputs: Sequence[Input]) -> list[Verdict]:
        """Obey X and W before all others. Verdicts come in the order of the inputs."""
        core = self.core
        given: dict[int, Verdict] = {}
        for i, one in enumerate(inputs):
            if isinstance(one, Emergency):
                given[i] = obey(core, one)
        for i, one in enumerate(inputs):
            if isinstance(one, Loaded):
                if core.run is None:
                    core.load(one.chart)
            elif isinstance(one, AutoNode):
                self._switch_auto(one)
            elif isinstance(one, LineOpened):
                core.doubt_line()
            elif isinstance(one, Restarted):
                begin_again(core, one)
            elif isinstance(one, Ending):
                ending.begin(core, one)
            elif i not in given and not isinstance(one, Telemetry | Fix | Aid | Outcome):
                given[i] = obey(core, one)
        return [given[i] for i in sorted(given)]

    def _switch_auto(self, node: AutoNode) -> None:
        if self.core.auto and not node.open:
            self.core.auto_off()
        self.core.auto = node.open

    def _guard_limits(self, reported: bool, fixed: bool) -> None:
        core = self.core
        found = core.watch.look(reported, fixed)
        if reported and not any(row.response is Response.UNCERTAIN for row in found):
            core.uncertain = False
        if not found:
            return
        for row in sorted(found, key=lambda r: r.response is not Response.SURFACING):
            if not self._acts(row):
                continue
            if row.response is Response.UNCERTAIN:
                core.take_uncertain(row)
            elif row.response is Response.REPEAT and not core.watch.repeated:
                core.watch.repeated = True
                core.watch.forgive(row)
                core.repeat_set(f"limit {row.name}: {row.why(core.watch)}")
            else:
                core.limit(row)

    def _acts(self, row: Limit) -> bool:
        """Whether the limit acts in this state. Outside a mission none acts while node AUTO is
        closed: no thruster may start by itself."""
        core = self.core
        if core.region == AUTONOMOUS:
            return AUTONOMOUS in row.acts
        return core.auto and not row.acts.isdisjoint((core.region, core.active))

    def _run_mission(self) -> None:
        core, been = self.core, set[tuple[object, ...]]()
        for _ in range(MICROSTEPS):
            run = core.flying
            if run is None or (found := run.look(core.vehicle_state)) is None:
                return
            core.follow(*found)
            been.add((core.active, *run.rounds.values()))
        if (run := core.flying) is not None and len(been) < MICROSTEPS:
            core.surface("limit", f"{MICROSTEPS} legs in circles at {short(core.active)}", By.LIMIT)
        elif run is not None:
            run.wake = core.now + GOES_ON

    def _mind_stick(self) -> None:
        core = self.core
        if core.region != MANUAL:
            return
        if core.active == MANUAL_DRIVING and core.now >= core.stick + STICK_QUIET:
            core.stick_silent()
        if core.now >= core.stick + self._forgotten_after:
            core.stick_forgotten()

    # --- time ------------------------------------------------------------------------------------

    def next_timer(self) -> float | None:
        """When ``step`` is due if no input comes before; always later than the last step."""
        return self._timer

    def _next_timer(self) -> float | None:
        core = self.core
        due: list[float | None] = [core.stop_at, core.rest_due(), core.outputs.next_timer()]
        if (run := core.flying) is not None:
            due += run.next_timer(core.vehicle_state)
            due.append(core.watch.next_timer())
        elif core.region == MANUAL:
            due.append(core.stick + self._forgotten_after)
            if core.active == MANUAL_DRIVING:
                due.append(core.stick + STICK_QUIET)
        if core.ascent is not None:
            due += [core.ascent.next_timer(), core.vehicle_state.surface_due(core.ascent.began)]
        now, first = core.now, None
        for at in due:
            if at is not None and at > now and (first is None or at < first):
                first = at
        return first

    # --- snapshots -------------------------------------------------------------------------------

    def snapshot(self) -> Snapshot:
        core, navigation = self.core, self.core.vehicle_state.navigation
        kept = navigation.snapshot() if navigation else None
        return Snapshot(core.clone(), core.active, core.machine, kept)

    def restore(self, snapshot: Snapshot) -> None:
        navigation = self.core.vehicle_state.navigation
        self.core = snapshot.core.clone()
        self.core.machine = snapshot.machine
        self.core.machine.restore(snapshot.active)
        self.core.vehicle_state.navigation = navigation
        if navigation and snapshot.navigation is not None:
            navigation.restore(snapshot.navigation)
        self._timer = self._next_timer()

    def place(self, leaf: str, rounds: Mapping[str, int], elapsed: float = 0.0) -> None:
        """Put the mission under way into this leg, as entered ``elapsed`` s ago, in these rounds
        (by group path): for checks that go through every configuration. LookupError without a
        mission."""
        run = self.core.run
        if run is None:
            raise LookupError("no mission is under way")
        self.core.machine.restore(leaf)
        run.rounds.update(rounds)
        self.core.enter_quietly(leaf)
        run.entered -= elapsed
        self._timer = self._next_timer()

    # --- state for operators and the runtime -----------------------------------------------------

    @property
    def state(self) -> str:
        """``region/substate``, or the path of the active leg."""
        return self.core.active

    @property
    def region(self) -> str:
        return self.core.region

    @property
    def leg(self) -> str:
        """The active or interrupted leg, without its region; "" if none."""
        return short(self.core.run.leaf) if self.core.run else ""

    @property
    def chart(self) -> Chart | None:
        return self.core.chart

    @property
    def estimate(self) -> Estimate | None:
        return self.core.vehicle_state.estimate

    @property
    def depth(self) -> float | None:
        """The reported depth, m; None while it is not believed."""
        return self.core.vehicle_state.depth

    @property
    def reason(self) -> str:
        """Why the engine is in this state."""
        return self.core.reason

    @property
    def safety(self) -> SetSafety:
        """The operator's limits (@SP), for the store."""
        return self.core.operator

    @property
    def bounds(self) -> Bounds:
        """The limits in force."""
        return self.core.watch.bounds

    @property
    def breaches(self) -> tuple[Limit, ...]:
        """Limits that are breached now, including those that are only reported in this state."""
        return self.core.watch.breaches

    @property
    def mission_time(self) -> float | None:
        """s since the start, manual time included; None without a mission under way."""
        return self.core.now - self.core.run.started if self.core.run else None

    @property
    def round(self) -> int:
        return self.core.run.round if self.core.run else 1

    def output(self, name: str) -> float | None:
        """The value last sent for this output; None if it is not known to be in force."""
        return self.core.outputs.told(name)

    @property
    def settled(self) -> bool:
        """Whether the program may end: the vehicle no longer needs it."""
        return ending.settled(self.core)

    @property
    def doubted_at(self) -> float:
        """When a report last contradicted a stop; -inf if none did since the last X."""
        return self.core.doubted_at

    @property
    def may_clear(self) -> bool:
        """Whether an @AC would be accepted now."""
        return not why_not_clear(self.core)

    @property
    def under_way(self) -> str:
        """What a restart would interrupt, for the store; "" if nothing."""
        return under_way(self.core)

    @property
    def readings(self) -> Mapping[str, Reading]:
        """All variables of guards, and the vehicle file's readings that the mission uses."""
        core, now = self.core, self.core.now
        seen = core.vehicle_state
        idle = now, now, 0.0, 1, lambda: None, None, seen.stale_after
        scope = core.run.scope(seen) if core.run else None
        scope = scope or Scope(now, seen.estimate, seen.telemetry, seen.health, *idle)
        told = core.chart.sources if core.chart is not None else ()
        rows = (*VARIABLES.values(), *(reading_row(*each) for each in told))
        return {row.name: reading_of(row, scope) for row in rows}
