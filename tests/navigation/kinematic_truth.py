"""A vehicle that only has a course and a speed: quick truth for laws that need no dynamics.

The simulated vehicle (links.simulated) is the judge of consistency; this one is for single laws.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass

from mission.model import Position
from mission.navigation.geodesy import LocalFrame
from protocol.messages import Fix, Telemetry

HOME = Position(30.2874595, 120.1535765)


@dataclass(frozen=True, slots=True)
class Sea:
    """Truth that the vehicle does not know; rad and m/s."""

    current: tuple[float, float] = (0.1, -0.15)
    bias: float = 0.08
    scale: float = 1.05
    declination: float = 0.0
    heading_noise: float = math.radians(3.0)
    fix_noise: float = 2.5


@dataclass(frozen=True, slots=True)
class Truth:
    t: float
    north: float
    east: float
    heading: float
    speed: float
    depth: float


def sail(
    sea: Sea, surface_s: float, dive_s: float, seed: int, gear: float = 8.0, speed: float = 1.0
) -> Iterator[tuple[Truth, Telemetry | Fix]]:
    """One report every 2 s; fixes every second at first and again after the dive."""
    rng, frame = random.Random(seed), LocalFrame(HOME)
    n = e = 0.0
    for second in range(int(surface_s + dive_s) + 60):
        t = float(second)
        heading = (0.6 * (second // 90)) % (2.0 * math.pi)
        under = surface_s <= second < surface_s + dive_s
        depth = 0.2 + 0.5 * max(min(second - surface_s, surface_s + dive_s - second, 19.6), 0.0)
        v = speed * sea.scale
        n += v * math.cos(heading) + sea.current[0]
        e += v * math.sin(heading) + sea.current[1]
        truth = Truth(t, n, e, heading, v, depth)
        if second % 2 == 0:
            compass = heading + sea.bias - sea.declination + rng.gauss(0.0, sea.heading_noise)
            yield (
                truth,
                Telemetry(
                    t,
                    depth=depth + rng.gauss(0.0, 0.1),
                    altitude=20.0 - depth + rng.gauss(0.0, 0.1),
                    heading=compass % (2.0 * math.pi),
                    pitch=rng.gauss(0.0, 0.01),
                    roll=rng.gauss(0.0, 0.01),
                    actuators=(gear / 12.0, gear / 12.0, 0.0, 0.0, 0.0),
                ),
            )
        if not under:
            noisy = n + rng.gauss(0.0, sea.fix_noise), e + rng.gauss(0.0, sea.fix_noise)
            lat, lon = frame.to_geodetic(*noisy)
            yield truth, Fix(t + 0.1, lat, lon, sea.fix_noise)
