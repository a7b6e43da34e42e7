"""The measurement equations of added sensors: what the filter expects of each.

    through the water  ahead = (scale u + deviation) k
    over ground        the same, plus the speed by sinking, and the current turned into the hull:
                       ahead += n cos psi + e sin psi, starboard = sway + e cos psi - n sin psi
    to a beacon        r = |place - beacon|, with the second order of the position error across
                       the line to it (Bar-Shalom, Li, Kirubarajan 2001, ch. 10.3.2):
                       r += p / 2r, and its variance p^2 / 2r^2; the depth is an input

What does not live here: which sensors there are and when one is believed (added), F and Q (filter).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mission.navigation.filter import Array, Filter, Motion
from mission.navigation.items import Aiding
from mission.navigation.model import (
    CE,
    CN,
    COMPASS,
    COS,
    DEPTH,
    DEVIATION,
    SCALE,
    SIN,
    STATES,
    WANDER,
    WE,
    WN,
)
from protocol.added import GROUND, PLACE, RANGE

_GATES = (0.0, 10.828, 13.816)  # chi-square, 99.9 %, by degrees of freedom


class Innovation(NamedTuple):
    """The innovation ``y``, how the value follows from the states (``h``), and its noise ``r``."""

    y: Array
    h: Array
    r: Array


def innovation(filter_: Filter, a: Aiding, run: Motion) -> Innovation:
    n = len(a.values)
    r = np.eye(n) * a.sigma**2
    if a.kind == PLACE:
        return Innovation(np.array(a.values) - filter_.x[:2], np.eye(2, STATES), r)
    if a.kind == RANGE:
        return _of_range(filter_, a)
    z, h = _of_hull(filter_, run, ground=a.kind == GROUND)
    if n > 1:  # the sway to either side is not a state
        r[1, 1] += (filter_.figures.sway.sigma * run.expected) ** 2
    return Innovation(np.array(a.values) - z[:n], h[:n], r)


def _of_range(filter_: Filter, a: Aiding) -> Innovation:
    north, east, depth, heard = a.values
    x, p = filter_.x, filter_.covariance
    apart = float(x[0]) - north, float(x[1]) - east, float(x[DEPTH]) - depth
    way = max(math.hypot(*apart), 1.0)
    n, e, d = (one / way for one in apart)
    (nn, ne), (_, ee) = p[:2, :2].tolist()
    across = nn + ee - (n * n * nn + 2.0 * n * e * ne + e * e * ee)
    variance = a.sigma**2 + d * d * float(p[DEPTH, DEPTH]) + 0.5 * (across / way) ** 2
    h = np.zeros((1, STATES))
    h[0, :2] = n, e
    return Innovation(np.array((heard - way - 0.5 * across / way,)), h, np.array(((variance,),)))


def fits(filter_: Filter, a: Aiding, run: Motion) -> bool:
    """Whether the value is within 1.5 sigma: an opened gate is widened until it is."""
    y, h, r = innovation(filter_, a, run)
    return float(y @ filter_.kalman.inv(h @ filter_.covariance @ h.T + r) @ y) < 2.25


def correct(filter_: Filter, a: Aiding, run: Motion) -> bool:
    """Correct the filter by a sensor's value; return False if it is beyond the gate."""
    y, h, r = innovation(filter_, a, run)
    inverse = filter_.kalman.inv(h @ filter_.covariance @ h.T + r)
    if float(y @ inverse @ y) > _GATES[len(y)]:
        return False
    filter_.kalman.update(y + h @ filter_.x, r, h)
    return True


def _of_hull(filter_: Filter, run: Motion, *, ground: bool) -> tuple[Array, Array]:
    """Return the expected speeds ahead and to starboard, and how they follow from the states."""
    x = filter_.x
    sm, cm = math.sin(run.heading), math.cos(run.heading)
    error = x[COMPASS] + x[WANDER] + x[SIN] * sm + x[COS] * cm
    c, s = math.cos(run.heading - float(error)), math.sin(run.heading - float(error))
    way = float(x[SCALE]) * run.expected + float(x[DEVIATION]) * run.driven
    z, h = np.array((way * run.along, way * run.sway)), np.zeros((2, STATES))
    for row, share in enumerate((run.along, run.sway)):
        h[row, SCALE], h[row, DEVIATION] = run.expected * share, run.driven * share
    if not ground:
        return z, h
    north, east = float(x[CN]), float(x[CE])
    h[:, CN], h[:, CE] = (c, -s), (s, c)
    if run.surfaced:
        north, east = north + float(x[WN]), east + float(x[WE])
        h[:, WN], h[:, WE] = (c, -s), (s, c)
    ahead, starboard = north * c + east * s, east * c - north * s
    z += (ahead + run.heave, starboard)
    for column, share in ((COMPASS, 1.0), (WANDER, 1.0), (SIN, sm), (COS, cm)):
        h[:, column] = (-starboard * share, ahead * share)
    return z, h
