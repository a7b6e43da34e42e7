"""Laws of the report: one file that needs no other, with all that happened, of one dive or many."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from matplotlib.figure import Figure

from mission.analysis.journal import recordings
from mission.analysis.report.dive import Dive
from mission.analysis.report.map import draw_map
from mission.analysis.story import story
from mission.commands.report import report
from mission.model import Record, Tx
from mission.onboard.blackbox import BlackBox
from mission.onboard.runtime.records import tx_record

RECORDED = Path(__file__).parent / "recorded"
SHORT, HEAVY, AGAIN = (
    RECORDED / f"{name}.mcap" for name in ("short-time", "heavy-then-ended", "begun-again")
)


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


def test_the_page_names_no_other_host(made: tuple[Page, Path]) -> None:
    page, _ = made
    assert "//" not in page.text
    assert "script" not in page.tags
    assert all(load.startswith("#") for load in page.loads)


def test_the_page_has_every_picture_and_the_whole_story(made: tuple[Page, Path]) -> None:
    page, _ = made
    captions = re.findall(r"<figcaption>(\w+)", page.text)
    assert captions == ["Map", "Depth", "What", "Attitude", "Batteries", "Sensors", "Fixes"]
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


def test_several_dives_are_on_one_page_in_the_order_of_their_starts(tmp_path: Path) -> None:
    ran = reported(AGAIN, HEAVY, "-o", tmp_path / "day.html", "--json")
    assert ran.exit_code == 0, ran.output
    page = Page(tmp_path / "day.html")
    assert re.findall(r"<h2>Dive (\d) of 2", page.text) == ["1", "2"]
    assert page.text.count("<h2>Between two recordings") == 1
    assert len(json.loads(ran.stdout)) == 2
    ran = reported(AGAIN, HEAVY, "-o", tmp_path / "day.png")
    assert (ran.exit_code, "of one FILE" in ran.output) == (2, True)


@pytest.fixture(scope="module")
def drawn() -> tuple[Figure, Dive]:
    (items,) = recordings([SHORT])
    dive, figure = Dive.of(items, None), Figure(figsize=(8.5, 6.5))
    draw_map(figure.subplots(), dive)
    return figure, dive


def test_the_track_fills_the_map_and_no_ellipse_buries_it(drawn: tuple[Figure, Dive]) -> None:
    figure, dive = drawn
    (axes,) = figure.axes
    places = np.array([(s["east_m"], s["north_m"]) for s in dive.states if s["east_m"] is not None])
    spread = float(np.max(np.ptp(places, axis=0)))
    width = float(np.ptp(axes.get_xlim()))
    assert spread < width
    for low, high, at in ((*axes.get_xlim(), places[:, 0]), (*axes.get_ylim(), places[:, 1])):
        assert np.all((low < at) & (at < high))
    assert all(2.0 * max(p.get_width(), p.get_height()) <= width for p in axes.patches)
    assert len(axes.patches) <= 10


def test_scale_graticule_and_every_leg_are_on_the_map(drawn: tuple[Figure, Dive]) -> None:
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
        assert len(degrees) >= 2
        metres = list(axis.get_ticklocs())
        at = [abs(middle) + m * (degrees[1] - degrees[0]) / (metres[1] - metres[0]) for m in metres]
        assert at == pytest.approx(degrees, abs=1e-6)
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    assert all(any(leg in row for row in legend) for leg in {s.leg for s in dive.stays()})


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
