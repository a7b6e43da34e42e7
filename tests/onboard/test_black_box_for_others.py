"""Laws of what others read: every topic by its schema alone, whatever becomes of the closing."""

from __future__ import annotations

import itertools
import json
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from shutil import copyfile

import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from recorded_flight import NOTES, recorded
from served import noted_processes

from mission.authoring.prepare import prepare
from mission.legs.rows import Rows
from mission.model import Record
from mission.model.shipped import missions_folder
from mission.navigation.geodesy import LocalFrame
from mission.onboard import blackbox
from mission.onboard.blackbox import (
    BlackBox,
    close_each,
    close_part,
    close_recording,
    closed,
    read_parts,
    read_records,
    recording,
)
from mission.onboard.blackbox.closed import CHUNK_S
from mission.onboard.runtime import records as rec
from mission.onboard.serve.closing import close_in_background
from mission.onboard.stream.derived import Derivation, Message
from mission.onboard.stream.plan import plan_geojson
from mission.onboard.stream.topics import DERIVED, RAW, TOPICS

FIRST_FORM = Path(__file__).parents[1] / "analysis" / "recorded" / "begun-again.mcap"


@pytest.fixture(scope="module")
def growing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("others") / "growing.mcap"
    return recorded(path, "harbour-survey.yaml", "speed_log=0.05")


@pytest.fixture(scope="module")
def done(growing: Path) -> Path:
    path = growing.with_name("closed.mcap")
    copyfile(growing, path)
    close_recording(path, NOTES)
    return path


@pytest.fixture
def box(growing: Path, tmp_path: Path) -> Path:
    path = tmp_path / "box.mcap"
    copyfile(growing, path)
    return path


def decoded(path: Path) -> Counter[str]:
    """Every message by the official reader, and by nothing but the schema that the file has."""
    seen: Counter[str] = Counter()
    known: dict[str, Draft202012Validator] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            if channel.topic not in known:
                described = json.loads(schema.data)
                Draft202012Validator.check_schema(described)
                known[channel.topic] = Draft202012Validator(described)
            known[channel.topic].validate(json.loads(message.data))
            seen[channel.topic] += 1
    return seen


@pytest.mark.proof
def test_every_topic_of_a_growing_file_is_decoded_by_its_schema_alone(growing: Path) -> None:
    seen = decoded(growing)
    assert seen.keys() >= {"start", "rx", "tx", "step", "estimate", "standing", "mission"}
    assert seen.keys() <= {topic.name for topic in RAW}


@pytest.mark.proof
def test_every_topic_of_a_closed_part_is_decoded_by_its_schema_alone(done: Path) -> None:
    seen = decoded(done)
    assert seen.keys() >= {topic.name for topic in DERIVED}
    assert seen["state"] == seen["estimate"] > 100


def test_every_field_of_every_topic_says_its_unit_or_meaning() -> None:
    for topic in TOPICS.values():
        Draft202012Validator.check_schema(topic.schema)
        if topic.well_known:
            continue
        for name, field in topic.schema["properties"].items():
            assert field.get("description") or "anyOf" in field or "hdop" in name, (
                topic.name,
                name,
            )


def test_a_closed_part_has_the_same_records_and_is_smaller(growing: Path, done: Path) -> None:
    assert list(recording(done)) == list(recording(growing))
    assert done.stat().st_size < 0.7 * growing.stat().st_size


def test_a_closed_part_says_what_it_is_of(done: Path) -> None:
    with done.open("rb") as file:
        reader = make_reader(file)
        (metadata,) = list(reader.iter_metadata())
        attached = {one.name: one.data for one in reader.iter_attachments()}
    digest = metadata.metadata["missions"]
    assert metadata.metadata.items() >= {**NOTES, "vehicle": "auv", "end": "whole"}.items()
    assert metadata.metadata["began"].startswith("2025-")
    assert json.loads(attached["vehicle.json"])["name"] == "auv"
    assert "folder" in json.loads(attached["configuration.json"])
    assert b"harbour" in attached[f"mission-{digest[:8]}.yaml"]


@pytest.mark.proof
def test_index_and_statistics_of_a_closed_part_are_true(done: Path) -> None:
    seen = decoded(done)
    with done.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        topics = {number: channel.topic for number, channel in summary.channels.items()}
        counts = summary.statistics.channel_message_counts
        assert {topics[number]: many for number, many in counts.items()} == seen
        chunks = summary.chunk_indexes
        assert summary.statistics.chunk_count == len(chunks) > 10
        for chunk in chunks:
            assert chunk.message_end_time - chunk.message_start_time <= (CHUNK_S + 3.0) * 1e9
            file.seek(chunk.chunk_start_offset)
            assert file.read(1) == b"\x06"
        middle = chunks[len(chunks) // 2]
        file.seek(0)
        later = make_reader(file).iter_messages(starting_at=middle.message_start_time)
        assert next(iter(later))[2].log_time >= middle.message_start_time
        file.seek(0)
        assert sum(1 for _ in StreamReader(file, validate_crcs=True).records) > len(chunks)


def test_places_on_the_earth_are_those_of_the_estimate(growing: Path) -> None:
    records = list(read_parts(growing))
    derivation = Derivation(records[0])
    places, states = [], []
    for record in records:
        for message in derivation.receive(record):
            if message.topic == "position":
                places.append(message.value)
            elif message.topic == "state" and message.value["latitude_deg"] is not None:
                states.append(message.value)
    assert len(places) == len(states) > 100
    home = rec.read_standing([r for r in records if r.kind == rec.STANDING][-1]).origin
    assert home is not None
    for place, state in zip(places, states, strict=True):
        north = math.radians(place["latitude"] - home.latitude_deg) * 6.37e6
        assert north == pytest.approx(state["north_m"], abs=0.5 + 0.01 * abs(state["north_m"]))
        assert place["latitude"] == state["latitude_deg"]
        assert place["altitude"] == pytest.approx(-(state["depth_m"] or 0.0))


def test_while_nobody_knows_where_home_is_an_estimate_is_no_place_on_the_earth(
    growing: Path,
) -> None:
    """As behind a start without a fix, until the next fix."""
    records = list(read_parts(growing))
    derivation = Derivation(records[0])
    told = [list(derivation.receive(record)) for record in records]
    last = next(i for i, made in reversed(list(enumerate(told))) if _places(made))
    standing = rec.read_standing([r for r in records if r.kind == rec.STANDING][-1])
    list(derivation.receive(rec.standing_record(records[last].t, replace(standing, origin=None))))
    assert not _places(derivation.receive(records[last]))


def _places(made: Iterable[Message]) -> list[Message]:
    return [message for message in made if message.topic == "position"]


def test_the_margins_are_what_is_left_to_the_limits_in_force(growing: Path) -> None:
    records = list(read_parts(growing))
    derivation = Derivation(records[0])
    states = [m.value for r in records for m in derivation.receive(r) if m.topic == "state"]
    standing = [rec.read_standing(r) for r in records if r.kind == rec.STANDING][-1]
    flown = [s for s in states if s["state"].startswith("autonomous/") and s["north_m"] is not None]
    assert len(flown) > 50
    for state in flown:
        assert state["depth_m"] + state["to_depth_m"] == pytest.approx(standing.depth, abs=1e-3)
        far = math.hypot(state["north_m"], state["east_m"])
        assert far + state["to_radius_m"] == pytest.approx(standing.radius, abs=1e-3)
        passed = state["mission_time_s"] + state["to_time_s"]
        assert passed == pytest.approx(standing.time, abs=1e-3)


def test_the_map_of_the_plan_goes_from_corner_to_corner_of_the_rows() -> None:
    prepared = prepare(missions_folder() / "lawnmower.yaml")
    chart = prepared.chart
    assert chart.mission.home is not None
    features = plan_geojson(chart, prepared.vehicle, chart.mission.home)["features"]
    named = {one["properties"]["name"]: one["geometry"]["coordinates"] for one in features}
    assert list(named)[:2] == ["home", "radius"]
    frame = LocalFrame(chart.mission.home)
    steered = [s for s in chart.states if s.leg and isinstance(s.leg.kind, Rows)]
    assert steered
    for state in steered:
        assert state.leg is not None
        kind = state.leg.kind
        assert isinstance(kind, Rows)
        area = named[state.path.partition("/")[2]]
        flat = [frame.to_local(math.radians(n), math.radians(e)) for e, n in area]
        sides = [math.dist(a, b) for a, b in itertools.pairwise(flat[-2 * kind.count :])]
        assert sides[0::2] == pytest.approx([kind.length] * kind.count, abs=0.01)
        assert sides[1::2] == pytest.approx([kind.spacing] * (kind.count - 1), abs=0.01)


# --- the closing itself --------------------------------------------------------------------------


@pytest.mark.proof
def test_a_closing_that_the_disk_cuts_leaves_the_part_as_it_was(
    box: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = box.read_bytes()

    def full(fd: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("mission.onboard.blackbox.closed.os.fsync", full)
    with pytest.raises(OSError, match="No space left"):
        close_part(box)
    assert box.read_bytes() == whole
    assert [path.name for path in box.parent.iterdir()] == [box.name]


@pytest.mark.proof
def test_a_new_file_that_says_something_else_never_takes_the_place_of_the_old(
    box: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = box.read_bytes()
    really = closed.read_records

    def less(path: Path) -> list[Record]:
        found = list(really(path))
        return found[:-1] if path.name.endswith(".new") else found

    monkeypatch.setattr("mission.onboard.blackbox.closed.read_records", less)
    assert not close_part(box)
    assert box.read_bytes() == whole


def test_what_is_damaged_of_the_first_form_or_closed_already_stays_as_it_is(
    box: Path, done: Path, tmp_path: Path
) -> None:
    data = bytearray(box.read_bytes())
    data[len(data) // 2] ^= 1
    box.write_bytes(data)
    old, again = tmp_path / "old.mcap", tmp_path / "again.mcap"
    copyfile(FIRST_FORM, old)
    copyfile(done, again)
    before = {path: path.read_bytes() for path in (box, old, again)}
    assert close_each(sorted(tmp_path.glob("*.mcap"))) == 0
    assert {path: path.read_bytes() for path in (box, old, again)} == before


@pytest.mark.proof
def test_what_a_power_cut_left_behind_is_closed_with_all_its_whole_records(box: Path) -> None:
    box.write_bytes(box.read_bytes()[:-300])
    records = list(read_records(box))
    assert close_each([box]) == 1
    assert list(read_records(box)) == records
    with box.open("rb") as file:
        (metadata,) = list(make_reader(file).iter_metadata())
    assert metadata.metadata["end"].startswith("cut: ")


def test_what_is_being_written_is_left_alone_also_where_it_begins_while_others_are_closed(
    box: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written, begun = tmp_path / "written.mcap", tmp_path / "begun.mcap"
    started, growing = noted_processes(monkeypatch), box.read_bytes()
    written.write_bytes(growing)
    close_in_background(tmp_path, written)
    begun.write_bytes(growing)
    (closing,) = started
    closing.wait()
    assert box.read_bytes() != growing, "it is closed"
    assert written.read_bytes() == begun.read_bytes() == growing


@pytest.mark.proof
def test_a_further_part_knows_what_the_first_one_said(growing: Path, tmp_path: Path) -> None:
    path = tmp_path / "box.mcap"
    whole = list(read_parts(growing))
    parts = BlackBox(path, wall=1.75e9, limit=300_000)
    for record in whole:
        parts.record(record)
        parts.store(parts.take())
    parts.close()
    assert len(list(tmp_path.iterdir())) >= 2
    close_recording(path)
    assert list(read_parts(path)) == whole
    with (tmp_path / "box.part2.mcap").open("rb") as file:
        messages = make_reader(file).iter_messages(topics=["state"])
        state = json.loads(next(iter(messages))[2].data)
    assert state["state"]
    assert state["latitude_deg"] is not None
    assert state["to_radius_m"] is not None


def test_numbers_of_channels_are_places_in_the_table_and_stay_what_they_are() -> None:
    assert blackbox.KINDS[:14] == (
        "start", "rx", "timer", "connected", "disconnected", "navigation", "store", "step",
        "estimate", "tx", "fault", "ending", "standing", "mission",
    )  # fmt: skip
