"""The bytes of a growing file: MCAP without chunks, whole after each record.

    magic, Header, a Schema and a Channel per kind | Message, Message, ... | DataEnd, Footer, magic
    Message: u8 5 | u64 length | u16 channel | u32 check | u64 log time | u64 publish time | data

Each kind of record is a topic, and its payload is the data. Publish time is the engine's time of
the record, log time the wall time when it was made, both in ns; log times never go back.

``check`` stands in the sequence number, which MCAP leaves free. It is the CRC-32 of the data, with
channel and time as initial value, plus the record's number times a constant. So a reader detects
blocks that a power cut damaged, and records that are missing between two whole ones. In the first
form (profile ``auvmission``) every number was 0, and the payloads were different (first_form).

Any MCAP tool reads the file; the footer names no summary, so readers scan. The library writes head
and foot. This module packs the messages itself, because that is most of the cost.

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
CHANNELS = {kind: number for number, kind in enumerate(KINDS, 1)}  # a kind keeps its number
MAGIC = b"\x89MCAP0\r\n"
FLUSH_S = 0.1  # s between two writes by a shell
LIMIT = 16 << 20  # bytes of one part
PROFILE, FIRST_PROFILE = "auvmission-2", "auvmission"

HEAD, FIELDS = struct.Struct("<BQ"), struct.Struct("<HIQQ")
_MESSAGE = struct.Struct("<BQHIQQ")
OP_HEADER, OP_SCHEMA, OP_CHANNEL, OP_MESSAGE, OP_CHUNK, OP_MESSAGE_INDEX = 1, 3, 4, 5, 6, 7
OP_ATTACHMENT, OP_METADATA, OP_DATA_END = 9, 12, 15
OPCODES = range(1, 16)
NS = 1e9
_NUMBERS = 1 << 32
_SPREAD = 0x85EBCA6B  # so that a wrong byte of the check gives no number nearby
_GATHER = pow(_SPREAD, -1, _NUMBERS)


class BlackBoxError(OSError):
    pass


def pack(kind: str, payload: bytes, number: int, logged: int, t: int) -> bytes:
    """Return a record as a message. ``logged``: wall time, ``t``: the engine's time, both in ns."""
    channel = CHANNELS[kind]
    check = (crc(payload, channel, t) + number * _SPREAD) % _NUMBERS
    head = _MESSAGE.pack(OP_MESSAGE, FIELDS.size + len(payload), channel, check, logged, t)
    return head + payload


def count(data: bytes) -> int:
    """Return the number of messages in ``data``; all must be whole."""
    at = number = 0
    while at < len(data):
        at += HEAD.size + HEAD.unpack_from(data, at)[1]
        number += 1
    return number


def crc(payload: bytes | memoryview, channel: int, t: int) -> int:
    return zlib.crc32(payload, (channel + t + (t >> 32)) & 0xFFFFFFFF)


def number_of(check: int, payload: bytes | memoryview, channel: int, t: int) -> int:
    """Return the record's number if the record is intact; otherwise an arbitrary number."""
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
