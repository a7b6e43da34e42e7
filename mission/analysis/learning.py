"""What other recordings of the same vehicle teach, before one is scored: leave-one-out.

For each of the other runs its speed v, current c and compass bias b are fitted by least squares,

    d(north, east)/dt = v cos(pitch) (ahead - b to starboard) + c

The mean of the v is the speed figure, their spread its sigma; what is left along the track is the
slow noise about it (the part of which that each run's own v has swallowed is put back), what is
left across it the sway. The mean of the c of runs in the same waters is what a vehicle's own
black boxes would say about the current there, and their spread how far it is from that another
day. Of both spreads a part is only what each fit errs by, since its noise is not white: that part
(the covariance of least squares under the noise found) is taken off (random effects by moments:
DerSimonian and Laird, Controlled Clinical Trials 7, 1986, 177-188). The b are as large as a bias is
on another day; their mean is not taken off, a compass may be set anew.

Of a glider, ``spread`` learns from the dives before one how large what moves it is beside its
figures, by the mean of their normalised misses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mission.analysis.recordings import Recording
from mission.navigation.geodesy import LocalFrame

Array = NDArray[np.float64]

_SAME_WATERS = 20_000.0  # m between two starts
_TEACHES = 60.0  # s: what a shorter run says of its speed is not worth much beside others
_STEP = 5.0  # s over which velocities are taken from positions
_RIDGE, _ROUGH = 0.2, 0.15  # m/s: how far a current is expected to be from none; of a velocity
_KEPT, _SWAY = 200.0, 10.0  # s: a speed is kept for minutes, a sway is not
_LEAST, _LEAST_BIAS = 0.05, math.radians(1.0)  # m/s, rad: nothing is known better for another day
_FIGURED = 4.0
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
    compass: float | None = None  # rad, one sigma of its bias; None: the vehicle file's


@dataclass(frozen=True, slots=True)
class _Fit:
    speed: float
    bias: float
    current: NDArray[Any]
    along: float  # (m/s)^2, mean square of what is left
    across: float
    blurred: NDArray[Any]  # variances with which the noise went into speed, current (2), bias


def learn(others: Sequence[Recording], waters_of: Recording) -> Learned:
    """From ``others`` (runs) for one that is not among them."""
    others = [o for o in others if o.t[-1] - o.t[0] >= _TEACHES] or list(others)
    if not others:
        return Learned()
    fits = [_fit(run) for run in others]
    k, speeds = len(fits), np.array([f.speed for f in fits])
    speed = float(np.mean(speeds))
    spread = float(np.std(speeds, ddof=1)) if k > 1 else 0.2 * speed
    blurred = float(np.mean([f.blurred[0] for f in fits]))
    lasting = math.sqrt(max(spread**2 - blurred, 0.0) + spread**2 / k) / speed
    along = float(np.sqrt(np.mean([f.along for f in fits])))
    across = float(np.sqrt(np.mean([f.across for f in fits])))
    pairs = zip(fits, others, strict=True)
    near = [f for f, run in pairs if _same_waters(run, waters_of)]
    current, current_sigma = _waters(near)
    return Learned(
        speed=speed,
        speed_sigma=max(lasting, 0.05),
        speed_noise=min(max(along, 0.05), 0.5),
        sway=min(across / speed, 0.15),
        current=current,
        current_sigma=current_sigma,
        currents=len(near),
        compass=_bias(fits),
    )


def spread(misses: Sequence[float]) -> float:
    """Sigmas are to be multiplied by it. ``misses`` of earlier dives: normalised squares over their
    degrees of freedom, 1 where the figures are right; the figures count as ``_FIGURED`` dives."""
    return math.sqrt((_FIGURED + sum(misses)) / (_FIGURED + len(misses)))


def _bias(fits: Sequence[_Fit]) -> float | None:
    if len(fits) < 2:
        return None
    spread = float(np.mean([f.bias**2 for f in fits]))
    blurred = float(np.mean([f.blurred[3] for f in fits]))
    return max(_FEW * math.sqrt(max(spread - blurred, 0.0) + spread / len(fits)), _LEAST_BIAS)


def _waters(near: Sequence[_Fit]) -> tuple[tuple[float, float], float]:
    """Mean and sigma per axis for another day; shrunk towards no current while they are few."""
    n = len(near)
    if n < 2:
        return (0.0, 0.0), _RIDGE
    currents = np.array([f.current for f in near])
    spread = float(np.mean(np.var(currents, axis=0, ddof=1)))
    blurred = float(np.mean([f.blurred[1:3] for f in near]))
    mean = currents.mean(axis=0) * n / (n + 1.0)
    sigma = _FEW * math.sqrt(max(spread - blurred, 0.0) + spread / n)
    return (float(mean[0]), float(mean[1])), max(sigma, _LEAST)


def _same_waters(one: Recording, other: Recording) -> bool:
    lat, lon = math.radians(other.origin.latitude_deg), math.radians(other.origin.longitude_deg)
    return math.hypot(*LocalFrame(one.origin).to_local(lat, lon)) < _SAME_WATERS


def _fit(run: Recording) -> _Fit:
    """Speed, current and compass bias of one run, over means of ``_STEP`` s."""
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
    unseen = _in_the_mean((at[-1] - at[0]) / _KEPT)
    slow, sway = float(np.mean(along * along)) / (1.0 - unseen), float(np.mean(across * across))
    blurred, v = _blur(rows, at[:-1], bow, slow, sway), float(x[0])
    blurred[3] /= v * v
    return _Fit(v, float(x[3]) / v, x[1:3], slow, sway, blurred)


def _blur(rows: Array, at: Array, bow: Array, slow: float, sway: float) -> Array:
    """Variances of what is found when the noise is ``slow`` along the bow, ``sway`` across."""
    apart = np.abs(at[:, None] - at)
    ahead, beam = bow.reshape(-1), np.concatenate((-bow[1], bow[0]))
    noise = slow * np.outer(ahead, ahead) * np.tile(np.exp(-apart / _KEPT), (2, 2))
    noise += sway * np.outer(beam, beam) * np.tile(np.exp(-apart / _SWAY), (2, 2))
    gain = np.linalg.pinv(rows)[:, : len(noise)]
    variances: Array = np.diag(gain @ noise @ gain.T).copy()
    return variances


def _in_the_mean(x: float) -> float:
    """Share of a Gauss-Markov process's variance that its mean over x correlation times has."""
    return 2.0 / x * (1.0 - (1.0 - math.exp(-x)) / x)


def _integral(t: Array, f: Array) -> Array:
    return np.concatenate(([0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * np.diff(t))))
