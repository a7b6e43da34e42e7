"""What filterpy costs beyond its equations: one hour of input through Filter, and in numpy.

Input: 1800 @SD and 3600 GPS sentences, which are 1800 fixes. Both sides do the same: write F and
Q, x after the motion, P = F P F' + Q, and the Joseph update with two measurements. Prints the
ratio of the medians of alternating runs; the whole Navigation is timed beside it.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from dataclasses import replace

import numpy as np

from mission.model import Position
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from mission.navigation import LocalFrame, Navigation
from mission.navigation.filter import Filter, Motion
from mission.navigation.model import STATES, figures
from protocol.messages import Fix, Telemetry

REPORTS, ROUNDS = 1800, 7
HOME = Position(30.2874595, 120.1535765)


class Plain(Filter):
    """The same equations, called directly: no library around them."""

    def __init__(self, vehicle: Vehicle) -> None:
        super().__init__(figures(vehicle))
        kf = self.kalman
        self.x_, self.p_, self.f_, self.q_ = kf.x, kf.P, kf.F, kf.Q
        self.i_ = np.eye(STATES)

    def move(self, dt: float, run: Motion) -> None:
        self.kalman.x = self.x_  # ``transition`` reads the state there
        moved = self.transition(dt, run)
        self.x_ = self.f_ @ self.x_
        self.p_ = self.f_ @ self.p_ @ self.f_.T + self.q_
        self.x_[:4] = moved

    def correct(self, z: np.ndarray, r: np.ndarray, h: np.ndarray) -> None:
        y = z - h @ self.x_
        pht = self.p_ @ h.T
        s = h @ pht + r
        (a, b), (c, d) = s.tolist()
        det = 1.0 / (a * d - b * c)
        k = pht @ np.array(((d * det, -b * det), (-c * det, a * det)))
        self.x_ = self.x_ + k @ y
        ikh = self.i_ - k @ h
        self.p_ = ikh @ self.p_ @ ikh.T + k @ r @ k.T


def _runs() -> list[Motion]:
    return [Motion(heading=0.01 * i, expected=1.0) for i in range(REPORTS)]


def library(vehicle: Vehicle, runs: list[Motion]) -> tuple[float, np.ndarray]:
    f = Filter(figures(vehicle))
    f.place(0.0, 0.0, 6.0)
    begin = time.perf_counter()
    for i, run in enumerate(runs):
        f.predict(1.0, run)
        f.vertical(5.0, 10.0)
        f.predict(1.0, run)
        f.fix(0.5 * i, 0.1 * i, 6.25)
    return time.perf_counter() - begin, f.covariance


def plain(vehicle: Vehicle, runs: list[Motion]) -> tuple[float, np.ndarray]:
    from mission.navigation.filter import _BOTH, _POSITION

    f = Plain(vehicle)
    f.place(0.0, 0.0, 6.0)
    f.x_, f.p_ = f.kalman.x, f.kalman.P
    rd, ra = 0.5 * f.figures.depth**2, f.figures.altitude**2
    begin = time.perf_counter()
    for i, run in enumerate(runs):
        f.move(1.0, run)
        f.correct(np.array((5.0, 10.0)), np.array(((rd, 0.0), (0.0, ra))), _BOTH)
        f.move(1.0, run)
        f.correct(np.array((0.5 * i, 0.1 * i)), np.array(((6.25, 0.0), (0.0, 6.25))), _POSITION)
    return time.perf_counter() - begin, f.p_


def whole(vehicle: Vehicle) -> float:
    """Navigation as the engine uses it: health, frame, gate, history, one estimate a report."""
    nav, frame = Navigation(replace(vehicle, declination=0.0), HOME), LocalFrame(HOME)
    items: list[Telemetry | Fix] = []
    for i in range(REPORTS):
        t, heading = 2.0 * i, (0.01 * i) % (2.0 * math.pi)
        items.append(
            Telemetry(t, 5.0 + 1e-3 * i, 10.0 - 1e-3 * i, heading, 0.0, 0.0, actuators=(0.5,) * 5)
        )
        items.append(Fix(t + 1.0, *frame.to_geodetic(0.1 * i, 0.05 * i), 2.5))
    begin = time.perf_counter()
    for item in items:
        if isinstance(item, Telemetry):
            nav.telemetry(item)
            nav.estimate(item.t)
        else:
            nav.fix(item)
    return time.perf_counter() - begin


def measure() -> dict[str, float]:
    vehicle, runs = load_vehicle("auv"), _runs()
    pairs = []
    for _ in range(ROUNDS):
        one, p_one = library(vehicle, runs)
        two, p_two = plain(vehicle, runs)
        assert np.allclose(p_one, p_two, rtol=1e-9)
        pairs.append((one, two))
    lib, bare = (statistics.median(column) for column in zip(*pairs, strict=True))
    return {"filterpy_s": lib, "numpy_s": bare, "ratio": lib / bare, "navigation_s": whole(vehicle)}


def main() -> dict[str, float]:
    m = measure()
    sys.stdout.write(
        f"navigation, 1800 @SD + 1800 fixes: filterpy {m['filterpy_s']:.3f} s, the same equations "
        f"in numpy {m['numpy_s']:.3f} s, ratio {m['ratio']:.2f} (at most 1.5); "
        f"all of Navigation {m['navigation_s']:.3f} s\n"
    )
    return {"ratio": m["ratio"]}


if __name__ == "__main__":
    main()
