"""What a binary table promises: ranges (G4), orders of bytes, padding, constants, checksums."""

from __future__ import annotations

import math
from typing import Any

import pytest

from protocol.checksum import sum256, xor8
from protocol.codec import CannotEncode
from protocol.fields import (
    F32LE,
    F64LE,
    I8,
    I16BE,
    I16LE,
    I32LE,
    U8,
    U16BE,
    U16LE,
    U32LE,
    BinaryFrame,
    Check,
    Const,
    FaultKind,
    FrameType,
    Pad,
    Raw,
)

FIELDS = (
    Const(b"\xfe\xef"),
    U8("mode", choices=(0, 1)),
    I8("angle", -30, 30),
    U16BE("voltage", scale=100),
    I16BE("temperature", -50, 50, scale=100),
    Pad(2),
    U16LE("width"),
    I16LE("speed"),
    F32LE("depth", 0, 100),
    F64LE("latitude", -90, 90),
    U32LE("count"),
    I32LE("rpm", -1000, 1000),
    U8("force", -100, 100, bias=100),
    Const(b"\x07", FaultKind.BAD_LENGTH),
    Raw("passed", 2),
    Check(xor8, "B"),
    Const(b"\xfa\xaf"),
)
TABLE = BinaryFrame("x.TABLE", "a table", FIELDS)
COMMAND = BinaryFrame("x.COMMAND", "a table", FIELDS, command=True)
VALUES: dict[str, Any] = {
    "mode": 1,
    "angle": -7,
    "voltage": 38.0,
    "temperature": -1.5,
    "width": 1500,
    "speed": -2,
    "depth": 12.5,
    "latitude": 30.25,
    "count": 4_000_000_000,
    "rpm": -500,
    "force": -100,
    "passed": "0aff",
}
RAW = bytes.fromhex(
    "feef 01 f9 0ed8 ff6a 0000 dc05 feff 00004841 0000000000403e40 00286bee 0cfeffff 00 07 0aff"
)
GOOD = RAW + bytes([xor8(RAW)]) + b"\xfa\xaf"


def changed(at: int, data: bytes) -> bytes:
    """The good frame with other bytes and a right checksum."""
    body = GOOD[:at] + data + GOOD[at + len(data) : -3]
    return body + bytes([xor8(body)]) + GOOD[-2:]


def test_a_table_is_its_bytes() -> None:
    assert TABLE.encode(VALUES) == GOOD
    assert TABLE.decode(GOOD) == VALUES | {"flags": []}
    assert (TABLE.length, TABLE.lead) == (len(GOOD), b"\xfe\xef")
    assert TABLE.offsets == (0, 2, 3, 4, 6, 8, 10, 12, 14, 18, 26, 30, 34, 35, 36, 38, 39)
    assert "flags" not in COMMAND.decode(GOOD)


@pytest.mark.parametrize(
    ("raw", "kind"),
    [
        (GOOD, None),
        (b"\xff" + GOOD[1:], "bad_header"),
        (GOOD[:-1] + b"\x00", "bad_tail"),
        (changed(35, b"\x08"), "bad_length"),
        (changed(8, b"\x01\x02"), None),
        (GOOD[:-3] + bytes([GOOD[-3] ^ 1]) + GOOD[-2:], "bad_checksum"),
        (changed(2, b"\x02"), "bad_enum"),
        (changed(3, b"\x1f"), "out_of_range"),
        (changed(14, b"\x00\x00\xc0\x7f"), "out_of_range"),
        (changed(14, b"\x00\x00\x80\x7f"), "out_of_range"),
    ],
)
def test_a_command_out_of_range_is_refused_and_telemetry_is_not(raw: bytes, kind: str) -> None:
    assert COMMAND.check(raw) == kind
    kept = kind in ("bad_enum", "out_of_range")
    assert TABLE.check(raw) == (None if kept else kind)


@pytest.mark.parametrize(
    ("raw", "name", "value", "flag"),
    [
        (changed(2, b"\x02"), "mode", 2, "mode:bad_enum"),
        (changed(3, b"\x1f"), "angle", 31, "angle:out_of_range"),
        (changed(3, b"\xe1"), "angle", -31, "angle:out_of_range"),
        (changed(14, b"\x00\x00\xc0\x7f"), "depth", None, "depth:nan"),
        (changed(14, b"\x00\x00\x80\xff"), "depth", None, "depth:inf"),
    ],
)
def test_doubtful_telemetry_is_kept_and_named(
    raw: bytes, name: str, value: object, flag: str
) -> None:
    decoded = TABLE.decode(raw)
    assert decoded[name] == value
    assert decoded["flags"] == [flag]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mode": 2}, "mode: 2 is outside 0, 1"),
        ({"angle": 31}, "angle: 31 is outside -30..30"),
        ({"angle": "1"}, "a number is needed"),
        ({"angle": True}, "a number is needed"),
        ({"angle": None}, "a number is needed"),
        ({"width": 65536}, "x.TABLE"),
        ({"width": math.inf}, "no place in an integer"),
        ({"speed": -40000}, "x.TABLE"),
        ({"depth": math.nan}, "depth: nan"),
        ({"depth": math.inf}, "depth: inf"),
        ({"latitude": 91}, "latitude"),
        ({"passed": "0a"}, "2 bytes are needed, not 1"),
        ({"passed": "zz"}, "hexadecimal is needed"),
        ({"passed": 5}, "hexadecimal is needed"),
    ],
)
def test_what_cannot_be_encoded_is_said(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(CannotEncode, match=message):
        TABLE.encode(VALUES | changes)


def test_a_missing_value_is_named() -> None:
    with pytest.raises(CannotEncode, match="rpm is missing"):
        TABLE.encode({k: v for k, v in VALUES.items() if k != "rpm"})


def test_packing_lets_a_broken_sensor_speak() -> None:
    raw = TABLE.pack(VALUES | {"depth": 500.0, "angle": 100})
    assert TABLE.check(raw) is None
    assert TABLE.decode(raw)["flags"] == ["angle:out_of_range", "depth:out_of_range"]
    with pytest.raises(CannotEncode, match=r"x\.TABLE"):
        TABLE.pack(VALUES | {"depth": 1e300})


def test_what_is_not_known_is_sent_as_no_number() -> None:
    raw = TABLE.encode(VALUES | {"depth": None})
    assert TABLE.decode(raw)["depth"] is None
    with pytest.raises(CannotEncode, match="depth: a command needs a number"):
        COMMAND.encode(VALUES | {"depth": None})


def test_a_second_checksum_may_be_right_as_well() -> None:
    table = BinaryFrame(
        "x.T", "", (Const(b"\xaa"), U8("a"), Check(xor8, "B", 0, sum256), Const(b"\xdd"))
    )
    right, also = b"\xaa\x0f\xa5\xdd", b"\xaa\x0f\xb9\xdd"
    assert table.encode({"a": 15}) == right
    assert table.check(right) is table.check(also) is None
    assert table.check(b"\xaa\x0f\xb8\xdd") == "bad_checksum"


def test_derived_values_and_absent_flags() -> None:
    def double(values: dict[str, Any]) -> None:
        values["twice"] = 2 * values["a"]

    table = BinaryFrame("x.T", "", (Const(b"\xaa"), U8("a")), flags=False, derive=double)
    assert table.decode(b"\xaa\x03") == {"a": 3, "twice": 6}
    assert table.measure(b"\xaa\x03", 0, 1) == 0


def test_a_frame_type_says_itself_what_it_is() -> None:
    bare = FrameType()
    for call in (lambda: bare.measure(b"", 0, 0), lambda: bare.check(b""), lambda: bare.decode(b""), lambda: bare.encode({})):  # fmt: skip
        with pytest.raises(AssertionError):
            call()
