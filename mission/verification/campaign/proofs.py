"""Flights within what the check assumed, against what it proved.

A mission that passed the check is flown in any current up to the assumed one, from any start within
the assumed distance of home, with a compass, a speed scale and a floor within the assumptions, with
failing sensors and lost links. From the start to the end of the mission (idle, or the surface after
an emergency) these laws hold:

    time    not past the proved worst time      range   never beyond the proved one
    depth   never beyond the proved one (that    energy  no more than was proved
            for a failed sensor, if one fails)  end     at the surface, by itself

Lost links are that to the boat, and the line's telemetry and answers. A line that loses commands
leaves the vehicle without control for so long; the fault campaign covers it.

What does not live here: what is proved (check), the flight (trial).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from random import Random

from links.simulated.board_faults import ANY
from links.simulated.plant import Body
from links.simulated.sea import Sea
from links.simulated.sensors import Health, Sensor, SensorErrors
from links.simulated.settings import FaultEvent, Settings, setting_of
from mission.authoring.check import Proved
from mission.authoring.check.assumptions import Assumptions
from mission.authoring.check.fenced import fenced
from mission.model import AUTONOMOUS, IDLE_READY, SURFACED, Mission, Step
from mission.model.vehicle import Vehicle
from mission.verification.campaign.area_laws import against
from mission.verification.campaign.disturbances import INCIDENTS
from mission.verification.campaign.draw import profiles_of
from mission.verification.campaign.home import AFLOAT
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.staging import faults_of
from mission.verification.campaign.trial import FOREVER, fault_ends, try_out
from mission.verification.rig.acts import Disturbance
from mission.verification.rig.trace import Trace, from_home
from mission.verification.rig.vehicle import body_of

MOST = 3  # faults a flight
BIAS = math.radians(4.0)  # one sigma of the compass; cut at two (assumed: 12 deg)
SPEED = 0.08  # one sigma of the speed scale; cut at two (assumed: 20 %)
LINKS = ("stm32_silent", "ack_lost", "bytes_corrupted", "line_noise", "splice")
LOST_LINKS = ("topside_lost", "topside_garbage", "topside_floods")
TIME, DEPTH, RANGE, ENERGY, END = "time", "depth", "range", "energy", "end"
AREA = "area"
_BLIND = ("depth_", "altitude_")
_DARK = ("depth_", "stm32_silent")
_RECEIVER = "gps_lost"  # only a vehicle with a receiver can have it
LOOKS_WELL = ("_stuck", "_drifting", "_late")  # of a sensor: unseen near the setpoint
LOSSES = (
    *(f"{s.name.lower()}_{h.value}" for s in Sensor for h in Health if h is not Health.HEALTHY),
    *("gps_lost", "gps_silent", "gps_corrupted", *LINKS),
)


@dataclass(frozen=True, slots=True)
class Claim:
    """A mission with its proof; ``source`` names it on a command line."""

    source: str
    mission: Mission
    proved: Proved


@dataclass(frozen=True, slots=True)
class Proof:
    """One flight of a claim, as drawn."""

    profile: str
    vehicle_seed: int
    settings: Settings
    disturbances: tuple[Disturbance, ...]
    offset: tuple[float, float]
    heading: float
    lost: tuple[str, ...]  # incidents, with their times

    def in_words(self) -> str:
        sea = self.settings.sea
        words = [
            self.profile,
            f"current {sea.current[0]:.2f} m/s towards {math.degrees(sea.current[1]):.0f} deg",
            f"floor {sea.floor:.1f} m",
            f"from {self.offset[0]:.0f} north {self.offset[1]:.0f} east",
            *(setting_of(event) for event in self.settings.faults),
            *self.lost,
        ]
        return ", ".join(words)


@dataclass(frozen=True, slots=True)
class Margin:
    """Bounds that a flight needed, or that were proved: s, m from home, m deep, J."""

    time: float
    range: float
    depth: float
    energy: float


_NOTHING = Margin(0.0, 0.0, 0.0, 0.0)
Draw = Callable[[Claim, Vehicle, int, int], Proof]


@dataclass(frozen=True, slots=True)
class Shown:
    """The result of one flight."""

    source: str
    flight: int
    words: str
    started: bool
    violations: tuple[Violation, ...]
    needed: Margin
    proved: Margin


def losses_of(vehicle: str) -> list[str]:
    """Return those of LOSSES that the vehicle can have."""
    there = faults_of(vehicle)
    return [name for name in LOSSES if name in there]


def draw_proof(claim: Claim, vehicle: Vehicle, seed: int, flight: int) -> Proof:
    rng = Random(f"proof {seed} {claim.mission.name} {flight}")
    allowed = claim.mission.safety.depth or vehicle.limits.depth
    assume = Assumptions.of(claim.mission, vehicle, min(allowed, vehicle.limits.depth))
    faults, disturbances, lost = [], [], []
    horizon = 0.4 * claim.proved.worst_time
    for name in rng.choices(
        [*losses_of(claim.mission.vehicle), *LOST_LINKS], k=rng.randint(0, MOST)
    ):
        begin = round(rng.uniform(8.0, 10.0 + horizon), 1)
        if name not in LOST_LINKS:
            faults.append(_loss(rng, name, begin))
        else:
            said = INCIDENTS[name].draw(rng, ())
            disturbances += [
                Disturbance(begin + d.after, d.act, d.data, d.link, d.address) for d in said
            ]
            lost.append(f"{name}@{begin}")
    away = rng.uniform(0.0, 0.9 * assume.start), rng.uniform(0.0, math.tau)
    return Proof(
        rng.choice(profiles_of(claim.mission.vehicle)),
        rng.randrange(1 << 31),
        Settings(_sea(rng, assume), _errors(rng), _body(rng, claim.mission.vehicle), tuple(faults)),
        tuple(disturbances),
        (away[0] * math.cos(away[1]), away[0] * math.sin(away[1])),
        rng.uniform(0.0, math.tau),
        tuple(lost),
    )


def _sea(rng: Random, assume: Assumptions) -> Sea:
    surface = assume.current * rng.choice([1.0, rng.random()]), rng.uniform(0.0, math.tau)
    deep = (assume.current * rng.random(), rng.uniform(0.0, math.tau))
    floor = max(3.0, assume.floor * rng.choice([1.0, 1.0, rng.uniform(0.3, 1.0)]))
    return Sea(surface, deep if rng.random() < 0.3 else None, min(floor, assume.floor))


def _errors(rng: Random) -> SensorErrors:
    return SensorErrors(compass_bias=_within(rng, BIAS))


def _body(rng: Random, vehicle: str) -> Body:
    """Draw the body. A simulated board has a body of its own, but for the weight."""
    body = body_of(vehicle)
    return replace(body, main_thrust=body.main_thrust * (1.0 + _within(rng, SPEED)) ** 2)


def _within(rng: Random, sigma: float) -> float:
    return min(max(rng.gauss(0.0, sigma), -2.0 * sigma), 2.0 * sigma)


def _loss(rng: Random, name: str, begin: float) -> FaultEvent:
    duration = round(ANY[name].duration * 10.0 ** rng.uniform(-0.5, 0.5), 1)
    return FaultEvent(name, begin, FOREVER if rng.random() < 0.15 else duration)


def show(claim: Claim, vehicle: Vehicle, seed: int, flight: int, draw: Draw = draw_proof) -> Shown:
    proof = draw(claim, vehicle, seed, flight)
    trial = try_out(
        claim.mission,
        vehicle,
        proof.profile,
        proof.vehicle_seed,
        proof.settings,
        proof.disturbances,
        offset=proof.offset,
        heading=proof.heading,
    )
    begun, ended = _times(trial)
    of = _proved(claim, vehicle, proof)
    words = f"{claim.source}: {proof.in_words()}"
    if trial.raised:
        raised = Violation("raised", trial.truth.t, trial.raised)
        return Shown(claim.source, flight, words, True, (raised,), _NOTHING, of)
    if begun is None:
        return Shown(claim.source, flight, words, False, (), _NOTHING, of)
    needed = _needed(trial, vehicle, begun, trial.truth.t if ended is None else ended)
    found = list(_violations(trial, of, begun, ended, needed))
    found += _areas(trial, claim.mission, begun, ended)
    return Shown(claim.source, flight, words, True, tuple(found), needed, of)


def _proved(claim: Claim, vehicle: Vehicle, proof: Proof) -> Margin:
    """Return the proved bounds, with the additions for the faults of the flight.

    Where a wrong reading looks healthy, the ascent from the blind depth is added. Where the depth
    is not believed, the time until fixes prove the surface is added: for ever without fixes.
    """
    proved = claim.proved
    faults = [event.name for event in proof.settings.faults if event.name.startswith(_BLIND)]
    depth = proved.blind_depth if faults else proved.max_depth
    longer = proved.blind_time if any(name.endswith(LOOKS_WELL) for name in faults) else 0.0
    if any(event.name.startswith(_DARK) for event in proof.settings.faults):
        longer += min(proved.dark_time, FOREVER)
    if any(name.startswith("depth_") for name in faults) and not _has_fixes(claim, proof):
        longer += FOREVER
    battery = vehicle.battery
    return Margin(
        proved.worst_time + longer,
        proved.max_range + longer * claim.mission.current(vehicle.current),
        depth,
        proved.worst_energy + longer * (battery.hotel + battery.vertical),
    )


def _has_fixes(claim: Claim, proof: Proof) -> bool:
    """Whether the vehicle has a receiver, and every failure of it ends."""
    lost = (e.name.startswith("gps_") and fault_ends(e) == math.inf for e in proof.settings.faults)
    return _RECEIVER in losses_of(claim.mission.vehicle) and not any(lost)


def _times(trial: Trace) -> tuple[float | None, float | None]:
    """Return when the mission began, and when it or its emergency ended; None if not."""
    begun = None
    for event in trial.events:
        if not isinstance(event, Step) or not event.entered:
            continue
        state = event.entered[-1]
        if begun is None and state.startswith(AUTONOMOUS):
            begun = event.t
        elif begun is not None and state in (IDLE_READY, SURFACED):
            return begun, event.t
    return begun, None


def _needed(trial: Trace, vehicle: Vehicle, begun: float, ended: float) -> Margin:
    places = [place for place in trial.track if begun <= place.t <= ended]
    thrust = places[-1].used - places[0].used if places else 0.0
    return Margin(
        ended - begun,
        max((math.hypot(*from_home(trial, place)) for place in places), default=0.0),
        max((place.depth for place in places), default=0.0),
        thrust + vehicle.battery.hotel * (ended - begun),
    )


def _areas(
    trial: Trace, mission: Mission, begun: float, ended: float | None
) -> Iterator[Violation]:
    """Yield the first place where the vehicle truly breaks an area."""
    fences = fenced(mission)
    for place in trial.track if fences else ():
        inside = begun <= place.t <= (trial.truth.t if ended is None else ended)
        here = from_home(trial, place)
        if inside and against(fences, here, place.depth):
            says = f"north {here[0]:.0f} east {here[1]:.0f}, {place.depth:.1f} m deep"
            yield Violation(AREA, place.t, f"{says}, breaks an area")
            return


def _violations(
    trial: Trace, proved: Margin, begun: float, ended: float | None, needed: Margin
) -> Iterator[Violation]:
    if needed.time > proved.time:
        says = f"{needed.time:.0f} s, proved {proved.time:.0f} s"
        yield Violation(TIME, begun + needed.time, says)
    if needed.range > proved.range:
        says = f"{needed.range:.0f} m from home, proved {proved.range:.0f} m"
        yield Violation(RANGE, begun, says)
    if needed.depth > proved.depth:
        says = f"{needed.depth:.1f} m deep, proved {proved.depth:.1f} m"
        yield Violation(DEPTH, begun, says)
    if needed.energy > proved.energy:
        says = f"{needed.energy / 3600:.1f} Wh, proved {proved.energy / 3600:.1f} Wh"
        yield Violation(ENERGY, begun, says)
    never_knows = proved.time >= FOREVER  # that the vehicle is up
    if (ended is None and not never_knows) or trial.truth.depth > AFLOAT:
        says = f"{trial.truth.depth:.1f} m deep, in {trial.state}"
        yield Violation(END, trial.truth.t, says)
