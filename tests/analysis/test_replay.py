"""Laws of replay: the same inputs give the same records, and the first difference is shown."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner

from links.simulated.settings import parse_settings
from mission.analysis.replay.replay import ReplayError, replay, summary
from mission.authoring.prepare import prepare
from mission.commands.replay import replay as command
from mission.model import Record
from mission.model.shipped import missions_folder
from mission.onboard.blackbox import BlackBox, read_records, recording
from mission.onboard.runtime.records import ESTIMATE, RX, STEP, TIMER, TX, ListRecorder
from mission.verification.simulation.flight import fly


@pytest.fixture(scope="module")
def recorded() -> list[Record]:
    prepared = prepare(missions_folder() / "first-dive.yaml")
    recorder = ListRecorder()
    sea = parse_settings(["current=0.2@70"])
    fly(prepared.mission, prepared.vehicle, seed=5, settings=sea, recorder=recorder)
    return recorder.records


def saved(path: Path, records: list[Record]) -> Path:
    box = BlackBox(path)
    for record in records:
        box.record(record)
    box.close()
    return path


KEPT = sorted((Path(__file__).parent / "recorded").glob("*.mcap"))


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.stem)
def test_a_box_that_was_recorded_long_ago_gives_the_same_bytes_and_states(path: Path) -> None:
    """Who changes a rule of flight on purpose records them anew: python tests/analysis/record.py."""
    found = replay(list(read_records(path)))
    assert found.identical, summary(found)


@pytest.mark.proof
def test_a_flight_from_the_file_is_identical(recorded: list[Record], tmp_path: Path) -> None:
    path = saved(tmp_path / "box.mcap", recorded)
    ran = CliRunner().invoke(command, [str(path)])
    assert ran.exit_code == 0, ran.output
    assert ran.output.startswith(f"identical: {len(recorded)} records")


def test_a_cut_file_is_replayed_to_its_last_whole_record(
    recorded: list[Record], tmp_path: Path
) -> None:
    path = saved(tmp_path / "box.mcap", recorded)
    whole = path.read_bytes()
    for share in (0.3, 0.5, 0.77):
        path.write_bytes(whole[: int(len(whole) * share)])
        result = replay(list(read_records(path)))
        assert result.identical
        assert 100 < result.records < len(recorded)


def changed(recorded: list[Record], kind: str, at: int = 20) -> tuple[int, list[Record]]:
    """One record of that kind with another byte near its end: within what it says."""
    number = [n for n, r in enumerate(recorded) if r.kind == kind][at]
    old = recorded[number]
    payload = old.payload[:-3] + bytes([old.payload[-3] ^ 1]) + old.payload[-2:]
    new = Record(old.t, old.kind, payload)
    return number, [*recorded[:number], new, *recorded[number + 1 :]]


def test_what_is_missing_is_told_and_never_called_identical(
    recorded: list[Record], tmp_path: Path
) -> None:
    path = saved(tmp_path / "b.mcap", recorded)
    whole = path.read_bytes()
    assert CliRunner().invoke(command, [str(path)]).stderr == ""
    path.write_bytes(whole[: len(whole) // 2])
    ran = CliRunner().invoke(command, ["--json", str(path)])
    assert ran.exit_code == 3
    assert "is cut behind" in ran.stderr
    told = json.loads(ran.stdout)
    assert not told["identical"]
    assert len(told["missing"]) == 1
    ran = CliRunner().invoke(command, [str(path)])
    assert "identical" not in ran.stdout
    assert ran.stdout.startswith("the same as far as it can be compared: ")


def garbled(path: Path, kind: str, at: int) -> None:
    """The ``at``-th record of that kind with another byte within."""
    payload = [r.payload for r in read_records(path) if r.kind == kind][at]
    whole = path.read_bytes()
    place = whole.index(payload) + 3
    path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])


def test_behind_a_missing_output_all_else_is_compared(
    recorded: list[Record], tmp_path: Path
) -> None:
    path = saved(tmp_path / "b.mcap", recorded)
    garbled(path, ESTIMATE, 20)
    garbled(path, TX, 4)
    found = replay(list(recording(path)))
    assert (found.same, found.identical) == (True, False)
    assert (found.records, found.beyond) == (len(recorded) - 2, 0)
    assert [gap.records for gap in found.gaps] == [1, 1]


def test_behind_a_missing_input_nothing_is_compared_and_that_is_told(
    recorded: list[Record], tmp_path: Path
) -> None:
    path = saved(tmp_path / "b.mcap", recorded)
    garbled(path, RX, 60)
    found = replay(list(recording(path)))
    assert (found.same, found.identical) == (True, False)
    assert found.records + found.beyond == len(recorded) - 1
    assert found.beyond > 100
    assert f"behind {found.until:.3f} s nothing could be compared" in summary(found)


@pytest.mark.parametrize("kind", [TX, STEP, ESTIMATE])
def test_the_first_difference_is_found_and_shown(recorded: list[Record], kind: str) -> None:
    number, records = changed(recorded, kind, 5 if kind != ESTIMATE else 40)
    result = replay(records)
    assert result.divergence is not None
    assert result.divergence.number == number
    assert result.divergence.expected == records[number]
    assert result.divergence.actual == recorded[number]
    told = summary(result)
    assert told.startswith(f"different at {recorded[number].t:.6f} s, record {number}")
    assert "recorded" in told


def test_of_two_steps_the_fields_that_differ_are_named(recorded: list[Record]) -> None:
    number = [n for n, r in enumerate(recorded) if r.kind == STEP][5]
    step = json.loads(recorded[number].payload) | {"event": "something else"}
    text = json.dumps(step, separators=(",", ":")).encode()
    records = [*recorded[:number], Record(recorded[number].t, STEP, text), *recorded[number + 1 :]]
    assert '  event: "something else" -> ' in summary(replay(records))


def rounded(records: list[Record], by: float) -> list[Record]:
    """Every tenth estimate with another depth, as another processor's arithmetic has it."""
    out = []
    for n, record in enumerate(records):
        if record.kind == ESTIMATE and n % 10 == 0:
            told = json.loads(record.payload)
            told["depth"] += by
            text = json.dumps(told, separators=(",", ":")).encode()
            record = Record(record.t, ESTIMATE, text)
        out.append(record)
    return out


def test_another_processors_last_digits_are_told_and_passed_when_that_is_asked_for(
    recorded: list[Record], tmp_path: Path
) -> None:
    path = str(saved(tmp_path / "box.mcap", rounded(recorded, 1e-12)))
    strict = CliRunner().invoke(command, [path])
    assert strict.exit_code == 1
    assert "in the last digits only" in strict.output
    passed = CliRunner().invoke(command, ["--rounded", path])
    assert passed.exit_code == 0, passed.output
    assert passed.output.startswith(f"the same: {len(recorded)} records")
    assert "estimates to rounding" in passed.output
    found = replay(list(read_records(tmp_path / "box.mcap")), rounded=True)
    assert found.whole
    assert not found.identical


@pytest.mark.parametrize("by", [1e-6, math.inf])
def test_what_is_more_than_rounding_is_a_difference_though_rounding_is_passed(
    recorded: list[Record], by: float
) -> None:
    found = replay(rounded(recorded, by), rounded=True)
    assert found.divergence is not None
    assert "last digits" not in summary(found)


@pytest.mark.parametrize("kind", [TX, STEP])
def test_a_byte_or_a_step_is_never_rounded(recorded: list[Record], kind: str) -> None:
    number, records = changed(recorded, kind, 5)
    found = replay(records, rounded=True).divergence
    assert found is not None
    assert found.number == number


def test_another_input_is_followed_by_other_outputs(recorded: list[Record]) -> None:
    number = next(n for n, r in enumerate(recorded) if r.kind == RX and b"@AA$" in r.payload)
    records = [*recorded[:number], *recorded[number + 1 :]]
    found = replay(records).divergence
    assert found is not None
    assert found.number >= number


def test_a_missing_and_a_surplus_output_are_differences(recorded: list[Record]) -> None:
    at = next(n for n, r in enumerate(recorded) if r.kind == TX and n > 100)
    missing = replay([*recorded[:at], *recorded[at + 1 :]]).divergence
    assert missing is not None
    assert missing.actual == recorded[at]
    surplus = replay([*recorded[: at + 1], recorded[at], *recorded[at + 1 :]]).divergence
    assert surplus is not None
    assert surplus.number == at + 1


def test_a_timer_that_came_at_another_time_is_no_silent_change(recorded: list[Record]) -> None:
    timers = [n for n, r in enumerate(recorded) if r.kind == TIMER]
    at = timers[len(timers) // 2]
    old = recorded[at]
    records = [*recorded[:at], Record(old.t + 0.5, TIMER, old.payload), *recorded[at + 1 :]]
    assert replay(records).divergence is not None


def test_without_a_whole_start_nothing_is_replayed(recorded: list[Record], tmp_path: Path) -> None:
    with pytest.raises(ReplayError, match="no whole start record"):
        replay(recorded[1:])
    with pytest.raises(ReplayError, match="no whole start record"):
        replay([])
    path = saved(tmp_path / "box.mcap", recorded)
    path.write_bytes(path.read_bytes()[:400])
    ran = CliRunner().invoke(command, [str(path)])
    assert ran.exit_code == 2
    assert "no whole start record" in ran.output


def test_a_start_of_another_shape_names_the_versions(recorded: list[Record]) -> None:
    data = json.loads(recorded[0].payload) | {"unheard_of": 1}
    with pytest.raises(ReplayError, match="replay with the version"):
        replay([Record(0.0, "start", json.dumps(data).encode())])


def test_json_says_where_it_differs(recorded: list[Record], tmp_path: Path) -> None:
    number, records = changed(recorded, TX)
    ran = CliRunner().invoke(command, ["--json", str(saved(tmp_path / "b.mcap", records))])
    assert ran.exit_code == 1
    told = json.loads(ran.output)
    assert told["identical"] is False
    assert told["divergence"]["record"] == number
