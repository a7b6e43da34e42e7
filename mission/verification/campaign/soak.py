"""The soak: missions in a row for days, with faults, and one program that lives through them.

After each flight the vehicle is towed home and recharged: another simulated vehicle, but the same
runtime (unless a fault kills it), store and black box. After every mission the soak measures memory
in three ways: the objects that the garbage collector knows, the blocks that Python has allocated
(strings and numbers too), and the resident memory of the process. Whenever the black box continues
in another part, the closed part must be whole, and is then deleted.

What does not live here: what goes wrong (draw), outcomes that a flight must not have (laws).
"""

from __future__ import annotations

import gc
import resource
import sys
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
from mission.onboard.blackbox import BlackBox, part_path, read_records
from mission.verification.campaign.draw import Subject, draw
from mission.verification.campaign.faults import FlightResult, Totals, result_of
from mission.verification.campaign.trial import try_out
from mission.verification.rig.acts import Act, Disturbance
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.trace import Event
from mission.verification.workers.progress import pace
from mission.verification.workers.telling import tell

DAY = 86400.0
PART = 4 << 20  # bytes of one part of the black box
LULL = 600.0  # s at most between two missions, adrift
_MEGABYTE = 1 << 20
_CLEAN = (b"@NSOOOCCO$", b"@SP,2000,240,100,10,$", b"@AC$")
RECENT = 5.0  # s: bytes of a flight may come from the last seconds of the one before
FLAT = 0.02  # share by which the live objects may differ between missions
FLAT_RESIDENT = 0.05  # the same of the process: its allocator gives little back
EVERY = 10.0  # s between two lines of progress, at least
SETTLED = 5  # missions, at least, until everything that is kept once exists
_STATM = Path("/proc/self/statm")


@dataclass(slots=True)
class Soaked:
    days: float = 0.0
    missions: int = 0
    totals: Totals = field(default_factory=Totals)
    objects: list[float] = field(default_factory=list)  # alive after each mission
    blocks: list[float] = field(default_factory=list)
    resident: list[float] = field(default_factory=list)  # MB; empty where the system does not tell
    parts: int = 1
    megabytes: float = 0.0  # of the parts that were deleted
    broken_parts: int = 0
    interrupted: bool = False

    @property
    def growth(self) -> dict[str, float]:
        """Return the growth of memory, as shares, since everything that is kept existed."""
        series = {"objects": self.objects, "blocks": self.blocks, "resident": self.resident}
        return {name: round(grown(values), 4) for name, values in series.items()}

    @property
    def flat(self) -> bool:
        growth = self.growth
        alive = max(growth["objects"], growth["blocks"])
        return alive < FLAT and growth["resident"] < FLAT_RESIDENT

    @property
    def held(self) -> bool:
        return self.totals.clean and self.flat and not self.broken_parts

    def as_json(self) -> dict[str, Any]:
        return self.totals.as_json() | {
            "days": round(self.days, 2),
            "missions": self.missions,
            "growth": self.growth,
            "resident_mb": round(self.resident[-1], 1) if self.resident else None,
            "black_box": {
                "parts": self.parts,
                "broken": self.broken_parts,
                "mb": round(self.megabytes, 1),
            },
        }

    def look_at_memory(self) -> None:
        gc.collect()
        self.objects.append(float(len(gc.get_objects())))
        self.blocks.append(float(sys.getallocatedblocks()))
        if _STATM.exists():
            pages = int(_STATM.read_text().split()[1])
            self.resident.append(pages * resource.getpagesize() / _MEGABYTE)


@dataclass(frozen=True, slots=True)
class Summary:
    """The result of a soak in another process: its JSON object, its text, whether all laws held."""

    found: Mapping[str, Any]
    stories: tuple[str, ...]
    held: bool


def grown(values: Sequence[float]) -> float:
    """Return the least of the last few values over the greatest of the second tenth, less one.

    So a leak shows, and a mission that is larger than the others does not. 0 for too few values.
    """
    if len(values) <= 2 * SETTLED:
        return 0.0
    tenth = max(len(values) // 10, SETTLED)
    return min(values[-SETTLED:]) / max(values[tenth : 2 * tenth]) - 1.0


def soak(
    days: float,
    seed: int,
    subjects: Sequence[Subject],
    vehicle: Vehicle,
    folder: Path,
    told: Callable[[Soaked, FlightResult], None] = lambda soaked, result: None,
) -> Soaked:
    """Run a soak; ``folder`` is for the black box. Ctrl-C ends it early and keeps the results."""
    box = BlackBox(folder / "soak.mcap", limit=PART)
    soaked = Soaked()
    try:
        _fly_on(soaked, days, seed, subjects, vehicle, box, told)
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
        story: Callable[[str], None],
        progress: Callable[[str], None],
    ) -> None:
        self._days, self._seed, self._vehicle = days, seed, vehicle
        self._story, self._progress = story, progress
        self._begun = self._told = time.monotonic()

    def __call__(self, soaked: Soaked, result: FlightResult) -> None:
        for line in story(soaked, result, self._seed, self._vehicle):
            self._story(line)
        now = time.monotonic()
        if now - self._told >= EVERY:
            self._told = now
            left = max(self._days - soaked.days, 0.0)
            done = f"seed {self._seed}: {soaked.days:.2f} of {self._days:g} days"
            how = f"{soaked.missions} missions, {soaked.totals.broken} broken"
            rate = pace(soaked.days, left, now - self._begun)
            self._progress(f"{done}, {rate}, {how}, growth {soaked.growth}")


def soak_alone(days: float, subjects: Sequence[Subject], vehicle: Vehicle, seed: int) -> Summary:
    """Run one of several soaks, in any process."""
    stories: list[str] = []
    telling = Telling(days, seed, vehicle.name, tell, tell)

    def told(soaked: Soaked, result: FlightResult) -> None:
        stories.extend(story(soaked, result, seed, vehicle.name))
        telling(soaked, result)

    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        soaked = soak(days, seed, subjects, vehicle, Path(folder), told)
    if soaked.interrupted:
        raise KeyboardInterrupt
    return Summary(soaked.as_json(), tuple(stories), soaked.held)


def story(soaked: Soaked, result: FlightResult, seed: int, vehicle: str) -> Iterator[str]:
    """Yield the report of a mission that broke a law, line by line."""
    if result.violations:
        yield f"mission {result.number}: {result.words}"
        for v in result.violations:
            yield f"  {v.kind} at {v.t:.1f} s: {v.says}"
        of = with_vehicle(vehicle)
        yield f"  again: auvmission faults{of} --seed {seed} --soak {soaked.days:.2f}"


def with_vehicle(name: str) -> str:
    return "" if name == "auv" else f" --vehicle {name}"


def _fly_on(
    soaked: Soaked,
    days: float,
    seed: int,
    subjects: Sequence[Subject],
    vehicle: Vehicle,
    box: BlackBox,
    told: Callable[[Soaked, FlightResult], None],
) -> None:
    rng = Random(f"soak {seed}")
    program = _program(vehicle, box)
    elapsed = 0.0
    earlier: tuple[Event, ...] = ()
    while elapsed < days * DAY:
        plan = draw(seed, soaked.missions, subjects, staged=0.0)
        lull = rng.uniform(0.0, LULL)
        disturbances = [
            Disturbance(1.0 + 5.0 * i, Act.SAY, frame) for i in range(3) for frame in _CLEAN
        ]
        trial = try_out(
            plan.subject.mission,
            vehicle,
            vehicle.dialect,
            plan.vehicle_seed,
            plan.settings,
            [
                Disturbance(0.1, Act.FREE),
                *disturbances,
                *plan.disturbances,
                Disturbance(lull, Act.FREE),
            ],
            heading=plan.heading,
            program=program,
        )
        program.begin_again(trial.truth.t)
        elapsed += trial.truth.t
        soaked.days, soaked.missions = elapsed / DAY, soaked.missions + 1
        told_of = replace(trial, events=(*earlier, *trial.events))
        earlier = last_words(told_of.events, told_of.truth.t)
        result = result_of(plan, told_of, vehicle, vehicle.dialect, whole=False)
        result = replace(result, violations=tuple(v for v in result.violations if v.t >= 0.0))
        soaked.totals.add(result)
        del trial, told_of
        soaked.look_at_memory()
        _take_away(soaked, box)
        told(soaked, result)


def last_words(events: Sequence[Event], end: float) -> tuple[Event, ...]:
    """Return what the audit of the next flight must know of this one, at the next flight's times.

    This flight ended at ``end``. The audit needs the state that was entered last, the last command
    (an ascent repeats its U12 for as long as its turn lasts), and the events of the last seconds.
    """
    steps = [e for e in events if isinstance(e, Step)]
    state = [e for e in steps if e.entered][-1:]
    command = [e for e in steps if e.actions][-1:]
    recent = {id(e) for e in (*state, *command)} | {id(e) for e in events if e.t > end - RECENT}
    return tuple(replace(e, t=e.t - end) for e in events if id(e) in recent)


def _program(vehicle: Vehicle, box: BlackBox) -> Program:
    program = Program(vehicle, FillableStore(), START.timestamp(), lambda: box)
    program.boot(0.0, 0.0)
    return program


def _take_away(soaked: Soaked, box: BlackBox) -> None:
    """Check the closed parts of the black box, count the broken ones, and delete them all."""
    first = box.path.parent / "soak.mcap"
    while (part := part_path(first, soaked.parts)) != box.path:
        whole = any(True for _ in read_records(part)) and part.stat().st_size <= 2 * PART
        soaked.broken_parts += not whole
        soaked.megabytes += part.stat().st_size / _MEGABYTE
        part.unlink()
        soaked.parts += 1
