"""The refusals of the check, one function a rule, and the report that comes of them.

    no-bound       a leg that no clock ends
    endless        a way that leads back and may be taken without end
    no-way-up      a state from which clocks alone do not lead to the surface
    unreachable    a leg that no way leads to
    unknowable     a guard on what this vehicle never reports
    no-home        a latitude and longitude, in a mission that does not say where home is
    time           the worst case, with the ascent, exceeds the safety time
    radius         the swept path, widened by current and uncertainty, leaves the radius
    depth          the same for the depth
    energy         the worst case exceeds the battery
    heavy          the vehicle does not rise by itself, and X rests on that
    too-long       more rounds than can be walked

What does not live here: the bounds (bounds.py) and the walk (flow.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mission.authoring.check.assumptions import SPEED_SHARE, Assumptions
from mission.authoring.check.bounds import Bounds, LegBounds
from mission.authoring.check.flow import Flow, Proof, TooLongError, trail
from mission.authoring.check.places import places_named
from mission.authoring.compiler.granularity import rounded
from mission.engine import bounds as envelope
from mission.engine.limits import DEPTH_MARGIN
from mission.engine.variables import CLOCK, VARIABLES
from mission.model import (
    AUTONOMOUS,
    IMPLICIT_SURFACE,
    And,
    By,
    Chart,
    Comparison,
    Expression,
    Guard,
    Not,
    Or,
    Position,
    State,
    Where,
    buoyancy,
)
from mission.model.vehicle import Vehicle
from mission.navigation.geodesy import LocalFrame
from protocol.messages import SetSafety

PATH_STEPS = 12  # of a counterexample; what lies between is told by its number


@dataclass(frozen=True, slots=True)
class Refusal:
    """``path`` is the counterexample where one matters: leg, how it was left, after how long."""

    rule: str
    where: Where
    message: str
    path: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Proved:
    states: int
    transitions: int
    worst_time: float  # s, with the ascent
    worst_energy: float  # J
    max_range: float  # m from home, the truth
    max_depth: float  # m
    blind_depth: float  # m, the same if the sensor that a hold goes by fails
    blind_time: float  # s that the ascent from there takes longer
    uncertainty: float  # m, of the estimate at the end, that was added
    path: tuple[str, ...]  # of the worst time


@dataclass(frozen=True, slots=True)
class Report:
    refusals: tuple[Refusal, ...]
    proved: Proved | None
    assumed: tuple[str, ...]

    @property
    def ok(self) -> bool:
        return not self.refusals


def check_mission(chart: Chart, vehicle: Vehicle) -> Report:
    """Everything that refuses this chart on this vehicle; linear in legs times rounds."""
    mission = chart.mission
    limits = envelope.in_force(vehicle, mission.safety, SetSafety())
    assume = Assumptions.of(mission, vehicle, limits.depth)
    frame = LocalFrame(mission.home) if mission.home else None
    early = [*_heavy(chart, vehicle), *_no_bound(chart), *_no_home(chart)]
    unbounded = bool(early)
    early += _unknowable(chart, vehicle)
    if unbounded:
        return Report(tuple(early), None, tuple(_assumed(chart, vehicle, assume, False)))
    flow = Flow(
        chart,
        vehicle,
        assume,
        lambda state: LegBounds(state, vehicle, assume, frame),
        radius=limits.radius,
        depth=limits.depth + DEPTH_MARGIN,
    )
    try:
        proof = flow.walk(Bounds.start(assume.start, 2.0 * vehicle.sensors.fix, assume.depth))
    except TooLongError:
        message = f"more than {flow.proof.walked - 1} legs are flown in the worst case; repeat less"
        refusals = (*early, Refusal("too-long", mission.where, message))
        return Report(refusals, None, tuple(_assumed(chart, vehicle, assume, False)))
    found = [*early, *_ways(chart, proof), *_bounds(chart, vehicle, proof, limits)]
    floor = any(leg.leans_on_floor for leg in flow.legs.values())
    assumed = tuple(_assumed(chart, vehicle, assume, floor))
    return Report(tuple(found), _proved(proof, chart, vehicle), assumed)


# --- rules ------------------------------------------------------------------------------


def _legs(chart: Chart) -> Iterator[State]:
    return (s for s in chart.states if s.leg is not None and s.path != IMPLICIT_SURFACE)


def _name(path: str) -> str:
    return path.removeprefix(AUTONOMOUS + "/")


def _heavy(chart: Chart, vehicle: Vehicle) -> Iterator[Refusal]:
    if why := buoyancy.heavy(vehicle):
        yield Refusal("heavy", chart.mission.where, why)


def _no_bound(chart: Chart) -> Iterator[Refusal]:
    for state in _legs(chart):
        leg = state.leg
        assert leg is not None
        if leg.duration is None and leg.timeout is None:
            message = f"{_name(state.path)} has no clock to end it; add for or timeout"
            yield Refusal("no-bound", leg.where, message)


def _no_home(chart: Chart) -> Iterator[Refusal]:
    """How far a position is from a home that the first fixes will tell cannot be proved."""
    if chart.mission.home is not None:
        return
    for state in _legs(chart):
        assert state.leg is not None
        if any(isinstance(place, Position) for place in places_named(state.leg.kind)):
            message = (
                f"{_name(state.path)} names a latitude and longitude, but the mission names no "
                "home to measure from; add home, or write north .. east .."
            )
            yield Refusal("no-home", state.leg.where, message)


def _variables(expression: Expression) -> Iterator[Comparison]:
    match expression:
        case Comparison():
            yield expression
        case Not(operand):
            yield from _variables(operand)
        case And(operands) | Or(operands):
            for operand in operands:
                yield from _variables(operand)


def _known(guard: Guard | Expression, vehicle: Vehicle) -> bool:
    """Whether some reading could decide it on this vehicle (of an or, one side is enough)."""
    match guard:
        case Guard(expression):
            return _known(expression, vehicle)
        case Comparison(name):
            sources = VARIABLES[name].source
            return all(s == CLOCK or s in vehicle.reports for s in sources)
        case Not(operand):
            return _known(operand, vehicle)
        case And(operands):
            return all(_known(o, vehicle) for o in operands)
        case Or(operands):
            return any(_known(o, vehicle) for o in operands)


def _unknowable(chart: Chart, vehicle: Vehicle) -> Iterator[Refusal]:
    seen = set()
    for edge in chart.edges:
        if edge.guard is None or edge.where in seen or _known(edge.guard, vehicle):
            continue
        seen.add(edge.where)
        names = sorted({c.variable for c in _variables(edge.guard.expression)})
        message = f"{vehicle.name} never reports what this guard needs ({', '.join(names)})"
        yield Refusal("unknowable", edge.where, message)


def _ways(chart: Chart, proof: Proof) -> Iterator[Refusal]:
    for child, edge in proof.backward.items():
        way = (f"{_name(edge.source)} ({edge.by.value})", _name(edge.target))
        where = edge.where if edge.where.line else _where(chart, edge.source)
        clocked = edge.by in (By.TIMEOUT, By.FOR, By.ELSE)
        rule = "no-way-up" if clocked else "endless"
        message = (
            f"{_name(child)} leads back to {_name(edge.target)}, without end"
            + (": clocks alone never lead to the surface" if clocked else "")
            + "; use repeat for rounds, and lead on with the exit"
        )
        yield Refusal(rule, where, message, way)
    for state in _legs(chart):
        if state.path not in proof.reached:
            assert state.leg is not None
            message = f"no way leads to {_name(state.path)}"
            yield Refusal("unreachable", state.leg.where, message)


def _bounds(
    chart: Chart, vehicle: Vehicle, proof: Proof, limits: envelope.Bounds
) -> Iterator[Refusal]:
    worst = proof.worst
    mission = chart.mission
    if proof.end is None or worst is None:
        if not proof.backward:
            yield Refusal("no-way-up", mission.where, "no way leads to the end of the mission")
        return
    if worst.time > limits.time:
        message = (
            f"the worst case takes {_minutes(worst.time)}, the ascent included; "
            f"the safety time is {_minutes(limits.time)}"
        )
        yield Refusal("time", mission.where, message, _path(worst))
    if proof.out_of_radius is not None:
        path, bounds = proof.out_of_radius
        message = (
            f"{_name(path)} may be {bounds.range:.0f} m from home, with current and uncertainty; "
            f"the radius is {limits.radius:.0f} m"
        )
        yield Refusal("radius", _where(chart, path), message, _path(bounds))
    if proof.out_of_depth is not None:
        path, bounds = proof.out_of_depth
        message = (
            f"{_name(path)} may reach {bounds.depth[1]:.1f} m; "
            f"the depth allowed is {limits.depth:.0f} m" + _floor_hint(chart, path)
        )
        yield Refusal("depth", _where(chart, path), message, _path(bounds))
    if worst.energy > vehicle.battery.usable:
        message = (
            f"the worst case takes {worst.energy / 3600:.0f} Wh, the ascent included; "
            f"usable are {vehicle.battery.usable / 3600:.0f} Wh"
        )
        yield Refusal("energy", mission.where, message, _path(worst))


def _floor_hint(chart: Chart, path: str) -> str:
    setpoint = chart.state(path).setpoint
    holds = setpoint is not None and setpoint.altitude is not None
    return "; end it sooner, or state the sea floor with assume floor" if holds else ""


def _where(chart: Chart, path: str) -> Where:
    state = next((s for s in chart.states if s.path == path), None)
    if state and state.leg and state.leg.where.line:
        return state.leg.where
    return chart.mission.where


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f} min"


def _path(bounds: Bounds | None) -> tuple[str, ...]:
    steps = [f"{_name(s.leg)} ({s.by.value}) {s.time:.0f} s" for s in trail(bounds)]
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
        path=_path(worst),
    )


def _assumed(chart: Chart, vehicle: Vehicle, assume: Assumptions, floor: bool) -> Iterator[str]:
    given = dict(chart.mission.assume)
    source = "the mission" if "current" in given else "the vehicle file"
    yield f"current at most {assume.current:g} m/s ({source})"
    yield f"started within {assume.start:g} m of home"
    yield f"speed by gear as in the vehicle file, within {SPEED_SHARE:.0%} (two sigma)"
    yield f"heading within {math.degrees(assume.heading):.0f} deg (two sigma of sensor and bias)"
    yield f"ascent by buoyancy alone at {buoyancy.told(vehicle)}"
    yield f"battery {vehicle.battery.usable / 3600:.0f} Wh usable, powers as in the vehicle file"
    yield from _stated_rounding(chart, vehicle)
    if floor:
        why = "" if "floor" in given else ", the depth allowed; state assume floor where it is"
        yield f"sea floor nowhere deeper than {assume.floor:g} m{why}"
    if vehicle.constant_batteries:
        yield "the battery is watched from outside: this vehicle reports constants"
    yield "a dead Pi, or an STM32 that hangs with its thrusters on, does not happen"


def _stated_rounding(chart: Chart, vehicle: Vehicle) -> Iterator[str]:
    """What is held between the vehicle's steps, and is lost in its sensor's noise."""
    legs = ((s.leg, s.setpoint) for s in _legs(chart) if s.leg and s.setpoint)
    found = (r for leg, held in legs for r in rounded(leg, held, vehicle))
    for text in dict.fromkeys(f"{r} is sent as {r.nearest:g} {r.unit}" for r in found):
        yield f"{text}, the nearest that {vehicle.name} can be told"
