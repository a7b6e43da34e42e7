"""GPS sentences as frames, to show what a receiver sends (``decode --link gps.nmea``).

    $GNGGA,...*hh CR LF      any sentence with its checksum; GGA and RMC are read, field by field

The runtime uses protocol.nmea instead: there the two sentences of an epoch become one fix. What
does not live here: the rules of single fields (protocol.nmea_fields).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from protocol.codec import CannotEncode
from protocol.fields import FaultKind, FrameType, Values
from protocol.framing import LinkRow
from protocol.nmea import IDLE, MAX_SENTENCE
from protocol.nmea_fields import TALKERS, Gga, Refused, Rmc, read_gga, read_rmc

_BODY = re.compile(rb"\$[\x20-\x23\x25-\x29\x2b-\x7e]*")
_STAR, _SUM = ord("*"), re.compile(rb"\*[0-9A-Fa-f]{2}")
_CUT = {
    ord("\r"): FaultKind.BAD_CHECKSUM,  # no checksum
    ord("\n"): FaultKind.BAD_CHECKSUM,
    ord("$"): FaultKind.TRUNCATED,
}


class NmeaFrame(FrameType):
    """One sentence with its line end. A GGA or RMC with a wrong field is refused; one without a
    fix is kept, with the flag ``no_fix``."""

    name, title, lead = "gps.NMEA", "NMEA 0183", b"$"

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        body = _BODY.match(data, at, min(end, at + MAX_SENTENCE))
        stop = at + 1 if body is None else body.end()
        if stop - at >= MAX_SENTENCE:
            return FaultKind.BAD_LENGTH
        if stop == end:
            return 0
        if data[stop] != _STAR:
            return _CUT.get(data[stop], FaultKind.BAD_CHAR)
        if end - stop > 2 and _SUM.match(data, stop) is None:
            return FaultKind.BAD_CHECKSUM
        tail = data[stop + 3 : stop + 5]
        if end - stop < 4 or (tail == b"\r" and end - stop < 5):
            return 0
        return stop + 3 + (2 if tail == b"\r\n" else tail[:1] == b"\n") - at

    def check(self, raw: bytes) -> FaultKind | None:
        text, _, stated = raw.rstrip(b"\r\n").rpartition(b"*")
        total = 0
        for byte in text[1:]:
            total ^= byte
        if total != int(stated, 16):
            return FaultKind.BAD_CHECKSUM
        try:
            _read(text)
        except Refused as refused:
            return FaultKind(refused.reason.kind)
        return None

    def decode(self, raw: bytes) -> Values:
        text = raw.rpartition(b"*")[0]
        name, _, fields = text[1:].decode("ascii").partition(",")
        read = _read(text)
        if read is None:
            return {"sentence": name, "fields": fields}
        return {"sentence": name, **_values(read)}

    def encode(self, values: Mapping[str, Any]) -> bytes:
        raise CannotEncode(f"{self.name}: what a receiver says is only read")


def _read(text: bytes) -> Gga | Rmc | None:
    """Read a GGA or RMC, None for another sentence. Raises Refused."""
    name, *fields = text[1:].decode("ascii").split(",")
    if name[:2] not in TALKERS or name[2:] not in ("GGA", "RMC"):
        return None
    return read_gga(fields) if name[2:] == "GGA" else read_rmc(fields, None)


def _values(read: Gga | Rmc) -> Values:
    place = [None if read.position is None else math.degrees(x) for x in read.position or (0, 0)]
    values: Values = {"second_of_day": read.second, "lat_deg": place[0], "lon_deg": place[1]}
    if isinstance(read, Gga):
        values |= {"hdop": read.hdop, "elevation_m": read.elevation, "satellites": read.satellites}
    else:
        course = None if read.course is None else math.degrees(read.course)
        values |= {"speed_m_s": read.speed, "course_deg": course, "utc": read.utc}
    return values | {"flags": [] if read.position else ["no_fix"]}


LINK = LinkRow("gps.nmea", lambda tolerances: (NmeaFrame(),), idle=IDLE)
