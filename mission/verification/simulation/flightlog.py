"""The results of a flight: legs, outcome, errors, track. Logged in flight, added up at the end.

    outcome    completed   the mission's end was reached, timeouts included
               emergency   an emergency was entered at any time
               failed      neither: refused, or not at its end in time

Times of legs count from the mission's start. True figures come from the simulated vehicle, which
has its own geodesy. There is one estimate with its true place for every report.

What does not live here: the loop (flight), the pictures (plot).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from mission.authoring.compiler.parts import parted
from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    IMPLICIT_SURFACE,
    SURFACED,
    By,
    Estimate,
    Group,
    Leg,
    Mission,
    Node,
    Step,
    Tx,
)
from mission.onboard.stream.events import limit_of, reason_of


@dataclass(frozen=True, slots=True)
class LegFlown:
    """A leg of the flight; times in s from the start. ``by``: how it was left; "": it was active at
    the end.

    ``trigger``: the edge of the chart that was taken; "" if none was (an operator, a limit), and
    then ``why`` has the reason. ``seen``: the values that the edge's guard saw.
    """

    name: str
    entered: float
    left: float
    by: str
    trigger: str = ""
    seen: tuple[tuple[str, float | None], ...] = ()
    why: str = ""


class TruePlace(NamedTuple):
    """The true place of the vehicle: m north and east of home, m below the surface."""

    t: float
    north: float
    east: float
    depth: float


class Sample(NamedTuple):
    """Estimate and true place at one report of the mission."""

    t: float  # s from the start
    estimate: Estimate
    true: TruePlace

    @property
    def error(self) -> float:
        """The horizontal error, m."""
        e = self.estimate
        return math.hypot(e.north - self.true.north, e.east - self.true.east)


@dataclass(frozen=True, slots=True)
class Flight:
    outcome: str
    reason: str
    digest: str
    mission_time: float  # s
    wall: float  # s
    final_state: str
    legs: tuple[LegFlown, ...]
    max_depth: float  # m, true
    max_range: float  # m from home, true
    samples: tuple[Sample, ...]
    track: tuple[TruePlace, ...]  # one a second, t from the flight's beginning
    steps: tuple[Step, ...]
    sent: tuple[Tx, ...]
    at_surface: bool  # truly, at the end
    compass_bias: float | None = None  # rad, true; None: its compass has none, or not known

    @property
    def on_land(self) -> bool:
        """Whether the vehicle has no depth and reports none."""
        is_deep = any(s.estimate.depth is not None or s.true.depth for s in self.samples)
        return bool(self.samples) and not is_deep

    @property
    def error_end(self) -> float | None:
        return self.samples[-1].error if self.samples else None

    @property
    def error_p95(self) -> float | None:
        if not self.samples:
            return None
        errors = sorted(sample.error for sample in self.samples)
        return errors[math.ceil(0.95 * len(errors)) - 1]

    def as_json(self) -> dict[str, Any]:
        """The JSON object that ``simulate --json`` prints."""
        errors = {"end": _rounded(self.error_end), "p95": _rounded(self.error_p95)}
        return {
            "outcome": self.outcome,
            "reason": self.reason,
            "digest": self.digest,
            "mission_time_s": round(self.mission_time, 3),
            "wall_s": round(self.wall, 3),
            "real_time_factor": round(self.mission_time / self.wall, 1) if self.wall else None,
            "final_state": self.final_state,
            "legs": [
                {
                    "name": leg.name,
                    "entered_s": round(leg.entered, 3),
                    "left_s": round(leg.left, 3),
                    "by": leg.by,
                }
                for leg in self.legs
            ],
            "max_depth_m": round(self.max_depth, 3),
            "max_range_m": round(self.max_range, 3),
            "navigation_error_m": errors,
        }


@dataclass(frozen=True, slots=True)
class FlightEnd:
    """The state of the flight when its loop ended, at ``t``."""

    t: float
    digest: str
    wall: float
    state: str
    track: tuple[TruePlace, ...]
    beside: tuple[TruePlace, ...]  # the true place at each of the log's estimates
    at_surface: bool
    compass_bias: float | None = None  # rad


class FlightLog:
    """Log of a flight, which must be given every step and estimate, in order."""

    def __init__(self, mission: Mission) -> None:
        self._leg_paths = leg_paths(mission)
        self._visits: Counter[str] = Counter()
        self._open: tuple[str, float] | None = None
        self.legs: list[LegFlown] = []
        self.steps: list[Step] = []
        self.estimates: list[Estimate] = []  # those of the mission
        self.sent: list[Tx] = []
        self.started: float | None = None
        self.ended: float | None = None
        self.emergency = ""
        self.completed = False
        self._ending = ""

    def step(self, step: Step) -> None:
        self.steps.append(step)
        if self.started is None and any(path in self._leg_paths for path in step.entered):
            self.started = step.t
        if self.started is None:
            return
        for path in step.exited:
            if self._open and path == self._open[0]:
                self._close(step.t, step)
        for path in step.entered:
            self._enter(path, step)

    def estimate(self, estimate: Estimate) -> None:
        if self.started is not None and self.ended is None:
            self.estimates.append(estimate)

    def flight(self, operator_failure: str, report: FlightEnd) -> Flight:
        start = self.started or 0.0
        last = self.ended if self.ended is not None else report.t
        if self._open:
            self._close(last, None)
        outcome, reason = self._outcome(operator_failure, report)
        mission_track = [p for p in report.track if self.started is not None and p.t >= start]
        return Flight(
            outcome=outcome,
            reason=reason,
            digest=report.digest,
            mission_time=last - start if self.started is not None else 0.0,
            wall=report.wall,
            final_state=report.state,
            legs=tuple(self.legs),
            max_depth=max((p.depth for p in mission_track), default=0.0),
            max_range=max((math.hypot(p.north, p.east) for p in mission_track), default=0.0),
            samples=tuple(
                Sample(estimate.t - start, estimate, true)
                for estimate, true in zip(self.estimates, report.beside, strict=True)
            ),
            track=report.track,
            steps=tuple(self.steps),
            sent=tuple(self.sent),
            at_surface=report.at_surface,
            compass_bias=report.compass_bias,
        )

    def _outcome(self, operator_failure: str, report: FlightEnd) -> tuple[str, str]:
        if self.emergency:
            return "emergency", self.emergency
        if self.completed:
            return "completed", "the mission's end was reached"
        if operator_failure:
            return "failed", operator_failure
        if self.started is not None and self.ended is not None:
            return "failed", f"ended before its end: {self._ending}"
        return "failed", f"not at its end after {report.t:.0f} s, in {report.state}"

    def _enter(self, path: str, step: Step) -> None:
        if path in self._leg_paths:
            self._visits[path] += 1
            self._open, self.ended = (path, step.t), None
        elif path.startswith("emergency/"):
            self.emergency = self.emergency or _why(step)
        elif path.startswith("manual/"):
            self.ended = None
        if path in (SURFACED, IDLE_READY, IDLE_EMPTY):
            self.ended, self._ending = step.t, f"to {path} by {_why(step)}"
            self.completed = self.completed or step.by is By.END

    def _close(self, t: float, step: Step | None) -> None:
        assert self._open is not None
        path, entered = self._open
        start = self.started or 0.0
        name, visit = path.removeprefix(f"{AUTONOMOUS}/"), self._visits[path]
        numbered = name if visit == 1 else f"{name}#{visit}"
        left = LegFlown(numbered, entered - start, t - start, "")
        if step is not None:
            left = replace(
                left,
                by=step.by.value if step.by else "",
                trigger=step.trigger,
                seen=next((e.values for e in step.evaluations if e.trigger == step.trigger), ()),
                why=_why(step),
            )
        self.legs.append(left)
        self._open = None


def leg_paths(mission: Mission) -> frozenset[str]:
    """Return the path of every leg in the chart, the implicit one included."""
    return frozenset(_leg_paths(parted(mission.body), AUTONOMOUS)) | {IMPLICIT_SURFACE}


def leg_names(mission: Mission) -> tuple[str, ...]:
    """Return the names of the legs that the mission states, in order, as flights name them."""
    paths = _leg_paths(parted(mission.body), AUTONOMOUS)
    return tuple(path.removeprefix(f"{AUTONOMOUS}/") for path in paths)


def _leg_paths(body: Iterable[Node], parent: str) -> Iterator[str]:
    for node in body:
        if isinstance(node, Group):
            yield from _leg_paths(node.body, f"{parent}/{node.name}")
        elif isinstance(node, Leg):
            yield f"{parent}/{node.name}"


def _why(step: Step) -> str:
    """Return the reason of the first command, or the limit that acted; else the event."""
    return reason_of(step) if step.actions or limit_of(step) else step.event


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
