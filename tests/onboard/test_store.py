"""The laws of the store: old or new, never between; damage is told, never raised."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from mission.onboard.store import (
    NO_LIMITS,
    UNKNOWN,
    DiskStore,
    MemoryStore,
    Store,
    Stored,
    StoreError,
    WatchedStore,
)
from protocol.messages import SetSafety

LINES = ("mission a vehicle auv", "dive: ZAS10 timeout 2min")
LIMITS = SetSafety(radius=500.0, depth=12.5)


@pytest.fixture(params=["memory", "disk"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Store:
    return MemoryStore() if request.param == "memory" else DiskStore(tmp_path / "new" / "store")


def test_new_store_is_empty(store: Store) -> None:
    assert store.content == Stored()


def test_what_was_kept_is_there_at_once(store: Store) -> None:
    store.keep_lines(LINES)
    store.keep_limits(LIMITS)
    store.keep_under_way("autonomous")
    assert store.content == Stored(LINES, LIMITS, "autonomous")
    store.keep_lines(())
    assert store.content == Stored((), LIMITS, "autonomous")


def test_what_was_kept_is_there_after_a_restart(tmp_path: Path) -> None:
    first = DiskStore(tmp_path)
    first.keep_lines(LINES)
    first.keep_limits(LIMITS)
    first.keep_under_way("emergency")
    assert DiskStore(tmp_path).content == Stored(LINES, LIMITS, "emergency")


def test_a_full_disk_has_room_for_what_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the next start, on deck, brings up a mission that has ended."""
    store, sync = DiskStore(tmp_path), os.fsync
    store.keep_under_way("autonomous/a")
    full = sum(path.stat().st_size for path in tmp_path.iterdir())

    def fills(descriptor: int) -> None:
        if sum(path.stat().st_size for path in tmp_path.iterdir()) > full:
            raise OSError(28, "No space left on device")
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", fills)
    with pytest.raises(StoreError, match="No space left"):
        store.keep_lines(LINES)
    store.keep_under_way("")
    assert DiskStore(tmp_path).content.under_way == ""


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_write_cut_short_leaves_the_old_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    store = DiskStore(tmp_path)
    store.keep_lines(LINES)

    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    if step == "fsync":
        monkeypatch.setattr(os, "fsync", fail)
    else:
        monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(StoreError, match=r"mission could not be written.*No space left"):
        store.keep_lines(("another",))
    monkeypatch.undo()
    assert store.content.lines == LINES
    assert DiskStore(tmp_path).content == Stored(LINES)


def test_left_over_of_a_killed_write_is_not_read(tmp_path: Path) -> None:
    DiskStore(tmp_path).keep_lines(LINES)
    (tmp_path / "mission.new").write_bytes(b"half")
    assert DiskStore(tmp_path).content.lines == LINES
    assert not (tmp_path / "mission.new").exists()


@pytest.mark.parametrize("name", ["mission", "limits", "under-way"])
def test_a_file_cut_at_any_byte_is_told_and_never_raises(tmp_path: Path, name: str) -> None:
    store = DiskStore(tmp_path)
    store.keep_lines(LINES)
    store.keep_limits(LIMITS)
    store.keep_under_way("")
    whole = (tmp_path / name).read_bytes()
    for length in range(len(whole)):
        (tmp_path / name).write_bytes(whole[:length])
        content = DiskStore(tmp_path).content
        assert [name in text for text in content.damage] == [True]
        assert content.lines == (() if name == "mission" else LINES)
        assert content.under_way == (UNKNOWN if name == "under-way" else "")


def test_a_file_that_the_disk_does_not_give_back_counts_as_damaged(tmp_path: Path) -> None:
    """As after a failing block; serve must begin, and surface what may be under way."""
    store = DiskStore(tmp_path)
    store.keep_lines(("a", "b"))
    store.keep_under_way("autonomous/a")
    (tmp_path / "under-way").unlink()
    (tmp_path / "under-way").mkdir()
    found = DiskStore(tmp_path).content
    assert found.lines == ("a", "b")
    assert found.under_way == UNKNOWN
    assert "cannot be read" in found.damage[0]


def test_limits_of_another_version_are_told_and_never_raise(tmp_path: Path) -> None:
    store = DiskStore(tmp_path)
    store.keep_lines(("a", "b"))
    for text in ('{"unheard": 1}', "[1]", "{"):
        store.write("limits", text)
        found = DiskStore(tmp_path).content
        assert found.limits == NO_LIMITS
        assert found.lines == ("a", "b")
        assert "not understood" in found.damage[0]


def test_a_path_that_cannot_be_a_folder_is_refused_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="file/store"):
        DiskStore(tmp_path / "file" / "store")


def test_the_memory_twin_fails_where_the_disk_failed() -> None:
    twin = MemoryStore(failures={1: "no space left"})
    twin.keep_lines(LINES)
    with pytest.raises(StoreError, match="no space"):
        twin.keep_under_way("autonomous")
    twin.keep_under_way("emergency")
    assert twin.content == Stored(LINES, under_way="emergency")


def test_a_watched_store_numbers_the_writes_that_failed() -> None:
    told: list[tuple[int, str]] = []
    store = WatchedStore(MemoryStore(failures={1: "full"}), lambda n, why: told.append((n, why)))
    store.keep_lines(LINES)
    with pytest.raises(StoreError):
        store.keep_limits(LIMITS)
    store.keep_under_way("x")
    assert told == [(1, "full")]
    assert store.content == Stored(LINES, under_way="x")
