"""Read black boxes: the whole records, and the gaps between them, in order of time.

A part may be growing, cut, damaged or closed, and of today's form or the first. A Gap stands in the
place of missing data. Damage costs single records; in a closed part, a chunk of some 20 s.

What does not live here: whole records in bytes (scan), files that are being written (tail).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mission.model import Record
from mission.onboard.blackbox.form import MAGIC, BlackBoxError
from mission.onboard.blackbox.parts import first_part, parts_of
from mission.onboard.blackbox.scan import End, Found, Scan, is_first_form
from mission.onboard.runtime.records import START


@dataclass(frozen=True, slots=True)
class Gap:
    """Data that is missing between two whole records, or after the last.

    ``after``, ``before``: the engine's times of the records around the gap; None: no such record.
    ``records``: how many are missing; None: unknown. ``cut``: the file ends here and was not
    closed; if ``lost`` is 0, no record is incomplete.
    """

    path: Path
    at: int  # byte of the file
    lost: int  # bytes
    after: float | None
    before: float | None = None
    records: int | None = None
    cut: bool = False

    @property
    def whole(self) -> bool:
        """Whether nothing is known to be missing: the file is growing, or a power cut came between
        two records."""
        return self.cut and self.lost == 0

    def __str__(self) -> str:
        since = "its beginning" if self.after is None else f"{self.after:.3f} s"
        until = "its end" if self.before is None else f"{self.before:.3f} s"
        if self.whole:
            return f"{self.path} was not closed (a power cut, or it is being written)"
        if self.cut:
            return f"{self.path} is cut behind {since}: the last {self.lost} bytes are no record"
        what = f"{self.records} records" if self.records else f"{self.lost} bytes"
        return f"{self.path}, byte {self.at}: {what} are missing between {since} and {until}"


Item = Record | Gap


def recording(path: Path) -> Iterator[Item]:
    """Read all parts of a recording in order, given the path of any part; the start record comes
    once. Raises BlackBoxError for a file that is no black box."""
    parts = parts_of(path)
    reader, begun = Reader(), False
    for part in parts:
        for item in reader.read(part):
            is_start = isinstance(item, Record) and item.kind == START
            if not (is_start and begun):
                yield item
            begun = begun or is_start


def read_parts(path: Path) -> Iterator[Record]:
    """Return the whole records of a recording, given the path of any part."""
    return (item for item in recording(path) if isinstance(item, Record))


def read_records(path: Path) -> Iterator[Record]:
    """Return the whole records of one file."""
    reader = Reader(0 if first_part(path) == path else None)
    return (item for item in reader.read(path) if isinstance(item, Record))


def missing(path: Path) -> tuple[Gap, ...]:
    """Return the gaps of a recording. Raises BlackBoxError."""
    return tuple(item for item in recording(path) if isinstance(item, Gap))


class Reader:
    """Reads one file after the other: numbers and times continue. ``expected`` None: the first file
    may be any part."""

    def __init__(self, expected: int | None = 0) -> None:
        self._expected = expected
        self._t: float | None = None

    def read(self, path: Path) -> Iterator[Item]:
        data = content(path)
        scan = Scan(is_first_form(data), self._expected)
        scan.at = min(len(MAGIC), len(data))
        closed = False
        for found in scan.read(data):
            if isinstance(found, End):
                closed = True
                if found.skipped:
                    yield Gap(path, found.at - found.skipped, found.skipped, self._t)
                continue
            if found.missed or found.missed is None:
                yield self._gap(path, found)
            if found.number or self._t is None:  # else a further part's copy of the start
                self._t = found.record.t
            yield found.record
        self._expected = scan.expected
        if not closed:
            rest = scan.rest
            yield Gap(path, len(data) - rest, rest, self._t, cut=True)

    def _gap(self, path: Path, found: Found) -> Gap:
        at, skipped = found.at - found.skipped, found.skipped
        return Gap(path, at, skipped, self._t, found.record.t, found.missed)


def content(path: Path) -> bytes:
    """Return the bytes of a black box. Raises BlackBoxError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise BlackBoxError(f"{path} cannot be read: {error.strerror or error}") from error
    if data[: len(MAGIC)] != MAGIC[: len(data)] and not _holds_records(data):
        raise BlackBoxError(f"{path} is no black box: it does not begin as MCAP does")
    return data


def _holds_records(data: bytes) -> bool:
    """Whether there are whole records although the first bytes are damaged."""
    scan = Scan(is_first_form(data))
    scan.at = len(MAGIC)
    return any(isinstance(found, Found) for found in scan.read(data))
