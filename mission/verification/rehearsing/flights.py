"""Rehearsed flights, each as a row of figures, on all cores.

A job has the content of mission, vehicle and sea floor: a worker elsewhere needs none of the files.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from links.simulated.settings import parse_settings
from mission.authoring.bathymetry import Depths
from mission.authoring.check.assumptions import Assumptions
from mission.authoring.check.bounds import LegBounds
from mission.authoring.prepare import Prepared
from mission.model import Chart
from mission.model.vehicle import Vehicle
from mission.onboard.runtime.mission_validator import MissionValidator
from mission.onboard.uncollected import uncollected
from mission.verification.rehearsing.sea import sea_of
from mission.verification.simulation.coverage import Coverage, coverage_of
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight
from mission.verification.simulation.reaching import Achieved, achieved_by
from mission.verification.simulation.seafloor import clearance, over
from mission.verification.workers import results
from mission.verification.workers.kept import Kept
from mission.verification.workers.outcome import Lost
from mission.verification.workers.places import Place
from mission.verification.workers.progress import Progress


@dataclass(frozen=True, slots=True)
class Rehearsed:
    """What all flights have in common. ``depths``: of the sea floor, None: as the mission assumes
    it; ``given``: valid settings of every flight, which are not drawn."""

    prepared: Prepared
    seed: int
    depths: Depths | None = None
    given: tuple[str, ...] = ()

    def settings(self, number: int) -> tuple[str, ...]:
        """Return the settings of flight ``number``, as texts."""
        of = self.prepared
        return sea_of(of.mission, of.vehicle, self.seed, number, self.given)


@dataclass(frozen=True, slots=True)
class Flown:
    """One flight, in SI units. ``surfaced``: the true place at the end, m from home, if the vehicle
    is at the surface.

    ``near``: for each limit, the greatest share of it that was used.
    """

    number: int
    settings: tuple[str, ...]
    outcome: str
    reason: str
    time: float
    energy: float
    error: float  # m, the greatest position error of the flight
    coverage: tuple[Coverage, ...]
    surfaced: tuple[float, float] | None
    near: tuple[tuple[str, float], ...]
    achieved: tuple[Achieved, ...] = ()
    clearance: float | None = None  # m, the least water under the vehicle, if the file has it
    legs: tuple[str, ...] = ()  # the legs that were flown, each once

    @property
    def covered(self) -> float:
        """The least share of an area that was truly seen; 1 if no leg states a swath."""
        return min((c.true for c in self.coverage), default=1.0)


def rehearsed(
    of: Rehearsed,
    flights: int,
    at: Place,
    kept: Kept[Flown] | None = None,
    progress: Progress | None = None,
) -> Iterator[Flown | Lost]:
    """Yield the flights in the order of their numbers, wherever they are flown."""
    judge = MissionValidator(of.prepared.vehicle)  # of each worker, which judges the mission once
    work = functools.partial(_one, of, judge)
    return results(work, range(flights), at, lambda number: f"flight {number}", kept, progress)


def _one(of: Rehearsed, judge: MissionValidator, number: int) -> Flown:
    with uncollected():  # until all objects of the flight are freed
        return _flown(of, judge, number)


def _flown(of: Rehearsed, judge: MissionValidator, number: int) -> Flown:
    prepared, depths = of.prepared, of.depths
    mission, vehicle = prepared.mission, prepared.vehicle
    settings = of.settings(number)
    sea = parse_settings(settings)
    if depths is not None:
        sea = over(sea, mission, depths)
    flight = fly(mission, vehicle, seed=of.seed + number, settings=sea, judge=judge)
    near = None if depths is None else clearance(flight, mission, depths)
    last = flight.track[-1] if flight.track and flight.at_surface else None
    covered = coverage_of(flight, mission)
    return Flown(
        number=number,
        settings=settings,
        outcome=flight.outcome,
        reason=flight.reason,
        time=flight.mission_time,
        energy=energy_of(flight, prepared.chart, vehicle),
        error=max((sample.error for sample in flight.samples), default=0.0),
        coverage=covered,
        surfaced=(last.north, last.east) if last is not None else None,
        near=_near(flight, prepared),
        achieved=achieved_by(flight, mission, covered),
        clearance=None if near is None else near.least,
        legs=tuple(dict.fromkeys(leg.name.partition("#")[0] for leg in flight.legs)),
    )


def energy_of(flight: Flight, chart: Chart, vehicle: Vehicle) -> float:
    """Return the energy of a flight in J, by the powers of the vehicle file: the power of each leg
    for as long as it lasted."""
    assume = Assumptions.of(chart.mission, vehicle, vehicle.limits.depth)
    power = {
        state.path.partition("/")[2]: LegBounds(state, vehicle, assume, None).power
        for state in chart.states
        if state.leg is not None
    }
    hotel = vehicle.battery.hotel
    return sum(
        (leg.left - leg.entered) * power.get(leg.name.partition("#")[0], hotel)
        for leg in flight.legs
    )


def _near(flight: Flight, prepared: Prepared) -> tuple[tuple[str, float], ...]:
    safety, hard = prepared.mission.safety, prepared.vehicle.limits
    used = {
        "time": flight.mission_time / min(hard.time, safety.time or math.inf),
        "radius": flight.max_range / min(hard.radius, safety.radius or math.inf),
        "depth": flight.max_depth / min(hard.depth, safety.depth or math.inf),
    }
    return tuple(used.items())
