"""Recordings: what is read, what others teach, and the figures on the real ones where present."""

from __future__ import annotations

import json
import math
import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from mission.analysis.calibration import Calibrated
from mission.analysis.recordings import RecordingError, read, wire
from mission.analysis.scores import as_object
from mission.analysis.scoring import score_folder
from mission.analysis.teaching import calibrate_by
from mission.commands.calibrate import calibrate as calibrate_command
from mission.commands.score import score as command
from mission.model import Position
from mission.model.shipped import load_vehicle
from mission.navigation import LocalFrame
from protocol.messages import Fix, Telemetry

pytestmark = pytest.mark.proof  # long: make proofs

HOME = Position(32.85, 34.89)
AUV = load_vehicle("auv")
TRUE = replace(  # the runs' headings are true, and they neither slip nor slow down in turns
    AUV,
    declination=0.0,
    calibration=replace(AUV.calibration, turn_slip=0.0, turn_loss=0.0),
)


def write_run(path: Path, speed: float, current: tuple[float, float], seed: int) -> None:
    """A run of 300 s as the real ones are written: legs with a turn, level at 10 m."""
    rng, frame, n, e, heading = random.Random(seed), LocalFrame(HOME), 0.0, 0.0, 0.0
    rows = ["t,lat,lon,depth,roll_deg,pitch_deg,heading_deg,vn,ve,vd,dvl_x,dvl_y,dvl_z"]
    for t in range(301):
        lat, lon = (math.degrees(a) for a in frame.to_geodetic(n, e))
        depth = 10.0 + rng.gauss(0.0, 0.05)
        compass = (math.degrees(heading) + rng.gauss(0.0, 0.1)) % 360  # exact, it would be frozen
        rows.append(f"{t},{lat:.8f},{lon:.8f},{depth:.3f},0.1,0.2,{compass:.3f},0,0,0,0,0,0")
        heading += 0.05 if t % 60 < 20 else 0.0
        n += speed * math.cos(heading) + current[0]
        e += speed * math.sin(heading) + current[1]
    path.write_text("\n".join(rows) + "\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("runs")
    for i, (speed, current) in enumerate(
        [(1.9, (0.1, 0.1)), (2.0, (0.15, 0.05)), (2.1, (0.05, 0.1))]
    ):
        write_run(found / f"run_{i}.csv", speed, current, i)
    (found / "notes.csv").write_text("a,b\n1,2\n")
    return found


def test_what_is_no_recording_is_told_and_left_out(folder: Path) -> None:
    with pytest.raises(RecordingError, match="heading_deg"):
        read(folder / "notes.csv")
    scores, refused = score_folder(folder, load_vehicle("auv"))
    assert len(scores) == 3 * 4
    assert len(refused) == 1
    assert "notes.csv" in refused[0]


def test_the_bytes_bring_back_what_was_recorded(folder: Path) -> None:
    run = read(folder / "run_0.csv")
    items = wire(run, [0, 1, 2], run.heading, 1500)
    reports = [i for i in items if isinstance(i, Telemetry)]
    fixes = [i for i in items if isinstance(i, Fix)]
    assert len(reports) == 151
    assert len(fixes) == 3
    assert fixes[0].latitude == pytest.approx(math.radians(HOME.latitude_deg), abs=1e-7)
    assert reports[20].heading == pytest.approx(run.heading[40], abs=1e-5)
    assert reports[20].depth == pytest.approx(run.depth[40], abs=1e-3)


def taken(done: Calibrated) -> set[str]:
    return {o.figure.name for o in done.lessons if o.taken}


def test_the_others_teach_speed_and_current(folder: Path) -> None:
    done = calibrate_by([read(folder / f"run_{i}.csv") for i in (1, 2)], TRUE)
    known = done.vehicle.calibration
    assert {"speed_scale", "current"} <= taken(done)
    assert known.speed_scale == pytest.approx(2.05, abs=0.04)  # gear 8 is 1 m/s in the file
    assert known.current[0] == pytest.approx(0.1 * 2 / 3, abs=0.03)  # two are few: shrunk


def test_the_current_is_that_of_the_last_logs_waters(folder: Path) -> None:
    runs = [read(folder / f"run_{i}.csv") for i in range(3)]
    away = replace(runs[0], origin=Position(40.0, 10.0))
    done = calibrate_by([*runs[1:], away], TRUE)
    assert "current" not in taken(done)
    assert done.vehicle.calibration.current == (0.0, 0.0)
    assert "current" in taken(calibrate_by([away, *runs[1:]], TRUE))


def test_a_log_that_stands_apart_is_named_and_changes_nothing(tmp_path: Path) -> None:
    for i in range(5):
        write_run(tmp_path / f"run_{i}.csv", 1.9 + 0.02 * i, (0.1, 0.05), i)
    write_run(tmp_path / "towed.csv", 3.5, (0.1, 0.05), 9)
    runs = [read(file) for file in sorted(tmp_path.glob("*.csv"))]
    done, without = calibrate_by(runs, TRUE), calibrate_by(runs[:-1], TRUE)
    assert (5, "speed_scale") in done.apart
    assert not without.apart
    one, other = done.vehicle.calibration, without.vehicle.calibration
    assert one.speed_scale == pytest.approx(other.speed_scale, rel=0.02)
    assert one.speed_scale_sigma == pytest.approx(other.speed_scale_sigma, rel=0.3)


def test_a_copy_of_a_log_makes_nothing_surer(folder: Path) -> None:
    runs = [read(folder / f"run_{i}.csv") for i in range(3)]
    once, twice = calibrate_by(runs, TRUE), calibrate_by([*runs, runs[1], runs[2]], TRUE)
    assert twice.copies == ((3, 1), (4, 2))
    assert twice.vehicle == once.vehicle


def test_a_run_is_cut_where_it_comes_up_or_drifts(tmp_path: Path) -> None:
    """100 s of drifting after 200 s of swimming teach neither speed nor noise."""
    write_run(tmp_path / "whole.csv", 2.0, (0.1, 0.0), 1)
    rows = (tmp_path / "whole.csv").read_text().splitlines()
    last = rows[200].split(",")
    for depth, name in (("0.1", "up.csv"), ("10.0", "adrift.csv")):
        late = [",".join([str(t), *last[1:3], depth, *last[4:]]) for t in range(200, 300)]
        (tmp_path / name).write_text("\n".join([*rows[:201], *late]) + "\n")
        cut = read(tmp_path / name)
        assert cut.adrift == pytest.approx(100, abs=8)
        assert cut.t[-1] == pytest.approx(200.0, abs=8.0)
    _, told = score_folder(tmp_path, load_vehicle("auv"))
    assert [t.split(": ")[1].split()[1:4] for t in told] == [["rows", "at", "the"]] * 2


def test_what_cannot_be_used_is_told_and_costs_the_others_nothing(tmp_path: Path) -> None:
    for i in range(2):
        write_run(tmp_path / f"run_{i}.csv", 1.9 + 0.1 * i, (0.1, 0.0), i)
    whole = (tmp_path / "run_0.csv").read_text().splitlines(keepends=True)
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "cut.csv").write_text("".join(whole[:12]))
    (tmp_path / "gap.csv").write_text("".join(whole[:100] + whole[180:]))
    (tmp_path / "header.csv").write_text(whole[0])
    (tmp_path / "short.csv").write_text("".join(whole[:50]))
    bad = [*whole[:40], "x,,,nan\n", *whole[40:60], "59.5,232.1,34.9,1,1,1,1\n", *whole[60:]]
    (tmp_path / "bad.csv").write_text("".join(bad))
    scores, refused = score_folder(tmp_path, load_vehicle("auv"))
    told = dict(text.removeprefix(f"{tmp_path}/").split(": ", 1) for text in refused)
    assert set(told) == {"bytes.csv", "cut.csv", "header.csv", "bad.csv"}
    assert "10 s" in told["cut.csv"]
    assert told["bad.csv"].startswith("2 rows")
    assert {s.file for s in scores} == {"run_0.csv", "run_1.csv", "gap.csv", "short.csv", "bad.csv"}
    figures = [v for s in scores for v in (s.end_pct, s.ellipse_pct, s.reference_pct)]
    assert all(v is not None and math.isfinite(v) for v in figures)


def test_calibrate_takes_recordings_and_says_how_sure_it_is(folder: Path, tmp_path: Path) -> None:
    files = [str(folder / f"run_{i}.csv") for i in range(3)]
    result = CliRunner().invoke(calibrate_command, [*files, "--vehicle", "auv"])
    assert result.exit_code == 0, result.output
    assert "current: one sigma 0." in result.stderr
    assert "# near 32.85, 34.89 alone" in result.stdout
    unsaid = CliRunner().invoke(calibrate_command, files)
    assert unsaid.exit_code == 2
    assert "add --vehicle" in unsaid.output
    mixed = CliRunner().invoke(calibrate_command, [*files, str(tmp_path / "a.mcap")])
    assert mixed.exit_code == 2
    assert "give one kind" in mixed.output


def test_an_empty_folder_is_told(tmp_path: Path) -> None:
    result = CliRunner().invoke(command, [str(tmp_path)])
    assert result.exit_code == 2
    assert "no recording" in result.stderr
    assert json.loads(result.stdout)["runs"] == []


def test_the_spread_of_currents_leaves_out_what_each_fit_errs_by(tmp_path: Path) -> None:
    """The same current every day: it is known to the least that is believed, not to the fits'."""
    for i in range(4):
        write_run(tmp_path / f"run_{i}.csv", 1.9 + 0.05 * i, (0.15, 0.05), i)
    done = calibrate_by([read(file) for file in sorted(tmp_path.glob("*.csv"))], TRUE).vehicle
    assert done.calibration.current_sigma == pytest.approx(0.05, abs=0.02)
    assert done.sensors.heading_bias == pytest.approx(math.radians(1.0), abs=math.radians(0.3))


def test_a_run_alone_is_scored_without_a_reference(tmp_path: Path) -> None:
    write_run(tmp_path / "alone.csv", 1.7, (0.0, 0.1), 4)
    scores, _ = score_folder(tmp_path, load_vehicle("auv"))
    assert {s.reference_pct for s in scores} == {None}
    assert all(math.isfinite(s.end_pct) for s in scores)


def test_the_command_prints_one_object_last(folder: Path) -> None:
    result = CliRunner().invoke(command, [str(folder)])
    assert result.exit_code == 0
    found = json.loads(result.stdout.strip().splitlines()[-1])
    assert {"file", "scoring", "end_pct", "median_pct", "coverage", "reference_pct"} <= set(
        found["runs"][0]
    )


def test_a_state_that_is_not_there_is_refused(folder: Path) -> None:
    result = CliRunner().invoke(command, [str(folder), "--without", "luck"])
    assert result.exit_code == 2
    assert "waters" in result.output


@pytest.mark.minutes
def test_every_reference_is_met_and_the_ellipses_hold(recordings: Path) -> None:
    scores, _ = score_folder(recordings / "trajectories", load_vehicle("auv"))
    found = as_object(scores)
    rows = found["summary"]
    assert isinstance(rows, list)
    for row in rows:
        assert row["end_pct"] <= row["reference_pct"], row
        assert row["coverage"] >= 0.85, row
        assert row["nees"] <= 3.0, row
    assert isinstance(found["coverage"], float)
    assert found["coverage"] >= 0.85
    assert isinstance(found["ellipse_pct"], float)
    assert found["ellipse_pct"] < 20.0
    for s in scores:
        assert all(s.end_pct <= v for v in s.references.values()), s
    assert np.isfinite([s.median_pct for s in scores]).all()
