"""The Kalman filter: dead reckoning by compass and thrusters, corrected by fixes and depth.

filterpy's KalmanFilter, called so that it costs little more than its equations: the transition F
and the noise Q are written in place (the Jacobian about the estimate), the state is set after
``predict``, which makes it the extended filter to rounding; measurements are linear once angles
are inputs; ``inv`` is the closed form. The update is the Joseph form (filterpy), so P stays
symmetric and positive. States and figures: mission.navigation.model.

What does not live here: which readings are believed, gates, lateness, frames.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

from mission.navigation.model import (
    BOTTOM,
    CE,
    CN,
    COMPASS,
    DEPTH,
    DEVIATION,
    RATE,
    SCALE,
    STATES,
    E,
    Figures,
    N,
)

Array = NDArray[np.float64]

_UNKNOWN = 1e8  # m^2: no position, no depth yet
_STEP = 5.0  # s, the longest piece of a prediction
_POSITION = np.eye(2, STATES)
_DEPTH = np.zeros((1, STATES))
_DEPTH[0, DEPTH] = 1.0
_BOTH = np.zeros((2, STATES))  # depth; altitude = bottom - depth
_BOTH[0, DEPTH], _BOTH[1, BOTTOM], _BOTH[1, DEPTH] = 1.0, 1.0, -1.0
_ALTITUDE = _BOTH[1:]


def _inverse(s: Array) -> Array:
    if s.shape[0] == 1:
        return 1.0 / s
    (a, b), (c, d) = s.tolist()
    k = 1.0 / (a * d - b * c)
    return np.array(((d * k, -b * k), (-c * k, a * k)))


class Filter:
    """``heading`` arguments are compass + declination, rad; the compass error is a state."""

    def __init__(self, figures: Figures) -> None:
        self.figures = figures
        self._kf: Any = KalmanFilter(dim_x=STATES, dim_z=2)
        self._kf.inv = _inverse
        x = np.zeros(STATES)
        x[SCALE] = 1.0
        p = np.full(STATES, _UNKNOWN)
        p[CN] = p[CE] = figures.current.sigma**2
        p[SCALE] = figures.scale**2
        p[DEVIATION] = figures.deviation.sigma**2
        p[COMPASS] = figures.compass.sigma**2
        p[RATE] = figures.rate.sigma**2
        self._kf.x, self._kf.P = x, np.diag(p)
        self._kf.F, self._kf.Q = np.eye(STATES), np.zeros((STATES, STATES))
        self._f, self._q = self._kf.F.reshape(-1), self._kf.Q.reshape(-1)

    @property
    def x(self) -> Array:
        state: Array = self._kf.x
        return state

    @property
    def covariance(self) -> Array:
        p: Array = self._kf.P
        return p

    def save(self) -> tuple[Array, Array]:
        """The arrays are replaced, never written to, by what follows."""
        return self._kf.x, self._kf.P

    def load(self, saved: tuple[Array, Array]) -> None:
        self._kf.x, self._kf.P = saved

    # --- time ------------------------------------------------------------------------------

    def predict(
        self, dt: float, heading: float, expected: float, along: float, sway: float, lost: float
    ) -> None:
        """Moves on by ``dt``; see ``transition`` for the arguments."""
        pieces = max(1, math.ceil(dt / _STEP))
        for _ in range(pieces):
            moved = self.transition(dt / pieces, heading, expected, along, sway, lost)
            self._kf.predict()
            x = self._kf.x
            x[N], x[E] = moved

    def transition(
        self, dt: float, heading: float, expected: float, along: float, sway: float, lost: float
    ) -> tuple[float, float]:
        """Writes F and Q for ``dt``; the position after it.

        ``expected`` is the thrusters' speed, ``along`` the share of the speed that is horizontal,
        ``sway`` the speed to starboard, ``lost`` the extra heading variance times its correlation
        time (rad^2 s) while the compass cannot be believed.
        """
        fig, f, q = self.figures, self._f, self._q
        n, e, cn, ce, scale, deviation, error, _, _, _ = self._kf.x.tolist()
        true = heading - error
        c, s = math.cos(true), math.sin(true)
        speed = scale * expected + deviation
        forward = speed * along
        wn, we = (forward * c - sway * s) * dt, (forward * s + sway * c) * dt
        d_current, d_dev = fig.current.decay(dt), fig.deviation.decay(dt)
        d_compass, d_rate = fig.compass.decay(dt), fig.rate.decay(dt)
        t_current = 0.5 * dt * (1.0 + d_current)
        t_dev = fig.deviation.time * (1.0 - d_dev) * along
        t_scale = expected * along * dt
        f[N * STATES + CN] = f[E * STATES + CE] = t_current
        f[N * STATES + SCALE], f[E * STATES + SCALE] = t_scale * c, t_scale * s
        f[N * STATES + DEVIATION], f[E * STATES + DEVIATION] = t_dev * c, t_dev * s
        f[N * STATES + COMPASS], f[E * STATES + COMPASS] = we, -wn
        f[CN * STATES + CN] = f[CE * STATES + CE] = d_current
        f[DEVIATION * STATES + DEVIATION] = d_dev
        f[COMPASS * STATES + COMPASS] = d_compass
        f[DEPTH * STATES + RATE] = fig.rate.time * (1.0 - d_rate)
        f[RATE * STATES + RATE] = d_rate
        # the compass's white noise pushes across the track, once per report
        across = forward * forward * dt * (fig.heading**2 * fig.period + 2.0 * lost)
        q[N * STATES + N], q[E * STATES + E] = across * s * s, across * c * c
        q[N * STATES + E] = q[E * STATES + N] = -across * s * c
        q[CN * STATES + CN] = q[CE * STATES + CE] = _noise(fig.current.sigma, d_current)
        q[DEVIATION * STATES + DEVIATION] = _noise(fig.deviation.sigma, d_dev)
        q[COMPASS * STATES + COMPASS] = _noise(fig.compass.sigma, d_compass)
        q[RATE * STATES + RATE] = _noise(fig.rate.sigma, d_rate)
        q[SCALE * STATES + SCALE] = (0.1 * fig.scale) ** 2 * dt / 3600.0
        q[BOTTOM * STATES + BOTTOM] = fig.slope**2 * fig.slope_length * (abs(speed) + 0.02) * dt
        return (
            n + wn + (t_dev - along * dt) * deviation * c + t_current * cn,
            e + we + (t_dev - along * dt) * deviation * s + t_current * ce,
        )

    # --- measurements ------------------------------------------------------------------------

    def place(self, north: float, east: float, variance: float) -> None:
        """The position is known to be this, whatever was believed; the rest stays."""
        x, p = self._kf.x.copy(), self._kf.P.copy()
        x[N], x[E] = north, east
        p[:2, :], p[:, :2] = 0.0, 0.0
        p[N, N] = p[E, E] = variance
        self._kf.x, self._kf.P = x, p

    def shift(self, north: float, east: float) -> None:
        x = self._kf.x.copy()
        x[N] += north
        x[E] += east
        self._kf.x = x

    def innovation(self, north: float, east: float, variance: float) -> tuple[float, float, float]:
        """Of a position: north, east, and the normalised innovation squared."""
        x, p = self._kf.x, self._kf.P
        dn, de = north - float(x[N]), east - float(x[E])
        (a, b), (_, d) = p[:2, :2].tolist()
        a, d = a + variance, d + variance
        return dn, de, (d * dn * dn - 2.0 * b * dn * de + a * de * de) / (a * d - b * b)

    def fix(self, north: float, east: float, variance: float) -> None:
        r = np.array(((variance, 0.0), (0.0, variance)))
        self._kf.update(np.array((north, east)), r, _POSITION)

    def widen(self, factor: float) -> None:
        """Multiplies the covariance of all that moves the position; correlations stay."""
        p = self._kf.P.copy()
        p[:DEPTH, :DEPTH] *= factor
        self._kf.P = p

    def loosen(self, variance: float) -> None:
        """Adds to the position's variance alone."""
        p = self._kf.P.copy()
        p[N, N] += variance
        p[E, E] += variance
        self._kf.P = p

    def vertical(self, depth: float | None, altitude: float | None) -> tuple[float, int] | None:
        """Takes in what is there; the normalised innovation squared and its degrees of freedom."""
        fig, kf = self.figures, self._kf
        rd, ra = fig.depth**2, fig.altitude**2
        if depth is not None and altitude is not None:
            kf.update(np.array((depth, altitude)), np.array(((rd, 0.0), (0.0, ra))), _BOTH)
        elif depth is not None:
            kf.update(np.array((depth,)), np.array(((rd,),)), _DEPTH)
        elif altitude is not None:
            kf.update(np.array((altitude,)), np.array(((ra,),)), _ALTITUDE)
        else:
            return None
        y, si = kf.y, kf.SI
        return float(y @ si @ y), len(y)

    def velocity(
        self, north: float, east: float, heading: float, expected: float, along: float
    ) -> None:
        """Over ground, from a receiver's speed and course (rejected beyond 4 sigma)."""
        fig, x, p = self.figures, self._kf.x, self._kf.P
        true = heading - float(x[COMPASS])
        c, s = math.cos(true), math.sin(true)
        forward = (float(x[SCALE]) * expected + float(x[DEVIATION])) * along
        h = np.zeros((2, STATES))
        h[0, CN] = h[1, CE] = 1.0
        h[0, SCALE], h[1, SCALE] = expected * along * c, expected * along * s
        h[0, DEVIATION], h[1, DEVIATION] = along * c, along * s
        h[0, COMPASS], h[1, COMPASS] = forward * s, -forward * c
        across = (forward * fig.heading) ** 2
        r0 = fig.ground_velocity**2
        r = np.array(
            ((r0 + across * s * s, -across * s * c), (-across * s * c, r0 + across * c * c))
        )
        y = np.array((north - forward * c - float(x[CN]), east - forward * s - float(x[CE])))
        if float(y @ _inverse(h @ p @ h.T + r) @ y) < 16.0:
            self._kf.update(y + h @ x, r, h)


def _noise(sigma: float, decay: float) -> float:
    return sigma * sigma * (1.0 - decay * decay)
