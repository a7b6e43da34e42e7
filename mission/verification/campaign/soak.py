"""The soak: missions in a row for days, with faults, and one program that lives through them.

After each flight the vehicle is towed home and recharged: another simulated vehicle, but the same
runtime (unless a fault kills it), store and black box. After every mission the soak measures its
memory. Whenever the black box continues in another part, the closed part must be whole, and is then
deleted. A calm soak has no faults, so one program lives through all of it.

What does not live here: what goes wrong (draw), outcomes that a flight must not have (laws), when
memory counts as grown (memory).
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random
from typing import Any

from links.simulated.link import START
from mission.model import Step
from mission.model.vehicle import Vehicle
from mission.onboard.blackbox import BlackBox, Gap, part_path
from mission.onboard.blackbox.reading import Reader
from mission.verification.campaign.audit import commands_of
from mission.verification.campaign.calm import alarms, calm
from mission.verification.campaign.draw import Plan, Subject, draw
from mission.verification.campaign.faults import FlightResult, Totals, result_of
from mission.verification.campaign.memory import Memory
from mission.verification.campaign.trial import try_out
from mission.verification.rig.acts import Act, Disturbance
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.trace import Event, Trace
from mission.verification.workers.progress import pace
from mission.verification.workers.telling import tell

DAY = 86400.0
PART = 4 << 20  # bytes of one part of the black box
LULL = 600.0  # s at most between two missions, adrift
_MEGABYTE = 1 << 20
_CLEAN = (b"@NSOOOCCO$", b"@SP,2000,240,100,10,$", b"@AC$")
RECENT = 5.0  # s: bytes of a flight may come from the last seconds of the one before
EVERY = 10.0  # s between two lines of progress, at least


@dataclass(slots=True)
class Soaked:
    days: float = 0.0
    missions: int = 0
    totals: Totals = field(default_factory=Totals)
    memory: Memory = field(default_factory=Memory)
    parts: int = 1
    megabytes: float = 0.0  # of the parts that were deleted
    broken_parts: int = 0
    interrupted: bool = False

    @property
    def held(self) -> bool:
        return self.totals.clean and self.memory.flat is not False and not self.broken_parts

    def as_json(self) -> dict[str, Any]:
        return (
            self.totals.as_json()
            | {"days": round(self.days, 2), "missions": self.missions}
            | self.memory.as_json()
            | {
                "black_box": {
                    "parts": self.parts,
                    "broken": self.broken_parts,
                    "mb": round(self.megabytes, 1),
                },
            }
        )


@dataclass(frozen=True, slots=True)
class Summary:
    """The result of a soak in another process: its JSON object, its text, whether all laws held."""

    found: Mapping[str, Any]
    stories: tuple[str, ...]
    held: bool


def soak(
    days: float,
    seed: int,
    subjects: Sequence[Subject],
    vehicle: Vehicle,
    folder: Path,
    told: Callable[[Soaked, FlightResult], None] = lambda soaked, result: None,
    *,
    calmly: bool = False,
) -> Soaked:
    """Run a soak; ``folder`` is for the black box, ``calmly`` means without faults. Ctrl-C ends it
    early and keeps the results."""
    box = BlackBox(folder / "soak.mcap", limit=PART)
    soaked = Soaked()
    try:
        _fly_on(soaked, days, seed, subjects, vehicle, calmly, box, told)
    except KeyboardInterrupt:
        soaked.interrupted = True
    box.close()
    return soaked


class Telling:
    """Tells missions that break a law at once (``story``), and every EVERY s how far the soak is
    (``progress``)."""

    def __init__(
        self,
        days: float,
        seed: int,
        vehicle: str,
        calmly: bool,
        story: Callable[[str], None],
        progress: Callable[[str], None],
    ) -> None:
        self._days, self._seed, self._of = days, seed, (vehicle, calmly)
        self._story, self._progress = story, progress
        self._begun = self._told = time.monotonic()

    def __call__(self, soaked: Soaked, result: FlightResult) -> None:
        for line in story(soaked, result, self._seed, *self._of):
            self._story(line)
        now = time.monotonic()
        if now - self._told >= EVERY:
            self._told = now
            left = max(self._days - soaked.days, 0.0)
            done = f"seed {self._seed}: {soaked.days:.2f} of {self._days:g} days"
            how = f"{soaked.missions} missions, {soaked.totals.broken} broken"
            rate = pace(soaked.days, left, now - self._begun)
            self._progress(f"{done}, {rate}, {how}, {soaked.memory}")


def soak_alone(
    days: float, subjects: Sequence[Subject], vehicle: Vehicle, calmly: bool, seed: int
) -> Summary:
    """Run one of several soaks, in any process."""
    stories: list[str] = []
    telling = Telling(days, seed, vehicle.name, calmly, tell, tell)

    def told(soaked: Soaked, result: FlightResult) -> None:
        stories.extend(story(soaked, result, seed, vehicle.name, calmly))
        telling(soaked, result)

    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        soaked = soak(days, seed, subjects, vehicle, Path(folder), told, calmly=calmly)
    if soaked.interrupted:
        raise KeyboardInterrupt
    words = (f"seed {seed}: {line}" for line in soaked.memory.in_words())
    return Summary(soaked.as_json(), (*stories, *words), soaked.held)


def story(
    soaked: Soaked, result: FlightResult, seed: int, vehicle: str, calmly: bool = False
) -> Iterator[str]:
    """Yield the report of a mission that broke a law, line by line."""
    if result.violations:
        yield f"mission {result.number}: {result.words}"
        for v in result.violations:
            yield f"  {v.kind} at {v.t:.1f} s: {v.says}"
        yield again(seed, vehicle, calmly, f"{math.ceil(100 * soaked.days) / 100:.2f}")


def again(seed: int, vehicle: str, calmly: bool, days: str) -> str:
    of = f"{' --calm' * calmly}{'' if vehicle == 'auv' else f' --vehicle {vehicle}'}"
    return f"  again: auvmission faults{of} --seed {seed} --soak {days}"


def _fly_on(
    soaked: Soaked,
    days: float,
    seed: int,
    subjects: Sequence[Subject],
    vehicle: Vehicle,
    calmly: bool,
    box: BlackBox,
    told: Callable[[Soaked, FlightResult], None],
) -> None:
    rng = Random(f"soak {seed}")
    program = _program(vehicle, box)
    elapsed = 0.0
    earlier: tuple[Event, ...] = ()
    while elapsed < days * DAY:
        number, lull = soaked.missions, rng.uniform(0.0, LULL)
        plan = calm(seed, number, subjects) if calmly else draw(seed, number, subjects, staged=0.0)
        trial = _flown(plan, lull, vehicle, program)
        program.begin_again(trial.truth.t)
        elapsed += trial.truth.t
        soaked.days, soaked.missions = elapsed / DAY, soaked.missions + 1
        told_of = replace(trial, events=(*earlier, *trial.events))
        earlier = last_words(told_of.events, told_of.truth.t)
        more = tuple(alarms(trial, vehicle)) if calmly else ()
        result = result_of(plan, told_of, vehicle, vehicle.dialect, whole=False, more=more)
        result = replace(result, violations=tuple(v for v in result.violations if v.t >= 0.0))
        soaked.totals.add(result)
        del trial, told_of
        soaked.memory.look(program.starts)
        _take_away(soaked, box)
        told(soaked, result)


def _flown(plan: Plan, lull: float, vehicle: Vehicle, program: Program) -> Trace:
    """Fly the next mission, from a program that lives on, and drift for ``lull`` s after it."""
    disturbances = [
        Disturbance(0.1, Act.FREE),
        *(Disturbance(1.0 + 5.0 * i, Act.SAY, frame) for i in range(3) for frame in _CLEAN),
        *plan.disturbances,
        Disturbance(lull, Act.FREE),
    ]
    return try_out(
        plan.subject.mission,
        vehicle,
        vehicle.dialect,
        plan.vehicle_seed,
        plan.settings,
        disturbances,
        heading=plan.heading,
        program=program,
    )


def last_words(events: Sequence[Event], end: float) -> tuple[Event, ...]:
    """Return what the audit of the next flight must know of this one, at the next flight's times.

    This flight ended at ``end``. The audit needs the state that was entered last, the last command
    to the vehicle (an ascent repeats its U12 for as long as its turn lasts, a board its frame for
    as long as nothing else is asked for), and the events of the last seconds.
    """
    steps = [e for e in events if isinstance(e, Step)]
    state = [e for e in steps if e.entered][-1:]
    command = [e for e in steps if commands_of(e)][-1:]
    recent = {id(e) for e in (*state, *command)} | {id(e) for e in events if e.t > end - RECENT}
    return tuple(replace(e, t=e.t - end) for e in events if id(e) in recent)


def _program(vehicle: Vehicle, box: BlackBox) -> Program:
    program = Program(vehicle, FillableStore(), START.timestamp(), lambda: box)
    program.boot(0.0, 0.0)
    return program


def _take_away(soaked: Soaked, box: BlackBox) -> None:
    """Read the closed parts of the black box, count the broken ones, and delete them all."""
    first = box.path.parent / "soak.mcap"
    while (part := part_path(first, soaked.parts)) != box.path:
        soaked.broken_parts += not _whole(part)
        soaked.megabytes += part.stat().st_size / _MEGABYTE
        part.unlink()
        soaked.parts += 1


def _whole(part: Path) -> bool:
    """Return whether a part was closed, and each of its records can be read."""
    items = list(Reader(None).read(part))
    gaps = any(isinstance(item, Gap) for item in items)
    return bool(items) and not gaps and part.stat().st_size <= 2 * PART
