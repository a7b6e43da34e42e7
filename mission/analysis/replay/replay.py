"""Replay: the recorded inputs through the same runtime, compared with what it recorded then.

    start --> Runtime; every input, in order --> what it records now == what stands in the file

Everything is compared to the last bit: kinds, times, payloads and their order. The file may end
anywhere (a power cut): records that the runtime makes beyond that end do not count as missing. Only
the program's version in the start record may differ; it is reported. For a recording of the first
form, the kinds of records that it lacks are left out.

Another kind of processor multiplies the filter's matrices with other instructions, and the last
digits of estimates differ (an aarch64 Pi, an x86-64 laptop). On request, estimates are compared to
``ROUNDING``, and the greatest difference is reported; all else is compared to the last bit.

After missing records the comparison continues if only outputs of the inputs before them can be
missing. Else it ends there, and says so.

    ReplayError        (the operator must act: nothing to begin with, or from another version)

What does not live here: files (blackbox), how a runtime is made again (rerun).
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from mission import __version__
from mission.analysis.replay.rerun import failed_writes, feed, runtime_from
from mission.model import Record
from mission.onboard.blackbox import Gap
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.stream.events import frame_text

ROUNDING = 1e-9  # relative to a number, or to 1 if it is smaller


class ReplayError(ValueError):
    pass


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first record that differs. ``cause``: the input that led to it. ``expected`` is None if
    nothing was recorded there, ``actual`` if nothing comes there now."""

    number: int  # of the record in the recording, from 0
    cause: Record
    expected: Record | None
    actual: Record | None

    @property
    def t(self) -> float:
        return (self.expected or self.actual or self.cause).t


@dataclass(frozen=True, slots=True)
class Replayed:
    records: int  # records compared
    inputs: int
    until: float  # s, the engine's time of the last one
    version: str  # the program that recorded it
    divergence: Divergence | None
    gaps: tuple[Gap, ...] = ()  # all gaps of the recording; after ``until`` nothing was compared
    beyond: int = 0  # whole records after the gap that ended the comparison
    rounded: int = 0  # estimates that are equal only to rounding
    apart: float = 0.0  # their greatest difference, on the scale of ``ROUNDING``

    @property
    def identical(self) -> bool:
        """All records are there, were compared, and are equal to the last bit."""
        return self.whole and not self.rounded

    @property
    def whole(self) -> bool:
        """All records are there, were compared, and are equal to the tolerance asked for."""
        return self.same and all(gap.whole for gap in self.gaps)

    @property
    def same(self) -> bool:
        """No difference as far as records could be compared."""
        return self.divergence is None


def replay(recording: Sequence[Record | Gap], rounded: bool = False) -> Replayed:
    """Replay a recording. ``rounded``: estimates may differ by ``ROUNDING``. Raises ReplayError."""
    records = [item for item in recording if isinstance(item, Record)]
    start = _start(recording)
    again = rec.ListRecorder()
    try:
        runtime = runtime_from(start, failed_writes(records), again)
    except ValueError as error:
        raise ReplayError(f"recorded by version {start.version}: {error}") from error
    return _Comparison(start, runtime, again, records[0], rounded).run(recording)


class _Comparison:
    """The records that the runtime makes again, beside the recorded ones."""

    def __init__(
        self,
        start: rec.Start,
        runtime: Runtime,
        again: rec.ListRecorder,
        first: Record,
        rounded: bool,
    ) -> None:
        self._version, self._runtime, self._again = start.version, runtime, again
        self._left_out = rec.SINCE_FORM_2 if start.form < rec.FORM else frozenset[str]()
        self._produced: deque[Record] = deque()
        self._cause, self._inputs, self._until, self._number = first, 0, 0.0, 0
        self._tolerance = ROUNDING if rounded else 0.0
        self._rounded, self._apart = 0, 0.0

    def run(self, recording: Sequence[Record | Gap]) -> Replayed:
        gaps = tuple(item for item in recording if isinstance(item, Gap))
        for place, item in enumerate(recording):
            if isinstance(item, Gap):
                if not self._passes(item):
                    rest = sum(isinstance(one, Record) for one in recording[place:])
                    return self._result(gaps, beyond=rest)
            elif (divergence := self._compare(item)) is not None:
                return self._result(gaps, divergence)
        return self._result(gaps)

    def _result(
        self, gaps: tuple[Gap, ...], divergence: Divergence | None = None, beyond: int = 0
    ) -> Replayed:
        return Replayed(
            self._number,
            self._inputs,
            self._until,
            self._version,
            divergence,
            gaps,
            beyond,
            self._rounded,
            self._apart,
        )

    def _compare(self, record: Record) -> Divergence | None:
        self._take()
        if record.kind in rec.INPUTS and record.kind != rec.STORE:
            if self._produced:  # the inputs before made more than was recorded
                return Divergence(self._number, self._cause, record, self._produced[0])
            self._cause, self._inputs = record, self._inputs + 1
            feed(self._runtime, record)
            self._take()
        actual = self._produced[0] if self._produced else None
        if actual is None or not self._same(record, actual):
            return Divergence(self._number, self._cause, record, actual)
        self._produced.popleft()
        self._number, self._until = self._number + 1, record.t
        return None

    def _same(self, recorded: Record, now: Record) -> bool:
        if _same(recorded, now):
            return True
        apart = _apart(recorded, now) if self._tolerance else math.inf
        if apart > self._tolerance:
            return False
        self._rounded, self._apart = self._rounded + 1, max(self._apart, apart)
        return True

    def _take(self) -> None:
        made = self._again.records
        self._produced.extend(one for one in made if one.kind not in self._left_out)
        made.clear()

    def _passes(self, gap: Gap) -> bool:
        """Whether the comparison can continue after the gap: the missing records are outputs that
        wait here."""
        self._take()
        if gap.records is None or gap.records > len(self._produced):
            return gap.cut
        for _ in range(gap.records):
            self._produced.popleft()
        return True


def _start(recording: Sequence[Record | Gap]) -> rec.Start:
    first = recording[0] if recording else None
    if not isinstance(first, Record) or first.kind != rec.START:
        raise ReplayError("there is no whole start record: nothing can be replayed from it")
    try:
        return rec.read_start(first)
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


def _apart(recorded: Record, now: Record) -> float:
    """Return the greatest difference between the numbers of two estimates, each relative to the
    greater number or to 1; infinite if anything else differs."""
    if not recorded.kind == now.kind == rec.ESTIMATE or not _same(
        recorded, replace(now, payload=recorded.payload)
    ):
        return math.inf
    return _between(json.loads(recorded.payload), json.loads(now.payload))


def _between(one: Any, other: Any) -> float:
    if isinstance(one, float) and isinstance(other, float) and math.isfinite(one - other):
        return abs(one - other) / max(abs(one), abs(other), 1.0)
    if isinstance(one, dict) and isinstance(other, dict) and list(one) == list(other):
        return max((_between(one[key], other[key]) for key in one), default=0.0)
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        return max(map(_between, one, other), default=0.0)
    return 0.0 if one == other and type(one) is type(other) else math.inf


# --- in words ------------------------------------------------------------------------------------


def summary(result: Replayed) -> str:
    other = f", recorded by version {result.version}" if result.version != __version__ else ""
    extent = f"{result.records} records, {result.inputs} inputs, {result.until:.3f} s{other}"
    if result.rounded:
        extent += f"; {result.rounded} estimates to rounding, {result.apart:.1g} apart at most"
    if result.whole:
        return f"{'the same' if result.rounded else 'identical'}: {extent}"
    if result.divergence is None:
        head = f"the same as far as it can be compared: {extent}"
        return "\n".join([head, *_not_compared(result)])
    found = result.divergence
    lines = [
        f"different at {found.t:.6f} s, record {found.number} ({extent} before it the same)",
        f"  after     {describe(found.cause)}",
        f"  recorded  {describe(found.expected)}",
        f"  now       {describe(found.actual)}",
    ]
    return "\n".join([*lines, *_fields(found), *_hint(found)])


def _hint(found: Divergence) -> Iterator[str]:
    if found.expected and found.actual and _apart(found.expected, found.actual) <= ROUNDING:
        yield "  in the last digits only: another kind of processor recorded it? --rounded goes on"


def _not_compared(result: Replayed) -> Iterator[str]:
    for gap in result.gaps:
        if not gap.whole:
            yield f"  missing   {gap}"
    if result.beyond:
        yield (
            f"  behind {result.until:.3f} s nothing could be compared: inputs are missing; "
            f"{result.beyond} records are there and can be read"
        )


def describe(record: Record | None) -> str:
    """Describe one record in one line: the bytes received or sent, the JSON of a decision."""
    if record is None:
        return "nothing"
    head = f"{record.kind} at {record.t:.6f} s:"
    if record.kind == rec.RX:
        rx = rec.read_rx(record)
        return f"{head} {rx.link} {frame_text(rx.data)}"
    if record.kind == rec.TX:
        tx = rec.read_tx(record)
        return f"{head} {tx.link} {frame_text(tx.data)} ({tx.reason})"
    if record.kind in rec.INPUTS:
        return " ".join([head, *rec.read_texts(record)])
    return f"{head} {record.payload.decode(errors='replace')[:400]}"


def _fields(found: Divergence) -> list[str]:
    """Return the fields in which two JSON records differ."""
    pair = (found.expected, found.actual)
    if any(r is None or r.kind not in (rec.STEP, rec.ESTIMATE) for r in pair):
        return []
    try:
        old, new = (json.loads(r.payload) for r in pair if r is not None)
    except ValueError:
        return []
    keys = [key for key in old if old[key] != new.get(key)]
    return [f"  {key}: {json.dumps(old[key])} -> {json.dumps(new.get(key))}" for key in keys]
