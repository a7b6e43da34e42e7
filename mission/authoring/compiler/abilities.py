"""Refuse legs and guards that the vehicle, by its file, can never follow or know.

Each check looks at one resolved leg and yields Diagnostics with the place in the text. What does
not live here: the proofs over time, place and energy (mission.authoring.check).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import replace

from mission.authoring.compiler.axes import axis_where, own_setpoint, statement_problems
from mission.authoring.compiler.directions import direction_problems
from mission.authoring.compiler.granularity import granularity_problems
from mission.authoring.compiler.outputs import output_problems
from mission.authoring.compiler.refusing import refused
from mission.engine.clearance import at_depth, is_guarded
from mission.engine.variables import CLOCK, VARIABLES
from mission.legs import LEGS
from mission.model import Axis, Expression, Leg, Trend, Where, terms
from mission.model.diagnostics import Diagnostic
from mission.model.tables import derived
from mission.model.units import GEARS
from mission.model.vehicle import CLOSED, Vehicle
from mission.navigation.health import CHANNELS
from protocol.codec import CannotEncode, VehicleCodec
from protocol.messages import Setpoint
from protocol.vehicles import codec


def leg_problems(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    found = [problem for check in _CHECKS for problem in check(leg, setpoint, vehicle)]
    yield from found or [
        *granularity_problems(leg, setpoint, vehicle),
        *_encodes(leg, setpoint, vehicle),
    ]


def own_problems(leg: Leg, vehicle: Vehicle) -> Iterator[Diagnostic]:
    """The problems of a leg that do not depend on what the legs before it set."""
    own = own_setpoint(leg)
    yield from statement_problems(leg)
    yield from output_problems(leg, vehicle)
    for check in _OWN:
        yield from check(leg, own, vehicle)
    yield from granularity_problems(leg, own, vehicle)
    gives = LEGS[type(leg.kind)].gives
    for leave in leg.exits:
        yield from guard_problems(leave.guard.expression, vehicle, leave.where, gives)


def _follows(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    wanted = {
        "surge": setpoint.surge != 0.0,
        "turn": setpoint.turn != 0.0,
        "heave": bool(setpoint.heave),
        "heading": setpoint.heading is not None,
        "depth": setpoint.depth is not None,
        "altitude": setpoint.altitude is not None and not is_guarded(setpoint),
        "attitude": setpoint.pitch is not None or setpoint.roll is not None,
    }
    needs = LEGS[type(leg.kind)].needs
    wanted["heading"] |= "heading" in needs
    wanted["depth"] |= "depth" in needs
    loop = vehicle.outer_loop
    for axis, asked in wanted.items():
        if asked and axis in CLOSED and loop is not None and not loop.confirmed:
            yield refused(
                "signs-unconfirmed",
                axis_where(leg, axis),
                f"{vehicle.name} holds no {axis}: nobody has confirmed its axes and signs",
                "auvmission doctor --signs, then write `confirmed:` under outer_loop",
            )
        elif asked and axis not in vehicle.follows:
            word = "pitch" if axis == "attitude" else axis
            yield refused(
                "vehicle-cannot-follow",
                axis_where(leg, word),
                f"{vehicle.name} cannot follow {axis}{_WORDS.get(axis, '')}",
                f"it follows {', '.join(sorted(vehicle.follows))}",
            )


_WORDS = {"surge": " (gear, speed)", "turn": " (left, right)", "heave": " (up, down)"}


def _reports(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    row = LEGS[type(leg.kind)]
    if is_guarded(setpoint) and "altitude" not in vehicle.reports:
        yield refused(
            "vehicle-cannot-know",
            axis_where(leg, "altitude"),
            f"{vehicle.name} never reports an altitude that a depth could be kept above",
            "hold the depth alone",
        )
    if row.awaits_fix(leg.kind) and "position" not in vehicle.reports:
        yield refused(
            "vehicle-cannot-know",
            leg.where,
            f"no fix can end this {row.name} leg: {vehicle.name} never reports a position",
            "write it without `until fix`: it ends at the surface",
        )
    for sensor in sorted(row.needs - vehicle.reports):
        yield refused(
            "vehicle-cannot-know",
            leg.where,
            f"a {row.name} leg needs {sensor}, which {vehicle.name} never reports",
            "hold a heading for a time instead",
        )


def _one_speed(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    horizontal = round(abs(setpoint.surge or setpoint.turn) * GEARS)
    vertical = round(abs(setpoint.heave or 0.0) * GEARS)
    if vehicle.one_speed and horizontal and vertical and horizontal != vertical:
        yield refused(
            "one-speed",
            axis_where(leg, "heave"),
            f"{vehicle.name} has one speed for both: gear {horizontal} ahead or turning and "
            f"gear {vertical} up or down cannot be held together",
            "write the same gear for both, or hold a depth",
        )


def _encodes(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    """Refuse a leg whose setpoint the vehicle's codec cannot encode."""
    row = LEGS[type(leg.kind)]
    if Axis.HEADING in row.steers and not row.ascends:
        setpoint = replace(setpoint, heading=0.0)
    for depth in row.depths(leg.kind) or (setpoint.depth,):
        wanted = replace(setpoint, depth=depth)
        if is_guarded(wanted):
            wanted = at_depth(wanted)
        if vehicle.outer_loop is not None:
            wanted = replace(wanted, depth=None, heading=None)
        fault = _cannot_say(vehicle.codec, vehicle.dialect, wanted)
        if fault:
            yield refused(
                "vehicle-has-no-word",
                leg.where,
                f"{vehicle.name} has no command for this leg: {fault}",
                "set what the message names in another way",
            )
            return


@functools.lru_cache(maxsize=1024)  # legs of one mission often have the same setpoint
def _cannot_say(name: str, dialect: str, setpoint: Setpoint) -> str:
    try:
        _codec(name, dialect).encode(setpoint)
    except CannotEncode as error:
        return str(error)
    return ""


@functools.lru_cache(maxsize=16)
def _codec(name: str, dialect: str) -> VehicleCodec:
    return codec(name, dialect, {})


def _figures(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    row = LEGS[type(leg.kind)]
    fault = row.fault(leg.kind)
    if fault:
        yield refused("leg-figures", leg.where, fault, "change these figures")
    for depth in (*row.depths(leg.kind), setpoint.depth):
        if depth is not None and depth > vehicle.limits.depth:
            yield refused(
                "too-deep",
                axis_where(leg, "depth"),
                f"depth {depth:g} m is below the hard limit of {vehicle.name}, "
                f"{vehicle.limits.depth:g} m",
                "stay above it",
            )


def _makes_way(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    row = LEGS[type(leg.kind)]
    if row.makes_way and setpoint.surge <= 0.0:
        yield refused(
            "no-way-on",
            leg.where,
            f"a {row.name} leg goes nowhere without way on",
            "add gear (1 to 12) or speed",
        )


def _bounded(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    if leg.duration is None and leg.timeout is None:
        yield refused(
            "no-time-bound",
            leg.where,
            f"{leg.name} is not bounded by time: it could last for ever",
            "add timeout (or for)",
        )
    for word, value in (("for", leg.duration), ("timeout", leg.timeout)):
        if value is not None and not 0.0 < value < float("inf"):
            yield refused(
                "no-time-bound",
                leg.where,
                f"{word} {value:g} s is no bound",
                "write a time greater than 0",
            )


@derived(LEGS)
def _given() -> frozenset[str]:
    """Variables that only some leg types have."""
    return frozenset().union(*(row.gives for row in LEGS.values()))


def guard_problems(
    expression: Expression, vehicle: Vehicle, where: Where, gives: frozenset[str] | None
) -> Iterator[Diagnostic]:
    """The problems of a guard. ``gives``: variables that not every leg type has, and this leg does;
    None: the guard does not belong to a leg."""
    for term in terms(expression):
        place = term.where if term.where.line else where
        for name in term.asks:
            yield from _asked(name, vehicle, place, gives)
        if isinstance(term, Trend):
            yield from _never_true(term, place)
            yield from _between_reports(term, vehicle, place)
    yield from direction_problems(expression, where)


def _asked(
    name: str, vehicle: Vehicle, place: Where, gives: frozenset[str] | None
) -> Iterator[Diagnostic]:
    variable = VARIABLES.get(name)
    if variable is None:
        if name not in vehicle.readings:
            yield refused(
                "unknown-variable",
                place,
                f"there is no variable {name!r}",
                f"known ones: {', '.join([*VARIABLES, *vehicle.readings])}",
            )
        return
    absent = [s for s in variable.source if s != CLOCK and s not in vehicle.reports]
    if absent:
        yield refused(
            "never-known",
            place,
            f"{name} can never be known: {vehicle.name} does not report {' nor '.join(absent)}",
            "use a variable that this vehicle reports",
        )
    elif gives is not None and name in _given() - gives:
        yield refused(
            "never-known",
            place,
            f"{name} is known only in {_legs_that_give(name)} legs",
            "use travelled, range or elapsed",
        )


def _legs_that_give(name: str) -> str:
    return ", ".join(sorted(row.name for row in LEGS.values() if name in row.gives))


def _between_reports(term: Trend, vehicle: Vehicle, place: Where) -> Iterator[Diagnostic]:
    """Refuse a window in which the vehicle hardly reports twice: the middle value of each three
    reports counts, and it is one report old."""
    period = vehicle.sensors.telemetry_period
    if not term.of_depth and term.window < 1.5 * period:
        yield refused(
            "never-known",
            place,
            f"nothing is known of {term.variable} within {term.window:g} s: "
            f"{vehicle.name} reports every {period:g} s",
            f"write within {2.0 * period:g} s or more",
        )


def _never_true(term: Trend, place: Where) -> Iterator[Diagnostic]:
    """Refuse a change that no believable reading makes: the sensor would count as broken."""
    row = CHANNELS.get(term.variable)
    if row is None:
        return
    most = row.high - row.low
    if not term.of_depth:
        most = min(most, row.rate * term.window)
    if term.amount > most:
        moves = "rises" if term.rises else "falls"
        yield refused(
            "never-true",
            place,
            f"{term.variable} never {moves} by so much: readings are believed to {most:g} "
            f"{VARIABLES[term.variable].unit}",
            "ask for less, or give it longer",
        )


_Check = Callable[[Leg, Setpoint, Vehicle], Iterator[Diagnostic]]
_OWN: tuple[_Check, ...] = (_bounded, _figures, _reports, _follows, _one_speed)
_CHECKS = (*_OWN, _makes_way)
