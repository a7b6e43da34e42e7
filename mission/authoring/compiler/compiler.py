"""Mission -> Chart: plain tables that the machine, the check and the graph read.

    names -> ways (next leg, targets, rounds) -> edges -> complete sets -> problems

Rules: an exit without a target leads to the next leg in order; at the end of a repeated group
there is one edge for another round and one beyond it; at the mission's end is the implicit leg
``surface``. Bare lines are no states: their settings travel on the ways through them. All problems
of a mission are told at once.

MissionErrors             (the mission's author must act; every one has line and column)

What does not live here: how values travel (axes), what a vehicle can do (abilities), the proofs
over time, place and energy (check), running (machine, engine).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from mission.authoring.compiler.abilities import guard_problems, leg_problems
from mission.authoring.compiler.axes import (
    Flow,
    Resolution,
    Unit,
    joined,
    statement_problems,
    unit_of,
)
from mission.authoring.compiler.granularity import BETWEEN_STEPS
from mission.authoring.compiler.outputs import (
    complete,
    fight_problems,
    output_problems,
    outputs_of,
    sources_of,
)
from mission.authoring.compiler.parts import parted, parts_fault
from mission.authoring.compiler.refusing import refused
from mission.engine.guards import comparisons
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
    Loop,
    Mission,
    Node,
    Set,
    State,
    Where,
    legs_of,
)
from mission.model.diagnostics import Diagnostic, MissionErrors, ordered
from mission.model.extent import DEEPEST_GROUP, WATCHED
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint


@dataclass(frozen=True, slots=True)
class Compiled:
    """``chart`` is there where the ways between the legs are known; it is whole, and may be flown,
    where nothing was ``found`` to be wrong."""

    chart: Chart | None
    found: tuple[Diagnostic, ...]


def compiled(mission: Mission, vehicle: Vehicle, digest: str) -> Compiled:
    return _Compiler(mission, vehicle).compiled(digest)


def compile_mission(mission: Mission, vehicle: Vehicle, digest: str) -> Chart:
    """Raises MissionErrors with everything that is wrong."""
    made = compiled(mission, vehicle, digest)
    if made.found or made.chart is None:
        raise MissionErrors(made.found)
    return made.chart


@dataclass(frozen=True, slots=True)
class _Slot:
    """A place in the mission's order: ``index`` may be one beyond the group's last node."""

    group: str
    index: int


@dataclass(frozen=True, slots=True)
class _Way:
    loops: tuple[Loop, ...]
    target: str
    unit: Unit


# Where one of these is wrong, nobody knows which leg leads where.
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
        self._problems: list[Diagnostic] = []
        self._states: list[State] = []
        self._bodies: dict[str, tuple[Node, ...]] = {AUTONOMOUS: parted(mission.body)}
        self._repeat: dict[str, int] = {AUTONOMOUS: 1}
        self._slots: dict[str, _Slot] = {}  # path -> its place
        self._named: dict[str, list[str]] = {}  # name -> paths
        self._children: dict[tuple[str, str], str] = {}
        self._legs: dict[str, Leg] = {}
        self._edges: list[Edge] = []
        self._flows: list[Flow] = []
        self._ways: dict[_Slot, tuple[_Way, ...]] = {}
        self._levels: dict[str, dict[str, float]] = {}  # path of a leg -> its outputs

    def compiled(self, digest: str) -> Compiled:
        self._index()
        for leg in legs_of(self._mission.body):
            if why := parts_fault(leg):
                self._refuse("parts", leg.where, f"{leg.name}: {why}")
        start = self._ways_from(_Slot(AUTONOMOUS, 0))[0]
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

    # --- names and places ----------------------------------------------------------------

    def _index(self) -> None:
        stack = [(AUTONOMOUS, i, node) for i, node in enumerate(self._bodies[AUTONOMOUS])][::-1]
        while stack:
            parent, i, node = stack.pop()
            path = f"{parent}/{node.name}"
            if not self._take(parent, path, i, node):
                continue
            if isinstance(node, Group):
                self._states.append(State(path, parent, group=node))
                self._bodies[path], self._repeat[path] = node.body, node.repeat
                self._check_group(path, node)
                if path.count("/") <= DEEPEST_GROUP.most:
                    stack += [(path, j, child) for j, child in enumerate(node.body)][::-1]
            else:
                self._problems += statement_problems(node)
                self._problems += output_problems(node, self._vehicle)
                if isinstance(node, Leg):
                    self._states.append(State(path, parent, leg=node))
                    self._legs[path] = node

    def _take(self, parent: str, path: str, index: int, node: Node) -> bool:
        if node.name == SURFACE or "/" in node.name or not node.name:
            self._refuse(
                "name-reserved",
                node.where,
                f"{node.name!r} cannot be a name here",
                f"{SURFACE} is the leg at every mission's end; choose another name",
            )
            return False
        if path in self._slots:
            self._refuse(
                "name-twice",
                node.where,
                f"{node.name} appears twice in the same group",
                "choose another name",
            )
            return False
        self._slots[path] = _Slot(parent, index)
        self._children[parent, node.name] = path
        self._named.setdefault(node.name, []).append(path)
        return True

    def _check_group(self, path: str, group: Group) -> None:
        if group.repeat < 1:
            self._refuse("repeat", group.where, "a group has at least one round")
        elif group.repeat > 1 and not any(legs_of(group.body)):
            self._refuse(
                "loop-without-wait",
                group.where,
                f"{group.name} repeats without a leg that takes time",
                "add a wait or another leg",
            )
        if path.count("/") > DEEPEST_GROUP.most:
            self._refuse(
                "too-deep-nesting",
                group.where,
                f"groups stand inside each other more than {DEEPEST_GROUP.most} deep",
                "flatten them",
            )

    def _resolve_name(self, scope: str, name: str, where: Where) -> tuple[_Way, ...]:
        """The ways to a target, sought from the innermost group outward, then anywhere."""
        if name == SURFACE:
            return (_Way((), IMPLICIT_SURFACE, joined(())),)
        first, *rest = name.split("/")
        found = self._lookup(scope, first)
        for part in rest:
            found = self._children.get((found or "", part))
        if found is None:
            self._unknown_target(name, where)
            return ()
        if found in self._bodies:
            return self._ways_from(_Slot(found, 0))
        return self._ways_from(self._slots[found])

    def _lookup(self, scope: str, name: str) -> str | None:
        while True:
            found = self._children.get((scope, name))
            if found is not None or scope == AUTONOMOUS:
                break
            scope = self._slots[scope].group
        if found is None and len(self._named.get(name, ())) == 1:
            found = self._named[name][0]
        return found

    def _unknown_target(self, name: str, where: Where) -> None:
        several = self._named.get(name, [])
        if len(several) > 1:
            places = ", ".join(p.partition("/")[2] for p in several)
            self._refuse(
                "ambiguous-target",
                where,
                f"{name} could be any of {places}",
                "write its path",
            )
            return
        near = difflib.get_close_matches(name, [*self._named, SURFACE], n=3)
        hint = f"did you mean {', '.join(near)}?" if near else f"{SURFACE} is always there"
        self._refuse("unknown-target", where, f"there is no leg {name!r}", hint)

    # --- ways ------------------------------------------------------------------------------

    def _ways_from(self, slot: _Slot) -> tuple[_Way, ...]:
        known = self._ways.get(slot)
        if known is None:
            known = self._ways[slot] = tuple(self._find_ways(slot))
        return known

    def _find_ways(self, slot: _Slot) -> Iterator[_Way]:
        group, index = slot.group, slot.index
        loops: tuple[Loop, ...] = ()
        units: list[Unit] = []
        while True:
            target = self._first_leg(group, index, units)
            if target is not None:
                yield _Way(loops, target, joined(units))
                return
            if group == AUTONOMOUS:
                yield _Way(loops, IMPLICIT_SURFACE, joined(units))
                return
            if self._repeat[group] > 1:
                again = list(units)
                target = self._first_leg(group, 0, again)
                if target is not None:
                    yield _Way((*loops, Loop(group, True)), target, joined(again))
                loops = (*loops, Loop(group, False))
            group, index = self._slots[group].group, self._slots[group].index + 1

    def _first_leg(self, group: str, index: int, units: list[Unit]) -> str | None:
        """The first leg from there to the group's end; bare lines on the way go to ``units``."""
        body = self._bodies[group]
        for i in range(index, len(body)):  # no slice: that would be quadratic over a long mission
            node = body[i]
            path = f"{group}/{node.name}"
            if isinstance(node, Leg):
                return path
            if isinstance(node, Set):
                units.append(unit_of(node))
            elif path in self._bodies and (inner := self._first_leg(path, 0, units)):
                return inner
        return None

    # --- edges -----------------------------------------------------------------------------

    def _leg_edges(self, path: str, leg: Leg) -> None:
        slot = self._slots[path]
        follow = self._ways_from(_Slot(slot.group, slot.index + 1))
        row = LEGS[type(leg.kind)]
        for i, leave in enumerate(leg.exits, start=1):
            self._check_guard(leave.guard, leave.where, row.gives)
            target = leave.target
            ways = self._resolve_name(slot.group, target, leave.where) if target else follow
            self._connect(f"{path}:until{i}", path, ways, By.UNTIL, leave.where, leave.guard)
        timed_surface = row.ascends and leg.duration is not None
        if row.ends and not timed_surface:
            self._connect(f"{path}:end", path, follow, By.END, leg.where)
        if leg.duration is not None:
            self._connect(f"{path}:for", path, follow, By.FOR, leg.where)
        otherwise = self._resolve_name(
            slot.group, leg.otherwise or self._mission.on_timeout, leg.where
        )
        if leg.timeout is not None:
            self._connect(f"{path}:timeout", path, otherwise, By.TIMEOUT, leg.where)
        self._connect(f"{path}:else", path, otherwise, By.ELSE, leg.where)

    def _handler_edges(self, path: str, holder: Group | Mission) -> None:
        for i, handler in enumerate(holder.handlers, start=1):
            self._check_guard(handler.guard, handler.where, None)
            ways = self._resolve_name(path, handler.target, handler.where)
            self._connect(f"{path}:on{i}", path, ways, By.ON, handler.where, handler.guard)

    def _mission_edges(self) -> None:
        mission = self._mission
        self._handler_edges(AUTONOMOUS, mission)
        ways = self._resolve_name(AUTONOMOUS, mission.on_uncertain, mission.where)
        self._connect(f"{AUTONOMOUS}:uncertain", AUTONOMOUS, ways, By.UNCERTAIN, mission.where)
        self._edges.append(Edge(f"{IMPLICIT_SURFACE}:end", IMPLICIT_SURFACE, IDLE_READY, By.END))

    def _connect(
        self,
        trigger: str,
        source: str,
        ways: tuple[_Way, ...],
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
        """Every guard that a leg and the groups around it watch costs each step of the engine."""
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

    def _resolve(self, start: _Way) -> dict[str, Setpoint]:
        parents = {state.path: state.parent for state in self._states}
        first = Flow("", start.target, start.unit)
        outputs = outputs_of(self._mission)
        resolution = Resolution(self._legs, parents, self._flows, first, outputs)
        sets, problems = resolution.setpoints()
        self._problems += problems
        self._levels = resolution.levels()
        told: set[str] = set()  # a value that legs keep is complained of once, where it is stated
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
    return sum(1 for each in guarded for _ in comparisons(each.guard.expression))
