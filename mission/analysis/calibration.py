"""Calibration from dives with fixes: speed scale, compass bias, its deviation, noise figures.

Each log is filtered with wide priors; what its fixes taught about scale, bias and deviation is
the information that its posterior has beyond the prior (Maybeck, Stochastic Models, Estimation,
and Control 1, 1979, ch. 5.7: information adds over independent data), so logs of any length add
up. White noise of a sensor is what is left of its third differences (a ramp and a bend of it
cancel; Brockwell and Davis, Time Series, 1991, ch. 1.4).

A figure is taken over only where the logs know it better than the vehicle file says it is known, or
contradict that; else it stays as it was, and so does its sigma (FIGURES: what would teach it).

The proof is the error with which each dive ends: the estimate against the first fix that comes
again, with the vehicle file before and after; with several logs, "after" is calibrated on the
others. What does not live here: the texts (lessons).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from mission.analysis.floating import Rise, rise_of
from mission.model.vehicle import Sensors, Vehicle
from mission.navigation.filter import Array
from mission.navigation.model import COMPASS, COS, SCALE, SIN, STATES
from mission.navigation.navigator import Navigation
from protocol.messages import Fix, Telemetry

Inputs = Sequence[Telemetry | Fix]

_FITTED = (SCALE, COMPASS, SIN, COS)
_CONTRADICTS = 3.0  # sigmas between logs and vehicle file
_DIVE = 60.0  # s without a fix
ENOUGH = 20  # differences without which a noise figure stays as it was


class CalibrationError(ValueError):
    """The operator must act: these logs cannot calibrate; says what is missing."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A row of what is fitted: which of ``_FITTED``, how wide the logs may look for it, the least
    sigma that is believed, and what a log must hold to teach it."""

    name: str
    states: tuple[int, ...]
    wide: float
    least: float
    fly: str


FIGURES = (
    Figure("speed_scale", (0,), 0.3, 0.02,
           "legs of a minute or more there and back at the gears of the missions"),
    Figure("heading_bias", (1,), math.radians(15.0), math.radians(1.0),
           "legs of a minute or more on two headings or more"),
    Figure("deviation", (2, 3), math.radians(4.0), math.radians(0.5),
           "legs of a minute or more on four headings or more, all round"),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Lesson:
    """One sigma of a figure in the vehicle file and by the logs alone; whether theirs is taken."""

    figure: Figure
    before: float
    logs: float
    taken: bool


@dataclass(frozen=True, slots=True)
class Stretch:
    """A dive from one fix to another: what was missed at its end, of what was swum (m)."""

    log: int
    begin: float
    end: float
    distance: float
    before: float
    after: float


@dataclass(frozen=True, slots=True)
class Calibrated:
    vehicle: Vehicle
    sigmas: tuple[float, float, float, float]  # of scale, bias, and the deviation's sin and cos
    stretches: tuple[Stretch, ...]
    held_out: bool  # "after" was calibrated on other logs
    lessons: tuple[Lesson, ...]
    unheard: tuple[str, ...]  # sensors of which the logs hold too little for a noise figure
    rise: Rise | None  # by buoyancy alone; None: no float test in the logs

    def percent(self) -> tuple[float, float]:
        """Median error before and after, in % of distance."""
        known = [s for s in self.stretches if s.distance > 1.0]
        if not known:
            return math.nan, math.nan
        before = median(100.0 * s.before / s.distance for s in known)
        return before, median(100.0 * s.after / s.distance for s in known)


def calibrate(logs: Sequence[Inputs], vehicle: Vehicle) -> Calibrated:
    """Raises CalibrationError."""
    logs = [sorted(log, key=lambda item: item.t) for log in logs]
    if not any(len([i for i in log if isinstance(i, Fix)]) >= 2 for log in logs):
        raise CalibrationError("no log has two fixes: there is nothing to compare with")
    taught = [_information(log, vehicle) for log in logs]
    fit = _fit(vehicle, taught)
    done, unheard = _noise(fit.vehicle, logs)
    held_out = len(logs) > 1
    stretches: list[Stretch] = []
    for i, log in enumerate(logs):
        others = [t for j, t in enumerate(taught) if j != i]
        tried = _fit(vehicle, others).vehicle if held_out else fit.vehicle
        stretches += _compare(i, log, vehicle, tried)
    rise = rise_of(logs, vehicle.sensors.depth)
    if rise is not None:
        done = replace(done, ascent_buoyancy=rise.at_least, ascent_measured=rise.day)
    return Calibrated(done, fit.sigmas, tuple(stretches), held_out, fit.lessons, unheard, rise)


# --- fit -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Information:
    matrix: Array  # 4 x 4
    vector: Array
    declination: float


def _believed(vehicle: Vehicle) -> tuple[float, float, float]:
    """One sigma of each of ``FIGURES`` in the vehicle file."""
    known = vehicle.calibration
    return known.speed_scale_sigma, vehicle.sensors.heading_bias, known.deviation_sigma


def _precision(sigmas: Sequence[float]) -> Array:
    """Diagonal, of the four; ``sigmas`` of ``FIGURES``."""
    wide = [s for row, s in zip(FIGURES, sigmas, strict=True) for _ in row.states]
    return np.diag([1.0 / s**2 for s in wide])


def _information(log: Inputs, vehicle: Vehicle) -> _Information:
    """Of the four, about (scale - 1, bias, sin, cos), beyond the prior."""
    scale, bias, deviation = (row.wide for row in FIGURES)
    wide = replace(
        vehicle,
        sensors=replace(vehicle.sensors, heading_bias=bias),
        calibration=replace(
            vehicle.calibration, speed_scale_sigma=scale, deviation_sigma=deviation
        ),
    )
    nav = Navigation(wide)
    for item in log:
        if isinstance(item, Fix):
            nav.fix(item)
        else:
            nav.telemetry(item)
    x = nav.core.filter.x - np.eye(STATES)[SCALE]
    p = nav.core.filter.covariance[np.ix_(_FITTED, _FITTED)]
    matrix, prior = np.linalg.inv(p), _precision([row.wide for row in FIGURES])
    return _Information(matrix - prior, matrix @ x[list(_FITTED)], nav.declination)


@dataclass(frozen=True, slots=True)
class _Fit:
    vehicle: Vehicle
    sigmas: tuple[float, float, float, float]
    lessons: tuple[Lesson, ...]


def _fit(vehicle: Vehicle, taught: Sequence[_Information]) -> _Fit:
    """What is kept counts as sure as the vehicle file says while the others are fitted; of those
    that the logs do not teach the least taught is kept first, the others may be clear then."""
    before = [max(s, 1e-4) for s in _believed(vehicle)]
    kept: dict[int, Lesson] = {}
    while True:
        priors = [before[i] if i in kept else row.wide for i, row in enumerate(FIGURES)]
        x, sigmas = _solved(priors, taught)
        free = [i for i in range(len(FIGURES)) if i not in kept]
        heard = {i: _lesson(FIGURES[i], before[i], x, sigmas) for i in free}
        open_ = [i for i in free if not heard[i].taken]
        if not open_:
            break
        least = max(open_, key=lambda i: heard[i].logs / before[i])
        kept[least] = heard[least]
    for i in kept:
        states = list(FIGURES[i].states)
        x[states], sigmas[states] = 0.0, before[i]
    lessons = tuple((heard | kept)[i] for i in range(len(FIGURES)))
    turn = taught[0].declination - vehicle.compass_bias if taught else 0.0
    a, b, c, d = sigmas.tolist()
    return _Fit(_with(vehicle, lessons, x, turn), (a, b, c, d), lessons)


def _solved(priors: Sequence[float], taught: Sequence[_Information]) -> tuple[Array, Array]:
    """The four and their sigmas."""
    matrix = _precision(priors) + sum((t.matrix for t in taught), np.zeros((4, 4)))
    covariance = np.linalg.inv(matrix)
    x: Array = covariance @ sum((t.vector for t in taught), np.zeros(4))
    return x, np.sqrt(np.diag(covariance))


def _lesson(row: Figure, before: float, x: Array, sigmas: Array) -> Lesson:
    logs = max(float(sigmas[i]) for i in row.states)
    off = max(abs(float(x[i])) / math.hypot(before, float(sigmas[i])) for i in row.states)
    return Lesson(row, before, logs, logs < before or off > _CONTRADICTS)


def _with(vehicle: Vehicle, lessons: Sequence[Lesson], x: Array, turn: float) -> Vehicle:
    """``turn``: the filter's phase of the deviation is the corrected heading's."""
    scale, bias, a, b = x.tolist()
    known, old = vehicle.calibration, vehicle.calibration.deviation
    c, s = math.cos(turn), math.sin(turn)
    told = [
        max(lesson.logs, min(lesson.figure.least, lesson.before)) if lesson.taken else before
        for lesson, before in zip(lessons, _believed(vehicle), strict=True)
    ]
    return replace(
        vehicle,
        compass_bias=vehicle.compass_bias + bias,
        sensors=replace(vehicle.sensors, heading_bias=told[1]),
        calibration=replace(
            known,
            speed_scale=known.speed_scale * (1.0 + scale),
            speed_scale_sigma=told[0],
            deviation=replace(old, sin1=old.sin1 + a * c - b * s, cos1=old.cos1 + a * s + b * c),
            deviation_sigma=told[2],
        ),
    )


# --- noise ---------------------------------------------------------------------------------------


def _noise(vehicle: Vehicle, logs: Sequence[Inputs]) -> tuple[Vehicle, tuple[str, ...]]:
    """And the sensors of which there is too little to tell."""
    reports = [[i for i in log if isinstance(i, Telemetry)] for log in logs]
    depth = _white(reports, lambda t: t.depth)
    found = {
        "depth": (None if depth is None else depth * math.sqrt(2.0), 0.01),
        "altitude": (_white(reports, lambda t: t.altitude), 0.01),
        "heading": (_white(reports, lambda t: t.heading, circular=True), 2e-3),
        "fix": (_fix_noise(logs, vehicle), 0.01),
    }
    heard = {name: max(s, least) for name, (s, least) in found.items() if s is not None}
    sensors: Sensors = replace(vehicle.sensors, **heard)
    return replace(vehicle, sensors=sensors), tuple(n for n in found if n not in heard)


def _white(
    logs: Sequence[Sequence[Telemetry]],
    read: Callable[[Telemetry], float | None],
    *,
    circular: bool = False,
) -> float | None:
    """Sigma of white noise by the median of third differences: bends and repeats do not count."""
    found: list[float] = []
    for log in logs:
        for window in zip(*(log[i:] for i in range(4)), strict=False):
            values = [read(t) for t in window]
            if any(v is None for v in values) or len(set(values)) < 4:
                continue
            a, b, c, d = (float(v) for v in values if v is not None)
            third = d - 3.0 * c + 3.0 * b - a
            found.append(abs(math.remainder(third, 2.0 * math.pi) if circular else third))
    if len(found) < ENOUGH:
        return None
    return median(found) / 0.6745 / math.sqrt(20.0)  # of |normal|; 1 + 9 + 9 + 1


def _fix_noise(logs: Sequence[Inputs], vehicle: Vehicle) -> float | None:
    """By the innovations of fixes one second after another (the filter adds little to them)."""
    squares: list[float] = []
    for log in logs:
        nav = Navigation(vehicle)
        for item in log:
            if isinstance(item, Telemetry):
                nav.telemetry(item)
                continue
            last = nav.core.last_fix
            nav.fix(item)
            if last is not None and item.t - last < 1.5 and nav.core.fix_nis is not None:
                squares.append(item.accuracy**2 * nav.core.fix_nis / 2.0)
    return math.sqrt(sum(squares) / len(squares)) if len(squares) >= ENOUGH else None


# --- proof ---------------------------------------------------------------------------------------


def _compare(log_number: int, log: Inputs, before: Vehicle, after: Vehicle) -> list[Stretch]:
    one, two = (_missed(log, vehicle) for vehicle in (before, after))
    return [
        Stretch(log_number, a.begin, a.end, a.distance, a.error, b.error)
        for a, b in zip(one, two, strict=True)
    ]


@dataclass(frozen=True, slots=True)
class _Dive:
    begin: float
    end: float
    distance: float
    error: float


def _missed(log: Inputs, vehicle: Vehicle) -> list[_Dive]:
    """How far the estimate is from the first fix after each dive, before it is used."""
    nav, found = Navigation(vehicle), []
    last, swum, seen = -math.inf, 0.0, 0.0
    for item in log:
        if isinstance(item, Telemetry):
            nav.telemetry(item)
            estimate = nav.estimate(item.t)
            swum += abs(estimate.speed) * (item.t - seen) if estimate and seen else 0.0
            seen = item.t
            continue
        estimate = nav.estimate(item.t)
        if estimate is not None and nav.frame is not None and item.t - last >= _DIVE:
            north, east = nav.frame.to_local(item.latitude, item.longitude)
            if last > -math.inf:
                error = math.hypot(north - estimate.north, east - estimate.east)
                found.append(_Dive(last, item.t, swum, error))
        nav.fix(item)
        last, swum = item.t, 0.0
    return found
