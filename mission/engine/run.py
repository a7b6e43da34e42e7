"""A mission under way: its active leg, since when, in which round; and the edge that is due next.

    handlers, innermost group first -> exits as written -> end -> for -> timeout -> else

Only the guards of the active leg and of the groups around it are evaluated. The machine gets only
the edge that fires. Round counts survive an interruption; an ordinary entry resets them.

What does not live here: regions, limits and operators (engine), what a guard means (guards).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Self

from mission.engine.ascent import Ascent, Way
from mission.engine.clearance import Clearance, is_guarded
from mission.engine.lasting import Lasting
from mission.engine.memory import Memory
from mission.engine.plan import Plan, name_of, plan_of, repeat_of
from mission.engine.readings import Scope, Value
from mission.engine.rest import may_have_sunk
from mission.engine.variables import VARIABLES, value_of
from mission.engine.vehicle_state import SURFACE_TIME, VehicleState
from mission.engine.words import short
from mission.legs import Pilot, Track, View
from mission.legs.base import wrap
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    Action,
    Axis,
    By,
    Chart,
    Edge,
    Estimate,
    Evaluation,
    Leg,
)
from mission.model.copies import copied
from mission.model.regions import AGAIN
from mission.model.vehicle import STALE_AFTER
from protocol.messages import Order, Setpoint

BLIND_TIME = 6.0  # s that a reading which a setpoint needs may be invalid
NEW_HEADING = math.radians(2.5)  # a steered heading is sent again when it changed by more
MISSED = 1.0  # m short of the depth that was asked for, at a timeout
_AFTER = 1e-3  # s beyond a reading's greatest age


class Run:
    def __init__(
        self, chart: Chart, now: float, ways: tuple[Way, ...], clearance: Clearance
    ) -> None:
        """``ways``: the ways that the vehicle's ascents try in turn."""
        self.chart, self._ways, self._clearance = chart, ways, clearance
        self.started = now
        self.entered = now
        self.travelled = 0.0
        self.rounds: dict[str, int] = {}
        self.sent: Setpoint | None = None  # None while it ascends
        self.refused = False  # the vehicle answered N to the set, or never got it
        self.wake: float | None = None  # when to look again, by the last look
        self.ascent: Ascent | None = None
        self.at_surface = False  # the ascent has ended, everything is stopped
        self._plans: dict[str, Plan] = {}
        self._plan = self._planned(chart.initial)
        self._pilot: Pilot | None = None
        self._steered_by: Estimate | None = None
        self._held = Lasting()
        self._memory = Memory(chart)
        self._spent: dict[str, str] = {}  # handlers that acted, and whose guard was not false since
        self._taken: set[str] = set()  # handlers that acted at all
        self._blind: dict[str, float] = {}
        self._needed: tuple[str, ...] = ()
        self._needed_by: Setpoint | None = None
        self._reckoned = now

    def clone(self) -> Self:
        return copied(self, _plans=self._plans)  # plans do not change

    @property
    def leaf(self) -> str:
        return self._plan.path

    @property
    def leg(self) -> Leg:
        return self._plan.leg

    @property
    def round(self) -> int:
        return self.rounds.get(self._plan.repeated, 1)

    @property
    def climbing(self) -> bool:
        """Whether the leg ascends, and has not reached the surface."""
        return self.ascent is not None and not self.at_surface

    # --- entering ------------------------------------------------------------------------------

    def enter(
        self, path: str, entered: tuple[str, ...], vehicle_state: VehicleState, *, history: bool
    ) -> tuple[Action, ...]:
        """Enter a leg. Return what to send: its whole set, or the ascent's first command."""
        now, ascended = vehicle_state.now, self._surfaced(vehicle_state)
        before, stopped = (None, False) if history else (self.ascent, self.at_surface)
        self._plan = self._planned(path)
        self.entered = self._reckoned = now
        self.travelled, self.refused, self.at_surface = 0.0, False, False
        self._blind, self._needed_by = {}, None
        self._memory.begin(self._plan.trends, again=history)
        if not history:
            self.rounds.update(dict.fromkeys((g for g in self._plan.groups if g in entered), 1))
            self._spent = {h: source for h, source in self._spent.items() if source not in entered}
        fresh = (path, *entered)
        self._held.keep({e.trigger for e, _ in self._plan.guarded if e.source not in fresh})
        why = f"entry of {short(path)}"
        if self._plan.kind.ascends:
            if before is not None and ascended:
                return self._stay_up(before, stopped, why)
            self._pilot, self.sent = None, None
            if before is not None and not stopped:
                return ()  # a new ascent begins with W, and as built W first goes on diving
            vehicle_state.rising_since = now
            self.ascent = Ascent(
                now,
                vehicle_state.moving_depth,
                why,
                self._ways,
                overturned=vehicle_state.overturned,
                upward=vehicle_state.depth is None,
            )
            return self.ascent.first()
        self.ascent = vehicle_state.rising_since = None
        self._clearance.begin()
        begin, view = self._plan.kind.begin, self._view(vehicle_state)
        self._pilot = begin(self._plan.leg.kind, self._plan.base, view) if begin else None
        stop = (Action(Order.STOP, f"{why}: the ascent is over"),) if before else ()
        self.sent = self._wanted(vehicle_state)
        return (*stop, Action(self.sent, why))

    def _stay_up(self, proved: Ascent, stopped: bool, why: str) -> tuple[Action, ...]:
        """Keep the ascent that has ended at the surface: no climb is needed. Return the stop, if it
        was not sent yet."""
        self.ascent, self.at_surface = proved, True
        return () if stopped else (Action(Order.STOP, f"{why}: at the surface already"),)

    def again(self, why: str) -> tuple[Action, ...]:
        """Return the whole set, to be sent again."""
        return (Action(self.sent, why),) if self.sent is not None else ()

    # --- looking -------------------------------------------------------------------------------

    def count(self, edge: Edge) -> None:
        """Count the rounds that an edge begins or ends, before its leg is entered."""
        for loop in edge.loops:
            self.rounds[loop.group] = self.rounds.get(loop.group, 1) + 1 if loop.again else 1

    def look(self, vehicle_state: VehicleState) -> tuple[Edge, tuple[Evaluation, ...]] | None:
        """Return the edge that is due, and the evaluation that decided it; set ``wake``."""
        now, plan = vehicle_state.now, self._plan
        self.wake = None
        self._notice_blindness(vehicle_state)
        if plan.guarded:
            found = self._look_at_guards(vehicle_state)
            if found is not None:
                return found
        for edge in plan.plain:
            due = self.due(edge, vehicle_state)
            if due is None or not self.open(edge):
                continue
            if now >= due:
                return edge, (Evaluation(edge.trigger, True, self._values_of(edge, vehicle_state)),)
            self._wake_at(due)
        return None

    def _look_at_guards(
        self, vehicle_state: VehicleState
    ) -> tuple[Edge, tuple[Evaluation, ...]] | None:
        plan, now = self._plan, vehicle_state.now
        scope = self.scope(vehicle_state)
        values = plan.sheet.values(scope)
        waiting = False
        for edge, guard in plan.guarded:
            result = guard.test(values, scope)
            if edge.by is By.ON and not self._arises(edge, result):
                self._held.forget(edge.trigger)
            elif result and self.open(edge):
                since = self._held.holds(edge.trigger, now) if guard.held else now
                if now >= since + guard.held:
                    seen = plan.sheet.named(guard, values)
                    taken = self._act(edge) if edge.by is By.ON else edge
                    return taken, (Evaluation(edge.trigger, True, seen),)
                waiting = True
                self._wake_at(since + guard.held)
            elif guard.held and result is False:
                self._held.breaks(edge.trigger, now)
            elif guard.held:
                self._held.forget(edge.trigger)
            if guard.timed:
                self._wake_at(guard.next_change(values, now))
        if waiting and vehicle_state.telemetry is not None:
            for age in plan.sheet.stale_after:
                oldest = min(age, vehicle_state.stale_after) if age == STALE_AFTER else age
                self._wake_at(vehicle_state.telemetry.t + oldest + _AFTER)
        return None

    def _arises(self, handler: Edge, result: bool | None) -> bool:
        """Whether a handler may act: its guard was false since it acted, and it leads elsewhere."""
        if result is False:
            self._spent.pop(name_of(handler), None)
        return handler.target != self.leaf and name_of(handler) not in self._spent

    def _act(self, handler: Edge) -> Edge:
        """Return the handler's edge; from the second time on, an edge to the implicit leg."""
        name = name_of(handler)
        self._spent[name] = handler.source
        if name in self._taken:
            return Edge(AGAIN, handler.source, IMPLICIT_SURFACE, handler.by)
        self._taken.add(name)
        return handler

    def uncertain(self) -> Edge | None:
        """Return the edge of ``on uncertain``; from the second time on, one to the implicit leg."""
        for edge in self.chart.leaving(AUTONOMOUS):
            if edge.by is By.UNCERTAIN and edge.target != self.leaf and self.open(edge):
                return self._act(edge)
        return None

    def open(self, edge: Edge) -> bool:
        """Whether the counts of rounds allow the edge."""
        for loop in edge.loops:
            left = self.rounds.get(loop.group, 1) < repeat_of(self.chart, loop.group)
            if left is not loop.again:
                return False
        return True

    def due(self, edge: Edge, vehicle_state: VehicleState) -> float | None:
        """When the edge is due by its kind alone (for, timeout, end, else); None if it is not."""
        if edge.by is By.FOR or edge.by is By.TIMEOUT:
            lasts = self.leg.duration if edge.by is By.FOR else self.leg.timeout
            return None if lasts is None else self.entered + lasts
        if edge.by is By.END:
            return vehicle_state.now if self._ended(vehicle_state) else None
        if self.refused:
            return vehicle_state.now
        return min(self._blind.values()) + BLIND_TIME if self._blind else None

    def _ended(self, vehicle_state: VehicleState) -> bool:
        if self.ascent is not None:
            if self._plan.kind.awaits_fix(self.leg.kind):
                since = max(self.ascent.began, self.entered - SURFACE_TIME)
                return vehicle_state.fixed(since) and vehicle_state.located(since)
            return vehicle_state.surfaced(self.ascent.began)
        return self._pilot is not None and self._pilot.finished(self._view(vehicle_state))

    def _surfaced(self, vehicle_state: VehicleState) -> bool:
        """Whether this ascent has proved the surface, and the vehicle is seen to be there still."""
        if self.ascent is None or may_have_sunk(vehicle_state, self.ascent.began):
            return False
        return vehicle_state.surfaced(max(self.ascent.began, vehicle_state.now - SURFACE_TIME))

    def _values_of(self, edge: Edge, vehicle_state: VehicleState) -> tuple[tuple[str, Value], ...]:
        elapsed: tuple[str, Value] = ("elapsed", round(vehicle_state.now - self.entered, 6))
        if edge.by is By.ELSE:
            return (elapsed, *((need, None) for need in self._blind))
        return (elapsed, ("depth", vehicle_state.depth))

    def missed_depth(self, vehicle_state: VehicleState) -> str:
        """Describe, at a timeout, a dive that did not reach its depth; "" if there is none."""
        wanted, depth = self.sent.depth if self.sent else None, vehicle_state.depth
        if wanted is None or depth is None or wanted - depth <= MISSED:
            return ""
        return f"no progress, depth {depth:.1f} m of {wanted:g} m"

    def _notice_blindness(self, vehicle_state: VehicleState) -> None:
        for need in self._needs():
            if vehicle_state.believable(need):
                self._blind.pop(need, None)
            else:
                self._blind.setdefault(need, vehicle_state.now)

    def _needs(self) -> Iterable[str]:
        """The readings that the leg needs to be steered; an ascent needs none."""
        sent, needs = self.sent, self._plan.kind.needs
        if sent is None:
            return ()
        if sent is not self._needed_by:  # once per set
            held = [n for n in ("depth", "altitude", "heading") if getattr(sent, n) is not None]
            self._needed_by, self._needed = sent, tuple(dict.fromkeys((*sorted(needs), *held)))
        return self._needed

    def _wake_at(self, due: float | None) -> None:
        if due is not None and (self.wake is None or due < self.wake):
            self.wake = due

    # --- steering ------------------------------------------------------------------------------

    def steer(self, vehicle_state: VehicleState) -> tuple[Action, ...]:
        """Return what the active leg sends now; most of the time nothing."""
        if self.ascent is not None:
            return self._climb(vehicle_state, self.ascent)
        if vehicle_state.estimate is self._steered_by:
            return ()
        if self._pilot is None and not is_guarded(self._plan.base):
            return ()
        self._steered_by = vehicle_state.estimate
        wanted = self._wanted(vehicle_state)
        if self.sent is not None and not _differs(wanted, self.sent):
            return ()
        self.sent, self.refused = wanted, False
        return (Action(wanted, f"{short(self.leaf)} steers", steers=True),)

    def _climb(self, vehicle_state: VehicleState, ascent: Ascent) -> tuple[Action, ...]:
        if self.at_surface:
            return ()
        if vehicle_state.surfaced(ascent.began):
            self.at_surface = True
            return (Action(Order.STOP, f"{short(self.leaf)}: the surface is reached"),)
        return ascent.act(*vehicle_state.seen_rising)

    def reckon(self, vehicle_state: VehicleState) -> None:
        """Add a new estimate to the path over ground, and a new report to the memory."""
        if self._memory.watching:
            self._memory.take(self.scope(vehicle_state))
        e = vehicle_state.estimate
        if e is None or e.t <= self._reckoned:
            return
        if e.heading is not None:
            north = e.speed * math.cos(e.heading) + e.current_north
            east = e.speed * math.sin(e.heading) + e.current_east
            self.travelled += math.hypot(north, east) * (e.t - self._reckoned)
        self._reckoned = e.t

    def next_timer(self, vehicle_state: VehicleState) -> list[float | None]:
        due = [self.wake]
        if self.ascent is not None and self.climbing:
            due += [self.ascent.next_timer(), vehicle_state.surface_due(self.ascent.began)]
        return due

    def scope(self, vehicle_state: VehicleState) -> Scope:
        return Scope(
            vehicle_state.now,
            vehicle_state.estimate,
            vehicle_state.telemetry,
            vehicle_state.health,
            self.entered,
            self.started,
            self.travelled,
            self.round,
            self._track_from(vehicle_state),
            self._memory,
            vehicle_state.stale_after,
        )

    def value(self, name: str, vehicle_state: VehicleState) -> Value:
        return value_of(VARIABLES[name], self.scope(vehicle_state))

    def _track_from(self, vehicle_state: VehicleState) -> Callable[[], Track | None]:
        pilot = self._pilot
        return lambda: pilot.track(self._view(vehicle_state)) if pilot else None

    def _view(self, vehicle_state: VehicleState) -> View:
        located = vehicle_state.believable("position")
        return View(
            vehicle_state.now,
            vehicle_state.estimate if located else None,
            vehicle_state.depth,
            vehicle_state.place,
        )

    def _wanted(self, vehicle_state: VehicleState) -> Setpoint:
        """The pilot's set: heading turned from true to compass, depth clear of the bottom."""
        base = self._plan.base
        if self._pilot is None:
            return self._clearance.told(base, vehicle_state)
        steered = self._pilot.setpoint(self._view(vehicle_state))
        wanted = self._clearance.told(steered, vehicle_state)
        if Axis.HEADING not in self._plan.kind.steers:
            return wanted
        compass = None if wanted.heading is None else vehicle_state.compass(wanted.heading)
        if compass is None:  # without a heading the vehicle makes no way
            return replace(wanted, surge=0.0, heading=None)
        return replace(wanted, heading=compass)

    def _planned(self, path: str) -> Plan:
        plan = self._plans.get(path)
        if plan is None:
            plan = self._plans[path] = plan_of(self.chart, path)
        return plan


def _differs(wanted: Setpoint, sent: Setpoint) -> bool:
    a, b = wanted.heading, sent.heading
    if a is None or b is None:
        return wanted != sent
    turned = abs(wrap(a - b)) >= NEW_HEADING
    return turned or wanted.depth != sent.depth or wanted.surge != sent.surge
