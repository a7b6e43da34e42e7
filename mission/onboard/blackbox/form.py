"""The bytes of a file that grows: MCAP without chunks, whole after each record.

    magic, Header, a Schema and a Channel per kind | Message, Message, ... | DataEnd, Footer, magic
    Message: u8 5 | u64 length | u16 channel | u32 check | u64 log time | u64 publish time | data

Topics are the kinds of records, data their payloads, publish time the engine's time that they are
of, and log time the wall's when they were made, in ns: log times never go back. ``check`` stands
where the format has a free sequence number: the CRC-32 of the data, begun with channel and time,
plus the record's number times a constant. So blocks that a power cut garbled are known, and so is
what was lost between two records that are whole. In the first form (profile ``auvmission``) every
number was 0 and payloads were others (first_form). Any MCAP tool reads the file (the footer names
no summary, so readers scan). The library writes head and foot; messages are packed here, because
that is most of the cost.

    BlackBoxError      (the operator must act: no such folder, not a black box)

What does not live here: files (box, reading), a part that was closed (closed).
"""

from __future__ import annotations

import json
import struct
import zlib
from functools import cache

from mcap.data_stream import RecordBuilder
from mcap.records import Channel, DataEnd, Footer, Header, Schema

from mission import __version__
from mission.onboard.stream.topics import RAW, Topic

KINDS = tuple(topic.name for topic in RAW)
CHANNELS = {kind: number for number, kind in enumerate(KINDS, 1)}  # never another number
MAGIC = b"\x89MCAP0\r\n"
FLUSH_S = 0.1  # how often a shell stores what was recorded
LIMIT = 16 << 20  # bytes of one part
PROFILE, FIRST_PROFILE = "auvmission-2", "auvmission"

HEAD, FIELDS = struct.Struct("<BQ"), struct.Struct("<HIQQ")
_MESSAGE = struct.Struct("<BQHIQQ")
OP_HEADER, OP_SCHEMA, OP_CHANNEL, OP_MESSAGE, OP_CHUNK, OP_MESSAGE_INDEX = 1, 3, 4, 5, 6, 7
OP_ATTACHMENT, OP_METADATA, OP_DATA_END = 9, 12, 15
OPCODES = range(1, 16)
NS = 1e9
_NUMBERS = 1 << 32
_SPREAD = 0x85EBCA6B  # so that a wrong byte of the check makes no number that is near
_GATHER = pow(_SPREAD, -1, _NUMBERS)


class BlackBoxError(OSError):
    pass


def pack(kind: str, payload: bytes, number: int, logged: int, t: int) -> bytes:
    """A record as a message: ``logged`` by the wall's time, of the engine's time ``t``, in ns."""
    channel = CHANNELS[kind]
    check = (crc(payload, channel, t) + number * _SPREAD) % _NUMBERS
    head = _MESSAGE.pack(OP_MESSAGE, FIELDS.size + len(payload), channel, check, logged, t)
    return head + payload


def count(data: bytes) -> int:
    """Of whole messages."""
    at = number = 0
    while at < len(data):
        at += HEAD.size + HEAD.unpack_from(data, at)[1]
        number += 1
    return number


def crc(payload: bytes | memoryview, channel: int, t: int) -> int:
    return zlib.crc32(payload, (channel + t + (t >> 32)) & 0xFFFFFFFF)


def number_of(check: int, payload: bytes | memoryview, channel: int, t: int) -> int:
    """Of the record, if it is whole; any number otherwise."""
    return (check - crc(payload, channel, t)) * _GATHER % _NUMBERS


def schema_text(topic: Topic) -> bytes:
    return json.dumps(topic.schema, separators=(",", ":")).encode()


@cache
def head() -> bytes:
    builder = RecordBuilder()
    builder.write(MAGIC)
    Header(PROFILE, f"auvmission {__version__}").write(builder)
    for number, topic in enumerate(RAW, 1):
        Schema(number, schema_text(topic), "jsonschema", topic.schema_name).write(builder)
        Channel(number, topic.name, "json", dict(topic.metadata), number).write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


@cache
def foot() -> bytes:
    builder = RecordBuilder()
    DataEnd(0).write(builder)
    Footer(0, 0, 0).write(builder)
    builder.write(MAGIC)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
