"""Laws of exports: the readers of others get every value back, and no text becomes more than that."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from later import Later
from recorded_flight import recorded

from mission.analysis.export import FORMS
from mission.analysis.export.columns import ExportError, sheets
from mission.analysis.export.gpx import gpx
from mission.analysis.export.kml import kml
from mission.analysis.export.places import Places, Plan
from mission.analysis.journal import Line, Wanted, lines, recordings
from mission.authoring.importing import Findings, format_of, load
from mission.commands.export import export
from mission.model import Record, Tx
from mission.onboard.blackbox import BlackBox
from mission.onboard.runtime.records import tx_record
from mission.onboard.stream.topics import TOPICS

pandas, parquet, shapely = Later("pandas"), Later("pyarrow.parquet"), Later("shapely")
gpxpy, fastkml, tracks = Later("gpxpy"), Later("fastkml"), Later("fastkml.gx")
features, utils, geometry = (
    Later("fastkml.features"),
    Later("fastkml.utils"),
    Later("shapely.geometry"),
)
SHORT = Path(__file__).parent / "recorded" / "short-time.mcap"
HOSTILE = (
    "=1+1", "+1", "-1", "@SUM(A1)", "\t=1", " =1", "'=1", "\uff1d1", "a;=1", 'a"b,c', "a\r\nb",
    "\x00", "\\x00", "\x1b[2J", "\u202e", "\ud800", "</name><x>", "", "plain",
)  # fmt: skip


def exported(*words: str | Path) -> Result:
    return CliRunner().invoke(export, list(map(str, words)))


@pytest.fixture(scope="module")
def box(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("export") / "survey.mcap", "lawnmower.yaml")


@pytest.fixture(scope="module")
def said(box: Path) -> dict[str, list[Line]]:
    """What the black box itself says, by topic."""
    (items,) = recordings([box])
    found: dict[str, list[Line]] = {}
    for line in lines(items, Wanted(frozenset(TOPICS))):
        found.setdefault(line.topic, []).append(line)
    return found


@pytest.fixture(scope="module")
def folder(box: Path) -> Path:
    out = box.parent / "out"
    forms = (word for form in FORMS for word in ("--as", form))
    ran = exported(box, "-o", out, *forms)
    assert ran.exit_code == 0, ran.output
    assert sorted(ran.stdout.splitlines()) == sorted(map(str, (out / "survey").iterdir()))
    return out / "survey"


def flat(value: object, name: str = "") -> dict[str, object]:
    """A value's fields by their columns; by its own rule, not the program's."""
    if isinstance(value, dict) and name not in ("configuration", "vehicle"):
        made: dict[str, object] = {}
        for key, one in value.items():
            made |= flat(one, f"{name}_{key}".strip("_"))
        return made
    return {name: value}


def unescaped(text: str) -> str:
    text = text.removeprefix("'")
    return re.sub(
        r"\\(?:\\|x(..)|u(....))",
        lambda m: chr(int(m[1] or m[2], 16)) if m[1] or m[2] else "\\",
        text,
    )


def same(kind: str, seen: object, wanted: object) -> bool:
    if wanted is None:
        return seen is None or (isinstance(seen, float) and math.isnan(seen))
    if kind == "number":
        return seen == wanted or (math.isnan(seen) and math.isnan(wanted))  # type: ignore[arg-type]
    return bool(seen == wanted)


@pytest.mark.proof
def test_pandas_reads_every_value_of_every_topic_back_from_csv(
    folder: Path, said: dict[str, list[Line]]
) -> None:
    columns = pandas.read_csv(folder / "columns.csv", keep_default_na=False)
    assert set(columns["topic"]) == set(said)
    for topic, wanted in said.items():
        kinds = columns[columns["topic"] == topic].set_index("column")["kind"]
        texts = {
            name: str for name, kind in kinds.items() if kind not in ("number", "integer", "flag")
        }
        table = pandas.read_csv(
            folder / f"{topic}.csv", dtype=texts, keep_default_na=False,
            na_values={name: [""] for name in kinds.index}, engine="python",
        )  # fmt: skip
        assert list(table.columns) == list(kinds.index)
        assert len(table) == len(wanted)
        for row, line in zip(table.to_dict("records"), wanted, strict=True):
            assert row["t_s"] == line.value.get("t", line.t)
            assert abs(pandas.Timestamp(row["time_utc"]).timestamp() - line.wall) < 2e-6
            for name, value in flat(dict(line.value)).items():
                if name == "t" or (value is None and name not in row):  # a table that is null
                    continue
                seen = row[name]
                if isinstance(value, list | dict):
                    seen = json.loads(seen)
                elif isinstance(value, str) and kinds[name] == "text":
                    seen = "" if same("text", seen, None) else unescaped(seen)
                assert same(kinds[name], seen, value), (topic, name, seen, value)


def test_pyarrow_reads_every_value_of_every_topic_back_with_its_unit(
    folder: Path, said: dict[str, list[Line]]
) -> None:
    for topic, wanted in said.items():
        table = parquet.read_table(folder / f"{topic}.parquet")
        for row, line in zip(table.to_pylist(), wanted, strict=True):
            assert row["t_s"] == line.value.get("t", line.t)
            assert abs(row["time_utc"].timestamp() - line.wall) < 2e-6
            for name, value in flat(dict(line.value)).items():
                if name == "t" or (value is None and name not in row):  # a table that is null
                    continue
                seen = json.loads(row[name]) if is_json(topic, name) else row[name]
                assert same("text", seen, value), (topic, name, seen, value)
    units = parquet.read_schema(folder / "telemetry.parquet").field("depth_m").metadata
    assert units == {b"unit": b"m", b"says": b""}


def is_json(topic: str, name: str) -> bool:
    return (topic, name) in {
        ("start", "configuration"),
        ("start", "vehicle"),
        ("step", "evaluations"),
    }


def test_every_number_of_csv_has_its_unit_or_a_meaning_beside_it(folder: Path) -> None:
    with (folder / "columns.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    units = {(row["topic"], row["column"]): row["unit"] for row in rows}
    assert units["estimate", "heading"] == "rad"
    assert units["telemetry", "heading_deg"] == "deg"
    assert units["estimate", "depth_rate"] == "m/s"
    bare = [row for row in rows if row["kind"] == "number" and not (row["unit"] or row["says"])]
    assert {row["topic"] for row in bare} <= {"pose", "estimate"}


def test_gpxpy_reads_track_fixes_and_legs_where_they_were(
    folder: Path, said: dict[str, list[Line]]
) -> None:
    read = gpxpy.parse((folder / "track.gpx").read_text(encoding="utf-8"))
    track, fixes = read.tracks
    states = [line for line in said["state"] if line.value["latitude_deg"] is not None]
    for made, lines_ in ((track, states), (fixes, said["fix"])):
        seen = [point for segment in made.segments for point in segment.points]
        assert len(seen) == len(lines_) > 5
        for point, line in zip(seen, lines_, strict=True):
            assert point.latitude == pytest.approx(line.value["latitude_deg"], abs=1e-8)
            assert point.longitude == pytest.approx(line.value["longitude_deg"], abs=1e-8)
            assert point.time.timestamp() == pytest.approx(line.wall, abs=1e-3)
    under = [p.elevation for s in track.segments for p in s.points]
    assert under == [-line.value["depth_m"] for line in states]
    assert len(fixes.segments) > 1, "a dive is no line between two fixes"
    planned = json.loads(said["plan"][-1].value["geojson"])["features"]
    legs = {f["properties"]["name"]: f["geometry"]["coordinates"] for f in planned
            if f["geometry"]["type"] == "LineString" and f["properties"]["name"] != "radius"}  # fmt: skip
    assert len(legs) > 1
    seen = {r.name: [[p.longitude, p.latitude] for p in r.points] for r in read.routes}
    assert seen == legs


def test_a_plan_that_was_exported_can_be_imported_again(folder: Path) -> None:
    path = folder / "track.gpx"
    found = Findings(str(path))
    source = load(path, format_of(path, found), found)
    legs = gpxpy.parse(path.read_text(encoding="utf-8")).routes
    assert [route.name for route in source.routes] == [leg.name for leg in legs]
    for route, leg in zip(source.routes, legs, strict=True):
        assert len(route.steps()) == len(leg.points)


def test_a_reader_of_kml_finds_track_fixes_and_plan(
    folder: Path, said: dict[str, list[Line]]
) -> None:
    read = fastkml.KML.parse(folder / "track.kml")
    states = [line for line in said["state"] if line.value["latitude_deg"] is not None]
    items = [
        item for track in utils.find_all(read, of_type=tracks.Track) for item in track.track_items
    ]
    assert len(items) == len(states)
    for item, line in zip(items, states, strict=True):
        place = line.value["longitude_deg"], line.value["latitude_deg"], -line.value["depth_m"]
        assert item.coord.coords[0] == pytest.approx(place, abs=1e-8)
        assert item.when.dt.timestamp() == pytest.approx(line.wall, abs=1e-3)
    marks = list(utils.find_all(read, of_type=features.Placemark))
    assert len([m for m in marks if m.times is not None]) == len(said["fix"])
    assert {"home", "radius"} <= {mark.name for mark in marks}


RINGS = {
    "wreck": [[120.1, 30.1], [120.2, 30.1], [120.2, 30.2], [120.1, 30.1]],
    "bay": [[120.0, 30.0], [120.5, 30.0], [120.5, 30.5], [120.0, 30.5], [120.0, 30.0]],
}


@pytest.fixture(scope="module")
def fenced() -> Places:
    areas = [
        {"type": "Feature", "properties": {"name": name, "what": f"keep out {name}"},
         "geometry": {"type": "Polygon", "coordinates": [ring]}}
        for name, ring in RINGS.items()
    ]  # fmt: skip
    return Places("2026-01-01T00:00:00.000Z", "auv", plans={"0": Plan("fenced", areas)})


def test_gpxpy_reads_areas_as_closed_tracks_that_nobody_steers_along(fenced: Places) -> None:
    read = gpxpy.parse(gpx(fenced).decode())
    seen = {
        track.name: [[p.longitude, p.latitude] for p in track.segments[0].points]
        for track in read.tracks
    }
    assert seen == RINGS
    assert read.routes == []
    assert {track.description for track in read.tracks} == {
        "fenced: keep out wreck", "fenced: keep out bay",
    }  # fmt: skip


def test_a_reader_of_kml_finds_the_areas_as_polygons(fenced: Places) -> None:
    read = fastkml.KML.parse(io.BytesIO(kml(fenced)))
    marks = {mark.name: mark for mark in utils.find_all(read, of_type=features.Placemark)}
    seen = {
        name: [list(at) for at in mark.geometry.exterior.coords] for name, mark in marks.items()
    }
    assert seen == RINGS
    assert marks["bay"].description == "keep out bay"


def test_a_reader_of_geojson_finds_track_fixes_and_plan(
    folder: Path, said: dict[str, list[Line]]
) -> None:
    read = json.loads((folder / "track.geojson").read_text())
    by = {of: [f for f in read["features"] if f["properties"]["of"] == of]
          for of in ("plan", "track", "fix")}  # fmt: skip
    assert all(geometry.shape(f["geometry"]).is_valid for some in by.values() for f in some)
    states = [line for line in said["state"] if line.value["latitude_deg"] is not None]
    track = [
        p
        for f in by["track"]
        for p in shapely.get_coordinates(geometry.shape(f["geometry"]), include_z=True)
    ]
    wanted = [
        (v["longitude_deg"], v["latitude_deg"], -v["depth_m"]) for v in (s.value for s in states)
    ]
    assert [tuple(point) for point in track] == wanted
    radii = [r for f in by["track"] for r in f["properties"]["radius_95_m"]]
    assert radii == [line.value["radius_95_m"] for line in states]
    assert len(by["fix"]) == len(said["fix"])
    planned = json.loads(said["plan"][-1].value["geojson"])["features"]
    assert [f["geometry"] for f in by["plan"]] == [f["geometry"] for f in planned]


def hostile_box(folder: Path) -> Path:
    (items,) = recordings([SHORT])
    made = BlackBox(folder / "hostile.mcap")
    assert isinstance(items[0], Record)
    made.record(items[0])
    for number, text in enumerate(HOSTILE):
        made.record(tx_record(Tx(float(number), "vehicle", b"@ZAX0$", text)))
    made.close()
    return made.path


def test_no_text_of_a_csv_begins_as_a_formula_and_every_text_comes_back(tmp_path: Path) -> None:
    ran = exported(hostile_box(tmp_path), "-o", tmp_path, "--as", "csv")
    assert ran.exit_code == 0, ran.output
    raw = (tmp_path / "hostile" / "tx.csv").read_bytes()
    assert not re.search(rb"[\x00-\x09\x0b\x0c\x0e-\x1f]", raw)
    with (tmp_path / "hostile" / "tx.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(unescaped(row["reason"]) for row in rows) == HOSTILE
    for row in rows:
        for separator in (",", ";", "\t"):
            cells = [row["reason"], *row["reason"].split(separator)[1:]]
            assert not any(cell.strip()[:1] in tuple("=+-@\uff1d") for cell in cells if cell), row


def test_parquet_has_hostile_texts_as_they_are(tmp_path: Path) -> None:
    assert exported(hostile_box(tmp_path), "-o", tmp_path, "--as", "parquet").exit_code == 0
    table = parquet.read_table(tmp_path / "hostile" / "tx.parquet")
    seen = table.column("reason").to_pylist()
    assert seen == [t.replace("\ud800", "\\ud800") for t in HOSTILE]


def test_a_vehicle_of_any_name_makes_no_marks_in_xml(tmp_path: Path) -> None:
    (items,) = recordings([SHORT])
    made = BlackBox(tmp_path / "named.mcap")
    for item in items:
        if isinstance(item, Record):
            name = b"</name><x>&\\u0000"
            again = item.payload.replace(b'"name":"auv"', b'"name":"' + name + b'"')
            again = again.replace(b'"name": "auv"', b'"name": "' + name + b'"')
            made.record(Record(item.t, item.kind, again if item.kind == "start" else item.payload))
    made.close()
    ran = exported(made.path, "-o", tmp_path, "--as", "gpx", "--as", "kml")
    assert ran.exit_code == 0, ran.output
    read = gpxpy.parse((tmp_path / "named" / "track.gpx").read_text(encoding="utf-8"))
    assert read.name == r"</name><x>&\x00"
    assert fastkml.KML.parse(tmp_path / "named" / "track.kml").features


def test_a_value_that_is_not_what_its_topic_says_is_refused_with_its_place() -> None:
    (items,) = recordings([SHORT])
    assert isinstance(items[0], Record)
    payload = b'{"link":"gps","kind":5,"offset":1,"length":2}'
    with pytest.raises(ExportError, match=r"fault at 7 s: kind is 5, which is no text"):
        list(sheets([items[0], Record(7.0, "fault", payload)]))


def test_nothing_is_written_over_unless_force_says_so(tmp_path: Path) -> None:
    assert exported(SHORT, "-o", tmp_path, "--as", "gpx").exit_code == 0
    path = tmp_path / "short-time" / "track.gpx"
    path.write_text("mine")
    again = exported(SHORT, "-o", tmp_path, "--as", "csv", "--as", "gpx")
    assert again.exit_code == 2
    assert str(path) in again.stderr
    assert "--force" in again.stderr
    assert [one.name for one in path.parent.iterdir()] == ["track.gpx"]
    assert path.read_text() == "mine"
    assert exported(SHORT, "-o", tmp_path, "--as", "gpx", "--force").exit_code == 0
    assert path.read_text().startswith("<?xml")


def test_two_logs_of_one_name_get_a_folder_each_and_none_leaves_the_output(tmp_path: Path) -> None:
    logs = [tmp_path / name for name in ("a/flight.mcap", "b/flight.mcap", "a/...mcap")]
    for log in logs:
        log.parent.mkdir(exist_ok=True)
        log.write_bytes(SHORT.read_bytes())
    out = tmp_path / "deep" / "out"
    assert exported(*logs, "-o", out, "--as", "geojson").exit_code == 0
    made = {str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*.geojson")}
    assert made == {f"deep/out/{n}/track.geojson" for n in ("flight", "flight-2", "log")}


def test_what_is_missing_in_a_damaged_log_is_told_and_the_rest_is_exported(tmp_path: Path) -> None:
    data = bytearray(SHORT.read_bytes())
    data[len(data) // 2] ^= 1
    path = tmp_path / "cut.mcap"
    path.write_bytes(data)
    ran = exported(path, "-o", tmp_path, "--as", "csv")
    assert ran.exit_code == 0
    assert "are missing between" in ran.stderr
    (items,) = recordings([path])
    wanted = sum(isinstance(i, Record) and i.kind == "estimate" for i in items)
    assert len(pandas.read_csv(tmp_path / "cut" / "estimate.csv")) == wanted > 10


@pytest.mark.parametrize("form", ["gpx", "kml", "geojson"])
def test_a_log_without_any_place_says_so(form: str, tmp_path: Path) -> None:
    ran = exported(hostile_box(tmp_path), "-o", tmp_path / "out", "--as", form)
    assert ran.exit_code == 2
    assert "hostile.mcap: nothing in it has a place" in ran.stderr
    assert not (tmp_path / "out").exists()


def test_a_log_without_a_place_keeps_no_other_form_and_no_other_log_back(tmp_path: Path) -> None:
    out, placeless = tmp_path / "out", hostile_box(tmp_path)
    ran = exported(placeless, SHORT, "-o", out, "--as", "gpx", "--as", "kml", "--as", "parquet")
    assert ran.exit_code == 2
    assert ran.stderr.count("nothing in it has a place") == 1
    assert {path.suffix for path in (out / placeless.stem).iterdir()} == {".parquet"}
    assert {path.suffix for path in (out / SHORT.stem).iterdir()} == {".gpx", ".kml", ".parquet"}


def test_what_cannot_be_read_written_or_made_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    notes = tmp_path / "notes.txt"
    notes.write_text("no black box")
    ran = exported(notes, "-o", tmp_path / "out", "--as", "csv")
    assert (ran.exit_code, "notes.txt" in ran.stderr) == (2, True)
    assert "cannot be written" not in ran.stderr
    ran = exported(SHORT, "-o", notes / "out", "--as", "gpx")
    assert (ran.exit_code, "cannot be written" in ran.stderr) == (2, True)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    ran = exported(SHORT, "-o", tmp_path / "out", "--as", "parquet")
    assert (ran.exit_code, "auvmission[parquet]" in ran.stderr) == (2, True)


def test_the_choice_of_forms_is_the_table() -> None:
    (option,) = [one for one in export.params if one.name == "forms"]
    assert list(option.type.choices) == list(FORMS)  # type: ignore[attr-defined]
