"""Deep-water waves, as sensors feel them: in the pressure, the attitude and the compass.

Linear theory (Dean and Dalrymple, Water Wave Mechanics, 1991, chapters 3 and 4). There are two
waves of nearly the same period, so they come in groups. A wave of amplitude a and angular frequency
w has k = w^2 / g. At depth z it

- changes the pressure head by ``a exp(-kz) cos``;
- tilts a floating body by its slope ``ak exp(-kz) sin``;
- turns the compass, which takes the acceleration for a part of gravity, by the slope times the
  tangent of the field's dip;
- moves the water by ``aw exp(-kz) cos`` along the direction of the crests' travel. A floating body
  moves with the water, and a GPS receiver shows this velocity.

A floating hull is much shorter than these waves and rises and falls with them, so its sensor sees
half of the pressure swing. Deeper the hull is taken to stand still, the worst case for its sensors.

What does not live here: the motion of the vehicle itself, which is that of still water.
"""

from __future__ import annotations

from math import cos, exp, pi, sin
from random import Random
from typing import NamedTuple

GRAVITY = 9.81  # m/s^2
AFLOAT = 0.5  # m: depth beyond which the hull does not float
_APART = 1.15  # ratio of the two periods: six or seven waves make a group


class Felt(NamedTuple):
    head: float = 0.0  # m
    roll: float = 0.0  # rad
    pitch: float = 0.0  # rad
    north: float = 0.0  # m/s, of the water
    east: float = 0.0


STILL = Felt()


def felt(waves: Waves | None, t: float, depth: float) -> Felt:
    return STILL if waves is None else waves.at(t, depth)


class Waves:
    """``amplitude``: m, the greatest of both waves together; ``period``: s."""

    def __init__(self, amplitude: float, period: float, seed: int) -> None:
        rng = Random(f"waves {seed}")  # of their own: waves change no other draw
        abeam = rng.uniform(0.0, 2.0 * pi)
        self._across, self._along = sin(abeam), cos(abeam)
        self._set = Random(f"crests {seed}").uniform(0.0, 2.0 * pi)  # direction of travel, rad
        self._amplitude = amplitude / 2.0
        frequencies = 2.0 * pi / period, 2.0 * pi / (_APART * period)
        self._both = tuple((w, w * w / GRAVITY, rng.uniform(0.0, 2.0 * pi)) for w in frequencies)

    def at(self, t: float, depth: float) -> Felt:
        head = slope = flow = 0.0
        share = 0.5 if depth < AFLOAT else 1.0
        for w, k, phase in self._both:
            here = self._amplitude * exp(-k * max(depth, 0.0))
            up = here * cos(w * t + phase)
            head += up
            flow += up * w
            slope += here * k * sin(w * t + phase)
        lean = slope * self._across, slope * self._along
        return Felt(share * head, *lean, flow * cos(self._set), flow * sin(self._set))
