"""Recordings as others may write them: other spellings, other seas, wild rows, what is missing."""

from __future__ import annotations

import csv
import json
import math
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.analysis import scoring
from mission.analysis.missed import trust
from mission.analysis.recordings import RecordingError, read
from mission.analysis.scores import Score, as_object
from mission.analysis.scoring import glider_vehicle, score_folder
from mission.analysis.teaching import calibrate_by
from mission.commands.score import score as command
from mission.model import Position
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from mission.navigation import LocalFrame

Rows = list[dict[str, str]]
HOME = Position(32.85, 34.89)
VEHICLE = load_vehicle("auv")


def run(seed: int, home: Position = HOME, seconds: int = 240) -> Rows:
    """Legs with a turn at 10 m."""
    rng, frame, n, e, heading = random.Random(seed), LocalFrame(home), 0.0, 0.0, 0.0
    speed, rows = 1.9 + 0.1 * seed, []
    for t in range(seconds + 1):
        lat, lon = (math.degrees(a) for a in frame.to_geodetic(n, e))
        compass = (math.degrees(heading) + rng.gauss(0.0, 0.1)) % 360.0
        rows.append(
            {
                "t": f"{t}",
                "lat": f"{lat:.8f}",
                "lon": f"{lon:.8f}",
                "depth": f"{10.0 + rng.gauss(0.0, 0.05):.3f}",
                "roll_deg": "0.1",
                "pitch_deg": "0.2",
                "heading_deg": f"{compass:.3f}",
            }
        )
        heading += 0.05 if t % 60 < 20 else 0.0
        n += speed * math.cos(heading) + 0.1
        e += speed * math.sin(heading) + 0.02 * seed
    return rows


def glider(home: Position, declination: float, begin: float = 1695220914.0, dives: int = 3) -> Rows:
    """Dives of half an hour; the compass says what it would there (deg)."""
    frame, rows, n, e, heading, t = LocalFrame(home), list[dict[str, str]](), 0.0, 0.0, 0.7, begin
    for dive in range(dives + 1):
        for step in range(12 if dive == dives else 192):
            up, depth, speed = step < 12, 0.05, 0.0
            if not up:
                rises = (step // 30) % 2 or step >= 168  # to the surface at its end
                pitch = 26.0 if rises else -26.0
                depth = max(float(rows[-1]["depth_m"]) - math.copysign(1.8, pitch), 0.6)
                speed = 0.18 / math.tan(math.radians(29.0))
            lat, lon = (math.degrees(a) for a in frame.to_geodetic(n, e))
            rows.append(
                {
                    "unix_s": f"{t:.1f}",
                    "depth_m": f"{depth:.3f}",
                    "heading_mag_deg": f"{(math.degrees(heading) - declination + 0.1 * (step % 7)) % 360.0:.2f}",
                    "pitch_deg": "2" if up else f"{pitch + 0.1 * (step % 5):.1f}",
                    "roll_deg": "0",
                    "speed_est_mps": "0" if up else "0.32",
                    "gps_lat": f"{lat:.6f}" if up else "",
                    "gps_lon": f"{lon:.6f}" if up else "",
                }
            )
            t += 10.0
            n += (speed * math.cos(heading) + 0.05) * 10.0
            e += (speed * math.sin(heading) - 0.05) * 10.0
        heading += 0.7
    return rows


def text(rows: Rows) -> str:
    return "\n".join([",".join(rows[0]), *(",".join(row.values()) for row in rows)]) + "\n"


def scored(folder: Path, *files: tuple[str, Rows]) -> tuple[list[Score], list[str]]:
    folder.mkdir(exist_ok=True)
    for name, rows in files:
        (folder / name).write_text(text(rows))
    return score_folder(folder, VEHICLE)


def figures(scores: list[Score]) -> list[tuple[float, ...]]:
    return [(s.end_pct, s.median_pct, s.coverage, s.ellipse_pct) for s in scores]


def east_to_360(written: str) -> str:
    rows = list(csv.DictReader(written.splitlines()))
    return text([row | {"lon": f"{float(row['lon']) % 360.0:.8f}"} for row in rows])


def turned_round(written: str) -> str:
    return "\n".join(",".join(reversed(line.split(","))) for line in written.splitlines())


SPELLINGS: dict[str, Callable[[str], str]] = {
    "byte order mark": lambda s: "\ufeff" + s,
    "carriage returns": lambda s: s.replace("\n", "\r\n"),
    "capitals and spaces": lambda s: s.replace("t,lat,lon", "T, Lat ,LON", 1),
    "another order": turned_round,
    "quotes": lambda s: "\n".join('"' + li.replace(",", '","') + '"' for li in s.splitlines()),
    "further columns": lambda s: s.replace("\n", ",7\n").replace("deg,7", "deg,salinity", 1),
    "longitudes to 360": east_to_360,
    "rows without a fix at 0, 0": lambda s: (
        s + "".join(f"{t},0,0,1,0,0,0\n" for t in range(241, 600))
    ),
}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[float, ...]]:
    folder = tmp_path_factory.mktemp("plain")
    return figures(scored(folder, ("a.csv", run(0, Position(-17.0, -120.0))))[0])


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_how_a_file_is_written_changes_no_figure(
    tmp_path: Path, plain: list[tuple[float, ...]], spelling: str
) -> None:
    written = SPELLINGS[spelling](text(run(0, Position(-17.0, -120.0))))
    (tmp_path / "another name.CSV").write_bytes(written.encode())
    found = figures(score_folder(tmp_path, VEHICLE)[0])
    assert found == [pytest.approx(row, abs=1e-6) for row in plain]


@pytest.mark.proof
@pytest.mark.parametrize(
    "home", [Position(-32.85, -70.0), Position(32.85, 179.9995), Position(1e-4, -1e-4)]
)
def test_other_seas_give_the_same_figures(tmp_path: Path, home: Position) -> None:
    here, _ = scored(tmp_path / "here", ("a.csv", run(0)), ("b.csv", run(1)))
    there, told = scored(tmp_path / "there", ("a.csv", run(0, home)), ("b.csv", run(1, home)))
    assert not told
    for one, other in zip(figures(here), figures(there), strict=True):
        assert other == pytest.approx(one, abs=0.2)


@pytest.mark.parametrize("home", [Position(-30.0, 179.9995), Position(-30.0, -179.9995)])
def test_a_glider_crosses_the_date_line(tmp_path: Path, home: Position) -> None:
    scores, told = scored(tmp_path, ("g.csv", glider(home, 19.0)))
    assert not told
    assert len(scores) == 1
    assert scores[0].samples == 3
    assert scores[0].end_pct < 15.0
    assert scores[0].reference_pct is not None


@pytest.mark.proof
def test_wild_places_cost_themselves_and_the_other_runs_nothing(tmp_path: Path) -> None:
    clean, _ = scored(tmp_path / "clean", ("a.csv", run(0)), ("b.csv", run(1)))
    wild = run(0)
    for i in (0, 100, 101, 180):
        wild[i] = wild[i] | {"lat": "12.5", "lon": "-80.1"}
    spoilt, told = scored(tmp_path / "spoilt", ("a.csv", wild), ("b.csv", run(1)))
    assert len(told) == 1
    assert "a.csv: 4 rows" in told[0]
    for one, other in zip(figures(clean), figures(spoilt), strict=True):
        assert other == pytest.approx(one, abs=3.0)


@pytest.mark.proof
def test_a_recording_is_never_taught_by_its_own_copy_or_a_piece_of_it(tmp_path: Path) -> None:
    alone, _ = scored(tmp_path / "alone", ("a.csv", run(0)))
    copies = ("b.csv", run(0)), ("c.csv", run(0)[30:200])
    among, _ = scored(tmp_path / "among", ("a.csv", run(0)), *copies)
    assert figures([s for s in among if s.file == "a.csv"]) == figures(alone)
    assert all(s.reference_pct is None for s in among)


@pytest.mark.proof
def test_files_of_one_name_are_told_apart(tmp_path: Path) -> None:
    for i in range(2):
        scored(tmp_path / f"day {i}.csv", ("run.csv", run(i)))
    scores, told = score_folder(tmp_path, VEHICLE)
    assert {s.file for s in scores} == {"day 0.csv/run.csv", "day 1.csv/run.csv"}
    assert not told


def test_a_glider_that_did_not_record_its_speed_has_figures_and_no_reference(
    tmp_path: Path,
) -> None:
    rows = [{k: v for k, v in r.items() if k != "speed_est_mps"} for r in glider(HOME, 5.0)]
    scores, told = scored(tmp_path, ("g.csv", rows))
    assert not told
    assert scores[0].reference_pct is None
    assert scores[0].references == {}
    assert 0.0 < scores[0].end_pct < 60.0
    json.dumps(as_object(scores), allow_nan=False)


def test_a_few_dives_tell_little_of_how_far_to_trust_the_figures_and_many_tell_it() -> None:
    right = math.log(2.0)  # the median of chi-square with two degrees of freedom, over them
    assert trust([]) == 1.0
    assert 0.85 < trust([0.0]) < 1.0
    assert trust([0.25 * right] * 100) == pytest.approx(0.5, abs=0.05)
    assert trust([4.0 * right] * 100) == pytest.approx(2.0, abs=0.05)


def test_one_wild_dive_tells_nothing_of_the_figures() -> None:
    misses = [0.3, 0.5, 0.7, 0.9, 1.2, 0.4]
    assert trust([*misses, 1e4]) == pytest.approx(trust([*misses, 1.0]), rel=0.02)


def trusted(folder: Path, vehicle: Vehicle) -> float:
    """By what the figures are multiplied that calibrate makes of one log of five dives."""
    file = folder / "g.csv"
    file.write_text(text(glider(HOME, 5.0, dives=5)))
    log = read(file)
    return calibrate_by([log], glider_vehicle(vehicle, log.period)).trusted


@pytest.mark.proof
def test_dives_of_one_log_narrow_figures_of_which_it_taught_none(tmp_path: Path) -> None:
    assert trusted(tmp_path, VEHICLE) < 0.9


@pytest.mark.proof
def test_dives_of_one_log_never_narrow_what_it_taught(tmp_path: Path) -> None:
    vague = replace(VEHICLE, sensors=replace(VEHICLE.sensors, heading_bias=1.0))
    assert trusted(tmp_path, vague) == 1.0


def test_dives_that_missed_little_narrow_the_ellipse_of_later_ones_and_move_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learned, _ = scored(tmp_path, ("g.csv", glider(HOME, 5.0)))
    monkeypatch.setattr(scoring, "trust", lambda misses: 1.0)
    believed, _ = scored(tmp_path, ("g.csv", glider(HOME, 5.0)))
    assert learned[0].ellipse_pct < 0.99 * believed[0].ellipse_pct  # by a median of two
    assert learned[0].coverage == 1.0
    assert learned[0].end_pct == pytest.approx(believed[0].end_pct, abs=1.0)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([r | {"heading_deg": "nan"} for r in run(0)], "no number in heading_deg"),
        (run(0)[::-1], "241 rows, 240 without numbers, out of range, of order"),
        (run(0, seconds=20), "too short to be scored: 20 s"),
        (glider(HOME, 5.0, begin=1.7e12), "no date in s since 1970"),
        ([{"t;lat;lon": "1;2;3"}], "there are: t;lat;lon"),
    ],
)
def test_what_cannot_be_scored_says_why(tmp_path: Path, rows: Rows, said: str) -> None:
    file = tmp_path / "odd.csv"
    file.write_text(text(rows))
    with pytest.raises(RecordingError, match=said):
        read(file)
    result = CliRunner().invoke(command, [str(tmp_path)])
    assert result.exit_code == 2
    assert f"left out: {file}" in result.stderr
    assert json.loads(result.stdout)["coverage"] is None


@pytest.mark.proof
def test_short_runs_teach_where_nothing_else_does(tmp_path: Path) -> None:
    """Their speed is near 2 m/s; 1.5 is what is believed where nothing was recorded."""
    files = [(f"{i}.csv", run(i, seconds=50)) for i in range(3)]
    scores, _ = scored(tmp_path, *files)
    assert all(s.end_pct < 15.0 for s in scores)
    assert all(s.coverage == 1.0 for s in scores)
