"""Walk every way through the chart, with the bounds that hold on it.

- The walk goes scope by scope: the body of a group in its order, for each of its rounds. Each leg
  is entered with the join of the bounds of all ways into it.
- Edges forward in their scope, or out of it, are followed. A backward edge that is not the round of
  a group could be taken without end, and is reported.
- ``on`` handlers act once each (a second time the engine surfaces). So the chart is walked again
  from their targets, with the bounds found there, once for each handler that leads to a leg.
- At any moment of a leg a limit or a handler may end the mission: the ascent from there counts.

What does not live here: what a leg does to the bounds (bounds.py), what is refused (rules.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TypeVar

from mission.authoring.check.ascents import ascent_time, goes_on
from mission.authoring.check.assumptions import Assumptions
from mission.authoring.check.bounds import Bounds, LegBounds, Trail
from mission.authoring.check.fenced import Broken, broken, swept
from mission.authoring.check.seabed import Over
from mission.engine.areas import Fence
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, By, Chart, Edge, Loop, State
from mission.model.vehicle import Vehicle

# Most legs that are walked; a longer mission is refused. The Pi checks an upload between two polls
# of its links, so the check may take only a second or two there.
ROUNDS = 5_000

K = TypeVar("K")
Exits = dict[tuple[str, tuple[Loop, ...]], Bounds]


class TooLongError(Exception):
    """The mission needs more than ``ROUNDS`` legs to be walked."""


@dataclass(slots=True)
class Proof:
    """The results of the walk: the worst of each figure with its bounds, and what was reached."""

    end: Bounds | None = None  # at the end of the mission, by its own ways
    worst: Bounds | None = None  # the same, and after every ascent that a limit may begin
    widest: float = 0.0  # m from home
    deepest: float = 0.0  # m
    blind: float = 0.0  # m deep if the sensor of a hold fails
    out_of_radius: tuple[str, Bounds] | None = None  # the first leg that may leave the radius
    out_of_depth: tuple[str, Bounds] | None = None
    breaks: Broken | None = None  # the first leg that may break an area
    over: dict[str, Over] = field(default_factory=dict)  # what legs sweep, if requested
    reached: set[str] = field(default_factory=set)
    taken: set[str] = field(default_factory=set)
    backward: dict[str, Edge] = field(default_factory=dict)
    walked: int = 0


class Flow:
    def __init__(
        self,
        chart: Chart,
        vehicle: Vehicle,
        assume: Assumptions,
        bounds_of: Callable[[State], LegBounds],
        *,
        radius: float,
        depth: float,
        fences: tuple[Fence, ...] = (),
        sweeps: bool = False,
    ) -> None:
        """``radius`` and ``depth``, in m: the proof records the first leg that may exceed them, and
        the first that may break one of the ``fences``. ``sweeps``: also record what legs sweep."""
        self.chart, self.vehicle, self.assume = chart, vehicle, assume
        self.radius, self.depth, self.fences, self.sweeps = radius, depth, fences, sweeps
        self.proof = Proof()
        self.legs = {
            s.path: bounds_of(s) for s in chart.states if s.leg and s.path != IMPLICIT_SURFACE
        }
        self.state = {s.path: s for s in chart.states}
        self.children: dict[str, list[str]] = {}
        for s in chart.states:
            self.children.setdefault(s.parent, []).append(s.path)
        self.place = {path: i for kids in self.children.values() for i, path in enumerate(kids)}
        self.edges: dict[str, list[Edge]] = {}
        self.handlers: dict[str, list[Edge]] = {}
        for edge in chart.edges:
            handled = edge.by in (By.ON, By.UNCERTAIN)
            (self.handlers if handled else self.edges).setdefault(edge.source, []).append(edge)
        self._next: dict[str, Bounds] = {}
        self._interrupted = False

    def walk(self, start: Bounds) -> Proof:
        entries = {self.chart.initial: start}
        handlers = (h for scope in self.handlers.values() for h in scope)
        lead_on = sum(h.target != IMPLICIT_SURFACE for h in handlers)
        for generation in range(1 + lead_on):
            self._interrupted = generation > 0
            self._next = {}
            self._scope(AUTONOMOUS, entries, ())
            entries = self._next
            if not entries:
                break
        return self.proof

    # --- one scope -----------------------------------------------------------------------

    def _scope(self, path: str, entries: dict[str, Bounds], above: tuple[str, ...]) -> Exits:
        """The bounds on leaving a scope, by target and by the loops that outer scopes must test."""
        group = self.state[path].group if path in self.state else None
        rounds = group.repeat if group else 1
        out: Exits = {}
        for number in range(rounds):
            again: dict[str, Bounds] = {}
            last = number == rounds - 1
            for child in self.children.get(path, ()):
                for (target, loops), bounds in self._child(child, entries, (*above, path)).items():
                    self._follow(path, child, last, target, loops, bounds, entries, again, out)
            entries = again
            if not entries:
                break
        return out

    def _child(self, child: str, entries: dict[str, Bounds], above: tuple[str, ...]) -> Exits:
        if child in self.children:
            inside = {t: b for t, b in entries.items() if t.startswith(child + "/")}
            for target in inside:
                del entries[target]
            return self._scope(child, inside, above) if inside else {}
        bounds = entries.pop(child, None)
        return {} if bounds is None else self._leg(child, bounds, above)

    def _follow(
        self,
        path: str,
        child: str,
        last: bool,
        target: str,
        loops: tuple[Loop, ...],
        bounds: Bounds,
        entries: dict[str, Bounds],
        again: dict[str, Bounds],
        out: Exits,
    ) -> None:
        """Assign one way to this round, the next round, or the exits of the scope."""
        mine = [loop for loop in loops if loop.group == path]
        rest = tuple(loop for loop in loops if loop.group != path)
        for loop in mine:
            # a group that a handler has entered may be in any of its rounds
            if loop.again is last and not (self._interrupted and not loop.again):
                return
        if not self._inside(path, target) or any(loop.again for loop in rest):
            _merge(out, (target, rest), bounds)
        elif mine and mine[0].again:
            _merge(again, target, bounds)
        elif self.place[self._branch(path, target)] > self.place[child]:
            _merge(entries, target, bounds)
        else:
            self.proof.backward.setdefault(child, self._edge_between(child, target))

    def _inside(self, path: str, target: str) -> bool:
        return target.startswith(path + "/") and target in self.state

    def _branch(self, path: str, target: str) -> str:
        head = target[len(path) + 1 :].split("/", 1)[0]
        return f"{path}/{head}"

    def _edge_between(self, child: str, target: str) -> Edge:
        return next(
            e
            for source, edges in self.edges.items()
            if source == child or source.startswith(child + "/")
            for e in edges
            if e.target == target
        )

    # --- one leg -------------------------------------------------------------------------

    def _leg(self, path: str, entry: Bounds, above: tuple[str, ...]) -> Exits:
        if path == IMPLICIT_SURFACE:
            self._arrive(path, entry)
            return {}
        proof, leg = self.proof, self.legs[path]
        proof.walked += 1
        if proof.walked > ROUNDS:
            raise TooLongError
        proof.reached.add(path)
        sweep = leg.sweep(entry)
        self._note(path, sweep)
        self._look_at_areas(path, leg, entry, sweep)
        proof.blind = max(proof.blind, leg.blind(entry))
        if self.sweeps:
            over = Over(
                swept(leg, entry, sweep), leg.blind(entry), leg.holds_depth, leg.least_floor
            )
            proof.over[path] = proof.over[path].joined(over) if path in proof.over else over
        self._surface(path, sweep)
        for scope in above:
            for handler in self.handlers.get(scope, ()):
                if handler.target != path:
                    proof.taken.add(handler.trigger)
                    _merge(self._next, handler.target, self._into(handler.target, sweep))
        out: Exits = {}
        for edge in self.edges.get(path, ()):
            guard = edge.guard.expression if edge.guard else None
            proof.taken.add(edge.trigger)
            left = leg.leave(entry, edge.by, guard=guard)
            _merge(out, (edge.target, edge.loops), self._into(edge.target, left))
        return out

    def _look_at_areas(self, path: str, leg: LegBounds, entry: Bounds, sweep: Bounds) -> None:
        if self.fences and self.proof.breaks is None:
            on = goes_on(sweep, self.vehicle)
            time = ascent_time(sweep.depth[1], self.vehicle)
            drift = on.error - sweep.error + self.assume.current * time
            self.proof.breaks = broken(path, self.fences, swept(leg, entry, sweep), drift)

    def _into(self, target: str, bounds: Bounds) -> Bounds:
        ascends = target not in self.legs or self.legs[target].ascends
        return goes_on(bounds, self.vehicle) if ascends else bounds

    def _arrive(self, path: str, bounds: Bounds) -> None:
        """Record the implicit leg: the ascent that ends the mission."""
        self.proof.reached.add(path)
        end = self._surface(path, bounds)
        self.proof.end = end if self.proof.end is None else self.proof.end.join(end)

    def _surface(self, path: str, bounds: Bounds) -> Bounds:
        """Record an ascent from these bounds (a limit may act at any moment); return its end."""
        time = ascent_time(bounds.depth[1], self.vehicle)
        drift = self.assume.current * time
        battery = self.vehicle.battery
        energy = time * (battery.hotel + battery.vertical)
        bounds = goes_on(bounds, self.vehicle)
        up = bounds._replace(
            time=bounds.time + time,
            energy=bounds.energy + energy,
            range=bounds.range + drift,
            error=bounds.error + drift,
            trail=Trail(IMPLICIT_SURFACE, By.END, time, energy, bounds.trail),
            spent=Trail(IMPLICIT_SURFACE, By.END, time, energy, bounds.spent),
        )
        self._note(path, up)
        worst = self.proof.worst
        self.proof.worst = up if worst is None else worst.join(up)
        return up

    def _note(self, path: str, bounds: Bounds) -> None:
        proof = self.proof
        proof.widest = max(proof.widest, bounds.range)
        proof.deepest = max(proof.deepest, bounds.depth[1])
        if proof.out_of_radius is None and bounds.range > self.radius:
            proof.out_of_radius = (path, bounds)
        if proof.out_of_depth is None and bounds.depth[1] > self.depth:
            proof.out_of_depth = (path, bounds)


def _merge(table: dict[K, Bounds], key: K, bounds: Bounds) -> None:
    here = table.get(key)
    table[key] = bounds if here is None else here.join(bounds)


def trail(last: Trail | None) -> Iterable[Trail]:
    """The steps of a trail from the start on."""
    steps = []
    at = last
    while at is not None:
        steps.append(at)
        at = at.before
    return reversed(steps)
