"""The black box: every record in an MCAP file, readable after a power cut at any byte.

    magic, Header, a Channel per kind | Message, Message, ... | DataEnd, Footer, magic
    Message: u8 5 | u64 length | u16 channel | u32 check | u64 log time | u64 publish time | data

Topics are the kinds of records, data their payloads, publish time the engine's time and log time
the wall's, in ns. ``check`` stands where the format has a free sequence number: the CRC-32 of the
data, begun with channel and time, so that blocks which a power cut garbled are known. There are
neither chunks nor index: what is written is whole, and a cut costs the last record alone. Any MCAP
tool reads the file (the footer names no summary, so readers scan). The library writes head and
foot; messages are packed here, because that is most of the cost.

A file that has grown to its limit is closed and goes on in the next part; each part begins with
the ``start`` record again. ``<start>.mcap``, ``<start>.part2.mcap``, ...: by the start's wall time.

A disk that fails must not stop the vehicle: nothing here raises after opening, nor where a shell
opens it. What cannot be written waits, the first ``WAITING`` bytes of it; what is lost is counted.

    BlackBoxError      (the operator must act: no such folder, not a black box)

What does not live here: what the payloads mean (records), the comparison (replay).
"""

from __future__ import annotations

import errno
import os
import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import RecordBuilder
from mcap.records import Channel, DataEnd, Footer, Header

from mission import __version__
from mission.model import Record
from mission.onboard.runtime.records import (
    CONNECTED,
    DISCONNECTED,
    ENDING,
    ESTIMATE,
    FAULT,
    NAVIGATION,
    RX,
    START,
    STEP,
    STORE,
    TIMER,
    TX,
)

KINDS = (
    START, RX, TIMER, CONNECTED, DISCONNECTED, NAVIGATION, STORE, STEP, ESTIMATE, TX, FAULT,
    ENDING,
)  # fmt: skip
_JSON = frozenset({START, STEP, ESTIMATE})

MAGIC = b"\x89MCAP0\r\n"
FLUSH_S = 0.1  # how often a shell stores what was recorded
LIMIT = 256 << 20  # bytes of one part
WAITING = 16 << 20  # bytes kept while the disk does not take them
_BATCH = 1 << 16

_MESSAGE = struct.Struct("<BQHIQQ")
_HEAD, _FIELDS = struct.Struct("<BQ"), struct.Struct("<HIQQ")
_CHANNEL = struct.Struct("<HHI")  # number, schema, length of the topic
_OP_CHANNEL, _OP_MESSAGE, _OP_DATA_END = 4, 5, 15
_KNOWN = range(1, 16)  # the format's opcodes
_FIXED = _FIELDS.size
_NS = 1e9
_CHANNELS = {kind: number for number, kind in enumerate(KINDS, 1)}
_SMALLEST = 4096  # bytes: a part holds more than its head
_PART = re.compile(r"\.part\d+$")


class BlackBoxError(OSError):
    pass


class BlackBox:
    """A Recorder. ``wall``: s since 1970 at the engine's time 0 (0: none, as in simulation).

    ``shell`` False: ``record`` writes by itself, in batches, never synced. True: ``record`` only
    keeps; the shell calls ``take`` in the same thread and gives what it got to ``store`` in
    another, one at a time; a file that cannot be made is tried again with each ``store``.
    Raises BlackBoxError if the file cannot be made and there is no shell.
    """

    def __init__(
        self, path: Path, wall: float = 0.0, limit: int = LIMIT, shell: bool = False
    ) -> None:
        self.path, self.failure, self.lost = path, "", 0
        self._base, self._part, self._limit = path, 1, limit
        self._wall, self._shell = round(wall * _NS), shell
        self._pending, self._start = bytearray(), b""
        self._unwritten = bytearray()
        self.fd, self._size, self._closed = -1, 0, False
        try:
            self._open()
        except BlackBoxError as error:
            if not shell:
                raise
            self.failure = str(error)

    def record(self, record: Record) -> None:
        payload = record.payload
        channel, t = _CHANNELS[record.kind], round(record.t * _NS)
        message = _MESSAGE.pack(
            _OP_MESSAGE,
            _FIXED + len(payload),
            channel,
            _check(payload, channel, t),
            self._wall + t,
            t,
        )
        if record.kind == START:
            self._start = message + payload
        if self._shell and len(self._pending) > WAITING:
            self.lost += 1
            return
        self._pending += message
        self._pending += payload
        if not self._shell and len(self._pending) > _BATCH:
            self.store(self.take())

    def take(self) -> bytes:
        """What was recorded since the last call: whole records."""
        data, self._pending = bytes(self._pending), bytearray()
        return data

    def store(self, data: bytes, sync: bool = False) -> None:
        """Never raises: ``failure`` says what the disk said last, "" if all is well."""
        if len(self._unwritten) > WAITING:
            self.lost += 1
            data = b""
        try:
            self._write(data)
            if sync:
                os.fdatasync(self.fd)
            self.failure = ""
        except BlackBoxError as error:
            self.failure = str(error)
        except OSError as error:
            self.failure = f"{self.path}: {error.strerror or error}"

    def close(self) -> None:
        """Twice is harmless."""
        if self._closed:
            return
        self.store(self.take())
        self._closed = True
        fd, self.fd = self.fd, -1
        if fd >= 0:
            self._finish(fd)

    def _open(self) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.fd, self._size = _begin(self.path)
        except OSError as error:
            why = error.strerror or error
            raise BlackBoxError(f"the black box {self.path} cannot be made: {why}") from error

    def _write(self, data: bytes) -> None:
        """What the disk did not take stands first in the next write: no record is split."""
        if not self._unwritten and self._size > _SMALLEST and self._size + len(data) > self._limit:
            self._unwritten = bytearray(data)
            self._next_part()
        else:
            self._unwritten += data
        if self.fd < 0:
            self._open()
        while self._unwritten:
            written = os.write(self.fd, self._unwritten)
            self._size += written
            del self._unwritten[:written]

    def _next_part(self) -> None:
        path = part_path(self._base, self._part + 1)
        fd, self._size = _begin(path)
        old, self.fd, self.path, self._part = self.fd, fd, path, self._part + 1
        self._unwritten[:0] = self._start
        self._finish(old)

    def _finish(self, fd: int) -> None:
        try:
            os.write(fd, foot())
            os.fsync(fd)
        except OSError as error:
            self.failure = f"{self.path}: {error.strerror or error}"
        finally:
            os.close(fd)


def file_name(wall: float) -> str:
    """By the start's wall time, so that names sort as the starts did."""
    return datetime.fromtimestamp(wall, UTC).strftime("%Y%m%dT%H%M%SZ.mcap")


def new_path(folder: Path, wall: float) -> Path:
    """A name that is not taken: two starts within a second (or a clock set back) differ."""
    path = folder / file_name(wall)
    number = 1
    while path.exists():
        number += 1
        path = folder / file_name(wall).replace(".mcap", f"-{number}.mcap")
    return path


def part_path(base: Path, part: int) -> Path:
    return base if part == 1 else base.with_name(f"{base.stem}.part{part}{base.suffix}")


def first_part(path: Path) -> Path:
    return path.with_name(_PART.sub("", path.stem) + path.suffix)


def read_records(path: Path) -> Iterator[Record]:
    """One file, to its last whole record. Raises BlackBoxError for what is no black box."""
    try:
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            magic = file.read(len(MAGIC))
            if magic != MAGIC[: len(magic)]:
                raise BlackBoxError(f"{path} is no black box: it does not begin as MCAP does")
            yield from _records(file, size)
    except OSError as error:
        if isinstance(error, BlackBoxError):
            raise
        raise BlackBoxError(f"{path} cannot be read: {error.strerror or error}") from error


@dataclass(frozen=True, slots=True)
class Unread:
    """The end of a file that nobody closed: ``size - whole`` bytes behind its last whole record."""

    path: Path
    whole: int  # bytes that hold whole records
    size: int

    def __str__(self) -> str:
        lost = self.size - self.whole
        if not lost:
            return (
                f"{self.path} was not closed (a power cut, or it is being written): nothing is lost"
            )
        return (
            f"{self.path} is cut or damaged behind byte {self.whole} of {self.size}: "
            f"{lost} bytes are left out"
        )


def unread(path: Path) -> tuple[Unread, ...]:
    """Of every part that does not end as one that was closed. Raises BlackBoxError."""
    return tuple(found for part in _parts(path) if (found := _unread(part)) is not None)


def _unread(path: Path) -> Unread | None:
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        file.seek(len(MAGIC))
        whole = len(MAGIC)
        for opcode, body in _whole_records(file, size):
            if opcode == _OP_DATA_END:
                return None
            whole += _HEAD.size + len(body)
    return Unread(path, min(whole, size), size)


def read_parts(path: Path) -> Iterator[Record]:
    """A recording from its first part to its last, its start once, whichever part is named."""
    base, *further = _parts(path)
    yield from read_records(base)
    for part in further:
        yield from (record for record in read_records(part) if record.kind != START)


def _parts(path: Path) -> list[Path]:
    base = first_part(path)
    if not base.exists() and path.exists():
        raise BlackBoxError(f"{path} goes on from {base}, which is not there")
    parts = [base]
    while (further := part_path(base, len(parts) + 1)).exists():
        parts.append(further)
    return parts


class Tail:
    """A file that is being written: ``read`` gives the whole records that have come since.
    Raises BlackBoxError for what is no black box."""

    def __init__(self, path: Path) -> None:
        try:
            self._file = path.open("rb")
        except OSError as error:
            raise BlackBoxError(f"{path} cannot be read: {error.strerror or error}") from error
        if self._file.read(len(MAGIC)) != MAGIC:
            self._file.close()
            raise BlackBoxError(f"{path} is no black box: it does not begin as MCAP does")
        self._at, self._kinds = len(MAGIC), dict[int, str]()

    def read(self) -> Iterator[Record]:
        self._file.seek(self._at)
        for opcode, body in _whole_records(self._file, os.fstat(self._file.fileno()).st_size):
            self._at += _HEAD.size + len(body)
            if (record := _record(opcode, body, self._kinds)) is not None:
                yield record

    def close(self) -> None:
        self._file.close()


def _records(file: BinaryIO, size: int) -> Iterator[Record]:
    """Ends without a word where the file was cut, or where zeros stand for lost blocks."""
    kinds: dict[int, str] = {}
    for opcode, body in _whole_records(file, size):
        if (record := _record(opcode, body, kinds)) is not None:
            yield record
        elif opcode == _OP_MESSAGE:
            return


def _record(opcode: int, body: bytes, kinds: dict[int, str]) -> Record | None:
    """None for what is no message of a channel in ``kinds``, which gets the channels."""
    if opcode == _OP_CHANNEL and len(body) >= _CHANNEL.size:
        number, _, name = _CHANNEL.unpack_from(body)
        kinds[number] = body[_CHANNEL.size : _CHANNEL.size + name].decode(errors="replace")
    elif opcode == _OP_MESSAGE:
        number, _, _, t = _FIELDS.unpack_from(body)
        if number in kinds:
            return Record(t / _NS, kinds[number], body[_FIELDS.size :])
    return None


def _whole_records(file: BinaryIO, size: int) -> Iterator[tuple[int, bytes]]:
    while len(head := file.read(_HEAD.size)) == _HEAD.size:
        opcode, length = _HEAD.unpack(head)
        short = opcode == _OP_MESSAGE and length < _FIXED
        if opcode not in _KNOWN or short or file.tell() + length > size:
            return
        body = file.read(length)
        if opcode == _OP_MESSAGE:
            number, check, _, t = _FIELDS.unpack_from(body)
            if check != _check(body[_FIELDS.size :], number, t):
                return
        yield opcode, body


def _check(payload: bytes, channel: int, t: int) -> int:
    return zlib.crc32(payload, (channel + t + (t >> 32)) & 0xFFFFFFFF)


def _begin(path: Path) -> tuple[int, int]:
    """A new file with its head: descriptor and size."""
    fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o644)
    try:
        if (written := os.write(fd, _head())) < len(_head()):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    except OSError:
        os.close(fd)
        path.unlink()  # whoever tries again finds the name free
        raise
    return fd, written


@cache
def _head() -> bytes:
    builder = RecordBuilder()
    builder.write(MAGIC)
    Header("auvmission", f"auvmission {__version__}").write(builder)
    for kind, number in _CHANNELS.items():
        encoding = "json" if kind in _JSON else "auvmission"
        Channel(number, kind, encoding, {}, 0).write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


@cache
def foot() -> bytes:
    builder = RecordBuilder()
    DataEnd(0).write(builder)
    Footer(0, 0, 0).write(builder)
    builder.write(MAGIC)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
