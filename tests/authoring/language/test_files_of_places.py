"""`follow file ROUTE`: the places of a file, read beside the mission; only they travel."""

from __future__ import annotations

from pathlib import Path

import pytest

from mission.authoring.importing.places import beside
from mission.authoring.language import MissionErrors, digest, load, parse, parse_script, script
from mission.authoring.language.layout import formatted
from mission.authoring.prepare import Unreadable, prepare, prepare_text
from mission.model import Mission

HEAD = "mission m vehicle auv\nhome 30.2874595 120.1535765\nsafety time 30min\n"
PLACES = "30.2876 120.1537, 30.288 120.1537, 30.288 120.1545"
HELD = "within 5 depth 3 gear 6 timeout 5min"
POINTS = [(30.2876, 120.1537), (30.288, 120.1537), (30.288, 120.1545)]
FILES = {
    "r.csv": "name,lat,lon\na,30.2876,120.1537\nb,30.288,120.1537\n\nb,30.288,120.1537\n"
    "c,30.288,120.1545\n",
    "r.geojson": '{"type": "LineString", "coordinates": '
    + str([[lon, lat] for lat, lon in POINTS])
    + "}",
    "route.gpx": "<gpx><rte>"
    + "".join(f'<rtept lat="{lat}" lon="{lon}"/>' for lat, lon in POINTS)
    + "</rte></gpx>",
    "track.gpx": "<gpx><trk><trkseg>"
    + "".join(f'<trkpt lat="{lat}" lon="{lon}"/>' for lat, lon in POINTS)
    + "</trkseg></trk></gpx>",
}


def written(folder: Path, name: str, text: str, leg: str = "") -> Path:
    (folder / name).write_text(text)
    file = folder / "m.mission"
    file.write_text(f"{HEAD}go: {leg or f'follow file {name} {HELD}'}\n")
    return file


def read(file: Path) -> Mission:
    return load(file, files=beside(file))


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_places_is_the_same_as_its_places_written_out(name: str, tmp_path: Path) -> None:
    said = parse(f"{HEAD}go: follow {PLACES} {HELD}\n")
    assert digest(read(written(tmp_path, name, FILES[name]))) == digest(said)


def test_what_travels_to_the_vehicle_has_the_places_and_no_file(tmp_path: Path) -> None:
    made = read(written(tmp_path, "r.csv", FILES["r.csv"]))
    assert "file" not in " ".join(script(made))
    assert parse_script(script(made)) == made


def test_yaml_names_a_file_and_a_path_with_a_blank_stands_in_quotes(tmp_path: Path) -> None:
    file = written(tmp_path, "my route.csv", FILES["r.csv"], f'follow file "my route.csv" {HELD}')
    yaml = tmp_path / "m.yaml"
    yaml.write_text(
        "mission: m\nhome: {latitude: 30.2874595, longitude: 120.1535765}\nsafety: {time: 30 min}\n"
        "legs:\n  - go: {follow: file 'my route.csv', within: 5 m, depth: 3 m, gear: 6, "
        "timeout: 5 min}\n".replace("'", '"').replace(
            'file "my route.csv"', "'file \"my route.csv\"'"
        )
    )
    assert digest(read(yaml)) == digest(read(file))


RING = [[lon, lat] for lat, lon in [*POINTS, POINTS[0]]]
CRS = '"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}'
SHORE = "<LinearRing><coordinates>" + " ".join(f"{lon},{lat},0" for lon, lat in RING)
SHORE += "</coordinates></LinearRing>"


def kml(area: str) -> str:
    mooring = "<Placemark><Point><coordinates>120.1,30.2,0</coordinates></Point></Placemark>"
    return f"<kml><Document>{mooring}<Placemark><name>bay</name>{area}</Placemark></Document></kml>"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("r.csv", FILES["r.csv"]),
        ("r.geojson", f'{{"type": "Polygon", "coordinates": {[RING]}}}'),
        (
            "r.geojson",
            '{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, '
            f'"geometry": {{"type": "Polygon", "coordinates": {[RING]}}}}}]}}',
        ),
        ("r.geojson", f'{{"type": "MultiPolygon", "coordinates": {[[RING]]}, {CRS}}}'),
        ("r.kml", kml(f"<Polygon><outerBoundaryIs>{SHORE}</outerBoundaryIs></Polygon>")),
        ("r.kml", kml(SHORE)),
    ],
)
def test_an_area_may_come_from_a_file(name: str, text: str, tmp_path: Path) -> None:
    leg = f"cover file {name} spacing 20 gear 6 depth 3 timeout 9min"
    said = parse(f"{HEAD}go: cover {PLACES} spacing 20 gear 6 depth 3 timeout 9min\n")
    assert digest(read(written(tmp_path, name, text, leg))) == digest(said)


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        (
            "r.kml",
            kml(
                f"<Polygon><outerBoundaryIs>{SHORE}</outerBoundaryIs><innerBoundaryIs>{SHORE}"
                "</innerBoundaryIs></Polygon>"
            ),
            "an area with holes",
        ),
        ("r.kml", kml(SHORE + SHORE), "2 routes"),
        ("r.geojson", f'{{"type": "MultiPolygon", "coordinates": {[[RING], [RING]]}}}', "2 routes"),
        (
            "r.geojson",
            f'{{"type": "Polygon", "coordinates": {[RING]}, {CRS.replace("CRS84", "3857")}}}',
            "not in WGS 84",
        ),
    ],
)
def test_an_area_that_is_not_one_ring_in_degrees_is_refused(
    name: str, text: str, what: str, tmp_path: Path
) -> None:
    leg = f"cover file {name} spacing 20 gear 6 depth 3 timeout 9min"
    with pytest.raises(MissionErrors, match=what):
        read(written(tmp_path, name, text, leg))


def test_the_path_is_relative_to_the_mission(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = written(tmp_path, "r.csv", FILES["r.csv"])
    monkeypatch.chdir("/")
    assert prepare(file).mission == read(file)


def test_a_vehicle_reads_no_files() -> None:
    with pytest.raises(MissionErrors, match="files of places are read where the mission is a file"):
        parse_script(f"{HEAD}go: follow file /etc/passwd {HELD}".splitlines())
    with pytest.raises(Unreadable, match="read where the mission is a file"):
        prepare_text(f"{HEAD}go: follow file r.csv {HELD}\n", "m.mission")


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("r.csv", "lat,lon\n30.1,120.1\n30.1,x\n", "r.csv:3: longitude is no number: 'x'"),
        ("r.csv", "lat,lon\n120.1,30.1\n", "r.csv:2: latitude 120.1 is beyond 90 degrees"),
        ("r.csv", "a,b\n30.1,120.1\n", "r.csv:1: no columns latitude and longitude"),
        ("r.csv", "lat,lon\n30.1\n", "r.csv:2: longitude is no number"),
        ("r.csv", "lat,lon\n30,1,120,1\n", "r.csv:2: 4 columns, and the first line names 2"),
        ("r.csv", "lat,lon\n30," + "5" * 200_000, "r.csv:2: no table: field larger than"),
        ("r.geojson", f'{{"type": "Polygon", "coordinates": {[RING, RING]}}}', "with holes"),
        ("r.geojson", '{"type": "Polygon", "coordinates": []}', "without corners"),
        ("r.doc", "", "its suffix '.doc' is no format's"),
        ("r.gpx", "<gpx></gpx>", "there is no route in it"),
        ("r.gpx", "<gpx><rte>", "r.gpx"),
    ],
)
def test_what_is_wrong_with_the_file_is_told_with_its_line(
    name: str, text: str, told: str, tmp_path: Path
) -> None:
    with pytest.raises(MissionErrors) as error:
        read(written(tmp_path, name, text))
    assert told in str(error.value)
    assert error.value.diagnostics[0].where.line == 4


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    file = written(tmp_path, "r.csv", "", f"follow file none.csv {HELD}")
    with pytest.raises(MissionErrors, match=r"none\.csv: cannot be read"):
        read(file)


def test_more_places_than_a_leg_has_are_refused_with_their_number(tmp_path: Path) -> None:
    rows = "".join(f"30.{k:04d},120.1\n" for k in range(1000, 1600))
    with pytest.raises(MissionErrors, match=r"r\.csv has 600 places: more than 500 places"):
        read(written(tmp_path, "r.csv", f"lat,lon\n{rows}"))


def test_one_place_is_no_route(tmp_path: Path) -> None:
    with pytest.raises(MissionErrors, match="needs several places"):
        read(written(tmp_path, "r.csv", "lat,lon\n30.1,120.1\n"))


@pytest.mark.parametrize(
    "path", ["route(1),b.csv", '"route(1)  b.csv"', '"rows #3.csv"', "a<b>c.csv", '"c (d) : e.csv"']
)
def test_fmt_leaves_the_path_of_a_file_as_it_is(path: str, tmp_path: Path) -> None:
    leg = f"follow  file   {path}   {HELD}   until depth>3"
    file = written(tmp_path, path.strip('"'), FILES["r.csv"], leg)
    tidy = formatted(file.read_text() + "# the end\n")
    assert tidy.splitlines()[-2:] == [
        f"go: follow file {path} {HELD} until depth > 3",
        "# the end",
    ]
    assert formatted(tidy) == tidy
    before = read(file)
    file.write_text(tidy)
    assert read(file) == before
