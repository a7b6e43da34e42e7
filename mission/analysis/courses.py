"""Stretches of a log along which fixes came all the way: what they say of the noise of the motion.

A course is cut where fixes, reports or the heading end, and where the drive is unknown or not on: a
vehicle that drifts says nothing of how evenly it swims. Of each the speed's share v, the current c
and the compass's bias b are fitted by least squares over means of ``STEP`` s,

    d(north, east)/dt = v u cos(pitch) (ahead - b to starboard) + c

with u the speed that the thrusters let expect. What is left along the bow is the slow noise of the
speed (the part of which that v has swallowed is put back), what is left across it the sway; the
receiver's white noise, by third differences of its places, is taken off both. Of many courses
the median counts: one that was disturbed changes nothing.

What does not live here: what many logs say together (pooling, calibration).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
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
KEPT, SWAY = 200.0, 10.0  # s: a speed is kept for minutes, a sway is not
_APART = 10.0  # s between two fixes or reports of one course
_UNDER_WAY = 0.3  # m/s by the thrusters: slower is no course
_RIDGE, _ROUGH = 0.2, 0.15  # m/s: how far a current is expected to be from none; of a velocity
_SURE = 0.5  # of a sigma: what is known worse is not known


@dataclass(frozen=True, slots=True)
class Course:
    """Rows are reports: ``t`` s, ``ahead`` and ``place`` n x 2, m: where the thrusters' speed alone
    would have led, and where it was by its fixes; ``speed`` the mean of the thrusters' speed."""

    t: Array
    ahead: Array
    place: Array
    speed: float
    white: float  # m, of the fixes


@dataclass(frozen=True, slots=True)
class Motion:
    """``scale``: what the thrusters' speed is to be multiplied by. ``along``: one sigma of the
    speed, m/s; ``across``: of the sway, as a share of the speed. ``sure``: how well both are
    known, m/s."""

    scale: float
    along: float
    across: float
    sure: float


def courses(log: Inputs, vehicle: Vehicle) -> list[Course]:
    """``log`` in the order of its times."""
    nav, rows, fixes = Navigation(vehicle), list[tuple[float, ...]](), list[tuple[float, ...]]()
    for item in log:
        if isinstance(item, Fix):
            nav.fix(item)
            if nav.frame is not None and nav.core.last_fix == item.t:
                fixes.append((item.t, *nav.frame.to_local(item.latitude, item.longitude)))
            continue
        nav.telemetry(item)
        known = nav.core.heading is not None and nav.core.heading_loss(item.t) == 0.0
        driven = item.actuators is not None and nav.core.expected > _UNDER_WAY
        speed = nav.core.expected * math.cos(item.pitch or 0.0) if known and driven else math.nan
        rows.append((item.t, nav.core.heading or 0.0, speed))
    if len(fixes) < 2:
        return []
    return _cut(np.array(rows), np.array(fixes))


def _cut(rows: Array, fixes: Array) -> list[Course]:
    """``rows``: t, heading, speed (NaN: no course). ``fixes``: t, north, east."""
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
    place = np.column_stack([np.interp(t, fixes[:, 0], fixes[:, k]) for k in (1, 2)])
    inside = fixes[(fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1])]
    return Course(t, ahead, place, float(np.mean(speed)), white(inside[:, 1:].T))


def white(series: Sequence[Sequence[float]] | Array) -> float:
    """Sigma of white noise by the median of third differences: bends of a track do not count."""
    found = [abs(float(d)) for values in series for d in np.diff(np.asarray(values), n=3)]
    return median(found) / 0.6745 / math.sqrt(20.0) if found else 0.0  # 1 + 9 + 9 + 1


def motion(found: Sequence[Course]) -> Motion | None:
    """The medians over the courses; None without one."""
    if not found:
        return None
    fits = np.array([_fit(course) for course in found])
    scale, along, across, noise = (float(v) for v in np.median(fits, axis=0))
    windows = sum((c.t[-1] - c.t[0]) / STEP for c in found)
    sure = math.sqrt(noise / math.sqrt(windows))
    speed = float(np.median([c.speed for c in found])) * scale
    return Motion(scale, math.sqrt(max(along, 0.0)), math.sqrt(max(across, 0.0)) / speed, sure)


def _fit(course: Course) -> tuple[float, float, float, float]:
    """Share of the thrusters' speed; mean squares along and across, less the fixes' part, and
    that part ((m/s)^2)."""
    at = np.arange(course.t[0], course.t[-1], STEP)
    ahead, velocity = (
        np.diff([np.interp(at, course.t, track[:, k]) for k in (0, 1)], axis=1).T / STEP
        for track in (course.ahead, course.place)
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
    fixes = 2.0 * (course.white / STEP) ** 2
    unseen = in_the_mean((at[-1] - at[0]) / KEPT)
    slow = (float(np.mean(along * along)) - fixes) / (1.0 - unseen)
    return float(x[0]), slow, float(np.mean(across * across)) - fixes, fixes


def in_the_mean(x: float) -> float:
    """Share of a Gauss-Markov process's variance that its mean over x correlation times has."""
    return 2.0 / x * (1.0 - (1.0 - math.exp(-x)) / x)
