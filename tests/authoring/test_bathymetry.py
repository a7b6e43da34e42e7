"""Files of depths: each format as its users write it, and what is wrong with one by its line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mission.authoring.bathymetry import BathymetryError, bathymetry_of, read_bathymetry

GRID = """ncols 3
nrows 2
xllcorner 120
yllcorner 30
cellsize 0.001
NODATA_value -9999
-5 -6 -7
-8 -9999 -10
"""


def geojson(*features: tuple[dict[str, object], str, object]) -> str:
    return json.dumps(
        {
            "type": "FeatureCollection",
            "features": [
                {
                    "type": "Feature",
                    "properties": properties,
                    "geometry": {"type": kind, "coordinates": places},
                }
                for properties, kind, places in features
            ],
        }
    )


def square(west: float, south: float, side: float) -> list[list[float]]:
    east, north = west + side, south + side
    return [[west, south], [east, south], [east, north], [west, north], [west, south]]


def test_the_first_line_of_an_esri_grid_is_its_north() -> None:
    grid = bathymetry_of(GRID, "bay.asc")
    assert [grid.at(30.0015, 120.0005 + 0.001 * k) for k in range(3)] == [5.0, 6.0, 7.0]
    assert grid.at(30.0005, 120.0005) == 8.0


def test_an_esri_grid_by_its_centre_lies_half_a_cell_farther_south_west() -> None:
    centred = bathymetry_of(GRID.replace("llcorner", "llcenter"), "bay.asc")
    assert centred.at(30.001, 120.0) == 5.0


def test_between_four_cells_that_know_the_depth_lies_between() -> None:
    grid = bathymetry_of(GRID.replace("-9999\n", "-1\n").replace(" -9999 ", " -9 "), "bay.asc")
    assert grid.at(30.001, 120.001) == pytest.approx((5 + 6 + 8 + 9) / 4)


def test_no_data_and_what_is_outside_are_not_known() -> None:
    grid = bathymetry_of(GRID, "bay.asc")
    assert grid.at(30.0005, 120.0015) is None
    assert grid.at(30.01, 120.0005) is None
    assert grid.known == pytest.approx(5 / 6)


def test_heights_and_depths_of_one_floor_are_the_same() -> None:
    heights = bathymetry_of(GRID, "h.asc")
    depths = bathymetry_of(
        GRID.replace("\n-8", "\n8").replace("-5 -6 -7", "5 6 7").replace("-10", "10"), "d.asc"
    )
    assert (heights.shallow[0] == depths.shallow[0]).all()
    assert "heights" in heights.told
    assert "heights" not in depths.told


def test_land_is_a_negative_depth() -> None:
    assert bathymetry_of(GRID.replace("-5", "2"), "bay.asc").at(30.0015, 120.0005) == -2.0


def test_a_grid_may_count_its_longitudes_from_0_to_360() -> None:
    west = bathymetry_of(GRID.replace("xllcorner 120", "xllcorner 355"), "bay.asc")
    assert west.at(30.0015, -4.9995) == 5.0


def test_a_regular_survey_leaves_no_hole_between_its_soundings() -> None:
    rows = [f"{120 + i * 1e-4} {30 + j * 1e-4} {5 + i}" for i in range(12) for j in range(9)]
    assert bathymetry_of("\n".join(rows), "s.xyz").known == 1.0


def test_a_cell_keeps_its_shallowest_and_its_deepest_sounding() -> None:
    table = "lat;lon;depth\n30;120;4\n30;120;9\n30.001;120.001;5\n"
    found = bathymetry_of(table, "s.csv")
    assert {float(found.shallow[-1, 0]), float(found.deep[-1, 0])} == {4.0, 9.0}


def test_a_table_goes_by_the_names_of_its_columns() -> None:
    table = "name,depth,longitude,latitude\na,4,120,30\nb,6,120.001,30.001\n"
    assert bathymetry_of(table, "s.csv").at(30.0, 120.0) == 4.0


def test_a_unit_behind_the_name_of_a_column_is_no_part_of_it() -> None:
    table = "Latitude,Longitude,Depth (m)\n30,120,4\n30.001,120.001,6\n"
    assert bathymetry_of(table, "s.csv").at(30.0, 120.0) == 4.0


def test_depths_of_which_none_is_positive_are_heights_whatever_they_are_called() -> None:
    below = "lon,lat,depth\n120,30,-4\n120.001,30.001,-6\n"
    assert bathymetry_of(below, "s.csv").at(30.0, 120.0) == 4.0
    ashore = below + "120.002,30.002,3\n"
    assert bathymetry_of(ashore, "s.csv").at(30.0, 120.0) == -4.0


@pytest.mark.parametrize("first", ["120 30 NaN\n", "120 30 4\n"])
def test_a_sounding_that_is_nan_is_not_known(first: str) -> None:
    rows = [f"{120 + i * 1e-4} {30 + j * 1e-4} {5 + i}" for i in range(9) for j in range(9)]
    gap = "120.0004 30.0004 NaN"
    found = bathymetry_of(first + "\n".join([gap, *rows]), "s.xyz")
    assert found.at(30.0, 120.0) == (4.0 if "4" in first else 5.0)
    assert float(found.deep[-1, -1]) == 13.0


@pytest.mark.parametrize(
    ("begin", "what"),
    [
        (b"II*\0", "a GeoTIFF; write it as an ESRI ASCII grid"),
        (b"CDF\x01", "netCDF; write it as an ESRI ASCII grid"),
        (b"\x89HDF\r\n", "netCDF or a BAG; write"),
        (b"DSAA\n3 2\n", "a Surfer grid; write"),
        (b"PK\x03\x04", "a ZIP archive; unpack it first"),
    ],
)
def test_a_format_that_is_not_read_is_named_with_the_way_to_one_that_is(
    begin: bytes, what: str, tmp_path: Path
) -> None:
    file = tmp_path / "bay"
    file.write_bytes(begin + bytes(100))
    with pytest.raises(BathymetryError, match=f"bay: {what}"):
        read_bathymetry(file)


def test_an_area_of_s57_has_a_shallowest_and_a_deepest_depth_and_a_hole_is_a_hole() -> None:
    rings = [square(120, 30, 0.01), square(120.004, 30.004, 0.002)]
    found = bathymetry_of(geojson(({"DRVAL1": 5, "DRVAL2": 10}, "Polygon", rings)), "a.json")
    assert found.at(30.002, 120.002) == 5.0
    assert float(found.deep[150, 10]) == 10.0
    assert found.at(30.005, 120.005) is None


def test_soundings_and_areas_together_keep_the_shallower() -> None:
    wreck = ({}, "Point", [120.005, 30.005, 2.0])
    area = ({"depth": 8}, "Polygon", [square(120, 30, 0.01)])
    found = bathymetry_of(geojson(area, wreck), "a.json")
    assert float(found.shallow[150, 130]) == 2.0
    assert found.at(30.002, 120.002) == 8.0


def test_an_elevation_is_turned_into_a_depth_by_its_name() -> None:
    points = [({"elevation": z}, "Point", [120 + z / 1e4, 30 + z / 1e4]) for z in (3, 4, 5)]
    found = bathymetry_of(geojson(*points), "a.json")
    assert float(found.shallow[found.shallow == found.shallow].max()) <= -3.0


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "f: empty; an ESRI ASCII grid begins with ncols"),
        (GRID.replace("-8 ", "-8 x "), "f: 7 values, not nrows x ncols = 6; the first line"),
        (GRID.replace("-10", "x"), "f:8: 'x' is no number"),
        (GRID.replace("-10", "inf"), "f:8: inf is no depth; write nodata_value"),
        (GRID.replace("ncols 3", "ncols 3.5"), "f: ncols 3.5 is no number of cells"),
        (GRID.replace("cellsize", "cell"), "f:5: cell is no key"),
        (GRID.replace("xllcorner 120", "xllcorner 500000"), "gdalwarp -t_srs EPSG:4326"),
        (GRID.replace("cellsize 0.001\n", ""), "f: no dx or cellsize"),
        ("ncols 9999\nnrows 9999\n", "f: 9,999 x 9,999 cells are more than 4,000,000"),
        ("1,2,3", "f:1: nothing says which column is which"),
        ("lat,lon,depth\n1,2\n", "f:2: 2 columns are too few; write lat, lon, depth"),
        ("lat,lon,temp\n1,2,3\n", "f:1: no column depth or z"),
        ("{", "f: no JSON"),
        ("{}", "f: features[0]: no feature of GeoJSON"),
        (geojson(({}, "Point", [1, 2])), "f: features[0]: Point without a depth"),
        (geojson(({}, "Polygon", [square(1, 2, 1)])), "features[0]: an area without a depth"),
        (
            geojson(({"depth": 1}, "Point", [1, 2]), ({"height": -1}, "Point", [1, 2])),
            "f: some features name depths, others heights",
        ),
        (GRID.replace("-9999\n-5", "-7\n-5").replace("-5 -6 -7", "-7 -7 -7").replace("-8 -9999 -10", "-7 -7 -7"),
         "f: no cell of it knows a depth"),
    ],
)  # fmt: skip
def test_what_is_no_bathymetry_is_told_where_and_what_instead(text: str, told: str) -> None:
    with pytest.raises(BathymetryError) as error:
        bathymetry_of(text, "f")
    assert told in str(error.value)


def test_a_file_that_is_not_there_is_told_by_its_name(tmp_path: Path) -> None:
    with pytest.raises(BathymetryError, match=r"none\.asc: No such file"):
        read_bathymetry(tmp_path / "none.asc")


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    file = tmp_path / "s.csv"
    file.write_text("\ufefflat,lon,depth\n30,120,4\n30.1,120.1,6\n", encoding="utf-8")
    assert read_bathymetry(file).at(30.0, 120.0) == 4.0


def test_a_bank_that_is_smaller_than_a_cell_is_not_lost() -> None:
    bank = square(120.05005, 30.05005, 0.0002)
    sea = square(120.0, 30.0, 0.1)
    grid = bathymetry_of(
        geojson(({"depth": 20}, "Polygon", [sea]), ({"depth": 2}, "Polygon", [bank])), "bay.json"
    )
    assert grid.shallow.min() == 2.0
    assert grid.known == 1.0


@pytest.mark.parametrize("unknown", ["-32768", "32767", "-3.4e38", "1e20"])
def test_what_no_sea_and_no_mountain_has_is_no_depth(unknown: str) -> None:
    with pytest.raises(BathymetryError, match=r"is no depth.*nodata_value"):
        bathymetry_of(GRID.replace("-8 -9999", f"-8 {unknown}"), "bay.asc")


@pytest.mark.parametrize(
    "text",
    [
        '{"type": "Point", "coordinates": [120, 30, 1' + "0" * 400 + "]}",
        '{"type": "Point", "coordinates": [120, 30, 1' + "0" * 5000 + "]}",
        '{"type": "Point", "coordinates": [1' + "0" * 400 + ", 30, 5]}",
        '{"type": "Point", "coordinates": [120, 30, NaN]}',
        '{"type": "MultiPoint", "coordinates": [[120, 30, 5], [120, 30, Infinity]]}',
        "lat,lon,depth\n30,120," + "5" * 200_000,
        "lat,lon,depth" + "h" * 200_000 + "\n30,120,5",
    ],
    ids=range(7),
)
def test_numbers_that_no_file_of_depths_has_are_refused(text: str) -> None:
    with pytest.raises(BathymetryError):
        bathymetry_of(text, "bay")
