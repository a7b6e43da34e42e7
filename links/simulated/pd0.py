"""The binary ensemble (PD0) of the simulated Doppler log: bottom and water track in ship's axes.

Leaders are empty except for the axes. What does not live here: the measurements (added), the
decoder.
"""

from __future__ import annotations

import struct

_NONE = (-32.768, -32.768)
_SHIP = 0b10111  # coordinate transformation: ship's axes, tilts used
_LEADER, _VARIABLE, _BOTTOM = 0x0000, 0x0080, 0x0600
_SIZES = {_LEADER: 59, _VARIABLE: 65, _BOTTOM: 81}

Speeds = tuple[float, float]  # to starboard and ahead, m/s


def ensemble(ground: Speeds | None, water: Speeds) -> bytes:
    """Build an ensemble. ``ground`` is None if the bottom is out of reach."""
    parts = {kind: bytearray(size) for kind, size in _SIZES.items()}
    at, offsets = 6 + 2 * len(parts), list[int]()
    for kind, part in parts.items():
        part[:2] = struct.pack("<H", kind)
        offsets.append(at)
        at += len(part)
    parts[_LEADER][25] = _SHIP
    struct.pack_into("<2h", parts[_BOTTOM], 24, *_past(_NONE if ground is None else ground))
    struct.pack_into("<2h", parts[_BOTTOM], 50, *_past(water))
    head = struct.pack(f"<2sHBB{len(parts)}H", b"\x7f\x7f", at + 2, 0, len(parts), *offsets)
    body = head + b"".join(parts.values()) + bytes(2)
    return body + struct.pack("<H", sum(body) % 65536)


def _past(speeds: Speeds) -> tuple[int, int]:
    """Velocity of ground or water relative to the instrument, mm/s."""
    if speeds == _NONE:
        return -32768, -32768
    return round(-1000.0 * speeds[0]), round(-1000.0 * speeds[1])
