"""GPS sentences (NMEA 0183): GGA and RMC of one epoch become one Fix; both can be encoded.

    $GNGGA,hhmmss.ss,ddmm.mmmm,N,dddmm.mmmm,E,q,nn,hdop,alt,M,sep,M,age,ref*hh CR LF
    $GNRMC,hhmmss.ss,A,ddmm.mmmm,N,dddmm.mmmm,E,knots,course,ddmmyy,var,E[,mode[,nav]]*hh CR LF

Rules:
  * Every sentence must carry its checksum. Without CR LF it is accepted if the checksum is right.
    Receivers send more than the standard's 82 characters; ``MAX_SENTENCE`` is the limit here.
  * Only GGA and RMC of satellite talkers are read, after the cheap checks. pynmea2 supplies their
    field tables and writes them. nmea_fields checks every value, since pynmea2 reads an empty
    latitude as 0.0, accepts 99 N, and returns a bad number as text.
  * GGA gives position, quality, HDOP, elevation; RMC speed, course, date. Either alone is enough.
    If one of them reports "invalid" (quality 0, 6, 7, 8; status V; mode E, M, N, S), the epoch
    gives no Fix. The last field of RMC (NMEA 4.1) is ignored: receivers always send V in it.
  * An epoch is complete with both, at the first sentence of another time, or after ``IDLE``.
    ``Fix.t`` is the arrival of its first sentence's first byte.
  * An epoch with the same time as the one before is refused. One with an earlier time is refused
    too, and becomes the new reference: a clock adjustment costs one epoch, and late sentences from
    a buffer do not move the position.
  * Accuracy (one sigma per axis) = HDOP x UERE x share of the quality / sqrt 2.

What does not live here: single fields (protocol.nmea_fields), whether to believe a fix
(mission.navigation), the serial port (links).
"""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import dataclass, field
from datetime import date

from protocol.messages import Fix, FrameFault
from protocol.nmea_fields import (
    TALKERS,
    Gga,
    Refusal,
    Refused,
    Rmc,
    encode_gga,
    encode_rmc,
    read_gga,
    read_rmc,
)

__all__ = ["Counters", "NmeaDecoder", "Refusal", "encode_gga", "encode_rmc"]

MAX_SENTENCE = 128  # bytes from $ to the last of the checksum
IDLE = 0.2  # s without a byte: the epoch is over, an unfinished sentence is given up
UERE = 3.5  # m, one sigma in the plane at HDOP 1, single-frequency receiver without corrections
UNKNOWN_HDOP = 5.0  # used if the receiver reports no HDOP, or 0.0
CONTRADICTION = 1e-5  # rad (64 m) between the GGA and the RMC of one epoch

_HALF_DAY, _DAY = 43200.0, 86400.0

_LINE_ENDS = (b"\r\n", b"")
_END = re.compile(rb"[^\x20-\x23\x25-\x7e]")  # a line end, another $, or a byte of no sentence
_USED = {f"${talker}{kind},".encode(): kind for talker in TALKERS for kind in ("GGA", "RMC")}
_HEX = {b"%02X" % n: n for n in range(256)} | {b"%02x" % n: n for n in range(256)}


@dataclass(slots=True)
class Counters:
    """``sentences`` are those with a right checksum, of any type; ``used`` are GGA and RMC."""

    sentences: int = 0
    used: int = 0
    fixes: int = 0
    refusals: Counter[Refusal] = field(default_factory=Counter)


@dataclass(slots=True)
class _Epoch:
    t: float
    second: float
    gga: Gga | None = None
    rmc: Rmc | None = None
    spoilt: bool = False


@dataclass(slots=True)
class _Run:
    """Successive bytes that belong to no accepted sentence."""

    offset: int
    end: int
    kind: str


class NmeaDecoder:
    """Decode one receiver's stream. ``uere``: m. ``not_before`` corrects the 1024-week rollover of
    old receivers: an earlier date is moved forward by whole rollovers. It affects ``Fix.utc`` only.
    """

    def __init__(self, uere: float = UERE, not_before: date | None = None) -> None:
        self.counters = Counters()
        self._uere = uere
        self._not_before = not_before
        self._buffer = b""
        self._begun = 0.0  # arrival of the first byte in the buffer
        self._offset = 0  # of the buffer's first byte in the stream
        self._run: _Run | None = None
        self._epoch: _Epoch | None = None
        self._last: float | None = None  # second of the day of the newest epoch with a position
        self._deadline: float | None = None
        self._idle_from = math.inf  # when the epoch is over if no more bytes come

    def receive(self, data: bytes, now: float) -> list[Fix | FrameFault]:
        out: list[Fix | FrameFault] = []
        if now >= self._idle_from and self._deadline is None:
            self._epoch = None
        begun, held = self._begun, len(self._buffer)
        buffer = self._buffer + data
        pos = 0
        while (start := buffer.find(b"$", pos)) >= 0:
            if start > pos:
                self._outside(buffer[pos:start], pos)
            end = _END.search(buffer, start + 1)
            stop = end.start() if end else len(buffer)
            if end is None and stop - start <= MAX_SENTENCE:
                pos = start
                break
            first = begun if start < held else now
            self._sentence(buffer[start:stop], start, buffer[stop : stop + 1], first, out)
            pos = stop
        else:
            if (rest := buffer[pos:]) not in _LINE_ENDS:
                self._outside(rest, pos)
            pos = len(buffer)
        self._begun = begun if pos < held else now
        self._buffer = buffer[pos:]
        self._offset += pos
        if data:
            self._idle_from = now + IDLE
            self._deadline = self._idle_from if self._is_waiting() else None
        return out

    def _is_waiting(self) -> bool:
        """Whether ``flush`` has anything to close: bytes, a run, or an epoch with a position."""
        epoch = self._epoch
        given = epoch is not None and (epoch.gga or epoch.rmc)
        return bool(self._buffer or self._run or given)

    def next_timer(self) -> float | None:
        return self._deadline

    def flush(self, now: float) -> list[Fix | FrameFault]:
        """Close what is open; does nothing before the time that ``next_timer`` returned."""
        out: list[Fix | FrameFault] = []
        if self._deadline is None or now < self._deadline:
            return out
        self._deadline = None
        if self._buffer:
            self._sentence(self._buffer, 0, b"", self._begun, out)
            self._offset += len(self._buffer)
            self._buffer = b""
        self._close_run(out)
        self._close_epoch(out)
        return out

    # --- bytes to sentences ---------------------------------------------------------------

    def _outside(self, skipped: bytes, at: int) -> None:
        """Note the bytes between sentences: anything but line ends is garbage."""
        inner = skipped.strip(b"\r\n")
        if not inner:
            return
        begin = at + skipped.index(inner)
        if self._run is None:
            self.counters.refusals[Refusal.GARBAGE] += 1
        self._fault(begin, begin + len(inner), Refusal.GARBAGE)

    def _fault(self, begin: int, end: int, reason: Refusal) -> None:
        if self._run is None:
            self._run = _Run(self._offset + begin, self._offset + end, reason.kind)
        else:
            self._run.end = self._offset + end

    def _close_run(self, out: list[Fix | FrameFault]) -> None:
        if (run := self._run) is not None:
            out.append(FrameFault(run.offset, run.kind, run.end - run.offset))
            self._run = None

    def _sentence(
        self, text: bytes, at: int, after: bytes, first: float, out: list[Fix | FrameFault]
    ) -> None:
        """``text`` from $ up to ``after``, the byte that ended it (none at a flush)."""
        try:
            found = self._parse(text, after)
        except Refused as refused:
            self.counters.refusals[refused.reason] += 1
            self._fault(at, at + len(text), refused.reason)
            return
        if self._run is not None:
            self._close_run(out)
        if found is not None:
            self._admit(found, first, out)

    def _parse(self, text: bytes, after: bytes) -> Gga | Rmc | None:
        if len(text) > MAX_SENTENCE:
            raise Refused(Refusal.OVERLONG)
        if after not in (b"\r", b"\n", b"$", b""):
            raise Refused(Refusal.CHARACTER)
        stated = _HEX.get(text[-2:]) if text[-3:-2] == b"*" else None
        if stated is None or stated != _xor(text[1:-3]):
            cut = after in (b"$", b"")
            missing = Refusal.NO_CHECKSUM if b"*" not in text else Refusal.CHECKSUM
            raise Refused(Refusal.CUT if cut else missing)
        self.counters.sentences += 1
        kind = _USED.get(text[:7])
        if kind is None:
            return None
        self.counters.used += 1
        fields = text[7:-3].decode("ascii").split(",")
        return read_gga(fields) if kind == "GGA" else read_rmc(fields, self._not_before)

    # --- sentences to fixes ---------------------------------------------------------------

    def _admit(self, found: Gga | Rmc, first: float, out: list[Fix | FrameFault]) -> None:
        epoch = self._epoch
        if epoch is None or epoch.second != found.second:
            self._close_epoch(out)
            if found.position is not None and (reason := self._out_of_order(found.second)):
                self.counters.refusals[reason] += 1
                return
            self._epoch = epoch = _Epoch(first, found.second)
        if found.position is None:
            self.counters.refusals[Refusal.NO_FIX] += 1
            epoch.spoilt = True
        elif isinstance(found, Gga):
            epoch.gga = epoch.gga or found  # several talkers in one epoch: the first counts
        else:
            epoch.rmc = epoch.rmc or found
        if epoch.gga and epoch.rmc:
            self._close_epoch(out)

    def _out_of_order(self, second: float) -> Refusal | None:
        """Return why this time is refused, or None. It becomes the new reference. A difference of
        half a day or more counts as a midnight between."""
        last, self._last = self._last, second
        if last is None:
            return None
        step = (second - last + _HALF_DAY) % _DAY - _HALF_DAY
        if step == 0.0:
            return Refusal.REPEATED
        return Refusal.TIME_BACK if step < 0.0 else None

    def _close_epoch(self, out: list[Fix | FrameFault]) -> None:
        epoch, self._epoch = self._epoch, None
        if epoch is None or not (epoch.gga or epoch.rmc):
            return
        if epoch.spoilt or _apart(epoch.gga, epoch.rmc):
            self.counters.refusals[Refusal.CONTRADICTION] += 1
            return
        self.counters.fixes += 1
        out.append(_fix(epoch, self._uere))


def _fix(epoch: _Epoch, uere: float) -> Fix:
    gga, rmc = epoch.gga, epoch.rmc
    one = gga or rmc
    assert one is not None
    assert one.position is not None
    hdop = gga.hdop if gga else None
    share = gga.share if gga else 1.0
    return Fix(
        t=epoch.t,
        latitude=one.position[0],
        longitude=one.position[1],
        accuracy=(hdop or UNKNOWN_HDOP) * uere * share / math.sqrt(2.0),
        speed=rmc.speed if rmc else None,
        course=rmc.course if rmc else None,
        hdop=hdop,
        elevation=gga.elevation if gga else None,
        satellites=gga.satellites if gga else None,
        utc=rmc.utc if rmc else None,
    )


def _apart(gga: Gga | None, rmc: Rmc | None) -> bool:
    if gga is None or rmc is None or gga.position is None or rmc.position is None:
        return False
    east = (gga.position[1] - rmc.position[1] + math.pi) % math.tau - math.pi
    east *= math.cos(gga.position[0])
    return math.hypot(gga.position[0] - rmc.position[0], east) > CONTRADICTION


def _xor(body: bytes) -> int:
    """XOR of all bytes, at most 128, by folding one big integer: a tenth of the time of a loop."""
    n = int.from_bytes(body, "little")
    n ^= n >> 512
    n ^= n >> 256
    n ^= n >> 128
    n ^= n >> 64
    n ^= n >> 32
    n ^= n >> 16
    return (n ^ n >> 8) & 0xFF
