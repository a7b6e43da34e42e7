"""The Kalman filter: dead reckoning by compass and thrusters, corrected by fixes and depth.

This is filterpy's KalmanFilter, called so that it costs little more than its equations. The
transition F (the Jacobian at the estimate) and the noise Q are written in place. The state is set
after ``predict``, which makes it the extended filter, to rounding. Angles are inputs, so the
measurements are linear. ``inv`` is the closed form. The update has the Joseph form (filterpy), so P
stays symmetric and positive. States and figures: mission.navigation.model.

What does not live here: which readings are believed, gates, late input, frames.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mission.navigation.kalman import KalmanFilter
from mission.navigation.model import (
    BOTTOM,
    CE,
    CN,
    COMPASS,
    COS,
    DEPTH,
    DEVIATION,
    RATE,
    SCALE,
    SIN,
    STATES,
    WANDER,
    WE,
    WN,
    E,
    Figures,
    N,
)

Array: TypeAlias = NDArray[np.float64]

_UNKNOWN = 1e4  # m: no position, no depth yet
_LOOSEST = 25.0  # times the variance before any input: the most that ``widen`` makes of it
_TURN = 0.15  # rad between two reports: less is noise
_STEP = 5.0  # s, the longest piece of a prediction
_MOST = 720  # pieces: an hour. In a longer gap they are longer: the position is unknown by then
_POSITION = np.eye(2, STATES)
_DEPTH = np.zeros((1, STATES))
_DEPTH[0, DEPTH] = 1.0
_BOTH = np.zeros((2, STATES))  # depth; altitude = bottom - depth
_BOTH[0, DEPTH], _BOTH[1, BOTTOM], _BOTH[1, DEPTH] = 1.0, 1.0, -1.0
_ALTITUDE = _BOTH[1:]
_COMPASS = (COMPASS, SIN, COS, WANDER)
_PAIRS = (
    *((N, N), (N, E), (E, E), (CN, CN), (CE, CE)),
    *((SCALE, SCALE), (SCALE, DEVIATION), (DEVIATION, DEVIATION)),
    *((DEPTH, DEPTH), (DEPTH, BOTTOM), (BOTTOM, BOTTOM), (RATE, RATE)),
    *itertools.combinations_with_replacement(_COMPASS, 2),
)
_TOLD = np.array([i * STATES + k for i, k in _PAIRS])


def _inverse(s: Array) -> Array:
    if s.shape[0] == 1:
        return 1.0 / s
    (a, b), (c, d) = s.tolist()
    k = 1.0 / (a * d - b * c)
    return np.array(((d * k, -b * k), (-c * k, a * k)))


def _across(fig: Figures) -> float:
    """Return the density (rad^2 s) of the noise across the heading: compass and sway."""
    return fig.heading**2 * fig.period + 2.0 * fig.sway.sigma**2 * fig.sway.time


class Motion(NamedTuple):
    """How the vehicle moves over a stretch of time, as far as is known; m, s, rad.

    ``heading``: compass + declination (the compass's error is a state). ``expected``: speed by the
    thrusters. ``along``: share of the speed that moves it horizontally. ``sway``: slip to
    starboard, share of the speed. ``lost``: extra heading variance times its correlation time
    (rad^2 s) while the compass is not believed. ``driven``: share of the speed's deviation that
    acts (none at rest). ``turned``: angle since the report before. ``skid``: variance (to any side)
    that a turn adds, per second and (m/s)^2. ``heave``: speed ahead (m/s) that a pitched hull gains
    when it sinks or rises other than along its bow. ``late``: the last fix is longer ago than the
    current is known to be steady. ``untold``: variance (m^2/s, to any side) of unreported motion.
    """

    heading: float = 0.0
    expected: float = 0.0
    along: float = 1.0
    sway: float = 0.0
    lost: float = 0.0
    driven: float = 1.0
    turned: float = 0.0
    surfaced: bool = False
    skid: float = 0.0
    heave: float = 0.0
    late: bool = False
    untold: float = 0.0


@dataclass(frozen=True, slots=True)
class _Steady:
    """Values for one length of step. ``kept``: the share of a current that is left after it.
    ``current``, ``drift``, ``deviation``: for how long (s) the value at its begin moves the
    vehicle. ``wander``: the wander's share of Q."""

    dt: float = -1.0
    late: bool = False
    kept: float = 1.0
    current: float = 0.0
    drift: float = 0.0
    deviation: float = 0.0
    wander: float = 0.0


class Filter:
    def __init__(self, figures: Figures) -> None:
        self.figures = fig = figures
        self.kalman: Any = KalmanFilter(dim_x=STATES, dim_z=2)
        self.kalman.inv = _inverse
        x, sigma = np.zeros(STATES), np.full(STATES, _UNKNOWN)
        x[SCALE], (x[CN], x[CE]) = 1.0, fig.current_mean
        sigma[CN], sigma[CE], sigma[WN], sigma[WE] = (fig.current.sigma,) * 2 + (
            fig.drift.sigma,
        ) * 2
        sigma[SCALE], sigma[DEVIATION] = fig.scale, fig.deviation.sigma
        sigma[COMPASS], sigma[SIN], sigma[COS] = fig.compass.sigma, fig.harmonic, fig.harmonic
        sigma[WANDER] = math.hypot(fig.wander.sigma, fig.second)  # the second harmonic
        sigma[RATE] = fig.rate.sigma
        self.kalman.x, self.kalman.P = x, np.diag(sigma * sigma)
        self._loosest = _LOOSEST * (sigma * sigma)[:DEPTH]
        self._loosest[N] = self._loosest[E] = math.inf
        self.kalman.F, self.kalman.Q = np.eye(STATES), np.zeros((STATES, STATES))
        self._f, self._q = self.kalman.F.reshape(-1), self.kalman.Q.reshape(-1)
        self._steady = _Steady()
        depth, altitude = 0.5 * fig.depth**2, fig.altitude**2
        self._depth_and_altitude = np.diag((depth, altitude))
        self._depth_alone, self._altitude_alone = np.diag((depth,)), np.diag((altitude,))
        self._wander = _across(fig)

    @property
    def x(self) -> Array:
        state: Array = self.kalman.x
        return state

    @property
    def covariance(self) -> Array:
        p: Array = self.kalman.P
        return p

    def save(self) -> tuple[Array, Array]:
        """State and covariance. Later steps replace these arrays and never write to them."""
        return self.kalman.x, self.kalman.P

    def told(self) -> tuple[list[float], list[float]]:
        """The state, and the covariances that an estimate needs, in the order of ``_TOLD``."""
        return self.kalman.x.tolist(), self.kalman.P.take(_TOLD).tolist()

    def load(self, saved: tuple[Array, Array]) -> None:
        self.kalman.x, self.kalman.P = saved

    def load_vertical(self, saved: tuple[Array, Array]) -> None:
        """Restore depth, its rate and the bottom alone; nothing couples them to the others."""
        x, p = self.kalman.x.copy(), self.kalman.P.copy()
        x[DEPTH:], p[DEPTH:, DEPTH:] = saved[0][DEPTH:], saved[1][DEPTH:, DEPTH:]
        self.kalman.x, self.kalman.P = x, p

    def trust(self, figures: Figures, share: float) -> None:
        """Use ``figures`` from now on, and make all states but the vertical ones ``share`` times as
        uncertain."""
        self.figures, self._steady, self._wander = figures, _Steady(), _across(figures)
        p = self.kalman.P.copy()
        p[:DEPTH, :] *= share
        p[:, :DEPTH] *= share
        self.kalman.P = p

    # --- time ------------------------------------------------------------------------------

    def predict(self, dt: float, run: Motion) -> None:
        pieces = min(max(1, math.ceil(dt / _STEP)), _MOST)
        for _ in range(pieces):
            self._piece(dt / pieces, run)

    def _piece(self, dt: float, run: Motion) -> None:
        moved = self.transition(dt, run)
        self.kalman.predict()
        x = self.kalman.x
        x[N], x[E], x[CN], x[CE] = moved

    def transition(self, dt: float, run: Motion) -> tuple[float, float, float, float]:
        """Write F and Q for ``dt``; return position and current after it."""
        fig, f, q = self.figures, self._f, self._q
        n, e, cn, ce, wn, we, scale, deviation, error, a, b, wander, _, _, _ = (
            self.kalman.x.tolist()
        )
        sm, cm = math.sin(run.heading), math.cos(run.heading)
        true = run.heading - error - a * sm - b * cm - wander
        c, s = math.cos(true), math.sin(true)
        speed = scale * run.expected + deviation * run.driven
        forward = speed * run.along + run.heave
        sway = run.sway * speed
        dn, de = (forward * c - sway * s) * dt, (forward * s + sway * c) * dt
        if dt != self._steady.dt or run.late != self._steady.late:
            self._steady = self._write_steady(dt, run.late)
        steady = self._steady
        t_drift = steady.drift if run.surfaced else 0.0
        driven = run.along * run.driven
        t_dev = steady.deviation * driven
        t_scale = run.expected * run.along * dt
        f[N * STATES + WN] = f[E * STATES + WE] = t_drift
        f[N * STATES + SCALE], f[E * STATES + SCALE] = t_scale * c, t_scale * s
        f[N * STATES + DEVIATION], f[E * STATES + DEVIATION] = t_dev * c, t_dev * s
        f[N * STATES + COMPASS], f[E * STATES + COMPASS] = de, -dn
        f[N * STATES + SIN], f[E * STATES + SIN] = de * sm, -dn * sm
        f[N * STATES + COS], f[E * STATES + COS] = de * cm, -dn * cm
        f[N * STATES + WANDER], f[E * STATES + WANDER] = de, -dn
        # noise across the track: the compass's white noise, once per report, and the sway
        across = forward * forward * dt * (self._wander + 2.0 * run.lost)
        skid = (run.skid * speed * speed + run.untold) * dt
        q[N * STATES + N], q[E * STATES + E] = across * s * s + skid, across * c * c + skid
        q[N * STATES + E] = q[E * STATES + N] = -across * s * c
        q[WANDER * STATES + WANDER] = steady.wander + self._harmonics(run)
        q[BOTTOM * STATES + BOTTOM] = fig.slope**2 * fig.slope_length * (abs(speed) + 0.02) * dt
        mn, me = fig.current_mean
        late = t_dev - driven * dt  # the deviation fades within the step
        return (
            n + dn + late * deviation * c + steady.current * cn + t_drift * wn,
            e + de + late * deviation * s + steady.current * ce + t_drift * we,
            mn + steady.kept * (cn - mn),
            me + steady.kept * (ce - me),
        )

    def _write_steady(self, dt: float, late: bool) -> _Steady:
        """Write the parts of F and Q that depend on ``dt`` and ``late`` alone."""
        fig, f, q = self.figures, self._f, self._q
        water = fig.current if late else fig.fresh
        for process, states in (
            (water, (CN, CE)),
            (fig.drift, (WN, WE)),
            (fig.deviation, (DEVIATION,)),
            (fig.compass, (COMPASS,)),
            (fig.wander, (WANDER,)),
            (fig.rate, (RATE,)),
        ):
            kept = process.decay(dt)
            for i in states:
                f[i * STATES + i] = kept
                q[i * STATES + i] = process.sigma**2 * (1.0 - kept * kept)
        q[SCALE * STATES + SCALE] = fig.pace**2 * dt / 3600.0
        kept, drift = water.decay(dt), fig.drift.decay(dt)
        current = 0.5 * dt * (1.0 + kept)
        f[N * STATES + CN] = f[E * STATES + CE] = current
        f[DEPTH * STATES + RATE] = fig.rate.time * (1.0 - fig.rate.decay(dt))
        return _Steady(
            dt=dt,
            late=late,
            kept=kept,
            current=current,
            drift=0.5 * dt * (1.0 + drift),
            deviation=fig.deviation.time * (1.0 - fig.deviation.decay(dt)),
            wander=float(q[WANDER * STATES + WANDER]),
        )

    def _harmonics(self, run: Motion) -> float:
        """Return the variance (rad^2) that a turn adds for the deviation's second harmonic.

        The harmonic's value before the turn is not removed but fades as the wander does. So this is
        its variance times 1 - cos, not the variance of the difference, which is twice as much.
        """
        if abs(run.turned) < _TURN:
            return 0.0
        return self.figures.second**2 * (1.0 - math.cos(2.0 * run.turned))

    # --- measurements ------------------------------------------------------------------------

    def place(self, north: float, east: float, variance: float) -> None:
        """Set the position to a known one, whatever was believed before."""
        x, p = self.kalman.x.copy(), self.kalman.P.copy()
        x[N], x[E] = north, east
        p[:2, :], p[:, :2] = 0.0, 0.0
        p[N, N] = p[E, E] = variance
        self.kalman.x, self.kalman.P = x, p

    def shift(self, north: float, east: float) -> None:
        x = self.kalman.x.copy()
        x[N] += north
        x[E] += east
        self.kalman.x = x

    def innovation(self, north: float, east: float, variance: float) -> tuple[float, float, float]:
        """Return the innovation of a position: north, east, and its normalised square."""
        x, p = self.kalman.x, self.kalman.P
        dn, de = north - float(x[N]), east - float(x[E])
        (a, b), (_, d) = p[:2, :2].tolist()
        a, d = a + variance, d + variance
        return dn, de, (d * dn * dn - 2.0 * b * dn * de + a * de * de) / (a * d - b * b)

    def fix(self, north: float, east: float, variance: float) -> None:
        r = np.array(((variance, 0.0), (0.0, variance)))
        self.kalman.update(np.array((north, east)), r, _POSITION)

    def widen(self, factor: float, *, still: bool) -> None:
        """Multiply the covariance of all that moves the position; correlations stay. Compass,
        thrusters and current never become much less known than before any input: at rest nothing
        would bring them back, and the filter cannot compute with what they grow to. A state that
        the vehicle file gives as certain stays so. ``still``: nothing drove, so compass and
        thrusters have moved nothing, and do not grow."""
        p = self.kalman.P.copy()
        plane = p[:DEPTH, :DEPTH]
        known = plane.diagonal()
        room = np.divide(self._loosest, known, out=np.full(DEPTH, math.inf), where=known > 0.0)
        if still:
            room[SCALE:DEPTH] = 1.0
        if (room >= factor).all():
            plane *= factor
        else:  # each state has a share of the widening, so that the sum stays positive
            share = np.sqrt(np.clip((room - 1.0) / (factor - 1.0), 0.0, 1.0))
            plane += (factor - 1.0) * share[:, None] * plane * share
        self.kalman.P = p

    def loosen(self, variance: float) -> None:
        """Add ``variance`` (m^2) to the position alone."""
        p = self.kalman.P.copy()
        p[N, N] += variance
        p[E, E] += variance
        self.kalman.P = p

    @property
    def current_found(self) -> float:
        """By how many m/s the estimated current differs from that of the vehicle file."""
        north, east = self.figures.current_mean
        return math.hypot(float(self.x[CN]) - north, float(self.x[CE]) - east)

    def doubt_current(self, sigma: float) -> None:
        """Take the current to be uncertain by ``sigma`` m/s or more along each axis. An axis that
        was known better loses its correlations; the mean stays."""
        p = self.kalman.P.copy()
        for axis in (CN, CE):
            if p[axis, axis] < sigma * sigma:
                p[axis, :] = p[:, axis] = 0.0
                p[axis, axis] = sigma * sigma
        self.kalman.P = p

    def vertical(self, depth: float | None, altitude: float | None) -> tuple[float, int] | None:
        """Correct by depth and altitude (m) where given. Return the normalised innovation squared
        and its degrees of freedom, None if neither is given."""
        kf = self.kalman
        if depth is not None and altitude is not None:
            kf.update(np.array((depth, altitude)), self._depth_and_altitude, _BOTH)
            (a, b), ((p, q), (_, r)) = kf.y.tolist(), kf.SI.tolist()
            return p * a * a + 2.0 * q * a * b + r * b * b, 2
        if depth is not None:
            kf.update(np.array((depth,)), self._depth_alone, _DEPTH)
        elif altitude is not None:
            kf.update(np.array((altitude,)), self._altitude_alone, _ALTITUDE)
        else:
            return None
        return kf.y.item() ** 2 * kf.SI.item(), 1

    def velocity(self, north: float, east: float, run: Motion, noise: Array) -> None:
        """Correct by a receiver's velocity over ground, m/s (rejected beyond 4 sigma).
        ``noise``: its covariance, (m/s)^2."""
        x, p = self.kalman.x, self.kalman.P
        sm, cm = math.sin(run.heading), math.cos(run.heading)
        true = run.heading - float(x[COMPASS]) - float(x[WANDER])
        true -= float(x[SIN]) * sm + float(x[COS]) * cm
        c, s = math.cos(true), math.sin(true)
        speed = float(x[SCALE]) * run.expected + float(x[DEVIATION]) * run.driven
        forward, sway = speed * run.along + run.heave, speed * run.sway
        vn, ve = forward * c - sway * s, forward * s + sway * c
        h = np.zeros((2, STATES))
        for column, n, e in (
            (CN, 1.0, 0.0),
            (CE, 0.0, 1.0),
            (WN, float(run.surfaced), 0.0),
            (WE, 0.0, float(run.surfaced)),
            (SCALE, run.expected * run.along * c, run.expected * run.along * s),
            (DEVIATION, run.along * run.driven * c, run.along * run.driven * s),
            (COMPASS, ve, -vn),
            (WANDER, ve, -vn),
            (SIN, ve * sm, -vn * sm),
            (COS, ve * cm, -vn * cm),
        ):
            h[0, column], h[1, column] = n, e
        across = forward * forward * self._wander  # a density: fixes come once a second
        r = noise + across * np.array(((s * s, -s * c), (-s * c, c * c)))
        drift = x[WN:SCALE] if run.surfaced else np.zeros(2)
        y = np.array((north - vn, east - ve)) - x[CN:WN] - drift
        if float(y @ _inverse(h @ p @ h.T + r) @ y) < 16.0:
            self.kalman.update(y + h @ x, r, h)
