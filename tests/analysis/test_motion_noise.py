"""Noise of the motion by a receiver's speed and course, and the drift at the surface by dives' ends,
on vehicles whose truth is given: no simulator."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
import yaml

from mission.analysis.adrift import ENOUGH, SHARES, drift, with_drift
from mission.analysis.calibration import calibrate
from mission.analysis.courses import courses, motion
from mission.analysis.information import FIGURES, information
from mission.analysis.lessons import kept, section
from mission.analysis.noise import of_velocity
from mission.analysis.pooling import FEW
from mission.model import Position
from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import Vehicle
from mission.navigation import LocalFrame, Navigation
from mission.navigation.model import CN
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
    ("wind", "low", "high"), [(0.0, 0.1, 0.6), (0.03, 0.5, 2.0), (0.2, 3.0, 9)]
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


def test_what_a_handful_of_dives_leaves_open_of_a_drift_is_added() -> None:
    """None is told below the least share tried with what is added to the spread of a handful."""
    told = drift([dive(seed, 0.0) for seed in range(12)], [AUV] * 12)
    assert told is not None
    assert told.share >= FEW * SHARES[0]


def test_a_speed_that_is_kept_for_minutes_is_told_by_many_minutes_alone() -> None:
    assert "motion" in kept(calibrate([afloat(1)], AUV))
    logs = [afloat(seed) for seed in range(3)]
    assert "motion" not in kept(calibrate(logs, AUV))


def test_the_dives_of_a_log_teach_no_drift_to_itself() -> None:
    log = [item for seed in range(4) for item in later(dive(seed, 0.0), 400.0 * seed)]
    assert calibrate([log], AUV).drift is None
    both = calibrate([log, later(log, 1e4)], AUV)
    assert both.drift is None or both.drift.dives >= ENOUGH


def later(log: list[Telemetry | Fix], seconds: float) -> list[Telemetry | Fix]:
    return [
        item._replace(t=item.t + seconds)
        if isinstance(item, Telemetry)
        else replace(item, t=item.t + seconds)
        for item in log
    ]


def pace(share: float, minutes: float) -> tuple[float, float]:
    known = with_drift(AUV, share, 60.0 * minutes).calibration
    return known.current_time, known.current_time_for


def test_dives_that_miss_little_tell_how_steady_a_current_is_for_as_long_as_they_last() -> None:
    tide = 12.42 * 3600.0
    for minutes in (5.0, 10.0, 20.0):
        time, valid = pace(1.0 / 27.0, minutes)
        assert valid == 60.0 * minutes
        # no less than a tide changes in that time
        changed = 1.0 - math.cos(2.0 * math.pi * valid / tide)
        assert 1.0 - math.exp(-valid / time) == pytest.approx(changed)
    assert pace(0.9, 10.0)[0] == pytest.approx(AUV.calibration.current_time / 0.81)
    for share in (1.0, 3.0):  # more is the drift's
        assert pace(share, 10.0) == (AUV.calibration.current_time, 0.0)
    assert pace(0.1, 60.0) == (AUV.calibration.current_time, 0.0)  # as long as a tide shows


def test_what_is_written_of_receiver_drift_and_pace_is_read_back(tmp_path: Path) -> None:
    told = with_drift(AUV, 0.1, 600.0)
    told = replace(told, calibration=replace(told.calibration, fix_velocity=0.07))
    base = yaml.safe_load((missions_folder() / "vehicles" / "auv.yaml").read_text())
    file = tmp_path / "auv2.yaml"
    file.write_text(yaml.safe_dump(base | yaml.safe_load(section(told))))
    read, known = load_vehicle(file).calibration, told.calibration
    assert read.current_time_for == known.current_time_for == 600.0
    assert read.current_time == pytest.approx(known.current_time, abs=0.5)
    assert read.current_time > AUV.calibration.current_time
    assert (read.fix_velocity, read.surface_drift) == (0.07, pytest.approx(known.surface_drift))
    assert "current_time" not in section(AUV)


def test_a_pace_that_dives_told_is_taken_back_by_dives_that_miss_more() -> None:
    steady = with_drift(AUV, 0.1, 600.0)
    assert with_drift(steady, 9.0, 600.0).calibration.current_time == pytest.approx(
        AUV.calibration.current_time
    )


def current_variance(vehicle: Vehicle, seconds: int) -> float:
    """Of one axis, so long after a minute of fixes that told it."""
    nav, told = Navigation(vehicle), FRAME.to_geodetic(0.0, 0.0)
    for t in range(-60, seconds):
        if t <= 0:
            nav.fix(Fix(float(t), told[0] + 1e-9 * t, told[1], accuracy=0.5))
        if t % 2 == 0:
            depth, heading = 5.0 * (t > 0) + 1e-4 * t, 0.7 + 1e-4 * t
            nav.telemetry(Telemetry(t + 0.5, heading=heading, depth=depth, actuators=(0.0, 0.0)))
    return float(nav.core.filter.covariance[CN, CN])


def test_a_current_is_steadier_for_the_time_that_is_said_and_no_longer() -> None:
    known = replace(AUV.calibration, current_sigma=0.1, surface_drift=1e-3)
    plain = replace(AUV, calibration=known)
    steady = replace(AUV, calibration=replace(known, current_time=1e6, current_time_for=300.0))
    a, b = ([current_variance(v, t) for t in (2, 290, 310, 900)] for v in (plain, steady))
    assert b[1] - b[0] < 0.1 * (a[1] - a[0])
    assert b[3] - b[2] == pytest.approx(a[3] - a[2], rel=0.05)


def test_how_far_one_looks_for_a_bias_or_a_scale_does_not_change_what_a_log_tells_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    near = information(afloat(1), AUV).variances
    rows = tuple(
        replace(row, wide=2.0 * row.wide) if i < 2 else row for i, row in enumerate(FIGURES)
    )
    monkeypatch.setattr("mission.analysis.information.FIGURES", rows)
    far = information(afloat(1), AUV).variances
    assert far[:2] == pytest.approx(near[:2], rel=0.1)
