"""Checksums of the four documents, and other readings of the ``@SD`` CRC that a capture may need.

    crc32_stm32    000 @SD   CRC-32/MPEG-2 over byte-swapped words (E-V19)
    crc16_modbus   000 modem
    xor8           002
    sum255         004       mod 255 never gives FF (E-P2); sum256 as tolerance
    sum256         003

What does not live here: which bytes a checksum covers; the frame's table has that.
"""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Callable
from dataclasses import dataclass

import crcmod

Checksum = Callable[[bytes], int]

_mpeg2: Checksum = crcmod.mkCrcFun(0x104C11DB7, initCrc=0xFFFFFFFF, rev=False, xorOut=0)
_mpeg2_from_0: Checksum = crcmod.mkCrcFun(0x104C11DB7, initCrc=0, rev=False, xorOut=0)
_ethernet: Checksum = crcmod.mkCrcFun(0x104C11DB7, initCrc=0, rev=True, xorOut=0xFFFFFFFF)
_modbus: Checksum = crcmod.mkCrcFun(0x18005, initCrc=0xFFFF, rev=True, xorOut=0)

_MASK = 0xFFFFFFFF
_WORD = next(code for code in "IL" if array(code).itemsize == 4)


def crc16_modbus(data: bytes) -> int:
    """CRC-16/MODBUS; "123456789" gives 4B37."""
    return _modbus(data)


def xor8(data: bytes) -> int:
    """XOR of all bytes."""
    value = 0
    for byte in data:
        value ^= byte
    return value


def sum255(data: bytes) -> int:
    return sum(data) % 255


def sum256(data: bytes) -> int:
    return sum(data) & 0xFF


def crc32_stm32(data: bytes) -> int:
    """CRC of the STM32's unit, fed with little-endian words, the last one padded with zeros."""
    words = array(_WORD, data + _ZEROS[len(data) & 3])
    words.byteswap()
    return _mpeg2(words)  # type: ignore[arg-type]  # any buffer will do


_ZEROS = (b"", b"\0\0\0", b"\0\0", b"\0")
_REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def stm32_checker(length: int) -> Callable[[bytes, bytes], bool]:
    """Return a function that tests whether ``length`` bytes (whole words) have this
    ``crc32_stm32``, at half of its cost.

    Ethernet's CRC has the same polynomial, but reads the bits of each byte in reverse. Over data
    followed by its own CRC it is a constant. zlib computes it faster than crcmod's table. This
    check only confirms a CRC: one that is sent, shown or searched for is computed above.
    """
    words = array(_WORD, bytes(length + 4))
    view = memoryview(words).cast("B")

    def agrees(data: bytes, stored: bytes) -> bool:
        view[:] = (data + stored).translate(_REVERSED)
        words.byteswap()
        return zlib.crc32(words) == _MASK

    return agrees


# --- other readings of "STM32 hardware CRC" (tolerance sd_crc, auvmission find-crc) -------------


def crc32_mpeg2(data: bytes) -> int:
    return _mpeg2(data)


def _swapped(data: bytes) -> bytes:
    words = array(_WORD, data)
    words.byteswap()
    return words.tobytes()


def _whole(data: bytes) -> bytes:
    return data[: len(data) & ~3]


def _filled(data: bytes, filler: bytes) -> bytes:
    return data + filler * (-len(data) & 3)


def _little_tail_bytes(data: bytes) -> int:
    whole = _whole(data)
    return _mpeg2(_swapped(whole) + data[len(whole) :])


def _little_zero_word(data: bytes) -> int:
    whole = _whole(data)
    return _mpeg2(_swapped(whole) + (b"\0\0\0\0" if len(whole) < len(data) else b""))


def _byte_a_word(data: bytes) -> int:
    return _mpeg2(b"".join(b"\0\0\0" + data[i : i + 1] for i in range(len(data))))


def _field_a_word(data: bytes) -> int:
    """15 floats as they are, then each u16 in a word of its own (the layout of ``@SD``)."""
    floats, words = data[:60], data[60:]
    singles = b"".join(words[i : i + 2] + b"\0\0" for i in range(0, len(words), 2))
    return crc32_stm32(floats + singles)


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to turn bytes into a CRC-32."""

    name: str
    compute: Checksum


READINGS = (
    Reading("words", crc32_stm32),
    Reading("words-truncated", lambda d: crc32_stm32(_whole(d))),
    Reading("words-ff", lambda d: crc32_stm32(_filled(d, b"\xff"))),
    Reading("words-tail-bytes", _little_tail_bytes),
    Reading("words-tail-dropped", _little_zero_word),
    Reading("words-inverted", lambda d: crc32_stm32(d) ^ _MASK),
    Reading("words-reflected", lambda d: _ethernet(_filled(d, b"\0"))),
    Reading("big-words", lambda d: _mpeg2(_filled(d, b"\0"))),
    Reading("big-words-truncated", lambda d: _mpeg2(_whole(d))),
    Reading("big-words-ff", lambda d: _mpeg2(_filled(d, b"\xff"))),
    Reading("bytes", _mpeg2),
    Reading("bytes-inverted", lambda d: _mpeg2(d) ^ _MASK),
    Reading("bytes-from-0", _mpeg2_from_0),
    Reading("ethernet", _ethernet),
    Reading("ethernet-not-inverted", lambda d: _ethernet(d) ^ _MASK),
    Reading("byte-a-word", _byte_a_word),
    Reading("field-a-word", _field_a_word),
)


@dataclass(frozen=True, slots=True)
class SdProfile:
    """A reading and the bytes that it covers: ``data`` 3..80 of the frame, ``frame`` 0..80."""

    name: str
    first: int
    compute: Checksum


SD_PROFILES = tuple(
    SdProfile(f"{reading.name}/{cover}", first, reading.compute)
    for reading in READINGS
    for cover, first in (("data", 3), ("frame", 0))
    if not (reading.compute is _field_a_word and cover == "frame")
)
SD_DEFAULT = "words/data"


def find_sd_crc_profile(frame: bytes) -> tuple[str, ...]:
    """Return the names of all profiles whose CRC fits this 86-byte frame, the normative first."""
    stored = int.from_bytes(frame[81:85], "little")
    return tuple(p.name for p in SD_PROFILES if p.compute(frame[p.first : 81]) == stored)


def sd_profile(name: str) -> SdProfile:
    """Raises KeyError for an unknown name."""
    return {profile.name: profile for profile in SD_PROFILES}[name]
