"""Charts that others drew: electronic charts of S-57 and the coasts of the world, read by GDAL."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from enc_cell import enc_cell
from later import installed
from programs import run

from mission.console.charts import world
from mission.console.charts.enc import convert
from mission.console.charts.layer import ChartError
from mission.console.charts.shelf import Shelf, read_chart
from mission.console.charts.world import NAME, read_world

installed("pyogrio", "pip install 'auvmission[chart]'")
installed("shapely", "pip install 'auvmission[chart]'")
SOUTH, WEST = 60.0, 25.0


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    path = tmp_path / "CELL.000"
    path.write_bytes(enc_cell(SOUTH, WEST))
    return path


@pytest.mark.proof
def test_an_electronic_chart_becomes_shapes_with_their_depths(cell: Path) -> None:
    out = cell.with_suffix(".geojson")
    ran = run("chart", str(cell), "-o", str(out))
    assert ran.exit_code == 0
    told = "CELL.000, 1 : 12000, depths below lowest astronomical tide: 1 land, 1 depth area, "
    assert told + "1 depth contour, 1 coast, 1 sounding, 1 wreck\n" in ran.output
    shown = {
        (one["form"], one["name"], one["depth"], one["deeper"])
        for one in json.loads(read_chart(out).data)
    }
    assert shown == {
        ("area", "Cape", None, None),
        ("area", "", 5.0, 12.0),
        ("line", "", 5.0, None),
        ("line", "", None, None),
        ("point", "", 7.3, None),
        ("point", "wreck", 4.2, None),
    }


@pytest.mark.proof
def test_the_places_of_an_electronic_chart_are_kept_to_a_centimetre(cell: Path) -> None:
    by_class = {f["properties"]["class"]: f["geometry"] for f in convert(cell).geojson["features"]}
    assert by_class["WRECKS"]["coordinates"] == [WEST + 0.003, SOUTH + 0.002]
    assert by_class["SOUNDG"]["coordinates"] == [WEST + 0.005, SOUTH + 0.005]
    (ring,) = by_class["DEPARE"]["coordinates"]
    assert {(WEST, SOUTH), (WEST, SOUTH + 0.01), (WEST + 0.01, SOUTH)} <= {tuple(p) for p in ring}


@pytest.mark.parametrize(
    ("more", "says"),
    [({"horizontal": 1}, "DSPM_HDAT is 1, not 2"), ({"units": 3}, "DSPM_DUNI is 3, not 1")],
)
def test_a_chart_in_other_places_or_units_than_ours_is_refused(
    tmp_path: Path, more: dict[str, int], says: str
) -> None:
    cell = tmp_path / "OLD.000"
    cell.write_bytes(enc_cell(SOUTH, WEST, **more))
    with pytest.raises(ChartError, match=says):
        convert(cell)


@pytest.mark.proof
def test_what_is_no_electronic_chart_is_refused_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "no.000").write_bytes(b"nothing of the kind")
    ran = run("chart", str(tmp_path / "no.000"))
    assert ran.exit_code == 2
    assert "no.000" in ran.output


def _with(at: int, byte: int) -> bytes:
    whole = enc_cell(SOUTH, WEST)
    return whole[:at] + bytes([byte]) + whole[at + 1 :]


DAMAGED = {
    "cut after the header": enc_cell(SOUTH, WEST)[:1193],
    "ring that does not close": _with(2099, 66),
    "letters of no alphabet": _with(1277, 197),
}


@pytest.mark.parametrize("body", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_electronic_chart_is_refused_with_its_name(tmp_path: Path, body: bytes) -> None:
    cell = tmp_path / "HURT.000"
    cell.write_bytes(body)
    with pytest.raises(ChartError, match=r"HURT\.000: "):
        convert(cell)


@pytest.mark.proof
def test_a_chart_that_ends_its_reader_costs_itself_alone_and_is_named(
    tmp_path: Path, cell: Path
) -> None:
    hurt, out = tmp_path / "DEADLY.000", tmp_path / "out.geojson"
    hurt.write_bytes(_with(1578, 0))  # GDAL 3.12 reads beyond its memory
    ran = run("chart", str(hurt), str(cell), "-o", str(out))
    assert ran.exit_code == 2
    assert "DEADLY.000: " in ran.output
    assert "fetch the cell again" in ran.output
    assert "CELL.000, 1 : 12000" in ran.output
    assert len(json.loads(out.read_text())["features"]) == 6


@pytest.mark.proof
def test_several_charts_become_one_file(tmp_path: Path, cell: Path) -> None:
    other = tmp_path / "OTHER.000"
    other.write_bytes(enc_cell(SOUTH + 1, WEST))
    ran = run("chart", str(cell), str(other))
    assert ran.exit_code == 0
    shapes = json.loads(ran.stdout)["features"]
    assert len(shapes) == 12
    assert str(shapes[-1]["geometry"]["coordinates"]).startswith("[25.003, 61.002")


@pytest.mark.proof
def test_what_cannot_be_made_out_of_an_electronic_chart_is_told_in_one_line(tmp_path: Path) -> None:
    cell = tmp_path / "HURT.000"
    cell.write_bytes(_with(2944, 82))  # an attribute that S-57 has not
    ran = run("chart", str(cell), "-o", str(tmp_path / "out.geojson"))
    assert ran.exit_code == 0
    assert "HURT.000: not all could be made out: Illegal feature attribute id" in ran.output
    assert "RuntimeWarning" not in ran.output


@pytest.mark.proof
def test_the_coasts_of_the_world_lie_under_all_charts_and_say_how_far_off_they_are(
    tmp_path: Path, cell: Path
) -> None:
    coasts = read_world()
    assert coasts is not None
    lines = [one["at"][0] for one in json.loads(coasts.data)]
    corners = [place for line in lines for place in line]
    # Cape Agulhas, Gibraltar, Hawaii: within what they may be off, and a bit
    for latitude, longitude in ((-34.8, 20.0), (36.1, -5.4), (19.6, -155.5)):
        assert any(abs(x - longitude) < 1 and abs(y - latitude) < 1 for x, y in corners)
    assert all(abs(x) < 180 for x, _ in corners)  # the map's edge is no coast
    run("chart", str(cell), "-o", str(tmp_path / "cell.geojson"))
    told = Shelf(tmp_path, (tmp_path / "cell.geojson",), coasts).as_objects()
    assert [one["name"] for one in told] == [NAME, "cell.geojson"]
    assert told[0]["off_m"] == world.OFF_M


def test_where_there_is_no_outline_the_console_goes_without(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(world, "WITHIN", "nowhere.shp")
    assert read_world() is None
    assert Shelf(tmp_path, (), None).as_objects() == []
