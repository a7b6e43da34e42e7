"""Rehearsed flights, each as a row of figures, on all cores."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from links.simulated.settings import parse_settings
from mission.authoring.bathymetry import Depths, read_bathymetry
from mission.authoring.check.assumptions import Assumptions
from mission.authoring.check.bounds import LegBounds
from mission.authoring.importing.places import beside
from mission.authoring.prepare import Prepared, prepare_text
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
class Job:
    """What a worker needs to fly one flight; picklable."""

    text: str
    source: str
    vehicle: str | None
    parameters: tuple[tuple[str, str], ...]
    seed: int
    number: int
    bathymetry: str = ""  # a file of depths
    given: tuple[str, ...] = ()  # settings that are given, not drawn


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
    bathymetry: str = ""
    clearance: float | None = None  # m, the least water under the vehicle, if the file has it
    legs: tuple[str, ...] = ()  # the legs that were flown, each once

    @property
    def covered(self) -> float:
        """The least share of an area that was truly seen; 1 if no leg states a swath."""
        return min((c.true for c in self.coverage), default=1.0)


def rehearsed(
    prepared: Prepared,
    vehicle: str | None,
    parameters: dict[str, str],
    seed: int,
    flights: int,
    at: Place,
    kept: Kept[Flown] | None = None,
    bathymetry: str = "",
    given: tuple[str, ...] = (),
    progress: Progress | None = None,
) -> Iterator[Flown | Lost]:
    """Yield the flights in the order of their numbers, wherever they are flown. ``bathymetry``: a
    file that every worker can read. ``given``: valid settings of every flight."""
    named = tuple(sorted(parameters.items()))
    jobs = [
        Job(prepared.text, prepared.source, vehicle, named, seed, number, bathymetry, given)
        for number in range(flights)
    ]
    return results(_one, jobs, at, lambda job: f"flight {job.number}", kept, progress)


def _one(job: Job) -> Flown:
    with uncollected():  # until all objects of the flight are freed
        return _flown(job)


def _flown(job: Job) -> Flown:
    prepared, judge = _prepared(job.text, job.source, job.vehicle, job.parameters)
    mission, vehicle = prepared.mission, prepared.vehicle
    settings = sea_of(mission, vehicle, job.seed, job.number, job.given)
    sea, depths = parse_settings(settings), _depths(job.bathymetry)
    if depths is not None:
        sea = over(sea, mission, depths)
    flight = fly(mission, vehicle, seed=job.seed + job.number, settings=sea, judge=judge)
    near = None if depths is None else clearance(flight, mission, depths)
    last = flight.track[-1] if flight.track and flight.at_surface else None
    covered = coverage_of(flight, mission)
    return Flown(
        number=job.number,
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
        bathymetry=job.bathymetry,
        clearance=None if near is None else near.least,
        legs=tuple(dict.fromkeys(leg.name.partition("#")[0] for leg in flight.legs)),
    )


@functools.lru_cache(maxsize=1)
def _depths(path: str) -> Depths | None:
    return read_bathymetry(Path(path)) if path else None


@functools.lru_cache(maxsize=1)
def _prepared(
    text: str, source: str, vehicle: str | None, parameters: tuple[tuple[str, str], ...]
) -> tuple[Prepared, MissionValidator]:
    """Prepare the mission and its validator, once for all flights of a worker."""
    found = prepare_text(text, source, vehicle, dict(parameters), beside(Path(source)))
    return found, MissionValidator(found.vehicle)


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
