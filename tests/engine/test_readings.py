"""What each reading is of an instant, and how sure it is: by hand, from an estimate and a report."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from mission.engine import readings
from mission.engine.readings import Scope
from mission.engine.variables import (
    VARIABLES,
    difference,
    reading_of,
    reading_row,
    row_of,
    value_of,
)
from mission.legs.base import Track
from mission.model import Estimate, Health, NavigationMode
from mission.model.vehicle import STALE_AFTER
from mission.navigation import distribution
from protocol.messages import Telemetry
from protocol.vehicles.channels import Source

SIGMAS = {"heading": 0.1, "current": 0.3, "speed": 0.4}
HERE = Estimate(
    t=98.0,
    north=-30.0,
    east=-40.0,
    depth=5.0,
    depth_rate=0.0,
    altitude=None,
    heading=math.radians(30.0),
    speed=1.0,
    current_north=0.2,
    current_east=-0.1,
    covariance=(9.0, 0.0, 1.0),
    sigmas=SIGMAS,
    nis=None,
    fix_age=1.23456789,
    mode=NavigationMode.FIX,
)
VELOCITY = (math.cos(math.radians(30.0)) + 0.2, 0.5 - 0.1)
NOWHERE = HERE._replace(mode=NavigationMode.NONE)
TRACK = Track(distance=20.0, cross_track=3.0, bearing=0.0, ahead=math.radians(60.0))


def scope(
    estimate: Estimate | None = HERE,
    report: Telemetry | None = None,
    track: Track | None = None,
) -> Scope:
    times = 90.00000049, 10.00000051
    return Scope(100.0, estimate, report, lambda _: Health(True, "", 0.0), *times, 0.0, 1, lambda: track)  # fmt: skip


@pytest.mark.parametrize(
    ("read", "value"),
    [
        (readings.ground_speed, math.hypot(*VELOCITY)),
        (readings.course, math.atan2(VELOCITY[1], VELOCITY[0])),
        (readings.range_home, 50.0),
        (readings.bearing, math.atan2(40.0, 30.0)),
        (readings.current, math.hypot(0.2, -0.1)),
        (readings.uncertainty, distribution.around_95(HERE.covariance)),
        (readings.fix_age, 3.234568),
        (readings.estimated("depth"), 5.0),
        (readings.position("north"), -30.0),
    ],
)
def test_a_reading_follows_from_the_estimate_and_without_one_is_unknown(read, value: float) -> None:
    assert read(scope()) == pytest.approx(value, abs=1e-12)
    assert read(scope(None)) is None


def test_a_direction_is_within_one_turn_from_north() -> None:
    back = HERE._replace(heading=math.radians(200.0), north=30.0, east=40.0)
    assert readings.course(scope(back)) == pytest.approx(
        math.atan2(math.sin(math.radians(200.0)) - 0.1, math.cos(math.radians(200.0)) + 0.2)
        + math.tau
    )
    assert readings.bearing(scope(back)) == pytest.approx(math.atan2(-40.0, -30.0) + math.tau)


def test_what_hardly_moves_has_no_course_and_without_a_heading_there_is_no_ground_speed() -> None:
    still = HERE._replace(speed=0.0, current_north=0.049, current_east=0.0)
    assert readings.course(scope(still)) is None
    assert readings.course(scope(still._replace(current_north=0.051))) == 0.0
    assert readings.ground_speed(scope(HERE._replace(heading=None))) is None


@pytest.mark.parametrize(
    "read", [readings.range_home, readings.bearing, readings.current, readings.uncertainty,
             readings.position("east")]
)  # fmt: skip
def test_where_no_position_is_known_nothing_of_a_place_is(read: Callable[[Scope], object]) -> None:
    assert read(scope(NOWHERE)) is None


def test_times_are_told_to_the_microsecond() -> None:
    assert readings.elapsed(scope()) == 10.0
    assert readings.mission_time(scope()) == 89.999999


@pytest.mark.parametrize(
    ("batteries", "known"),
    [((12.5, 48.0), (12.5, 48.0, None)), ((12.5,), (12.5, None, None)), (None, (None,) * 3)],
)
def test_a_battery_that_is_not_reported_is_unknown(batteries, known) -> None:
    report = Telemetry(0.0, batteries=batteries)
    assert tuple(readings.battery(n)(scope(report=report)) for n in range(3)) == known
    assert readings.battery(0)(scope()) is None


@pytest.mark.parametrize(("leaks", "value"), [(True, 1.0), (False, 0.0), (None, None)])
def test_a_leak_is_one_or_nought(leaks: bool | None, value: float | None) -> None:
    assert readings.leak(scope(report=Telemetry(0.0, leak=leaks))) == value


def test_what_the_leg_tells_of_its_track_needs_a_position() -> None:
    for read, value in ((readings.distance, 20.0), (readings.cross_track, 3.0)):
        assert read(scope(track=TRACK)) == value
        assert read(scope()) is None
        assert read(scope(NOWHERE, track=TRACK)) is None


# --- how sure ---------------------------------------------------------------------------------------


def test_a_sigma_that_the_estimate_does_not_tell_is_nought() -> None:
    assert readings.sigma_of("speed")(scope()) == 0.4
    assert readings.sigma_of("depth")(scope()) == 0.0
    for sigma in (readings.sigma_of("speed"), readings.toward(0.0), readings.greatest):
        assert sigma(scope(None)) == 0.0


def test_a_sigma_of_a_place_is_that_along_its_bearing() -> None:
    assert readings.toward(0.0)(scope()) == pytest.approx(3.0)
    assert readings.toward(math.pi / 2)(scope()) == pytest.approx(1.0)
    assert readings.greatest(scope()) == pytest.approx(3.0)
    assert readings.cross_sigma(scope(track=TRACK)) == pytest.approx(1.0)
    assert readings.cross_sigma(scope()) == 0.0


def test_the_bearing_of_home_is_as_sure_as_the_place_across_it_is_for_its_range() -> None:
    north = HERE._replace(north=10.0, east=0.0)
    assert readings.bearing_sigma(scope(north)) == pytest.approx(0.1)
    assert readings.bearing_sigma(scope(north._replace(north=0.0, east=10.0))) == pytest.approx(0.3)
    for nowhere in (None, north._replace(north=0.0), north._replace(north=0.01)):
        assert readings.bearing_sigma(scope(nowhere)) == math.pi


def test_a_course_is_as_sure_as_heading_and_current_and_less_the_slower_it_is() -> None:
    speed = math.hypot(*VELOCITY)
    assert readings.course_sigma(scope()) == pytest.approx(math.hypot(0.1, 0.3 / speed))
    assert readings.course_sigma(scope(HERE._replace(heading=None))) == math.pi
    assert readings.ground_speed_sigma(scope()) == pytest.approx(0.5)


def test_a_share_is_of_the_whole_distribution_about_the_place() -> None:
    assert readings.range_share(scope(), 48.0) == distribution.within(
        48.0, -30.0, -40.0, HERE.covariance
    )
    shared = readings.distance_share(scope(track=TRACK), 19.0)
    ahead = 20.0 * math.cos(TRACK.ahead), 20.0 * math.sin(TRACK.ahead)
    assert shared == distribution.within(19.0, *ahead, HERE.covariance)
    assert 0.0 < shared < 1.0
    for lacking in (scope(), scope(None, track=TRACK), scope(NOWHERE, track=TRACK)):
        assert readings.distance_share(lacking, 19.0) is None
    assert readings.range_share(scope(NOWHERE), 48.0) is None


# --- whether it is believed ---------------------------------------------------------------------------


def at(now: float, report: Telemetry | None, **healths: Health) -> Scope:
    return Scope(
        now, HERE, report, lambda sensor: healths.get(sensor, Health(True, "", 0.0)),
        *(0.0, 0.0, 0.0, 1), lambda: None,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("health", "known"),
    [
        (Health(True, "", 0.0), True),
        (Health(True, "", STALE_AFTER), True),
        (Health(True, "", STALE_AFTER + 0.1), False),
        (Health(False, "frozen", 0.0), False),
    ],
)
def test_a_value_is_known_while_its_sensors_are_healthy_and_fresh(health: Health, known: bool):
    now = at(100.0, Telemetry(99.0), depth=health)
    assert (value_of(VARIABLES["depth"], now) is not None) is known
    shown = reading_of(VARIABLES["depth"], now)
    assert (shown.valid, shown.reason) == (known, "" if known else health.reason or "stale")
    assert shown.age == 1.0


def test_what_is_no_number_is_not_known() -> None:
    row = replace(VARIABLES["depth"], read=lambda scope: math.nan)
    assert value_of(row, at(100.0, Telemetry(99.0))) is None
    assert reading_of(row, at(100.0, Telemetry(99.0))).reason == "missing"


def test_a_clock_is_always_known_and_has_no_age() -> None:
    shown = reading_of(VARIABLES["elapsed"], at(100.0, None))
    assert (shown.value, shown.valid, shown.age) == (100.0, True, 0.0)


@pytest.mark.parametrize(
    ("age", "value"), [(0.0, 7.0), (STALE_AFTER, 7.0), (STALE_AFTER + 0.1, None)]
)
def test_a_reading_of_the_vehicle_file_is_of_the_report_and_goes_stale_with_it(age, value) -> None:
    row = reading_row("metal", Source("metal", "", "of metal", lambda report: 7.0))
    assert (row.name, value_of(row, at(100.0, Telemetry(100.0 - age)))) == ("metal", value)
    assert value_of(row, at(100.0, None)) is None
    assert (
        row_of("metal", {"metal": Source("metal", "", "of metal", lambda report: 7.0)}).name
        == "metal"
    )
    assert row_of("depth", {}) is VARIABLES["depth"]


def test_a_difference_of_directions_is_the_short_way_round() -> None:
    assert difference(VARIABLES["heading"], 0.1, math.tau - 0.1) == pytest.approx(0.2)
    assert difference(VARIABLES["depth"], 7.0, 5.0) == 2.0
