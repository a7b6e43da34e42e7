"""The wire against pymavlink and against its own limit, all in one run: use the ratios.

    limit       struct.unpack of frames that are known to be good: nothing found, nothing checked
    stream      bytes with garbage between -> framed, CRC-checked, Telemetry in SI
    log         the same bytes at once -> columns
    pymavlink   its own messages of that size, from the same chunks: alone, and with as much garbage

Each figure is the best of several rounds, and the contenders take turns within a round.
"""

from __future__ import annotations

import importlib.util
import io
import random
import struct
import sys
import time
from collections.abc import Callable

from protocol.log_columns import decode_log
from protocol.messages import Telemetry
from protocol.vehicles.auv import ACTUATORS, MAGNETOMETERS, SD, AuvCodec

FRAMES, CHUNK, ROUNDS = 5_000, 4096, 15
GARBAGE = 0.10  # of the frames' bytes


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


def stream(pieces: list[bytes]) -> int:
    codec = AuvCodec()
    return sum(type(item) is Telemetry for piece in pieces for item in codec.receive(piece, 0.0))


def unpack(messages: list[bytes]) -> int:
    bare = struct.Struct("<3x15f9HIc").unpack
    for message in messages:
        bare(message)
    return len(messages)


def mavlink() -> tuple[list[bytes], Callable[[list[bytes]], int]]:
    """Messages of 84 bytes (the nearest to 86), and pymavlink's parser."""
    from pymavlink.dialects.v20 import common

    rng, packer = random.Random(2), common.MAVLink(io.BytesIO())

    def numbers(count: int) -> list[float]:
        return [rng.uniform(-50, 50) for _ in range(count)]

    made = [
        common.MAVLink_attitude_quaternion_cov_message(
            rng.randrange(1 << 40), numbers(4), *numbers(3), numbers(9)
        ).pack(packer)
        for _ in range(FRAMES)
    ]

    def parse(pieces: list[bytes]) -> int:
        parser = common.MAVLink(io.BytesIO())
        parser.robust_parsing = True
        return sum(
            message.get_type() != "BAD_DATA"
            for piece in pieces
            for message in parser.parse_buffer(piece) or ()
        )

    return made, parse


def measure() -> tuple[dict[str, float], dict[str, int]]:
    """Microseconds per frame sent, and how many of them were found."""
    rng = random.Random(1)
    sd = frames(rng)
    dirty = with_garbage(sd, rng)
    pieces, clean_pieces = chunks(dirty), chunks(b"".join(sd))
    contenders: dict[str, Callable[[], int]] = {
        "limit": lambda: unpack(sd),
        "stream": lambda: stream(pieces),
        "stream, no garbage": lambda: stream(clean_pieces),
        "log": lambda: len(decode_log(dirty)),
    }
    if importlib.util.find_spec("pymavlink"):
        messages, parse = mavlink()
        clean_mav, dirty_mav = chunks(b"".join(messages)), chunks(with_garbage(messages, rng))
        contenders["pymavlink"] = lambda: parse(clean_mav)
        contenders["pymavlink, garbage"] = lambda: parse(dirty_mav)
    best, found = dict.fromkeys(contenders, float("inf")), dict.fromkeys(contenders, 0)
    for _ in range(ROUNDS):
        for name, work in contenders.items():
            start = time.perf_counter()
            found[name] = work()
            best[name] = min(best[name], time.perf_counter() - start)
    return {name: seconds / FRAMES * 1e6 for name, seconds in best.items()}, found


def main() -> dict[str, float]:
    say = sys.stdout.write
    figures, found = measure()
    say(f"{FRAMES} frames of 86 bytes, chunks of {CHUNK}, {GARBAGE:.0%} garbage\n")
    for name, figure in figures.items():
        lost = f", {FRAMES - found[name]} frames not found" if found[name] < FRAMES else ""
        say(f"  {name:<22} {figure:7.2f} us a frame{lost}\n")
    say(f"  stream costs {figures['stream'] / figures['limit']:.1f} times the limit\n")
    ratios: dict[str, float] = {}
    if "pymavlink" not in figures:
        say("  pymavlink is skipped: it comes with the extra [bench]\n")
        return ratios
    for ours in ("stream", "log"):
        for theirs in ("pymavlink, garbage", "pymavlink"):
            ratio = figures[theirs] / figures[ours]
            say(f"  {ours} is {ratio:.1f} times as fast as {theirs}\n")
        ratios[f"{ours}_ratio"] = figures["pymavlink"] / figures[ours]
    return ratios


if __name__ == "__main__":
    main()
