"""Laws of the report: one file that needs no other, with all that happened, of one dive or many."""

from __future__ import annotations

import json
import math
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from later import Later

from mission.analysis.chapters import Chapter, Table
from mission.analysis.doubts import Spell
from mission.analysis.journal import recordings
from mission.analysis.report.dive import Dive, Stay
from mission.analysis.report.figures import (
    Picture,
    map_of,
    parted,
    pictures_of,
    reports_of_depth,
    thrusters_of,
    unbroken,
)
from mission.analysis.report.map import _scale, draw_map, flown_of, marks_of, near
from mission.analysis.report.numbers import along, around, as_runs
from mission.analysis.report.page import _heading
from mission.analysis.report.words import day, figures, track_words
from mission.analysis.story import story
from mission.analysis.tell import as_html
from mission.authoring.prepare import prepare
from mission.commands.report import report
from mission.commands.simulate import simulate
from mission.model import Position, Record, Tx
from mission.model.shipped import load_vehicle
from mission.model.shown import clock
from mission.onboard.blackbox import BlackBox, close_recording, notes_of
from mission.onboard.runtime.records import RX, read_rx, tx_record
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.simulation.flight import fly

drawing, patches = Later("matplotlib.figure"), Later("matplotlib.patches")
RECORDED = Path(__file__).parent / "recorded"
SHORT, HEAVY, AGAIN = (
    RECORDED / f"{name}.mcap" for name in ("short-time", "heavy-then-ended", "begun-again")
)
HOP = """\
mission hop vehicle auv
home 30.2874595 120.1535765
safety radius 500 time 15min depth 10 voltage 10
assume current 0.2
dive: depth 2 heading 0 gear 6 until depth >= 1.5 timeout 90
up: surface timeout 3min
"""


class Page(HTMLParser):
    def __init__(self, path: Path) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.loads: list[str] = []
        self.text = path.read_text(encoding="utf-8")
        self.feed(self.text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.loads += [v or "" for n, v in attrs if n in ("src", "href", "xlink:href", "data")]


def reported(*words: str | Path) -> Result:
    return CliRunner().invoke(report, list(map(str, words)))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Page, Path]:
    path = tmp_path_factory.mktemp("report")
    ran = reported(SHORT, "-o", path / "dive.html", "--map", path / "map.pdf")
    assert ran.exit_code == 0, ran.output
    return Page(path / "dive.html"), path / "map.pdf"


@pytest.mark.proof
def test_the_page_names_no_other_host(made: tuple[Page, Path]) -> None:
    page, _ = made
    assert "//" not in page.text
    assert "script" not in page.tags
    assert all(load.startswith("#") for load in page.loads)


def test_the_page_has_every_picture_and_the_whole_story(made: tuple[Page, Path]) -> None:
    page, _ = made
    captions = re.findall(r"<figcaption>(\w+)", page.text)
    assert captions == [
        *("Map", "Depth", "What", "Attitude", "Batteries", "Sensors", "Thrusters", "Fixes")
    ]
    assert page.tags.count("svg") == len(captions)
    tables = [table for one in story(recordings([SHORT])) for table in one.tables]
    assert page.tags.count("tr") == sum(len(table.rows) + 1 for table in tables)


def test_the_map_is_a_file_of_its_own_as_its_suffix_says(
    made: tuple[Page, Path], tmp_path: Path
) -> None:
    assert made[1].read_bytes().startswith(b"%PDF")
    ran = reported(SHORT, "-o", tmp_path / "p.html", "--map", tmp_path / "map.jpg")
    assert (ran.exit_code, "a .png, .pdf or .svg" in ran.output) == (2, True)
    assert not (tmp_path / "p.html").exists()


@pytest.mark.proof
def test_several_dives_are_on_one_page_in_the_order_of_their_starts(tmp_path: Path) -> None:
    ran = reported(AGAIN, HEAVY, "-o", tmp_path / "day.html", "--json")
    assert ran.exit_code == 0, ran.output
    page = Page(tmp_path / "day.html")
    heads = re.findall(r"<h2>(Dive 1 of 1|The same dive)", page.text)
    assert heads == ["Dive 1 of 1", "The same dive"]  # the program began again
    assert page.text.count("<h2>Between two recordings") == 1
    assert len(json.loads(ran.stdout)) == 2
    happened = [m.start() for m in re.finditer("<h2>What happened", page.text)]
    dives = [m.start() for m in re.finditer("<h2>(?:Dive 1|The same dive)", page.text)]
    assert sorted(happened + dives) == [dives[0], happened[0], dives[1], happened[1]]
    for more in (("-o", tmp_path / "day.pdf"), ("--pictures", tmp_path / "pictures")):
        ran = reported(AGAIN, HEAVY, *more)
        assert (ran.exit_code, "of one FILE" in ran.output) == (2, True)


@pytest.mark.parametrize(("suffix", "head"), [(".png", b"\x89PNG"), (".pdf", b"%PDF")])
def test_the_smoothed_track_alone_is_a_picture_as_its_suffix_says(
    suffix: str, head: bytes, tmp_path: Path
) -> None:
    path = tmp_path / f"track{suffix}"
    ran = reported(SHORT, "-o", path)
    assert ran.exit_code == 0, ran.output
    assert path.read_bytes().startswith(head)


def test_what_a_vehicle_does_not_report_has_no_empty_picture(tmp_path: Path) -> None:
    """Of the robot a battery alone; of the ROV neither battery, altitude nor place, but what its thrusters do."""
    rows = {"robot-drive": {"margins": 2, "batteries": 1},
            "rov-dive": {"map": 1, "depth": 1, "margins": 2, "attitude": 3, "sensors": 1,
                         "thrusters": 1}}  # fmt: skip
    for name, expected in rows.items():
        prepared, box = prepare(Path(name)), BlackBox(tmp_path / f"{name}.mcap")
        fly(prepared.mission, prepared.vehicle, seed=3, recorder=box)
        box.close()
        (items,) = recordings([box.path])
        made = {one.name: one for one in pictures_of(Dive.of(items, None))}
        assert {one.name: one.rows for one in made.values()} == expected
    assert made["map"].caption == "Map: estimated track by legs."
    axes = drawing.Figure().subplots()
    made["map"].draw([axes])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("east of home, m", "north of home, m")
    numbers = [text.get_text() for text in axes.texts]
    assert "1\u20133" in numbers, "legs on one spot do not cover one another"


def test_numbers_that_would_cover_one_another_are_told_as_one() -> None:
    assert as_runs([3, 1, 2, 5, 7, 8]) == "1\u20133, 5, 7, 8"
    assert list(along([(1.0, 1), (2.0, 2), (9.0, 3)], 2.0)) == [(1.5, "1, 2"), (9.0, "3")]
    assert list(along([(t, 1 + t % 2) for t in range(9)], 2.0)) == [(4.0, "1, 2")]
    assert list(along([], 2.0)) == []
    places = [((0.0, 0.0), 1), ((3.0, 0.0), 2), ((6.0, 1.0), 3), ((0.0, 4.0), 4), ((9.0, 0.0), 5)]
    assert list(around(places, 100.0)) == [
        ((0.0, 0.0), "1\u20133"), ((0.0, 4.0), "4"), ((9.0, 0.0), "5")
    ]  # fmt: skip


def test_what_happened_stands_before_the_pictures(made: tuple[Page, Path]) -> None:
    page, _ = made
    assert (
        page.text.index("<h2>What happened") < page.text.index("<svg") < page.text.index("<h2>Legs")
    )
    assert re.search(r"<h1>.+, auv, \d{4}-\d\d-\d\d \d\d:\d\d UTC</h1>", page.text)


@pytest.mark.proof
def test_every_picture_of_a_dive_is_a_png_and_a_pdf(tmp_path: Path) -> None:
    ran = reported(SHORT, "-o", tmp_path / "p.html", "--pictures", tmp_path / "pictures")
    assert ran.exit_code == 0, ran.output
    made = sorted((tmp_path / "pictures").iterdir())
    names = ["attitude", "batteries", "depth", "fixes", "map", "margins", "sensors", "thrusters"]
    assert [path.name for path in made] == [f"{n}.{form}" for n in names for form in ("pdf", "png")]
    for path in made:
        head = {".pdf": b"%PDF", ".png": b"\x89PNG"}[path.suffix]
        assert path.read_bytes().startswith(head)
        assert str(path) in ran.stdout


@pytest.mark.proof
def test_the_page_of_a_simulation_says_its_sea_and_its_seed(tmp_path: Path) -> None:
    mission = tmp_path / "hop.mission"
    mission.write_text(HOP)
    words = [mission, "--seed", "7", "--set", "current=0.1@90", "--report", tmp_path / "out"]
    ran = CliRunner().invoke(simulate, list(map(str, words)))
    assert ran.exit_code == 0, ran.output
    page = Page(tmp_path / "out" / "report.html")
    says = "simulated, current 0.1 m/s towards 90 deg, floor at 30 m, set current=0.1@90, seed 7"
    assert f"<p>flight.mcap, {says}</p>" in page.text
    assert re.search(rf"<figcaption>Map: [^<]*\({says}\)", page.text)
    assert "<h1>hop, auv, 2025-06-01 08:00 UTC</h1>" in page.text


def test_metadata_of_a_file_that_is_open_or_damaged_are_none(tmp_path: Path) -> None:
    (items,) = recordings([SHORT])
    box = BlackBox(tmp_path / "short.mcap")
    for item in items[:50]:
        assert isinstance(item, Record)
        box.record(item)
    box.close()
    path = box.path
    assert notes_of(path) == {}, "nobody closed it yet"
    close_recording(path, {"seed": "7"})
    assert notes_of(path)["seed"] == "7"
    data = path.read_bytes()
    for cut in (0, 5, 12, 40, 80):
        path.write_bytes(data[:cut])
        assert notes_of(path) == {}
    path.write_bytes(data[:40] + bytes(200) + data[240:])
    assert notes_of(path) == {}
    assert notes_of(tmp_path / "none.mcap") == {}


@pytest.fixture(scope="module")
def drawn() -> tuple[Any, Dive]:
    (items,) = recordings([SHORT])
    dive, figure = Dive.of(items, None), drawing.Figure(figsize=(8.5, 6.5))
    draw_map(figure.subplots(), dive)
    return figure, dive


@pytest.mark.parametrize(("offset", "named"), [(0.0, True), (500.0, False)])
def test_home_is_in_the_legend_where_it_is_on_the_map(offset: float, named: bool) -> None:
    (items,) = recordings([SHORT])
    dive, axes = Dive.of(items, None), drawing.Figure().subplots()
    dive.fixes, dive.plan, dive.smoothed, dive.covariances = [], [], None, []
    dive.states = [{**s, "north_m": n + offset} for s in dive.states if (n := s["north_m"])]
    draw_map(axes, dive)
    assert ("home" in axes.get_legend_handles_labels()[1]) is named


def test_the_track_fills_the_map_and_no_ellipse_buries_it(drawn: tuple[Any, Dive]) -> None:
    figure, dive = drawn
    (axes,) = figure.axes
    places = np.array([(s["east_m"], s["north_m"]) for s in dive.states if s["east_m"] is not None])
    spread = float(np.max(np.ptp(places, axis=0)))
    sides = [float(np.ptp(limits)) for limits in (axes.get_xlim(), axes.get_ylim())]
    width = max(sides)
    assert spread < width < 1.3 * max(spread, 10.0), "it fills the long side"
    assert min(sides) >= 0.6 * width - 1e-6
    for low, high, at in ((*axes.get_xlim(), places[:, 0]), (*axes.get_ylim(), places[:, 1])):
        assert np.all((low < at) & (at < high))
    assert all(2.0 * max(p.get_width(), p.get_height()) <= width for p in axes.patches)
    assert len(axes.patches) <= 10


@pytest.mark.parametrize(("length_m", "beyond"), [(8.0, False), (900.0, True)])
def test_the_track_fills_the_map_of_a_dive_that_ended_early(length_m: float, beyond: bool) -> None:
    (items,) = recordings([SHORT])
    dive, axes = Dive.of(items, None), drawing.Figure().subplots()
    assert dive.origin is not None
    latitude, longitude = dive.origin.latitude_deg, dive.origin.longitude_deg
    far = [longitude, latitude + math.degrees(length_m / 6_371_000.0)]
    dive.plan = [feature("goto", [[longitude, latitude], far])]
    draw_map(axes, dive)
    flown = flown_of(dive)
    long = max(10.0, float(np.max(np.ptp(flown, axis=0))))
    assert np.ptp(axes.get_ylim()) < 2.6 * long, "half of it on each side, and the margin"
    assert ("goes on beyond" in map_of(dive).caption) is beyond


def test_where_nothing_is_known_of_the_track_the_whole_plan_fills_the_map() -> None:
    plan = [(0.0, 0.0), (0.0, 900.0)]
    assert near([], plan) == plan
    assert near([(0.0, 0.0), (0.0, 100.0)], plan) == [(0.0, 0.0), (0.0, 150.0)]


@pytest.mark.parametrize("corner", [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)])
def test_the_scale_stands_where_no_track_is(corner: tuple[float, float]) -> None:
    axes = drawing.Figure().subplots()
    axes.set_xlim(-100.0, 100.0)
    axes.set_ylim(-100.0, 100.0)
    shown = [(corner[0] * at, corner[1] * at) for at in np.linspace(50.0, 95.0, 20)]
    _scale(axes, 200.0, shown)
    (bar,) = axes.lines
    for east, north in zip(*bar.get_data(), strict=True):
        assert all(np.hypot(east - e, north - n) > 30.0 for e, n in shown)


def test_scale_graticule_and_every_leg_are_on_the_map(drawn: tuple[Any, Dive]) -> None:
    figure, dive = drawn
    (axes,) = figure.axes
    (scale,) = [text for text in axes.texts if text.get_text().endswith(" m")]
    bars = [np.ptp(line.get_xdata()) for line in axes.lines if line.get_linewidth() == 3.0]
    assert any(length == pytest.approx(float(scale.get_text()[:-2])) for length in bars)
    (north,) = [text for text in axes.texts if text.get_text() == "N"]
    assert north.xy[1] > north.xyann[1], "the arrow leads up"
    assert north.arrow_patch.get_arrowstyle().arrow == "->"
    assert dive.origin is not None
    for axis, middle in (
        (axes.yaxis, dive.origin.latitude_deg),
        (axes.xaxis, dive.origin.longitude_deg),
    ):
        degrees = [float(label.get_text().split("\u00b0")[0]) for label in axis.get_ticklabels()]
        assert 2 <= len(degrees) <= 6
        metres = list(axis.get_ticklocs())
        at = [abs(middle) + m * (degrees[1] - degrees[0]) / (metres[1] - metres[0]) for m in metres]
        assert at == pytest.approx(degrees, abs=1e-6)
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    assert all(any(leg in row for row in legend) for leg in {s.leg for s in dive.stays()})


def test_the_caption_of_the_map_names_a_plan_only_where_a_leg_steers_to_places() -> None:
    dive = Dive(load_vehicle("auv"), 0.0, origin=Position(30.0, 120.0))
    dive.plan = [feature("radius", [[120.0, 30.0], [120.001, 30.0]])]
    assert "plan" not in map_of(dive).caption
    dive.plan.append(feature("goto", [[120.0, 30.0], [120.0, 30.001]]))
    assert map_of(dive).caption.startswith("Map: plan, estimated track by legs.")


def feature(name: str, places: list[list[float]]) -> dict[str, Any]:
    form = {"type": "LineString", "coordinates": places}
    return {"geometry": form, "properties": {"name": name, "what": name}}


def test_a_depth_that_was_not_to_be_believed_is_hatched_and_the_caption_says_so() -> None:
    dive = Dive(load_vehicle("auv"), 0.0)
    dive.states = [
        {"t": t, "depth_m": 2.0, "leg": "dive", "north_m": None}
        | dict.fromkeys(("to_depth_m", "to_radius_m", "to_time_s", "to_voltage_v"))
        for t in (0.0, 50.0, 100.0)
    ]
    dive.telemetry = []
    (depth, *_) = pictures_of(dive)
    assert (depth.name, hatched(depth)) == ("depth", [])
    assert "Hatched" not in depth.caption
    dive.spells = [Spell("depth", 20.0, 60.0, "frozen"), Spell("heading", 5.0, 9.0, "frozen")]
    (depth, *_) = pictures_of(dive)
    assert hatched(depth) == [(20.0, 60.0)]
    assert "Hatched: it was not to be believed." in depth.caption


def test_pictures_words_and_story_tell_the_same_of_sensors_that_fell_silent() -> None:
    items = [item for item in recordings([SHORT])[0] if not is_reported_after(item, 150.0)]
    dive = Dive.of(items, None)
    told = figures(dive)
    assert told is not None
    stale = [one for one in told["sensors"] if one["sensor"] == "depth"]
    assert [one["reason"] for one in stale] == ["stale"]
    spell = stale[0]["begin_s"], stale[0]["end_s"]
    assert spell[0] <= 150.0 < stale[0]["noticed_s"] < spell[1], "since the last report"
    pictures = {picture.name: picture for picture in pictures_of(dive)}
    assert hatched(pictures["depth"]) == [pytest.approx(spell)]
    assert pytest.approx(spell) in bars(pictures["fixes"])
    assert f"depth      stale from {spell[0]:.0f} to {spell[1]:.0f} s" in track_words(dive)
    (sensors,) = [one for one in story([items]) if one.title == "Sensors"]
    assert ("depth", "stale", clock(spell[0]), clock(spell[1])) in {
        (*row[:3], row[4]) for row in sensors.tables[0].rows
    }


def is_reported_after(item: object, t: float) -> bool:
    if not isinstance(item, Record) or item.kind != RX:
        return False
    rx = read_rx(item)
    return rx.link == VEHICLE and rx.t > t


def bars(picture: Picture) -> list[tuple[float, float]]:
    """From and to, of the last axes."""
    axes = drawing.Figure().subplots(picture.rows, 1)
    picture.draw(axes)
    bars = (patch for patch in axes[-1].patches if isinstance(patch, patches.Rectangle))
    return [(one.get_x(), one.get_x() + one.get_width()) for one in bars]


def hatched(picture: Picture) -> list[tuple[float, float]]:
    axes = drawing.Figure().subplots(1, 1)
    picture.draw([axes])
    return [
        (patch.get_x(), patch.get_x() + patch.get_width())
        for patch in axes.patches
        if patch.get_hatch()
    ]


@pytest.mark.proof
def test_a_recording_without_a_fix_has_a_page_and_says_so(tmp_path: Path) -> None:
    (items,) = recordings([SHORT])
    box = BlackBox(tmp_path / "dry.mcap")
    assert isinstance(items[0], Record)
    box.record(items[0])
    box.record(tx_record(Tx(1.0, "vehicle", b"@ZAX0$", "<script>$x_$</script>")))
    box.close()
    ran = reported(box.path)
    assert ran.exit_code == 0, ran.output
    assert "there is no fix" in ran.stdout
    page = Page(tmp_path / "dry.html")
    assert "there is no fix" in page.text
    assert "script" not in page.tags
    assert reported(box.path, "-o", tmp_path / "dry.png").exit_code == 2


def test_a_heading_about_north_is_drawn_as_one_line() -> None:
    north = np.array([359.0, 1.0, np.nan, 358.0])
    assert np.array_equal(unbroken(north), [-1.0, 1.0, np.nan, -2.0], equal_nan=True)
    south = np.array([179.0, 181.0])
    assert np.array_equal(unbroken(south), south)
    assert np.isnan(unbroken(np.array([np.nan]))).all()


def test_a_leg_is_coloured_to_its_end_and_not_to_the_next_report() -> None:
    (items,) = recordings([SHORT])
    dive = Dive.of(items, None)
    rows = next(one for one in story([items]) if one.title == "Legs").tables[0].rows
    assert [clock(stay.begin) for stay in dive.stays()] == [
        row[1] for row in rows[: len(dive.stays())]
    ]
    last = dive.stays()[-1]
    assert round(last.end - last.begin, 1) == float(rows[len(dive.stays()) - 1][2].split()[0])
    assert last.end < dive.states[-1]["t"] - 5.0, "the emergency is no leg"


def test_the_margins_are_scaled_by_the_limits_in_force_and_not_by_those_of_before() -> None:
    (items,) = recordings([SHORT])
    dive = Dive.of(items, None)
    dive.states[0] = {**dive.states[0], "to_depth_m": 100.0}  # before the mission's limits came
    picture = next(one for one in pictures_of(dive) if one.name == "margins")
    axes = drawing.Figure().subplots(picture.rows, 1)
    picture.draw(axes)
    assert axes[0].get_ylim()[1] < 1.2 * dive.standing[-1].depth


def test_twelve_legs_have_twelve_colours() -> None:
    marks = marks_of([Stay(f"leg{n}", n, n + 1.0) for n in range(12)])
    assert len({mark.colour for mark in marks.values()}) == 12


def test_neither_legend_nor_arrow_lies_on_what_is_drawn(drawn: tuple[Any, Dive]) -> None:
    figure, dive = drawn
    (axes,) = figure.axes
    (north,) = [text for text in axes.texts if text.get_text() == "N"]
    assert north.xy[0] > 1.0, "beside the map"
    picture = next(one for one in pictures_of(dive) if one.name == "fixes")
    three = drawing.Figure().subplots(picture.rows, 1)
    picture.draw(three)
    box = three[1].get_legend().get_bbox_to_anchor().transformed(three[1].transAxes.inverted())
    assert box.y0 == pytest.approx(1.0), "above the axes"


def test_a_line_of_depths_is_parted_where_no_report_came() -> None:
    t, depth = parted(np.array([0.0, 2.0, 10.0]), np.array([1.0, 2.0, 3.0]))
    assert np.array_equal(depth, [1.0, 2.0, np.nan, 3.0], equal_nan=True)
    assert list(t) == [0.0, 2.0, 10.0, 10.0]


def test_depths_that_were_not_to_be_believed_are_no_dots_and_no_residuals() -> None:
    dive = Dive(load_vehicle("auv"), 0.0, spells=[Spell("depth", 4.1, 8.1, "absurd")])
    dive.telemetry = [{"t": float(t), "depth_m": 1.0} for t in range(0, 12, 2)]
    assert [one["t"] for one in reports_of_depth(dive)] == [0.0, 2.0, 8.0, 10.0]
    dive.spells = [Spell("depth", 4.1, 10.1, "absurd")]  # as the recording ends
    assert [one["t"] for one in reports_of_depth(dive)] == [0.0, 2.0]


def test_what_each_thruster_reported_is_a_picture() -> None:
    (items,) = recordings([SHORT])
    dive = Dive.of(items, None)
    picture = next(one for one in pictures_of(dive) if one.name == "thrusters")
    axes = drawing.Figure().subplots()
    picture.draw([axes])
    assert [text.get_text() for text in axes.get_legend().get_texts()] == thrusters_of(dive)
    assert max(float(np.nanmax(line.get_ydata())) for line in axes.lines) > 30.0


def test_a_dive_in_several_recordings_is_one_dive() -> None:
    one, other, third = (
        Dive(load_vehicle("auv"), float(n), missions={"hop": None}) for n in range(3)
    )
    assert day([one, other]).startswith("2 dives, ")
    assert _heading([one, other], 2).startswith("Dive 2 of 2: hop")
    other.goes_on, other.missions = True, {}
    assert day([one, other]).endswith(", in 2 recordings")
    assert _heading([one, other, third], 2).startswith(
        "The same dive, after the program began again"
    )
    assert _heading([one, other, third], 3).startswith("Dive 2 of 2: hop")


def test_no_line_of_a_page_breaks_a_frame() -> None:
    said = Chapter("T", ("@ZAH-90,8$ took all <b>",), (Table(("frame",), (("@ZAX0$",),)),))
    page = as_html("t", [said])
    assert "<code>@ZAH-90,8$</code> took all &lt;b&gt;" in page
    assert "<td><code>@ZAX0$</code></td>" in page
    assert "code{white-space:nowrap" in page


def test_a_roll_about_the_back_is_drawn_as_one_line() -> None:
    assert list(unbroken(np.array([178.0, -179.0]))) == [178.0, 181.0]
