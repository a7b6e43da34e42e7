"""White noise of the sensors, of each report independently, estimated from logs.

White noise is what is left in third differences: constants, ramps and curves cancel (Brockwell and
Davis, Time Series, 1991, ch. 1.4). A figure for which the logs hold too little is kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from statistics import median
from typing import TypeVar

from mission.analysis.courses import Inputs
from mission.model.vehicle import Sensors, Vehicle
from mission.navigation.geodesy import EARTH
from protocol.added import GROUND, PLACE, RANGE, WATER
from protocol.messages import Aid, Fix, Telemetry

_Said = TypeVar("_Said")
LEAST = {WATER: 2e-3, GROUND: 2e-3, PLACE: 0.05, RANGE: 0.05}  # SI: the least sigmas
_MEDIAN = 1.3863  # median of chi-square with two degrees of freedom
_NEXT = 1.5  # s between two successive fixes, at most
_SUREST = 0.05  # m/s: promised by makers of small receivers; slow errors do not show in differences
ENOUGH = 20  # differences; with fewer, a noise figure is kept


def sensed(
    vehicle: Vehicle, logs: Sequence[Inputs], squares: Sequence[float]
) -> tuple[Vehicle, tuple[str, ...]]:
    """Add the sensors' noise; also return the names of sensors with too little data. ``squares``:
    normalised innovations of successive fixes (the filter adds little to them), times the fixes'
    variance."""
    reports = [[i for i in log if isinstance(i, Telemetry)] for log in logs]
    depth = white_noise(reports, lambda t: t.depth)
    found = {
        "depth": (None if depth is None else depth * math.sqrt(2.0), 0.01),
        "altitude": (white_noise(reports, lambda t: t.altitude), 0.01),
        "heading": (white_noise(reports, lambda t: t.heading, circular=True), 2e-3),
        "fix": (_fix_noise(squares), 0.01),
    }
    heard = {name: max(s, least) for name, (s, least) in found.items() if s is not None}
    sensors: Sensors = replace(vehicle.sensors, **heard)
    return replace(vehicle, sensors=sensors), tuple(n for n in found if n not in heard)


def of_velocity(logs: Sequence[Inputs]) -> float | None:
    """Estimate one sigma of a receiver's speed and course, m/s on each axis, from successive fixes;
    None if there are too few."""
    found = []
    for log in logs:
        fixes = [i for i in log if isinstance(i, Fix) and i.speed is not None]
        ends = [k for k, (a, b) in enumerate(pairwise(fixes), 1) if b.t - a.t > _NEXT]
        cuts = [0, *ends, len(fixes)]
        found += [fixes[a:b] for a, b in pairwise(cuts)]
    axes = [white_noise(found, partial(_made_good, axis=f)) for f in (math.cos, math.sin)]
    known = [s for s in axes if s is not None]
    return max(math.sqrt(sum(s * s for s in known) / len(known)), _SUREST) if known else None


def _made_good(f: Fix, axis: Callable[[float], float]) -> float | None:
    return None if f.speed is None or f.course is None else f.speed * axis(f.course)


def of_added(logs: Sequence[Sequence[Aid]], vehicle: Vehicle) -> dict[str, float]:
    """Estimate one sigma of each value of the added sensors, by kind, for kinds with enough data.
    No log shows their offsets."""
    found: dict[str, list[float]] = {}
    for kind, which in dict.fromkeys((a.kind, _source(a)) for log in logs for a in log):
        said = [[a for a in log if (a.kind, _source(a)) == (kind, which)] for log in logs]
        for axis in range(2):
            sigma = white_noise(said, partial(_metric, axis=axis, vehicle=vehicle))
            found.setdefault(kind, []).extend([] if sigma is None else [sigma])
    return {kind: max(median(s), LEAST[kind]) for kind, s in found.items() if s}


def _source(a: Aid) -> float:
    """Return which beacon: each is a series of its own."""
    return a.values[0] if a.kind == RANGE else 0.0


def _metric(a: Aid, axis: int, vehicle: Vehicle) -> float | None:
    """Return one value in SI units: metres for a place or a range."""
    if a.kind == RANGE:
        beacon = vehicle.beacons.get(f"{a.values[0]:g}")
        return None if axis or beacon is None else a.values[1] * beacon.sound
    if axis >= len(a.values):
        return None
    across = math.cos(a.values[0]) if axis else 1.0
    return a.values[axis] * EARTH * across if a.kind == PLACE else a.values[axis]


def white_noise(
    logs: Sequence[Sequence[_Said]],
    read: Callable[[_Said], float | None],
    *,
    circular: bool = False,
) -> float | None:
    """Estimate the sigma of white noise by the median of third differences. Curves cancel; windows
    with repeated values are left out. None if there are too few."""
    found: list[float] = []
    for log in logs:
        for window in zip(*(log[i:] for i in range(4)), strict=False):
            values = [read(t) for t in window]
            if any(v is None for v in values) or len(set(values)) < 4:
                continue
            a, b, c, d = (float(v) for v in values if v is not None)
            third = d - 3.0 * c + 3.0 * b - a
            found.append(abs(math.remainder(third, 2.0 * math.pi) if circular else third))
    if len(found) < ENOUGH:
        return None
    return median(found) / 0.6745 / math.sqrt(20.0)  # 0.6745: median of |normal|; 20: 1 + 9 + 9 + 1


def _fix_noise(squares: Sequence[float]) -> float | None:
    return math.sqrt(median(squares) / _MEDIAN) if len(squares) >= ENOUGH else None
