"""Laws of the form of black boxes: what an examination by the specification alone finds in them."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from shutil import copyfile

import pytest
from mcap.writer import IndexType, Writer
from mcap_doctor import examine
from recorded_flight import recorded

from mission.onboard.blackbox import BlackBox, close_part, close_recording, read_parts


@pytest.fixture(scope="module")
def growing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("examined") / "growing.mcap", "first-dive.yaml")


@pytest.fixture
def box(growing: Path, tmp_path: Path) -> Path:
    path = tmp_path / "box.mcap"
    copyfile(growing, path)
    return path


@pytest.mark.proof
def test_an_examination_finds_nothing_in_a_file_that_grew_nor_once_it_is_closed(box: Path) -> None:
    assert examine(box) == []
    assert close_part(box)
    assert examine(box) == []


def test_an_examination_finds_nothing_in_further_parts_nor_behind_a_power_cut(
    growing: Path, tmp_path: Path
) -> None:
    path = tmp_path / "box.mcap"
    parts = BlackBox(path, wall=1.75e9, limit=150_000)
    for record in read_parts(growing):
        parts.record(record)
        parts.store(parts.take())
    parts.close()
    found = sorted(tmp_path.iterdir())
    assert len(found) >= 2
    found[-1].write_bytes(found[-1].read_bytes()[:-200])
    close_recording(path)
    assert [examine(part) for part in found] == [[]] * len(found)


def _without_its_messages_indexed(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def unindexed(*args: object, **options: object) -> Writer:
        kinds = IndexType.ALL & ~IndexType.MESSAGE
        return Writer(*args, index_types=kinds, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("mission.onboard.blackbox.closed.Writer", unindexed)
    close_part(path)


def _with_a_wrong_byte(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    close_part(path)
    data = bytearray(path.read_bytes())
    data[-struct.calcsize("<IQ") - 40] ^= 1  # in the summary
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("spoil", "complaint"),
    [
        (_without_its_messages_indexed, "not every message is in its indexes"),
        (_with_a_wrong_byte, "the CRC of the summary does not fit"),
    ],
)
def test_an_examination_sees_what_is_not_as_specified(
    spoil: Callable[[Path, pytest.MonkeyPatch], None],
    complaint: str,
    box: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spoil(box, monkeypatch)
    assert any(complaint in told for told in examine(box))
