"""Results in a file, so that an interrupted campaign continues from there.

The file has JSON lines. The first has what was asked for, and the program; every other line is a
result with the name of its job, written as it comes. A last line that is incomplete is removed.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, Generic, TypeVar

from mission.model.plain import from_plain, to_plain
from mission.verification.workers.code import code, difference

_R = TypeVar("_R")


class Unusable(ValueError):
    """The file is of another campaign or program, is no file of results, or cannot be written."""


class Kept(Generic[_R]):
    """``kind``: the type of the results (mission.model.plain); ``count``: results in the file at
    the beginning."""

    def __init__(self, kind: Any, found: dict[str, Any], file: IO[str] | None = None) -> None:
        self._kind, self._found, self._file = kind, found, file
        self.count = len(found)

    def get(self, name: str) -> _R | None:
        """Return a kept result, or None, and forget it: each is asked for once."""
        data = self._found.pop(name, None)
        found: _R | None = None if data is None else from_plain(self._kind, data)
        return found

    def add(self, name: str, result: _R) -> None:
        if self._file is not None:
            line = json.dumps({"job": name, "result": to_plain(result)}, separators=(",", ":"))
            self._file.write(line + "\n")
            self._file.flush()


@contextmanager
def keeping(path: Path | None, asked: Mapping[str, Any], kind: Any) -> Iterator[Kept[Any]]:
    """Keep results in a file. ``asked``: plain data on which the results depend. Raises
    Unusable."""
    if path is None:
        yield Kept(kind, {})
        return
    head = json.loads(json.dumps({"asked": dict(asked), "code": dict(code())}))
    found, file = _opened(path, head)
    with file:
        yield Kept(kind, found, file)


def _opened(path: Path, head: Mapping[str, Any]) -> tuple[dict[str, Any], IO[str]]:
    """Return the results in the file, and the file, open to append."""
    try:
        found = _read(path, head) if path.exists() and path.stat().st_size else None
        file = path.open("a", encoding="utf-8")
        if found is None:
            file.write(json.dumps(head) + "\n")
            file.flush()
    except OSError as error:
        raise Unusable(f"{path}: cannot be written: {error.strerror or error}") from None
    return found or {}, file


def _read(path: Path, head: Mapping[str, Any]) -> dict[str, Any]:
    whole = path.read_bytes()
    whole = whole[: whole.rfind(b"\n") + 1]
    try:
        first, *rows = map(json.loads, whole.splitlines())
        _same(path, first, head)
        found = {row["job"]: row["result"] for row in rows}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, Unusable):
            raise
        raise Unusable(f"{path} is no file of results; name one that is not there yet") from None
    with path.open("r+b") as file:
        file.truncate(len(whole))
    return found


def _same(path: Path, theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> None:
    for part, words in (("asked", "another campaign"), ("code", "another program")):
        differs = difference(_texts(theirs[part]), _texts(ours[part]))
        if differs:
            raise Unusable(f"{path} has results of {words} ({differs}); name another file")


def _texts(part: Mapping[str, Any]) -> dict[str, str]:
    return {name: str(value) for name, value in part.items()}
