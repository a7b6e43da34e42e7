"""How much waves move the vehicle to and fro at the surface, by a receiver's velocities.

A floating hull moves with the water: in waves of amplitude a and angular frequency w at up to a w
(0.5 m at 5 s: 0.6 m/s). The receiver measures that rightly, but it is no current. So a velocity
counts with the scatter that the velocities of the last half minute have about their mean, as if one
of an ordinary sea were among them: the less there are, the less each is believed. Velocities that
follow each other within 1.5 s share the phase of a wave, and count for less.

What does not live here: the receiver's own noise (the vehicle file), places (waves move the vehicle
by metres at most, less than the noise of a fix).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mission.navigation.filter import Array, Filter, Motion
from mission.navigation.items import GroundFix

ORDINARY = 0.2  # m/s, one sigma along an axis: a sea of 1 m significant height and 8 s
_PHASE = 1.5  # s: a quarter of a wave of 6 s; velocities that are nearer share its phase
_FADES = 30.0  # s, in which what was heard fades: three of the longest waves


class Seaway(NamedTuple):
    """Mean and scatter of the velocities over ground less the way through the water, north and
    east, m/s. What was heard counts the less, the longer ago it was: ``heard`` of them remain."""

    t: float = -math.inf
    heard: float = 0.0
    north: float = 0.0
    east: float = 0.0
    nn: float = 0.0
    ne: float = 0.0
    ee: float = 0.0

    def used(self, filter_: Filter, f: GroundFix, run: Motion) -> Seaway:
        """Hear the velocity of a fix, if it has one, and correct the filter by it."""
        if f.velocity is None:
            return self
        sea = self.after(f.t, f.velocity, run)
        noise = sea.noise(filter_.figures.ground_velocity, self.share(f.t))
        filter_.velocity(*f.velocity, run, noise)
        return sea

    def share(self, t: float) -> float:
        """Return how much a velocity at ``t`` tells beside the one before it: 1 is all of it."""
        return min(max(t - self.t, 0.1) / _PHASE, 1.0)

    def after(self, t: float, over_ground: tuple[float, float], run: Motion) -> Seaway:
        """Hear one velocity, m/s north and east, of a vehicle that runs so through the water."""
        through = run.expected * run.along
        north = over_ground[0] - through * math.cos(run.heading) - self.north
        east = over_ground[1] - through * math.sin(run.heading) - self.east
        fades, share = math.exp((self.t - t) / _FADES), self.share(t)
        heard = fades * self.heard + share
        part = share / heard
        apart = fades * self.heard * part
        return Seaway(
            *(t, heard, self.north + part * north, self.east + part * east),
            fades * self.nn + apart * north * north,
            fades * self.ne + apart * north * east,
            fades * self.ee + apart * east * east,
        )

    def noise(self, receiver: float, share: float) -> Array:
        """Return the covariance of the last velocity, (m/s)^2. ``receiver``: its own noise, m/s,
        one sigma along each axis at least; ``share``: what it tells beside the one before it."""
        usual, least, n = ORDINARY * ORDINARY, receiver * receiver, share * max(self.heard, 1.0)
        nn, ee = max((usual + self.nn) / n, least), max((usual + self.ee) / n, least)
        return np.array(((nn, self.ne / n), (self.ne / n, ee)))
