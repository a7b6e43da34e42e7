"""What goes wrong in flight ``number`` of the fault campaign with seed ``seed``: always the same.

A flight has a mission, a profile, a sea with up to 0.5 m/s of current, and one to five disturbances
at random times, drawn from FAULTS and INCIDENTS. In a quarter of the flights all of them come
within 5 s. A fault may last for ever, unless nobody can control the vehicle meanwhile (OUT_OF_HAND)
or it changes the vehicle's weight: such a vehicle physically cannot be brought home.

What does not live here: what a fault or an incident does (links.simulated.faults, disturbances).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random

from links.simulated.board_faults import ANY
from links.simulated.sea import Sea
from links.simulated.settings import FaultEvent, Settings, setting_of
from mission.authoring.language import script
from mission.model import Mission
from mission.model.vehicle import Vehicle
from mission.verification.campaign.disturbances import INCIDENTS
from mission.verification.campaign.fitting import beaconed, fit
from mission.verification.campaign.scene_texts import mission_of
from mission.verification.campaign.staging import faults_of, scenes_of, staged_on
from mission.verification.campaign.trial import FOREVER
from mission.verification.rig.acts import Disturbance
from mission.verification.rig.vehicle import body_of, flown, home_of

MOST = 5  # disturbances a flight
CURRENT = 0.5  # m/s
HORIZON = 0.4  # share of the proved time: about what a mission really takes
OF_BOARD = 0.15  # the same for the short missions of the other vehicles
AT_START, TOGETHER = 0.1, 0.4  # shares of the disturbances
CLUSTERED, CLUSTER = 0.25, 5.0  # share of the flights, s: everything at nearly the same time
FOR_EVER = 0.15  # share of the faults that last so, where they may
OUT_OF_HAND = frozenset(
    {
        *("stm32_hang", "command_lost", "command_corrupted", "unexplained_dive", "deaf_to_x"),
        *("refuses", "thrust_dead"),
    }
)
WEIGHT = frozenset({"heavy", "light"})
STAGED, BESIDE = 0.7, 0.4  # share of flights with a scene; of those, with a disturbance beside it
ROUGH, AMPLITUDE, WAVE_PERIOD = 0.5, (0.05, 0.75), (3.5, 12.0)  # share of the flights; m, s
AIR = -0.2, 0.4  # m of depth, by an air pressure of 980 to 1040 hPa
AIR_OF_BOARDS = -0.2, 0.25  # m: with more, a vehicle without a receiver never knows it is up (R7)
SKY, SETTLE = (0.0, 3.0), (0.0, 20.0)  # m: error of fixes for minutes; of the first fixes
ANSWERS = (0.0, 0.1, 0.2, 0.28)  # s that answers may take: with their bytes less than 0.3 (R1)
UNEVEN = (0.0, 0.2, 0.4, 0.6)  # s that a report may come early or late
SCENE_TIME, SCENE_FLOOR = 160.0, 30.0  # s of a scene that matter; m
IDLE = ("temperature_", "magnetometer_", "battery_")  # this vehicle decides nothing by them
SELDOM = 0.25  # times as often as others: idle faults, and those that need a fitted sensor
DOCUMENTED = "documented"
PROFILES = ("as-built", DOCUMENTED)


@dataclass(frozen=True, slots=True)
class Subject:
    """A mission to fly; ``proved_time`` is the check's, s."""

    path: Path
    mission: Mission
    proved_time: float

    @property
    def vehicle(self) -> str:
        return self.mission.vehicle


@dataclass(frozen=True, slots=True)
class Drawn:
    """An incident with its disturbances, at the flight's times."""

    name: str
    begin: float
    disturbances: tuple[Disturbance, ...]


@dataclass(frozen=True, slots=True)
class Plan:
    seed: int
    number: int
    subject: Subject
    profile: str
    vehicle_seed: int
    settings: Settings
    incidents: tuple[Drawn, ...]
    heading: float
    scene: str = ""
    silence: float | None = None  # s: the topside's longest allowed silence
    batteries: bool = False  # the vehicle reports their true voltages

    @property
    def vehicle(self) -> Vehicle:
        found = beaconed(flown(self.subject.vehicle), self.settings)
        return replace(found, constant_batteries=found.constant_batteries and not self.batteries)

    @property
    def kinds(self) -> tuple[str, ...]:
        return (
            *(event.name for event in self.settings.faults),
            *(drawn.name for drawn in self.incidents if drawn.name != self.scene),
            *([f"scene {self.scene}"] if self.scene else []),
        )

    @property
    def disturbances(self) -> tuple[Disturbance, ...]:
        return tuple(disturbance for drawn in self.incidents for disturbance in drawn.disturbances)

    def in_words(self) -> str:
        sea = self.settings.sea
        speed, direction = sea.current
        bias = self.settings.errors.depth_bias
        words = [
            f"{self.subject.path.stem} on {self.profile}",
            f"current {speed:.2f} m/s towards {math.degrees(direction):.0f} deg",
            f"floor {sea.floor:.0f} m",
            *([f"depth_bias={bias:g}"] if bias is not None else []),
            *([f"waves={sea.waves[0]:g}@{sea.waves[1]:g}"] if sea.waves[0] else []),
            *([f"fix_wander={wander:g}"] if (wander := self.settings.errors.fix_wander) else []),
            *([f"fix_settle={settle:g}"] if (settle := self.settings.errors.fix_settle) else []),
            *([f"uneven={self.settings.uneven:g}"] if self.settings.uneven else []),
            *([f"answers_late={late:g}"] if (late := self.settings.answers_late) else []),
            *(setting_of(event) for event in self.settings.faults),
            *(f"{drawn.name}@{drawn.begin:.1f}" for drawn in self.incidents),
        ]
        return ", ".join(words)


def draw(seed: int, number: int, subjects: Sequence[Subject], staged: float = STAGED) -> Plan:
    """Draw the plan of a flight; ``staged`` is the share of the flights with a scene."""
    rng = Random(f"faults {seed} {number}")
    if rng.random() < staged:
        return in_a_seaway(_staged(rng, seed, number, subjects))
    return in_a_seaway(_disturbed(rng, seed, number, subjects))


def stage(name: str, seed: int, vehicle: str = "auv") -> Plan:
    """Plan this scene and nothing else. Raises KeyError if it is not staged on the vehicle."""
    return _set_up(name, vehicle, Random(f"scene {name} {seed}"), seed, 0)


def profiles_of(vehicle: str) -> tuple[str, ...]:
    """Return the vehicle's profiles: only the AUV is known to differ from its document."""
    return PROFILES if vehicle == "auv" else (DOCUMENTED,)


def on_profile(plan: Plan, profile: str) -> Plan:
    """Set the profile; as built no batteries are reported, so such plans fly as documented."""
    return replace(plan, profile=DOCUMENTED if plan.batteries else profile)


def rows(subjects: Sequence[Subject]) -> tuple[str, ...]:
    """Return the rows that flights are drawn from: scenes, and missions by their file names."""
    return (*scenes_of(subjects[0].vehicle), *(subject.path.stem for subject in subjects))


def draw_row(row: str, rng: Random, seed: int, number: int, subjects: Sequence[Subject]) -> Plan:
    """Draw a flight of one of ``rows``. Every second flight of a scene has nothing beside it."""
    if row in scenes_of(subjects[0].vehicle):
        return in_a_seaway(_staged(rng, seed, number, subjects, row, BESIDE if number % 2 else 0.0))
    subject = {subject.path.stem: subject for subject in subjects}[row]
    return in_a_seaway(_disturbed(rng, seed, number, subjects, subject))


def in_a_seaway(plan: Plan) -> Plan:
    """Add uneven reports, waves, the air's pressure and errors of fixes to a plan.

    No firmware reports exactly every 2.000 s, and few seas are flat. The air's pressure offsets a
    depth that is the pressure less 10 dbar. Successive fixes share their error.
    """
    if plan.subject.vehicle == "robot":
        return plan
    rng, settings = Random(f"seaway {plan.vehicle_seed}"), plan.settings
    uneven, rough = rng.choice(UNEVEN), rng.random() < ROUGH
    waves = (round(rng.uniform(*AMPLITUDE), 2), round(rng.uniform(*WAVE_PERIOD), 1))
    sea = replace(settings.sea, waves=waves) if rough else settings.sea
    if plan.subject.vehicle != "auv":
        errors = replace(settings.errors, depth_bias=round(rng.uniform(*AIR_OF_BOARDS), 2))
        return replace(plan, settings=replace(settings, sea=sea, errors=errors))
    errors = replace(
        settings.errors,
        depth_bias=round(rng.uniform(*AIR), 2),
        fix_wander=round(rng.uniform(*SKY), 1),
        fix_settle=round(rng.uniform(*SETTLE)),
    )
    settings = replace(settings, sea=sea, errors=errors, uneven=uneven)
    return replace(plan, settings=replace(settings, answers_late=rng.choice(ANSWERS)))


def _staged(
    rng: Random,
    seed: int,
    number: int,
    subjects: Sequence[Subject],
    name: str = "",
    beside: float = BESIDE,
) -> Plan:
    """Draw a scene, in some flights with a disturbance beside it."""
    vehicle = subjects[0].vehicle
    plan = _set_up(name or _scene(vehicle, seed, number), vehicle, rng, seed, number)
    if rng.random() >= beside:
        return plan
    faults, incidents = [*plan.settings.faults], [*plan.incidents]
    begin = round(rng.uniform(8.0, SCENE_TIME / 2.0), 1)
    _disturb(rng, _troubles(rng, 1, vehicle)[0], begin, subjects, faults, incidents)
    settings = fit(plan.settings, faults, home_of(plan.subject.mission), rng)
    return replace(plan, settings=settings, incidents=tuple(incidents))


def _scene(vehicle: str, seed: int, number: int) -> str:
    """Return the scene of a flight.

    A round has every scene once, in a random order of its own. So a few hundred flights have all
    scenes.
    """
    order = list(scenes_of(vehicle))
    turn, place = divmod(number, len(order))
    Random(f"scenes {seed} {turn}").shuffle(order)
    return order[place]


def _set_up(name: str, vehicle: str, rng: Random, seed: int, number: int) -> Plan:
    scene = staged_on(vehicle, name, rng)
    current = _sea(rng).current if scene.current is None else (scene.current, 0.0)
    sea = Sea(current, None, SCENE_FLOOR)
    mission = mission_of(scene.text, vehicle)
    settings = Settings(sea=sea, body=body_of(vehicle))
    profile = rng.choice(profiles_of(vehicle))
    plan = Plan(
        seed,
        number,
        Subject(Path(scene.text), mission, SCENE_TIME),
        profile,
        rng.randrange(1 << 31),
        fit(settings, scene.faults, home_of(mission), rng),
        (Drawn(name, 0.0, scene.disturbances),),
        rng.uniform(0.0, math.tau),
        name,
        scene.silence,
        scene.batteries,
    )
    return on_profile(plan, profile)


def _disturbed(
    rng: Random,
    seed: int,
    number: int,
    subjects: Sequence[Subject],
    subject: Subject | None = None,
) -> Plan:
    subject = subject or rng.choice(subjects)
    profile = rng.choice(profiles_of(subject.vehicle))
    vehicle_seed = rng.randrange(1 << 31)
    sea = _sea(rng)
    heading = rng.uniform(0.0, math.tau)
    horizon = (HORIZON if subject.vehicle == "auv" else OF_BOARD) * subject.proved_time
    names = _troubles(rng, rng.randint(1, MOST), subject.vehicle)
    others = [s for s in subjects if s is not subject] or [subject]
    faults: list[FaultEvent] = []
    incidents: list[Drawn] = []
    for name, begin in zip(names, _begins(rng, len(names), horizon), strict=True):
        _disturb(rng, name, begin, others, faults, incidents)
    settings = Settings(sea=sea, body=body_of(subject.vehicle))
    settings = fit(settings, faults, home_of(subject.mission), rng)
    return Plan(seed, number, subject, profile, vehicle_seed, settings, tuple(incidents), heading)


def _troubles(rng: Random, count: int, vehicle: str) -> list[str]:
    """Draw names of the vehicle's faults and of INCIDENTS."""
    known = faults_of(vehicle)
    seldom = {name for name, row in known.items() if row.needs or name.startswith(IDLE)}
    names = (*known, *INCIDENTS)
    return rng.choices(names, [SELDOM if n in seldom else 1.0 for n in names], k=count)


def _disturb(
    rng: Random,
    name: str,
    begin: float,
    others: Sequence[Subject],
    faults: list[FaultEvent],
    incidents: list[Drawn],
) -> None:
    """Draw one row of FAULTS or INCIDENTS into the list that it belongs to."""
    if name not in INCIDENTS:
        faults.append(_fault(rng, name, begin))
        return
    lines = tuple(script(rng.choice(others).mission))
    disturbances = INCIDENTS[name].draw(rng, lines)
    incidents.append(
        Drawn(name, begin, tuple(_moved(disturbance, begin) for disturbance in disturbances))
    )


def _begins(rng: Random, count: int, horizon: float) -> list[float]:
    if rng.random() < CLUSTERED:
        first = _begin(rng, (), horizon)
        return [round(first + rng.uniform(0.0, CLUSTER), 1) for _ in range(count)]
    begins: list[float] = []
    for _ in range(count):
        begins.append(_begin(rng, begins, horizon))
    return begins


def _begin(rng: Random, others: Sequence[float], horizon: float) -> float:
    """Draw a time: anywhere, near the start, or near another, since troubles come together."""
    drawn = rng.random()
    if drawn < AT_START:
        begin = rng.uniform(1.0, 15.0)
    elif others and drawn < AT_START + TOGETHER:
        begin = max(1.0, rng.choice(others) + rng.uniform(-10.0, 30.0))
    else:
        begin = rng.uniform(1.0, horizon)
    return round(begin, 1)


def _sea(rng: Random) -> Sea:
    surface = rng.uniform(0.0, CURRENT), rng.uniform(0.0, math.tau)
    deep = (rng.uniform(0.0, CURRENT), rng.uniform(0.0, math.tau)) if rng.random() < 0.3 else None
    floor = rng.uniform(3.0, 60.0) if rng.random() < 0.8 else 150.0
    return Sea(surface, deep, floor)


def _fault(rng: Random, name: str, begin: float) -> FaultEvent:
    row = ANY[name]
    duration = round(row.duration * 10.0 ** rng.uniform(-0.5, 0.5), 1)
    if rng.random() < FOR_EVER and name not in OUT_OF_HAND | WEIGHT:
        duration = FOREVER
    value = round(row.value * rng.uniform(0.5, 1.5), 3) if row.unit else None
    return FaultEvent(name, begin, duration, value)


def _moved(disturbance: Disturbance, begin: float) -> Disturbance:
    return Disturbance(
        begin + disturbance.after,
        disturbance.act,
        disturbance.data,
        disturbance.link,
        disturbance.address,
    )
