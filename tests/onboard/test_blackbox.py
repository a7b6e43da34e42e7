"""Laws of the black box: what was recorded comes back, whatever became of the file."""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, make_reader

from mission.model import Record
from mission.onboard import blackbox
from mission.onboard.blackbox import (
    BlackBox,
    BlackBoxError,
    file_name,
    form,
    free,
    missing,
    read_parts,
    read_records,
)
from mission.onboard.blackbox import box as writer

RECORDS = [
    Record(0.0, "start", b'{"version":"1"}'),
    Record(0.25, "rx", b"\x00" * 8 + b"topside\x00x\x00@AA$"),
    Record(0.25, "step", b'{"t":0.25}'),
    Record(1.0, "tx", b"vehicle\x00\x00r\x00@ZAF5$"),
    Record(2.125, "timer", b""),
]


def written(folder: Path, records: list[Record] = RECORDS, close: bool = True) -> Path:
    path = folder / "box.mcap"
    box = BlackBox(path, wall=1.75e9)
    for record in records:
        box.record(record)
    if close:
        box.close()
    else:
        box.store(box.take(), sync=True)
        os.close(box.fd)
    return path


def test_what_was_recorded_is_read_back(tmp_path: Path) -> None:
    assert list(read_records(written(tmp_path))) == RECORDS


def test_a_file_never_closed_is_read_to_its_last_flush(tmp_path: Path) -> None:
    assert list(read_records(written(tmp_path, close=False))) == RECORDS


@pytest.mark.proof
def test_a_file_cut_at_any_byte_is_a_prefix_of_its_records(tmp_path: Path) -> None:
    path = written(tmp_path)
    counts = []
    for length in reversed(range(path.stat().st_size)):
        os.truncate(path, length)  # a tenth of the time of a file written anew
        found = list(read_records(path))
        assert found == RECORDS[: len(found)]
        counts.append(len(found))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == len(RECORDS)


@pytest.mark.proof
@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.builds(
            Record,
            st.integers(0, 10**7).map(lambda n: n / 64),
            st.sampled_from(blackbox.KINDS),
            st.binary(max_size=300),
        ),
        max_size=20,
    ),
    st.floats(0, 1),
    st.binary(max_size=40),
)
def test_a_cut_file_with_rubbish_behind_it_never_raises(
    tmp_path_factory: pytest.TempPathFactory, records: list[Record], share: float, rubbish: bytes
) -> None:
    folder = tmp_path_factory.mktemp("box")
    whole = written(folder, records).read_bytes()
    path = folder / "cut.mcap"
    length = max(len(blackbox.MAGIC), int(len(whole) * share))
    assume(not rubbish or rubbish[:1] != whole[length : length + 1])  # the missing byte is none
    path.write_bytes(whole[:length])
    found = list(read_records(path))
    assert found == records[: len(found)]
    path.write_bytes(whole[:length] + rubbish)
    assert list(read_records(path)) == found


def test_behind_a_garbled_record_reading_goes_on_and_the_gap_is_told_by_time(
    tmp_path: Path,
) -> None:
    path = written(tmp_path)
    whole = path.read_bytes()
    at = whole.index(b"@ZAF5$")
    path.write_bytes(whole[:at] + b"@ZAF6$" + whole[at + 6 :])
    assert list(read_records(path)) == RECORDS[:3] + RECORDS[4:]
    (gap,) = missing(path)
    assert (gap.after, gap.before, gap.records) == (0.25, 2.125, 1)
    assert gap.at < at < gap.at + gap.lost
    assert "1 records are missing between 0.250 s and 2.125 s" in str(gap)


def test_zeros_that_a_lost_block_left_end_the_file(tmp_path: Path) -> None:
    path = written(tmp_path, close=False)
    path.write_bytes(path.read_bytes() + bytes(5000))
    assert list(read_records(path)) == RECORDS


def test_other_tools_read_the_same_messages(tmp_path: Path) -> None:
    path = written(tmp_path)
    for make in (make_reader, NonSeekingReader):
        with path.open("rb") as file:
            found = [(c.topic, m.data, m.publish_time) for _, c, m in make(file).iter_messages()]
        assert found == [(r.kind, r.payload, round(r.t * 1e9)) for r in RECORDS]


def test_a_full_part_goes_on_in_the_next_and_all_parts_are_one_recording(tmp_path: Path) -> None:
    path = tmp_path / "box.mcap"
    box = BlackBox(path, limit=60_000)
    records = [RECORDS[0], *(Record(float(n), "rx", bytes(1000)) for n in range(160))]
    for record in records:
        box.record(record)
        box.store(box.take())
    box.close()
    parts = sorted(p.name for p in tmp_path.iterdir())
    assert len(parts) >= 3
    assert all(p.stat().st_size <= 60_000 for p in tmp_path.iterdir())
    assert list(read_parts(path)) == records
    assert list(read_parts(tmp_path / "box.part2.mcap")) == records
    assert next(read_records(tmp_path / "box.part2.mcap")) == RECORDS[0]


def test_a_disk_that_fails_stops_nothing_and_splits_no_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "box.mcap"
    box = BlackBox(path, shell=True)
    box.store(b"")
    really = os.write
    answers = iter([7, OSError(errno.ENOSPC, "No space left on device"), 30])

    def write(fd: int, data: bytes) -> int:
        answer = next(answers, len(data))
        if isinstance(answer, OSError):
            raise answer
        return really(fd, data[:answer])

    monkeypatch.setattr("mission.onboard.blackbox.box.os.write", write)
    for record in RECORDS:
        box.record(record)
    box.store(box.take())
    assert "No space left" in box.failure
    box.record(Record(3.0, "timer", b"later"))
    box.store(box.take())
    assert box.failure == ""
    box.close()
    assert list(read_records(path)) == [*RECORDS, Record(3.0, "timer", b"later")]


def test_a_file_that_cannot_be_made_at_first_has_everything_once_it_can(tmp_path: Path) -> None:
    folder = tmp_path / "log"
    folder.write_text("in the way")
    box = BlackBox(folder / "box.mcap", shell=True)
    for record in RECORDS:
        box.record(record)
    box.store(box.take())
    assert "cannot be made" in box.failure
    folder.unlink()
    box.store(box.take())
    assert box.failure == ""
    box.close()
    assert list(read_records(folder / "box.mcap")) == RECORDS


def test_a_box_that_could_never_be_made_closes_without_a_word(tmp_path: Path) -> None:
    (tmp_path / "log").write_text("in the way")
    box = BlackBox(tmp_path / "log" / "box.mcap", shell=True)
    box.record(RECORDS[0])
    box.close()
    box.close()


def test_a_file_without_its_whole_head_is_not_left_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    really = os.write
    monkeypatch.setattr(
        "mission.onboard.blackbox.box.os.write", lambda fd, data: really(fd, data[:100])
    )
    with pytest.raises(BlackBoxError, match="No space left"):
        BlackBox(tmp_path / "box.mcap")
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_never_recovers_bounds_what_waits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "WAITING", 1000)
    box = BlackBox(tmp_path / "box.mcap", shell=True)
    for n in range(100):
        box.record(Record(float(n), "rx", bytes(100)))
    assert box.lost > 0
    assert len(box.take()) < 2000


def test_of_a_disk_that_never_recovers_each_record_is_counted_as_lost_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "WAITING", 1000)
    box = BlackBox(tmp_path / "box.mcap", shell=True)
    really = os.write

    def full(fd: int, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "full")

    monkeypatch.setattr("mission.onboard.blackbox.box.os.write", full)
    for n in range(100):
        box.record(Record(float(n), "rx", bytes(100)))
        if n % 5 == 4:
            box.store(box.take(), sync=True)
            box.store(b"", sync=True)
    monkeypatch.setattr("mission.onboard.blackbox.box.os.write", really)
    lost = box.lost
    box.close()
    assert lost > 50
    assert len(list(read_records(tmp_path / "box.mcap"))) == 100 - lost


def test_a_foreign_file_and_an_absent_one_are_named(tmp_path: Path) -> None:
    foreign = tmp_path / "notes.txt"
    foreign.write_text("no black box")
    with pytest.raises(BlackBoxError, match=r"notes\.txt is no black box"):
        list(read_records(foreign))
    with pytest.raises(BlackBoxError, match="cannot be read"):
        list(read_records(tmp_path / "absent.mcap"))
    with pytest.raises(BlackBoxError, match="cannot be made"):
        BlackBox(foreign / "box.mcap")


def test_two_starts_in_one_second_have_two_files(tmp_path: Path) -> None:
    first = free(tmp_path / file_name(1.75e9))
    assert first.name == "20250615T150640Z.mcap"
    first.touch()
    assert free(first) != first


@pytest.mark.proof
def test_of_a_closed_file_nothing_is_missing_and_a_cut_one_says_where_it_ends(
    tmp_path: Path,
) -> None:
    path = written(tmp_path)
    assert missing(path) == ()
    again, size = path.with_name("again.mcap"), path.stat().st_size
    shutil.copy(path, again)
    for cut in reversed(
        range(len(blackbox.MAGIC), size - 40, 7)
    ):  # 7 meets every place in a record
        os.truncate(path, cut)
        (gap,) = missing(path)
        assert gap.cut
        assert gap.at + gap.lost == cut
        os.truncate(again, gap.at)
        assert list(read_records(again)) == list(read_records(path))
        (nothing,) = missing(again)
        assert nothing.whole


def test_a_time_garbled_in_its_high_bytes_is_no_record(tmp_path: Path) -> None:
    path = written(tmp_path, [Record(1.0, "start", b"")])
    whole = bytearray(path.read_bytes())
    last = len(whole) - len(form.foot()) - 1  # of the engine's time
    whole[last] = 1
    path.write_bytes(whole)
    assert list(read_records(path)) == []
