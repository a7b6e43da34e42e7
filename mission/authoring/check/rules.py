"""The refusals of the check, one function for each rule, and the report.

    no-bound       a leg that no clock ends
    endless        a way that leads back and may be taken without end
    no-way-up      a state from which clocks alone do not lead to the surface
    unreachable    a leg that no way leads to
    unknowable     a guard on a value that this vehicle never reports
    no-leg-before  a guard of the first leg that needs the peak of the leg before
    no-home        a latitude and longitude, or a file of depths, in a mission without home
    time           the worst case, with the ascent, exceeds the safety time
    radius         the swept path, widened by current and uncertainty, leaves the radius
    depth          the same for the depth
    area           an area that is no polygon, or that a leg or the ascent from it may break
    never-below    a depth with a least altitude, where the floor leaves no depth to hold
    energy         the worst case exceeds the battery
    heavy          the vehicle does not rise by itself, which X relies on
    unheard        the vehicle reports nothing
    too-long       the mission has more legs than can be walked
    grounding      with a file of depths: a leg that may be deeper than the sea floor (seabed.py)
    floor          the same: a sea floor deeper than the assumed one
    purpose        legs that are not expected to achieve the goal of the mission (purpose.py)

What does not live here: the bounds (bounds.py) and the walk (flow.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mission.authoring.bathymetry import Depths
from mission.authoring.check import remedy, seabed
from mission.authoring.check.ascents import dark_time
from mission.authoring.check.assumptions import Assumptions, not_clear, told
from mission.authoring.check.bounds import Bounds, LegBounds, Trail
from mission.authoring.check.fenced import area_faults, fenced, words
from mission.authoring.check.flow import Flow, Proof, TooLongError, trail
from mission.authoring.check.knowable import none_before, unknowable
from mission.authoring.check.places import places_named
from mission.authoring.check.purpose import Outlook, judged
from mission.authoring.check.seabed import Ground
from mission.engine import bounds as envelope
from mission.engine.limits import DEPTH_MARGIN
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    By,
    Chart,
    Mission,
    Position,
    State,
    Where,
    buoyancy,
    legs_of,
)
from mission.model.diagnostics import Diagnostic, Stage
from mission.model.vehicle import Vehicle
from mission.navigation.geodesy import LocalFrame
from protocol.messages import SetSafety

PATH_STEPS = 12  # shown steps of a counterexample; those left out in the middle are counted


@dataclass(frozen=True, slots=True)
class Proved:
    states: int
    transitions: int
    worst_time: float  # s, with the ascent
    worst_energy: float  # J
    max_range: float  # m from home, true
    max_depth: float  # m
    blind_depth: float  # m, greatest depth if the sensor of a hold fails
    blind_time: float  # s more for the ascent from there
    uncertainty: float  # m, added to the estimate until the end
    path: tuple[str, ...]  # the way with the worst time
    dark_time: float = 0.0  # s more until fixes prove the surface, if no depth is believed


@dataclass(frozen=True, slots=True)
class Report:
    refusals: tuple[Diagnostic, ...]
    proved: Proved | None
    assumed: tuple[str, ...]
    outlook: tuple[Outlook, ...] = ()  # of the legs with a goal
    grounds: tuple[Ground, ...] = ()  # the sea floor under the legs, if a file of depths is given

    @property
    def ok(self) -> bool:
        return not self.refusals


def check_mission(chart: Chart, vehicle: Vehicle, depths: Depths | None = None) -> Report:
    """Check a chart on a vehicle: all refusals, and the proof. Linear in legs times rounds."""
    mission = chart.mission
    limits = envelope.in_force(vehicle, mission.safety, SetSafety())
    assume = Assumptions.of(mission, vehicle, limits.depth)
    early = [*before_the_proof(mission, vehicle), *_no_bound(chart)]
    unbounded = bool(early)
    early += [*unknowable(chart, vehicle), *_not_clear(chart, vehicle), *none_before(chart)]
    if unbounded:
        return Report(tuple(early), None, tuple(told(chart, vehicle, assume, False)))
    flow = _flow(chart, vehicle, assume, limits, sweeps=depths is not None)
    try:
        proof = flow.walk(_start(vehicle, assume))
    except TooLongError:
        message = f"more than {flow.proof.walked - 1} legs are flown in the worst case"
        refusals = (*early, _refused("too-long", mission.where, message, "repeat less"))
        return Report(refusals, None, tuple(told(chart, vehicle, assume, False)))
    purpose = judged(mission, vehicle)
    found = [*early, *_ways(chart, proof), *_bounds(chart, vehicle, proof, limits, assume)]
    found += purpose.refusals
    under: dict[str, Ground] = {}
    if depths is not None:
        found += _homeless(mission)
        under = seabed.grounds(proof.over, depths, mission.home) if mission.home else {}
        found += seabed.refusals(under, proof.over, chart)
        proof.blind = seabed.blind(under, proof.over) if under else proof.blind
    floor = any(leg.leans_on_floor for leg in flow.legs.values())
    assumed = tuple(told(chart, vehicle, assume, floor))
    proved, ground = _proved(proof, chart, vehicle), tuple(under.values())
    return Report(tuple(found), proved, assumed, purpose.outlook, ground)


def _homeless(mission: Mission) -> Iterator[Diagnostic]:
    if mission.home is None:
        message = "what lies under a leg cannot be known: the mission names no home"
        yield _refused("no-home", mission.where, message, "add home")


def before_the_proof(mission: Mission, vehicle: Vehicle) -> Iterator[Diagnostic]:
    """Refusals that do not depend on the legs' settings and order."""
    yield from _heavy(mission, vehicle)
    yield from _unheard(mission, vehicle)
    yield from no_home(mission)
    yield from (_refused("area", *found) for found in area_faults(mission))


def check_ways(chart: Chart, vehicle: Vehicle) -> Iterator[Diagnostic]:
    """Refusals of an incomplete chart: only those of its ways, which need no setpoints."""
    limits = envelope.in_force(vehicle, chart.mission.safety, SetSafety())
    assume = Assumptions.of(chart.mission, vehicle, limits.depth)
    if any(_no_bound(chart)):
        return
    try:
        proof = _flow(chart, vehicle, assume, limits).walk(_start(vehicle, assume))
    except TooLongError:
        return
    yield from _ways(chart, proof)


def _flow(
    chart: Chart,
    vehicle: Vehicle,
    assume: Assumptions,
    limits: envelope.Bounds,
    *,
    sweeps: bool = False,
) -> Flow:
    frame = LocalFrame(chart.mission.home) if chart.mission.home else None
    return Flow(
        chart,
        vehicle,
        assume,
        lambda state: LegBounds(state, vehicle, assume, frame),
        radius=limits.radius,
        depth=limits.depth + DEPTH_MARGIN,
        fences=fenced(chart.mission),
        sweeps=sweeps,
    )


def _start(vehicle: Vehicle, assume: Assumptions) -> Bounds:
    return Bounds.start(assume.start, 2.0 * vehicle.sensors.fix, assume.depth)


def _refused(
    code: str, where: Where, message: str, hint: str = "", path: tuple[str, ...] = ()
) -> Diagnostic:
    return Diagnostic(Stage.CHECK, code, where, message, hint, path)


# --- rules ------------------------------------------------------------------------------


def _legs(chart: Chart) -> Iterator[State]:
    return (s for s in chart.states if s.leg is not None and s.path != IMPLICIT_SURFACE)


def _name(path: str) -> str:
    return path.removeprefix(AUTONOMOUS + "/")


def _heavy(mission: Mission, vehicle: Vehicle) -> Iterator[Diagnostic]:
    if why := buoyancy.heavy(vehicle):
        message, _, hint = why.partition("; ")
        yield _refused("heavy", mission.where, message, hint)


def _unheard(mission: Mission, vehicle: Vehicle) -> Iterator[Diagnostic]:
    if not vehicle.reports:
        message = f"{vehicle.name} reports nothing: without a report a mission ends in 5 s (R8)"
        hint = "move it by the stick or by hand, or fly a vehicle that reports"
        yield _refused("unheard", mission.where, message, hint)


def _no_bound(chart: Chart) -> Iterator[Diagnostic]:
    for state in _legs(chart):
        leg = state.leg
        assert leg is not None
        if leg.duration is None and leg.timeout is None:
            message = f"{_name(state.path)} has no clock to end it"
            yield _refused("no-bound", leg.where, message, "add for or timeout")


def _not_clear(chart: Chart, vehicle: Vehicle) -> Iterator[Diagnostic]:
    for path, message in not_clear(chart, vehicle):
        yield _refused("never-below", _where(chart, path), message, "assume floor deeper")


def no_home(mission: Mission) -> Iterator[Diagnostic]:
    """Refuse positions in a mission without home: their distance from a home at the first fixes
    cannot be bounded."""
    for leg in () if mission.home is not None else legs_of(mission.body):
        if any(isinstance(place, Position) for place in places_named(leg.kind)):
            message = (
                f"{leg.name or 'this leg'} names a latitude and longitude, but the mission names "
                "no home to measure from"
            )
            yield _refused("no-home", leg.where, message, "add home, or write north .. east ..")


def _ways(chart: Chart, proof: Proof) -> Iterator[Diagnostic]:
    for child, edge in proof.backward.items():
        way = (f"{_name(edge.source)} ({edge.by.value})", _name(edge.target))
        where = edge.where if edge.where.line else _where(chart, edge.source)
        clocked = edge.by in (By.TIMEOUT, By.FOR, By.ELSE)
        code = "no-way-up" if clocked else "endless"
        message = f"{_name(child)} leads back to {_name(edge.target)}, without end" + (
            ": clocks alone never lead to the surface" if clocked else ""
        )
        hint = "use repeat for rounds, and lead on with the exit"
        yield _refused(code, where, message, hint, way)
    for state in _legs(chart):
        if state.path not in proof.reached:
            assert state.leg is not None
            message = f"no way leads to {_name(state.path)}"
            hint = f"lead there with -> {state.leg.name}, or take it out"
            yield _refused("unreachable", state.leg.where, message, hint)


def _bounds(
    chart: Chart,
    vehicle: Vehicle,
    proof: Proof,
    limits: envelope.Bounds,
    assume: Assumptions,
) -> Iterator[Diagnostic]:
    worst = proof.worst
    mission = chart.mission

    def again(changed: Chart) -> Proof:
        return _flow(changed, vehicle, assume, limits).walk(_start(vehicle, assume))

    if proof.end is None or worst is None:
        if not proof.backward:
            message, hint = "no way leads to the end of the mission", "let the last leg end"
            yield _refused("no-way-up", mission.where, message, hint)
        return
    if worst.time > limits.time:
        message = (
            f"the worst case takes {_minutes(worst.time)}, the ascent included; "
            f"the safety time is {_minutes(limits.time)}"
        )
        hint = remedy.hint(_time(limits.time), chart, proof, again)
        hint += _longer(mission, vehicle, worst.time)
        yield _refused("time", mission.where, message, hint, _path(worst.trail))
    if proof.out_of_radius is not None:
        path, bounds = proof.out_of_radius
        message = (
            f"{_name(path)} may be {bounds.range:.0f} m from home, with current and uncertainty; "
            f"the radius is {limits.radius:.0f} m"
        )
        hint = "stay nearer, or state what the radius may be with safety radius"
        yield _refused("radius", _where(chart, path), message, hint, _path(bounds.trail))
    if proof.breaks is not None:
        path = proof.breaks.path
        hint = "lead it farther off, take fixes on the way, or assume less current"
        yield _refused("area", _where(chart, path), words(proof.breaks, _name(path)), hint)
    if proof.out_of_depth is not None:
        path, bounds = proof.out_of_depth
        message = (
            f"{_name(path)} may reach {bounds.depth[1]:.1f} m; "
            f"the depth allowed is {limits.depth:.0f} m"
        )
        hint = _floor_hint(chart, path)
        yield _refused("depth", _where(chart, path), message, hint, _path(bounds.trail))
    if worst.energy > vehicle.battery.usable:
        message = (
            f"the worst case takes {worst.energy / 3600:.0f} Wh, the ascent included; "
            f"usable are {vehicle.battery.usable / 3600:.0f} Wh"
        )
        hint = remedy.hint(_energy(vehicle.battery.usable), chart, proof, again)
        yield _refused("energy", mission.where, message, hint, _path(worst.spent))


def _time(allowed: float) -> remedy.Figure:
    return remedy.Figure(
        of=lambda step: step.time,
        worst=lambda worst: worst.time,
        last=lambda worst: worst.trail,
        allowed=allowed,
        shown=_minutes,
    )


def _energy(allowed: float) -> remedy.Figure:
    return remedy.Figure(
        of=lambda step: step.energy,
        worst=lambda worst: worst.energy,
        last=lambda worst: worst.spent,
        allowed=allowed,
        shown=lambda joules: f"{joules / 3600:.0f} Wh",
    )


def _longer(mission: Mission, vehicle: Vehicle, worst: float) -> str:
    """A longer safety time as hint, if only the mission's own limit is exceeded."""
    if mission.safety.time is None or worst > vehicle.limits.time:
        return ""
    return f"; or safety time {math.ceil(worst / 60)} min"


def _floor_hint(chart: Chart, path: str) -> str:
    setpoint = chart.state(path).setpoint
    holds = setpoint is not None and setpoint.altitude is not None
    if holds:
        return "end it sooner, or state the sea floor with assume floor"
    return "end it sooner, or stay higher"


def _where(chart: Chart, path: str) -> Where:
    state = next((s for s in chart.states if s.path == path), None)
    if state and state.leg and state.leg.where.line:
        return state.leg.where
    return chart.mission.where


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f} min"


def _path(last: Trail | None) -> tuple[str, ...]:
    steps = [f"{_name(s.leg)} ({s.by.value}) {s.time:.0f} s" for s in trail(last)]
    if len(steps) <= PATH_STEPS:
        return tuple(steps)
    half = PATH_STEPS // 2
    return (*steps[:half], f"... {len(steps) - 2 * half} more ...", *steps[-half:])


# --- the report --------------------------------------------------------------------------


def _proved(proof: Proof, chart: Chart, vehicle: Vehicle) -> Proved | None:
    worst = proof.worst
    if proof.end is None or worst is None:
        return None
    blind = max(proof.deepest, proof.blind)
    return Proved(
        states=len(proof.reached),
        transitions=len(proof.taken),
        worst_time=worst.time,
        worst_energy=worst.energy,
        max_range=proof.widest,
        max_depth=proof.deepest,
        blind_depth=blind,
        blind_time=(blind - proof.deepest) / vehicle.ascent_buoyancy,
        uncertainty=proof.end.error,
        path=_path(worst.trail),
        dark_time=dark_time(vehicle),
    )
