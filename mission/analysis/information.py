"""What the fixes of one log teach about each figure of a calibration.

The log is filtered with wide priors. The fixes taught the information that the posterior has beyond
the prior (Maybeck, Stochastic Models, Estimation, and Control 1, 1979, ch. 5.7).

What does not live here: combining many logs (calibration).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mission.analysis.courses import Inputs
from mission.model import Position
from mission.model.vehicle import Vehicle
from mission.navigation.filter import Array
from mission.navigation.model import (
    CE,
    CN,
    COMPASS,
    COS,
    SCALE,
    SIN,
    STATES,
    Figures,
    Markov,
    figures,
)
from mission.navigation.navigator import Navigation
from protocol.messages import Fix

FITTED = (SCALE, COMPASS, SIN, COS, CN, CE)
DAY = 0.05  # m/s: least sigma of a current on another day
_NEXT = 1.5  # s between two successive fixes, at most


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure that is fitted.

    ``states``: indices into ``FITTED``. ``wide``: prior sigma of the fit. ``changes``: the sigma
    that says how much it changes within a log; it is that of an uncalibrated vehicle, so that a log
    teaches the same whatever was learned before. ``least``: the smallest sigma that is believed.
    ``fly``: what a log must contain to teach it. ``daily``: it differs from day to day."""

    name: str
    states: tuple[int, ...]
    wide: float
    changes: float
    least: float
    fly: str
    daily: bool = True


FIGURES = (
    Figure("speed_scale", (0,), 0.5, 0.1, 0.02,
           "legs of a minute or more there and back at the gears of the missions"),
    Figure("heading_bias", (1,), math.radians(15.0), math.radians(6.0), math.radians(1.0),
           "legs of a minute or more on two headings or more"),
    Figure("deviation", (2, 3), math.radians(4.0), math.radians(2.0), math.radians(0.5),
           "legs of a minute or more on four headings or more, all round", daily=False),
    Figure("current", (4, 5), 0.5, 0.5, DAY,
           "surface-shakedown on two days or more in the same waters"),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Information:
    """The information of one log about (scale - 1, bias, sin, cos, current north, east), beyond the
    prior. ``found`` and ``variances``: by this log alone. ``squares``: see ``noise.sensed``."""

    matrix: Array  # 6 x 6
    vector: Array
    found: Array
    variances: Array
    declination: float
    origin: Position | None
    squares: tuple[float, ...]


def precision(sigmas: Sequence[float]) -> Array:
    """Return the diagonal 6 x 6 precision matrix; ``sigmas``: one for each of ``FIGURES``."""
    wide = [s for row, s in zip(FIGURES, sigmas, strict=True) for _ in row.states]
    return np.diag([1.0 / s**2 for s in wide])


def information(log: Inputs, vehicle: Vehicle) -> Information:
    wide = _believing(vehicle, [row.wide for row in FIGURES])
    near = figures(_believing(vehicle, [row.changes for row in FIGURES]))
    nav, squares = Navigation(wide, figures=_wide_at_first(figures(wide), near)), list[float]()
    for item in log:
        if not isinstance(item, Fix):
            nav.telemetry(item)
            continue
        last = nav.core.last_fix
        nav.fix(item)
        if last is not None and item.t - last < _NEXT and nav.core.fix_nis is not None:
            squares.append(item.accuracy**2 * nav.core.fix_nis)
    x = (nav.core.filter.x - np.eye(STATES)[SCALE])[list(FITTED)]
    p = nav.core.filter.covariance[np.ix_(FITTED, FITTED)]
    matrix, prior = np.linalg.inv(p), precision([row.wide for row in FIGURES])
    origin = None if nav.frame is None else nav.frame.origin
    return Information(
        matrix - prior, matrix @ x, x, np.diag(p).copy(), nav.declination, origin, tuple(squares)
    )


def _believing(vehicle: Vehicle, sigmas: Sequence[float]) -> Vehicle:
    """Return the vehicle with ``sigmas`` for ``FIGURES`` and with zero mean current."""
    scale, bias, deviation, current = sigmas
    return replace(
        vehicle,
        sensors=replace(vehicle.sensors, heading_bias=bias),
        calibration=replace(
            vehicle.calibration, speed_scale_sigma=scale, deviation_sigma=deviation,
            current=(0.0, 0.0), current_sigma=current,
        ),
    )  # fmt: skip


def _wide_at_first(far: Figures, near: Figures) -> Figures:
    """Let the compass error, its second harmonic and the speed scale change within a log by as much
    as in ``near``, however wide the priors are. Else a wider prior would make a log teach less of
    what lasts. A current that may be strong may also change much."""
    compass = _as_steady(far.compass, near.compass)
    return replace(far, compass=compass, pace=near.pace, second=near.second)


def _as_steady(far: Markov, near: Markov) -> Markov:
    """Keep the sigma of ``far``, with the variance that ``near`` gains in a short time."""
    return Markov(far.sigma, near.time * (far.sigma / near.sigma) ** 2)
