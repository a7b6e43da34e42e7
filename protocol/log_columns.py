"""A whole recording of the STM32's line at once: every good ``@SD`` as one row of columns.

    candidates   where "@SD" stands and "$" 85 bytes later
    check        every CRC of docs/protocol.md is affine in the bytes of a frame of fixed length:
                 crc(frame) = crc(empty frame) xor T0[byte 3] xor T1[byte 4] ...
    torn frames  what lies between the good ones goes through the framer, if an @ACK_ is in it

The frames are those that ``protocol.framing`` accepts, the values those of ``AuvCodec``; a value
that Telemetry has as None is NaN here. numpy is imported when it is needed, not before.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from protocol.checksum import sd_profile
from protocol.framing import Frame
from protocol.tolerances import Tolerances
from protocol.vehicles import auv

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_LENGTH = auv.SD.length
_FIRST, _DATA = 3, 78
_BLOCK = 2048  # frames: what the checks of one block touch stays in the cache
_SHORTEST_TORN = _LENGTH + 9


@dataclass(frozen=True, slots=True, eq=False)
class SdColumns:
    """n rows in the order of their offsets; SI, named as in Telemetry."""

    offset: NDArray[np.int64]  # of the first byte in the recording
    depth: Floats
    altitude: Floats
    heading: Floats
    pitch: Floats
    roll: Floats
    temperature_c: Floats
    magnetic: Floats  # n x 9
    actuators: Floats  # n x 7
    batteries: Floats  # n x 2

    def __len__(self) -> int:
        return len(self.offset)


def decode_log(
    data: bytes,
    tolerances: Tolerances | None = None,
    battery_scale: auv.BatteryScale = (1.0, 1.0),
) -> SdColumns:
    """Every ``@SD`` of a recording; all other bytes are passed over."""
    import numpy as np

    chosen = tolerances or Tolerances()
    offsets, frames = _good(np.frombuffer(data, np.uint8), chosen["sd_crc"])
    torn = _torn(data, offsets, chosen)
    if torn:
        more = np.frombuffer(b"".join(frame.raw for frame in torn), np.uint8)
        frames = np.concatenate((frames, more.reshape(-1, _LENGTH)))
        offsets = np.concatenate((offsets, np.array([f.offset for f in torn], np.int64)))
        order = np.argsort(offsets)
        offsets, frames = offsets[order], frames[order]
    return _columns(offsets, frames, battery_scale)


def _good(raw: NDArray[np.uint8], profile: str) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
    """Offsets and bytes (n x 86) of the frames that stand there whole."""
    import numpy as np

    if len(raw) < _LENGTH:
        return np.empty(0, np.int64), np.empty((0, _LENGTH), np.uint8)
    stop = len(raw) - _LENGTH + 1
    at = np.flatnonzero(raw[:stop] == ord("@"))
    at = at[(raw[at + 1] == ord("S")) & (raw[at + 2] == ord("D")) & (raw[at + 85] == ord("$"))]
    windows = np.lib.stride_tricks.sliding_window_view(raw, _LENGTH)
    right = [
        block[_right(windows[block], profile)]
        for block in (at[i : i + _BLOCK] for i in range(0, len(at), _BLOCK))
    ]
    offsets = _apart(np.concatenate(right)) if right else at
    return offsets, windows[offsets]


def _right(frames: NDArray[np.uint8], profile: str) -> NDArray[np.bool_]:
    import numpy as np

    base, tables = _affine(profile)
    computed = np.full(len(frames), base, np.uint32)
    columns = np.ascontiguousarray(frames[:, _FIRST : _FIRST + _DATA].T)
    for table, column in zip(tables, columns, strict=True):
        computed ^= table[column]
    stored = np.ascontiguousarray(frames[:, 81:85]).view("<u4")[:, 0]
    right: NDArray[np.bool_] = computed == stored
    return right


@cache
def _affine(profile: str) -> tuple[int, NDArray[np.uint32]]:
    """The CRC of a frame of zeros, and what each value of each byte adds to it (78 x 256)."""
    import numpy as np

    row = sd_profile(profile)

    def crc(data: bytes) -> int:
        return row.compute((b"@SD" + data)[row.first :])

    base = crc(bytes(_DATA))
    tables = np.zeros((_DATA, 256), np.uint32)
    for position, bit in itertools.product(range(_DATA), range(8)):
        single = bytes(position) + bytes([1 << bit]) + bytes(_DATA - 1 - position)
        tables[position, np.arange(256) >> bit & 1 == 1] ^= np.uint32(crc(single) ^ base)
    return base, tables


def _apart(offsets: NDArray[np.int64]) -> NDArray[np.int64]:
    """Of frames that overlap the first one counts, as in the framer."""
    import numpy as np

    if len(offsets) < 2 or int(np.diff(offsets).min()) >= _LENGTH:
        return offsets
    kept: list[int] = []
    for offset in offsets.tolist():
        if not kept or offset >= kept[-1] + _LENGTH:
            kept.append(offset)
    return np.array(kept, np.int64)


def _torn(data: bytes, offsets: NDArray[np.int64], tolerances: Tolerances) -> list[Frame]:
    """Frames with an acknowledgement inside, from what lies between the good ones."""
    import numpy as np

    starts = np.concatenate((np.zeros(1, np.int64), offsets + _LENGTH))
    stops = np.concatenate((offsets, np.array([len(data)], np.int64)))
    wide = stops - starts >= _SHORTEST_TORN
    found: list[Frame] = []
    for start, stop in zip(starts[wide].tolist(), stops[wide].tolist(), strict=True):
        if data.find(b"@ACK_", start, stop) < 0:
            continue
        framer = auv.FROM_STM32.framer(tolerances)
        items = framer.receive(data[start:stop], 0.0) + framer.flush(float("inf"))
        found += [
            item._replace(offset=item.offset + start)
            for item in items
            if isinstance(item, Frame) and item.type.name == auv.SD.name
        ]
    return found


def _columns(
    offsets: NDArray[np.int64], frames: NDArray[np.uint8], battery_scale: auv.BatteryScale
) -> SdColumns:
    import numpy as np

    floats = np.ascontiguousarray(frames[:, 3:63]).view("<f4").astype(np.float64)
    words = np.ascontiguousarray(frames[:, 63:81]).view("<u2").astype(np.float64)
    floats[~np.isfinite(floats)] = np.nan
    degree = np.pi / 180
    magnetic = floats[:, 6:] * 1e-6
    magnetic[np.isnan(magnetic).any(axis=1)] = np.nan
    return SdColumns(
        offset=offsets,
        depth=floats[:, 4],
        altitude=floats[:, 5],
        heading=-(floats[:, 2] * degree) % (2 * np.pi),
        pitch=floats[:, 1] * degree,
        roll=floats[:, 0] * degree,
        temperature_c=floats[:, 3],
        magnetic=magnetic,
        actuators=(words[:, :7] - 1500) / 500,
        batteries=words[:, 7:] * np.array(battery_scale),
    )
