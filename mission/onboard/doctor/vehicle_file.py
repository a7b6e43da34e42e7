"""Findings from the vehicle file alone, without the vehicle: on the Pi and on the boat.

They name limits that can never act, whether the vehicle rises by itself, what happens if a computer
fails, and what has not been measured.
"""

from __future__ import annotations

from collections.abc import Iterator

from mission.engine.limits import LIMITS
from mission.model.vehicle import Vehicle
from mission.onboard.doctor.boards import board
from mission.onboard.doctor.buoyant import buoyant
from mission.onboard.doctor.findings import Finding, ok, warning


def of_file(vehicle: Vehicle) -> Iterator[Finding]:
    yield from never_acting(vehicle)
    yield from buoyant(vehicle)
    yield from assumed(vehicle)


def never_acting(vehicle: Vehicle) -> Iterator[Finding]:
    for row in LIMITS.values():
        if vehicle.drives and "depth" in row.needs:
            continue  # a limit for vehicles in the water
        if why := row.disarmed(vehicle):
            yield warning(
                f"limit {row.name}", f"can never act: {why}", "plan as if it were not there"
            )


def assumed(vehicle: Vehicle) -> Iterator[Finding]:
    its = board(vehicle)
    if its.silence is None:
        yield ok(
            "assumed",
            f"if the Pi dies while {its.name} is in automatic, the vehicle keeps its "
            "last setpoint until serve runs again",
            f"have the service manager restart serve (docs/operation.md); keep {its.beside}",
        )
    else:
        yield ok(
            "assumed",
            f"if the Pi dies, {its.name} goes neutral by itself after {its.silence:g} s",
            f"see it once on deck: kill serve, and watch; keep {its.beside}",
        )
    yield ok(
        "assumed",
        f"{its.name}, if it hangs, keeps {its.moves} as they are",
        f"have its hardware watchdog enabled; keep {its.beside}",
    )
    if vehicle.calibration == type(vehicle.calibration)():
        yield warning(
            "assumed",
            "speeds and turning are planning figures, not measured",
            "fly missions/surface-shakedown.yaml, then auvmission calibrate"
            if vehicle.codec == "auv"
            else "measure them by hand (auvmission stick), and set them in the vehicle file",
        )
