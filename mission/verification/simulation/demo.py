"""The demonstration: a mission from its file to the vehicle and back home, over real bytes.

    auvmission vehicle   <-- pty ----------->  auvmission serve    <-- TCP -->  this process
    (board, body, GPS)   <-- pty: GPS ------>  (the Pi's program)               (the operator)

Three processes and one time factor. The operator uploads line by line, starts with ``@AA`` and
asks with ``@DU``; state and leg come from the events that ``serve --events`` prints. The results
come from the black box, and the true track from the simulated vehicle's own file.

What does not live here: the processes (staged), the command line (commands/demo), pictures (plot,
graph).
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from mission.analysis.ellipses import ellipse
from mission.authoring.language import script
from mission.authoring.prepare import Prepared
from mission.model import Estimate, NavigationMode, Position, Step
from mission.onboard.blackbox import read_parts
from mission.onboard.runtime.records import (
    ESTIMATE,
    STANDING,
    START,
    STEP,
    estimate_of,
    read_standing,
    read_start,
    step_of,
)
from mission.topside.console import converse
from mission.topside.upload import OperatorError, start, status, upload
from mission.verification.simulation.flightlog import Flight, FlightEnd, FlightLog
from mission.verification.simulation.staged import READY_S, DemoError, Lines, Stage, told_to_end
from mission.verification.simulation.truth import Home, Truth, read_truth
from protocol.messages import Status, StoreReport

POLL_S = 0.25  # real s between two @DU
PLANNED = frozenset({"until", "for", "end"})
LEFT = frozenset(
    {
        "gps",
        "graph.svg",
        "pi",
        "report.html",
        "serve.log",
        "serve.yaml",
        "track.png",
        "truth.csv",
        "vehicle",
        "vehicle.log",
        "vehicle.yaml",
    }
)  # files that a demonstration leaves in its folder, and that the next one may remove


@dataclass(slots=True)
class Progress:
    """What the operator sees during the flight."""

    lines: int = 0  # lines of the mission that are in the vehicle
    state: str = "idle"
    leg: str = ""
    depth: float | None = None
    position: tuple[float, float] | None = None  # m north and east of home, as estimated
    uncertainty: float | None = None  # m, the longer half axis of its 95 % ellipse
    started: float | None = None  # engine's time
    left: float | None = None  # s at most, by the check's worst case
    over: bool = False


@dataclass(frozen=True, slots=True)
class Demo:
    prepared: Prepared
    folder: Path
    speed: float
    vehicle: str  # file or name
    seed: int
    settings: tuple[str, ...]
    worst_time: float  # s
    tell: Callable[[str], None]
    show: Callable[[Progress], None]
    progress: Progress = field(default_factory=Progress)

    def fly(self) -> Flight:
        """Fly the demonstration. Raises DemoError, and OperatorError for what the Pi refuses."""
        self.folder.mkdir(parents=True, exist_ok=True)
        began = time.monotonic()
        with told_to_end(), self._stage.vehicle() as vehicle, self._stage.serve(vehicle) as events:
            ready = events.take(READY_S)
            topside, box = ready["topside"], Path(ready["black_box"])
            self.tell(f"the Pi listens on {topside}; its board is at {vehicle['vehicle']}")
            self._operate(topside, events)
        return self._flight(box, vehicle["wall"], time.monotonic() - began)

    @property
    def _stage(self) -> Stage:
        return Stage(self.prepared, self.folder, self.vehicle, self.speed, self.seed, self.settings)

    # --- the operator ------------------------------------------------------------------------

    def _operate(self, topside: str, events: Lines) -> None:
        lines = script(self.prepared.mission)
        talk = upload(lines, self.prepared.chart.digest, self._line)
        self.tell(converse(topside, talk))
        self.tell(converse(topside, start(patience=30)))
        deadline = time.monotonic() + 2.0 * self.worst_time / self.speed + READY_S
        while not self.progress.over:
            if time.monotonic() > deadline:
                raise DemoError("the mission is not over after twice its worst-case time")
            self._hear(events)
            with suppress(OperatorError):  # one lost answer: the next poll asks again
                converse(topside, status(self._told))
            self.show(self.progress)
            time.sleep(POLL_S)

    def _line(self, have: int, total: int) -> None:
        if have > self.progress.lines:
            self.progress.lines = have
            self.tell(f"  line {have} of {total} is in the vehicle")

    def _hear(self, events: Lines) -> None:
        for event in events.waiting():
            if "step" in event:
                self._step(step_of(json.dumps(event["step"])))
            elif "estimate" in event:
                self._estimate(estimate_of(json.dumps(event["estimate"])))

    def _estimate(self, estimate: Estimate) -> None:
        progress = self.progress
        if estimate.mode is not NavigationMode.NONE:
            progress.position = (estimate.north, estimate.east)
            progress.uncertainty = ellipse(estimate.covariance)[0] / 2.0
        if progress.started is not None:
            progress.left = max(0.0, self.worst_time - (estimate.t - progress.started))

    def _step(self, step: Step) -> None:
        progress = self.progress
        for path in step.entered:
            region, _, rest = path.partition("/")
            progress.state, progress.leg = region, rest
            if region == "autonomous" and progress.started is None:
                progress.started = step.t
            ended = path in ("idle/ready", "emergency/surfaced", "emergency/stopped")
            progress.over = progress.started is not None and ended

    def _told(self, told: Status, _: StoreReport | None) -> None:
        self.progress.depth = told.telemetry.depth if told.telemetry else None

    # --- the results ---------------------------------------------------------------------------

    def _flight(self, box: Path, vehicle_wall: float, wall: float) -> Flight:
        """Return the flight, from the black box and the true track. Places count from the home that
        the vehicle itself uses: a home taken from a fix has the error of that fix."""
        truth = self._truth()
        given = self.prepared.mission.home
        home = truth.begin if given is None else _radians(given)
        log, homes = FlightLog(self.prepared.mission), list[Home]()
        offset, last, state = 0.0, 0.0, "idle/ready"
        for record in read_parts(box):
            last = max(last, record.t)
            if record.kind == START:
                offset = (read_start(record).wall - vehicle_wall) * self.speed
            elif record.kind == STEP:
                step = step_of(record.payload)
                log.step(step)
                state = step.entered[-1] if step.entered else state
            elif record.kind == STANDING and (origin := read_standing(record).origin) is not None:
                home = _radians(origin)
            elif record.kind == ESTIMATE:
                log.estimate(estimate_of(record.payload))
                homes += [home] * (len(log.estimates) - len(homes))
        beside = zip(log.estimates, homes, strict=True)
        seen = tuple(truth.place(e.t + offset, counted) for e, counted in beside)
        at_surface = float(truth.depth[-1]) < 0.5
        digest, track = self.prepared.chart.digest, truth.track(home, offset)
        return log.flight("", FlightEnd(last, digest, wall, state, track, seen, at_surface))

    def _truth(self) -> Truth:
        path = self.folder / "truth.csv"
        if (truth := read_truth(path)) is None:
            raise DemoError(f"the simulated vehicle left no track in {path}")
        return truth


def _radians(position: Position) -> tuple[float, float]:
    return math.radians(position.latitude_deg), math.radians(position.longitude_deg)


def not_as_planned(flight: Flight) -> list[str]:
    """Return why the demonstration does not exit with 0: where and how it ended, and legs that were
    not left as planned."""
    found = [] if flight.at_surface else ["the vehicle is not at the surface"]
    if flight.outcome != "completed":
        found.append(f"the mission was not completed but {flight.outcome}")
    odd = [leg for leg in flight.legs if leg.by not in PLANNED]
    return found + [f"{leg.name} was left by {leg.by or 'nothing'}" for leg in odd]
