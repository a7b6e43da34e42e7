"""Field types for the table of a binary frame; one table both encodes and decodes.

    SD = BinaryFrame("auv.SD", "000 table 3.2", (
        Const(b"@SD"),
        F32LE("roll_deg", -90, 90), ...
        U16LE("pwm_left_main", 1000, 2000), ...
        Check(crc32_stm32, "I", first=3),
        Const(b"$"),
    ))

Offsets follow from the order of the fields. Rule G4 for a value outside its range: ``encode``
refuses the whole frame; a received command is refused (``out_of_range``); in telemetry the value is
kept and named in ``flags`` as ``field:reason``. NaN and infinity decode as None with a flag.

Values have the names and units of docs/protocol.md. What does not live here: text frames
(``protocol.text``), how frames are found in a stream (``protocol.framing``), the conversion to SI
units (the adapters in ``protocol.vehicles``).
"""

from __future__ import annotations

import enum
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from protocol.checksum import Checksum
from protocol.codec import CannotEncode

Values = dict[str, Any]
"""Name of docs/protocol.md -> number, text, None, or a list of names (``flags``)."""


class FaultKind(enum.StrEnum):
    TRUNCATED = "truncated"
    BAD_HEADER = "bad_header"
    BAD_TAIL = "bad_tail"
    BAD_LENGTH = "bad_length"
    BAD_CHECKSUM = "bad_checksum"
    BAD_CHAR = "bad_char"
    OUT_OF_RANGE = "out_of_range"
    NON_NUMERIC = "non_numeric"
    EMPTY_FIELD = "empty_field"
    FIELD_COUNT = "field_count"
    BAD_ENUM = "bad_enum"


class FrameType:
    """One type of frame: how to find, check, decode and encode it.

    ``lead``: the bytes that a candidate begins with. ``length``: 0 if it varies.
    """

    name: str
    title: str  # document and table
    lead: bytes
    length: int = 0

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        """Return the length of the candidate at ``at`` (its lead is there), 0 while more bytes are
        needed, or why it is no frame."""
        raise AssertionError

    def check(self, raw: bytes) -> FaultKind | None:
        """Return why these bytes are no frame of this type, or None."""
        raise AssertionError

    def decode(self, raw: bytes) -> Values:
        """Only for bytes that ``check`` accepts."""
        raise AssertionError

    def encode(self, values: Mapping[str, Any]) -> bytes:
        """Raises CannotEncode. Ignores what ``decode`` adds, such as ``flags``."""
        raise AssertionError


# --- fields ---


@dataclass(frozen=True, slots=True)
class Number:
    """``value = raw / scale - bias``; ``low``/``high`` bound the value, ``choices`` list it."""

    name: str
    low: float | None = None
    high: float | None = None
    code: str = field(kw_only=True)  # of struct
    order: str = field(default="<", kw_only=True)
    scale: float = field(default=1, kw_only=True)
    bias: float = field(default=0, kw_only=True)
    choices: tuple[int, ...] = field(default=(), kw_only=True)

    @property
    def floating(self) -> bool:
        return self.code in "fd"

    def value(self, raw: float) -> float:
        if self.scale != 1:
            raw = raw / self.scale
        return raw - self.bias if self.bias else raw

    def doubt(self, value: float) -> str | None:
        """Return what is wrong with a value (nan, inf, out_of_range, bad_enum), or None."""
        if value - value != 0:
            return "nan" if value != value else "inf"
        if self.choices:
            return None if value in self.choices else FaultKind.BAD_ENUM
        if (self.low is not None and value < self.low) or (
            self.high is not None and value > self.high
        ):
            return FaultKind.OUT_OF_RANGE
        return None

    def raw(self, value: Any) -> float:
        """Return the value as a raw number. Raises CannotEncode if there is none."""
        if value is None and self.floating:
            return math.nan
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise CannotEncode(f"{self.name}: a number is needed, not {value!r}")
        counts = (value + self.bias) * self.scale
        if self.floating:
            return counts
        if not math.isfinite(counts):
            raise CannotEncode(f"{self.name}: {value} has no place in an integer")
        return round(counts)

    def refuse(self, value: float) -> None:
        reason = self.doubt(value)
        if reason is not None:
            allowed = ", ".join(map(str, self.choices)) or f"{self.low}..{self.high}"
            raise CannotEncode(f"{self.name}: {value} is outside {allowed}")


U8 = partial(Number, code="B")
I8 = partial(Number, code="b")
U16LE = partial(Number, code="H")
U16BE = partial(Number, code="H", order=">")
I16LE = partial(Number, code="h")
I16BE = partial(Number, code="h", order=">")
U32LE = partial(Number, code="I")
I32LE = partial(Number, code="i")
F32LE = partial(Number, code="f")
F64LE = partial(Number, code="d")


@dataclass(frozen=True, slots=True)
class Raw:
    """Bytes that are passed through; their value is lower-case hexadecimal."""

    name: str
    size: int


@dataclass(frozen=True, slots=True)
class Pad:
    """Undefined bytes: zero when sent, ignored when received."""

    size: int


@dataclass(frozen=True, slots=True)
class Const:
    """Fixed bytes. ``kind``: the fault if other bytes are there (default: header or tail)."""

    data: bytes
    kind: FaultKind | None = None
    also: bytes = b""  # accepted on decode as well (a tolerance)


@dataclass(frozen=True, slots=True)
class Check:
    """A checksum over the bytes from ``first`` up to itself. ``code``: format letter of struct."""

    compute: Checksum
    code: str
    first: int = 0
    also: Checksum | None = None  # accepted on decode as well (a tolerance)


Field = Number | Raw | Pad | Const | Check


def _struct_code(item: Field) -> str:
    match item:
        case Number() | Check():
            return item.code
        case Raw():
            return f"{item.size}s"
        case Pad():
            return f"{item.size}x"
    return f"{len(item.data)}s"


@dataclass(frozen=True, slots=True)
class _Segment:
    """Successive fields with one byte order, which one struct reads."""

    offset: int
    layout: struct.Struct
    fields: tuple[Field, ...]  # without Pad


def _segments(fields: Sequence[Field]) -> tuple[_Segment, ...]:
    segments: list[_Segment] = []
    start = 0
    while fields:
        order = next((f.order for f in fields if isinstance(f, Number)), "<")
        count = next(
            (i for i, f in enumerate(fields) if isinstance(f, Number) and f.order != order),
            len(fields),
        )
        run = fields[:count]
        layout = struct.Struct(order + "".join(map(_struct_code, run)))
        segments.append(_Segment(start, layout, tuple(f for f in run if not isinstance(f, Pad))))
        start += layout.size
        fields = fields[count:]
    return tuple(segments)


class BinaryFrame(FrameType):
    """A frame of fixed length, defined by its table.

    ``command``: the frame is refused if a value is out of range (G4). ``derive`` adds decoded
    values and flags that follow from several fields. ``flags=False``: no value can be doubtful.
    """

    def __init__(
        self,
        name: str,
        title: str,
        fields: Sequence[Field],
        *,
        command: bool = False,
        flags: bool = True,
        derive: Callable[[Values], None] | None = None,
    ) -> None:
        self.name, self.title, self.fields = name, title, tuple(fields)
        self.command, self.derive = command, derive
        self.flags = flags and not command
        first = self.fields[0]
        assert isinstance(first, Const), "a table begins with its header"
        self.lead = first.data
        self._segments = _segments(self.fields)
        self.length = sum(segment.layout.size for segment in self._segments)
        self.offsets = self._offsets()
        self._consts, self._checks = self._constants(), self._checksums()

    @property
    def layout(self) -> struct.Struct:
        """The whole frame as one little-endian struct, checksums as bytes."""
        sized = (
            f"{struct.calcsize(f.code)}s" if isinstance(f, Check) else _struct_code(f)
            for f in self.fields
        )
        return struct.Struct("<" + "".join(sized))

    def _offsets(self) -> tuple[int, ...]:
        sizes = [struct.calcsize("<" + _struct_code(f)) for f in self.fields]
        return tuple(sum(sizes[:i]) for i in range(len(sizes)))

    def _constants(self) -> tuple[tuple[int, tuple[bytes, ...], FaultKind], ...]:
        """Return offset, allowed bytes and fault of each constant: the lead, then from the tail
        backwards, as the tail is the cheapest check."""
        last = len(self.fields) - 1
        found = [
            (
                at,
                (f.data, f.also) if f.also else (f.data,),
                f.kind or (FaultKind.BAD_TAIL if i == last else FaultKind.BAD_HEADER),
            )
            for i, (at, f) in enumerate(zip(self.offsets, self.fields, strict=True))
            if isinstance(f, Const)
        ]
        return tuple(found[:1] + found[:0:-1])

    def _checksums(self) -> tuple[tuple[int, struct.Struct, Check], ...]:
        return tuple(
            (at, struct.Struct("<" + f.code), f)
            for at, f in zip(self.offsets, self.fields, strict=True)
            if isinstance(f, Check)
        )

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        return self.length if end - at >= self.length else 0

    def check(self, raw: bytes) -> FaultKind | None:
        for at, expected, kind in self._consts:
            if not raw.startswith(expected, at):
                return kind
        for at, layout, check in self._checks:
            (stored,) = layout.unpack_from(raw, at)
            covered = raw[check.first : at]
            if check.compute(covered) != stored and (
                check.also is None or check.also(covered) != stored
            ):
                return FaultKind.BAD_CHECKSUM
        return self._refusal(raw) if self.command else None

    def _refusal(self, raw: bytes) -> FaultKind | None:
        for item, stored in self._stored(raw):
            if isinstance(item, Number):
                doubt = item.doubt(item.value(stored))
                if doubt is not None:
                    wrong_code = doubt == FaultKind.BAD_ENUM
                    return FaultKind.BAD_ENUM if wrong_code else FaultKind.OUT_OF_RANGE
        return None

    def _stored(self, raw: bytes) -> list[tuple[Field, Any]]:
        stored: list[tuple[Field, Any]] = []
        for segment in self._segments:
            stored += zip(
                segment.fields, segment.layout.unpack_from(raw, segment.offset), strict=True
            )
        return stored

    def decode(self, raw: bytes) -> Values:
        values: Values = {}
        flags: list[str] = []
        for item, stored in self._stored(raw):
            if isinstance(item, Number):
                values[item.name] = value = item.value(stored)
                doubt = item.doubt(value)
                if doubt is not None:
                    flags.append(f"{item.name}:{doubt}")
                    values[item.name] = None if doubt in ("nan", "inf") else value
            elif isinstance(item, Raw):
                values[item.name] = stored.hex()
        if self.flags:
            values["flags"] = flags
        if self.derive is not None:
            self.derive(values)
        return values

    def encode(self, values: Mapping[str, Any]) -> bytes:
        for item in self.fields:
            if not isinstance(item, Number) or item.name not in values:
                continue
            value = values[item.name]
            if value is not None:
                item.raw(value)
                item.refuse(value)
            elif self.command:
                raise CannotEncode(f"{self.name}: {item.name}: a command needs a number")
        return self.pack(values)

    def pack(self, values: Mapping[str, Any]) -> bytes:
        """Encode without range checks: the simulation sends what a broken sensor would send."""
        out = bytearray()
        for segment in self._segments:
            stored = [self._to_raw(item, values) for item in segment.fields]
            try:
                out += segment.layout.pack(*stored)
            except (struct.error, OverflowError) as error:
                raise CannotEncode(f"{self.name}: {error}") from None
        for at, layout, check in self._checks:
            layout.pack_into(out, at, check.compute(bytes(out[check.first : at])))
        return bytes(out)

    def _to_raw(self, item: Field, values: Mapping[str, Any]) -> Any:
        match item:
            case Const():
                return item.data
            case Number():
                return item.raw(required(values, item.name, self.name))
            case Raw():
                return _raw_bytes(item, required(values, item.name, self.name))
            case _:
                return 0


def required(values: Mapping[str, Any], name: str, frame: str) -> Any:
    if name not in values:
        raise CannotEncode(f"{frame}: the value {name} is missing")
    return values[name]


def _raw_bytes(item: Raw, value: Any) -> bytes:
    try:
        data = bytes.fromhex(value)
    except (TypeError, ValueError):
        raise CannotEncode(f"{item.name}: hexadecimal is needed, not {value!r}") from None
    if len(data) != item.size:
        raise CannotEncode(f"{item.name}: {item.size} bytes are needed, not {len(data)}")
    return data
