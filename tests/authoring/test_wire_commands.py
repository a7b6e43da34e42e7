"""decode, encode and find-crc as a person and as a program use them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from mission.cli import main
from protocol.checksum import sd_profile
from protocol.vehicles import frame_types

SD = frame_types()["auv.SD"]
GOOD = bytes.fromhex("405344" + "00" * 60 + "DC05" * 7 + "0C003000" + "F05C9375" + "24")


def run(*arguments: str, data: bytes = b"", code: int = 0) -> str:
    result = CliRunner().invoke(main, arguments, input=data)
    assert result.exit_code == code, result.output
    return result.output


def test_a_person_sees_offsets_names_units_and_faults(tmp_path: Path) -> None:
    file = tmp_path / "capture.bin"
    file.write_bytes(b"xx" + GOOD + b"@ACK_RI\x80$")
    text = run("decode", "--link", "auv.from_stm32", str(file))
    assert "0  FAULT bad_header, 2 bytes" in text
    assert "2  auv.SD, 86 bytes  (000 table 3.2)" in text
    assert "+19  depth_m                             0 m" in text
    assert "+27  mag_front_x                         0 uT" in text
    assert "+63  pwm_left_main                    1500 us" in text
    assert "doubtful: mask:out_of_range" in text
    assert text.endswith("2 frames; faults: 1 bad_header; 2 bytes skipped\n")


def test_a_program_gets_one_object_per_line() -> None:
    output = run("decode", "--link", "auv.to_pi", "--json", data=b"@MMF5$..@NI$")
    assert [json.loads(line) for line in output.splitlines()] == [
        {"offset": 0, "type": "auv.MM", "values": {"dir": "F", "speed": 5}},
        {"offset": 6, "fault": "bad_header", "length": 2},
        {"offset": 8, "type": "auv.NI", "values": {}},
    ]


def test_hex_is_one_stream_over_all_lines() -> None:
    text = GOOD.hex(" ", 8).encode()
    cut = text[:41].rsplit(b" ", 1)[0]
    output = run(
        "decode", "--link", "auv.from_stm32", "--json", "--hex", data=cut + b"\n" + text[len(cut) :]
    )
    assert json.loads(output)["type"] == "auv.SD"


def test_every_hex_line_is_a_stream_of_its_own() -> None:
    lines = [GOOD.hex(), "", GOOD[:20].hex(), "404e4924 404e49"]
    output = run("decode", "--link", "auv.any", "--hex-lines", data="\n".join(lines).encode())
    first, second, third, fourth = map(json.loads, output.splitlines())
    assert first[0]["values"]["pwm_left_main"] == 1500
    assert second == []
    assert third == [{"offset": 0, "fault": "truncated", "length": 20}]
    assert fourth[0] == {"offset": 0, "type": "auv.NI", "values": {}}
    assert fourth[1] == {"offset": 4, "fault": "truncated", "length": 3}


def test_what_is_no_number_is_null_and_flagged_in_json() -> None:
    values = SD.decode(GOOD) | {"depth_m": None, "roll_deg": None}
    output = run("decode", "--link", "auv.from_stm32", "--json", data=SD.encode(values))
    decoded = json.loads(output, parse_constant=pytest.fail)["values"]
    assert decoded["depth_m"] is None
    assert decoded["flags"] == ["roll_deg:nan", "depth_m:nan"]
    shown = run("decode", "--link", "auv.from_stm32", data=SD.encode(values))
    assert "depth_m                             - m" in shown


def test_can_frames_are_lines_of_their_own() -> None:
    lines = b"001#FF001000200030\n\n002#FE001000200030\n"
    output = run("decode", "--link", "coreboard.can", "--json", data=lines)
    assert [json.loads(line)["type"] for line in output.splitlines()] == [
        "coreboard.CAN_FORCE",
        "coreboard.CAN_TORQUE",
    ]


def test_a_tolerance_is_an_option() -> None:
    arguments = ("decode", "--link", "auv.to_stm32", "--json")
    assert json.loads(run(*arguments, data=b"@ZAA1,2$"))["fault"] == "field_count"
    output = run(*arguments, "--option", "zaa_comma=on", data=b"@ZAA1,2$")
    assert json.loads(output)["values"]["roll_deg"] == 2
    assert (
        json.loads(run(*arguments, "--option", "zaa_comma", data=b"@ZAA1,2$"))["type"] == "auv.ZA"
    )


@pytest.mark.parametrize(
    ("arguments", "data", "message"),
    [
        (("decode", "--link", "auv.nowhere"), b"", "auv.from_stm32"),
        (("decode", "--link", "auv.any", "--option", "x=1"), b"", "st_compact"),
        (("decode", "--link", "auv.any", "--hex"), b"40\n4x", "line 2: not hexadecimal: '4x'"),
        (("decode", "--link", "auv.any", "--hex-lines"), b"zz", "line 1: not hexadecimal"),
        (("decode", "--link", "coreboard.can"), b"\n1-FF\n", "line 2: no CAN frame ID#DATA"),
        (("encode", "auv.XX"), b"", "auv.SD"),
        (("encode", "auv.MM", "{"), b"", "no JSON"),
        (("encode", "auv.MM", "[]"), b"", "an object is needed"),
        (("find-crc", "--hex", "-"), b"zz", "not hexadecimal"),
    ],
)
def test_bad_usage_says_what_instead(arguments: tuple[str, ...], data: bytes, message: str) -> None:
    assert message in run(*arguments, data=data, code=2).replace("\n", " ")


def test_encode_prints_the_frame_raw_or_as_hex() -> None:
    values = json.dumps({"code": "H", "heading_deg": -90})
    assert run("encode", "auv.ZA", values) == "@ZAH-90$"
    assert run("encode", "auv.ZA", values, "--hex") == b"@ZAH-90$".hex() + "\n"
    assert run("encode", "auv.DU") == "@DU$"


def test_encode_refuses_what_is_out_of_range() -> None:
    assert "outside 0..12" in run("encode", "auv.MM", '{"dir": "F", "speed": 13}', code=2)


def test_encode_refuses_names_that_the_frame_does_not_have() -> None:
    typed = '{"thruster": 1, "gear": 3, "speed": 2}'
    says = run("encode", "auv.MT", typed, code=2)
    assert "called speed" in says
    assert "thruster, gear" in says
    assert "called gear" in run("encode", "auv.ZA", '{"code": "X", "gear": 3}', code=2)
    assert "are none" in run("encode", "auv.NI", '{"a": 1}', code=2)
    shown = json.dumps({"switches": "COOCCCO", "effective": "OOOCOCO", "flags": []})
    assert run("encode", "auv.RS", shown) == "@RSCOOCCCO$"


def test_decode_and_encode_are_each_others_inverse() -> None:
    line = json.loads(run("decode", "--link", "auv.any", "--json", data=GOOD))
    assert run("encode", line["type"], json.dumps(line["values"]), "--hex").strip() == GOOD.hex()


def test_find_crc_names_the_profile_of_a_capture(tmp_path: Path) -> None:
    profile = sd_profile("bytes/frame")
    frames = b""
    for depth in range(1, 6):
        raw = SD.encode(SD.decode(GOOD) | {"depth_m": depth})
        frames += raw[:81] + profile.compute(raw[:81]).to_bytes(4, "little") + b"$.."
    file = tmp_path / "capture.bin"
    file.write_bytes(frames + b"@SD" + b"$" * 83 + b"@SD")
    assert run("find-crc", str(file)).startswith("bytes/frame: right in 5 of 6 candidates")
    found = json.loads(run("find-crc", "--json", str(file)))
    assert found == {"profile": "bytes/frame", "candidates": 6, "votes": {"bytes/frame": 5}}
    decoded = run("decode", "--link", "auv.from_stm32", "--option", "sd_crc=bytes/frame", str(file))
    assert "5 frames" in decoded


def test_find_crc_says_what_it_tried() -> None:
    broken = GOOD[:30] + b"\x07" + GOOD[31:]
    assert "no profile fits" in run("find-crc", "--hex", "-", data=broken.hex().encode(), code=1)


def test_profiles_that_cannot_be_told_apart_are_all_named() -> None:
    data = bytes(78)
    frames = b""
    for name in ("words/data", "words-truncated/data"):
        frames += b"@SD" + data + sd_profile(name).compute(data).to_bytes(4, "little") + b"$"
    text = run("find-crc", "-", data=frames)
    assert text.startswith("words/data: right in 1 of 2")
    assert "also words-truncated/data: right in 1" in text
