"""The frames received on a link, each with its time. Sans-IO.

    bytes, their time --Hearing--> Heard (frame or fault, its bytes, its time)

``t`` is in s since 1970 UTC throughout. What does not live here: where the bytes come from
(console, replay.follow), files of bytes (the command decode).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

from links import at_rate, parse_address
from links.base import Rx
from protocol.framing import Frame, LinkRow
from protocol.messages import FrameFault
from protocol.modem import BAUD as MODEM
from protocol.tolerances import Tolerances
from protocol.vehicles import VEHICLES, line_rate

_RECEIVER = 9600  # bit/s: of links that belong to no vehicle
_CAN_HEAD = 3  # identifier u16, length u8


@dataclass(frozen=True, slots=True)
class Heard:
    """A frame or a fault. ``way``: its stream, "" if there is only one."""

    t: float
    item: Frame | FrameFault
    raw: bytes
    way: str = ""

    @property
    def is_fault(self) -> bool:
        return isinstance(self.item, FrameFault)


class Hearing:
    """A link with all its streams: each direction and each peer is a stream of its own."""

    def __init__(self, row: LinkRow, tolerances: Tolerances) -> None:
        self._row, self._tolerances = row, tolerances
        self._streams: dict[str, _Stream] = {}

    def receive(self, rx: Rx) -> Iterator[Heard]:
        """Also call it without bytes: unfinished frames are given up in time (G3)."""
        if not rx.data:
            for stream in self._streams.values():
                yield from stream.receive(b"", rx.t)
            return
        way = f"{rx.link} {rx.address}".strip()
        if way not in self._streams:
            self._streams[way] = _Stream(self._row, self._tolerances, way)
        yield from self._streams[way].receive(rx.data, rx.t)

    def end(self) -> Iterator[Heard]:
        for stream in self._streams.values():
            yield from stream.end()


class _Stream:
    def __init__(self, row: LinkRow, tolerances: Tolerances, way: str) -> None:
        self._framer, self._way = row.framer(tolerances), way
        self._datagrams = row.line is not None
        self._bytes, self._base = bytearray(), 0  # bytes that are not yielded yet, and their offset
        self._t = 0.0

    def receive(self, data: bytes, t: float) -> Iterator[Heard]:
        yield from self._told(self._framer.flush(t))
        if data:
            self._bytes += data
            self._t = t
            yield from self._told(self._framer.receive(data, t))
        if self._datagrams:
            yield from self.end()

    def end(self) -> Iterator[Heard]:
        yield from self._told(self._framer.flush(math.inf))

    def _told(self, items: Iterable[Frame | FrameFault]) -> Iterator[Heard]:
        for item in items:
            if isinstance(item, FrameFault):
                at = max(0, item.offset - self._base)
                end = max(0, item.offset + item.length - self._base)
                raw, t = bytes(self._bytes[at:end]), self._t
            else:
                raw, t = item.raw, item.t
            yield Heard(t, item, raw, self._way)
        self._forget()

    def _forget(self) -> None:
        """Of a fault without end keep only the last bytes."""
        if len(self._bytes) > 2 * _LONGEST:
            gone = len(self._bytes) - _LONGEST
            del self._bytes[:gone]
            self._base += gone


_LONGEST = 1 << 16  # bytes


def with_baud(url: str, link: str) -> str:
    """Add the bit rate of the link's document to a serial port's URL without one. Raises
    LinkAddressError."""
    if parse_address(url).scheme != "serial":
        return url
    if link == "auv.modem":
        return at_rate(url, MODEM)
    vehicle = link.partition(".")[0]
    known = vehicle in VEHICLES
    return at_rate(url, line_rate(vehicle) if known else _RECEIVER)


def on_record(row: LinkRow, data: bytes) -> bytes:
    """Return the form that the command decode reads: one CAN frame per line, all else unchanged."""
    if row.line is None:
        return data
    return b"%03X#%b\n" % (int.from_bytes(data[:2], "big"), data[_CAN_HEAD:].hex().encode())


# --- forms of output ---


def as_object(heard: Heard, raw: bool) -> dict[str, object]:
    item = heard.item
    told: dict[str, object] = {"time": _stamp(heard.t).isoformat(timespec="milliseconds")}
    if heard.way:
        told["way"] = heard.way
    if isinstance(item, FrameFault):
        told |= {"fault": item.kind, "length": item.length}
    else:
        told |= {"type": item.type.name, "values": item.values()}
    return told | ({"raw": heard.raw.hex()} if raw else {})


def as_line(heard: Heard, raw: bool) -> str:
    """Return a line, with the computer's local time."""
    item = heard.item
    clock = _stamp(heard.t).astimezone().strftime("%H:%M:%S.%f")[:-3]
    if isinstance(item, FrameFault):
        says = f"FAULT {item.kind}, {item.length} bytes"
    else:
        says = f"{item.type.name}  {_shown(item.values())}".rstrip()
    way = f"{heard.way}  " if heard.way else ""
    return f"{clock}  {way}{says}" + (f"\n{'':14}{heard.raw.hex(' ')}" if raw else "")


def as_json(heard: Heard, raw: bool) -> str:
    return json.dumps(as_object(heard, raw))


def _stamp(t: float) -> datetime:
    return datetime.fromtimestamp(t, UTC)


def _shown(values: Mapping[str, object]) -> str:
    flags = values.get("flags") or []
    assert isinstance(flags, list)
    told = [f"{name}={_value(value)}" for name, value in values.items() if name != "flags"]
    return " ".join([*told, *(f"DOUBTFUL:{flag}" for flag in flags)])


def _value(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, str):  # a string from the line must not control the terminal
        return value.encode("unicode_escape").decode("ascii")
    return f"{value:.9g}" if isinstance(value, float) else str(value)
