"""Calibration from dives with fixes: speed, compass, current, noise of the motion and the sensors.

The fixes of each log teach its speed scale, compass bias, deviation and current (information). A
scale, a bias and a current differ from day to day. How much they differ is estimated first
(pooling). One day's log then counts as an estimate of the mean, with that variance added. Each
sigma that is written says how far another day may be from the mean. The current is that of the
waters of the last log.

A figure is taken over only if the logs know it better than the vehicle file does, or contradict the
vehicle file. Else the figure and its sigma stay as they were (FIGURES says what would teach them).

What does not live here: noise (courses, noise), drift and the check by dives (adrift, missed), the
texts (lessons).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from mission.analysis.adrift import Drift, drift, with_drift
from mission.analysis.courses import KEPT, Inputs, Motion, courses, motion
from mission.analysis.floating import Rise, rise_of
from mission.analysis.information import (
    DAY,
    FIGURES,
    FITTED,
    Figure,
    Information,
    information,
    precision,
)
from mission.analysis.missed import Stretch, compare, share_of, widened
from mission.analysis.noise import of_velocity, sensed
from mission.analysis.pooling import FEW, Pooled, pool
from mission.model import Position
from mission.model.vehicle import Vehicle
from mission.navigation.filter import Array
from mission.navigation.geodesy import LocalFrame
from protocol.messages import Fix

_CONTRADICTS = 3.0  # sigmas between logs and vehicle file
_SAME_WATERS = 20_000.0  # m between two logs
_TAUGHT = 0.5  # of the prior's width: a log with a larger sigma teaches nothing


class CalibrationError(ValueError):
    """The logs cannot calibrate; the message tells the operator what is missing."""


_CURRENT = len(FIGURES) - 1


@dataclass(frozen=True, slots=True)
class Lesson:
    """One sigma of a figure in the vehicle file and by the logs; whether the logs' is taken."""

    figure: Figure
    before: float
    logs: float
    taken: bool


@dataclass(frozen=True, slots=True)
class Calibrated:
    vehicle: Vehicle
    sigmas: tuple[float, float, float, float]  # scale, bias, sin and cos of the deviation
    stretches: tuple[Stretch, ...]
    held_out: bool  # each log was reckoned with a calibration from the other logs
    lessons: tuple[Lesson, ...]
    unheard: tuple[str, ...]  # noise figures for which the logs hold too little
    rise: Rise | None  # by buoyancy alone; None if the logs have no float test
    apart: tuple[tuple[int, str], ...] = ()  # outlier logs, and the figure concerned
    copies: tuple[tuple[int, int], ...] = ()  # logs left out, and the log that each copies
    waters: Position | None = None  # position at which the current was found
    trusted: float = 1.0  # factor on the sigmas that move a position, from the dives
    drift: Drift | None = None  # of the surface; None if no dive shows it

    def percent(self) -> tuple[float, float]:
        """Median error before and after, in % of distance."""
        known = [s for s in self.stretches if s.distance > 1.0]
        if not known:
            return math.nan, math.nan
        before = median(100.0 * s.before / s.distance for s in known)
        return before, median(100.0 * s.after / s.distance for s in known)


def calibrate(logs: Sequence[Inputs], vehicle: Vehicle) -> Calibrated:
    """Calibrate ``vehicle`` from logs. Raises CalibrationError."""
    logs = [sorted(log, key=lambda item: item.t) for log in logs]
    if not any(len([i for i in log if isinstance(i, Fix)]) >= 2 for log in logs):
        raise CalibrationError("no log has two fixes: there is nothing to compare with")
    copies = _copies(logs)
    once = [i for i in range(len(logs)) if i not in dict(copies)]
    logs = [logs[i] for i in once]
    moved = motion([course for log in logs for course in courses(log, vehicle)])
    begun, quiet = _moving(vehicle, moved)
    begun, silent = _afloat(begun, logs)
    taught = [information(log, begun) for log in logs]
    held_out = len(logs) > 1  # with a single log, the dives would judge what they taught
    adrift = drift(logs, _tried(begun, vehicle, taught)) if held_out else None
    if adrift is not None:
        begun = with_drift(begun, adrift.share, adrift.length)
        taught = [information(log, begun) for log in logs]
    fit = _fit(begun, vehicle, taught)
    done, unheard = sensed(fit.vehicle, logs, [s for t in taught for s in t.squares])
    stretches: list[Stretch] = []
    for i, tried in enumerate(_tried(begun, vehicle, taught)):
        stretches += compare(once[i], logs[i], vehicle, tried)
    learned = not quiet or any(lesson.taken for lesson in fit.lessons)
    share = share_of(stretches, proves=held_out or not learned)
    rise = rise_of(logs, vehicle.sensors.depth)
    done = widened(done, share)
    if rise is not None:
        done = replace(done, ascent_buoyancy=rise.at_least, ascent_measured=rise.day)
    return Calibrated(
        vehicle=done,
        sigmas=fit.sigmas,
        stretches=tuple(stretches),
        held_out=held_out,
        lessons=fit.lessons,
        unheard=(*unheard, *quiet, *silent),
        rise=rise,
        apart=tuple((once[i], name) for i, name in fit.apart),
        copies=copies,
        waters=taught[-1].origin,
        trusted=share,
        drift=adrift,
    )


def _copies(logs: Sequence[Inputs]) -> tuple[tuple[int, int], ...]:
    """Find logs that share more than a tenth of their positions with an earlier log."""
    places = [{(i.latitude, i.longitude) for i in log if isinstance(i, Fix)} for log in logs]
    found: dict[int, int] = {}
    for i, one in enumerate(places):
        for j in range(i):
            fewer = min(len(one), len(places[j]))
            if j not in found and i not in found and 10 * len(one & places[j]) > max(fewer, 20):
                found[i] = j
    return tuple(found.items())


def _moving(vehicle: Vehicle, moved: Motion | None) -> tuple[Vehicle, tuple[str, ...]]:
    """Add the motion noise and a first speed scale; also return what the logs do not teach."""
    known = vehicle.calibration
    if moved is None:
        return vehicle, ("motion",)
    few = math.sqrt(0.5 * KEPT / moved.seconds)  # relative error of a sigma of such a slow process
    if few > _TAUGHT or moved.sure > _TAUGHT * max(moved.along, known.speed_noise):
        return vehicle, ("motion",)
    scale = known.speed_scale * min(max(moved.scale, 0.3), 4.0)
    known = replace(
        known,
        speed_scale=scale,
        speed_noise=max(moved.along, 0.02),
        speed_time=KEPT,
        sway_noise=min(max(moved.across, 0.005), 0.2),
    )
    return replace(vehicle, calibration=known), ()


def _afloat(vehicle: Vehicle, logs: Sequence[Inputs]) -> tuple[Vehicle, tuple[str, ...]]:
    """Add the noise of the receiver's speed and course; also return what the logs do not teach."""
    noise = of_velocity(logs)
    if noise is None:
        return vehicle, ("fix_velocity",)
    return replace(vehicle, calibration=replace(vehicle.calibration, fix_velocity=noise)), ()


def _tried(begun: Vehicle, vehicle: Vehicle, taught: Sequence[Information]) -> list[Vehicle]:
    """Return the vehicle to reckon each log with: fitted to the other logs, if there are any."""
    if len(taught) == 1:
        return [_fit(begun, vehicle, taught).vehicle]
    others = [[t for t in taught if t is not own] for own in taught]
    return [_fit(begun, vehicle, each).vehicle for each in others]


# --- fit -----------------------------------------------------------------------------------------


def _believed(vehicle: Vehicle) -> tuple[float, float, float, float]:
    """Return one sigma of each of ``FIGURES`` in the vehicle file."""
    known = vehicle.calibration
    current = vehicle.current if known.current_sigma is None else known.current_sigma
    return known.speed_scale_sigma, vehicle.sensors.heading_bias, known.deviation_sigma, current


@dataclass(frozen=True, slots=True)
class _Days:
    """The variance between days of each of the six fitted values, and the outlier logs."""

    between: Array
    apart: frozenset[tuple[int, str]]
    near: tuple[int, ...]  # logs from the same waters as the last one


@dataclass(frozen=True, slots=True)
class _Fit:
    vehicle: Vehicle
    sigmas: tuple[float, float, float, float]
    lessons: tuple[Lesson, ...]
    apart: tuple[tuple[int, str], ...]


def _days(taught: Sequence[Information]) -> _Days:
    between, apart = np.zeros(len(FITTED)), set[tuple[int, str]]()
    near = tuple(i for i, t in enumerate(taught) if _same_waters(t.origin, taught[-1].origin))
    for row in (row for row in FIGURES if row.daily):
        among = near if row.name == "current" else tuple(range(len(taught)))
        pools = [_pooled(row, state, among, taught) for state in row.states]
        for ids, pooled in pools:
            apart |= {(ids[i], row.name) for i in pooled.apart}
        if pools:
            between[list(row.states)] = np.mean([pooled.between for _, pooled in pools])
    return _Days(between, frozenset(apart), near)


def _pooled(
    row: Figure, state: int, among: Sequence[int], taught: Sequence[Information]
) -> tuple[tuple[int, ...], Pooled]:
    """Pool one fitted value over the logs that teach it; also return their indices."""
    ids = tuple(i for i in among if taught[i].variances[state] < (_TAUGHT * row.wide) ** 2)
    found = [float(taught[i].found[state]) for i in ids]
    return ids, pool(found, [float(taught[i].variances[state]) for i in ids])


def _same_waters(one: Position | None, other: Position | None) -> bool:
    if one is None or other is None:
        return False
    lat, lon = math.radians(other.latitude_deg), math.radians(other.longitude_deg)
    return math.hypot(*LocalFrame(one).to_local(lat, lon)) < _SAME_WATERS


def _fit(begun: Vehicle, vehicle: Vehicle, taught: Sequence[Information]) -> _Fit:
    """Fit the figures to the logs. Figures that the logs do not teach are kept; in the fit of the
    others the vehicle file's sigma is their prior. The least taught figure is kept first, because
    the others may be well determined then."""
    days = _days(taught) if taught else _Days(np.zeros(len(FITTED)), frozenset(), ())
    good = [t for i, t in enumerate(taught) if i not in {i for i, _ in days.apart}]
    before = [max(s, 1e-4) for s in _believed(vehicle)]
    was = np.zeros(len(FITTED))
    was[0] = vehicle.calibration.speed_scale / begun.calibration.speed_scale - 1.0
    kept: dict[int, Lesson] = {}
    if len(days.near) < 2:
        row = FIGURES[_CURRENT]
        kept[_CURRENT] = Lesson(row, before[_CURRENT], row.wide, taken=False)
    while True:
        priors = [before[i] if i in kept else row.wide for i, row in enumerate(FIGURES)]
        x, sigmas, mean = _solved(priors, good, days, current_known=_CURRENT not in kept)
        free = [i for i in range(len(FIGURES)) if i not in kept]
        heard = {i: _lesson(FIGURES[i], before[i], x - was, sigmas, mean) for i in free}
        open_ = [i for i in free if not heard[i].taken]
        if not open_:
            break
        least = max(open_, key=lambda i: heard[i].logs / before[i])
        kept[least] = heard[least]
    for i in kept:
        states = list(FIGURES[i].states)
        x[states], sigmas[states] = was[states], before[i]
    lessons = tuple((heard | kept)[i] for i in range(len(FIGURES)))
    turn = taught[0].declination - vehicle.compass_bias if taught else 0.0
    a, b, c, d = sigmas.tolist()[:4]
    done = _with(begun, vehicle, lessons, x, turn, len(days.near))
    return _Fit(done, (a, b, c, d), lessons, tuple(sorted(days.apart)))


def _solved(
    priors: Sequence[float], taught: Sequence[Information], days: _Days, *, current_known: bool
) -> tuple[Array, Array, Array]:
    """Return the six fitted values, their sigmas for another day, and their sigmas as a mean over
    all days. If the current is not to be known, each log has a current of its own."""
    between = days.between.copy()
    now = list(FIGURES[_CURRENT].states)
    between[now] = max(between[now][0], DAY**2) if current_known else priors[_CURRENT] ** 2
    matrix, vector = precision(priors), np.zeros(len(FITTED))
    for t in taught:
        other = np.eye(len(FITTED)) + t.matrix * between
        matrix = matrix + np.linalg.solve(other, t.matrix)
        vector = vector + np.linalg.solve(other, t.vector)
    covariance = np.linalg.inv(matrix)
    spread = FEW**2 * days.between if len(taught) > 1 else 0.0
    own = np.diag(covariance)
    return covariance @ vector, np.sqrt(own + spread), np.sqrt(own)


def _lesson(row: Figure, before: float, off_by: Array, sigmas: Array, mean: Array) -> Lesson:
    """``off_by``: difference from the vehicle file; ``mean``: sigma of the mean over all days."""
    logs = max(float(sigmas[i]) for i in row.states)
    off = max(abs(float(off_by[i])) / math.hypot(before, float(mean[i])) for i in row.states)
    return Lesson(row, before, logs, logs < before or off > _CONTRADICTS)


def _with(
    begun: Vehicle, vehicle: Vehicle, lessons: Sequence[Lesson], x: Array, turn: float, near: int
) -> Vehicle:
    """Write the fit into the vehicle. ``turn``: the filter's deviation is a function of the
    corrected heading, so its phase is turned by this. ``near``: number of logs that teach the
    current; a few shrink it towards zero."""
    scale, bias, a, b, north, east = x.tolist()
    known, old = begun.calibration, vehicle.calibration.deviation
    c, s = math.cos(turn), math.sin(turn)
    told = [
        max(lesson.logs, min(lesson.figure.least, lesson.before)) if lesson.taken else before
        for lesson, before in zip(lessons, _believed(vehicle), strict=True)
    ]
    done = replace(
        known,
        speed_scale=known.speed_scale * (1.0 + scale),
        speed_scale_sigma=told[0],
        deviation=replace(old, sin1=old.sin1 + a * c - b * s, cos1=old.cos1 + a * s + b * c),
        deviation_sigma=told[2],
    )
    if lessons[_CURRENT].taken:
        few = near / (near + 1.0)
        done = replace(done, current=(few * north, few * east), current_sigma=max(told[3], DAY))
    return replace(
        vehicle,
        compass_bias=vehicle.compass_bias + bias,
        sensors=replace(vehicle.sensors, heading_bias=told[1]),
        calibration=done,
    )
