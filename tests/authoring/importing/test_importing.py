"""Plans of other programs as missions: every format, and what a hostile or careless file meets."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from random import Random

import pytest
from click.testing import CliRunner, Result
from plans import (
    HOME,
    NEPTUS_EDGE,
    NEPTUS_NODES,
    PLACED,
    PLANS,
    A,
    B,
    geojson,
    gpx,
    item,
    kml,
    moos,
    neptus,
    neptus_goto,
    neptus_node,
    plan,
    slocum,
    waypoint,
    wpl,
    zipped,
)

from mission.authoring.importing import FORMATS, Findings, ImportErrors, chosen, format_of
from mission.authoring.language import parse
from mission.cli import main
from mission.legs import Goto, Loiter, Rows, Surface, Yoyo
from mission.model import Leg, Local, Mission, Position
from mission.model.diagnostics import Diagnostic, Stage
from mission.model.shipped import load_vehicle
from mission.navigation.geodesy import LocalFrame

FRAME = LocalFrame(Position(*HOME))


def imported(tmp_path: Path, suffix: str, content: bytes, *more: str) -> Result:
    file = tmp_path / f"file{suffix}"
    file.write_bytes(content)
    # What a format cannot say, and home where it cannot say that: those that can are not asked.
    said = ["--pick", "harbour"] if suffix in (".nmis", ".nmisz") and "--pick" not in more else []
    command = ["import", str(file), "-o", str(tmp_path / "made.yaml"), *said, *more]
    return CliRunner().invoke(main, command)


def made(tmp_path: Path, suffix: str, content: bytes, *more: str) -> Mission:
    result = imported(tmp_path, suffix, content, *more)
    assert result.exit_code in (0, 1), result.output
    return parse((tmp_path / "made.yaml").read_text(), "made.yaml")


def answers(*more: str) -> tuple[str, ...]:
    return ("--home", f"{HOME[0]},{HOME[1]}", "--depth", "5 m", "--gear", "6", *more)


def legs(mission: Mission) -> list[Leg]:
    return [node for node in mission.body if isinstance(node, Leg)]


def local(place: object) -> tuple[float, float]:
    if isinstance(place, Local):
        return place.north, place.east
    assert isinstance(place, Position)
    return FRAME.to_local(math.radians(place.latitude_deg), math.radians(place.longitude_deg))


def settings(leg: Leg) -> dict[str, float]:
    return {setting.word: setting.value for setting in leg.settings}


def test_every_format_has_a_plan_here() -> None:
    assert PLANS.keys() == FORMATS.keys()


@pytest.mark.parametrize("name", PLANS)
def test_the_same_way_comes_out_of_every_format(name: str, tmp_path: Path) -> None:
    suffix, content = PLANS[name]
    *way, up = legs(made(tmp_path, suffix, content, *answers()))
    assert isinstance(up.kind, Surface)
    for leg, place in zip(way, (A, B), strict=True):
        assert isinstance(leg.kind, Goto)
        assert local(leg.kind.place) == pytest.approx(local(Position(*place)), abs=0.5)
        assert settings(leg) == {"depth": 5.0, "surge": 0.5}
        assert leg.otherwise == up.name


@pytest.mark.parametrize("name", PLANS)
def test_each_leg_has_time_for_its_way_against_the_current_that_is_assumed(
    name: str, tmp_path: Path
) -> None:
    suffix, content = PLANS[name]
    here = (0.0, 0.0)
    for leg in legs(made(tmp_path, suffix, content, *answers()))[:-1]:
        assert isinstance(leg.kind, Goto)
        there = local(leg.kind.place)
        assert leg.timeout is not None
        assert leg.timeout > math.dist(here, there) / (0.75 - 0.2) * 1.2 + 30.0
        here = there


@pytest.mark.parametrize("name", PLANS)
def test_what_is_imported_is_proved_and_names_its_source(name: str, tmp_path: Path) -> None:
    suffix, content = PLANS[name]
    result = imported(tmp_path, suffix, content, *answers())
    assert result.exit_code == 0, result.output
    assert f"# Imported from file{suffix}" in (tmp_path / "made.yaml").read_text()
    assert "proved" in result.output


def test_a_mission_that_the_check_refuses_is_written_and_exits_1(tmp_path: Path) -> None:
    far = [waypoint(A), waypoint((30.35, 120.15))]
    result = imported(tmp_path, ".plan", plan(far), "--gear", "6")
    assert result.exit_code == 1
    assert "refused" in result.output
    assert (tmp_path / "made.yaml").exists()


@pytest.mark.parametrize(
    ("suffix", "content", "where"),
    [
        (".gpx", gpx(), "line 3: a waypoint outside any route"),
        (".geojson", geojson(), "features[0].geometry: a Polygon"),
        (".kml", kml(), "line 3: a Point"),
        (
            ".kml",
            kml().replace(b"<Point>", b"<LinearRing/><Polygon><LinearRing/></Polygon><Point>"),
            "line 3: a LinearRing: an area is no path\n",
        ),
        (".plan", plan(), "mission.items[1]: command 201"),
        (".plan", plan(), "rallyPoints.points: rally points"),
        (".ma", slocum(), "line 4: num_legs_to_run -1"),
        (".ma", slocum(name="Goto_list"), "line 4: num_legs_to_run -1"),
        (".bhv", moos(), "line 10: behavior BHV_Loiter"),
        (".bhv", moos(), "line 5: condition = DEPLOY = true"),
        (".waypoints", wpl(["4 0 3 16 0 0 0 0 30.2882 120.154 -5 1"]), "line 2: index 4"),
    ],
)
def test_what_is_left_out_is_named_by_line_or_path_on_the_terminal_and_in_the_file(
    suffix: str, content: bytes, where: str, tmp_path: Path
) -> None:
    result = imported(tmp_path, suffix, content, *answers())
    assert f"left out: {where}" in result.output
    assert f"# Left out: {where}" in (tmp_path / "made.yaml").read_text()


def fenced(inclusion: object, corners: list[list[object]], radius: float = 400.0) -> bytes:
    circle = {"circle": {"center": [*HOME], "radius": radius}, "inclusion": True}
    polygon = {"polygon": corners, "inclusion": inclusion}
    return plan([waypoint(A)], {"circles": [circle], "polygons": [polygon]})


WRECK: list[list[object]] = [[30.2900, 120.1500], [30.2900, 120.1505], [30.2905, 120.1505]]


def test_fences_of_a_plan_are_areas_of_the_mission_no_wider_than_they_are(tmp_path: Path) -> None:
    inside, outside = made(tmp_path, ".plan", fenced(False, WRECK), *answers()).areas
    assert (inside.out, outside.out) == (False, True)
    assert outside.corners == tuple(Position(*map(float, map(str, c))) for c in WRECK)
    assert len(inside.corners) == 24
    assert [math.hypot(*local(c)) for c in inside.corners] == pytest.approx([400.0] * 24, abs=0.02)
    lying = made(tmp_path, ".plan", fenced(False, WRECK).replace(b'400.0}, "inclusion": true',
                 b'400.0}, "inclusion": false'), *answers()).areas  # fmt: skip
    (edges,) = ([local(c) for c in area.corners] for area in lying if len(area.corners) == 24)
    near = [math.hypot((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in pairwise(edges)]
    assert near == pytest.approx([400.0] * 23, abs=0.02), "the circle lies within it"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (fenced(True, WRECK[:2]), "geoFence.polygons[0]: a polygon has three corners or more"),
        (fenced(True, []), "geoFence.polygons[0]: a polygon has three corners or more"),
        (fenced("yes", WRECK), "geoFence.polygons[0].inclusion: it is neither true nor false"),
        (fenced(True, [["a", 1], *WRECK]), "geoFence.polygons[0].polygon[0][0]: not a number"),
        (fenced(True, [[300, 1], *WRECK]), "geoFence.polygons[0].polygon[0]: latitude 300"),
        (fenced(True, WRECK, 0.0), "geoFence.circles[0]: a circle has a radius greater than 0"),
        (fenced(True, WRECK), "a second fence to keep in, beside geoFence.polygons[0]"),
        (fenced(False, WRECK * 40), "geoFence.polygons[0]: more than 100 corners in an area"),
        (
            plan([waypoint(A)], {"polygons": [{"polygon": WRECK, "inclusion": False}] * 33}),
            "geoFence.polygons[32]: more than 32 areas in a mission",
        ),
    ],
)
def test_a_fence_that_is_none_is_refused_by_its_path(
    content: bytes, said: str, tmp_path: Path
) -> None:
    result = imported(tmp_path, ".plan", content, *answers())
    assert result.exit_code == 2
    assert said in result.output


def test_a_way_that_leaves_a_fence_is_refused_by_the_check(tmp_path: Path) -> None:
    around = {"polygons": [{"polygon": WRECK, "inclusion": True}]}
    result = imported(tmp_path, ".plan", plan([waypoint(A)], around), *answers())
    assert result.exit_code == 1
    assert "keep in fence_1" in result.output


def test_a_datum_that_is_wgs_84_is_no_other_and_another_is_refused(tmp_path: Path) -> None:
    def content(name: str) -> bytes:
        return geojson(crs={"type": "name", "properties": {"name": name}})

    ours = imported(tmp_path, ".geojson", content("urn:ogc:def:crs:OGC:1.3:CRS84"), *answers())
    assert "crs" not in ours.output
    theirs = imported(tmp_path, ".geojson", content("urn:ogc:def:crs:EPSG::32650"), *answers())
    assert theirs.exit_code == 2
    assert "crs: its places are in urn:ogc:def:crs:EPSG::32650, not in WGS 84" in theirs.output
    assert "ogr2ogr" in theirs.output


def test_an_arrival_radius_is_written_as_a_length_that_can_be_read(tmp_path: Path) -> None:
    content = gpx().replace(b"0.01<", b"0.050<")
    imported(tmp_path, ".gpx", content, *answers())
    assert "within: 92.6 m" in (tmp_path / "made.yaml").read_text()


# --- what a file does not say -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "asked"),
    [
        ("--depth 5m --gear 6", "say --home"),
        ("--home first --gear 6", "say --depth"),
        ("--home first --depth 5m", "say --speed, or --gear"),
    ],
)
def test_what_the_file_does_not_say_is_asked_for_by_option(
    given: str, asked: str, tmp_path: Path
) -> None:
    content = gpx().replace(b"<ele>-5</ele>", b"<ele>0</ele>")
    result = imported(tmp_path, ".gpx", content, *given.split())
    assert result.exit_code == 2
    assert asked in result.output
    assert not (tmp_path / "made.yaml").exists()


def test_home_may_be_the_first_point(tmp_path: Path) -> None:
    mission = made(tmp_path, ".gpx", gpx(), "--home", "first", "--speed", "0.75 m/s")
    assert mission.home == Position(*A)


def test_an_option_does_not_override_what_the_file_says(tmp_path: Path) -> None:
    first = legs(made(tmp_path, ".gpx", gpx(), *answers("--depth", "3 m")))[0]
    assert settings(first)["depth"] == 5.0
    assert isinstance(first.kind, Goto)
    assert first.kind.within == pytest.approx(18.52)


@pytest.mark.parametrize("option", ["--depth", "--altitude", "--speed", "--within"])
@pytest.mark.parametrize("value", ["nan", "-3", "0", "5 kg", "1e999"])
def test_an_option_that_is_no_size_is_refused(option: str, value: str, tmp_path: Path) -> None:
    result = imported(tmp_path, ".gpx", gpx(), *answers(option, value))
    assert result.exit_code == 2
    assert option in result.output


def test_of_several_routes_one_is_picked_by_name(tmp_path: Path) -> None:
    second = f'<rte><name>other</name><rtept lat="{B[0]}" lon="{B[1]}"/></rte>'
    result = imported(tmp_path, ".gpx", gpx(extra=second), *answers())
    assert result.exit_code == 2
    assert "harbour (line 4), other (line 8)" in result.output
    mission = made(tmp_path, ".gpx", gpx(extra=second), *answers("--pick", "other"))
    assert mission.name == "other"
    assert len(mission.body) == 2


def test_what_is_wrong_with_a_plan_that_nobody_picks_is_no_error(tmp_path: Path) -> None:
    assert imported(tmp_path, ".nmis", neptus()).exit_code == 0
    result = imported(tmp_path, ".nmis", neptus(), "--pick", "other")
    assert result.exit_code == 2
    assert "Launch has no counterpart" in result.output


# --- places -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PLACED)
@pytest.mark.parametrize("place", [(99.0, 120.0), (30.0, 181.0), (float("nan"), 120.0)])
def test_no_place_on_earth_is_refused_with_its_line(
    name: str, place: tuple[float, float], tmp_path: Path
) -> None:
    result = imported(tmp_path, PLANS[name][0], PLACED[name](place), *answers())
    assert result.exit_code == 2
    assert any(word in result.output for word in ("beyond", "number", "no latitude"))
    assert "Traceback" not in result.output


@pytest.mark.parametrize("name", ["gpx", "geojson", "kml"])
def test_latitude_and_longitude_that_are_exchanged_are_seen_from_home(
    name: str, tmp_path: Path
) -> None:
    home, there = (41.18, -8.70), (41.185, -8.705)
    turned = PLACED[name]((there[1], there[0])).replace(
        str(B[0]).encode(), b"TURN"
    )  # the second point as well
    turned = turned.replace(str(B[1]).encode(), str(there[0]).encode())
    turned = turned.replace(b"TURN", str(there[1]).encode())
    given = ("--home", f"{home[0]},{home[1]}", "--gear", "6", "--depth", "5m")
    result = imported(tmp_path, PLANS[name][0], turned, *given)
    assert result.exit_code == 2
    assert "exchanged: say --swap" in result.output
    mission = made(tmp_path, PLANS[name][0], turned, *given, "--swap")
    kind = legs(mission)[0].kind
    assert isinstance(kind, Goto)
    assert kind.place == Position(*there)


@pytest.mark.parametrize(
    "latitude",
    ["41N10'48''", "41N10.8'", "41.18N", "N41.18", "41.18"],
)
def test_neptus_writes_a_latitude_in_five_ways(latitude: str, tmp_path: Path) -> None:
    node = neptus_node("n", neptus_goto(latitude, "8W42'0''"), start=True)
    kind = legs(made(tmp_path, ".nmis", neptus(node), "--home", "41.18,-8.7"))[0].kind
    assert isinstance(kind, Goto)
    assert kind.place == Position(41.18, -8.7)


@pytest.mark.parametrize(
    "latitude", ["41N61'0''", "41N10'60''", "N41N", "-41S", "41E", "41,18", ""]
)
def test_a_latitude_that_says_two_things_is_refused(latitude: str, tmp_path: Path) -> None:
    node = neptus_node("n", neptus_goto(latitude, "8W42'0''"), start=True)
    assert imported(tmp_path, ".nmis", neptus(node)).exit_code == 2


def test_offsets_of_a_neptus_point_are_metres_on_top(tmp_path: Path) -> None:
    more = "<offset-north>30</offset-north><offset-west>20</offset-west>"
    node = neptus_node("n", neptus_goto(str(HOME[0]), str(HOME[1]), more), start=True)
    kind = legs(made(tmp_path, ".nmis", neptus(node)))[0].kind
    assert isinstance(kind, Goto)
    assert local(kind.place) == pytest.approx((30.0, -20.0), abs=0.02)


def test_minutes_of_a_goto_list_end_at_sixty(tmp_path: Path) -> None:
    result = imported(tmp_path, ".ma", slocum("12060.000 3017.000\n"), *answers())
    assert result.exit_code == 2
    assert "file.ma:10:1: 12060.000: minutes go to 60 [position]" in result.output


# --- what a step means --------------------------------------------------------------------------


def test_mavlink_circles_and_the_way_home_have_their_legs(tmp_path: Path) -> None:
    items = [
        item(18, 2, None, -25, None, *A, -5),
        item(19, 90, None, 30, None, *B, 4, frame=10),
        item(20, frame=2),
        item(21, 0, 0, 0, 0, 0, 0, 0),
    ]
    first, second, home, up = legs(made(tmp_path, ".plan", plan(items), *answers()))
    assert isinstance(first.kind, Loiter)
    assert (first.kind.radius, first.kind.side) == (25.0, -1)
    assert first.duration is not None
    assert first.duration >= 2 * math.tau * 25.0 / 0.75
    assert second.duration is not None
    way = math.dist(local(first.kind.place), local(second.kind.place)) / 0.75
    assert 90.0 + way <= second.duration <= 90.0 + 4.0 * way  # on the circle, behind the way to it
    assert settings(second)["altitude"] == 4.0
    assert isinstance(home.kind, Goto)
    assert home.kind.place == "home"
    assert isinstance(up.kind, Surface)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (item(177, 1, 3), "a jump has no counterpart"),
        (item(17, 0, 0, 20, 0, *A, -5), "never ends"),
        (item(19, 0, 0, 20, 0, *A, -5), "never ends"),
        (item(18, 2, 0, 0, 0, *A, -5), "without a radius"),
        (item(16, 0, 0, 0, 0, 0, 0, -5), "no latitude and longitude"),
        (item(94, 0, 0, 0, 0, *A, -5), "command 94 has no counterpart"),
        (item(16, 0, 0, 0, 0, *A, -5, frame=1), "frame 1"),
        ({"type": "ComplexItem", "complexItemType": "survey"}, "without the items"),
        ({"type": "Other"}, "neither SimpleItem nor ComplexItem"),
        ({"type": "SimpleItem", "command": 16, "frame": 3, "params": [1]}, "seven params"),
    ],
)
def test_an_item_that_would_fly_otherwise_is_refused_by_its_path(
    wrong: dict[str, object], message: str, tmp_path: Path
) -> None:
    result = imported(tmp_path, ".plan", plan([waypoint(A), wrong]), *answers())
    assert result.exit_code == 2
    assert message in result.output
    assert "mission.items[1]" in result.output


ROWS = """<RowsManeuver><basePoint><point><coordinate><latitude>30.2882</latitude>
<longitude>120.154</longitude><z>3</z><zunits>ALTITUDE</zunits></coordinate></point></basePoint>
<width>60</width><length>100</length><hstep>20</hstep><bearing>90</bearing>{more}
<speed unit="RPM">1000</speed></RowsManeuver>"""


def test_rows_of_neptus_are_rows(tmp_path: Path) -> None:
    text = ROWS.format(more="<firstCurveRight>false</firstCurveRight>")
    result = imported(tmp_path, ".nmis", neptus(neptus_node("r", text, True)), "--gear", "6")
    assert "a speed in RPM" in result.output
    (leg, _) = legs(parse((tmp_path / "made.yaml").read_text()))
    kind = leg.kind
    assert isinstance(kind, Rows)
    assert (kind.count, kind.length, kind.spacing, kind.side) == (4, 100.0, 20.0, -1)
    assert kind.bearing == pytest.approx(math.pi / 2)
    assert settings(leg) == {"altitude": 3.0, "surge": 0.5}


@pytest.mark.parametrize(
    "more",
    ["<crossAngle>10</crossAngle>", "<alternationPercentage>50</alternationPercentage>"],
)
def test_rows_that_ours_cannot_be_are_refused(more: str, tmp_path: Path) -> None:
    text = neptus(neptus_node("r", ROWS.format(more=more), True))
    assert imported(tmp_path, ".nmis", text, "--gear", "6").exit_code == 2


def yoyo_node(pitch: float) -> str:
    place = f"<latitude>{A[0]}</latitude><longitude>{A[1]}</longitude>"
    text = f"""<YoYo><finalPoint><point><coordinate>{place}<z>6</z><zunits>DEPTH</zunits>
</coordinate></point></finalPoint><amplitude>3</amplitude><pitch>{pitch}</pitch>
<speed unit="m/s">0.75</speed></YoYo>"""
    return neptus_node("y", text, True)


def test_a_yoyo_goes_to_its_point_between_its_depths(tmp_path: Path) -> None:
    pitch, way = 0.2, math.hypot(*local(Position(*A)))
    yoyo, there, _ = legs(made(tmp_path, ".nmis", neptus(yoyo_node(pitch))))
    assert isinstance(yoyo.kind, Yoyo)
    assert (yoyo.kind.shallow, yoyo.kind.deep) == (3.0, 9.0)
    assert yoyo.kind.cycles == int(way / (12.0 / math.tan(pitch)))
    assert isinstance(there.kind, Goto)


def test_cycles_of_a_yoyo_are_no_steeper_than_the_hull(tmp_path: Path) -> None:
    steep, _, _ = legs(made(tmp_path, ".nmis", neptus(yoyo_node(0.7))))
    auv, way = load_vehicle("auv"), math.hypot(*local(Position(*A)))
    assert isinstance(steep.kind, Yoyo)
    lasts = 6.0 / auv.dive_rate + 6.0 / auv.ascent_buoyancy
    assert steep.kind.cycles == int(way / (lasts * 0.75)) < int(way / (12.0 / math.tan(0.7)))


def test_a_height_of_0_is_the_surface_where_others_are_under_water(tmp_path: Path) -> None:
    above = item(16, 0, 0, 0, 0, *A, 0)
    dives = plan([above, item(16, 0, 0, 0, 0, *B, -5)])
    first, second, _ = legs(made(tmp_path, ".plan", dives, *answers()))
    assert settings(first)["depth"] == 0.0
    assert settings(second)["depth"] == 5.0
    first, _ = legs(made(tmp_path, ".plan", plan([above]), *answers()))  # a boat's
    assert settings(first)["depth"] == 5.0


def test_pop_ups_and_paths_of_neptus_have_their_legs(tmp_path: Path) -> None:
    place = f"""<coordinate><latitude>{HOME[0]}</latitude><longitude>{HOME[1]}</longitude>
<depth>4</depth></coordinate>"""
    path = f"""<FollowPath><basePoint><point>{place}</point></basePoint><path>
<nedOffsets northOffset="10" eastOffset="0" depthOffset="1"/>
<nedOffsets northOffset="30" eastOffset="5" depthOffset="0"/></path>
<speed unit="MPS">0.75</speed></FollowPath>"""
    up = f"""<PopUp><finalPoint><point>{place}</point></finalPoint><duration>30</duration>
<flags CurrPos="true"/><speed unit="MPS">0.75</speed></PopUp>"""
    graph = neptus_node("one", path, True) + neptus_node("two", up) + NEPTUS_EDGE
    first, second, rise = legs(made(tmp_path, ".nmis", neptus(graph)))
    assert isinstance(first.kind, Goto)
    assert isinstance(second.kind, Goto)
    assert local(first.kind.place) == pytest.approx((10.0, 0.0), abs=0.02)
    assert settings(first)["depth"] == 5.0
    assert local(second.kind.place) == pytest.approx((30.0, 5.0), abs=0.02)
    assert isinstance(rise.kind, Surface)


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        (NEPTUS_EDGE + NEPTUS_EDGE, "second way out of one"),
        (NEPTUS_EDGE.replace("ManeuverIsDone", "depth > 3"), "a guard that is no end"),
        (
            NEPTUS_EDGE
            + "<edge><source>two</source><target>one</target><guard>true</guard></edge>",
            "comes back to one",
        ),
    ],
)
def test_a_plan_that_is_no_chain_is_refused(edges: str, message: str, tmp_path: Path) -> None:
    result = imported(tmp_path, ".nmis", neptus(NEPTUS_NODES + edges))
    assert result.exit_code == 2
    assert message in result.output


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (moos("format=lawnmower, x=0, y=40"), "a pattern"),
        (moos("60,-40,3"), "is not x,y"),
        (moos("$(START)"), "a macro"),
        (b"#include plug.bhv\n" + moos(), "a macro of nsplug"),
        (moos()[:-5], "without an end"),
    ],
)
def test_a_behavior_file_that_is_a_program_is_refused(
    content: bytes, message: str, tmp_path: Path
) -> None:
    result = imported(tmp_path, ".bhv", content, *answers())
    assert result.exit_code == 2
    assert message in result.output


# --- hostile files ------------------------------------------------------------------------------

DAMAGE = (b"nan", b"-1", b"1e308", b"", b"null", b"[]", b'"', b"<", b"0", b",", b":", b"{", b"\n")
BOMB = '<!DOCTYPE x [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>'


@pytest.mark.parametrize(
    ("suffix", "content", "message"),
    [
        (".gpx", gpx(head=BOMB), "defines an entity"),
        (".gpx", b"<gpx>" + b"<a>" * 200, "elements"),
        (".gpx", b"<gpx>" + b"<a/>" * 130_000 + b"</gpx>", "elements"),
        (".gpx", b"<gpx><rte>", "not XML"),
        (".gpx", b"<kml/>", "the outermost element is kml"),
        (".gpx", b"", "not XML"),
        (".geojson", b"[" * 100_000, "not JSON"),
        (".geojson", b'{"type": 1, "type": 2}', "stands twice"),
        (".geojson", b'{"type": "Topology"}', "no type of GeoJSON"),
        (".geojson", json.dumps({"type": "LineString", "coordinates": 3}).encode(), "not a list"),
        (".geojson", b'{"type":"LineString","coordinates":[[1e999,3],[true,4]]}', "not a finite"),
        (".geojson", b"\xff\xfe", "it is not utf-8"),
        (".plan", b"{}", "it is not Plan"),
        (".kmz", b"PK\x03\x04 and no more", "cannot be unpacked"),
        (".kmz", zipped(b"", "plan.txt"), "it holds 0 files *.kml"),
        (".kmz", zipped(b"0" * (5 << 20), "doc.kml"), "which no plan has"),
        (".nmisz", zipped(b"0" * (5 << 20), "mission.nmis"), "which no plan has"),
        (".waypoints", wpl(header="QGC WPL 120"), "it is not QGC WPL 110"),
        (".waypoints", wpl(["1 2 3"]), "3 columns, not 12"),
        (".waypoints", wpl(["0 0 3 16 0 0 0 0 nan 120 -5 1"]), "is no number"),
        (".ma", slocum(name="yo"), "no behavior_name=goto_list"),
        (".ma", b"behavior_name=goto_list", "no <start:waypoints>"),
        (".ma", slocum("12 13 14\n"), "is not a longitude and a latitude"),
        (".xyz", b"", "is no format's"),
        (".gpx", b"<gpx/>", "there is no route in it"),
        (".gpx", gpx() + b" " * (5 << 20), "which no plan has"),
    ],
)
def test_a_hostile_file_is_refused_in_bounds(
    suffix: str, content: bytes, message: str, tmp_path: Path
) -> None:
    result = imported(tmp_path, suffix, content, *answers())
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert not (tmp_path / "made.yaml").exists()


@pytest.mark.parametrize("name", PLANS)
def test_a_damaged_file_is_refused_or_makes_a_mission_that_can_be_read(
    name: str, tmp_path: Path
) -> None:
    rng = Random(name)
    suffix, content = PLANS[name]
    for _ in range(40):
        damaged = bytearray(content)
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(len(damaged))
            damaged[at : at + rng.randint(0, 6)] = rng.choice(DAMAGE)
        result = imported(tmp_path, suffix, bytes(damaged), *answers())
        assert result.exit_code in (0, 1, 2), bytes(damaged)
        assert result.exception is None or isinstance(result.exception, SystemExit), damaged
        if result.exit_code < 2:
            parse((tmp_path / "made.yaml").read_text())


def test_a_file_that_is_not_there_is_said_to_be_missing(tmp_path: Path) -> None:
    result = CliRunner().invoke(main, ["import", str(tmp_path / "none.gpx")])
    assert result.exit_code == 2
    assert "No such file" in result.output


@pytest.mark.parametrize("suffix", [".kmz", ".nmisz"])
def test_an_archive_is_read_as_what_it_holds(suffix: str, tmp_path: Path) -> None:
    content = (
        zipped(kml(), "harbour.kml") if suffix == ".kmz" else zipped(neptus(), "m/mission.nmis")
    )
    assert len(made(tmp_path, suffix, content, *answers()).body) == 3


def test_a_mission_goes_to_standard_output_without_an_output(tmp_path: Path) -> None:
    file = tmp_path / "a.gpx"
    file.write_bytes(gpx())
    result = CliRunner().invoke(main, ["import", str(file), *answers()])
    assert parse(result.stdout).name == "harbour"


# --- how a refusal is told ----------------------------------------------------------------------


def refused(suffix: str, content: bytes) -> tuple[Diagnostic, ...]:
    found = Findings("file")
    source = format_of(Path(f"file{suffix}"), found).read(content, found)
    chosen(source, None, found).steps()
    with pytest.raises(ImportErrors) as caught:
        found.complain()
    return caught.value.diagnostics


def test_all_that_is_wrong_is_told_at_once_each_with_its_line_and_code(tmp_path: Path) -> None:
    points = '<rtept lat="95" lon="1"/>\n  <rtept lat="x" lon="1"/>'
    result = imported(tmp_path, ".gpx", f"<gpx><rte>\n{points}</rte></gpx>".encode(), *answers())
    assert result.exit_code == 2
    assert "file.gpx:2:1: latitude 95 is beyond 90 degrees [position]\n" in result.output
    shown = "file.gpx:3:3: lat is no number: 'x' [number]\n      <rtept"
    assert shown in result.output
    assert "file.gpx: 2 errors" in result.output


def test_a_place_that_is_no_line_is_told_by_its_path() -> None:
    (told,) = refused(".plan", b'{"fileType": "Plan", "mission": {"items": [{"type": "Loop"}]}}')
    assert (told.stage, told.code, told.where.line) == (Stage.IMPORT, "plan-form", 0)
    assert told.message.startswith("mission.items[0].type: 'Loop' is neither")


def test_a_line_of_somebody_elses_reaches_no_terminal_with_its_control_characters(
    tmp_path: Path,
) -> None:
    content = b"<gpx><rte>\n<rtept lat='x\xc2\x9b31m' lon='1'/></rte></gpx>"
    output = imported(tmp_path, ".gpx", content, *answers()).output
    assert "lat='x?31m'" in output
    assert "\x9b" not in output


# --- files of others ----------------------------------------------------------------------------


def test_missions_of_ardusub_are_taken_over(recordings: Path, tmp_path: Path) -> None:
    folder = recordings / "missions"
    dive = (folder / "ArduSub_DiveMission_sub_mission.txt").read_bytes()
    result = imported(tmp_path, ".txt", dive, "--gear", "8")
    assert result.exit_code == 2  # its home is in Canberra, its points are at Los Angeles
    assert "file.txt:3:1: more than 200 km from home [position]" in result.output
    way = legs(made(tmp_path, ".txt", dive, "--gear", "8", "--home", "first"))
    assert [type(leg.kind) for leg in way] == [Goto, Goto, Goto, Loiter, Goto, Surface]
    assert [settings(leg).get("depth") for leg in way] == [50, 50, 50, 25, 25, None]
    gripper = (folder / "ArduSub_GripperMission.txt").read_bytes()
    assert len(made(tmp_path, ".txt", gripper, "--depth", "3", "--gear", "8").body) == 4
