"""Setpoints between the steps of a vehicle's commands: the nearest step is sent, and reported.

    off by more than one sigma of the sensor that controls the hold  -> refused, with a hint
    off by less                                                      -> reported by the check

A hold at 4.5 m that is flown at 4 m never opens ``until depth >= 4.4``; half a degree of heading is
below the noise of any compass. A heading that the leg itself steers (goto) is updated all the time.

What does not live here: the steps themselves (each vehicle's codec).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mission.authoring.compiler.axes import axis_where
from mission.authoring.compiler.refusing import refused
from mission.engine.clearance import is_guarded
from mission.legs import LEGS
from mission.model import Axis, Leg, Where
from mission.model.diagnostics import Diagnostic
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint
from protocol.vehicles import vehicle_row

BETWEEN_STEPS = "between-steps"  # the code
_EXACT = 1e-6  # of a step; degrees were converted to radians and back


@dataclass(frozen=True, slots=True)
class Rounded:
    """A value that a leg holds, the ``nearest`` step that can be sent, and the steps ``below`` and
    ``above``; in m or deg, as in texts."""

    word: str
    unit: str
    wanted: float
    below: float
    above: float
    nearest: float
    bearable: bool
    where: Where

    def __str__(self) -> str:
        return f"{self.word} {self.wanted:g} {self.unit}"


@dataclass(frozen=True, slots=True)
class _Held:
    word: str
    value: float | None
    step: float
    sigma: float


def rounded(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Rounded]:
    """The values of the leg that cannot be sent exactly to this vehicle."""
    for held in _holds(leg, setpoint, vehicle):
        if held.value is None or held.step == 0.0:
            continue
        steps = held.value / held.step
        if abs(steps - round(steps)) < _EXACT:
            continue
        unit = "m" if held.word in ("depth", "altitude") else "deg"
        scale = held.step if unit == "m" else math.degrees(held.step)
        low = math.floor(steps)
        turns = round(360.0 / scale) if held.word == "heading" else 0
        below, above, nearest = (
            (n % turns if turns else n) * scale for n in (low, low + 1, round(steps))
        )
        off = abs(steps - round(steps)) * held.step
        wanted = round(steps * scale % 360.0 if turns else steps * scale, 9)
        bearable = off <= held.sigma
        place = axis_where(leg, held.word)
        yield Rounded(held.word, unit, wanted, below, above, nearest, bearable, place)


def granularity_problems(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[Diagnostic]:
    for found in rounded(leg, setpoint, vehicle):
        if not found.bearable:
            unit = found.unit
            yield refused(
                BETWEEN_STEPS,
                found.where,
                f"{vehicle.name} cannot be told {found}: it would hold {found.nearest:g} {unit}",
                f"write {found.below:g} {unit} or {found.above:g} {unit}",
            )


def _holds(leg: Leg, setpoint: Setpoint, vehicle: Vehicle) -> Iterator[_Held]:
    row, sigma = LEGS[type(leg.kind)], vehicle.sensors
    step = vehicle_row(vehicle.codec).granularity
    if row.ascends:
        return
    for depth in row.depths(leg.kind) or (setpoint.depth,):
        yield _Held("depth", depth, step.depth, sigma.depth)
    altitude = None if is_guarded(setpoint) else setpoint.altitude  # guarded: a depth is sent
    yield _Held("altitude", altitude, step.altitude, sigma.altitude)
    if Axis.HEADING not in row.steers:
        yield _Held("heading", setpoint.heading, step.heading, sigma.heading)
    yield _Held("pitch", setpoint.pitch, step.attitude, 0.0)
    yield _Held("roll", setpoint.roll, step.attitude, 0.0)
