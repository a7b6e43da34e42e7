"""Find frames in a stream of bytes: synchronise, delimit, check, give up.

Rules (docs/rules.md): frames with binary bytes are delimited by length (G1); a candidate that
fails costs ONE byte (G2); an unfinished candidate is given up after an idle time (G3). Successive
bytes that belong to no accepted frame form one run. When the run ends it is reported as one
FrameFault, with the kind of its first candidate (``bad_header`` if there was none).

    bytes -> [lead found? -> measured? -> checked?] -> Frame
                  | no           | no, wait    | no: one byte into the run, continue at the next

Decisions depend on the bytes alone: any split into chunks gives the same frames. A candidate is at
most as long as its type allows, so the work is linear in the bytes.

A guest frame spliced into a host frame (as built: an ``@ACK_`` printed in the middle of an
``@SD``) is taken out, and the host is tried again without it.

What does not live here: what a frame means (tables), clocks (``now`` is a parameter).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from protocol.fields import FaultKind, FrameType, Values
from protocol.messages import FrameFault
from protocol.starts import by_start, finder
from protocol.tolerances import Tolerances

SERIAL_IDLE = 0.05  # s
PATIENCE = 1.0  # s for the whole of a frame: the longest text takes 0.5 s at 9600 baud
MOST_GUESTS = 4  # acknowledgements spliced into one host: more cannot come in 90 ms


class Frame(NamedTuple):
    """An accepted frame; ``t``: arrival of its first byte. A tuple, as logs have millions."""

    type: FrameType
    raw: bytes  # without spliced guests
    offset: int  # from the start of the stream
    t: float

    def values(self) -> Values:
        return self.type.decode(self.raw)


# The result at one place in the buffer: bytes used (0: wait for more), the messages of the frames
# there, and if there are none, the fault's kind.
_Step = tuple[int, tuple[object, ...], FaultKind | None]
_WAIT: _Step = (0, (), None)
_NOTHING: _Step = (1, (), None)


@dataclass(slots=True)
class Counters:
    """Frames and faults of a link so far; ``bad`` counts faults by kind."""

    good: int = 0
    skipped: int = 0  # bytes of these faults
    bad: dict[str, int] = field(default_factory=dict)

    def note(self, kind: str, faults: int, length: int) -> None:
        self.bad[kind] = self.bad.get(kind, 0) + faults
        self.skipped += length


@dataclass(frozen=True, slots=True)
class Splice:
    """A ``guest`` frame may be inserted into a ``host`` frame; both have a fixed length."""

    host: FrameType
    guest: FrameType


# Messages and faults in their order, how many of them are faults, and where the last frame ends.
Stretch = tuple[Sequence[object], int, int]


@dataclass(frozen=True, slots=True)
class Shortcut:
    """A fast path for a link's most frequent frame; the framer then returns messages, not Frames.

    The framer calls ``read(data, at, last, base, t)`` where the lead's first byte is, with at least
    ``length`` bytes from there on. ``read`` takes flawless frames that begin at ``last`` or before,
    and noise between them in which no frame could begin. ``base``: offset of ``data`` in the
    stream. The framer scans everything else as usual; ``message`` turns those frames into messages.
    """

    lead: bytes
    length: int
    read: Callable[[bytes, int, int, int, float], Stretch]
    message: Callable[[Frame], object]

    def __deepcopy__(self, memo: object) -> Shortcut:
        """Return itself: mypyc would set the attributes of a copy, which is frozen."""
        return self


@dataclass(frozen=True, slots=True)
class LinkRow:
    """A link of docs/protocol.md: which frames a decoder may meet there.

    ``frames`` may list several types with the same lead; the shorter complete candidate is tried
    first. ``line``: turns a line of text into bytes; the input then has one datagram per line.
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
    """Find frames in one stream. ``receive`` and ``flush`` return frames and faults by offset.

    An unfinished candidate is given up after ``idle`` s without a byte, and ``patience`` s after
    its first byte: bytes that arrive slowly do not hold it open (G3).
    """

    def __init__(
        self,
        types: Sequence[FrameType],
        *,
        idle: float = SERIAL_IDLE,
        patience: float = PATIENCE,
        splice: Splice | None = None,
        shortcut: Shortcut | None = None,
    ) -> None:
        self.types = tuple(sorted(types, key=lambda t: -len(t.lead)))  # longest lead first
        self.idle, self.patience = idle, patience
        self.splice, self.counters = splice, Counters()
        self._shortcut = shortcut or _NO_SHORTCUT
        self._message = shortcut.message if shortcut is not None else None
        torn = b"" if splice is None else splice.host.lead[:1] + splice.guest.lead[:1]
        self._by_start = by_start(self.types, torn)
        self._finder = finder({t.lead[:1] for t in self.types})
        self.buffer = b""
        self._base = 0  # offset of the buffer's first byte in the stream
        self._fresh = 0  # candidates that begin before this offset are not waited for any more
        self.starts: list[int] = []  # offsets at which chunks began ...
        self.times: list[float] = []  # ... and when they came
        self._run: int | None = None  # where the open run of bytes that are no frame began ...
        self._run_kind: FaultKind | None = None  # ... and its first candidate's fault

    def receive(self, data: bytes, now: float) -> list[Frame | FrameFault]:
        if not data:
            return []
        if self.buffer:
            self.starts.append(self._base + len(self.buffer))
            self.times.append(now)
            self.buffer += data
        else:
            self.starts, self.times, self.buffer = [self._base], [now], bytes(data)
        return self._parse(final=False)

    def next_timer(self) -> float | None:
        """Return when to ``flush`` unfinished bytes or an open run, None if there are none."""
        if not self.buffer:
            return None if self._run is None else self.times[-1] + self.idle
        return min(self.times[-1] + self.idle, self._time(self._base) + self.patience)

    def flush(self, now: float) -> list[Frame | FrameFault]:
        """Give up what is unfinished: all of it if the link has been idle for ``idle`` s, else
        the bytes that came ``patience`` s ago or earlier."""
        due = self.next_timer()
        if due is None or now < due:
            return []
        chunks = zip(self.starts, self.times, strict=True)
        fresh = (start for start, t in chunks if t + self.patience > now)
        self._fresh = next(fresh, self._base + len(self.buffer))
        return self._parse(final=now >= self.times[-1] + self.idle)

    # --- the scan ---

    def _parse(self, *, final: bool) -> list[Any]:
        data, at, base = self.buffer, 0, self._base
        end, run, run_kind = len(data), self._run, self._run_kind
        read, length, lead = self._shortcut.read, self._shortcut.length, self._shortcut.lead[0]
        last = end - length  # the last place where the shortcut's frame can begin
        newest, now = self.starts[-1] - base, self.times[-1]
        next_start, counters = self._finder(data), self.counters
        out: list[Any] = []
        while at < end:
            items: Sequence[object] = ()
            gaps = 0
            if data[at] == lead and at <= last:
                if at < newest:  # one frame: the next one may have come with another chunk
                    items, gaps, stop = read(data, at, at, base, self._time(base + at))
                else:
                    items, gaps, stop = read(data, at, last, base, now)
            if not items:
                start = next_start(at)
                if start == at:
                    used, items, kind = self.candidate(data, at, end, final)
                    if not used:
                        break
                    run_kind, stop = run_kind or kind, at + used
                else:
                    stop = end if start < 0 else start
            if items:
                if run is not None:
                    out.append(self._fault(run, run_kind, base + at))
                    run = run_kind = None
                out += items
                counters.good += len(items) - gaps
                if gaps:
                    counters.note("bad_header", gaps, stop - at - length * (len(items) - gaps))
            elif run is None:
                run = base + at
            at = stop
        if final and run is not None:
            out.append(self._fault(run, run_kind, base + at))
            run = run_kind = None
        self._run, self._run_kind = run, run_kind
        self._base, self.buffer = base + at, data[at:]
        if len(self.times) > 1:
            self._forget()
        return out

    def candidate(self, data: bytes, at: int, end: int, final: bool) -> _Step:
        near = self._by_start.get(data[at : at + 2])
        if near is None:
            return _NOTHING
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
                return length, (self._accepted(frame, raw, at),), None
            kinds[order] = kind
        final = final or self._base + at < self._fresh
        if unfinished and not final:
            return _WAIT
        torn = None if self.splice is None else self._unsplice(data, at, end, final)
        return torn or (1, (), kinds[0] if kinds else None)

    def _accepted(self, frame: FrameType, raw: bytes, at: int) -> object:
        offset = self._base + at
        found = Frame(frame, raw, offset, self._time(offset))
        return found if self._message is None else self._message(found)

    def _fault(self, run: int, kind: FaultKind | None, stop: int) -> FrameFault:
        """Count and return the fault for the bytes from ``run`` to ``stop``."""
        name = "bad_header" if kind is None else kind.value
        self.counters.note(name, 1, stop - run)
        return fault(run, name, stop - run)

    # --- guests inside a host ---

    def _unsplice(self, data: bytes, at: int, end: int, final: bool) -> _Step | None:
        """Return a host and its guests, None if they are not there."""
        assert self.splice is not None
        host, guest = self.splice.host, self.splice.guest
        if not _may_be_torn(data, at, end, host.lead, guest.lead):
            return None
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
            return None if final else _WAIT
        raw = b"".join(parts)
        if not guests or not raw.startswith(host.lead) or host.check(raw) is not None:
            return None
        torn = (self._accepted(guest, raw, found) for found, raw in guests)
        return used, (self._accepted(host, raw, at), *torn), None

    # --- when a byte came ---

    def _time(self, offset: int) -> float:
        if len(self.times) == 1:
            return self.times[0]
        return self.times[bisect_right(self.starts, offset) - 1]

    def _forget(self) -> None:
        """Drop chunks whose bytes are all used; keep the newest one, for ``next_timer``."""
        gone = bisect_right(self.starts, self._base) - 1
        del self.starts[:gone], self.times[:gone]


def fault(offset: int, kind: str, length: int) -> FrameFault:
    """Make a FrameFault without its constructor, which is slower."""
    return tuple.__new__(FrameFault, (offset, kind, length))


def no_stretch(data: bytes, at: int, last: int, base: int, t: float) -> Stretch:
    """A ``Shortcut.read`` that takes nothing: the framer scans everything as usual."""
    return (), 0, at


def _as_it_is(frame: object) -> object:
    return frame


_NO_SHORTCUT = Shortcut(b"\0", 0, no_stretch, _as_it_is)


def _by_length(candidate: tuple[int, int, FrameType]) -> tuple[int, int]:
    return candidate[:2]


def _may_be_torn(data: bytes, at: int, end: int, lead: bytes, guest: bytes) -> bool:
    """Whether the host's lead is here, or a part of it followed by a guest's lead."""
    if data.startswith(lead, at):
        return True
    return any(
        data.startswith(lead[:n], at) and data.startswith(guest[: end - at - n], at + n)
        for n in range(1, len(lead))
        if end - at > n
    )


def _could_be_guest(data: bytes, position: int, stop: int, end: int, guest: FrameType) -> bool:
    """Whether a guest may begin in the host's last bytes, of which the rest is still to come."""
    first = max(position, end - guest.length + 1)
    return any(
        guest.lead.startswith(data[i : i + len(guest.lead)]) for i in range(first, min(stop, end))
    )
