"""The wire against pymavlink and against its own limit, all in one run: use the ratios.

    limit       struct.unpack of frames that are known to be good: nothing found, nothing checked
    stream      bytes with garbage between -> framed, CRC-checked, Telemetry in SI
    pymavlink   its own messages of that size

What is fair. An ``@SD`` has 86 bytes and 24 numbers, none in arrays, so the others are every
message of MAVLink's ``common`` set that has 75 to 86 bytes on the wire and no array: HIGHRES_IMU,
HIL_SENSOR, GPS_INPUT, EFI_STATUS (16 to 19 numbers, so they have less to do). pymavlink is as pip
installs it, with the compiled checksum of fastcrc (without it, it is three times slower or worse);
MAVLink 2, unsigned. It is read in two ways:

    parser      ``MAVLink.parse_buffer`` with the same chunks: the quickest way there is
    mavutil     ``recv_msg`` of a connection, which is how programs read it

Both get as much garbage as ours, and the figure for them is per message sent; where garbage looks
like a header they lose good messages, which is not charged. Ratios are to the geometric mean.
Time is that of this thread; each figure is the best of many short rounds, and the contenders take
turns within a round.
"""

from __future__ import annotations

import importlib.util
import io
import math
import os
import random
import struct
import sys
import time
from collections.abc import Callable
from typing import Any

from protocol.messages import Telemetry
from protocol.vehicles.auv import ACTUATORS, MAGNETOMETERS, SD, AuvCodec

FRAMES, MESSAGES, CHUNK, ROUNDS = 1_000, 500, 4096, 40
GARBAGE = 0.10  # of the frames' bytes
SIZES = range(75, 87)

Work = Callable[[], int]


def frames(rng: random.Random) -> list[bytes]:
    """A vehicle under way: everything changes from frame to frame."""
    made = []
    for _ in range(FRAMES):
        values: dict[str, float] = {
            "roll_deg": rng.gauss(0, 5),
            "pitch_deg": rng.gauss(0, 5),
            "yaw_deg": rng.uniform(-180, 180),
            "temperature_c": rng.gauss(15, 1),
            "depth_m": rng.uniform(0, 50),
            "altitude_m": rng.uniform(0, 50),
        }
        values |= {name: rng.uniform(-50, 50) for name in MAGNETOMETERS}
        values |= {f"pwm_{name}": rng.randrange(1000, 2001) for name in ACTUATORS}
        made.append(SD.encode(values | {"battery_control": 12, "battery_power": 48}))
    return made


def with_garbage(messages: list[bytes], rng: random.Random) -> bytes:
    most = round(2 * GARBAGE * len(messages[0]))
    return b"".join(m + rng.randbytes(rng.randint(0, most)) for m in messages)


def chunks(data: bytes) -> list[bytes]:
    return [data[i : i + CHUNK] for i in range(0, len(data), CHUNK)]


def stream(codec: AuvCodec, pieces: list[bytes]) -> int:
    return sum(type(item) is Telemetry for piece in pieces for item in codec.receive(piece, 0.0))


def unpack(messages: list[bytes]) -> int:
    bare = struct.Struct("<3x15f9HIc").unpack
    for message in messages:
        bare(message)
    return len(messages)


# --- pymavlink ---


def mavlink_messages() -> dict[str, list[bytes]]:
    """By name, what is as long as an ``@SD`` and has no array."""
    from pymavlink.dialects.v20 import common

    rng, packer = random.Random(2), common.MAVLink(io.BytesIO())
    made: dict[str, list[bytes]] = {}
    for kind in common.mavlink_map.values():
        size = 12 + kind.unpacker.size
        if size not in SIZES or any(kind.array_lengths):
            continue

        def number(field_type: str) -> float:
            whole = field_type not in ("float", "double")
            return rng.randrange(1, 100) if whole else rng.uniform(-50, 50)

        made[kind.msgname] = [
            kind(*map(number, kind.fieldtypes)).pack(packer) for _ in range(MESSAGES)
        ]
    return made


def parser(pieces: list[bytes]) -> int:
    from pymavlink.dialects.v20 import common

    link = common.MAVLink(io.BytesIO())
    link.robust_parsing = True
    return sum(
        message.get_type() != "BAD_DATA"
        for piece in pieces
        for message in link.parse_buffer(piece) or ()
    )


def mavutil_connection(data: bytes) -> int:
    """As from a serial port or a socket that always has the bytes which are asked for."""
    from pymavlink import mavutil

    class Memory(mavutil.mavfile):  # type: ignore[misc]
        def recv(self, n: int | None = None) -> bytes:
            return wire.read(self.mav.bytes_needed() if n is None else n)

    wire, found = io.BytesIO(data), 0
    link: Any = Memory(None, "memory")
    link.robust_parsing = True
    while True:
        message = link.recv_msg()
        found += message is not None and message.get_type() != "BAD_DATA"
        if message is None and wire.tell() >= len(data):
            return found


def mavlink_contenders() -> dict[str, tuple[int, Work]]:
    os.environ.setdefault("MAVLINK20", "1")  # what mavutil speaks
    contenders: dict[str, tuple[int, Work]] = {}
    for name, messages in mavlink_messages().items():
        clean, dirty = b"".join(messages), with_garbage(messages, random.Random(1))
        pieces, clean_pieces = chunks(dirty), chunks(clean)
        contenders |= {
            f"parser {name}": (MESSAGES, lambda p=pieces: parser(p)),
            f"parser, no garbage {name}": (MESSAGES, lambda p=clean_pieces: parser(p)),
            f"mavutil {name}": (MESSAGES, lambda d=dirty: mavutil_connection(d)),
        }
    return contenders


# --- all together ---


def measure() -> tuple[dict[str, float], dict[str, int]]:
    """Microseconds per frame sent, and how many of a hundred were found."""
    rng = random.Random(1)
    sd = frames(rng)
    pieces, clean_pieces = chunks(with_garbage(sd, rng)), chunks(b"".join(sd))
    codec, clean_codec = AuvCodec(), AuvCodec()
    contenders: dict[str, tuple[int, Work]] = {
        "limit": (FRAMES, lambda: unpack(sd)),
        "stream": (FRAMES, lambda: stream(codec, pieces)),
        "stream, no garbage": (FRAMES, lambda: stream(clean_codec, clean_pieces)),
    }
    if importlib.util.find_spec("pymavlink"):
        contenders |= mavlink_contenders()
    best, found = dict.fromkeys(contenders, math.inf), dict.fromkeys(contenders, 0)
    for _ in range(ROUNDS):
        for name, (count, work) in contenders.items():
            start = time.thread_time()
            got = work()
            best[name] = min(best[name], (time.thread_time() - start) / count * 1e6)
            found[name] = round(100 * got / count)
    return best, found


def mean_of(figures: dict[str, float], way: str) -> float:
    """Geometric, over the messages."""
    logs = [math.log(v) for name, v in figures.items() if name.startswith(f"{way} ")]
    return math.exp(sum(logs) / len(logs))


def main() -> dict[str, float]:
    say = sys.stdout.write
    figures, found = measure()
    say(f"{FRAMES} frames of 86 bytes, chunks of {CHUNK}, {GARBAGE:.0%} garbage\n")
    for name, figure in figures.items():
        lost = f", {100 - found[name]} % not found" if found[name] < 100 else ""
        say(f"  {name:<32} {figure:7.2f} us a frame{lost}\n")
    say(f"  stream costs {figures['stream'] / figures['limit']:.1f} times the limit\n")
    if not any(name.startswith("parser") for name in figures):
        say("  pymavlink is skipped: it comes with the extra [bench]\n")
        return {}
    ways = {way: mean_of(figures, way) for way in ("parser", "parser, no garbage", "mavutil")}
    for ours in ("stream", "stream, no garbage"):
        for way, theirs in ways.items():
            say(f"  {ours} is {theirs / figures[ours]:.1f} times as fast as {way}\n")
    return {
        "stream_ratio": ways["parser"] / figures["stream"],
        "stream_mavutil_ratio": ways["mavutil"] / figures["stream"],
    }


if __name__ == "__main__":
    main()
