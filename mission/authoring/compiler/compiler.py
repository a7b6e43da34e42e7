"""Compile a Mission to a Chart: plain tables that the machine, the check and the graph read.

    names -> ways (next leg, targets, rounds) -> edges -> complete sets -> problems

Rules: an exit without a target leads to the next leg in order. At the end of a repeated group there
is one edge for another round and one that leaves the group. The implicit leg ``surface`` ends the
mission. Bare lines are not states: the ways through them carry their settings. All problems of a
mission are reported at once.

MissionErrors             (the mission's author must act; every one has line and column)

What does not live here: the order of legs (ways), the values of each leg (axes), what a vehicle
can do (abilities), the proofs over time, place and energy (check), running (machine, engine).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from mission.authoring.compiler.abilities import guard_problems, leg_problems
from mission.authoring.compiler.axes import (
    Flow,
    Resolution,
    statement_problems,
)
from mission.authoring.compiler.granularity import BETWEEN_STEPS
from mission.authoring.compiler.outputs import (
    complete,
    fight_problems,
    output_problems,
    outputs_of,
    sources_of,
)
from mission.authoring.compiler.parts import parts_fault
from mission.authoring.compiler.refusing import refused
from mission.authoring.compiler.ways import Way, Ways
from mission.legs import LEGS, Surface
from mission.model import (
    AUTONOMOUS,
    IDLE_READY,
    IMPLICIT_SURFACE,
    SURFACE,
    By,
    Chart,
    Edge,
    Exit,
    Group,
    Guard,
    Handler,
    Leg,
    Mission,
    State,
    Where,
    legs_of,
    terms,
)
from mission.model.diagnostics import Diagnostic, MissionErrors, ordered
from mission.model.extent import WATCHED
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint


@dataclass(frozen=True, slots=True)
class Compiled:
    """The result of the compiler. ``chart`` is None if the ways between the legs are not known; it
    may be flown only if no problem was ``found``."""

    chart: Chart | None
    found: tuple[Diagnostic, ...]


def compiled(mission: Mission, vehicle: Vehicle, digest: str) -> Compiled:
    return _Compiler(mission, vehicle).compiled(digest)


def compile_mission(mission: Mission, vehicle: Vehicle, digest: str) -> Chart:
    """Compile a mission. Raises MissionErrors with all problems."""
    made = compiled(mission, vehicle, digest)
    if made.found or made.chart is None:
        raise MissionErrors(made.found)
    return made.chart


# Problems that leave unknown which leg leads where.
_LEADING = frozenset(
    {
        "ambiguous-target",
        "loop-without-wait",
        "name-reserved",
        "name-twice",
        "no-leg",
        "repeat",
        "too-deep-nesting",
        "unknown-target",
    }
)


class _Compiler:
    def __init__(self, mission: Mission, vehicle: Vehicle) -> None:
        self._mission, self._vehicle = mission, vehicle
        self._ways = Ways(mission)
        self._states, self._legs = self._ways.states, self._ways.legs
        self._problems = self._ways.problems
        self._edges: list[Edge] = []
        self._flows: list[Flow] = []
        self._levels: dict[str, dict[str, float]] = {}  # path of a leg -> its outputs

    def compiled(self, digest: str) -> Compiled:
        for line in self._ways.lines:
            self._problems += statement_problems(line)
            self._problems += output_problems(line, self._vehicle)
        for leg in legs_of(self._mission.body):
            if why := parts_fault(leg):
                self._refuse("parts", leg.where, f"{leg.name}: {why}")
        start = self._ways.start
        if start.target == IMPLICIT_SURFACE:
            self._refuse("no-leg", self._mission.where, "the mission has no leg that lasts")
        for path, leg in self._legs.items():
            self._leg_edges(path, leg)
        for state in self._states:
            if state.group is not None:
                self._handler_edges(state.path, state.group)
        self._mission_edges()
        self._check_watched()
        sets = self._resolve(start)
        found = ordered(self._problems)
        if not _LEADING.isdisjoint(p.code for p in found):
            return Compiled(None, found)
        states, edges = self._placed(sets), tuple(self._edges)
        sources = sources_of(edges, self._vehicle)
        chart = Chart(self._mission, digest, states, edges, start.target, sources)
        return Compiled(chart, found)

    # --- edges -----------------------------------------------------------------------------

    def _leg_edges(self, path: str, leg: Leg) -> None:
        group, follow = self._ways.group_of(path), self._ways.after(path)
        row = LEGS[type(leg.kind)]
        for i, leave in enumerate(leg.exits, start=1):
            self._check_guard(leave.guard, leave.where, row.gives)
            target = leave.target
            ways = self._ways.to(group, target, leave.where) if target else follow
            self._connect(f"{path}:until{i}", path, ways, By.UNTIL, leave.where, leave.guard)
        stays_up = row.ascends and leg.duration is not None and not row.awaits_fix(leg.kind)
        if row.ends and not stays_up:
            self._connect(f"{path}:end", path, follow, By.END, leg.where)
        if leg.duration is not None:
            self._connect(f"{path}:for", path, follow, By.FOR, leg.where)
        otherwise = self._ways.to(
            group if leg.otherwise else AUTONOMOUS,
            leg.otherwise or self._mission.on_timeout,
            leg.where,
        )
        if leg.timeout is not None:
            self._connect(f"{path}:timeout", path, otherwise, By.TIMEOUT, leg.where)
        self._connect(f"{path}:else", path, otherwise, By.ELSE, leg.where)

    def _handler_edges(self, path: str, holder: Group | Mission) -> None:
        for i, handler in enumerate(holder.handlers, start=1):
            self._check_guard(handler.guard, handler.where, None)
            ways = self._ways.to(path, handler.target, handler.where)
            self._connect(f"{path}:on{i}", path, ways, By.ON, handler.where, handler.guard)

    def _mission_edges(self) -> None:
        mission = self._mission
        self._handler_edges(AUTONOMOUS, mission)
        ways = self._ways.to(AUTONOMOUS, mission.on_uncertain, mission.where)
        self._connect(f"{AUTONOMOUS}:uncertain", AUTONOMOUS, ways, By.UNCERTAIN, mission.where)
        self._edges.append(Edge(f"{IMPLICIT_SURFACE}:end", IMPLICIT_SURFACE, IDLE_READY, By.END))

    def _connect(
        self,
        trigger: str,
        source: str,
        ways: tuple[Way, ...],
        by: By,
        where: Where,
        guard: Guard | None = None,
    ) -> None:
        for i, way in enumerate(ways):
            name = f"{trigger}.{i + 1}" if len(ways) > 1 else trigger
            self._edges.append(Edge(name, source, way.target, by, guard, way.loops, where))
            if way.target != IMPLICIT_SURFACE:
                self._flows.append(Flow(source, way.target, way.unit))

    def _check_guard(self, guard: Guard, where: Where, gives: frozenset[str] | None) -> None:
        self._problems += guard_problems(guard.expression, self._vehicle, where, gives)

    def _check_watched(self) -> None:
        """Limit the comparisons that a leg and its groups watch; each costs time in every step of
        the engine."""
        handled = {AUTONOMOUS: _watched(self._mission.handlers)}
        for state in self._states:
            above = handled[state.parent]
            if state.group is not None:
                handled[state.path] = above + _watched(state.group.handlers)
            elif state.leg and above + _watched(state.leg.exits) > WATCHED.most:
                leg, hint = state.leg, "use fewer, or part the leg"
                self._refuse("too-long", leg.where, WATCHED.exceeded, hint)
                return

    # --- sets ------------------------------------------------------------------------------

    def _resolve(self, start: Way) -> dict[str, Setpoint]:
        parents = {state.path: state.parent for state in self._states}
        first = Flow("", start.target, start.unit)
        outputs = outputs_of(self._mission)
        resolution = Resolution(self._legs, parents, self._flows, first, outputs)
        sets, problems = resolution.setpoints()
        self._problems += problems
        self._levels = resolution.levels()
        told: set[str] = set()  # a value that several legs keep is reported once, where it is set
        for path, leg in self._legs.items():
            self._problems += fight_problems(leg, sets[path], self._levels[path], self._vehicle)
            for problem in leg_problems(leg, sets[path], self._vehicle):
                kept = problem.code == BETWEEN_STEPS and problem.where == leg.where
                if not (kept and problem.message in told):
                    self._problems.append(problem)
                told.add(problem.message)
        return sets

    def _placed(self, sets: dict[str, Setpoint]) -> tuple[State, ...]:
        names, vehicle = outputs_of(self._mission), self._vehicle
        end = State(IMPLICIT_SURFACE, AUTONOMOUS, Leg(SURFACE, Surface()), Setpoint())
        legs = [replace(s, setpoint=sets[s.path]) if s.leg else s for s in self._states]
        return tuple(complete(s, names, self._levels, vehicle) for s in (*legs, end))

    def _refuse(self, code: str, where: Where, message: str, hint: str = "") -> None:
        self._problems.append(refused(code, where, message, hint))


def _watched(guarded: Iterable[Exit | Handler]) -> int:
    return sum(1 for each in guarded for _ in terms(each.guard.expression))
