"""Motion noise, estimated from stretches of a log ("courses") with fixes all along.

A course ends where the fixes, the reports or the heading end, and where the thrust is unknown or
off: a drifting vehicle says nothing about how evenly it swims. Least squares over means of ``STEP``
s fit to each course the share v of the speed, the current c and the compass bias b:

    d(north, east)/dt = v u cos(pitch) (ahead - b to starboard) + c

u is the speed expected from the thrusters. The residual along the bow is the slow noise of the
speed (the part of it that v absorbed is added back). The residual across the bow is the sway. The
receiver's white noise, from third differences, is subtracted from both. The velocities over
``STEP`` come from the fixes' positions or, if that is less noisy, from the receiver's own speed and
course; these only on a steady course, as the filter uses them. The median over the courses counts,
so one disturbed course changes nothing.

What does not live here: pooling over many logs (pooling, calibration).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np
from numpy.typing import NDArray

from mission.model.vehicle import Vehicle
from mission.navigation.navigator import Navigation
from protocol.messages import Fix, Telemetry

Array = NDArray[np.float64]
Inputs = Sequence[Telemetry | Fix]

STEP = 5.0  # s over which velocities are taken from positions
SHORTEST = 60.0  # s
KEPT, SWAY = 200.0, 10.0  # s: a speed deviation lasts minutes, a sway does not
_APART = 10.0  # s between two fixes or reports of one course, at most
_UNDER_WAY = 0.3  # m/s by the thrusters: below this there is no course
_RIDGE, _ROUGH = 0.2, 0.15  # m/s: sigma of the current's prior; sigma of one velocity
_TURNS, _GATHERS = 0.15, 0.05  # rad, m/s between two windows: above this the course is not steady
_SETTLES = 2  # windows that are left out after that
_SURE = 0.5  # of a sigma: anything less certain counts as unknown


@dataclass(frozen=True, slots=True)
class Course:
    """One course; arrays have a row per report.

    ``ahead``, ``place``: n x 2, m. ``ahead`` is where the thrusters' speed alone would have led.
    ``place`` is the position by the fixes or by the receiver's speed and course, whichever has less
    noise; ``by_velocity``: by speed and course. ``speed``: mean of the thrusters' speed, m/s.
    ``noise``: variance of a velocity over ``STEP`` by the receiver, (m/s)^2. ``counts``: windows of
    ``STEP`` that show how evenly the vehicle swims."""

    t: Array
    ahead: Array
    place: Array
    speed: float
    noise: float
    counts: NDArray[np.bool_]
    by_velocity: bool


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion noise over all courses.

    ``scale``: factor on the thrusters' speed. ``along``: one sigma of the speed, m/s. ``across``:
    one sigma of the sway, as a share of the speed. ``sure``: uncertainty of both from the
    receiver's noise, m/s. ``seconds``: length of all courses together."""

    scale: float
    along: float
    across: float
    sure: float
    seconds: float


def courses(log: Inputs, vehicle: Vehicle) -> list[Course]:
    """Find the courses of one log, which is sorted by time."""
    nav, rows, fixes = Navigation(vehicle), list[tuple[float, ...]](), list[tuple[float, ...]]()
    for item in log:
        if isinstance(item, Fix):
            nav.fix(item)
            if nav.frame is not None and nav.core.last_fix == item.t:
                here = nav.frame.to_local(item.latitude, item.longitude)
                fixes.append((item.t, *here, *_velocity(item)))
            continue
        nav.telemetry(item)
        known = nav.core.heading is not None and nav.core.heading_loss(item.t) == 0.0
        driven = item.actuators is not None and nav.core.expected > _UNDER_WAY
        speed = nav.core.expected * math.cos(item.pitch or 0.0) if known and driven else math.nan
        rows.append((item.t, nav.core.heading or 0.0, speed))
    if len(fixes) < 2:
        return []
    return _cut(np.array(rows), np.array(fixes))


def _velocity(f: Fix) -> tuple[float, float]:
    """Return north and east velocity, m/s; NaN if the receiver gives none."""
    if f.speed is None or f.course is None:
        return math.nan, math.nan
    return f.speed * math.cos(f.course), f.speed * math.sin(f.course)


def _cut(rows: Array, fixes: Array) -> list[Course]:
    """``rows``: t, heading, speed (NaN: no course). ``fixes``: t, position, velocity."""
    t, at = rows[:, 0], fixes[:, 0]
    i = np.clip(np.searchsorted(at, t), 1, len(at) - 1)
    covered = (t >= at[0]) & (t <= at[-1]) & (at[i] - at[i - 1] <= _APART)
    good = covered & np.isfinite(rows[:, 2])
    ends = np.flatnonzero(~good[1:] | ~good[:-1] | (np.diff(t) > _APART)) + 1
    pieces = [p for p in np.split(np.arange(len(t)), ends) if good[p].all() and len(p) > 1]
    return [_course(rows[p], fixes) for p in pieces if t[p[-1]] - t[p[0]] >= SHORTEST]


def _course(rows: Array, fixes: Array) -> Course:
    t, heading, speed = rows.T
    velocity = speed[:, None] * np.column_stack((np.cos(heading), np.sin(heading)))
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(t)[:, None]
    ahead = np.vstack((np.zeros(2), np.cumsum(steps, axis=0)))
    (by_places, place), (by_way, way) = _placed(t, fixes), _made_good(t, fixes)
    steady, swum = _steady(_windows(t, ahead)), float(np.mean(speed))
    if by_way < by_places and steady.sum() * STEP >= SHORTEST:
        return Course(t, ahead, way, swum, by_way, steady, by_velocity=True)
    return Course(t, ahead, place, swum, by_places, np.ones_like(steady), by_velocity=False)


def _windows(t: Array, track: Array) -> Array:
    """Return mean velocities over ``STEP``, n x 2, m/s."""
    at = np.arange(t[0], t[-1], STEP)
    moved: Array = np.diff([np.interp(at, t, track[:, k]) for k in (0, 1)], axis=1).T / STEP
    return moved


def _placed(t: Array, fixes: Array) -> tuple[float, Array]:
    """Return the noise of a velocity over ``STEP``, and the fixes' positions at ``t``."""
    inside = fixes[(fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1])]
    place = np.column_stack([np.interp(t, fixes[:, 0], fixes[:, k]) for k in (1, 2)])
    return 2.0 * (white(inside[:, 1:3].T) / STEP) ** 2, place


def _made_good(t: Array, fixes: Array) -> tuple[float, Array]:
    """Return the same from the receiver's velocities; infinite noise if there are too few."""
    first, last = np.searchsorted(fixes[:, 0], t[[0, -1]], side="right")
    said = fixes[max(first - 1, 0) : last + 1]  # one before and one after
    if len(said) < 4 or not np.isfinite(said).all():
        return math.inf, np.zeros((len(t), 2))
    at, velocity = said[:, 0], said[:, 3:]
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(at)[:, None]
    way = np.vstack((np.zeros(2), np.cumsum(steps, axis=0)))
    place = np.column_stack([np.interp(t, at, way[:, k]) for k in (0, 1)])
    apart = float(at[-1] - at[0]) / (len(at) - 1)
    return white(velocity.T) ** 2 * apart / STEP, place


def white(series: Sequence[Sequence[float]] | Array) -> float:
    """Estimate the sigma of white noise by the median of third differences, which cancel curves."""
    found = [abs(float(d)) for values in series for d in np.diff(np.asarray(values), n=3)]
    return median(found) / 0.6745 / math.sqrt(20.0) if found else 0.0  # 1 + 9 + 9 + 1


def motion(found: Sequence[Course]) -> Motion | None:
    """Return the medians over the courses; None without a course."""
    if not found:
        return None
    fits = np.array([_fit(course) for course in _evened(found)])
    scale, along, across, noise = (float(v) for v in np.median(fits, axis=0))
    windows = sum(int(c.counts.sum()) for c in found)
    sure = math.sqrt(noise / math.sqrt(windows))
    speed = float(np.median([c.speed for c in found])) * scale
    seconds = sum(float(c.t[-1] - c.t[0]) for c in found)
    bow, side = math.sqrt(max(along, 0.0)), math.sqrt(max(across, 0.0)) / speed
    return Motion(scale, bow, side, sure, seconds)


def _evened(found: Sequence[Course]) -> list[Course]:
    """Give all courses by velocity the same noise, their median. It is the receiver's, and one
    course alone determines it to a sixth only, which is as much as the speed's own noise."""
    told = [course.noise for course in found if course.by_velocity]
    noise = median(told) if told else math.nan
    return [replace(c, noise=noise) if c.by_velocity else c for c in found]


def _fit(course: Course) -> tuple[float, float, float, float]:
    """Return the share of the thrusters' speed, the mean squares along and across the bow less the
    fixes' part, and that part ((m/s)^2)."""
    ahead, velocity = (
        _windows(course.t, track)[course.counts] for track in (course.ahead, course.place)
    )
    n = len(velocity)
    rows = np.zeros((2 * n + 2, 4))
    rows[:n, 0], rows[n : 2 * n, 0] = ahead[:, 0], ahead[:, 1]
    rows[:n, 1] = rows[n : 2 * n, 2] = 1.0
    rows[:n, 3], rows[n : 2 * n, 3] = ahead[:, 1], -ahead[:, 0]  # a bias turns the bow to port
    rows[2 * n, 1] = rows[2 * n + 1, 2] = _ROUGH / _RIDGE
    values = np.concatenate((velocity[:, 0], velocity[:, 1], (0.0, 0.0)))
    x = np.linalg.lstsq(rows, values, rcond=None)[0]
    left = (values - rows @ x)[: 2 * n].reshape(2, n)
    bow = (ahead / np.linalg.norm(ahead, axis=1, keepdims=True)).T
    along, across = (left * bow).sum(axis=0), left[1] * bow[0] - left[0] * bow[1]
    unseen = in_the_mean(STEP * len(course.counts) / KEPT)
    noise = course.noise * (1.0 - 2.0 / n)  # a fit of four parameters leaves this much of it
    slow = (float(np.mean(along * along)) - noise) / (1.0 - unseen)
    return float(x[0]), slow, float(np.mean(across * across)) - noise, noise


def _steady(ahead: Array) -> NDArray[np.bool_]:
    """Mark windows without a turn or a change of speed, and not within ``_SETTLES`` after one: the
    filter models how a hull slips and gathers way."""
    speed = np.hypot(*ahead.T)
    turned = ahead[1:, 0] * ahead[:-1, 1] - ahead[1:, 1] * ahead[:-1, 0]
    angle = np.abs(np.arctan2(turned, (ahead[1:] * ahead[:-1]).sum(axis=1)))
    changes = (angle > _TURNS) | (np.abs(np.diff(speed)) > _GATHERS)
    out = np.zeros(len(ahead), dtype=bool)
    for i in np.flatnonzero(changes):
        out[i : i + 2 + _SETTLES] = True
    return ~out


def in_the_mean(x: float) -> float:
    """Return the share of a Gauss-Markov process's variance that remains in its mean over x
    correlation times."""
    return 2.0 / x * (1.0 - (1.0 - math.exp(-x)) / x)
