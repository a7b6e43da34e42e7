"""Replay: the recorded inputs through the same runtime, compared with what it recorded then.

    start --> Drive; every input, in order --> what it records now == what stands in the file

Everything is compared, to the last bit: kinds, times, payloads, and their order. The file may end
anywhere (a power cut): what the runtime would have recorded beyond its end is not missed. Only the
program's version in the start record may differ; it is told.

    ReplayError        (the operator must act: nothing to begin with, or from another version)

What does not live here: files (blackbox), how a runtime is made again (rerun).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

from mission import __version__
from mission.analysis.replay.rerun import drive_from, failed_writes, feed
from mission.model import Record
from mission.onboard.runtime import records as rec


class ReplayError(ValueError):
    pass


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first record that is not the same. ``cause`` is the input that led to it; ``expected``
    None: nothing was recorded there; ``actual`` None: nothing comes there now."""

    number: int  # of the record in the recording, from 0
    cause: Record
    expected: Record | None
    actual: Record | None

    @property
    def t(self) -> float:
        return (self.expected or self.actual or self.cause).t


@dataclass(frozen=True, slots=True)
class Replayed:
    records: int  # that were compared
    inputs: int
    until: float  # s, the engine's time of the last one
    version: str  # that recorded it
    divergence: Divergence | None

    @property
    def identical(self) -> bool:
        return self.divergence is None


def replay(recording: Sequence[Record]) -> Replayed:
    """Raises ReplayError."""
    start = _start(recording)
    again = rec.ListRecorder()
    try:
        runtime = drive_from(start, failed_writes(recording), again)
    except ValueError as error:
        raise ReplayError(f"recorded by version {start.version}: {error}") from error
    produced, place, inputs = again.records, 0, 0
    cause = recording[0]
    until = 0.0
    for number, record in enumerate(recording):
        if record.kind in rec.INPUTS and record.kind != rec.STORE:
            if place < len(produced):  # what came before this input has more than was recorded
                found = Divergence(number, cause, record, produced[place])
                return Replayed(number, inputs, until, start.version, found)
            cause, inputs = record, inputs + 1
            feed(runtime, record)
        actual = produced[place] if place < len(produced) else None
        if actual is None or not _same(record, actual):
            found = Divergence(number, cause, record, actual)
            return Replayed(number, inputs, until, start.version, found)
        place, until = place + 1, record.t
        if place == len(produced):
            produced.clear()
            place = 0
    return Replayed(len(recording), inputs, until, start.version, None)


def _start(recording: Sequence[Record]) -> rec.Start:
    if not recording or recording[0].kind != rec.START:
        raise ReplayError("there is no whole start record: nothing can be replayed from it")
    try:
        return rec.read_start(recording[0])
    except (ValueError, KeyError, TypeError) as error:
        raise ReplayError(
            f"the start record is not one of version {__version__}: {error}; "
            "replay with the version that recorded it"
        ) from error


def _same(recorded: Record, now: Record) -> bool:
    if recorded.kind == now.kind == rec.START:
        return True
    return (
        recorded.kind == now.kind
        and recorded.payload == now.payload
        and round(recorded.t * 1e9) == round(now.t * 1e9)
    )


# --- in words ------------------------------------------------------------------------------------


def summary(result: Replayed) -> str:
    other = f", recorded by version {result.version}" if result.version != __version__ else ""
    extent = f"{result.records} records, {result.inputs} inputs, {result.until:.3f} s{other}"
    if result.divergence is None:
        return f"identical: {extent}"
    found = result.divergence
    lines = [
        f"different at {found.t:.6f} s, record {found.number} ({extent} before it the same)",
        f"  after     {describe(found.cause)}",
        f"  recorded  {describe(found.expected)}",
        f"  now       {describe(found.actual)}",
    ]
    return "\n".join([*lines, *_fields(found)])


def describe(record: Record | None) -> str:
    """One record in one line: the bytes of what came and left, the JSON of what was decided."""
    if record is None:
        return "nothing"
    head = f"{record.kind} at {record.t:.6f} s:"
    if record.kind == rec.RX:
        rx = rec.read_rx(record)
        return f"{head} {rx.link} {_bytes(rx.data)}"
    if record.kind == rec.TX:
        tx = rec.read_tx(record)
        return f"{head} {tx.link} {_bytes(tx.data)} ({tx.reason})"
    if record.kind in rec.INPUTS:
        return " ".join([head, *rec.read_texts(record)])
    return f"{head} {record.payload.decode(errors='replace')[:400]}"


def _bytes(data: bytes) -> str:
    if all(0x20 <= byte < 0x7F for byte in data):
        return data.decode("ascii")
    return data.hex(" ")


def _fields(found: Divergence) -> list[str]:
    """Of two JSON records, the fields that differ."""
    pair = (found.expected, found.actual)
    if any(r is None or r.kind not in (rec.STEP, rec.ESTIMATE) for r in pair):
        return []
    try:
        old, new = (json.loads(r.payload) for r in pair if r is not None)
    except ValueError:
        return []
    keys = [key for key in old if old[key] != new.get(key)]
    return [f"  {key}: {json.dumps(old[key])} -> {json.dumps(new.get(key))}" for key in keys]
