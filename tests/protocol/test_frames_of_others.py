"""Documents 002, 003, 004: canonical frames, round trips, tolerances, and no corrupted byte passes."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from typing import Any

import pytest
from canonical_others import OTHERS
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.codec import CannotEncode
from protocol.examples import (
    MAIN_TO_PC,
    MAIN_TO_SENSOR,
    PC_TO_MAIN,
    ROV_DOWN,
    ROV_UP,
    SENSOR_TO_MAIN,
)
from protocol.fields import BinaryFrame, Number, Pad, Raw, Values
from protocol.framing import Frame
from protocol.messages import FrameFault
from protocol.tolerances import Tolerances
from protocol.vehicles import coreboard, frame_types, link, motorcan, robot, rov
from protocol.vehicles.motorcan import from_line

IDS = [f"{name}-{raw[:3].hex()}" for name, _, raw in OTHERS]
NORMATIVE = Tolerances()


def stream(name: str, data: bytes, **options: str) -> list[Frame | FrameFault]:
    framer = link(name).framer(Tolerances.parse(options))
    return framer.receive(data, 0.0) + framer.flush(1.0)


def one(name: str, data: bytes, **options: str) -> Values:
    (frame,) = stream(name, data, **options)
    assert isinstance(frame, Frame), frame
    return frame.values()


def fault(name: str, data: bytes, **options: str) -> str:
    """The kind of the first fault; no frame may come of it."""
    out = stream(name, data, **options)
    assert all(isinstance(item, FrameFault) for item in out), out
    assert isinstance(out[0], FrameFault)
    return out[0].kind


# --- canonical frames -----------------------------------------------------------------------


@pytest.mark.parametrize(("name", "link_name", "raw"), OTHERS, ids=IDS)
def test_a_canonical_frame_is_one_frame_of_its_type(name: str, link_name: str, raw: bytes) -> None:
    (frame,) = stream(link_name, b"\xfe\x55\xaa" + raw)[1:]
    assert isinstance(frame, Frame)
    assert (frame.type.name, frame.raw, frame.offset) == (name, raw, 3)


@pytest.mark.parametrize(("name", "link_name", "raw"), OTHERS, ids=IDS)
def test_encoding_the_decoded_values_gives_the_same_bytes(
    name: str, link_name: str, raw: bytes
) -> None:
    assert raw.endswith(frame_types()[name].encode(one(link_name, raw)))


def test_lengths_are_those_of_the_documents() -> None:
    assert {name: t.length for name, t in frame_types().items() if not name.startswith("auv")} == {
        "coreboard.MAIN_TO_PC": 90,
        "coreboard.MAIN_TO_SENSOR": 37,
        "coreboard.PC_TO_MAIN": 62,
        "coreboard.SENSOR_TO_MAIN": 155,
        "coreboard.CAN_FORCE": 3 + 7,
        "coreboard.CAN_TORQUE": 3 + 7,
        "rov.DOWN": 30,
        "rov.UP": 71,
        "robot.DOWN": 12,
        "robot.UP": 7,
    }


@pytest.mark.parametrize(
    ("frame", "offsets"),
    [
        (
            coreboard.main_to_pc(NORMATIVE),
            {"roll_deg": 2, "lat_deg": 14, "x_m": 30, "depth_m": 38, "avoid_m": 46, "mode": 62}
            | {"temperature_c": 63, "control_v": 65, "leak": 69, "usbl1": 70, "ins_aligned": 82},
        ),
        (
            coreboard.pc_to_main(NORMATIVE),
            {"lat_deg": 2, "x_m": 18, "depth_m": 26, "heading_deg": 30, "nav": 34, "tx": 35}
            | {"mode": 41, "ins_on": 43, "usbl_khz": 46, "angle_error_deg": 47, "passthrough": 48},
        ),
        (
            coreboard.main_to_sensor(NORMATIVE),
            {"ins": 2, "drop_weight": 12, "led1": 13, "ptz": 17, "passthrough": 18},
        ),
        (
            coreboard.sensor_to_main(NORMATIVE),
            {"temperature_c": 2, "ad1": 4, "reserved12": 12, "depth_m": 14, "leak_legacy_raw": 23}
            | {"roll_deg": 24, "p": 36, "ax": 48, "mx": 60, "dvl_x": 72, "lat_deg": 84}
            | {"vo_x": 100, "usbl_x_m": 112, "altitude_m": 120, "temperature2_c": 127}
            | {"control_v": 129, "leak": 133, "usbl1": 134, "ins_aligned": 146, "valid": 151},
        ),
        (
            rov.up(NORMATIVE),
            {"ax_g": 7, "gx_dps": 19, "ex_deg": 31, "depth_m": 43, "rpm_left_front": 47}
            | {"rpm_right_up": 59, "temperature_c": 63, "metal_pct": 67},
        ),
        (
            rov.down(NORMATIVE),
            {"hold_heading": 7, "hold_depth": 8, "led_pct": 9, "servo_deg": 10, "x": 11, "z": 15}
            | {"f": 19, "reserved": 23},
        ),
        (robot.up(NORMATIVE), {"speed_mm_s": 1, "voltage_mv": 3}),
        (
            robot.DownFrame(NORMATIVE),
            {"address": 1, "command": 2, "length": 3, "user": 4},
        ),
    ],
    ids=lambda x: x.name if isinstance(x, BinaryFrame) else "",
)
def test_offsets_are_those_of_the_documents(frame: BinaryFrame, offsets: dict[str, int]) -> None:
    found = {
        item.name: at
        for item, at in zip(frame.fields, frame.offsets, strict=True)
        if isinstance(item, (Number, Raw))
    }
    assert offsets.items() <= found.items()


# --- corruption -----------------------------------------------------------------------------


def corrupted(raw: bytes) -> Iterator[tuple[int, int, bytes]]:
    for at in range(len(raw)):
        for value in range(256):
            if value != raw[at]:
                yield at, value, raw[:at] + bytes([value]) + raw[at + 1 :]


CHECKED = [(name, raw) for name, _, raw in OTHERS if not name.startswith("coreboard.CAN")]


@pytest.mark.parametrize(("name", "raw"), CHECKED, ids=[i for i in IDS if "CAN" not in i])
def test_every_single_byte_corruption_is_refused_but_for_the_one_hole_of_mod_255(
    name: str, raw: bytes
) -> None:
    frame = frame_types()[name]
    passed = {(at, value) for at, value, bad in corrupted(raw) if accepted(frame, bad)}
    hole: set[tuple[int, int]] = set()
    if name == "robot.UP":  # mod 255 cannot tell 00 from FF
        hole = {(at, 0xFF) for at in range(1, 5) if raw[at] == 0}
    elif name == "robot.DOWN":  # nor here, where the table of commands does not
        hole = {(at, 0xFF) for at in range(4, 10) if raw[at] == 0}
        hole |= {(2, 0xFF)} if raw[1] == robot.ROBOT else set()
    assert passed == hole


def accepted(frame: Any, raw: bytes) -> bool:
    return raw.startswith(frame.lead) and frame.check(raw) is None


def test_stop_and_handshake_have_the_same_checksum() -> None:
    frame = robot.DownFrame(NORMATIVE)
    stop = frame.encode({"address": 1, "command": robot.STOP})
    shake = frame.encode({"address": 1, "command": robot.HANDSHAKE})
    assert stop[10] == shake[10] == 0xAB


# --- round trips ----------------------------------------------------------------------------


def values_of(frame: BinaryFrame) -> st.SearchStrategy[dict[str, Any]]:
    columns: dict[str, st.SearchStrategy[Any]] = {}
    for item in frame.fields:
        if isinstance(item, Raw):
            columns[item.name] = st.binary(min_size=item.size, max_size=item.size).map(bytes.hex)
        elif isinstance(item, Number):
            columns[item.name] = numbers(item)
    return st.fixed_dictionaries(columns)


def numbers(item: Number) -> st.SearchStrategy[Any]:
    if item.choices:
        return st.sampled_from(item.choices)
    if item.floating:
        width = 32 if item.code == "f" else 64
        return st.floats(item.low, item.high, width=width, allow_nan=False, allow_infinity=False)
    bits = 8 * struct.calcsize(item.code)
    low, high = (
        (0, 2**bits - 1) if item.code.isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    )
    if item.low is not None and item.high is not None:
        least, most = item.raw(item.low), item.raw(item.high)
        low, high = max(low, round(least)), min(high, round(most))
    return st.integers(low, high).map(item.value)


TABLES = [
    coreboard.main_to_pc,
    coreboard.pc_to_main,
    coreboard.main_to_sensor,
    coreboard.sensor_to_main,
    rov.up,
    rov.down,
    robot.up,
]


@pytest.mark.parametrize("table", TABLES, ids=lambda t: t(NORMATIVE).name)
@pytest.mark.parametrize("options", [{}, {"float_order": "high"}], ids=["low", "high"])
@settings(max_examples=25)
@given(data=st.data())
def test_what_is_encoded_is_decoded(table: Any, options: dict[str, str], data: Any) -> None:
    frame = table(Tolerances.parse(options))
    values = data.draw(values_of(frame))
    raw = frame.encode(values)
    assert len(raw) == frame.length
    assert frame.check(raw) is None
    assert values.items() <= frame.decode(raw).items()


@settings(max_examples=80)
@given(st.sampled_from(robot.COMMANDS), st.data())
def test_every_command_of_the_robot_survives_the_wire(row: robot.Command, data: Any) -> None:
    frame = robot.DownFrame(NORMATIVE)
    items = {i.name: data.draw(st.integers(i.low, i.high)) for i in row.items}
    raw = frame.encode({"address": row.address, "command": row.command, **items})
    values = frame.decode(raw)
    assert {**items, "length": row.length, "flags": []}.items() <= values.items()
    assert frame.encode(values) == raw
    assert values.get("at", "").startswith(row.at)


@given(*[st.integers(-32768, 32767)] * 3)
def test_can_frames_survive_the_wire(x: int, y: int, z: int) -> None:
    for table, names in ((motorcan.FORCE, "f{}_g"), (motorcan.TORQUE, "m{}_nm")):
        values = {names.format(axis): v for axis, v in zip("xyz", (x, y, z), strict=True)}
        assert table.decode(table.encode(values)) == values


@settings(max_examples=40)
@given(
    st.sampled_from([row for _, row, _ in OTHERS]),
    st.binary(max_size=400),
    st.integers(1, 40),
)
def test_noise_raises_nothing_and_any_chunking_gives_the_same(
    name: str, noise: bytes, size: int
) -> None:
    raw = next(raw for _, row, raw in OTHERS if row == name)
    data = noise + raw + noise[: len(noise) // 2] + raw
    framer = link(name).framer()
    parts = [x for i in range(0, len(data), size) for x in framer.receive(data[i : i + size], 0.0)]
    parts += framer.flush(1.0)
    assert [told(x) for x in parts] == [told(x) for x in stream(name, data)]


def told(item: Frame | FrameFault) -> object:
    return (item.type.name, item.raw, item.offset) if isinstance(item, Frame) else item


# --- readings and tolerances ----------------------------------------------------------------


def replaced(raw: bytes, at: int, data: bytes, check: Any) -> bytes:
    """With other bytes at ``at`` and the checksum made right again by ``check(frame) -> frame``."""
    return bytes(check(raw[:at] + data + raw[at + len(data) :]))


def xored(raw: bytes) -> bytes:
    total = 0
    for byte in raw[:-3]:
        total ^= byte
    return raw[:-3] + bytes([total]) + raw[-2:]


def summed(raw: bytes) -> bytes:
    return raw[:-3] + bytes([sum(raw[4:-3]) & 255]) + raw[-2:]


def test_float_order_high_turns_floats_and_leaves_integers() -> None:
    swapped = bytearray(MAIN_TO_PC)
    for at, size in (
        (2, 4),
        (6, 4),
        (10, 4),
        (14, 8),
        (22, 8),
        *((n, 4) for n in range(30, 50, 4)),
    ):
        swapped[at : at + size] = swapped[at : at + size][::-1]
    other = xored(bytes(swapped))
    assert one("coreboard.main_to_pc", other, float_order="high") == one(
        "coreboard.main_to_pc", MAIN_TO_PC
    )
    assert one("coreboard.main_to_pc", other)["depth_m"] != 10.0
    depth = struct.pack(">f", 20.0)
    assert one("rov.up", replaced(ROV_UP, 43, depth, summed), float_order="high")["depth_m"] == 20.0


def test_the_eight_byte_example_of_002_is_no_frame() -> None:
    example = bytes.fromhex("FE EF 05 DC 01 C9 FD DF")
    for name in ("coreboard.pc_to_main", "coreboard.main_to_sensor"):
        assert fault(name, example) == "truncated"


def test_the_printed_checksums_of_002_are_refused() -> None:
    assert (
        fault("coreboard.main_to_sensor", MAIN_TO_SENSOR[:34] + b"\xc9\xfd\xdf") == "bad_checksum"
    )
    assert fault("coreboard.main_to_pc", MAIN_TO_PC[:87] + b"\xd7\xfa\xaf") == "bad_checksum"


def test_tails_are_those_that_each_table_prints() -> None:
    assert fault("coreboard.main_to_sensor", MAIN_TO_SENSOR[:-2] + b"\xfa\xaf") == "bad_tail"
    assert fault("coreboard.main_to_pc", MAIN_TO_PC[:-2] + b"\xfd\xdf") == "bad_tail"


def test_the_older_layout_of_4_2_is_told_by_its_flags() -> None:
    old = bytes.fromhex(
        "FE EF 0E D8 00 00 00 00 01 A8 02 93 C1 81 24 6E 41 DC 0D 18 C2 94 48 9C 3E 1B 31 D6 3D 2F"
        f"65 A1 3C {'00' * 119} D7 FA AF"
    )
    flags = one("coreboard.sensor_to_main", old)["flags"]
    assert "leak_legacy_raw:bad_enum" in flags


def test_a_disagreement_of_the_two_leak_bytes_is_flagged() -> None:
    wet = replaced(SENSOR_TO_MAIN, 133, b"\x01", xored)
    assert one("coreboard.sensor_to_main", wet)["flags"] == ["leak_legacy_raw:disagrees"]
    both = replaced(wet, 23, b"\x00", xored)
    assert one("coreboard.sensor_to_main", both)["flags"] == []


def test_valid_bits_are_named_from_the_lowest() -> None:
    values = one("coreboard.sensor_to_main", replaced(SENSOR_TO_MAIN, 151, b"\x25", xored))
    assert values["valid_bits"] == ["DVL", "INS"]
    assert values["flags"] == ["valid:out_of_range"]


@pytest.mark.parametrize(
    ("at", "data", "kind"),
    [
        (35, b"\xc9", "out_of_range"),  # a force above 200
        (34, b"\x05", "bad_enum"),
        (41, b"\x02", "bad_enum"),
        (43, b"\xff", "bad_enum"),
        (2, struct.pack("<d", 90.5), "out_of_range"),
        (10, struct.pack("<d", math.nan), "out_of_range"),
        (26, struct.pack("<f", math.inf), "out_of_range"),
    ],
)
def test_a_command_with_a_value_outside_is_refused_whole(at: int, data: bytes, kind: str) -> None:
    assert fault("coreboard.pc_to_main", replaced(PC_TO_MAIN, at, data, xored)) == kind


def test_a_force_of_zero_counts_is_full_reverse() -> None:
    values = one("coreboard.pc_to_main", replaced(PC_TO_MAIN, 35, bytes(6), xored))
    assert [values[name] for name in ("tx", "ty", "tz", "mx", "my", "mz")] == [-100] * 6


def test_telemetry_out_of_range_is_kept_and_flagged() -> None:
    values = one("rov.up", replaced(ROV_UP, 63, struct.pack("<i", 101), summed))
    assert (values["temperature_c"], values["flags"]) == (101, ["temperature_c:out_of_range"])
    values = one("rov.up", replaced(ROV_UP, 43, struct.pack("<f", math.nan), summed))
    assert (values["depth_m"], values["flags"]) == (None, ["depth_m:nan"])


@pytest.mark.parametrize(("name", "raw"), [("rov.up", ROV_UP), ("rov.down", ROV_DOWN)])
def test_len003_loose_trusts_the_type_and_not_the_length_byte(name: str, raw: bytes) -> None:
    stale = raw[:3] + b"\x2b" + raw[4:]
    assert fault(name, stale) == "bad_length"
    assert one(name, stale, len003="loose") == one(name, raw)
    assert one(name, raw, len003="loose") == one(name, raw)
    assert fault(name, stale[:-3] + b"\xee\r\n", len003="loose") == "bad_checksum"


def test_the_examples_of_003_are_refused_as_printed() -> None:
    up = "55 AA 01 2B 01 01 00" + "00" * 58 + "02 0D 0A"
    down = "55 AA 11 15 01 01 00" + "00" * 21 + "02 0D 0A"
    assert fault("rov.up", bytes.fromhex(up)) == "truncated"
    assert fault("rov.down", bytes.fromhex(down)) == "bad_tail"


@pytest.mark.parametrize(("at", "value"), [(7, 2), (8, 2), (9, 101), (10, 31), (10, 0xE0)])
def test_the_rov_refuses_commands_outside(at: int, value: int) -> None:
    bad = replaced(ROV_DOWN, at, bytes([value]), summed)
    assert fault("rov.down", bad) in ("out_of_range", "bad_enum")


def robot_frame(*head: int, user: bytes = b"", modulus: int = 255) -> bytes:
    body = bytes([0xAA, *head]) + user.ljust(6, b"\0")
    return body + bytes([sum(body) % modulus, 0xDD])


def test_the_checksum_printed_in_004_is_refused() -> None:
    assert (
        fault("robot.down", bytes.fromhex("AA 01 01 00 00 00 00 00 00 00 01 DD")) == "bad_checksum"
    )


def test_mod_256_and_either_while_commissioning() -> None:
    full = robot_frame(1, 0x20, 2, user=b"\xf0\x70", modulus=256)
    assert full != robot_frame(1, 0x20, 2, user=b"\xf0\x70")
    assert fault("robot.down", full) == "bad_checksum"
    assert one("robot.down", full, mod="256")["speed_mm_s"] == 0x70F0
    for modulus in (255, 256):
        frame = robot_frame(1, 0x20, 2, user=b"\xf0\x70", modulus=modulus)
        assert one("robot.down", frame, mod="either")["speed_mm_s"] == 0x70F0


@pytest.mark.parametrize(
    ("frame", "kind"),
    [
        (robot_frame(0, 0, 0), "out_of_range"),
        (robot_frame(1, 0x0B, 0), "bad_enum"),
        (robot_frame(2, 4, 0), "bad_enum"),
        (robot_frame(1, 0, 7), "out_of_range"),
        (robot_frame(2, 1, 1, user=b"\x04"), "bad_enum"),
        (robot_frame(4, 5, 1, user=b"\x06"), "out_of_range"),
        (robot_frame(4, 6, 4, user=(36_001).to_bytes(4, "little")), "out_of_range"),
    ],
)
def test_the_robot_refuses_what_its_tables_do_not_hold(frame: bytes, kind: str) -> None:
    assert fault("robot.down", frame) == kind


def test_devices_without_a_table_pass_with_their_raw_bytes() -> None:
    values = one("robot.down", robot_frame(3, 0x77, 2, user=b"\x01\x02"))
    assert (values["address"], values["command"], values["user"]) == (3, 0x77, "010200000000")
    assert robot.DownFrame(NORMATIVE).encode(values) == robot_frame(3, 0x77, 2, user=b"\x01\x02")


def test_a_length_that_disagrees_and_rest_bytes_are_flagged() -> None:
    values = one("robot.down", robot_frame(1, 1, 6, user=b"\x00\x05"))
    assert values["flags"] == ["length:disagrees", "user:not_zero"]


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"address": 1, "command": 0x20}, "speed_mm_s is missing"),
        ({"address": 1, "command": 0x20, "speed_mm_s": 1.5}, "whole number"),
        ({"address": 1, "command": 0x20, "speed_mm_s": 40_000}, "outside"),
        ({"address": 1, "command": 0x50}, "bad_enum"),
        ({"command": 1}, "address is missing"),
        ({"address": 4, "command": 5, "user": "090000000000", "length": 1}, "out_of_range"),
    ],
)
def test_the_robot_is_sent_nothing_that_it_would_refuse(values: Values, says: str) -> None:
    with pytest.raises(CannotEncode, match=says):
        robot.DownFrame(NORMATIVE).encode(values)


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        ("002#FF001000200030", "bad_header"),  # identifier and first byte disagree
        ("001#FE001000200030", "bad_header"),
        ("003#FF001000200030", "bad_header"),
        ("001#FF0010002000", "bad_length"),
        ("001#FF00100020003000", "bad_length"),
    ],
)
def test_identifier_length_and_first_byte_of_a_can_frame_must_agree(line: str, kind: str) -> None:
    assert fault("coreboard.can", from_line(line)) == kind


def test_can_id_replaces_the_identifiers_of_the_tables() -> None:
    for first, key in (("FF", "fx_g"), ("FE", "mx_nm")):
        record = from_line(f"10A#{first}001000200030")
        assert fault("coreboard.can", record) == "bad_header"
        assert one("coreboard.can", record, can_id="0x10a")[key] == 16
    assert fault("coreboard.can", from_line("001#FF001000200030"), can_id="0x10a") == "bad_header"


def test_a_candump_line_is_read_and_a_wrong_one_is_refused_with_what_to_write() -> None:
    dumped = "(1436509052.249713) can0 001#FF001000200030"
    assert from_line(dumped) == from_line("1#ff001000200030")
    for line in ("FF001000200030", "001#FF0", "800#00", f"001#{'00' * 9}"):
        with pytest.raises(ValueError, match=r"001#FF|standard"):
            from_line(line)


def test_bare_pads_and_reserved_bytes_are_the_only_ones_that_do_not_come_back() -> None:
    pads = [
        (name, item.size)
        for name, frame in frame_types().items()
        if isinstance(frame, BinaryFrame) and not name.startswith("auv")
        for item in frame.fields
        if isinstance(item, Pad)
    ]
    assert pads == [("rov.DOWN", 1), ("rov.UP", 1)]
