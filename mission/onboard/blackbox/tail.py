"""Read a file while it is being written.

What does not live here: which file is next (analysis.replay.follow).
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from mission.model import Record
from mission.onboard.blackbox.form import MAGIC, BlackBoxError
from mission.onboard.blackbox.parts import part_path
from mission.onboard.blackbox.scan import Found, Scan, is_first_form
from mission.onboard.runtime.records import START

_HEAD = 256  # bytes that show the form


class Tail:
    """A growing file: ``read`` yields the whole records since the last call. ``expected``: the
    number of the first record, after the ``start`` of a further part; None: any number. Raises
    BlackBoxError for a file that is no black box."""

    def __init__(self, path: Path, expected: int | None = 0) -> None:
        try:
            self._file = path.open("rb")
        except OSError as error:
            raise BlackBoxError(f"{path} cannot be read: {error.strerror or error}") from error
        head = self._file.read(_HEAD)
        if head[: len(MAGIC)] != MAGIC:
            self._file.close()
            raise BlackBoxError(f"{path} is no black box: it does not begin as MCAP does")
        self._scan = Scan(is_first_form(head), expected)
        self._rest = head[len(MAGIC) :]

    @property
    def expected(self) -> int | None:
        """The number of the next record."""
        return self._scan.expected

    def read(self) -> Iterator[Record]:
        data = self._rest + self._file.read()
        for found in self._scan.read(data):
            if isinstance(found, Found):
                yield found.record
        self._rest, self._scan.at = data[self._scan.at :], 0

    def close(self) -> None:
        self._file.close()


class GrowingBox:
    """A recording, read part by part as it grows. ``wall``: wall time at the engine's time 0, once
    the start was read. Raises BlackBoxError."""

    def __init__(self, path: Path) -> None:
        self.path, self._part, self.wall = path, 1, 0.0
        self._tail = Tail(path)

    def read(self) -> Iterator[Record]:
        while True:
            for record in self._tail.read():
                if record.kind == START:
                    self.wall = json.loads(record.payload)["wall"]
                yield record
            further = part_path(self.path, self._part + 1)
            if not further.exists():
                return
            self._part, before = self._part + 1, self._tail
            self._tail = Tail(further, before.expected)
            before.close()

    def close(self) -> None:
        self._tail.close()
