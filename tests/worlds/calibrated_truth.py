"""Dives with a vehicle file that `calibrate` made of other days in the same waters.

    waters    a current of 0 to 0.3 m/s; each day's is off by 0.08 m/s on each axis (one sigma)
    vehicle   a compass bias to 10 deg, a speed table off by 10 % (one sigma)
    logs      ``LOGS`` days with fixes at the surface before the dive, through `calibrate`
    dives     ``DIVES`` other days, each judged at its end, before a fix comes

Everything else is the product's own: the shipped vehicle file, `calibrate`, the navigation.

    python tests/worlds/calibrated_truth.py 40       so many vehicles, each in waters of its own
    python tests/worlds/calibrated_truth.py 40 tide  each day's current is a tide at any of its hours
    python tests/worlds/calibrated_truth.py 40 wind  and a wind drives it at the surface, another each day
"""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from random import Random

import numpy as np
from simulated_truth import CHI2_95, HOME, Flown, flown

from links.simulated.link import SimulatedVehicle
from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors
from links.simulated.settings import Settings
from mission.analysis.calibration import calibrate
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from mission.navigation import LocalFrame, Navigation
from protocol.messages import Fix

LOGS, DIVES = 6, 4
DAY = 0.08  # m/s, of a current on each axis
QUIET = 60.0  # s without a fix: it is under water
TIDE = 12.42 * 3600.0  # s
WIND = 0.03  # m/s, of the drift at the surface on each axis
AFLOAT = 0.5  # m
SEAS = ("steady", "tide", "wind")


@dataclass(frozen=True, slots=True)
class End:
    """Of one dive, before a fix comes: NEES over its two degrees of freedom, error and 95 % radius
    in % of the way over ground."""

    nees: float
    error: float
    radius: float


class Moved(SimulatedVehicle):
    """In a tide of ``DAY`` (root mean square on each axis) about ``mean``, and a wind."""

    def __init__(
        self,
        mean: tuple[float, float],
        hours: tuple[float, float],
        wind: tuple[float, float],
        profile: str,
        seed: int,
        settings: Settings,
    ) -> None:
        super().__init__(profile, seed, settings)
        self._mean, self._hours, self._wind = mean, hours, wind
        self._sheared = True  # the current is looked at anew with each tick

    def advance(self, to_t: float) -> None:
        afloat = not self.track or self.track[-1].depth < AFLOAT
        turned = 2.0 * math.pi * self.now / TIDE
        north, east = (
            mean + math.sqrt(2.0) * DAY * math.sin(turned + hour) + afloat * wind
            for mean, hour, wind in zip(self._mean, self._hours, self._wind, strict=True)
        )
        self.current = north, east
        super().advance(to_t)


def dives(seed: int, *, learning: bool, sea: str = "steady") -> list[End]:
    """Of one vehicle; ``learning``: with fixes before each dive, else with one."""
    rng = Random(seed)
    speed, towards = rng.uniform(0.0, 0.3), rng.uniform(0.0, 2.0 * math.pi)
    waters = speed * math.cos(towards), speed * math.sin(towards)
    bias, table = math.radians(rng.uniform(-10.0, 10.0)), math.exp(rng.gauss(0.0, 0.1))
    day = _day if sea == "steady" else functools.partial(_moving_day, WIND * (sea == "wind"))
    days = [day(rng, waters, bias, fixes) for fixes in (True,) * LOGS + (learning,) * DIVES]
    auv = load_vehicle("auv")
    guessed = replace(auv, calibration=replace(auv.calibration, speed_scale=table))
    known = calibrate([day.items for day in days[:LOGS]], guessed).vehicle
    return [_end(day, known) for day in days[LOGS:]]


def _day(rng: Random, waters: tuple[float, float], bias: float, fixes: bool) -> Flown:
    north, east = (c + rng.gauss(0.0, DAY) for c in waters)
    sea = Sea(current=(math.hypot(north, east), math.atan2(east, north)))
    errors = SensorErrors(declination=math.radians(-6.2), compass_bias=bias)
    return flown(rng.randrange(10**6), Settings(sea=sea, errors=errors), learning=fixes)


def _moving_day(
    windy: float, rng: Random, waters: tuple[float, float], bias: float, fixes: bool
) -> Flown:
    hours = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.0, 2.0 * math.pi)
    wind = rng.gauss(0.0, windy), rng.gauss(0.0, windy)
    errors = SensorErrors(declination=math.radians(-6.2), compass_bias=bias)
    built = functools.partial(Moved, waters, hours, wind)
    settings = Settings(errors=errors)
    return flown(rng.randrange(10**6), settings, learning=fixes, built=built)


def _end(day: Flown, known: Vehicle) -> End:
    nav, frame, last = Navigation(known, HOME), LocalFrame(HOME), math.inf
    for item in day.items:
        if isinstance(item, Fix) and item.t - last > QUIET:
            break
        if isinstance(item, Fix):
            nav.fix(item)
            last = item.t
        else:
            nav.telemetry(item)
    seen = [truth for truth in day.truth if last <= truth.t <= item.t]
    places = np.array([frame.to_local(t.latitude, t.longitude) for t in seen])
    way = float(np.hypot(*np.diff(places, axis=0).T).sum())
    e = nav.estimate(seen[-1].t)
    assert e is not None
    dn, de = places[-1] - (e.north, e.east)
    a, b, d = e.covariance
    det = a * d - b * b
    nees = (d * dn * dn - 2.0 * b * dn * de + a * de * de) / det
    radius = math.sqrt(CHI2_95 * math.sqrt(det))
    return End(0.5 * nees, 100.0 * math.hypot(dn, de) / way, 100.0 * radius / way)


def told(ends: Sequence[End]) -> str:
    from scipy.stats import chi2

    low, high = chi2.ppf((0.005, 0.995), 2 * len(ends)) / (2 * len(ends))
    nees = [end.nees for end in ends]
    inside = np.mean([2.0 * n < CHI2_95 for n in nees])
    return (
        f"{len(ends)} dives: NEES {np.mean(nees):.2f} ({low:.2f} to {high:.2f}), ellipse holds "
        f"{inside:.0%}, error {np.median([e.error for e in ends]):.1f} %, "
        f"radius {np.median([e.radius for e in ends]):.1f} %"
    )


def main(vehicles: int, sea: str) -> None:
    for learning in (True, False):
        each = (dives(seed, learning=learning, sea=sea) for seed in range(vehicles))
        ends = [end for one in each for end in one]
        sys.stdout.write(f"{'fixes before' if learning else 'one fix'}: {told(ends)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40, sys.argv[2] if sys.argv[2:] else SEAS[0])
