"""A mission as a map: what it keeps in and out of stands there, too."""

from __future__ import annotations

from typing import Any

import pytest
from later import Later

from mission.analysis.report.dive import Dive
from mission.analysis.report.map import draw_map
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.model import Position
from mission.model.shipped import load_vehicle
from mission.navigation.geodesy import LocalFrame
from mission.onboard.stream.plan import plan_geojson

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
    found: list[dict[str, Any]] = plan_geojson(chart, HOME)["features"]
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
    found = plan_geojson(chart, HOME)["features"]
    rings = [f for f in found if f["geometry"]["type"] == "Polygon"]
    assert [f["properties"]["name"] for f in rings] == ["field", "a"]
    assert geometry.shape(rings[1]["geometry"]).exterior.is_ccw
    axes = drawing.Figure().subplots()
    draw_map(axes, Dive(load_vehicle("auv"), 0.0, origin=HOME, plan=[rings[1]]))
    legend = axes.get_legend()
    assert legend is not None
    assert "area to cover" in [text.get_text() for text in legend.get_texts()]
    assert axes.get_ylim()[1] > 60.0, "all of it is within the frame"
