"""PD0, the binary ensembles of Doppler logs: bottom track and water track, in ship's axes.

    7F 7F | bytes, u16 | spare | types n | n offsets, u16 | types ... | reserved | sum, u16

All numbers are little-endian. The sum is over all bytes before it, modulo 65536. ``bytes`` counts
all but the sum. Two types are read, with bytes counted from 1:

    0000  fixed leader    byte 26: the axes
    0600  bottom track    from byte 25: velocities over ground; from byte 51: of the water layer;
                          mm/s, -32768 if there is none

PD0 gives the velocity of ground and water relative to the instrument; ``velocities`` returns the
vehicle's own, as PD6 does. Only ship's axes are accepted: for beam and instrument axes the mounting
is not known, and earth axes include the log's own compass.

Source: Teledyne RD Instruments, Workhorse Commands and Output Data Format, "PD0". What does not
live here: where an ensemble ends among other lines (added).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from enum import Enum

MARK = b"\x7f\x7f"
SMALLEST, LARGEST = 8 + 59 + 2, 4096  # bytes, of the count in the header
MOST_TYPES = 16
_HEADER = struct.Struct("<2sHBB")
TOLD = _HEADER.size + 2  # bytes that are enough to tell whether an ensemble begins
_NONE = -32768
_FIXED, _BOTTOM = 0x0000, 0x0600
_AXES, _SHIP = 25, 0b10  # byte of the fixed leader, 0 the first; bits 3 and 4 of it
_OVER_GROUND, _IN_WATER = 24, 50  # bytes of the bottom track, 0 the first
_FEWEST = {_FIXED: 26, _BOTTOM: 58}  # bytes that must be there


class Whole(Enum):
    NOT_YET = "more bytes are needed to tell"
    NEVER = "no ensemble begins here"


class Unfit(ValueError):
    """A whole ensemble that cannot be used."""


def length(data: bytes) -> int | Whole:
    """Return the length in bytes, sum included, of the ensemble at the start of ``data``."""
    if not MARK.startswith(data[:2]):
        return Whole.NEVER
    if len(data) < _HEADER.size:
        return Whole.NOT_YET
    _, count, _, types = _HEADER.unpack_from(data)
    if not (SMALLEST <= count <= LARGEST and 0 < types <= MOST_TYPES):
        return Whole.NEVER
    first = _HEADER.size + 2 * types
    if len(data) >= TOLD and _word(data, _HEADER.size) != first:
        return Whole.NEVER
    return int(count) + 2


def begins(data: bytes, start: int, end: int) -> int:
    """Return where the first ensemble begins (or may begin, if fewer than TOLD bytes follow), from
    ``start`` on and before ``end``; -1 if none does."""
    while (start := data.find(MARK, start, end)) >= 0:
        if length(data[start : start + TOLD]) is not Whole.NEVER:
            break
        start += 1
    return start


def sum16(data: bytes) -> int:
    return sum(data) & 0xFFFF


def velocities(ensemble: bytes) -> Iterator[tuple[bool, float, float]]:
    """Yield whether over ground (else through water), ahead and starboard, m/s. ``ensemble`` has
    the length that ``length`` returned. Raises Unfit."""
    if sum16(ensemble[:-2]) != _word(ensemble, len(ensemble) - 2):
        raise Unfit("sum")
    parts = _parts(ensemble)
    if _BOTTOM not in parts:
        return
    if _FIXED not in parts or ensemble[parts[_FIXED] + _AXES] >> 3 & 0b11 != _SHIP:
        raise Unfit("axes")
    for ground, at in ((True, _OVER_GROUND), (False, _IN_WATER)):
        starboard, ahead = struct.unpack_from("<2h", ensemble, parts[_BOTTOM] + at)
        if _NONE not in (starboard, ahead):
            yield ground, -ahead / 1000.0, -starboard / 1000.0


def _parts(ensemble: bytes) -> dict[int, int]:
    """Return where each type that is read begins. Raises Unfit."""
    found: dict[int, int] = {}
    for n in range(ensemble[5]):
        at = _word(ensemble, _HEADER.size + 2 * n)
        if at + 2 > len(ensemble) - 2:
            raise Unfit("offset")
        kind = _word(ensemble, at)
        if at + _FEWEST.get(kind, 0) > len(ensemble) - 2:
            raise Unfit("offset")
        if kind in _FEWEST:
            found[kind] = at
    return found


def _word(data: bytes, at: int) -> int:
    return int.from_bytes(data[at : at + 2], "little")
