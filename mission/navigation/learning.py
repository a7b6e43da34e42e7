"""What other recordings of the same vehicle teach, before one is scored: leave-one-out.

For each of the other runs its own speed v and current c are fitted by least squares,

    d(north, east)/dt = v cos(pitch) ahead + c

The mean of the v is the speed figure, their spread its sigma; what is left along the track is the
slow noise about it (the part of which that each run's own v has swallowed is put back), what is
left across it the sway. The mean of the c of runs in the same waters is what a vehicle's own
black boxes would say about the current there, and their spread how far it is from that another
day.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mission.navigation.geodesy import LocalFrame
from mission.navigation.recordings import Recording

Array = NDArray[np.float64]

_SAME_WATERS = 20_000.0  # m between two starts
_STEP = 5.0  # s over which velocities are taken from positions
_RIDGE, _ROUGH = 0.2, 0.15  # m/s: how far a current is expected to be from none; of a velocity
_KEPT = 200.0  # s: a speed is kept for minutes
_FEW = 1.3  # on the spread of a handful of currents, itself uncertain (Student t against normal)


@dataclass(frozen=True, slots=True)
class Learned:
    """``speed_sigma`` and ``sway`` are shares of the speed; ``currents`` counts the runs near.

    The defaults stand where nothing else was recorded.
    """

    speed: float = 1.5
    speed_sigma: float = 0.4
    speed_noise: float = 0.3
    speed_time: float = _KEPT
    sway: float = 0.05
    current: tuple[float, float] = (0.0, 0.0)
    current_sigma: float = _RIDGE
    currents: int = 0


@dataclass(frozen=True, slots=True)
class _Fit:
    speed: float
    current: NDArray[Any]
    along: float  # (m/s)^2, mean square of what is left
    across: float
    swallowed: float  # the part of ``along`` that went into the speed


def learn(others: Sequence[Recording], waters_of: Recording) -> Learned:
    """From ``others`` (runs) for one that is not among them."""
    if not others:
        return Learned()
    fits = [_fit(run) for run in others]
    k, speeds = len(fits), np.array([f.speed for f in fits])
    speed = float(np.mean(speeds))
    spread = float(np.std(speeds, ddof=1)) if k > 1 else 0.2 * speed
    swallowed = float(np.mean([f.swallowed for f in fits]))
    lasting = math.sqrt(max(spread**2 - swallowed, 0.0) * (1.0 + 1.0 / k)) / speed
    along = float(np.sqrt(np.mean([f.along for f in fits])))
    across = float(np.sqrt(np.mean([f.across for f in fits])))
    pairs = zip(fits, others, strict=True)
    near = [f.current for f, run in pairs if _same_waters(run, waters_of)]
    current, current_sigma = _waters(np.array(near))
    return Learned(
        speed=speed,
        speed_sigma=max(lasting, 0.05),
        speed_noise=min(max(along, 0.05), 0.5),
        sway=min(across / speed, 0.15),
        current=current,
        current_sigma=current_sigma,
        currents=len(near),
    )


def _waters(currents: Array) -> tuple[tuple[float, float], float]:
    """Mean and sigma per axis for another day; shrunk towards no current while they are few."""
    n = len(currents)
    if n < 2:
        return (0.0, 0.0), _RIDGE
    spread = float(np.sqrt(np.mean(np.var(currents, axis=0, ddof=1))))
    mean = currents.mean(axis=0) * n / (n + 1.0)
    return (float(mean[0]), float(mean[1])), max(spread * _FEW * math.sqrt(1.0 + 1.0 / n), 0.1)


def _same_waters(one: Recording, other: Recording) -> bool:
    lat, lon = math.radians(other.origin.latitude_deg), math.radians(other.origin.longitude_deg)
    return math.hypot(*LocalFrame(one.origin).to_local(lat, lon)) < _SAME_WATERS


def _fit(run: Recording) -> _Fit:
    """Speed and current of one run, over means of ``_STEP`` s."""
    level = np.cos(run.pitch)
    at = np.arange(run.t[0], run.t[-1], _STEP)
    ahead = np.column_stack(
        [
            np.diff(np.interp(at, run.t, _integral(run.t, level * f(run.heading)))) / _STEP
            for f in (np.cos, np.sin)
        ]
    )
    place = np.column_stack([np.interp(at, run.t, p) for p in (run.north, run.east)])
    velocity = np.diff(place, axis=0) / _STEP
    n = len(velocity)
    rows = np.zeros((2 * n + 2, 3))
    rows[:n, 0], rows[n : 2 * n, 0] = ahead[:, 0], ahead[:, 1]
    rows[:n, 1] = rows[n : 2 * n, 2] = 1.0
    rows[2 * n, 1] = rows[2 * n + 1, 2] = _ROUGH / _RIDGE
    values = np.concatenate((velocity[:, 0], velocity[:, 1], (0.0, 0.0)))
    x = np.linalg.lstsq(rows, values, rcond=None)[0]
    left = (values - rows @ x)[: 2 * n].reshape(2, n)
    bow = (ahead / np.linalg.norm(ahead, axis=1, keepdims=True)).T
    along, across = (left * bow).sum(axis=0), left[1] * bow[0] - left[0] * bow[1]
    unseen = _in_the_mean((at[-1] - at[0]) / _KEPT)
    slow = float(np.mean(along * along)) / (1.0 - unseen)
    return _Fit(float(x[0]), x[1:], slow, float(np.mean(across * across)), unseen * slow)


def _in_the_mean(x: float) -> float:
    """Share of a Gauss-Markov process's variance that its mean over x correlation times has."""
    return 2.0 / x * (1.0 - (1.0 - math.exp(-x)) / x)


def _integral(t: Array, f: Array) -> Array:
    return np.concatenate(([0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * np.diff(t))))
