"""The checksums against published check values and slow references."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from canonical_auv import SD
from hypothesis import given
from hypothesis import strategies as st

from protocol.checksum import (
    READINGS,
    SD_DEFAULT,
    SD_PROFILES,
    Reading,
    crc16_modbus,
    crc32_mpeg2,
    crc32_stm32,
    find_sd_crc_profile,
    sd_profile,
    stm32_checker,
    sum255,
    sum256,
    xor8,
)

CHECK = b"123456789"

# the letter of the row in golden/crc_check_values.json -> the reading
GOLDEN = {
    "A": "bytes",
    "B": "words",
    "C": "words-truncated",
    "D": "words-ff",
    "E": "big-words",
    "F": "big-words-truncated",
    "G": "big-words-ff",
    "H": "words-tail-bytes",
    "I": "words-tail-dropped",
    "J": "byte-a-word",
    "K": "ethernet",
    "L": "ethernet-not-inverted",
    "M": "words-reflected",
    "N": "bytes-inverted",
    "O": "words-inverted",
    "P": "bytes-from-0",
}


def bitwise(words: list[int], crc: int = 0xFFFFFFFF) -> int:
    for word in words:
        crc ^= word
        for _ in range(32):
            crc = (crc << 1 ^ (0x04C11DB7 if crc >> 31 else 0)) & 0xFFFFFFFF
    return crc


@given(st.binary(max_size=90))
def test_the_stm32_unit_eats_little_endian_words_filled_with_zeros(data: bytes) -> None:
    padded = data + bytes(-len(data) % 4)
    words = [int.from_bytes(padded[i : i + 4], "little") for i in range(0, len(padded), 4)]
    assert crc32_stm32(data) == bitwise(words)


@given(st.binary(min_size=8, max_size=8), st.binary(min_size=80, max_size=80), st.integers(0, 31))
def test_a_checker_agrees_with_the_stm32_unit_alone(short: bytes, usual: bytes, bit: int) -> None:
    for data in (short, usual):
        agrees, crc = stm32_checker(len(data)), crc32_stm32(data)
        for _ in range(2):  # nothing is left over from the one before
            assert agrees(data, crc.to_bytes(4, "little"))
            assert not agrees(data, (crc ^ 1 << bit).to_bytes(4, "little"))
        assert not agrees(bytes([data[0] ^ 1]) + data[1:], crc.to_bytes(4, "little"))


def test_published_check_values() -> None:
    assert crc32_mpeg2(CHECK) == 0x0376E6E7
    assert crc32_stm32(bytes.fromhex("78563412")) == 0xDF8A8A2B
    assert crc16_modbus(CHECK) == 0x4B37
    assert xor8(bytes.fromhex("FEEF05DC01")) == 0xC9
    assert sum255(bytes.fromhex("AA0101" + "00" * 7)) == 0xAC
    assert sum255(bytes.fromhex("AA550100")) == 1
    assert sum256(bytes.fromhex("AA550100")) == 0


def test_every_reading_agrees_with_its_check_values(recordings: Path) -> None:
    table = json.loads((recordings / "golden" / "crc_check_values.json").read_text())
    inputs = (CHECK, bytes(range(0x4E)), bytes(range(0x51)), bytes(range(0x50)))
    readings = {reading.name: reading.compute for reading in READINGS}
    seen = set()
    for title, row in table.items():
        name = GOLDEN.get(title.split(" ")[0])
        if name is not None:
            seen.add(name)
            found = [f"{readings[name](data):08X}" for data in inputs]
            assert found == list(row.values()), title
    assert seen == set(GOLDEN.values())


def test_the_golden_frame_has_the_normative_profile(recordings: Path) -> None:
    raw = (recordings / "golden" / "sd_golden_A9F20A86.bin").read_bytes()
    assert find_sd_crc_profile(raw) == (SD_DEFAULT,)
    assert sd_profile(SD_DEFAULT).compute(raw[3:81]) == 0xA9F20A86


@pytest.mark.parametrize("profile", SD_PROFILES, ids=lambda p: p.name)
def test_a_frame_of_each_profile_names_it(profile: object) -> None:
    from protocol.checksum import SdProfile

    assert isinstance(profile, SdProfile)
    data = bytes((i * 73 + 11) & 0xFF for i in range(78))
    frame = b"@SD" + data
    frame += profile.compute(frame[profile.first :]).to_bytes(4, "little") + b"$"
    assert profile.name in find_sd_crc_profile(frame)


def test_no_profile_fits_a_wrong_frame() -> None:
    assert find_sd_crc_profile(SD[:40] + b"\x01" + SD[41:]) == ()


def test_each_field_as_a_word() -> None:
    reading = next(r for r in READINGS if r.name == "field-a-word")
    data = SD[3:81]
    words = [int.from_bytes(data[i : i + 4], "little") for i in range(0, 60, 4)]
    words += [int.from_bytes(data[i : i + 2], "little") for i in range(60, 78, 2)]
    assert reading.compute(data) == bitwise(words)


def test_profiles_are_every_reading_over_data_and_over_the_frame() -> None:
    """But a field a word, which the frame's head is not; what they cover begins there."""
    rows = {(p.name, p.first) for p in SD_PROFILES}
    both = {(f"{r.name}/{c}", at) for r in READINGS for c, at in (("data", 3), ("frame", 0))}
    assert rows == both - {("field-a-word/frame", 0)}


def bytewise(data: bytes, crc: int = 0xFFFFFFFF) -> int:
    """CRC-32 of 0x04C11DB7, highest bit first, bit by bit."""
    for byte in data:
        crc ^= byte << 24
        for _ in range(8):
            crc = (crc << 1 ^ (0x04C11DB7 if crc >> 31 else 0)) & 0xFFFFFFFF
    return crc


def mirrored(value: int, bits: int) -> int:
    return int(f"{value:0{bits}b}"[::-1], 2)


def ethernet(data: bytes) -> int:
    return mirrored(bytewise(bytes(mirrored(byte, 8) for byte in data)), 32) ^ 0xFFFFFFFF


def whole(data: bytes) -> bytes:
    return data[: len(data) // 4 * 4]


def filled(data: bytes, filler: bytes) -> bytes:
    while len(data) % 4:
        data += filler
    return data


def little(data: bytes) -> bytes:
    """Words of four bytes, each from its other end."""
    return b"".join(data[i : i + 4][::-1] for i in range(0, len(data), 4))


def spread(data: bytes) -> bytes:
    singles = [data[i : i + 2] + b"\0\0" for i in range(60, len(data), 2)]
    return filled(data[:60] + b"".join(singles), b"\0")


SPOKEN = {
    "words": lambda d: bytewise(little(filled(d, b"\0"))),
    "words-truncated": lambda d: bytewise(little(whole(d))),
    "words-ff": lambda d: bytewise(little(filled(d, b"\xff"))),
    "words-tail-bytes": lambda d: bytewise(little(whole(d)) + d[len(whole(d)) :]),
    "words-tail-dropped": lambda d: bytewise(little(whole(d)) + bytes(4) * (len(d) % 4 > 0)),
    "words-inverted": lambda d: bytewise(little(filled(d, b"\0"))) ^ 0xFFFFFFFF,
    "words-reflected": lambda d: ethernet(filled(d, b"\0")),
    "big-words": lambda d: bytewise(filled(d, b"\0")),
    "big-words-truncated": lambda d: bytewise(whole(d)),
    "big-words-ff": lambda d: bytewise(filled(d, b"\xff")),
    "bytes": bytewise,
    "bytes-inverted": lambda d: bytewise(d) ^ 0xFFFFFFFF,
    "bytes-from-0": lambda d: bytewise(d, 0),
    "ethernet": ethernet,
    "ethernet-not-inverted": lambda d: ethernet(d) ^ 0xFFFFFFFF,
    "byte-a-word": lambda d: bytewise(b"".join(bytes((0, 0, 0, byte)) for byte in d)),
    "field-a-word": lambda d: bytewise(little(spread(d))),
}


@pytest.mark.parametrize("reading", READINGS, ids=lambda r: r.name)
def test_every_reading_is_what_its_name_says(reading: Reading) -> None:
    """Computed slowly and from the name alone; for every length of the last word."""
    data = bytes((7 * i + 13 * (i % 5)) & 0xFF for i in range(85))
    for length in (*range(10), 60, 62, *range(75, 86)):
        assert reading.compute(data[:length]) == SPOKEN[reading.name](data[:length]), length


def test_a_profile_is_found_by_its_name() -> None:
    assert [sd_profile(profile.name) for profile in SD_PROFILES] == list(SD_PROFILES)
    with pytest.raises(KeyError):
        sd_profile("words")
