"""Sensors that a user adds, on a line of their own: what they say becomes Aids.

    $--VHW,deg,T,deg,M,knots,N,km/h,K*hh             speed through the water
    $--VBW,knots,knots,A,knots,knots,A[,...]*hh      ahead and across: in the water, over ground
    $--GLL, $--GGA                                   where it is, from outside: an acoustic system
    :WS,mm/s,mm/s,mm/s,A   :BS,...                   a Doppler log (PD6): starboard, ahead, up;
                                                     through the water, and over ground

A line ends with CR or LF. NMEA must carry its checksum; PD6 has none, so every field of it must be
as it should. What a sensor itself calls invalid (V, 99999 and the like) is no Aid. Other sentences
are passed over; what is none is a FrameFault.

What does not live here: what is believed of it (mission.navigation.added), the receiver (nmea).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

from protocol.messages import Aid, FrameFault
from protocol.nmea_fields import KNOT, Refused, read_gga, read_gll

WATER, GROUND, PLACE = "water", "ground", "place"  # the kinds of Aids
LONGEST = 160  # bytes of a line
UNFINISHED = 1.0  # s after its first byte a line is given up (G3)
FASTEST = 20.0  # m/s: faster is no vehicle of ours

_Said = Iterator[tuple[str, tuple[float, ...]]]

_END = re.compile(rb"[\r\n]+")
_NMEA = re.compile(r"\$[A-Z]{2}([A-Z]{3}),([ -~]*)\*([0-9A-Fa-f]{2})")
_OTHER = re.compile(r"\$P?[A-Z0-9]+,[ -~]*\*[0-9A-Fa-f]{2}")
_PD6 = re.compile(r":(WS|BS),( *[+-]?\d{1,5}),( *[+-]?\d{1,5}),( *[+-]?\d{1,5}),([AV])")
_OTHER_PD6 = re.compile(r":(SA|TS|RA|WI|WE|WD|BI|BE|BD),[ -~]*")
_SPEED = re.compile(r"[+-]?\d{1,3}(?:\.\d{1,4})?")


class _Unfit(ValueError):
    pass


def _speed(text: str) -> float:
    """Knots to m/s."""
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


_SENTENCES: Mapping[str, Callable[[list[str]], _Said]] = MappingProxyType(
    {"VHW": _vhw, "VBW": _vbw, "GLL": _gll, "GGA": _gga}
)


def _doppler(match: re.Match[str]) -> _Said:
    starboard, ahead, _ = (float(match[n].replace(" ", "")) / 1000.0 for n in (2, 3, 4))
    if match[5] == "V" or max(abs(starboard), abs(ahead)) > FASTEST:  # -32768: no velocity
        return
    if match[1] == "WS":
        yield WATER, (ahead,)
    else:
        yield GROUND, (ahead, starboard)


def _read(line: str) -> _Said:
    """Raises _Unfit or Refused for what is no line of such a sensor."""
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
    """The stream of one line. An Aid bears the time of its line's first byte."""

    def __init__(self) -> None:
        self._buffer, self._begun, self._offset = b"", 0.0, 0

    def receive(self, data: bytes, now: float) -> list[Aid | FrameFault]:
        out: list[Aid | FrameFault] = []
        if self._buffer and now - self._begun > UNFINISHED:
            out.append(FrameFault(self._offset - len(self._buffer), "truncated", len(self._buffer)))
            self._buffer = b""
        *lines, rest = _END.split(self._buffer + data)
        held = bool(self._buffer)
        at = self._offset
        for line in lines:
            begun, held = self._begun if held else now, False
            out += self._line(line, begun, at)
            at += len(line) + 1
        if len(rest) > LONGEST:
            out.append(FrameFault(at, "overlong", len(rest)))
            rest = b""
        if rest and not held:
            self._begun = now
        self._buffer, self._offset = rest, self._offset + len(data)
        return out

    def _line(self, line: bytes, begun: float, at: int) -> list[Aid | FrameFault]:
        text = line[max(line.rfind(b"$"), line.rfind(b":"), 0) :].decode("latin-1")
        if not text:
            return []
        try:
            return [Aid(begun, kind, values) for kind, values in list(_read(text))]
        except (_Unfit, Refused):
            return [FrameFault(at, "sentence", len(line))]
