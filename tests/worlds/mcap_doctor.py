"""An examination of MCAP files by their specification alone: what `mcap doctor` looks at, and not
with the library that writes them.

    file --records--> data section, then summary --examine--> complaints

Source: the MCAP format specification, sections "Records" and "Chunk Index".
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import zstandard

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX, OFFSET, DATA_END = range(9, 16)
_HEAD = struct.Struct("<BQ")
_POINTS_TO = {ATTACHMENT_INDEX: ATTACHMENT, METADATA_INDEX: METADATA, CHUNK_INDEX: CHUNK}


class Raw(NamedTuple):
    """A record: where it begins in its bytes, and its content."""

    at: int
    opcode: int
    content: bytes


class Chunk(NamedTuple):
    begin: int
    end: int
    size: int
    crc: int
    compression: str
    records: bytes


class Fields:
    """One after the other, little-endian."""

    def __init__(self, content: bytes) -> None:
        self._rest = content

    def numbers(self, form: str) -> tuple[int, ...]:
        size = struct.calcsize("<" + form)
        taken, self._rest = self._rest[:size], self._rest[size:]
        return struct.unpack("<" + form, taken)

    def prefixed(self) -> bytes:
        (length,) = self.numbers("I")
        taken, self._rest = self._rest[:length], self._rest[length:]
        assert len(taken) == length, "a length beyond its record"
        return taken

    def pairs(self, form: str) -> list[tuple[int, int]]:
        return [(a, b) for a, b in struct.iter_unpack("<" + form, self.prefixed())]

    @property
    def left(self) -> bytes:
        return self._rest


def records(data: bytes, at: int = 0) -> Iterator[Raw]:
    while at < len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        end = at + _HEAD.size + length
        assert end <= len(data), f"record {opcode} at {at} ends behind its bytes"
        yield Raw(at, opcode, data[at + _HEAD.size : end])
        at = end


@dataclass
class _Seen:
    schemas: dict[int, bytes] = field(default_factory=dict)
    channels: dict[int, bytes] = field(default_factory=dict)
    summary: set[tuple[int, int]] = field(default_factory=set)  # opcode and number
    chunks: dict[int, Chunk] = field(default_factory=dict)  # by place in the file
    in_chunk: dict[int, list[tuple[int, int, int]]] = field(default_factory=dict)
    indexed: dict[int, dict[int, tuple[int, set[tuple[int, int]]]]] = field(default_factory=dict)
    messages: list[tuple[int, int]] = field(default_factory=list)  # channel and log time
    at: dict[int, Raw] = field(default_factory=dict)  # every record outside chunks
    statistics: int = 0


def examine(path: Path) -> list[str]:
    """Complaints, none of a file that is as the specification says. Raises AssertionError or
    struct.error where records cannot even be told apart."""
    data, seen = path.read_bytes(), _Seen()
    assert data.startswith(MAGIC), "no magic at the begin"
    assert data.endswith(MAGIC), "no magic at the end"
    body = list(records(data[: -len(MAGIC)], len(MAGIC)))
    seen.at = {raw.at: raw for raw in body}
    ends = [raw for raw in body if raw.opcode == DATA_END]
    if body[0].opcode != HEADER or body[-1].opcode != FOOTER or len(ends) != 1:
        return ["header first, one data end, footer last: not so"]
    parts = (
        (raw for raw in body if raw.at < ends[0].at),
        (raw for raw in body if raw.at > ends[0].at),
    )
    told = [told for raw in parts[0] for told in _data(seen, raw)]
    told += [told for raw in parts[1] for told in _summary(seen, raw)]
    return [*told, *_ends(data, seen, ends[0], body[-1]), *_order(seen), *_indexes(seen)]


def _data(seen: _Seen, raw: Raw) -> Iterator[str]:
    """Of the data section."""
    if raw.opcode in (SCHEMA, CHANNEL, MESSAGE):
        yield from _inner(seen, raw)
    elif raw.opcode == CHUNK:
        yield from _chunk(seen, raw)
    elif raw.opcode == MESSAGE_INDEX:
        fields = Fields(raw.content)
        (channel,) = fields.numbers("H")
        last = max(seen.chunks, default=None)
        if last is None or channel in seen.indexed.setdefault(last, {}):
            yield f"message index of channel {channel} at {raw.at}: of no chunk, or twice"
            return
        seen.indexed[last][channel] = raw.at, set(fields.pairs("QQ"))
    elif raw.opcode == ATTACHMENT:
        if zlib.crc32(raw.content[:-4]) != int.from_bytes(raw.content[-4:], "little"):
            yield f"attachment at {raw.at}: its CRC does not fit"
    elif raw.opcode not in (HEADER, METADATA):
        yield f"record {raw.opcode} at {raw.at} in the data section"


def _chunk(seen: _Seen, raw: Raw) -> Iterator[str]:
    fields = Fields(raw.content)
    begin, end, size, crc = fields.numbers("QQQI")
    compression = fields.prefixed().decode()
    (length,) = fields.numbers("Q")
    packed = fields.left
    assert len(packed) == length
    seen.chunks[raw.at] = Chunk(begin, end, size, crc, compression, packed)
    plain = zstandard.ZstdDecompressor().decompress(packed, size) if compression else packed
    if len(plain) != size or zlib.crc32(plain) != crc:
        yield f"chunk at {raw.at}: its size or CRC does not fit"
    before, held = len(seen.messages), seen.in_chunk.setdefault(raw.at, [])
    for inner in records(plain):
        yield from _inner(seen, inner)
        if inner.opcode == MESSAGE:
            channel, t = seen.messages[-1]
            held.append((channel, t, inner.at))
    times = [t for _, t in seen.messages[before:]]
    if times and (min(times), max(times)) != (begin, end):
        yield f"chunk at {raw.at}: its times are not those of its messages"


def _inner(seen: _Seen, raw: Raw) -> Iterator[str]:
    """What stands in chunks, or where there are none by itself."""
    fields = Fields(raw.content)
    (number,) = fields.numbers("H")
    if raw.opcode == MESSAGE:
        _, log_time, _ = fields.numbers("IQQ")
        seen.messages.append((number, log_time))
        if number not in seen.channels:
            yield f"a message of channel {number} before it"
        return
    if raw.opcode not in (SCHEMA, CHANNEL):
        yield f"record {raw.opcode} in a chunk"
        return
    known = seen.schemas if raw.opcode == SCHEMA else seen.channels
    if number in known:
        yield f"record {raw.opcode} with number {number} stands there twice"
    known[number] = raw.content
    if raw.opcode == SCHEMA:
        _, encoding, text = fields.prefixed(), fields.prefixed(), fields.prefixed()
        if number == 0 or not encoding or not text:
            yield f"schema {number} says nothing"
    elif (schema := fields.numbers("H")[0]) not in seen.schemas:
        yield f"channel {number} of unknown schema {schema}"


def _summary(seen: _Seen, raw: Raw) -> Iterator[str]:
    if raw.opcode in (SCHEMA, CHANNEL):
        (number,) = Fields(raw.content).numbers("H")
        seen.summary.add((raw.opcode, number))
        known = seen.schemas if raw.opcode == SCHEMA else seen.channels
        if known.get(number) != raw.content:
            yield f"record {raw.opcode} with number {number}: the summary has another one"
    elif raw.opcode == STATISTICS:
        seen.statistics += 1
        yield from _statistics(seen, raw)
    elif raw.opcode in (ATTACHMENT_INDEX, METADATA_INDEX):
        yield from _points(seen, raw, *Fields(raw.content).numbers("QQ"))
    elif raw.opcode == OFFSET:
        group, begin, length = Fields(raw.content).numbers("BQQ")
        grouped = [r for at, r in seen.at.items() if begin <= at < begin + length]
        whole = sum(_HEAD.size + len(r.content) for r in grouped)
        if {r.opcode for r in grouped} != {group} or whole != length:
            yield f"summary offset of group {group}: it is not there"
    elif raw.opcode not in (CHUNK_INDEX, FOOTER):
        yield f"record {raw.opcode} at {raw.at} in the summary"


def _points(seen: _Seen, raw: Raw, at: int, length: int) -> Iterator[str]:
    there = seen.at.get(at)
    if there is None or there.opcode != _POINTS_TO[raw.opcode]:
        yield f"index {raw.opcode} at {raw.at} points to {at}, where there is none"
    elif length != _HEAD.size + len(there.content):
        yield f"index {raw.opcode} at {raw.at}: another length"


def _statistics(seen: _Seen, raw: Raw) -> Iterator[str]:
    fields = Fields(raw.content)
    many, schemas, channels, attached, noted, chunks, begin, end = fields.numbers("QHIIIIQQ")
    kinds = Counter(r.opcode for r in seen.at.values())
    told = many, schemas, channels, attached, noted, chunks
    there = (len(seen.messages), len(seen.schemas), len(seen.channels), kinds[ATTACHMENT],
             kinds[METADATA], kinds[CHUNK])  # fmt: skip
    if told != there:
        yield f"statistics count {told}, there are {there}"
    times = [t for _, t in seen.messages]
    if (begin, end) != (min(times), max(times)):
        yield "statistics: other times than those of the messages"
    counts = dict(fields.pairs("HQ"))
    if {channel: count for channel, count in counts.items() if count} != Counter(
        channel for channel, _ in seen.messages
    ):
        yield "statistics: other numbers of messages by channel"


def _ends(data: bytes, seen: _Seen, data_end: Raw, footer: Raw) -> Iterator[str]:
    (crc,) = Fields(data_end.content).numbers("I")
    if crc and crc != zlib.crc32(data[: data_end.at]):
        yield "the CRC of the data section does not fit"
    summary, offsets, check = Fields(footer.content).numbers("QQI")
    kinds = Counter(raw.opcode for raw in seen.at.values())
    if seen.statistics != (1 if kinds[CHUNK] else 0):
        yield f"{seen.statistics} statistics"
    if summary == 0:
        return
    if zlib.crc32(data[summary : footer.at + _HEAD.size + 16]) != check:
        yield "the CRC of the summary does not fit"
    if summary not in seen.at or summary < data_end.at or seen.at[offsets].opcode != OFFSET:
        yield "the footer points beside the summary"


def _order(seen: _Seen) -> Iterator[str]:
    latest = 0
    for channel, t in seen.messages:
        if t < latest:
            yield f"a message of channel {channel} at {t} behind one of {latest}"
        latest = max(latest, t)
    if seen.chunks and any(raw.opcode in (SCHEMA, CHANNEL, MESSAGE) for raw in _unchunked(seen)):
        yield "records in chunks and beside them"


def _unchunked(seen: _Seen) -> Iterator[Raw]:
    end = next(at for at, raw in seen.at.items() if raw.opcode == DATA_END)
    return (raw for at, raw in seen.at.items() if at < end)


def _indexes(seen: _Seen) -> Iterator[str]:
    """Each chunk has one index, and each of its messages is found by it: readers with an index
    read no other messages."""
    found = Counter(
        Fields(raw.content).numbers("QQQ")[2]
        for raw in seen.at.values()
        if raw.opcode == CHUNK_INDEX
    )
    if found != Counter(seen.chunks.keys()):
        yield "chunks and their indexes do not go together"
        return
    for raw in seen.at.values():
        if raw.opcode == CHUNK_INDEX:
            yield from _chunk_index(seen, raw)


def _chunk_index(seen: _Seen, raw: Raw) -> Iterator[str]:
    fields = Fields(raw.content)
    begin, end, at, length = fields.numbers("QQQQ")
    yield from _points(seen, raw, at, length)
    offsets = dict(fields.pairs("HQ"))
    (behind,) = fields.numbers("Q")
    compression = fields.prefixed().decode()
    packed, size = fields.numbers("QQ")
    chunk, indexed = seen.chunks[at], seen.indexed.get(at, {})
    if (begin, end, compression, packed, size) != (
        chunk.begin, chunk.end, chunk.compression, len(chunk.records), chunk.size
    ):  # fmt: skip
        yield f"the index of the chunk at {at} says something else"
    places = {channel: place for channel, (place, _) in indexed.items()}
    lengths = [_HEAD.size + len(seen.at[place].content) for place in places.values()]
    if offsets != places or behind != sum(lengths):
        yield f"the index of the chunk at {at}: its indexes of messages are elsewhere"
    held: dict[int, set[tuple[int, int]]] = {}
    for channel, t, place in seen.in_chunk[at]:
        held.setdefault(channel, set()).add((t, place))
    if held != {channel: entries for channel, (_, entries) in indexed.items()}:
        yield f"the chunk at {at}: not every message is in its indexes"
    for channel in held:
        schema = struct.unpack_from("<H", seen.channels[channel], 2)[0]
        if not {(CHANNEL, channel), (SCHEMA, schema)} <= seen.summary:
            yield f"channel {channel} is not in the summary"
