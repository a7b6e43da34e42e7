"""Check the outputs that a mission sets: against the vehicle file, and against the setpoints.

    output lamp 80    a name of the file, 0..80, reversible, needed by no limit
    hold_depth 1      beside depth 5: the flag would work against the setpoint of the leg

What does not live here: how legs keep values (axes), when values are sent (engine).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from mission.authoring.compiler.refusing import refused
from mission.engine.variables import VARIABLES
from mission.legs import LEGS
from mission.model import (
    Axis,
    Edge,
    Group,
    Leg,
    Mission,
    Node,
    OutputSetting,
    Set,
    State,
    terms,
)
from mission.model.diagnostics import Diagnostic
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint
from protocol.vehicles import vehicle_row
from protocol.vehicles.channels import Source

_AXES = {"heading": Axis.HEADING, "turn": Axis.HEADING, "depth": Axis.VERTICAL}

_BY_HAND = "the operator sets it: auvmission output"


def outputs_of(mission: Mission) -> tuple[str, ...]:
    """The sorted names of all outputs that the mission sets."""
    found: set[str] = set()
    stack: list[Node] = list(mission.body)
    while stack:
        node = stack.pop()
        if isinstance(node, Group):
            stack += node.body
        else:
            found |= {output.name for output in node.outputs}
    return tuple(sorted(found))


def output_problems(node: Leg | Set, vehicle: Vehicle) -> Iterator[Diagnostic]:
    for given in node.outputs:
        output = vehicle.output(given.name)
        if output is None:
            there = ", ".join(o.name for o in vehicle.outputs) or "none"
            message = f"{vehicle.name} has no output {given.name}"
            yield _problem("unknown-output", given, message, f"its file names: {there}")
        elif output.irreversible:
            message = f"{given.name} cannot be taken back: it is no part of a mission"
            yield _problem("irreversible", given, message, _BY_HAND)
        elif output.needed:
            message = f"no mission may set {given.name}: {output.needed}"
            yield _problem("needed-output", given, message, _BY_HAND)
        elif fault := output.fault(given.value):
            yield _problem(
                "output-range", given, fault, f"as the vehicle file of {vehicle.name} says"
            )


def _problem(code: str, given: OutputSetting, message: str, hint: str) -> Diagnostic:
    return refused(code, given.where, message, hint)


def fight_problems(
    leg: Leg, setpoint: Setpoint, levels: Mapping[str, float], vehicle: Vehicle
) -> Iterator[Diagnostic]:
    """Refuse outputs that would work against the setpoint of the leg."""
    steers = LEGS[type(leg.kind)].steers
    for name, level in levels.items():
        output = vehicle.output(name)
        if output is None or level == output.safe:
            continue
        axis = next((a for a in output.excludes if _asked(a, setpoint, steers)), None)
        if axis is not None:
            message = f"output {name} and {axis} exclude each other"
            hint = f"write output {name} {output.safe:g} in {leg.name}, or leave {axis} out"
            where = next((o.where for o in leg.outputs if o.name == name), leg.where)
            yield refused("axis-clash", where, message, hint)


def _asked(axis: str, setpoint: Setpoint, steers: frozenset[Axis]) -> bool:
    value = getattr(setpoint, axis)
    return _AXES.get(axis) in steers or (value is not None and value != 0.0)


def complete(
    state: State, names: Iterable[str], levels: Mapping[str, Mapping[str, float]], vehicle: Vehicle
) -> State:
    """The state of a leg with the value of each output in ``names``: the one in ``levels`` (by
    leg), or else safe."""
    if state.leg is None:
        return state
    told = levels.get(state.path, {})
    outputs = [o for name in names if (o := vehicle.output(name)) is not None]
    return replace(state, outputs=tuple((o.name, told.get(o.name, o.safe)) for o in outputs))


def sources_of(edges: Iterable[Edge], vehicle: Vehicle) -> tuple[tuple[str, Source], ...]:
    """The readings of the vehicle file that guards use, each with its source."""
    guards = (edge.guard.expression for edge in edges if edge.guard is not None)
    asked = {name for guard in guards for term in terms(guard) for name in term.asks}
    rows = {source.name: source for source in vehicle_row(vehicle.codec).sources}
    names = sorted(name for name in asked if name not in VARIABLES and name in vehicle.readings)
    return tuple((name, rows[vehicle.readings[name]]) for name in names)
