"""Finding frames in a stream of bytes: synchronise, delimit, check, give up.

Rules (docs/protocol.md): frames with binary bytes are delimited by length (G1); a candidate that
fails costs ONE byte (G2); what stays unfinished is given up after an idle time (G3). Bytes that
belong to no accepted frame form runs, as long as can be; a run is one FrameFault with the kind of
its first candidate (``bad_header`` where there was none), reported when the run ends.

    bytes -> [lead found? -> measured? -> checked?] -> Frame
                  | no           | no, wait    | no: one byte into the run, on at the next

Decisions depend on the bytes alone, never on how they were cut, so any chunking gives the same
frames. A candidate has at most its type's length, so the work is linear in the bytes.

A guest frame spliced into a host frame (vehicle-facts: an ``@ACK_`` printed in the middle of an
``@SD``) is taken out and the host tried again without it.

What does not live here: what a frame means (tables), clocks (``now`` is a parameter).
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, cast

from protocol.fields import FaultKind, FrameType, Values
from protocol.messages import FrameFault
from protocol.tolerances import Tolerances

SERIAL_IDLE = 0.05  # s
MOST_GUESTS = 4  # acknowledgements spliced into one host: more cannot come in 90 ms


class Frame(NamedTuple):
    """An accepted frame; ``t`` is when its first byte came. A tuple, as millions are made."""

    type: FrameType
    raw: bytes  # without spliced guests
    offset: int  # from the start of the stream
    t: float

    def values(self) -> Values:
        return self.type.decode(self.raw)


@dataclass(slots=True)
class Counters:
    """What a link has carried so far; ``bad`` counts faults by kind."""

    good: int = 0
    skipped: int = 0  # bytes of these faults
    bad: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Splice:
    """Which frame may be torn by which: both of fixed length."""

    host: FrameType
    guest: FrameType


@dataclass(frozen=True, slots=True)
class Shortcut:
    """Messages in place of Frames, and the frame that a link mostly carries read in one go.

    ``read(data, at, t)`` is asked where at least ``length`` bytes stand and the first one is the
    lead's. It gives the message of a whole and flawless frame, or None: the ordinary way decides,
    whose frames ``message`` turns into messages.
    """

    lead: bytes
    length: int
    read: Callable[[bytes, int, float], object | None]
    message: Callable[[Frame], object]


@dataclass(frozen=True, slots=True)
class LinkRow:
    """A link of docs/protocol.md section 7: which frames a decoder may meet there.

    ``frames`` may list several types with the same lead; the shorter complete candidate is tried
    first. ``line``: the input is text, one datagram a line, which this turns into bytes.
    """

    name: str
    frames: Callable[[Tolerances], Sequence[FrameType]]
    idle: float = SERIAL_IDLE
    splice: tuple[str, str] | None = None  # names of host and guest
    line: Callable[[str], bytes] | None = None

    def framer(
        self, tolerances: Tolerances | None = None, shortcut: Shortcut | None = None
    ) -> Framer:
        types = tuple(self.frames(tolerances or Tolerances()))
        splice = None
        if self.splice is not None:
            named = {frame.name: frame for frame in types}
            splice = Splice(*(named[name] for name in self.splice))
        return Framer(types, idle=self.idle, splice=splice, shortcut=shortcut)


class Framer:
    """``receive`` and ``flush`` yield frames and faults in the order of their offsets."""

    def __init__(
        self,
        types: Sequence[FrameType],
        *,
        idle: float = SERIAL_IDLE,
        splice: Splice | None = None,
        shortcut: Shortcut | None = None,
    ) -> None:
        self.types = tuple(sorted(types, key=lambda t: -len(t.lead)))  # longest lead first
        self.idle, self.splice, self.counters = idle, splice, Counters()
        self._shortcut = shortcut or _NO_SHORTCUT
        self._message = shortcut.message if shortcut is not None else None
        self._by_start: dict[bytes, tuple[FrameType, ...]] = {}
        for size in (1, 2):
            for start in {t.lead[:size] for t in self.types}:
                near = (t for t in self.types if t.lead[:size] == start[: len(t.lead)])
                self._by_start[start] = tuple(near)
        self._next_start = _finder({t.lead[:1] for t in self.types})
        self._buffer = b""
        self._base = 0  # offset of the buffer's first byte in the stream
        self._starts: list[int] = []  # offsets at which chunks began ...
        self._times: list[float] = []  # ... and when they came
        self._run_offset = self._run_length = 0
        self._run_kind: FaultKind | None = None
        self._out: list[Any] = []

    def receive(self, data: bytes, now: float) -> list[Frame | FrameFault]:
        if not data:
            return []
        self._starts.append(self._base + len(self._buffer))
        self._times.append(now)
        self._buffer = self._buffer + data if self._buffer else bytes(data)
        return self._parse(final=False)

    def next_timer(self) -> float | None:
        """When unfinished bytes or an open run have been idle for long enough."""
        if not self._buffer and not self._run_length:
            return None
        return self._times[-1] + self.idle

    def flush(self, now: float) -> list[Frame | FrameFault]:
        """Give up what is unfinished, if the link has been idle long enough by ``now``."""
        due = self.next_timer()
        return [] if due is None or now < due else self._parse(final=True)

    # --- the scan ---

    def _parse(self, *, final: bool) -> list[Any]:
        data, at, base = self._buffer, 0, self._base
        end = len(data)
        out, next_start = self._out, self._next_start
        read, length, lead = self._shortcut.read, self._shortcut.length, self._shortcut.lead[0]
        last = end - length  # where the shortcut's frame can begin at most
        newest, now = self._starts[-1] - base, self._times[-1]
        direct = 0  # frames that took the shortcut
        while at < end:
            if at <= last and data[at] == lead:
                message = read(data, at, now if at >= newest else self._time(base + at))
                if message is not None:
                    if self._run_length:
                        self._close_run()
                    out.append(message)
                    direct += 1
                    at += length
                    continue
            start = next_start(data, at)
            if start != at:
                stop = end if start < 0 else start
                if not self._run_length:
                    self._run_offset = base + at
                self._run_length += stop - at
                at = stop
                continue
            used = self._candidate(data, at, end, final)
            if used is None:
                break
            at += used
        self.counters.good += direct
        self._base = base + at
        self._buffer = data[at:]
        if final:
            self._close_run()
        if len(self._times) > 1:
            self._forget()
        self._out = []
        return out

    def _candidate(self, data: bytes, at: int, end: int, final: bool) -> int | None:
        """Bytes used: an accepted frame's, or one that is skipped; None to wait for more."""
        near = self._by_start.get(data[at : at + 2]) or self._by_start.get(data[at : at + 1], ())
        kinds: list[FaultKind] = []  # in the order of the types: the first one counts
        complete: list[tuple[int, int, FrameType]] = []
        unfinished = False
        for frame in near:
            if data.startswith(frame.lead, at):
                length = frame.measure(data, at, end)
                if isinstance(length, FaultKind):
                    kinds.append(length)
                    continue
                if length:
                    complete.append((length, len(kinds), frame))
                else:
                    unfinished = True
                kinds.append(FaultKind.TRUNCATED)
            elif end - at < len(frame.lead) and frame.lead.startswith(data[at:end]):
                unfinished = True
                kinds.append(FaultKind.TRUNCATED)
        complete.sort(key=_by_length)
        for length, order, frame in complete:
            raw = data[at : at + length]
            kind = frame.check(raw)
            if kind is None:
                self._emit(frame, raw, at)
                return length
            kinds[order] = kind
        if unfinished and not final:
            return None
        if self.splice is not None:
            used = self._unsplice(data, at, end, final)
            if used != 0:
                return used
        self._skip(at, kinds[0] if kinds else None)
        return 1

    def _emit(self, frame: FrameType, raw: bytes, at: int) -> None:
        self._close_run()
        offset = self._base + at
        found = Frame(frame, raw, offset, self._time(offset))
        self._out.append(found if self._message is None else self._message(found))
        self.counters.good += 1

    # --- guests inside a host ---

    def _unsplice(self, data: bytes, at: int, end: int, final: bool) -> int | None:
        """Bytes used by a host and its guests, 0 if there is none, None to wait for more."""
        assert self.splice is not None
        host, guest = self.splice.host, self.splice.guest
        if not _may_be_torn(data, at, end, host.lead, guest.lead):
            return 0
        parts: list[bytes] = []
        guests: list[tuple[int, bytes]] = []
        missing, position = host.length, at  # missing: bytes of the host still to be found
        while len(guests) < MOST_GUESTS:
            stop = position + missing + len(guest.lead) - 1
            found = data.find(guest.lead, max(position, at + 1), min(stop, end))
            if found < 0:
                break
            raw = data[found : found + guest.length]
            if len(raw) < guest.length or guest.check(raw) is not None:
                break
            parts.append(data[position:found])
            guests.append((found, raw))
            missing -= found - position
            position = found + guest.length
        parts.append(data[position : position + missing])
        used = position + missing - at
        if at + used > end or (
            not final and _could_be_guest(data, position, at + used, end, guest)
        ):
            return 0 if final else None
        raw = b"".join(parts)
        if not guests or not raw.startswith(host.lead) or host.check(raw) is not None:
            return 0
        self._emit(host, raw, at)
        for found, raw in guests:
            self._emit(guest, raw, found)
        return used

    # --- runs of bytes that are no frame ---

    def _skip(self, at: int, kind: FaultKind | None) -> None:
        if not self._run_length:
            self._run_offset = self._base + at
        self._run_length += 1
        if self._run_kind is None:
            self._run_kind = kind

    def _close_run(self) -> None:
        if not self._run_length:
            return
        kind = "bad_header" if self._run_kind is None else self._run_kind.value
        self._out.append(_fault(self._run_offset, kind, self._run_length))
        counters = self.counters
        counters.skipped += self._run_length
        counters.bad[kind] = counters.bad.get(kind, 0) + 1
        self._run_length, self._run_kind = 0, None

    # --- when a byte came ---

    def _time(self, offset: int) -> float:
        if len(self._times) == 1:
            return self._times[0]
        return self._times[bisect_right(self._starts, offset) - 1]

    def _forget(self) -> None:
        """Chunks whose bytes are all gone; the newest one stays, for ``next_timer``."""
        gone = min(bisect_right(self._starts, self._base) - 1, len(self._starts) - 1)
        if gone > 0:
            del self._starts[:gone], self._times[:gone]


def _finder(firsts: set[bytes]) -> Callable[[bytes, int], int]:
    """Where the next frame can begin, -1 for nowhere."""
    if len(firsts) == 1:
        (first,) = firsts
        return lambda data, at: data.find(first, at)
    search = re.compile(b"[" + b"".join(map(re.escape, sorted(firsts))) + b"]").search

    def find(data: bytes, at: int) -> int:
        found = search(data, at)
        return -1 if found is None else found.start()

    return find


# Longer than any buffer: nothing is read by it.
_NO_SHORTCUT = Shortcut(b"\0", 1 << 62, lambda data, at, t: None, lambda frame: frame)


class _Draft:
    """A FrameFault while it is filled: setting slots of a frozen class costs thrice as much."""

    __slots__ = FrameFault.__slots__


def _fault(offset: int, kind: str, length: int) -> FrameFault:
    draft: Any = _Draft()
    draft.offset, draft.kind, draft.length = offset, kind, length
    draft.__class__ = FrameFault
    return cast("FrameFault", draft)


def _by_length(candidate: tuple[int, int, FrameType]) -> tuple[int, int]:
    return candidate[:2]


def _may_be_torn(data: bytes, at: int, end: int, lead: bytes, guest: bytes) -> bool:
    """The host's lead, or a part of it with a guest behind."""
    if data.startswith(lead, at):
        return True
    return any(
        data.startswith(lead[:n], at) and data.startswith(guest[: end - at - n], at + n)
        for n in range(1, len(lead))
        if end - at > n
    )


def _could_be_guest(data: bytes, position: int, stop: int, end: int, guest: FrameType) -> bool:
    """A guest that begins in the host's last bytes and is not all there yet."""
    first = max(position, end - guest.length + 1)
    return any(
        guest.lead.startswith(data[i : i + len(guest.lead)]) for i in range(first, min(stop, end))
    )
