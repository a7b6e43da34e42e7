"""Noise of the motion by a receiver's speed and course, and the drift at the surface by dives' ends,
on vehicles whose truth is given: no simulator."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

import pytest

from mission.analysis.adrift import ENOUGH, drift
from mission.analysis.courses import courses, motion
from mission.analysis.noise import of_velocity
from mission.model import Position
from mission.model.shipped import load_vehicle
from mission.navigation import LocalFrame
from protocol.messages import Fix, Telemetry

AUV = load_vehicle("auv")
FRAME = LocalFrame(Position(30.2874595, 120.1535765))
GEAR = 8 / 12
PLAIN = 2.5  # m, of a receiver's places


def afloat(
    seed: int, *, velocity: float | None = 0.05, along: float = 0.0, across: float = 0.0
) -> list[Telemetry | Fix]:
    """Three minutes at 1 m/s with a turn in the middle; the speed off by ``along`` for ever, the
    way off to the side by ``across`` for some ten seconds each. ``velocity``: the noise of the
    receiver's, None: it tells none."""
    rng, items, n, e, side = Random(seed), list[Telemetry | Fix](), 0.0, 0.0, 0.0
    fast = 0.0
    for t in range(180):
        heading = 0.5 if t < 90 else 2.0
        kept = math.exp(-1.0 / 200.0)
        fast = kept * fast + along * math.sqrt(1.0 - kept * kept) * rng.gauss(0.0, 1.0)
        kept = math.exp(-0.1)
        side = kept * side + across * math.sqrt(1.0 - kept * kept) * rng.gauss(0.0, 1.0)
        speed = 1.0 + fast
        vn = speed * math.cos(heading) - side * math.sin(heading) + 0.1
        ve = speed * math.sin(heading) + side * math.cos(heading) - 0.05
        n, e = n + vn, e + ve
        place = FRAME.to_geodetic(n + rng.gauss(0.0, PLAIN), e + rng.gauss(0.0, PLAIN))
        fix = Fix(float(t), *place, accuracy=PLAIN)
        if velocity is not None:
            vn, ve = vn + rng.gauss(0.0, velocity), ve + rng.gauss(0.0, velocity)
            fix = replace(fix, speed=math.hypot(vn, ve), course=math.atan2(ve, vn))
        items.append(fix)
        if t % 2 == 0:
            compass = heading + rng.gauss(0.0, 1e-4)  # exact, it would be frozen
            items.append(Telemetry(t + 0.5, heading=compass, pitch=0.0, actuators=(GEAR,) * 2))
    return items


def found(
    along: float = 0.0, across: float = 0.0, velocity: float | None = 0.05
) -> tuple[float, float, float]:
    logs = [afloat(seed, velocity=velocity, along=along, across=across) for seed in range(8)]
    done = motion([course for log in logs for course in courses(log, AUV)])
    assert done is not None
    return done.along, done.across, done.sure


def test_a_receivers_speed_and_course_tell_how_evenly_a_hull_swims() -> None:
    along, across, sure = found(along=0.1, across=0.05)
    assert 0.04 < along < 0.16  # three minutes are less than a speed is kept for
    assert across == pytest.approx(0.05, rel=0.4)
    assert sure < 0.01
    even = found()
    assert max(even[:2]) < 0.02


def test_the_places_of_a_plain_receiver_hide_it() -> None:
    assert found(velocity=None)[2] > 0.5 * AUV.calibration.speed_noise


def test_the_noise_of_speed_and_course_is_found_and_never_less_than_makers_promise() -> None:
    for noise, told in ((0.15, 0.15), (0.01, 0.05)):
        log = afloat(1, velocity=noise)
        assert of_velocity([log]) == pytest.approx(told, rel=0.2)
    assert of_velocity([afloat(1, velocity=None)]) is None
    seldom = [i for i in afloat(1) if isinstance(i, Fix) and i.t % 5 == 0]
    assert of_velocity([seldom]) is None


def dive(seed: int, wind: float) -> list[Telemetry | Fix]:
    """At rest in a current: a minute at the surface, where ``wind`` moves it, too, five minutes
    under water, and a fix."""
    rng, items = Random(seed), list[Telemetry | Fix]()
    n, e = 0.0, 0.0
    current, drifting = ((rng.gauss(0.0, 0.1), rng.gauss(0.0, 0.1)) for _ in range(2))
    for t in range(360):
        deep = 60 <= t < 359
        share = 0.0 if deep else 10.0 * wind
        n, e = n + current[0] + share * drifting[0], e + current[1] + share * drifting[1]
        if not deep:
            place = FRAME.to_geodetic(n + rng.gauss(0.0, 0.5), e + rng.gauss(0.0, 0.5))
            items.append(Fix(float(t), *place, accuracy=0.5))
        if t % 2 == 0:
            depth = 5.0 * deep + rng.gauss(0.0, 0.03)
            compass = 0.7 + rng.gauss(0.0, 0.01)
            items.append(Telemetry(t + 0.5, heading=compass, depth=depth, actuators=(0.0, 0.0)))
    return items


@pytest.mark.parametrize(
    ("wind", "low", "high"), [(0.0, 0.1, 0.6), (0.03, 0.6, 1.7), (0.2, 3.0, 9)]
)
def test_the_ends_of_dives_tell_how_far_wind_moves_it_at_the_surface(
    wind: float, low: float, high: float
) -> None:
    logs = [dive(seed, wind) for seed in range(12)]
    told = drift(logs, [AUV] * len(logs))
    assert told is not None
    assert told.dives == len(logs)
    assert low < told.share < high


def test_few_dives_never_narrow_the_drift_and_none_tells_nothing() -> None:
    few = [dive(seed, 0.0) for seed in range(ENOUGH - 1)]
    told = drift(few, [AUV] * len(few))
    assert told is not None
    assert told.share == 1.0
    assert drift([afloat(1)], [AUV]) is None
