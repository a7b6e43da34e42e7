"""Convert a closed part: the same records in compressed chunks, and the topics derived from them.

    part --read--> records --derive--> chunks of 20 s --new file, read again--> replaces the part

Every topic has its schema, so that any tool reads it. The old file stays until the new one is on
the disk, whole and with the same records: after an interruption one of the two is there. A damaged
part stays as it is, since another tool may read more out of it.

What does not live here: when parts are converted (serve), what is derived (stream).
"""

from __future__ import annotations

import io
import json
import os
import re
import struct
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Attachment, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from mission import __version__
from mission.authoring.language import MissionErrors, parse_script, to_yaml
from mission.model import Record
from mission.model.plain import to_plain
from mission.model.vehicle import Vehicle
from mission.onboard.blackbox.form import (
    HEAD,
    MAGIC,
    NS,
    OP_ATTACHMENT,
    OP_METADATA,
    PROFILE,
    schema_text,
)
from mission.onboard.blackbox.parts import part_number, parts_of
from mission.onboard.blackbox.reading import content, read_records
from mission.onboard.blackbox.scan import Found, Scan, is_first_form
from mission.onboard.kept import sync_folder
from mission.onboard.runtime import records as rec
from mission.onboard.store import Stored
from mission.onboard.stream.derived import Derivation
from mission.onboard.stream.topics import DERIVED, RAW

CHUNK_S = 20.0  # damage costs a chunk; shorter chunks take more bytes, with their indexes
_CHUNK_BYTES = 1 << 18  # limit for a vehicle that reports much
_NOTHING: Mapping[str, str] = {}
_ATTACHED = ("vehicle", "configuration")  # fields of the start record
_STAMPS = 8 + 8  # bytes before the name of an attachment


@dataclass(frozen=True, slots=True)
class _Part:
    path: Path
    found: tuple[Found, ...]
    lost: int  # bytes at its end that are no record: a power cut

    @property
    def start(self) -> Record | None:
        first = self.found[0].record if self.found else None
        return first if first is not None and first.kind == rec.START else None


def close_part(path: Path, notes: Mapping[str, str] = _NOTHING) -> bool:
    """Convert a part that nobody writes to any more. ``notes`` are added to its metadata: of a
    simulation the seed and the sea. False if the part stays as it is: it is damaged, of the first
    form, or already converted. Raises OSError if the disk cannot be written."""
    part = _part(path)
    if part is None or part.start is None:
        return False
    new = path.with_name(f".{path.name}.new")
    try:
        with new.open("wb") as file:
            _write(file, part, notes)
            file.flush()
            os.fsync(file.fileno())
        if _says(new) != _says(path):
            return False
        new.replace(path)
        sync_folder(path.parent)
    finally:
        new.unlink(missing_ok=True)
    return True


def close_recording(path: Path, notes: Mapping[str, str] = _NOTHING) -> None:
    """Convert all parts of a recording."""
    for part in parts_of(path):
        close_part(part, notes)


def close_each(parts: Iterable[Path]) -> int:
    """Convert parts that nobody writes to any more; return how many were converted. A part that
    cannot be read or written stays as it is."""
    done = 0
    for path in parts:
        try:
            done += close_part(path)
        except OSError:
            continue
    return done


def notes_of(path: Path) -> Mapping[str, str]:
    """Return the metadata of a closed part: version, vehicle, of a simulation the seed and the sea.
    Empty if the part is not closed, or the metadata is damaged."""
    try:
        with path.open("rb") as file:
            first = list(islice(StreamReader(file).records, 2))
    except (OSError, McapError, ValueError, struct.error):
        return _NOTHING
    last = first[-1] if first else None
    return last.metadata if isinstance(last, Metadata) else _NOTHING


def told_start(path: Path) -> Record | None:
    """Rebuild the start record of a closed first part that has lost its first chunk, from the
    attachments. The store's content is unknown, and given as empty. None if the attachments are
    lost, too. Raises BlackBoxError."""
    data, notes = content(path), notes_of(path)
    found = [_attached(data, f"{name}.json") for name in _ATTACHED]
    if part_number(path) != 1 or not all(found):
        return None
    whole = [one for one in found if one is not None]
    plain: dict[str, Any] = {n: json.loads(a.data) for n, a in zip(_ATTACHED, whole, strict=True)}
    plain |= {"version": notes.get("version", "not known"), "store": to_plain(Stored())}
    plain |= {"form": int(notes.get("form", rec.FORM)), "wall": whole[0].log_time / NS}
    return Record(0.0, rec.START, json.dumps(plain).encode())


def _attached(data: bytes, name: str) -> Attachment | None:
    """Find the attachment with this name anywhere in the file; None if there is no whole one."""
    named = re.escape(len(name).to_bytes(4, "little") + name.encode())
    begins = re.compile(b"%c(.{8}).{%d}%b" % (OP_ATTACHMENT, _STAMPS, named), re.DOTALL)
    for one in begins.finditer(data):
        body = data[one.end(1) : one.end(1) + int.from_bytes(one[1], "little")]
        if zlib.crc32(body[:-4]) == int.from_bytes(body[-4:], "little"):
            found: Attachment = Attachment.read(ReadDataStream(io.BytesIO(body)))
            return found
    return None


def is_closed(data: bytes) -> bool:
    """Whether a part is converted: then its metadata follows the header."""
    length = HEAD.unpack_from(data, len(MAGIC))[1] if len(data) > len(MAGIC) + HEAD.size else 0
    behind = len(MAGIC) + HEAD.size + int(length)
    return data[behind : behind + 1] == bytes([OP_METADATA])


def _part(path: Path) -> _Part | None:
    """Read a part for conversion; None if it stays as it is."""
    data = content(path)
    if is_closed(data) or is_first_form(data):
        return None
    scan = Scan(False, 0 if part_number(path) == 1 else None)
    scan.at = len(MAGIC)
    read = list(scan.read(data))
    found = tuple(one for one in read if isinstance(one, Found))
    damaged = any(one.skipped for one in read) or any(one.missed != 0 for one in found)
    return None if damaged else _Part(path, found, scan.rest)


def _says(path: Path) -> list[tuple[int, str, bytes]]:
    return [(round(r.t * NS), r.kind, r.payload) for r in read_records(path)]


# --- the new file --------------------------------------------------------------------------------


def _write(file: BinaryIO, part: _Part, notes: Mapping[str, str]) -> None:
    assert part.start is not None
    derivation = Derivation(part.start)
    _recall(derivation, part.path)
    writer = Writer(
        file,
        chunk_size=_CHUNK_BYTES,
        compression=CompressionType.ZSTD,
        enable_data_crcs=True,
    )
    writer.start(PROFILE, f"auvmission {__version__}")
    writer.add_metadata("auvmission", _metadata(derivation.start, part, notes))
    channels = {}
    for topic in (*RAW, *DERIVED):
        schema = writer.register_schema(topic.schema_name, "jsonschema", schema_text(topic))
        metadata = dict(topic.metadata)
        channels[topic.name] = writer.register_channel(topic.name, "json", schema, metadata)
    _messages(writer, channels, part.found, derivation)
    for name, kind, data in _attachments(derivation.start, part.found):
        stamp = round(derivation.start.wall * NS)
        writer.add_attachment(stamp, stamp, name, kind, data)
    writer.finish()  # type: ignore[no-untyped-call]


def _recall(derivation: Derivation, path: Path) -> None:
    """Take in the parts before this one, since their values stay in force."""
    for before in parts_of(path):
        if part_number(before) < part_number(path) and before.exists():
            for record in read_records(before):
                derivation.remember(record)


def _messages(
    writer: Writer, channels: Mapping[str, int], found: Iterable[Found], derivation: Derivation
) -> None:
    wall = round(derivation.start.wall * NS)
    logged, until = wall, -1.0
    for one in found:
        record = one.record
        if record.t >= until:
            writer.flush()  # type: ignore[no-untyped-call]
            until = record.t + CHUNK_S
        t = round(record.t * NS)
        logged = max(logged, wall + t)
        writer.add_message(channels[record.kind], logged, record.payload, t, one.number)
        for message in derivation.receive(record):
            t = round(message.t * NS)
            data = json.dumps(message.value, separators=(",", ":"), allow_nan=False).encode()
            writer.add_message(channels[message.topic], logged, data, t, one.number)
    writer.flush()  # type: ignore[no-untyped-call]


def _metadata(start: rec.Start, part: _Part, notes: Mapping[str, str]) -> dict[str, str]:
    begun = datetime.fromtimestamp(start.wall, UTC).isoformat(timespec="microseconds")
    digests = [json.loads(r.payload)["digest"] for r in _missions(part.found)]
    return {
        "version": start.version,
        "closed_by": __version__,
        "form": str(start.form),
        "vehicle": start.vehicle.name,
        "began": begun,
        "part": str(part_number(part.path)),
        "missions": " ".join(dict.fromkeys(filter(None, digests))),
        "end": f"cut: {part.lost} bytes were no record" if part.lost else "whole",
        **notes,
    }


def _missions(found: Iterable[Found]) -> list[Record]:
    return [one.record for one in found if one.record.kind == rec.MISSION]


def _attachments(start: rec.Start, found: Iterable[Found]) -> list[tuple[str, str, bytes]]:
    plain = to_plain(start)
    made = [
        (f"{name}.json", "application/json", json.dumps(plain[name], indent=2).encode())
        for name in _ATTACHED
    ]
    for record in _missions(found):
        said = json.loads(record.payload)
        if said["digest"]:
            name = f"mission-{said['digest'][:8]}.yaml"
            made.append(
                (name, "application/yaml", _mission_text(said["lines"], start.vehicle).encode())
            )
    return list(dict.fromkeys(made))


def _mission_text(lines: list[str], vehicle: Vehicle) -> str:
    """The mission as YAML; the script itself if this version cannot read it."""
    try:
        return to_yaml(parse_script(lines, vehicle))
    except MissionErrors:
        return "\n".join(lines) + "\n"
