"""Laws of those who take records: none of them is in another's way, or in the runtime's."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest
from served import noted_processes, soon

from mission.authoring.prepare import prepare
from mission.model import Record
from mission.model.shipped import missions_folder
from mission.onboard.blackbox import BlackBox, read_records
from mission.onboard.runtime import records as rec
from mission.onboard.serve.closing import close_in_background
from mission.onboard.stream.sinks import Sinks
from mission.verification.simulation.flight import fly

RECORD = Record(0.0, rec.TIMER, b'{"t":0.0}')


class Broken:
    def record(self, record: Record) -> None:
        raise ZeroDivisionError("a bug")


def test_a_sink_that_fails_keeps_no_record_from_the_others_and_is_told_once() -> None:
    told: list[str] = []
    sinks, kept = Sinks(told.append), rec.ListRecorder()
    sinks.put("monitor", Broken())
    sinks.put("black box", kept)
    for _ in range(3):
        sinks.record(RECORD)
    assert kept.records == [RECORD] * 3
    assert told == ["monitor does not take every record: ZeroDivisionError: a bug"]


def test_a_sink_of_the_same_name_takes_the_place_of_the_one_before() -> None:
    sinks, first, second = Sinks(print), rec.ListRecorder(), rec.ListRecorder()
    sinks.put("black box", first)
    sinks.put("black box", second)
    sinks.record(RECORD)
    assert (first.records, second.records) == ([], [RECORD])
    sinks.put("black box", None)
    sinks.record(RECORD)
    assert second.records == [RECORD]


def test_what_holds_is_on_record_when_it_changes_and_only_then() -> None:
    prepared = prepare(missions_folder() / "first-dive.yaml")
    recorder = rec.ListRecorder()
    fly(prepared.mission, prepared.vehicle, seed=5, recorder=recorder)
    standing = [rec.read_standing(record) for record in recorder.of(rec.STANDING)]
    assert 2 < len(standing) < 20
    assert all(one != other for one, other in itertools.pairwise(standing))
    assert (standing[0].origin, standing[0].commander) == (None, "")
    last = standing[-1]
    assert last.origin is not None
    assert (last.commander, last.digest) == ("topside boat", prepared.chart.digest)
    assert last.depth == prepared.mission.safety.depth
    *_, mission = [json.loads(record.payload) for record in recorder.of(rec.MISSION)]
    assert mission["digest"] == prepared.chart.digest
    assert mission["lines"][0].startswith("mission first-dive vehicle auv")


def test_parts_that_are_closed_are_put_into_their_last_form_beside_the_program(
    tmp_path: Path,
) -> None:
    prepared = prepare(missions_folder() / "first-dive.yaml")
    box = BlackBox(tmp_path / "box.mcap")
    fly(prepared.mission, prepared.vehicle, seed=5, recorder=box)
    box.close()
    size, records = box.path.stat().st_size, list(read_records(box.path))
    close_in_background(tmp_path, None)
    soon(lambda: box.path.stat().st_size < size, "the closed part")
    assert list(read_records(box.path)) == records


@pytest.mark.proof
def test_where_nothing_but_the_part_that_is_written_is_there_no_process_closes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started = noted_processes(monkeypatch)
    close_in_background(tmp_path / "nowhere", None)
    box = BlackBox(tmp_path / "box.mcap")
    close_in_background(tmp_path, box.path)
    assert not started
    box.close()
    close_in_background(tmp_path, None)
    (closing,) = started
    closing.wait()
