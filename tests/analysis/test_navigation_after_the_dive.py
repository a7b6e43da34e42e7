"""Smoothing, calibration and the two commands, on flights of the simulated vehicle."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from matplotlib.axes import Axes
from simulated_truth import HOME, Flown, fly_plan

from mission.analysis.calibration import Calibrated, CalibrationError, calibrate
from mission.analysis.drawing import draw_calibration
from mission.analysis.lessons import kept, section, untaught
from mission.analysis.smoothing import Track, smooth
from mission.commands.calibrate import calibrate as calibrate_command
from mission.commands.report import report as report_command
from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import Vehicle
from mission.navigation import LocalFrame, Navigation
from mission.onboard.stream.senses import Sensed
from protocol.messages import Fix, Telemetry

VEHICLE = load_vehicle("auv")
OFF = replace(VEHICLE, calibration=replace(VEHICLE.calibration, speed_scale=1.15))


@pytest.fixture(scope="module")
def flown() -> Flown:
    return fly_plan(1, bias_deg=7.0, learning=True)


@pytest.fixture(scope="module")
def track(flown: Flown) -> Track:
    return smooth(flown.items, VEHICLE, HOME)


def errors(places: np.ndarray, track: Track, flown: Flown) -> np.ndarray:
    frame = LocalFrame(HOME)
    truth = [flown.truth[min(round(t), len(flown.truth) - 1)] for t in track.t]
    where = np.array([frame.to_local(p.latitude, p.longitude) for p in truth])
    return np.hypot(*(places - where).T)


@pytest.mark.proof
def test_smoothing_is_nearer_to_the_truth_than_filtering_and_that_than_the_raw(
    track: Track, flown: Flown
) -> None:
    raw, filtered, smoothed = (
        errors(p, track, flown).mean() for p in (track.raw, track.filtered, track.smoothed)
    )
    assert smoothed < 0.8 * filtered < 0.8 * raw


def test_smoothing_is_surer_than_filtering_and_right_to_be(track: Track, flown: Flown) -> None:
    assert (
        np.linalg.det(track.smoothed_covariance) <= 1.001 * np.linalg.det(track.filtered_covariance)
    ).all()
    radius = np.sqrt(5.991 * np.linalg.eigvalsh(track.smoothed_covariance)[:, 1])
    assert (errors(track.smoothed, track, flown) < radius).mean() > 0.85


def test_the_smoother_ends_where_the_filter_ends(track: Track) -> None:
    assert track.smoothed[-1] == pytest.approx(track.filtered[-1], abs=1e-9)


def test_what_is_smoothed_is_what_navigation_estimated(track: Track, flown: Flown) -> None:
    """The tape does not change the filter."""
    nav = Navigation(VEHICLE, HOME)
    for item in sorted(flown.items, key=lambda i: i.t):
        if isinstance(item, Fix):
            nav.fix(item)
        else:
            nav.telemetry(item)
    estimate = nav.estimate(float(track.t[-1]))
    assert estimate is not None
    assert (estimate.north, estimate.east) == pytest.approx(tuple(track.filtered[-1]), abs=1e-9)


def test_a_refused_fix_is_on_the_record(flown: Flown) -> None:
    items: list[Sensed] = list(flown.items)
    wild = next(i for i in items if isinstance(i, Fix) and i.t > 60.0)
    items[items.index(wild)] = replace(wild, latitude=wild.latitude + 1e-4)
    track = smooth(items, VEHICLE, HOME)
    assert [f.t for f in track.fixes if not f.used] == [wild.t]


def test_a_track_without_any_fix_is_refused() -> None:
    with pytest.raises(ValueError, match="no fix"):
        smooth([Telemetry(1.0, depth=1.0)], VEHICLE)


@pytest.mark.proof
def test_calibration_finds_scale_and_bias(flown: Flown) -> None:
    other = fly_plan(2, bias_deg=7.0, learning=True)
    done = calibrate([flown.items, other.items], OFF)
    assert done.vehicle.calibration.speed_scale == pytest.approx(0.98, abs=0.06)
    assert math.degrees(done.vehicle.compass_bias) == pytest.approx(7.0, abs=3.0)
    assert math.degrees(done.vehicle.sensors.heading) == pytest.approx(1.0, abs=0.3)
    assert done.vehicle.sensors.depth == pytest.approx(0.07, abs=0.02)
    assert done.vehicle.sensors.fix == pytest.approx(2.5, abs=0.5)
    assert done.held_out


@pytest.mark.proof
def test_calibration_pays_on_a_dive_that_it_has_not_seen(flown: Flown) -> None:
    """One fix before the dive: nothing is learned on the way but the current."""
    done = calibrate([flown.items, fly_plan(2, bias_deg=7.0, learning=True).items], OFF)
    before, after = 0.0, 0.0
    for seed in range(3, 5):
        unseen = fly_plan(seed, bias_deg=7.0, learning=False)
        one, two = (smooth(unseen.items, v, HOME) for v in (OFF, done.vehicle))
        under = (one.t > 30.0) & (one.t < one.t[-1] - 40.0)
        before += float(errors(one.filtered, one, unseen)[under].max())
        after += float(errors(two.filtered, two, unseen)[under].max())
    assert after < 0.7 * before


@pytest.mark.proof
def test_the_section_is_read_back_as_it_was_meant(flown: Flown, tmp_path: Path) -> None:
    done = calibrate([flown.items], OFF)
    base = yaml.safe_load((missions_folder() / "vehicles" / "auv.yaml").read_text())
    file = tmp_path / "auv2.yaml"
    file.write_text(yaml.safe_dump(base | yaml.safe_load(section(done.vehicle))))
    read = load_vehicle(file)
    assert read.calibration.speed_scale == pytest.approx(done.vehicle.calibration.speed_scale, 1e-3)
    assert read.compass_bias == pytest.approx(done.vehicle.compass_bias, abs=1e-3)
    assert read.calibration.deviation.sin1 == pytest.approx(
        done.vehicle.calibration.deviation.sin1, abs=1e-3
    )
    assert read.sensors.heading_bias == pytest.approx(done.vehicle.sensors.heading_bias, abs=1e-3)


def told(vehicle: Vehicle) -> tuple[object, ...]:
    """What calibration fits, and how sure it is of it."""
    c = vehicle.calibration
    bias = vehicle.compass_bias, vehicle.sensors.heading_bias
    return (c.speed_scale, c.speed_scale_sigma), bias, (c.deviation, c.deviation_sigma)


@pytest.mark.proof
def test_what_the_logs_do_not_teach_stays_as_the_vehicle_file_has_it() -> None:
    """One fix, a dive, and a fix: nothing tells a current from a bias or a wrong speed."""
    done = calibrate([fly_plan(3, bias_deg=7.0, learning=False).items], VEHICLE)
    assert told(done.vehicle) == told(VEHICLE)
    lines = untaught(done)
    named = ("speed_scale", "bias", "deviation", "current", "motion", "surface_drift", "float test")
    assert [next(n for n in named if n in line) for line in lines] == [*named]
    assert all("kept as it was; to teach it" in line for line in lines)


@pytest.mark.proof
def test_no_figure_is_less_known_by_logs_that_agree_with_the_vehicle_file(flown: Flown) -> None:
    sure = replace(
        VEHICLE,
        compass_bias=math.radians(7.0),
        sensors=replace(VEHICLE.sensors, heading_bias=math.radians(2.0)),
    )
    done = calibrate([flown.items], sure)
    assert told(done.vehicle)[1] == told(sure)[1]
    # one day says nothing of another day's current or wind, two minutes nothing of a speed that is
    # kept for minutes
    assert kept(done) == {"heading_bias", "deviation", "current", "motion", "surface_drift"}
    assert done.vehicle.calibration.surface_drift == VEHICLE.calibration.surface_drift
    assert done.vehicle.calibration.speed_noise == VEHICLE.calibration.speed_noise
    assert done.vehicle.calibration.speed_scale_sigma < VEHICLE.calibration.speed_scale_sigma
    assert done.vehicle.calibration.deviation_sigma == VEHICLE.calibration.deviation_sigma


@pytest.mark.proof
def test_calibrating_again_with_the_same_logs_makes_nothing_surer(flown: Flown) -> None:
    once = calibrate([flown.items], OFF).vehicle
    again = calibrate([flown.items], once).vehicle
    assert again.calibration.speed_scale_sigma > 0.9 * once.calibration.speed_scale_sigma
    assert again.sensors.heading_bias > 0.9 * once.sensors.heading_bias
    assert again.calibration.speed_scale == pytest.approx(once.calibration.speed_scale, rel=0.02)


@pytest.mark.proof
def test_logs_that_contradict_a_sure_vehicle_file_are_believed(flown: Flown) -> None:
    wrong = replace(
        VEHICLE,
        compass_bias=math.radians(-18.0),  # set anew, by 25 deg
        sensors=replace(VEHICLE.sensors, heading_bias=math.radians(1.0)),
    )
    done = calibrate([flown.items], wrong)
    assert "heading_bias" not in kept(done)
    assert math.degrees(done.vehicle.compass_bias) == pytest.approx(7.0, abs=5.0)
    assert done.vehicle.sensors.heading_bias > math.radians(1.0)


def test_a_log_too_short_for_a_noise_figure_leaves_it_and_says_so(flown: Flown) -> None:
    brief = [i for i in flown.items if i.t < 40.0 and not (isinstance(i, Fix) and i.t > 20.0)]
    done = calibrate([brief], VEHICLE)
    assert {"depth", "heading", "fix"} <= set(done.unheard)
    assert done.vehicle.sensors.depth == VEHICLE.sensors.depth
    assert done.vehicle.sensors.fix == VEHICLE.sensors.fix
    assert any("noise of fix" in line and "every second" in line for line in untaught(done))
    assert f"depth: {VEHICLE.sensors.depth:.3f} m   # as it was" in section(
        done.vehicle, kept(done)
    )


def test_logs_without_fixes_cannot_calibrate() -> None:
    with pytest.raises(CalibrationError, match="two fixes"):
        calibrate([[Telemetry(1.0, depth=1.0)]], VEHICLE)


@pytest.fixture(scope="module")
def box(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A black box of a short simulated mission."""
    from mission.authoring.language import parse
    from mission.onboard.blackbox import BlackBox
    from mission.verification.simulation.flight import fly

    mission = parse(
        "mission short vehicle auv\nhome 30.2874595 120.1535765\nsafety radius 500 time 20min\n"
        "a: heading 90 ZAF6 until elapsed > 40s timeout 60s\n"
        "b: heading 0 ZAF6 depth 4 until elapsed > 80s timeout 90s\n"
        "up: surface timeout 3min\n"
    )
    path = tmp_path_factory.mktemp("box") / "flight.mcap"
    recorder = BlackBox(path)
    fly(mission, VEHICLE, "as-built", 3, None, recorder)
    recorder.close()
    return path


@pytest.mark.proof
def test_report_draws_and_tells(box: Path, tmp_path: Path) -> None:
    picture = tmp_path / "track.png"
    result = CliRunner().invoke(report_command, [str(box), "-o", str(picture), "--json"])
    assert result.exit_code == 0, result.output
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert json.loads(result.stdout)["fixes"] > 10


def test_report_of_something_else_says_so(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    file.write_bytes(b"nothing")
    result = CliRunner().invoke(report_command, [str(file)])
    assert result.exit_code == 2
    assert "x.mcap" in result.output


@pytest.mark.proof
def test_a_picture_or_section_that_cannot_be_written_is_told(box: Path, tmp_path: Path) -> None:
    nowhere = tmp_path / "absent" / "x.png"
    for command, option in (
        (report_command, "-o"),
        (calibrate_command, "-o"),
        (calibrate_command, "--plot"),
    ):
        result = CliRunner().invoke(command, [str(box), option, str(nowhere)])
        assert result.exit_code == 2
        assert f"{nowhere}: cannot be written: No such file or directory" in result.stderr


@pytest.mark.proof
def test_calibrate_prints_a_section_and_draws(box: Path, tmp_path: Path) -> None:
    picture = tmp_path / "cal.png"
    result = CliRunner().invoke(calibrate_command, [str(box), "--plot", str(picture)])
    assert result.exit_code == 0, result.output
    assert "speed_scale" in yaml.safe_load(result.stdout)["calibration"]
    assert picture.exists()


def test_a_picture_of_logs_without_a_dive_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    told: list[str] = []
    monkeypatch.setattr(Axes, "text", lambda _self, _x, _y, words, **_: told.append(words))
    none = Calibrated(VEHICLE, (0.1, 0.1, 0.1, 0.1), (), False, (), (), None)
    draw_calibration(none, tmp_path / "cal.png")
    assert told == ["no dive between two fixes"]


def test_calibrate_tells_what_it_kept_and_when_the_error_has_grown(
    box: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Calibrated, "percent", lambda _: (11.1, 12.6))
    result = CliRunner().invoke(calibrate_command, [str(box)])
    assert result.exit_code == 0
    assert "keep the old figures" in result.stderr
    assert "too little about deviation" in result.stderr
    assert "# as it was" in result.stdout
    deviation = yaml.safe_load(result.stdout)["calibration"]["deviation_sigma"]
    assert deviation == f"{math.degrees(VEHICLE.calibration.deviation_sigma):.2f} deg"


def test_a_plan_is_the_same_for_the_same_seed() -> None:
    from simulated_truth import plan

    assert plan(Random(3), learning=True) == plan(Random(3), learning=True)
