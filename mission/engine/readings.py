"""The functions that the rows of ``variables`` name: how a reading is taken, and how sure it is.

A function of a Scope returns the SI value or None. Those under ``how sure`` return one standard
deviation, or the share of the distribution that fulfils a comparison, if the reading is not a
single normal variable.

What does not live here: names, units and ages (variables), what is remembered (memory).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from mission.legs.base import Track
from mission.model import Back, Estimate, Health, Trend
from mission.navigation import distribution
from protocol.messages import Telemetry


class Recall(Protocol):
    """The memory of readings, in SI; None: not known (mission.engine.memory)."""

    def extreme(self, trend: Trend) -> float | None: ...

    def peak(self, back: Back) -> float | None: ...


@dataclass(slots=True)
class Scope:
    """All that a reading can be taken from, at one instant. ``track``: the active leg's;
    ``stale_after``: s, the greatest age of a believed report."""

    now: float
    estimate: Estimate | None
    telemetry: Telemetry | None
    health: Callable[[str], Health]
    entered: float  # when the leg began
    started: float  # when the mission began
    travelled: float
    round: int
    track: Callable[[], Track | None]
    memory: Recall | None = None
    stale_after: float = math.inf


Value = float | None
Read = Callable[[Scope], Value]


# --- readings ------------------------------------------------------------------------------


def estimated(name: str) -> Read:
    def read(scope: Scope) -> Value:
        value: Value = getattr(scope.estimate, name, None)
        return value

    return read


def _located(scope: Scope) -> Estimate | None:
    estimate = scope.estimate
    return estimate if estimate is not None and estimate.located else None


def position(name: str) -> Read:
    def read(scope: Scope) -> Value:
        value: Value = getattr(_located(scope), name, None)
        return value

    return read


def reported(name: str) -> Read:
    def read(scope: Scope) -> Value:
        value: Value = getattr(scope.telemetry, name, None)
        return value

    return read


def battery(index: int) -> Read:
    def read(scope: Scope) -> Value:
        batteries = scope.telemetry.batteries if scope.telemetry else None
        return batteries[index] if batteries and index < len(batteries) else None

    return read


def leak(scope: Scope) -> Value:
    leak = scope.telemetry.leak if scope.telemetry else None
    return None if leak is None else float(leak)


def _ground(scope: Scope) -> tuple[float, float] | None:
    """Velocity over ground, north and east."""
    e = scope.estimate
    if e is None or e.heading is None:
        return None
    north = e.speed * math.cos(e.heading) + e.current_north
    return north, e.speed * math.sin(e.heading) + e.current_east


def ground_speed(scope: Scope) -> Value:
    velocity = _ground(scope)
    return None if velocity is None else math.hypot(*velocity)


_SLOWEST_COURSE = 0.05  # m/s: a slower velocity has no direction


def course(scope: Scope) -> Value:
    velocity = _ground(scope)
    if velocity is None or math.hypot(*velocity) < _SLOWEST_COURSE:
        return None
    return math.atan2(velocity[1], velocity[0]) % (2.0 * math.pi)


def range_home(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else math.hypot(e.north, e.east)


def bearing(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else math.atan2(-e.east, -e.north) % (2.0 * math.pi)


def distance(scope: Scope) -> Value:
    track = scope.track() if _located(scope) else None
    return None if track is None else track.distance


def cross_track(scope: Scope) -> Value:
    track = scope.track() if _located(scope) else None
    return None if track is None else track.cross_track


def current(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else math.hypot(e.current_north, e.current_east)


def uncertainty(scope: Scope) -> Value:
    e = _located(scope)
    return None if e is None else distribution.around_95(e.covariance)


def fix_age(scope: Scope) -> Value:
    e = scope.estimate
    if e is None or e.fix_age is None:
        return None
    return round(e.fix_age + scope.now - e.t, 6)


# Times are rounded to the microsecond, so that they meet a deadline computed as a sum.
def elapsed(scope: Scope) -> Value:
    return round(scope.now - scope.entered, 6)


def mission_time(scope: Scope) -> Value:
    return round(scope.now - scope.started, 6)


# --- how sure ------------------------------------------------------------------------------


def sigma_of(name: str) -> Callable[[Scope], float]:
    def sigma(scope: Scope) -> float:
        return scope.estimate.sigmas.get(name, 0.0) if scope.estimate else 0.0

    return sigma


def toward(bearing: float) -> Callable[[Scope], float]:
    def sigma(scope: Scope) -> float:
        e = scope.estimate
        return distribution.along(e.covariance, bearing) if e else 0.0

    return sigma


def greatest(scope: Scope) -> float:
    return distribution.principal(scope.estimate.covariance)[0] if scope.estimate else 0.0


def bearing_sigma(scope: Scope) -> float:
    e, far = scope.estimate, range_home(scope)
    if e is None or not far:
        return math.pi
    across = distribution.along(e.covariance, math.atan2(e.east, e.north) + math.pi / 2)
    return min(across / far, math.pi)


def course_sigma(scope: Scope) -> float:
    speed = ground_speed(scope) or _SLOWEST_COURSE
    return min(math.hypot(sigma_of("heading")(scope), sigma_of("current")(scope) / speed), math.pi)


def ground_speed_sigma(scope: Scope) -> float:
    return math.hypot(sigma_of("speed")(scope), sigma_of("current")(scope))


def cross_sigma(scope: Scope) -> float:
    track = scope.track()
    return 0.0 if track is None else toward(track.bearing + math.pi / 2)(scope)


def range_share(scope: Scope, bound: float) -> Value:
    e = _located(scope)
    return None if e is None else distribution.within(bound, e.north, e.east, e.covariance)


def distance_share(scope: Scope, bound: float) -> Value:
    e, track = _located(scope), scope.track()
    if e is None or track is None:
        return None
    north, east = (track.distance * f(track.ahead) for f in (math.cos, math.sin))
    return distribution.within(bound, north, east, e.covariance)
