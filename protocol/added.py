"""Sensors that a user adds on a separate line: their sentences and ensembles become Aids.

    $--VHW,deg,T,deg,M,knots,N,km/h,K*hh             speed through the water
    $--VBW,knots,knots,A,knots,knots,A[,...]*hh      ahead and across: in the water, over ground
    $--GLL, $--GGA                                   position from an acoustic positioning system
    $CAMPR,number,own,seconds*hh                     one-way travel time from a beacon: an acoustic
                                                     modem (WHOI Micro-Modem, answer to a ping)
    :WS,mm/s,mm/s,mm/s,A   :BS,...                   a Doppler log (PD6): starboard, ahead, up;
                                                     through the water, and over ground
    7F 7F ...                                        the same, binary (PD0)

A line ends with CR or LF. An NMEA sentence must carry its checksum. PD6 has no checksum, so each of
its fields must be well-formed. A value that the sensor itself marks as invalid (V, 99999 and
similar) gives no Aid. Other sentences are ignored; anything that is no sentence is a FrameFault. A
binary ensemble begins at its mark, and its header gives its length.

What does not live here: whether an Aid is believed (mission.navigation.added), the GPS receiver
(nmea), the contents of an ensemble (pd0).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

from protocol import pd0
from protocol.messages import Aid, FrameFault
from protocol.nmea_fields import KNOT, Refused, read_gga, read_gll

WATER, GROUND, PLACE = "water", "ground", "place"  # the kinds of Aids
RANGE = "range"
LONGEST = 160  # bytes of a line
UNFINISHED = 1.0  # s after its first byte: an unfinished line is given up (G3)
FASTEST = 20.0  # m/s: no vehicle of ours is faster
LATEST = 20.0  # s: longest travel time of sound from a beacon

_WINDOW = pd0.LARGEST + pd0.TOLD  # bytes that are searched for one line or ensemble

_Said = Iterator[tuple[str, tuple[float, ...]]]

_END = re.compile(rb"[\r\n]+")
_NMEA = re.compile(r"\$[A-Z]{2}([A-Z]{3}),([ -~]*)\*([0-9A-Fa-f]{2})")
_OTHER = re.compile(r"\$P?[A-Z0-9]+,[ -~]*\*[0-9A-Fa-f]{2}")
_PD6 = re.compile(r":(WS|BS),( *[+-]?\d{1,5}),( *[+-]?\d{1,5}),( *[+-]?\d{1,5}),([AV])")
_OTHER_PD6 = re.compile(r":(SA|TS|RA|WI|WE|WD|BI|BE|BD),[ -~]*")
_SPEED = re.compile(r"[+-]?\d{1,3}(?:\.\d{1,4})?")
_BEACON, _TRAVEL = re.compile(r"\d{1,3}"), re.compile(r"\d{0,2}\.\d{1,6}")


class _Unfit(ValueError):
    pass


def _speed(text: str) -> float:
    """Convert knots to m/s. Raises _Unfit."""
    if _SPEED.fullmatch(text) is None or abs(float(text)) * KNOT > FASTEST:
        raise _Unfit
    return float(text) * KNOT


def _vhw(fields: list[str]) -> _Said:
    if len(fields) < 6 or fields[5] != "N":
        raise _Unfit
    if fields[4]:
        yield WATER, (_speed(fields[4]),)


def _vbw(fields: list[str]) -> _Said:
    if len(fields) < 6 or not {fields[2], fields[5]} <= {"A", "V"}:
        raise _Unfit
    if fields[2] == "A":
        yield WATER, (_speed(fields[0]),)
    if fields[5] == "A":
        yield GROUND, (_speed(fields[3]), _speed(fields[4]))


def _gll(fields: list[str]) -> _Said:
    position = read_gll(fields)
    if position is not None:
        yield PLACE, position


def _gga(fields: list[str]) -> _Said:
    position = read_gga(fields).position
    if position is not None:
        yield PLACE, position


def _mpr(fields: list[str]) -> _Said:
    """Read beacon and travel time. Newer modems append further fields."""
    if len(fields) < 3 or _BEACON.fullmatch(fields[0]) is None:
        raise _Unfit
    if not fields[2]:
        return
    if _TRAVEL.fullmatch(fields[2]) is None or not 0.0 < float(fields[2]) <= LATEST:
        raise _Unfit
    yield RANGE, (float(fields[0]), float(fields[2]))


_SENTENCES: Mapping[str, Callable[[list[str]], _Said]] = MappingProxyType(
    {"VHW": _vhw, "VBW": _vbw, "GLL": _gll, "GGA": _gga, "MPR": _mpr}
)


def _ensemble(data: bytes) -> _Said:
    for ground, ahead, starboard in pd0.velocities(data):
        if max(abs(starboard), abs(ahead)) > FASTEST:
            continue
        yield (GROUND, (ahead, starboard)) if ground else (WATER, (ahead,))


def _doppler(match: re.Match[str]) -> _Said:
    starboard, ahead, _ = (float(match[n].replace(" ", "")) / 1000.0 for n in (2, 3, 4))
    if match[5] == "V" or max(abs(starboard), abs(ahead)) > FASTEST:  # -32768: no velocity
        return
    if match[1] == "WS":
        yield WATER, (ahead,)
    else:
        yield GROUND, (ahead, starboard)


def _read(line: str) -> _Said:
    """Read one line. Raises _Unfit or Refused if it is no line of such a sensor."""
    if (pd6 := _PD6.fullmatch(line)) is not None:
        yield from _doppler(pd6)
    elif (nmea := _NMEA.fullmatch(line)) is not None or _OTHER.fullmatch(line):
        sum_ = 0
        for byte in line[1:-3].encode():
            sum_ ^= byte
        if sum_ != int(line[-2:], 16):
            raise _Unfit
        if nmea is not None and nmea[1] in _SENTENCES:
            yield from _SENTENCES[nmea[1]](nmea[2].split(","))
    elif _OTHER_PD6.fullmatch(line) is None:
        raise _Unfit


class AddedDecoder:
    """Decode the stream of one line. ``Aid.t`` is the arrival of the sentence's first byte."""

    def __init__(self) -> None:
        self._buffer, self._begun, self._offset = b"", 0.0, 0

    def receive(self, data: bytes, now: float) -> list[Aid | FrameFault]:
        out: list[Aid | FrameFault] = []
        if self._buffer and now - self._begun > UNFINISHED:
            out.append(FrameFault(self._offset - len(self._buffer), "truncated", len(self._buffer)))
            self._buffer = b""
        rest, held, at = self._buffer + data, len(self._buffer), self._offset
        self._offset += len(data)
        while rest and (
            used := self._piece(rest[:_WINDOW], self._begun if held > 0 else now, at, out)
        ):
            at += len(rest[:used].rstrip(b"\r\n")) + 1  # offsets count any line end as one byte
            rest, held = rest[used:], held - used
        if rest and held <= 0:
            self._begun = now
        self._buffer = rest
        return out

    def _piece(self, rest: bytes, begun: float, at: int, out: list[Aid | FrameFault]) -> int:
        """Read the line or ensemble at the start of ``rest``; return its length in bytes, 0 if it
        is incomplete."""
        size = pd0.length(rest)
        if isinstance(size, int):
            if len(rest) < size:
                return 0
            return self._binary(rest[:size], begun, at, out)
        if size is pd0.Whole.NOT_YET and len(rest) > 1:
            return 0
        end = _END.search(rest)
        mark = pd0.begins(rest, 1, len(rest) if end is None else end.start())
        if mark > 0 and len(rest) > min(mark + pd0.TOLD - 1, LONGEST):
            out += self._line(rest[:mark], begun, at)
            return mark
        if end is not None and mark < 0:
            out += self._line(rest[: end.start()], begun, at)
            return end.end()
        if mark < 0 and len(rest) > LONGEST:
            out.append(FrameFault(at, "overlong", len(rest)))
            return len(rest)
        return 0

    @staticmethod
    def _binary(data: bytes, begun: float, at: int, out: list[Aid | FrameFault]) -> int:
        """Read an ensemble; return the bytes used. If its sum is wrong only the mark is skipped:
        a line may begin within the rest."""
        try:
            out += [Aid(begun, kind, values) for kind, values in list(_ensemble(data))]
        except pd0.Unfit as error:
            if str(error) == "sum":
                out.append(FrameFault(at, "bad_checksum", len(pd0.MARK)))
                return len(pd0.MARK)
            out.append(FrameFault(at, "sentence", len(data)))
        return len(data)

    def _line(self, line: bytes, begun: float, at: int) -> list[Aid | FrameFault]:
        text = line[max(line.rfind(b"$"), line.rfind(b":"), 0) :].decode("latin-1")
        if not text:
            return []
        try:
            return [Aid(begun, kind, values) for kind, values in list(_read(text))]
        except (_Unfit, Refused):
            return [FrameFault(at, "sentence", len(line))]
