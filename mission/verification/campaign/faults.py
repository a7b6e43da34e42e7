"""The fault campaign: disturbed flights by seed and number, and the totals of their results.

What does not live here: one flight (trial), what is drawn (draw), the laws of a flight (laws,
audit), where flights are flown (workers).
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from mission.authoring.prepare import Unreadable, check_prepared, prepare
from mission.model import AUTONOMOUS, STOPPED, SURFACING, Step
from mission.model.shipped import missions_folder, shipped_missions
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.records import Recorder
from mission.onboard.uncollected import uncollected
from mission.verification.campaign.draw import Plan, Subject, draw
from mission.verification.campaign.laws import (
    IGNORED,
    LOST,
    OVERRUN,
    RAISED,
    SPURIOUS,
    Violation,
    violations,
)
from mission.verification.campaign.margins import margins
from mission.verification.campaign.story import Story
from mission.verification.campaign.trial import Judge, known_judge, try_out
from mission.verification.campaign.whole_flight import kinds, throughout
from mission.verification.rig.trace import Located, Told, Trace
from mission.verification.rig.vehicle import flown

NOT_STARTED = "not started"
ALARMED = "alarmed"  # of flights without faults (calm)


@dataclass(frozen=True, slots=True)
class FlightResult:
    """The result of one flight; small, since it comes from another process.

    ``digest``: a hash of what was received, decided and sent, with its times, and of the truth at
    the end (digest_of).
    """

    number: int
    words: str
    kinds: tuple[str, ...]
    violations: tuple[Violation, ...]
    aborted: tuple[str, ...]
    digest: str = ""


@dataclass(slots=True)
class Totals:
    """``undone``: flights without a result."""

    flights: int = 0
    broken: int = 0  # flights that broke any law
    undone: int = 0
    kinds: Counter[str] = field(default_factory=Counter)
    aborted: Counter[str] = field(default_factory=Counter)
    violated: Counter[str] = field(default_factory=Counter)  # flights, by kind of violation
    digest: str = ""  # of all flights in their order

    def add(self, result: FlightResult) -> None:
        self.flights += 1
        self.broken += bool(result.violations)
        self.digest = sha256(f"{self.digest} {result.digest}".encode()).hexdigest()[:16]
        self.kinds.update(result.kinds)
        self.aborted.update(result.aborted)
        self.violated.update({violation.kind for violation in result.violations})

    @property
    def clean(self) -> bool:
        return not self.violated and not self.undone

    def as_json(self) -> dict[str, Any]:
        """Return the JSON object of one run: counts by fault, by kind of violation, by abort."""
        return {
            "flights": self.flights,
            "faults": dict(sorted(self.kinds.items())),
            "lost": self.violated[LOST],
            "overruns": self.violated[OVERRUN],
            "spurious": self.violated[SPURIOUS],
            "ignored": self.violated[IGNORED],
            "raised": self.violated[RAISED],
            **{kind: self.violated[kind] for kind in (*kinds(), ALARMED)},
            "aborted": dict(sorted(self.aborted.items())),
            "undone": self.undone,
            "digest": self.digest,
        }


def shipped() -> list[Path]:
    return sorted(missions_folder().glob("*.yaml"))


def subjects(paths: Iterable[Path], vehicle: str | None = None) -> list[Subject]:
    """Return the missions on ``vehicle``, as campaigns fly it; None: on their own vehicles.

    Raises Unreadable, or ValueError for a mission that the check refuses.
    """
    found = []
    for path in paths:
        prepared = prepare(path, None if vehicle is None else flown(vehicle))
        report = check_prepared(prepared)
        if not report.ok or report.proved is None:
            raise ValueError(f"{path}: refused by the check: {report.refusals[0].message}")
        mission = replace(prepared.mission, vehicle=prepared.vehicle.name)
        found.append(Subject(path, mission, report.proved.worst_time))
    return found


def fitting(vehicle: str) -> list[Subject]:
    """Return the shipped missions that fly on it: its own and the AUV's that the check passes."""
    found = []
    for path in shipped_missions().values():
        with contextlib.suppress(Unreadable, ValueError):
            if prepare(path).mission.vehicle in (vehicle, "auv"):
                found += subjects([path], vehicle)
    return found


def fly_plan(
    plan: Plan,
    vehicle: Vehicle,
    recorder: Callable[[], Recorder | None] = lambda: None,
    judge: Judge = lambda vehicle, digest: None,
) -> Trace:
    return try_out(
        plan.subject.mission,
        vehicle,
        plan.profile,
        plan.vehicle_seed,
        plan.settings,
        plan.disturbances,
        heading=plan.heading,
        recorder=recorder,
        configuration=replace(Configuration(), topside_silence=plan.silence),
        judge=judge,
    )


def fly_numbered(
    seed: int,
    number: int,
    known: Sequence[Subject],
    recorder: Callable[[], Recorder | None] = lambda: None,
) -> FlightResult:
    plan = draw(seed, number, known)
    vehicle = plan.vehicle
    with uncollected():  # the garbage collector finds nothing
        trial = fly_plan(plan, vehicle, recorder, known_judge)
        return result_of(plan, trial, vehicle, plan.profile)


def fly_near(plan: Plan) -> tuple[FlightResult, dict[str, float]]:
    """Fly a plan; return the result and how near the flight came to breaking each law."""
    vehicle = plan.vehicle
    trial = fly_plan(plan, vehicle)
    result = result_of(plan, trial, vehicle, plan.profile)
    if trial.raised:
        return result, {}
    settings = plan.settings
    story = Story(trial, trial.mission, vehicle, plan.profile, settings, plan.silence)
    return result, margins(story)


def result_of(
    plan: Plan,
    trial: Trace,
    vehicle: Vehicle,
    profile: str,
    *,
    whole: bool = True,
    more: Sequence[Violation] = (),
) -> FlightResult:
    """Judge a flight and return its result.

    ``whole``: the trial begins with the program, so that the laws of the whole flight apply.
    ``more``: violations that other laws have found.
    """
    mission = trial.mission
    found = [*violations(trial, mission, vehicle, profile, plan.settings), *more]
    if whole:
        found += throughout(trial, mission, vehicle, profile, plan.settings, plan.silence)
    found.sort(key=lambda violation: violation.t)
    return FlightResult(
        plan.number,
        plan.in_words(),
        plan.kinds,
        tuple(found),
        tuple(_aborts(trial)),
        digest_of(trial),
    )


def digest_of(trial: Trace) -> str:
    """Return a hash that is the same wherever the same flight is flown.

    Estimates and fixes are left out: their consequences are in the hash. Estimates take longest.
    """
    found = sha256()
    for event in trial.events:
        if not isinstance(event, Located | Told):
            found.update(repr(event).encode())
    found.update(repr((trial.truth, trial.state)).encode())
    return found.hexdigest()[:16]


def _aborts(trial: Trace) -> list[str]:
    """Return why missions did not come to their own end: limits, operators, restarts."""
    if trial.started is None:
        return [NOT_STARTED]
    reasons, state = [], ""
    for event in trial.events:
        if isinstance(event, Step) and event.entered:
            before, state = state, event.entered[-1]
            if event.trigger == "restart":
                reasons.append("restart")
            elif before.startswith(AUTONOMOUS) and state in (SURFACING, STOPPED):
                reasons.append(_reason(event))
    return reasons


def _reason(step: Step) -> str:
    limit = next((e.trigger for e in step.evaluations if e.trigger.startswith("limit ")), "")
    return limit or f"operator {step.trigger}"
