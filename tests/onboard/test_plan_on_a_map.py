"""A mission as a map: what it keeps in and out of stands there, too."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from later import Later

from mission.analysis.report.dive import Dive
from mission.analysis.report.map import draw_map
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.authoring.prepare import prepare
from mission.model import Position
from mission.model.shipped import load_vehicle
from mission.navigation.geodesy import LocalFrame
from mission.onboard.stream.plan import plan_geojson, routes
from mission.verification.planned.track import planned

drawing, geometry = Later("matplotlib.figure"), Later("shapely.geometry")
HOME = Position(30.2874595, 120.1535765)
TEXT = """mission fenced vehicle auv
home 30.2874595 120.1535765
safety radius 900 time 15min depth 20 voltage 10
keep in bay: north -300 east -300, north -300 east 500, north 500 east 500, north 500 east -300
keep out wreck: north 60 east 260, north 60 east 320, north 130 east 320 between 4 and 12
assume current 0.1
dive: depth 4 heading 0 gear 6 until depth >= 3.5 timeout 90
up: surface timeout 3min
"""


@pytest.fixture(scope="module")
def features() -> list[dict[str, Any]]:
    mission, vehicle = parse(TEXT), load_vehicle("auv")
    chart = compile_mission(mission, vehicle, digest(mission))
    found: list[dict[str, Any]] = plan_geojson(chart, load_vehicle("auv"), HOME)["features"]
    return found


def test_every_area_is_a_ring_on_the_map_where_the_mission_has_it(
    features: list[dict[str, Any]],
) -> None:
    areas = {f["properties"]["name"]: f for f in features if f["geometry"]["type"] == "Polygon"}
    assert list(areas) == ["bay", "wreck"]
    for feature in areas.values():
        ring = geometry.shape(feature["geometry"]).exterior
        assert ring.is_ccw, "as RFC 7946 wants it"
    (ring,) = areas["wreck"]["geometry"]["coordinates"]
    assert ring[0] == ring[-1]
    frame = LocalFrame(HOME)
    local = {
        tuple(
            round(v) for v in frame.to_local(lat * 0.017453292519943295, lon * 0.017453292519943295)
        )
        for lon, lat in ring
    }
    assert local == {(60, 260), (60, 320), (130, 320)}


@pytest.mark.proof
def test_the_map_of_a_report_says_what_is_kept_out_of(features: list[dict[str, Any]]) -> None:
    dive = Dive(load_vehicle("auv"), 0.0, origin=HOME, plan=features)
    axes = drawing.Figure().subplots()
    draw_map(axes, dive)
    legend = axes.get_legend()
    assert legend is not None
    named = [text.get_text() for text in legend.get_texts()]
    assert "keep out wreck (4 to 12 m)" in named
    assert "keep in bay" in named


def test_what_a_leg_covers_is_a_ring_on_the_map_and_once() -> None:
    text = (
        "mission m vehicle auv\nhome 30.2874595 120.1535765\nsafety time 60min depth 12\n"
        "keep in field: north -50 east -50, north -50 east 90, north 90 east 90, north 90 east -50\n"
        "a: cover north 0 east 0, north 0 east 60, north 60 east 60 swath 20 depth 6 gear 8 "
        "timeout 10min\nb: cover area field swath 20 depth 6 gear 8 timeout 10min\n"
        "up: surface timeout 3min\n"
    )
    mission = parse(text)
    chart = compile_mission(mission, load_vehicle("auv"), digest(mission))
    found = plan_geojson(chart, load_vehicle("auv"), HOME)["features"]
    rings = [f for f in found if f["geometry"]["type"] == "Polygon"]
    assert [f["properties"]["name"] for f in rings] == ["field", "a"]
    assert geometry.shape(rings[1]["geometry"]).exterior.is_ccw
    axes = drawing.Figure().subplots()
    draw_map(axes, Dive(load_vehicle("auv"), 0.0, origin=HOME, plan=[rings[1]]))
    legend = axes.get_legend()
    assert legend is not None
    assert "area to cover" in [text.get_text() for text in legend.get_texts()]
    assert axes.get_ylim()[1] > 60.0, "all of it is within the frame"


BY_HEADING = """mission legs vehicle auv
home 30.2874595 120.1535765
safety radius 900 time 60min depth 20 voltage 10
assume current 0.1
repeat 2 rows:
  out: depth 4 heading 90 gear 8 until travelled >= 200 timeout 8min
  back: heading 270 gear 8 for 100s
end
blind: heading 0 gear 6 until travelled >= 100 timeout 5min
home_run: goto home within 15 gear 8 timeout 10min
up: surface timeout 3min
"""


def drawn(text: str) -> dict[str, list[list[tuple[int, int]]]]:
    """Of each leg its lines, m north and east of home."""
    mission = parse(text)
    vehicle = load_vehicle(mission.vehicle)
    chart, frame = compile_mission(mission, vehicle, digest(mission)), LocalFrame(HOME)
    found: dict[str, list[list[tuple[int, int]]]] = {}
    for feature in plan_geojson(chart, vehicle, HOME)["features"]:
        if (
            feature["geometry"]["type"] == "LineString"
            and feature["properties"]["name"] != "radius"
        ):
            line = [
                frame.to_local(math.radians(n), math.radians(e))
                for e, n in feature["geometry"]["coordinates"]
            ]
            local = [(round(north), round(east)) for north, east in line]
            found.setdefault(feature["properties"]["name"], []).append(local)
    return found


def test_a_leg_by_heading_is_drawn_as_far_as_it_is_meant_to_go_and_each_round_where_it_leads() -> (
    None
):
    found = drawn(BY_HEADING)
    back = round(200 - 100 * load_vehicle("auv").speed_by_gear.at(8))
    assert found["rows/out"] == [[(0, 0), (0, 200)], [(0, back), (0, back + 200)]]
    assert found["rows/back"][0] == [(0, 200), (0, back)]
    assert found["blind"] == [[(0, 2 * back), (100, 2 * back)]]
    assert found["home_run"] == [[(100, 2 * back), (0, 0)]]


def test_rounds_along_the_same_line_are_one() -> None:
    text = BY_HEADING.replace("heading 270 gear 8 for 100s", "goto home within 5 timeout 9min")
    assert drawn(text)["rows/back"] == [[(0, 200), (0, 0)]]


def test_a_leg_that_is_for_when_another_fails_is_not_drawn() -> None:
    once = BY_HEADING.replace("repeat 2 rows", "group rows")
    found = drawn(once.replace("for 100s", "until travelled >= 150 -> home_run timeout 9min"))
    assert "blind" not in found
    assert found["home_run"] == [[(0, 50), (0, 0)]], "from where the leg before it ends"


def test_astern_is_drawn_astern() -> None:
    text = BY_HEADING.replace("heading 90 gear 8", "heading 90 gear -8").replace(
        "vehicle auv", "vehicle auv-documented"
    )
    assert drawn(text)["rows/out"][0] == [(0, 0), (0, -200)]


@pytest.mark.parametrize("name", ["first-dive", "transect", "harbour-survey", "lawnmower"])
def test_what_is_drawn_lies_where_the_plan_is_flown_but_for_its_turns(name: str) -> None:
    prepared = prepare(Path(name))
    assert prepared.mission.home is not None
    frame = LocalFrame(prepared.mission.home)
    ends = {state.path.partition("/")[2]: corners[-1] for state, corners in reversed(list(
        routes(prepared.chart, prepared.vehicle, frame)))}  # fmt: skip
    made = planned(prepared.mission, prepared.chart, prepared.vehicle)
    flown = {
        leg.name: (leg.spots[-1].north, leg.spots[-1].east) for leg in made.stretches if leg.spots
    }
    compared = ends.keys() & flown.keys()
    assert len(compared) >= 4
    for leg in compared:
        assert math.dist(ends[leg], flown[leg]) < 40.0, leg
