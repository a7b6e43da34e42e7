"""Reference methods to compare with, computed on the same rows. Errors in % of the path.

    runs      start    constant speed (mean over ground of the other runs), the heading as it is
              150 s    speed and current by regularised least squares on the first 150 s
    gliders   naive    the vehicle's own speed along its compass
              true     the same with the declination
              causal   the same with the current found in the dive before
              glide    the same with the speed by depth rate and pitch, as in the estimate

For runs each method is computed a second time with equal knowledge: the speed through the water,
the current and the compass bias that `calibrate` found from the other runs, as the estimate has
them. The least squares weigh a position with 5 m, and pull speed and current towards the given ones
with 0.2 m/s.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mission.analysis.recordings import NEAREST, Recording, held

Array = NDArray[np.float64]

_POSITION, _VELOCITY = 5.0, 0.2  # m, m/s
_ATTACK, _LEAST = np.radians(3.0), np.radians(8.0)  # rad: angle of attack; least pitch of a glide
_SLOWEST, _FASTEST = 0.03, 0.6  # m/s: least depth rate; greatest speed ahead


def ground_speed(run: Recording) -> float:
    return float(run.path[-1] / (run.t[-1] - run.t[0]))


@dataclass(frozen=True, slots=True)
class Known:
    """What is known before the run: speed and current, m/s, and the compass bias, rad."""

    speed: float
    current: tuple[float, float] = (0.0, 0.0)
    bias: float = 0.0


def constant_speed(run: Recording, heading: Array, given: Known) -> float:
    """Return the end error in % of the path."""
    moved = given.speed * _ahead(run.t, heading - given.bias)[-1]
    error = moved + run.t[-1] * np.array(given.current) - _place(run)[-1]
    return float(100.0 * np.hypot(*error) / run.path[-1])


def least_squares(run: Recording, heading: Array, given: Known, until: float) -> float:
    """Return the end error in % of the path since the last fix at ``until``."""
    heading = heading - given.bias
    ahead, place, known = _ahead(run.t, heading), _place(run), run.t <= until
    n, last = int(known.sum()), int(known.sum()) - 1
    rows = np.zeros((2 * n + 3, 3))
    rows[:n, 0], rows[n : 2 * n, 0] = ahead[known, 0], ahead[known, 1]
    rows[:n, 1] = rows[n : 2 * n, 2] = run.t[known]
    rows[: 2 * n] /= _POSITION
    rows[2 * n :] = np.eye(3) / _VELOCITY
    pulled = np.array((given.speed, *given.current)) / _VELOCITY
    values = np.concatenate((*(place[known].T / _POSITION), pulled))
    speed, *current = np.linalg.lstsq(rows, values, rcond=None)[0]
    moved = speed * (ahead[-1] - ahead[last]) + (run.t[-1] - run.t[last]) * np.array(current)
    error = place[last] + moved - place[-1]
    return float(100.0 * np.hypot(*error) / (run.path[-1] - run.path[last]))


def _ahead(t: Array, heading: Array) -> Array:
    """Return where a speed of 1 m/s along the heading would have led, n x 2."""
    dt = np.diff(t)
    steps = np.column_stack((np.cos(heading[:-1]) * dt, np.sin(heading[:-1]) * dt))
    return np.vstack((np.zeros(2), np.cumsum(steps, axis=0)))


def _place(run: Recording) -> Array:
    return np.column_stack((run.north, run.east))


@dataclass(frozen=True, slots=True)
class Dive:
    """A dive between the rows of two fixes. ``path``: distance that the vehicle believed to have
    swum, m; the distance between the fixes if its own speed was not recorded (``reckoned`` is
    False)."""

    begin: int
    end: int
    path: float
    reckoned: bool = True


def dives(glider: Recording, fixes: Sequence[int], deep: float, long: float) -> list[Dive]:
    """Find successive fixes ``long`` s or more apart with a depth of ``deep`` or more between
    them."""
    speed = held(glider.own_speed)
    found = []
    for a, b in itertools.pairwise(fixes):
        depth, t = glider.depth[a : b + 1], glider.t[a : b + 1]
        if t[-1] - t[0] >= long and np.nanmax(np.append(depth, 0.0)) >= deep:
            path = float(np.nansum(speed[a:b] * np.diff(t)))
            if path < NEAREST:
                ends = _place(glider)[[a, b]]
                path = max(float(np.hypot(*(ends[1] - ends[0]))), NEAREST)
                found.append(Dive(a, b, path, reckoned=False))
                continue
            found.append(Dive(a, b, path))
    return found


def glider_errors(
    glider: Recording,
    found: Sequence[Dive],
    declination: float,
    *,
    causal: bool,
    speed: Array | None = None,
) -> list[float]:
    """Return the error of each reckoned dive. ``causal``: use the current found in the dive before.
    ``speed``: horizontal, ahead, m/s; by default the vehicle's own."""
    heading = held(glider.heading) + declination
    speed = held(glider.own_speed) if speed is None else speed
    errors, current = [], np.zeros(2)
    for dive in (d for d in found if d.reckoned):
        rows = slice(dive.begin, dive.end)
        dt = np.diff(glider.t[dive.begin : dive.end + 1])
        swum = np.array([np.nansum(speed[rows] * f(heading[rows]) * dt) for f in (np.cos, np.sin)])
        ends = _place(glider)[[dive.begin, dive.end]]
        missed = ends[1] - ends[0] - swum
        duration = float(glider.t[dive.end] - glider.t[dive.begin])
        errors.append(float(100.0 * np.hypot(*(missed - current * duration)) / dive.path))
        if causal:
            current = missed / duration
    return errors


def glide_speed(glider: Recording) -> Array:
    """Return the horizontal speed, m/s: depth rate over the tangent of the path angle (as in
    mission.navigation.model)."""
    known = np.isfinite(glider.depth)
    rate = np.gradient(np.interp(glider.t, glider.t[known], glider.depth[known]), glider.t)
    pitch = np.abs(held(glider.pitch))
    glides = (np.abs(rate) > _SLOWEST) & (pitch > _LEAST)
    path = np.where(glides, pitch + _ATTACK, 0.5 * np.pi)
    forward = np.minimum(np.abs(rate) / np.sin(path), _FASTEST)
    speed: Array = np.where(glides, forward * np.cos(path), 0.0)
    return speed
