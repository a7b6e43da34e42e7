"""The planned track: where it leads, what is drawn of it, and what cannot be planned."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from later import Later

from mission.authoring.bathymetry import bathymetry_of
from mission.authoring.prepare import check_prepared, prepare
from mission.cli import main
from mission.model import Local, Position
from mission.navigation.geodesy import LocalFrame
from mission.verification.planned.formats import FORMATS
from mission.verification.planned.picture import _plan_view, _profile
from mission.verification.planned.track import Plan, planned

drawing = Later("matplotlib.figure")
TEXT = """
mission small vehicle auv
home 30.2874595 120.1535765
safety radius 400 time 20min depth 10
assume current 0.1
keep out wreck: north 300 east 200, north 300 east 260, north 340 east 230 between 4 and 9
dive: depth 4 heading 0 gear 6 until depth >= 3.5 timeout 60
mow: rows 2 bearing 90 length 60 spacing 20 side starboard from north 30 east 10 within 5 gear 6 timeout 8min
up: surface until fix timeout 3min
"""

# Depths of 9 m, 3 m from latitude 30.2877 on, which is 27 m north of home; none known in the east.
BAY = """ncols 2
nrows 2
xllcorner 120.1530
yllcorner 30.2869
cellsize 0.0008
nodata_value -9999
3 -9999
9 -9999
"""


@pytest.fixture(scope="module")
def over_bay(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    file = tmp_path_factory.mktemp("plan") / "small.mission"
    file.write_text(TEXT)
    ready = prepare(file)
    return planned(ready.mission, ready.chart, ready.vehicle, bathymetry_of(BAY, "bay.asc"))


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    file = tmp_path_factory.mktemp("plan") / "small.mission"
    file.write_text(TEXT)
    ready = prepare(file)
    return planned(ready.mission, ready.chart, ready.vehicle)


@pytest.mark.parametrize("name", ["coreboard-dive", "lawnmower"])
def test_the_plan_says_of_each_leg_what_the_check_expects_beside_the_vehicles_own_estimate(
    name: str,
) -> None:
    ready = prepare(name)
    made = planned(ready.mission, ready.chart, ready.vehicle)
    told = {leg.name: leg.expected for leg in made.stretches}
    for one in check_prepared(ready).outlook:
        names = [f"{one.leg}/row{n + 1}" for n in range(len(one.errors))] if one.rows else [one.leg]
        assert [told[name] for name in names] == list(one.errors)
    page = FORMATS[".html"].write(made).decode()
    for leg in (leg for leg in made.stretches if leg.spots):
        cells = "" if leg.expected is None else f"{leg.expected:.0f} m"
        assert f"<td>{cells}</td><td>{leg.spots[-1].axes[0]:.0f} m</td>" in page
    features = json.loads(FORMATS[".geojson"].write(made))["features"] if ready.mission.home else []
    for feature in features:
        known = feature["properties"]
        if known["is"] == "track":
            assert known.get("expected_m", 0.0) == round(told[known["leg"]] or 0.0, 1)


def test_legs_that_no_way_leads_to_in_still_water_are_told(tmp_path: Path) -> None:
    file = tmp_path / "m.mission"
    text = TEXT.replace("until depth >= 3.5 timeout 60", "until temperature falls 2 timeout 60")
    file.write_text(text)
    said = CliRunner().invoke(
        main, ["plan", str(file), "-o", str(tmp_path / "a.geojson"), "--json"]
    )
    assert said.exit_code == 0, said.output
    assert json.loads(said.stdout)["not_flown"] == ["mow", "up"]
    assert "not drawn, since no way leads there in still water: mow, up" in said.stderr


def test_the_track_leads_along_the_legs_of_the_mission(plan: Plan) -> None:
    assert [leg.name for leg in plan.stretches] == ["dive", "mow", "up", "surface"]
    assert plan.radius == 400.0
    times = [spot.t for leg in plan.stretches for spot in leg.spots]
    assert times == sorted(times)


def test_turning_points_are_the_corners_of_the_rows_with_their_times(plan: Plan) -> None:
    mow = plan.stretches[1]
    wanted = [(30.0, 10.0), (30.0, 70.0), (10.0, 70.0), (10.0, 10.0)]
    for spot, corner in zip(mow.turns, wanted, strict=True):
        assert math.dist((spot.north, spot.east), corner) < 8.0
    times = [spot.t for spot in mow.turns]
    assert times == sorted(times)
    assert {tuple(map(round, corner)) for corner in mow.area} == {
        (30, 10),
        (30, 70),
        (10, 70),
        (10, 10),
    }


def test_the_uncertainty_grows_as_long_as_there_is_no_fix(plan: Plan) -> None:
    mow = plan.stretches[1]
    assert mow.spots[-1].axes[0] > 2.0 * mow.spots[0].axes[0]


def test_over_a_file_each_place_has_its_floor_and_none_where_it_knows_none(over_bay: Plan) -> None:
    spots = [spot for leg in over_bay.stretches for spot in leg.spots]
    assert {spot.floor for spot in spots} == {9.0, 3.0, None}
    edge = 21.5  # m east of home, where the file ends
    for spot in spots:
        if abs(spot.east - edge) > 3.0:
            assert (spot.floor is None) is (spot.east > edge)
        if spot.floor == 9.0:
            assert spot.north < 32.0


def test_the_way_is_the_one_that_is_meant_where_the_floor_is_too_shallow(
    plan: Plan, over_bay: Plan
) -> None:
    meant, over = (
        [(s.t, s.north, s.east, s.depth) for leg in one.stretches for s in leg.spots]
        for one in (plan, over_bay)
    )
    assert np.array(over) == pytest.approx(np.array(meant), abs=1e-3)
    assert plan.clearance is None
    assert over_bay.clearance is not None
    assert over_bay.clearance.aground
    deep = max(s.depth for leg in plan.stretches for s in leg.spots)
    assert over_bay.clearance.least == pytest.approx(3.0 - deep, abs=0.3)


@pytest.mark.proof
def test_every_format_tells_the_least_water(plan: Plan, over_bay: Plan) -> None:
    least = f"{over_bay.stretches[1].water:.1f} m"
    assert least.startswith("-1.")
    page = FORMATS[".html"].write(over_bay).decode()  # with the picture
    assert f"least water under it {least}: aground" in page
    assert f"<td>{least}</td>" in page
    features = json.loads(FORMATS[".geojson"].write(over_bay))["features"]
    mow = next(p for f in features if (p := f["properties"]).get("leg") == "mow")
    assert mow["is"] == "track"
    assert f"{mow['water_m']:.1f} m" == least
    assert b"water_m" not in FORMATS[".geojson"].write(plan)


def test_the_floor_is_drawn_under_the_depth_and_keeps_the_dive_in_sight(over_bay: Plan) -> None:
    axes = drawing.Figure().subplots()
    _profile(axes, over_bay)
    (drawn,) = axes.collections
    levels = {round(y, 1) for path in drawn.get_paths() for _, y in path.vertices}
    assert {3.0, 9.0} < levels
    deep = [
        replace(leg, spots=tuple(replace(s, floor=900.0) for s in leg.spots))
        for leg in over_bay.stretches
    ]
    axes = drawing.Figure().subplots()
    _profile(axes, replace(over_bay, stretches=tuple(deep)))
    assert 4.0 < axes.get_ylim()[0] < 20.0


def test_the_command_tells_where_the_water_is_least(tmp_path: Path) -> None:
    (tmp_path / "a.mission").write_text(TEXT)
    (tmp_path / "bay.asc").write_text(BAY)
    command = ["plan", str(tmp_path / "a.mission"), "-o", str(tmp_path / "a.geojson")]
    command += ["--bathymetry", str(tmp_path / "bay.asc")]
    run = CliRunner().invoke(main, command)
    assert run.exit_code == 0, run.output
    assert re.fullmatch(
        r"least clearance +-1\.\d m at \d+ s, 30\.28\d+ 120\.15\d+: aground\n", run.stdout
    )
    without = (tmp_path / "a.mission").read_text().replace("home 30.2874595 120.1535765\n", "")
    (tmp_path / "a.mission").write_text(without)
    run = CliRunner().invoke(main, command)
    assert run.exit_code == 2
    assert "names no home, so that no depth lies under it; write home" in run.output


@pytest.mark.proof
def test_a_mission_says_the_same_plan_each_time(plan: Plan) -> None:
    assert FORMATS[".svg"].write(plan) == FORMATS[".svg"].write(plan)


@pytest.mark.proof
def test_every_format_is_what_its_suffix_says(plan: Plan) -> None:
    drawn = {suffix: row.write(plan) for suffix, row in FORMATS.items()}
    assert drawn[".png"].startswith(b"\x89PNG")
    assert b"<svg" in drawn[".svg"]
    assert b"<svg" in drawn[".html"]
    assert b"<td>mow</td>" in drawn[".html"]
    assert b"least water" not in drawn[".html"]
    assert json.loads(drawn[".geojson"])["type"] == "FeatureCollection"


@pytest.mark.proof
def test_areas_are_drawn_and_on_the_map(plan: Plan) -> None:
    (fence,) = plan.fences
    assert fence.area.name == "wreck"
    assert b"keep out wreck (4 to 9 m)" in FORMATS[".svg"].write(plan)
    features = json.loads(FORMATS[".geojson"].write(plan))["features"]
    told = next(f["properties"] for f in features if f["properties"]["is"] == "keep out")
    assert told == {"is": "keep out", "name": "wreck", "top_m": 4.0, "bottom_m": 9.0}


def test_an_area_whose_rows_come_up_for_fixes_is_filled_once(tmp_path: Path) -> None:
    corners = "north 20 east 0, north 20 east 60, north 60 east 60, north 60 east 0"
    text = re.sub(r"rows .* gear 6", f"cover {corners} spacing 20 depth 4 gear 6 resurface 1", TEXT)
    text = text.replace("radius 400 time 20min", "radius 900 time 40min")
    text = re.sub(r"keep out .*", "", text)
    (tmp_path / "m.mission").write_text(text)
    ready = prepare(tmp_path / "m.mission")
    axes = drawing.Figure().subplots()
    _plan_view(axes, planned(ready.mission, ready.chart, ready.vehicle))
    assert sum(patch.get_alpha() == 0.10 for patch in axes.patches) == 1


def test_the_map_layer_lies_where_home_is(plan: Plan) -> None:
    features = json.loads(FORMATS[".geojson"].write(plan))["features"]
    frame = LocalFrame(Position(30.2874595, 120.1535765))
    first = next(f for f in features if f["properties"]["is"] == "turn")
    longitude, latitude, height = first["geometry"]["coordinates"]
    place = frame.to_local(math.radians(latitude), math.radians(longitude))
    assert math.dist(place, (30.0, 10.0)) < 8.0
    assert height == pytest.approx(-4.0, abs=0.5)
    for feature in features:
        if feature["geometry"]["type"] == "Polygon":
            ring = feature["geometry"]["coordinates"][0]
            assert ring[0] == ring[-1]
            turned = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(ring))
            assert turned > 0.0  # counterclockwise


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        (TEXT.replace("home 30.2874595 120.1535765\n", ""), "a.geojson", "names no home"),
        (TEXT.replace("timeout 60\n", "timeout 60 else up\n").replace("until depth >= 3.5", "until depth >= 9"), "a.svg", ""),
        (TEXT, "a.pdf", "the suffix says what to write"),
    ],
)  # fmt: skip
def test_what_cannot_be_written_is_refused(
    text: str, name: str, message: str, tmp_path: Path
) -> None:
    file = tmp_path / "a.mission"
    file.write_text(text)
    result = CliRunner().invoke(main, ["plan", str(file), "-o", str(tmp_path / name)])
    if message:
        assert result.exit_code == 2
        assert message in result.output
    else:  # left by its timeout: that is a way, too, and is drawn
        assert result.exit_code == 0
    assert (tmp_path / name).exists() is not bool(message)


@pytest.mark.proof
def test_places_of_other_kinds_are_where_the_legs_go() -> None:
    ready = prepare("loiter")
    plan = planned(ready.mission, ready.chart, ready.vehicle)
    circles = [leg for leg in plan.stretches if leg.area]
    assert circles
    for leg in circles:
        centre = Local(
            sum(n for n, _ in leg.area) / len(leg.area), sum(e for _, e in leg.area) / len(leg.area)
        )
        last = leg.spots[-1]
        radius = math.dist(leg.area[0], (centre.north, centre.east))
        assert math.dist((last.north, last.east), (centre.north, centre.east)) < 1.5 * radius
