"""Find whole records in bytes that may be damaged anywhere.

A record is whole if its check matches and its number is the next one. After damage the search
continues byte by byte to the next whole record or chunk. If a number jumps further than the skipped
bytes could hold, it is believed only if the following record has the next number.

What does not live here: files, and the description of gaps (reading).
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import zstandard

from mission.model import Record
from mission.onboard.blackbox.first_form import as_today
from mission.onboard.blackbox.form import (
    CHANNELS,
    FIELDS,
    FIRST_PROFILE,
    HEAD,
    KINDS,
    MAGIC,
    NS,
    OP_ATTACHMENT,
    OP_CHANNEL,
    OP_CHUNK,
    OP_DATA_END,
    OP_HEADER,
    OP_MESSAGE,
    OP_MESSAGE_INDEX,
    OP_METADATA,
    OP_SCHEMA,
    OPCODES,
    PROFILE,
    number_of,
)
from mission.onboard.runtime.records import START

_FIXED = FIELDS.size
_SMALLEST = HEAD.size + _FIXED
_LARGEST = 1 << 24  # bytes of a record; a longer one is not searched for
_NEAR = 1 << 12  # records that may be missing before the last: a damaged one has any number
_LIKELY = re.compile(rb"(?:[\x05\x06]...|\x0f\x04\x00\x00)\x00{5}", re.DOTALL)
_CHUNK_FIXED = 8 + 8 + 8 + 4
_ENTRY = 8 + 8  # bytes of an entry in an index of messages
_BEFORE = frozenset({OP_HEADER, OP_SCHEMA, OP_CHANNEL, OP_METADATA})
_CHECKED = frozenset({OP_MESSAGE, OP_CHUNK, OP_DATA_END})
_START = CHANNELS[START]
_FOOTER = b"\x02\x14" + bytes(7)
_TELLING = 1 << 12
_TODAY = (PROFILE.encode(), b"jsonschema", b"closed_by")
_BEGINNING = re.compile(rb"\x01.{8}\x0a\x00\x00\x00" + FIRST_PROFILE.encode(), re.DOTALL)


@dataclass(frozen=True, slots=True)
class Found:
    """A whole record. ``skipped``: bytes before it that are no records. ``missed``: how many
    records are missing before it; None: unknown."""

    record: Record
    number: int
    at: int
    skipped: int
    missed: int | None


@dataclass(frozen=True, slots=True)
class End:
    """The end of the records in a closed file. ``skipped``: bytes before it that are no records."""

    at: int
    skipped: int


def is_first_form(data: bytes) -> bool:
    """Whether a file is of the first form. Its beginning tells even if a part of that is damaged:
    today's form has several marks there."""
    head = data[:_TELLING]
    return bool(_BEGINNING.match(head, len(MAGIC))) or not any(word in head for word in _TODAY)


class Scan:
    """Scans one file, or several in turn. ``expected``: the number of the next record; None: any
    number."""

    def __init__(self, first_form: bool, expected: int | None = 0) -> None:
        self.first_form, self.expected = first_form, expected
        self.at = 0  # up to here everything is found or given up
        self._begun = False
        self.rest = 0  # bytes after the last whole record that belong to none

    def read(self, data: bytes) -> Iterator[Found | End]:
        """Yield all that is whole from ``at`` on; may be called again with more data."""
        at = floor = self.at
        broken: int | None = None
        while at < len(data):
            size = _length(data, at)
            if size is not None and data[at] in _CHECKED:
                found = self._checked(data, at, at + size, broken is not None)
                if found is not None:
                    at += size
                    self.at, floor, broken, self._begun = at, at, None, True
                    yield from found
                    if found and isinstance(found[-1], End):
                        self.rest = 0
                        return
                    continue
            elif size is not None and self._passes(data, at, at + size):
                at += size
                continue
            broken = at if broken is None else broken
            candidate = _next(data, floor)
            if candidate is None:
                break
            at, floor = candidate, candidate + 1
        self.rest = 0 if broken is None else len(data) - broken

    def _passes(self, data: bytes, at: int, end: int) -> bool:
        """Whether this is whole but no record: head of a file, index of messages, attachment."""
        if data[at] == OP_ATTACHMENT:
            body, check = data[at + HEAD.size : end - 4], data[end - 4 : end]
            return zlib.crc32(body) == int.from_bytes(check, "little")
        if data[at] == OP_MESSAGE_INDEX:  # it has no check, but its length twice
            entries = int.from_bytes(data[at + HEAD.size + 2 : at + HEAD.size + 6], "little")
            return entries % _ENTRY == 0 and at + HEAD.size + 6 + entries == end
        return data[at] in _BEFORE and not self._begun

    def _checked(self, data: bytes, at: int, end: int, damaged: bool) -> list[Found | End] | None:
        """Return what the record at this place gives; None if it is not whole."""
        skipped = at - self.at if damaged else 0
        if data[at] == OP_DATA_END:
            return [End(at, skipped)] if _is_summary(data, end) else None
        if data[at] == OP_CHUNK:
            inner = _unpacked(data[at + HEAD.size : end])
            return None if inner is None else list(self._of_chunk(inner, at, skipped))
        number = _number(data, at, end)
        if not self._is_next(data, at, end, number, skipped):
            return None
        record = self._record(data, at, end)
        return None if record is None else [self._found(record, number, at, skipped)]

    def _is_next(self, data: bytes, at: int, end: int, number: int, skipped: int) -> bool:
        if self.first_form:
            return number == 0
        if number == 0 and _channel(data, at) == _START:
            return True
        if self.expected is not None:
            if self.expected <= number <= self.expected + skipped // _SMALLEST:
                return True
            if number < self.expected:
                return False
        size = _length(data, end)
        if size is not None and data[end] == OP_DATA_END:
            near = self.expected is not None and number < self.expected + _NEAR
            return near and _is_summary(data, end + size)
        follows = size is not None and data[end] == OP_MESSAGE
        return follows and _number(data, end, end + (size or 0)) == number + 1

    def _found(self, record: Record, number: int, at: int, skipped: int) -> Found:
        missed: int | None = None if skipped else 0
        again = number == 0 and record.kind == START  # repeated at the beginning of each part
        if not self.first_form and not (again and self.expected != 0):
            missed = 0 if self.expected is None else number - self.expected
            self.expected = number + 1
        elif again:
            missed = 0
        return Found(record, number, at, skipped, missed)

    def _record(self, data: bytes, at: int, end: int) -> Record | None:
        record = _message(data, at, end)
        if record is None or not self.first_form:
            return record
        try:
            return as_today(record)
        except ValueError:
            return None

    def _of_chunk(self, inner: bytes, at: int, skipped: int) -> Iterator[Found]:
        place = 0
        while (size := _length(inner, place)) is not None:
            if inner[place] == OP_MESSAGE:
                _, number, _, _ = FIELDS.unpack_from(inner, place + HEAD.size)
                record = _message(inner, place, place + size)
                if record is not None:
                    yield self._found(record, number, at, skipped)
                    skipped = 0
            place += size


def _length(data: bytes, at: int) -> int | None:
    """Length of the whole record that may begin here; None if none can."""
    if at + HEAD.size > len(data):
        return None
    opcode, length = HEAD.unpack_from(data, at)
    short = opcode == OP_MESSAGE and length < _FIXED
    if opcode not in OPCODES or short or length > _LARGEST or at + HEAD.size + length > len(data):
        return None
    return HEAD.size + int(length)


def _is_summary(data: bytes, at: int) -> bool:
    """Whether the end of a file follows: the footer at once, or schemas first."""
    return data.startswith(_FOOTER, at) or (_length(data, at) is not None and data[at] == OP_SCHEMA)


def _channel(data: bytes, at: int) -> int:
    return int.from_bytes(data[at + HEAD.size : at + HEAD.size + 2], "little")


def _message(data: bytes, at: int, end: int) -> Record | None:
    """The record in a message; None for a derived or unknown topic."""
    channel, _, _, t = FIELDS.unpack_from(data, at + HEAD.size)
    if not 0 < channel <= len(KINDS):
        return None
    return Record(t / NS, KINDS[channel - 1], data[at + _SMALLEST : end])


def _number(data: bytes, at: int, end: int) -> int:
    channel, check, _, t = FIELDS.unpack_from(data, at + HEAD.size)
    return number_of(check, data[at + _SMALLEST : end], channel, t)


def _next(data: bytes, at: int) -> int | None:
    found = _LIKELY.search(data, at)
    return None if found is None else found.start()


def _unpacked(body: bytes) -> bytes | None:
    """The content of a chunk; None if its check does not match."""
    if len(body) < _CHUNK_FIXED + 12:
        return None
    size, check = int.from_bytes(body[16:24], "little"), int.from_bytes(body[24:28], "little")
    name = int.from_bytes(body[28:32], "little")
    length, data = body[32 + name : 32 + name + 8], body[32 + name + 8 :]
    if body[32 : 32 + name] != b"zstd" or size > _LARGEST:
        return None
    if int.from_bytes(length, "little") != len(data):  # else it would skip more than the chunk
        return None
    try:
        if zstandard.frame_content_size(data) != size:
            return None
        unpacked = zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    except zstandard.ZstdError:
        return None
    return unpacked if zlib.crc32(unpacked) == check else None
