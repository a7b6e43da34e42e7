"""Charts of the user: what is read, what is refused and why, and what the page gets of it."""

from __future__ import annotations

import gzip
import io
import json
import sqlite3
import struct
import tempfile
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from console_world import Console
from PIL import Image
from pmtiles.tile import Compression, TileType, zxy_to_tileid
from pmtiles.writer import Writer

from mission.console.charts import layer, shapes, tiles
from mission.console.charts.layer import ChartError, Layer
from mission.console.charts.shelf import FILE, Shelf, read_chart

GRID = "ncols 3\nnrows 2\nxllcorner 24\nyllcorner 60\ncellsize 0.5\nNODATA_value -9999\n"
CORNERS = {
    "top_left": {"latitude": 60.2, "longitude": 24.8},
    "top_right": {"latitude": 60.2, "longitude": 25.0},
    "bottom_right": {"latitude": 60.1, "longitude": 25.0},
    "bottom_left": {"latitude": 60.1, "longitude": 24.8},
}


def picture(kind: str = "PNG") -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (40, 20), (10, 90, 160)).save(out, kind)
    return out.getvalue()


def feature(kind: str, coordinates: Any, **has: Any) -> dict[str, Any]:
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "geometry": geometry, "properties": has}


def geojson(path: Path, *features: object, **more: object) -> Layer:
    said = {"type": "FeatureCollection", "features": features, **more}
    path.write_text(json.dumps(said))
    return read_chart(path)


def mbtiles(path: Path, *tiles: tuple[int, int, int], **metadata: str) -> Path:
    """Of columns and rows from the south."""
    with sqlite3.connect(path) as archive:
        archive.execute("CREATE TABLE metadata (name TEXT, value TEXT)")
        archive.execute(
            "CREATE TABLE tiles (zoom_level INT, tile_column INT, tile_row INT, tile_data BLOB)"
        )
        archive.executemany("INSERT INTO metadata VALUES (?, ?)", metadata.items())
        data = [(*tile, picture() + bytes(tile)) for tile in tiles]
        archive.executemany("INSERT INTO tiles VALUES (?, ?, ?, ?)", data)
    archive.close()
    return path


def pmtiles(path: Path, kind: TileType = TileType.PNG) -> Path:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.write_tile(zxy_to_tileid(3, 4, 2), picture() + b"here")
        west, south, east, north = 0, 40_0000000, 45_0000000, 66_0000000
        head = {"tile_type": kind, "tile_compression": Compression.NONE, "min_lon_e7": west,
                "min_lat_e7": south, "max_lon_e7": east, "max_lat_e7": north,
                "center_zoom": 3, "center_lon_e7": west, "center_lat_e7": south}  # fmt: skip
        writer.finalize(head, {})
    return path


# --- what is read ---------------------------------------------------------------------------------


def test_each_form_of_geojson_is_read_with_its_name_and_its_depths(tmp_path: Path) -> None:
    ring = [[24.0, 60.0], [24.1, 60.0], [24.1, 60.1], [24.0, 60.0]]
    found = geojson(
        tmp_path / "sea.geojson",
        feature("Point", [24.05, 60.05, 7.0], DEPTH="4.5", NAME="Rock"),
        feature("MultiPoint", [[24, 60], [24.2, 60.1]], elevation=-12),
        feature("LineString", ring, valdco=10),
        feature("MultiLineString", [ring, ring]),
        feature("Polygon", [ring], DRVAL1=5, DRVAL2=10, OBJNAM="Basin"),
        feature("MultiPolygon", [[ring], [ring]]),
        {"type": "Feature", "geometry": None, "properties": {}},
    )
    told = json.loads(found.data)
    forms = [shape["form"] for shape in told]
    assert forms == ["point"] * 3 + ["line"] * 3 + ["area"] * 3
    assert (told[0]["depth"], told[0]["name"]) == (4.5, "Rock")
    assert [told[i]["depth"] for i in (1, 3, 4)] == [12.0, 10.0, None]
    assert (told[6]["depth"], told[6]["deeper"], told[6]["name"]) == (5.0, 10.0, "Basin")
    assert (found.kind, found.bounds) == ("shapes", (24.0, 60.0, 24.2, 60.1))


def test_a_grid_lies_where_its_head_says_rows_from_the_north(tmp_path: Path) -> None:
    path = tmp_path / "floor.asc"
    path.write_text(GRID + "1 2 3\n4 -9999 6\n")
    found = read_chart(path)
    depths = np.frombuffer(found.data, "<f4")
    assert found.bounds == pytest.approx((24.0, 60.0, 25.5, 61.0))
    assert depths[:4].tolist() == [1, 2, 3, 4]
    assert np.isnan(depths[4])
    assert (found.more["least"], found.more["greatest"]) == (1.0, 6.0)
    path.write_text(GRID.replace("corner 24", "corner 204") + "1 2 3\n4 5 6\n")
    assert read_chart(path).bounds == pytest.approx((-156.0, 60.0, -154.5, 61.0))


def test_heights_are_turned_to_depths_and_the_layer_says_so(tmp_path: Path) -> None:
    path = tmp_path / "gebco.asc"
    path.write_text(GRID + "-10 -20 -30\n-40 5 -9999\n")
    found = read_chart(path)
    assert np.frombuffer(found.data, "<f4")[:5].tolist() == [10, 20, 30, 40, -5]
    assert "heights, turned into depths" in found.note


def test_a_table_of_soundings_is_a_grid_of_depths(tmp_path: Path) -> None:
    path = tmp_path / "sounded.csv"
    path.write_text("latitude,longitude,depth\n60.0,24.0,5.5\n60.001,24.001,7.5\n")
    found = read_chart(path)
    assert (found.kind, found.more["least"], found.more["greatest"]) == ("depths", 5.5, 7.5)


@pytest.mark.parametrize(("kind", "suffix"), [("PNG", ".png"), ("JPEG", ".jpg"), ("WEBP", ".webp")])
def test_a_picture_lies_between_its_four_corners(tmp_path: Path, kind: str, suffix: str) -> None:
    path = tmp_path / f"scan{suffix}"
    path.write_bytes(picture(kind))
    (tmp_path / f"scan{suffix}.json").write_text(json.dumps(CORNERS))
    found = read_chart(path)
    assert found.bounds == (24.8, 60.1, 25.0, 60.2)
    assert found.media == f"image/{kind.lower()}"
    assert found.more["affine"] == pytest.approx([24.8, 0.005, 0, 60.2, 0, -0.005], abs=1e-12)


def test_a_world_file_is_of_the_middle_of_the_first_pixel(tmp_path: Path) -> None:
    path = tmp_path / "scan.png"
    path.write_bytes(picture())
    (tmp_path / "scan.pgw").write_text("0.005\n0\n0\n-0.005\n24.8025\n60.1975\n")
    assert read_chart(path).bounds == pytest.approx((24.8, 60.1, 25.0, 60.2))


def test_corners_that_are_a_little_off_are_told_and_those_that_are_far_off_refused(
    tmp_path: Path,
) -> None:
    path, beside = tmp_path / "scan.png", tmp_path / "scan.json"
    path.write_bytes(picture())
    skewed = CORNERS | {"top_right": {"latitude": 60.2, "longitude": 25.0 + 4 * 9e-5}}
    beside.write_text(json.dumps(skewed))
    assert "corners off by 5.0 m" in read_chart(path).note
    swapped = {**CORNERS, "top_left": CORNERS["top_right"], "top_right": CORNERS["top_left"]}
    beside.write_text(json.dumps(swapped))
    with pytest.raises(ChartError, match="no parallelogram"):
        read_chart(path)


def test_tiles_of_mbtiles_are_asked_for_from_the_north(tmp_path: Path) -> None:
    found = read_chart(mbtiles(tmp_path / "a.mbtiles", (3, 4, 5), (2, 2, 2), bounds="0,40,45,66"))
    assert found.tile is not None
    assert (found.tile(3, 4, 2) or b"").endswith(bytes((3, 4, 5)))
    assert found.tile(3, 4, 5) is None
    assert (found.bounds, found.more) == ((0, 40, 45, 66), {"least": 2, "greatest": 3})


def test_mbtiles_that_do_not_say_their_bounds_are_as_large_as_their_tiles(tmp_path: Path) -> None:
    found = read_chart(mbtiles(tmp_path / "a.mbtiles", (1, 1, 1)))
    assert found.bounds == pytest.approx((0, 0, 180, 85.0511), abs=1e-3)


def test_tiles_of_pmtiles_are_found(tmp_path: Path) -> None:
    found = read_chart(pmtiles(tmp_path / "a.pmtiles"))
    assert found.tile is not None
    assert (found.tile(3, 4, 2) or b"").endswith(b"here")
    assert found.tile(3, 0, 0) is None
    assert (found.bounds, found.more) == ((0, 40, 45, 66), {"least": 3, "greatest": 3})


# --- what is refused ------------------------------------------------------------------------------

BAD_SHAPES = {
    "no GeoJSON": "{",
    "type is 'Topology'": '{"type": "Topology"}',
    "crs urn:ogc:def:crs:EPSG::3067": '{"type": "FeatureCollection", "features": [], "crs": '
    '{"properties": {"name": "urn:ogc:def:crs:EPSG::3067"}}}',
    "a.geojson: latitude 6.67e": '{"type": "Point", "coordinates": [385000, 6670000]}',
    "NaN|nan. is no .longitude": '{"type": "Point", "coordinates": [24, NaN]}',
    "coordinates are missing": '{"type": "LineString"}',
    "geometry 'Circle'": '{"type": "Feature", "geometry": {"type": "Circle"}}',
    "is no .longitude, latitude.": '{"type": "LineString", "coordinates": [[1]]}',
    "no point, line or area": '{"type": "FeatureCollection", "features": []}',
}


@pytest.mark.parametrize("says", BAD_SHAPES)
def test_geojson_that_cannot_be_shown_is_refused_in_words(tmp_path: Path, says: str) -> None:
    path = tmp_path / "a.geojson"
    path.write_text(BAD_SHAPES[says])
    with pytest.raises(ChartError, match=says):
        read_chart(path)


def test_the_feature_that_is_wrong_is_named(tmp_path: Path) -> None:
    with pytest.raises(ChartError, match=r"sea.geojson: feature 2: latitude 91"):
        geojson(tmp_path / "sea.geojson", feature("Point", [0, 0]), feature("Point", [0, 91]))


def test_a_grid_that_cannot_be_shown_is_refused_in_the_words_of_the_check(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    path.write_text(GRID + "1 2 3 4 5")
    with pytest.raises(ChartError, match=r"a\.asc: 5 values, not nrows x ncols = 6"):
        read_chart(path)


BAD_PLACES = {
    "put scan.png.json with its four corners": "",
    "six numbers": "1 2 3",
    "degrees of WGS 84": "5 0 0 -5 385000 6670000",
}


@pytest.mark.parametrize("says", BAD_PLACES)
def test_a_picture_without_a_place_is_refused_in_words(tmp_path: Path, says: str) -> None:
    path = tmp_path / "scan.png"
    path.write_bytes(picture())
    if BAD_PLACES[says]:
        (tmp_path / "scan.pgw").write_text(BAD_PLACES[says])
    with pytest.raises(ChartError, match=says):
        read_chart(path)


@pytest.mark.parametrize(
    ("name", "says"),
    [("a.png", "no PNG"), ("a.mbtiles", "no MBTiles"), ("a.pmtiles", "no PMTiles"),
     ("a.geojson", "no GeoJSON|no UTF-8"), ("a.asc", r"a\.asc"), ("a.kml", "a chart ends in")],
)  # fmt: skip
def test_a_file_that_is_something_else_is_refused_in_words(
    tmp_path: Path, name: str, says: str
) -> None:
    path = tmp_path / name
    (tmp_path / "a.json").write_text(json.dumps(CORNERS))
    path.write_bytes(b"\x00\xff\xfe nothing of this kind" * 9)
    with pytest.raises(ChartError, match=says):
        read_chart(path)
    with pytest.raises(ChartError, match=r"lost\.\w+: "):
        read_chart(path.with_stem("lost"))


@pytest.mark.parametrize(
    "said",
    [
        {"crs": [1], "type": "Point", "coordinates": [1, 2]},
        {"crs": {"properties": []}, "type": "Point", "coordinates": [1, 2]},
        {"type": "Point", "coordinates": [10**400, 2]},
        feature("Point", [1, 2], depth=10**400),
    ],
)
def test_geojson_whose_values_are_no_such_things_is_refused_in_words(
    tmp_path: Path, said: Any
) -> None:
    (tmp_path / "odd.geojson").write_text(json.dumps(said))
    with pytest.raises(ChartError, match=r"^odd"):
        read_chart(tmp_path / "odd.geojson")


@pytest.mark.parametrize("row", ["'a', 'b', 'c'", "2.5, 0, 0", "3, NULL, NULL", "-3, 0, 0"])
def test_mbtiles_whose_tiles_are_at_no_place_are_refused_in_words(tmp_path: Path, row: str) -> None:
    path = mbtiles(tmp_path / "odd.mbtiles")
    with sqlite3.connect(path) as archive:
        archive.execute("DROP TABLE tiles")
        archive.execute("CREATE TABLE tiles (zoom_level, tile_column, tile_row, tile_data)")
        archive.execute(f"INSERT INTO tiles VALUES ({row}, x'00')")
    archive.close()
    with pytest.raises(ChartError, match=r"^odd"):
        read_chart(path)


def test_a_tile_that_is_too_large_is_never_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = read_chart(mbtiles(tmp_path / "a.mbtiles", (0, 0, 0)))
    assert found.tile is not None
    assert found.tile(0, 0, 0)
    monkeypatch.setattr(tiles, "MOST_TILE", 9)
    assert found.tile(0, 0, 0) is None


def test_mbtiles_that_never_come_to_an_end_are_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tiles, "LONGEST_S", 0.2)
    path = tmp_path / "endless.mbtiles"
    with sqlite3.connect(path) as archive:
        archive.execute("CREATE TABLE metadata (name TEXT, value TEXT)")
        archive.execute(
            "CREATE VIEW tiles AS WITH RECURSIVE n(zoom_level) AS "
            "(SELECT 1 UNION ALL SELECT 1 FROM n) "
            "SELECT zoom_level, 0 AS tile_column, 0 AS tile_row, x'00' AS tile_data FROM n"
        )
    archive.close()
    with pytest.raises(ChartError, match="interrupted"):
        read_chart(path)


@pytest.mark.parametrize("unpacked", [b"\0" * (64 << 20), b"\xff" * (2 << 20)])
def test_directories_of_pmtiles_that_unpack_to_much_are_not_unpacked(
    tmp_path: Path, unpacked: bytes
) -> None:
    packed = gzip.compress(unpacked)
    whole = bytearray(pmtiles(tmp_path / "a.pmtiles").read_bytes())
    whole[8:24] = struct.pack("<QQ", len(whole), len(packed))  # where the root is
    (tmp_path / "bomb.pmtiles").write_bytes(whole + packed)
    found = read_chart(tmp_path / "bomb.pmtiles")
    assert found.tile is not None
    tracemalloc.start()
    assert found.tile(3, 4, 2) is None
    assert tracemalloc.get_traced_memory()[1] < 16 << 20
    tracemalloc.stop()


def test_tiles_that_are_no_pictures_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ChartError, match="tiles of pbf: only pictures"):
        read_chart(mbtiles(tmp_path / "v.mbtiles", (0, 0, 0), format="pbf"))
    with pytest.raises(ChartError, match="tiles of MVT"):
        read_chart(pmtiles(tmp_path / "v.pmtiles", TileType.MVT))
    with pytest.raises(ChartError, match="no tile in it"):
        read_chart(mbtiles(tmp_path / "none.mbtiles"))


def test_what_is_too_large_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layer, "MOST", 10)
    with pytest.raises(ChartError, match="make tiles of it"):
        geojson(tmp_path / "a.geojson", feature("Point", [0, 0]))
    monkeypatch.undo()
    monkeypatch.setattr(shapes, "MOST_POINTS", 3)
    with pytest.raises(ChartError, match="more than 3 points"):
        geojson(tmp_path / "a.geojson", feature("MultiPoint", [[0, 0]] * 4))


def test_two_charts_of_one_name_are_refused(tmp_path: Path) -> None:
    paths = []
    for folder in ("north", "south"):
        (tmp_path / folder).mkdir()
        paths.append(tmp_path / folder / "a.geojson")
        geojson(paths[-1], feature("Point", [0, 0]))
    with pytest.raises(ChartError, match="two charts have this name"):
        Shelf(tmp_path, tuple(paths))


# --- what the page gets ---------------------------------------------------------------------------


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    geojson(tmp_path / "sea.geojson", feature("Point", [24, 60], depth=3))
    archive = mbtiles(tmp_path / "a b.mbtiles", (3, 4, 5))
    return Shelf(tmp_path, (archive, tmp_path / "sea.geojson"))


@pytest.fixture
def running(shelf: Shelf) -> Any:
    console = Console(list, shelf)
    yield console
    console.stop()


def test_the_page_gets_the_charts_their_data_and_their_tiles(running: Console) -> None:
    first, second = running.get("/api/charts")
    assert (first["name"], first["kind"], first["on"], first["opacity"]) == (
        "a b.mbtiles",
        "tiles",
        True,
        1.0,
    )
    assert running.get("/api/charts/sea.geojson")[0]["depth"] == 3.0
    status, headers, body = running.ask("/api/charts/a%20b.mbtiles/3/4/2")
    assert (status, headers["content-type"], body[:4]) == (200, "image/png", b"\x89PNG")
    for nothing in (
        "a%20b.mbtiles/3/4/3",
        "a%20b.mbtiles/3/9/9",
        "a%20b.mbtiles/99/0/0",
        "sea.geojson/0/0/0",
    ):
        assert running.ask(f"/api/charts/{nothing}")[0] == 204
    assert running.ask("/api/charts/none")[0] == 404
    assert second["note"] == "1 shapes"


@pytest.mark.parametrize(
    "path", ["/api/charts", "/api/charts/sea.geojson", "/api/charts/a%20b.mbtiles/3/4/2"]
)
def test_nobody_gets_a_chart_without_the_token(running: Console, path: str) -> None:
    assert running.ask(path, Authorization="")[0] == 403
    assert running.ask(path, {}, Authorization="")[0] == 403


def test_order_and_look_are_kept_for_the_next_time(
    running: Console, shelf: Shelf, tmp_path: Path
) -> None:
    wanted = [{"name": "sea.geojson", "on": False, "opacity": 0.4},
              {"name": "a b.mbtiles", "on": True, "opacity": 1.0}]  # fmt: skip
    assert running.get("/api/charts", wanted) == {}
    again = Shelf(tmp_path, (tmp_path / "a b.mbtiles", tmp_path / "sea.geojson")).as_objects()
    assert [{k: one[k] for k in ("name", "on", "opacity")} for one in again] == wanted
    for bad in ([{"name": "sea.geojson"}], 3, [7], b"{"):
        assert running.ask("/api/charts", bad)[0] == 400
    (tmp_path / FILE).write_text('{"sea.geojson": {"on": 3}, "a b.mbtiles": []}')
    assert [one["on"] for one in shelf.as_objects()] == [True, True]


def test_a_file_that_is_dropped_is_a_chart_and_a_picture_comes_with_its_place(
    running: Console,
) -> None:
    point = json.dumps({"type": "Point", "coordinates": [24, 60]}).encode()
    assert running.get("/api/charts/..%5Cnew.geojson", point) == {"name": "new.geojson"}
    said = running.get("/api/charts/scan.png", picture())
    assert "together with its world file" in said["says"]
    assert running.get("/api/charts/scan.png.json", json.dumps(CORNERS).encode()) == {"name": ""}
    assert running.get("/api/charts/scan.png", picture()) == {"name": "scan.png"}
    names = [one["name"] for one in running.get("/api/charts")]
    assert names == ["a b.mbtiles", "sea.geojson", "new.geojson", "scan.png"]
    assert running.ask("/api/charts/scan.png")[1]["content-type"] == "image/png"
    for bad in ("x.exe", "bad.geojson"):
        assert bad in running.get(f"/api/charts/{bad}", b"[")["says"]


def test_what_was_dropped_is_gone_with_the_console(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    shelf = Shelf(tmp_path)
    shelf.bring("a.geojson", b'{"type": "Point", "coordinates": [24, 60]}')
    assert len(list(tmp_path.glob("*/a.geojson"))) == 1
    shelf.close()
    assert not list(tmp_path.glob("*/a.geojson"))
