"""The yaw rate of a gyroscope that a user adds: carries the heading while no compass is believed.

While both speak, what the compass turned by less what the gyroscope did is its bias: the mean of
that since the first report, over 300 s at most. It is believed once it was compared for 30 s, if
four of the last five comparisons agree with each other, and not while it is frozen or silent.
A heading that is carried so for T seconds is off by its white noise, sigma sqrt(T), and by what the
bias may be off: the compass's noise over the time for which it was compared.

What does not live here: the compass (reckoner), which sensors there are (added).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mission.navigation.added import Seen
from mission.navigation.filter import Motion
from mission.navigation.items import Aiding
from protocol.added import TURN

_APART = 3.0  # s between two values, or a value and the report: more is a hole
_COMPARED, _REMEMBERED = 30.0, 300.0  # s: at least to be believed; at most of the mean
_LEAST = 1e-4  # rad/s: no bias is surer


class Gyro(NamedTuple):
    """``t``, ``rate``: of the last value; ``angle``: turned by since the last report, NaN after a
    hole; ``compared``: s; ``drifted``: rad, one sigma of what a carried heading is off by, and for
    how long it is carried."""

    t: float = -math.inf
    rate: float = 0.0
    sigma: float = 0.0
    angle: float = math.nan
    bias: float = 0.0
    compared: float = 0.0
    seen: Seen = Seen()
    carried: float = 0.0
    drifted: float = 0.0

    def heard(self, a: Aiding, run: Motion) -> Gyro:
        (rate,), since = a.values, a.t - self.t
        angle = self.angle + 0.5 * (self.rate + rate) * since if since <= _APART else math.nan
        seen = self.seen.heard(a, run)
        return self._replace(t=a.t, rate=rate, sigma=a.sigma, angle=angle, seen=seen)

    def reported(self, t: float) -> tuple[Gyro, float]:
        """At a report: turned by since the one before, NaN where that is not known."""
        beyond = t - self.t
        if not 0.0 <= beyond <= _APART:
            return self._replace(angle=math.nan), math.nan
        return self._replace(angle=-self.rate * beyond), self.angle + self.rate * beyond

    def compare(self, t: float, since: float, turned: float, compass: float, noise: float) -> Gyro:
        """With the compass, which turned by ``compass`` rad; ``noise``: one sigma of a heading."""
        fresh = self._replace(carried=0.0, drifted=0.0)
        if not math.isfinite(turned):
            return fresh
        off = math.remainder(compass - turned, 2.0 * math.pi) / since
        a = Aiding(t, TURN, (self.rate,), math.hypot(self.sigma, math.sqrt(2.0) * noise / since))
        seen = self.seen.noted(t, (off,))
        if not seen.confirmed(a):
            return fresh._replace(seen=seen)
        compared = min(self.compared + since, _REMEMBERED)
        bias = self.bias + (off - self.bias) * since / compared
        return fresh._replace(seen=seen, compared=compared, bias=bias)

    def carry(
        self, since: float, turned: float, noise: float, run: Motion
    ) -> tuple[Gyro, float | None]:
        """What the heading turned by in ``since`` seconds without a compass; None: not known."""
        known = math.isfinite(turned) and self.compared >= _COMPARED
        if not known or self.seen.frozen(TURN, run):
            return self, None
        carried = self.carried + since
        bias = max(math.sqrt(2.0) * noise / self.compared, _LEAST)
        drifted = math.hypot(self.sigma * math.sqrt(carried), bias * carried)
        return self._replace(carried=carried, drifted=drifted), turned + self.bias * since
