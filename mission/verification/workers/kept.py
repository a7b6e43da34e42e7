"""Results in a file, so that an interrupted campaign continues from there.

The file has JSON lines. The first has what was asked for, and the program; every other line is a
result with the name of its job, written as it comes. A last line that is incomplete is removed.
While a command uses the file it has a lock on it (flock), so no second command adds to it.

A line that is written survives the command. To survive a power cut it has to be on the disk. To
wait for the disk takes milliseconds. So a line that comes less than SYNC seconds after the last
wait is left to the next one, or to the system (Linux writes it after half a minute).
"""

from __future__ import annotations

import fcntl
import json
import math
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import Any, Generic, TypeVar

from mission.model.plain import from_plain, to_plain
from mission.verification.workers.code import code, difference

SYNC = 1.0  # s
_R = TypeVar("_R")


class Unusable(ValueError):
    """The file is of another campaign or program, is no file of results, is used by another
    command, or cannot be written."""


class Kept(Generic[_R]):
    """``found``: the results that were in the file at the beginning, by the names of their jobs."""

    def __init__(self, found: dict[str, _R], file: _File | None = None) -> None:
        self._found, self._file = found, file

    def get(self, name: str) -> _R | None:
        """Return a kept result, or None, and forget it: each is asked for once."""
        return self._found.pop(name, None)

    def add(self, name: str, result: _R) -> None:
        """Keep a result. Raises Unusable."""
        if self._file is not None:
            self._file.add({"job": name, "result": to_plain(result)})


@contextmanager
def keeping(path: Path | None, asked: Mapping[str, Any], kind: Any) -> Iterator[Kept[Any]]:
    """Keep results in a file. ``asked``: plain data on which the results depend; ``kind``: the type
    of the results (mission.model.plain). Raises Unusable."""
    if path is None:
        yield Kept({})
        return
    head = json.loads(json.dumps({"asked": dict(asked), "code": dict(code())}))
    with _opened(path) as file:
        yield Kept(file.begin(head, kind), file)


@contextmanager
def _opened(path: Path) -> Iterator[_File]:
    with _refusals(path):
        raw = path.open("a+b", buffering=0)  # a line that cannot be written is not tried again
    with raw:
        with _refusals(path):
            fcntl.flock(raw, fcntl.LOCK_EX | fcntl.LOCK_NB)
        file = _File(path, raw)
        try:
            yield file
        finally:
            file.sync()


@contextmanager
def _refusals(path: Path) -> Iterator[None]:
    try:
        yield
    except BlockingIOError:
        raise Unusable(f"{path} is used by another command; name another file") from None
    except OSError as error:
        raise Unusable(f"{path}: cannot be written: {error.strerror or error}") from None


class _File:
    def __init__(self, path: Path, raw: FileIO) -> None:
        self._path, self._raw = path, raw
        self._synced = -math.inf

    def begin(self, head: Mapping[str, Any], kind: Any) -> dict[str, Any]:
        """Return the results in the file, by job; write the head of a new one."""
        with _refusals(self._path):
            self._raw.seek(0)
            content = self._raw.read()
        if not content:
            self.add(head)
            return {}
        whole = content[: content.rfind(b"\n") + 1]
        found = self._results(whole.splitlines(), head, kind)
        with _refusals(self._path):
            self._raw.truncate(len(whole))
        return found

    def _results(self, lines: list[bytes], head: Mapping[str, Any], kind: Any) -> dict[str, Any]:
        try:
            first, *rows = map(json.loads, lines)
            _same(self._path, first, head)
            return {row["job"]: from_plain(kind, row["result"]) for row in rows}
        except Unusable:
            raise
        except (ValueError, KeyError, TypeError, AttributeError):
            why = "is no file of results; name one that is not there yet"
            raise Unusable(f"{self._path} {why}") from None

    def add(self, row: Mapping[str, Any]) -> None:
        left = json.dumps(row, separators=(",", ":")).encode() + b"\n"
        with _refusals(self._path):
            while left:
                left = left[self._raw.write(left) :]
        if time.monotonic() - self._synced >= SYNC:
            self.sync()

    def sync(self) -> None:
        with _refusals(self._path):
            os.fsync(self._raw.fileno())
        self._synced = time.monotonic()


def _same(path: Path, theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> None:
    for part, words in (("asked", "another campaign"), ("code", "another program")):
        differs = difference(_texts(theirs[part]), _texts(ours[part]))
        if differs:
            raise Unusable(f"{path} has results of {words} ({differs}); name another file")


def _texts(part: Mapping[str, Any]) -> dict[str, str]:
    return {name: str(value) for name, value in part.items()}
