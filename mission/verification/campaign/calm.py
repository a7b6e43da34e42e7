"""Flights without faults: only currents, noise and the trim of the body.

A flight is a shipped mission on one of the profiles, with:

    - a current at the surface and another one at depth, each up to the one that the mission assumes
    - waves, uneven reports, depth noise up to 0.2 m, 8 to 20 N of buoyancy
    - the ground within reach of the altimeter

The law: no limit acts and no leg takes its ``else``; each of these is a false alarm. One ``else``
is excused: that of a leg above the ground whose altimeter truly received no echo for as long as R8
waits for one. Each ping is lost independently, so about one flight in a thousand loses so many in
a row.

What does not live here: the other laws of a flight (laws, whole_flight), faults (draw).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from random import Random

from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors
from links.simulated.settings import Settings
from mission.engine.run import BLIND_TIME
from mission.model import Mission, Step
from mission.model.vehicle import Vehicle
from mission.onboard.runtime.records import Recorder
from mission.verification.campaign.draw import Plan, Subject, in_a_seaway, profiles_of
from mission.verification.campaign.faults import ALARMED, FlightResult, fly_plan, result_of
from mission.verification.campaign.laws import Violation
from mission.verification.rig.trace import Heard, Trace
from mission.verification.rig.vehicle import body_of
from protocol.messages import Telemetry
from protocol.vehicles import codec

NOISE, BUOYANCY = 0.2, (8.0, 20.0)  # m, N
DEPTH = 45.0  # m: the depth where a mission states none
UNEVEN = 0.85  # share of an assumed floor: the least that is drawn


def calm(seed: int, number: int, subjects: Sequence[Subject]) -> Plan:
    rng = Random(f"calm {seed} {number}")
    subject = rng.choice(subjects)
    mission = subject.mission
    most, floor = mission.current(0.5), dict(mission.assume).get("floor")
    surface = rng.uniform(0.0, most), rng.uniform(0.0, math.tau)
    deep = rng.uniform(0.0, most), rng.uniform(0.0, math.tau)
    low, high = (UNEVEN * floor, floor) if floor is not None else _open_floor(mission)
    settings = Settings(
        Sea(surface, deep, rng.uniform(low, high)),
        SensorErrors(depth_noise=rng.uniform(0.0, NOISE)),
        replace(body_of(subject.vehicle), buoyancy=rng.uniform(*BUOYANCY)),
    )
    profile = rng.choice(profiles_of(subject.vehicle))
    vehicle_seed = rng.randrange(1 << 31)
    heading = rng.uniform(0.0, math.tau)
    plan = Plan(seed, number, subject, profile, vehicle_seed, settings, (), heading)
    return in_a_seaway(plan)


def _open_floor(mission: Mission) -> tuple[float, float]:
    """Return the bounds of the floor, m. The check takes the allowed depth for the floor."""
    allowed = mission.safety.depth or DEPTH
    return allowed, 1.03 * allowed


def alarms(trial: Trace, vehicle: Vehicle) -> Iterator[Violation]:
    """Yield the limits that acted and the legs that took their ``else``, but for the excused."""
    for event in trial.events:
        if not (isinstance(event, Step) and event.entered):
            continue
        if event.trigger == "limit" or event.trigger.endswith(":else"):
            if _without_an_echo(event, trial, vehicle):
                continue
            words = next((e.trigger for e in event.evaluations if e.result), event.trigger)
            yield Violation(ALARMED, event.t, f"{words}: {'; '.join(event.actions)}")


def _without_an_echo(step: Step, trial: Trace, vehicle: Vehicle) -> bool:
    blind = ("altitude", None) in (value for e in step.evaluations for value in e.values)
    return blind and all(
        not told.altitude
        for heard in trial.events
        if isinstance(heard, Heard) and step.t - BLIND_TIME <= heard.t <= step.t
        for told in codec(*vehicle.speaks).receive(heard.data, heard.t)
        if isinstance(told, Telemetry)
    )


def fly_calmly(plan: Plan, recorder: Callable[[], Recorder | None] = lambda: None) -> FlightResult:
    vehicle = plan.vehicle
    trial = fly_plan(plan, vehicle, recorder)
    return result_of(plan, trial, vehicle, plan.profile, more=tuple(alarms(trial, vehicle)))
