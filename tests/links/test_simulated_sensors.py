"""Sensors, GPS and the globe under the simulated vehicle."""

from __future__ import annotations

import itertools
import re
import statistics
from dataclasses import replace
from datetime import UTC, datetime
from functools import reduce
from math import cos, degrees, hypot, nan, pi, radians, sin
from random import Random

import pytest
from geographiclib.geodesic import Geodesic

from links.base import Rx
from links.simulated.firmware.gps import GpsReceiver
from links.simulated.geodesy import local, moved
from links.simulated.link import HOME, SimulatedVehicle
from links.simulated.plant import Plant
from links.simulated.sea import Sea
from links.simulated.sensors import Health, Sensor, SensorErrors, Sensors, normals
from links.simulated.settings import Settings

QUIET = replace(
    SensorErrors(), compass_bias=0.0, compass_noise=0.0, compass_slow=0.0, deviation=0.0
)


def samples(
    errors: SensorErrors,
    n: int = 2000,
    *,
    repeats: bool = False,
    depth: float = 10.0,
    floor: float = 30.0,
    yaw: float = 0.0,
) -> list[list[float]]:
    plant = Plant(floor=floor)
    plant.depth, plant.yaw = depth, yaw
    sensors = Sensors(errors, Random(1), repeats_when_silent=repeats)
    return [sensors.sample(plant) for _ in range(n)]


def test_noise_is_drawn_as_the_generator_draws_it() -> None:
    ours, its_own = Random(5), Random(5)
    for count in (1, 15, 4, 2, 15, 1, 0, 3):
        assert normals(ours, count) == [its_own.gauss() for _ in range(count)]
        assert ours.getstate() == its_own.getstate()
        assert ours.random() == its_own.random()  # whoever draws in between


def test_depth_noise_and_bias_are_those_that_were_set() -> None:
    depths = [s[4] for s in samples(replace(QUIET, depth_bias=0.3, depth_noise=0.05))]
    assert statistics.fmean(depths) == pytest.approx(10.3, abs=0.01)
    assert statistics.stdev(depths) == pytest.approx(0.05, rel=0.1)


def test_the_compass_reads_magnetic_north_plus_its_bias() -> None:
    errors = replace(QUIET, declination=radians(-6.0), compass_bias=radians(2.0))
    assert degrees(samples(errors, 1, yaw=1.0)[0][2]) == pytest.approx(degrees(1.0) + 6.0 + 2.0)


def test_the_place_gives_the_declination_unless_the_settings_do() -> None:
    for stated, expected in ((None, radians(4.0)), (radians(-9.0), radians(-9.0))):
        errors = replace(QUIET, declination=stated)
        vehicle = SimulatedVehicle(settings=Settings(errors=errors), declination=radians(4.0))
        read = vehicle.sensors.sample(vehicle.plant)[2]
        assert (-read) % (2 * pi) == pytest.approx(expected % (2 * pi))


def test_the_deviation_depends_on_the_heading() -> None:
    errors = replace(QUIET, deviation=radians(3.0))
    read = [degrees(samples(errors, 1, yaw=radians(h))[0][2]) - h for h in (90, 180, 270)]
    assert read == pytest.approx([3.0 - 1.5, 1.5, -3.0 - 1.5])


def test_the_slow_compass_error_stays_for_minutes_and_wanders_over_hours() -> None:
    errors = replace(QUIET, compass_slow=radians(1.0))
    headings = [(degrees(s[2]) + 180) % 360 - 180 for s in samples(errors, 20000)]
    steps = [b - a for a, b in itertools.pairwise(headings)]
    assert statistics.stdev(headings) == pytest.approx(1.0, rel=0.3)
    assert statistics.stdev(steps) < 0.15


@pytest.mark.parametrize("repeats", [True, False])
def test_beyond_its_range_the_altimeter_is_silent(repeats: bool) -> None:
    heard = [
        s[5] for s in samples(replace(QUIET, altitude_drop=0.0), 5, floor=200.0, repeats=repeats)
    ]
    assert heard == [0.0] * 5 if repeats else all(value != value for value in heard)


def test_the_altimeter_drops_its_share_of_echoes() -> None:
    heard = [s[5] for s in samples(replace(QUIET, altitude_drop=0.25))]
    assert sum(value != value for value in heard) / len(heard) == pytest.approx(0.25, abs=0.03)
    echoes = [value for value in heard if value == value]
    assert statistics.fmean(echoes) == pytest.approx(20.0, abs=0.01)


def test_magnetometers_turn_with_the_vehicle() -> None:
    north, east = samples(QUIET, 1, yaw=0.0)[0][6:9], samples(QUIET, 1, yaw=radians(90))[0][6:9]
    assert north == pytest.approx([33e-6, 0.0, 35e-6], abs=1e-6)
    assert east == pytest.approx([0.0, -33e-6, 35e-6], abs=1e-6)


@pytest.mark.parametrize("sensor", Sensor)
@pytest.mark.parametrize("repeats", [True, False], ids=["as-built", "documented"])
def test_a_sick_sensor_is_frozen_silent_or_absurd(sensor: Sensor, repeats: bool) -> None:
    plant = Plant(floor=40.0)
    plant.depth = 10.0
    errors = replace(SensorErrors(), altitude_drop=0.0)
    sensors = Sensors(errors, Random(1), repeats_when_silent=repeats)
    before = [sensors.sample(plant)[slot] for slot in sensor.value]
    sensors.health[sensor] = Health.FROZEN
    before = [sensors.last[slot] for slot in sensor.value]
    plant.depth = 20.0
    assert [sensors.sample(plant)[slot] for slot in sensor.value] == before
    sensors.health[sensor] = Health.SILENT
    silent = [sensors.sample(plant)[slot] for slot in sensor.value]
    assert silent == before if repeats else all(value != value for value in silent)
    sensors.health[sensor] = Health.ABSURD
    absurd = [[sensors.sample(plant)[slot] for slot in sensor.value] for _ in range(20)]
    assert len({tuple(values) for values in absurd}) == 20
    del sensors.health[sensor]
    healthy = sensors.sample(plant)
    assert all(value == value for value in healthy)


def test_the_control_loop_sees_a_frozen_sensor_frozen() -> None:
    plant = Plant()
    sensors = Sensors(QUIET, Random(1), repeats_when_silent=True)
    sensors.sample(plant)
    sensors.health[Sensor.DEPTH] = sensors.health[Sensor.HEADING] = Health.FROZEN
    depth, heading = sensors.depth(plant), sensors.heading(plant)
    plant.depth, plant.yaw = 12.0, 2.0
    assert (sensors.depth(plant), sensors.heading(plant)) == (depth, heading)
    sensors.health.clear()
    assert sensors.depth(plant) > 11.0


def test_temperature_falls_with_depth() -> None:
    assert samples(QUIET, 1, depth=0.0)[0][3] > samples(QUIET, 1, depth=20.0)[0][3] + 0.8


# --- the globe --------------------------------------------------------------------------------


@pytest.mark.parametrize("latitude", [-55.0, 0.0, 30.3, 70.0])
def test_the_globe_agrees_with_geographiclib(latitude: float) -> None:
    """An independent library; the engine's own projection is not asked."""
    geodesic = Geodesic.WGS84
    start = radians(latitude), radians(120.0)
    position = start
    for _ in range(1000):
        position = moved(*position, 0.7, -0.4)
    found = geodesic.Inverse(latitude, 120.0, degrees(position[0]), degrees(position[1]))
    assert found["s12"] == pytest.approx(hypot(700, 400), rel=1e-4)
    north, east = local(start, *position)
    azimuth = radians(found["azi1"])
    assert north == pytest.approx(found["s12"] * cos(azimuth), abs=0.01)
    assert east == pytest.approx(found["s12"] * sin(azimuth), abs=0.01)


# --- GPS --------------------------------------------------------------------------------------

START = datetime(2025, 12, 31, 23, 59, 50, tzinfo=UTC)


def listen(
    seconds: float, settings: Settings | None = None, *, depth: float | None = None
) -> tuple[SimulatedVehicle, list[Rx]]:
    vehicle = SimulatedVehicle("as-built", 4, settings, start=START)
    if depth is not None:
        vehicle.plant.depth = depth
    return vehicle, vehicle.gps_link.receive(seconds)


def sentences(received: list[Rx]) -> list[str]:
    return [line for rx in received for line in rx.data.decode("ascii").splitlines()]


def test_every_sentence_has_a_right_checksum() -> None:
    _, received = listen(60.0)
    lines = sentences(received)
    assert len(lines) == 118
    for line in lines:
        body, stated = line[1:].split("*")
        assert int(stated, 16) == reduce(lambda a, b: a ^ b, body.encode())


def test_one_gga_and_one_rmc_a_second_with_the_wall_clock_over_midnight() -> None:
    _, received = listen(20.5)
    assert [rx.t for rx in received] == pytest.approx([n + 0.1 for n in range(1, 21)])
    lines = sentences(received)
    assert [line[3:6] for line in lines] == ["GGA", "RMC"] * 20
    assert lines[17].startswith("$GPRMC,235959.00,A,")
    assert lines[19].startswith("$GPRMC,000000.00,A,")
    assert ",311225,,,A*" in lines[17]
    assert ",010126,,,A*" in lines[19]


def test_no_fix_before_its_time_and_none_under_water() -> None:
    _, received = listen(10.5)
    states = [line.split(",")[2] for line in sentences(received) if "RMC" in line]
    assert states == ["V"] * 2 + ["A"] * 8
    _, received = listen(10.5, depth=15.0)
    assert {line.split(",")[2] for line in sentences(received) if "RMC" in line} == {"V"}
    assert all(
        re.fullmatch(r"\$GPGGA,\d{6}\.00,,,,,0,00,,,M,0\.0,M,,\*..", line)
        for line in sentences(received)
        if "GGA" in line
    )


def test_a_receiver_set_to_one_sentence_says_no_other_at_the_same_times() -> None:
    _, both = listen(10.5)
    _, one = listen(10.5, settings=Settings(sentences=("GGA",)))
    assert sentences(one) == [line for line in sentences(both) if "GGA" in line]
    assert [rx.t for rx in one] == [rx.t for rx in both]


def test_a_fix_comes_back_some_seconds_after_surfacing() -> None:
    vehicle, _ = listen(10.5)
    vehicle.plant.depth = 3.0
    states: list[tuple[float, str, float]] = []
    for second in range(11, 60):
        (rx,) = vehicle.gps_link.receive(second + 0.5)
        states.append((second, sentences([rx])[1].split(",")[2], vehicle.truth().depth))
    surfaced = next(t for t, _, depth in states if depth < 0.3)
    fixed = next(t for t, state, _ in states if state == "A")
    assert 3.0 <= fixed - surfaced <= 10.0


def degrees_of(line: str) -> tuple[float, float]:
    fields = line.split(",")
    return (
        float(fields[2][:2]) + float(fields[2][2:]) / 60,
        float(fields[4][:3]) + float(fields[4][3:]) / 60,
    )


def test_fixes_scatter_about_the_truth_by_the_stated_noise() -> None:
    vehicle, received = listen(1500.0, Settings(Sea(current=(0.3, radians(60.0)))))
    norths, easts = [], []
    truth = {round(point.t): point for point in vehicle.track}
    for rx in received:
        line = sentences([rx])[0]
        if line.split(",")[6] == "1":
            latitude, longitude = degrees_of(line)
            point = truth[round(rx.t - 0.1)]
            north, east = local(
                (point.latitude, point.longitude), radians(latitude), radians(longitude)
            )
            norths.append(north)
            easts.append(east)
    for errors in (norths, easts):
        assert statistics.fmean(errors) == pytest.approx(0.0, abs=0.25)
        assert statistics.stdev(errors) == pytest.approx(2.5, rel=0.1)


def test_what_wanders_stays_for_minutes_and_does_not_average_out() -> None:
    """Gauss and Markov, 100 s: neighbours err alike, and means over 20 s scatter as one fix does."""
    errors = SensorErrors(fix_noise=0.0, fix_wander=3.0)
    means = []
    for seed in range(60):
        receiver = GpsReceiver(errors, Random(seed), datetime(2026, 6, 1, tzinfo=UTC))
        beside = []
        for t in range(4, 24):
            receiver.report(float(t), 0.0, HOME, (0.0, 0.0))
            gga = receiver.take(t + 0.5)[-1].data.decode().splitlines()[0]
            beside.append(local(HOME, *map(radians, degrees_of(gga)))[0])
        assert max(abs(b - a) for a, b in itertools.pairwise(beside)) < 2.0
        means.append(statistics.fmean(beside))
    assert 2.2 < statistics.pstdev(means) < 3.8


def test_the_first_fix_behind_a_dive_is_off_and_says_so_until_it_has_settled() -> None:
    errors = SensorErrors(fix_noise=0.0, fix_settle=20.0)
    receiver = GpsReceiver(errors, Random(3), datetime(2026, 6, 1, tzinfo=UTC))
    told: list[tuple[float, float, int]] = []
    for t in range(1, 120):
        receiver.report(float(t), 5.0 if 20 <= t < 60 else 0.0, HOME, (0.0, 0.0))
        gga = receiver.take(t + 0.5)[-1].data.decode().splitlines()[0]
        if gga.split(",")[6] == "1":
            off = hypot(*local(HOME, *map(radians, degrees_of(gga))))
            told.append((off, float(gga.split(",")[8]), int(gga.split(",")[7])))
    before, behind = told[:16], told[17:]
    assert all(off < 0.01 and (hdop, of) == (1.0, 9) for off, hdop, of in before)
    assert behind[0][0] > 5.0
    assert behind[0][1] > 2.0
    assert behind[0][2] < 7
    assert all(b[0] < a[0] for a, b in itertools.pairwise(behind[:10]))
    assert behind[-1][0] < 0.1
    assert behind[-1][1:] == (1.0, 9)


def test_speed_and_course_are_over_ground() -> None:
    quiet = replace(SensorErrors(), speed_noise=0.0)
    _, received = listen(30.0, Settings(Sea(current=(0.5, radians(300.0))), errors=quiet))
    fields = sentences(received)[-1].split(",")
    assert float(fields[7]) * 1852 / 3600 == pytest.approx(0.5, abs=1e-3)
    assert float(fields[8]) == pytest.approx(300.0, abs=0.01)


def test_truth_moves_on_the_globe_as_the_plant_does() -> None:
    vehicle, _ = listen(1000.3, Settings(Sea(current=(0.3, radians(45.0)))))
    truth = vehicle.truth()
    assert truth.local == pytest.approx((212.2, 212.2), abs=0.1)
    assert truth.origin == HOME
    assert truth.ground_speed == pytest.approx(0.3)
    assert truth.at_surface
    assert nan != truth.altitude
    assert len(vehicle.track) == 1001


def test_a_current_at_the_floor_shears() -> None:
    sea = Sea(current=(0.4, 0.0), deep_current=(0.2, 0.0), floor=40.0)
    vehicle = SimulatedVehicle("as-built", 1, Settings(sea))
    vehicle.plant.depth = 20.0
    vehicle.advance(0.2)
    assert vehicle.truth().current[0] == pytest.approx(0.3, abs=0.01)
