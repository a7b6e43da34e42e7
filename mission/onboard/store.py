"""What outlives the process: the mission's lines, the operator's limits, what is under way.

    <folder>/mission    the accepted lines
    <folder>/limits     the limits that @SP set
    <folder>/under-way  what must end safely after a restart

StoreError              (the operator must act: disk full, no permission, not a folder)

Each file holds "sha256 <hex of the rest>\\n" and the rest. The store writes a temporary file, syncs
it, renames it into place and syncs the folder. After a power cut the file has the old content or
the new, whole.

A file that fails its checksum or cannot be read is damaged. Damage never raises: a damaged mission
or limits file counts as absent, a damaged ``under-way`` as unknown (engine: restart), and
``Stored.damage`` describes it.

What does not live here: staging, texts and their compilation (staging, language, compiler).
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from mission.model import UNKNOWN
from mission.onboard.kept import read_summed, write_summed
from protocol.messages import SetSafety

NO_LIMITS = SetSafety()
SPARE, ROOM = "spare", 4096  # a reserve file and its bytes: deleted if the disk is full
_V = TypeVar("_V")


class StoreError(OSError):
    """The store cannot be used, or a write failed; then the old content stays."""


@dataclass(frozen=True, slots=True)
class Stored:
    lines: tuple[str, ...] = ()  # of the accepted mission, as received by @AW; () if none
    limits: SetSafety = NO_LIMITS
    under_way: str = ""  # as in Engine.under_way; "" if nothing is
    damage: tuple[str, ...] = ()  # what could not be read, as text


def merged(kept: SetSafety, said: SetSafety) -> SetSafety:
    """Return ``kept``, updated with the fields that ``said`` sets."""
    named = {name: value for name, value in _limits(said).items() if value is not None}
    return replace(kept, **named)


class Store(Protocol):
    """Each ``keep_...`` method returns once its content is durable, or raises StoreError."""

    @property
    def content(self) -> Stored: ...

    def keep_lines(self, lines: tuple[str, ...]) -> None: ...

    def keep_limits(self, limits: SetSafety) -> None: ...

    def keep_under_way(self, what: str) -> None: ...


class MemoryStore:
    """A store in memory, for tests, simulation and replay. ``failures``: error text by the number
    of the write that fails (from 0), so that a replay meets the same full disk."""

    def __init__(self, content: Stored | None = None, failures: Mapping[int, str] = {}) -> None:
        self._content, self._failures, self._writes = content or Stored(), failures, 0

    @property
    def content(self) -> Stored:
        return self._content

    def keep_lines(self, lines: tuple[str, ...]) -> None:
        self.write(replace(self._content, lines=lines))

    def keep_limits(self, limits: SetSafety) -> None:
        self.write(replace(self._content, limits=limits))

    def keep_under_way(self, what: str) -> None:
        self.write(replace(self._content, under_way=what))

    def write(self, content: Stored) -> None:
        number, self._writes = self._writes, self._writes + 1
        if number in self._failures:
            raise StoreError(self._failures[number])
        self._content = content


class WatchedStore:
    """Forwards to another store, and reports each failure with the number of its write."""

    def __init__(self, store: Store, failed: Callable[[int, str], None]) -> None:
        self._store, self._failed, self._writes = store, failed, 0

    @property
    def content(self) -> Stored:
        return self._store.content

    def keep_lines(self, lines: tuple[str, ...]) -> None:
        self._watch(self._store.keep_lines, lines)

    def keep_limits(self, limits: SetSafety) -> None:
        self._watch(self._store.keep_limits, limits)

    def keep_under_way(self, what: str) -> None:
        self._watch(self._store.keep_under_way, what)

    def _watch(self, keep: Callable[[_V], None], value: _V) -> None:
        number, self._writes = self._writes, self._writes + 1
        try:
            keep(value)
        except StoreError as error:
            self._failed(number, str(error))
            raise


class LostStore:
    """Stands in for a store that cannot be used: each write raises StoreError with the reason."""

    def __init__(self, why: str, under_way: str = UNKNOWN) -> None:
        self.why, self.content = why, Stored(under_way=under_way)

    def keep_lines(self, lines: tuple[str, ...]) -> None:
        raise StoreError(self.why)

    def keep_limits(self, limits: SetSafety) -> None:
        raise StoreError(self.why)

    def keep_under_way(self, what: str) -> None:
        raise StoreError(self.why)


class DiskStore:
    """A store in a folder, which is created if absent. Raises StoreError if that fails."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for left_over in folder.glob("*.new"):
                with contextlib.suppress(OSError):  # a read-only medium can still be read
                    left_over.unlink()
        except FileExistsError as error:
            raise StoreError(f"the store {folder} cannot be used: it is no folder") from error
        except OSError as error:
            raise StoreError(
                f"the store {folder} cannot be used: {error.strerror or error}"
            ) from error
        self._content = self._read()
        self._reserve()

    @property
    def content(self) -> Stored:
        return self._content

    def keep_lines(self, lines: tuple[str, ...]) -> None:
        self.write("mission", "\n".join(lines))
        self._content = replace(self._content, lines=lines)

    def keep_limits(self, limits: SetSafety) -> None:
        self.write("limits", json.dumps(_limits(limits), sort_keys=True))
        self._content = replace(self._content, limits=limits)

    def keep_under_way(self, what: str) -> None:
        """Write it even on a full disk, after deleting the reserve file: otherwise a restart on
        deck would surface a vehicle whose mission is over."""
        try:
            self.write("under-way", what)
        except StoreError:
            with contextlib.suppress(OSError):
                (self._folder / SPARE).unlink()
            self.write("under-way", what)
        self._reserve()
        self._content = replace(self._content, under_way=what)

    def _reserve(self) -> None:
        """Create the reserve file, if the disk has room."""
        path = self._folder / SPARE
        with contextlib.suppress(OSError):
            if not path.exists() or path.stat().st_size < ROOM:
                path.write_bytes(bytes(ROOM))

    def _read(self) -> Stored:
        damage: list[str] = []
        mission = self._body("mission", damage, "")
        limits = self._body("limits", damage, "{}")
        under_way = self._body("under-way", damage, UNKNOWN)
        return Stored(
            tuple(mission.split("\n")) if mission else (),
            self._limits(limits or "{}", damage),
            under_way,
            tuple(damage),
        )

    def _limits(self, text: str, damage: list[str]) -> SetSafety:
        try:
            return SetSafety(**json.loads(text))
        except (ValueError, TypeError):  # written by another version
            damage.append(f"{self._folder / 'limits'} is not understood and was not used")
            return NO_LIMITS

    def _body(self, name: str, damage: list[str], if_damaged: str) -> str:
        path = self._folder / name
        try:
            return read_summed(path)
        except FileNotFoundError:
            return ""
        except OSError as error:  # a failing disk must not keep serve from surfacing a vehicle
            damage.append(f"{path} cannot be read and was not used: {error.strerror or error}")
        except ValueError:
            damage.append(f"{path} is damaged and was not used")
        return if_damaged

    def write(self, name: str, text: str) -> None:
        path = self._folder / name
        try:
            write_summed(path, text)
        except OSError as error:
            raise StoreError(f"{path} could not be written: {error.strerror or error}") from error


def _limits(limits: SetSafety) -> dict[str, Any]:
    return {field.name: getattr(limits, field.name) for field in fields(limits)}
