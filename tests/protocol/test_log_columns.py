"""A whole log at once says what the stream decoder says, frame by frame and bit by bit."""

from __future__ import annotations

import math
import random

import pytest
from canonical_auv import SD as CANONICAL
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.checksum import sd_profile
from protocol.framing import Frame
from protocol.log_columns import SdColumns, decode_log
from protocol.messages import Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles.auv import FROM_STM32, SD, AuvCodec, shortcut


def frame(seed: int) -> bytes:
    rng = random.Random(seed)
    values = SD.decode(CANONICAL)
    widest = rng.choice([2500, 2500, 65535])
    numbers = [math.nan, math.inf, rng.uniform(-400, 400), rng.uniform(-60, 60)]
    weights = [1, 1, 4, 400]
    for name, value in values.items():
        if isinstance(value, float):
            values[name] = rng.choices(numbers, weights)[0]
        elif isinstance(value, int):
            values[name] = rng.randint(0, widest)
    return SD.pack(values)


PARTS = st.lists(
    st.one_of(
        st.integers(0, 30).map(frame),
        st.binary(max_size=20),
        st.just(b"@ACK_ZAY$"),
        st.builds(lambda s, n: frame(s)[:n] + b"@ACK_ZAY$" + frame(s)[n:], st.integers(0, 9), st.integers(1, 86)),
        st.builds(lambda s, n: frame(s)[:n], st.integers(0, 9), st.integers(1, 86)),
    ),
    max_size=12,
).map(b"".join)  # fmt: skip


def streamed(
    data: bytes, scale: tuple[float, float], tolerances: Tolerances | None = None
) -> list[Telemetry]:
    codec = AuvCodec("as-built", tolerances, scale)
    items = codec.receive(data, 0.0) + codec.flush(1e9)
    return [item for item in items if isinstance(item, Telemetry)]


def known(values: object, count: int) -> list[float]:
    if isinstance(values, tuple):
        return [math.nan if v is None else v for v in values]
    return [math.nan] * count if values is None else [float(str(values))]


def row(log: SdColumns, i: int) -> list[float]:
    single = [log.depth, log.altitude, log.heading, log.pitch, log.roll, log.temperature_c]
    lists = [log.magnetic[i], log.actuators[i], log.batteries[i]]
    return [float(c[i]) for c in single] + [float(v) for values in lists for v in values]


def expected(t: Telemetry) -> list[float]:
    single = [t.depth, t.altitude, t.heading, t.pitch, t.roll, t.temperature_c]
    values = [math.nan if v is None else v for v in single]
    return values + known(t.magnetic, 9) + known(t.actuators, 7) + known(t.batteries, 2)


@settings(max_examples=120, deadline=None)
@given(PARTS)
def test_columns_are_the_streams_telemetry_to_the_last_bit(data: bytes) -> None:
    scale = (0.1, 0.5)
    log = decode_log(data, battery_scale=scale)
    telemetry = streamed(data, scale)
    assert len(log) == len(telemetry)
    for i, message in enumerate(telemetry):
        assert list(map(repr, row(log, i))) == list(map(repr, expected(message)))
    assert log.offset.tolist() == sorted(log.offset.tolist())


@settings(max_examples=100, deadline=None)
@given(PARTS, st.integers(1, 200))
def test_the_shortcut_and_the_ordinary_way_yield_the_same(data: bytes, size: int) -> None:
    """Frames, faults, order and times of arrival, however the bytes were cut."""
    codec, plain = AuvCodec(), FROM_STM32.framer()
    quick: list[object] = []
    slow: list[object] = []
    for i in range(0, len(data), size):
        quick += codec.receive(data[i : i + size], i / 1000)
        slow += plain.receive(data[i : i + size], i / 1000)
    quick += codec.flush(1e9)
    slow += plain.flush(1e9)
    message = shortcut(Tolerances(), (1.0, 1.0)).message
    assert quick == [message(item) if isinstance(item, Frame) else item for item in slow]
    assert codec.framer.counters == plain.counters


def test_offsets_lead_back_to_the_frames() -> None:
    torn = CANONICAL[:7] + b"@ACK_ZAN$" + CANONICAL[7:]
    data = b"..." + frame(1) + b"@SD" + torn + frame(2) + b"@ACK_ZAY$" + bytes(100)
    assert decode_log(data).offset.tolist() == [3, 92, 187]


def test_of_frames_that_overlap_the_first_one_counts() -> None:
    """A frame can hold another one only if it was made to; both decoders agree all the same."""
    inner = bytearray(frame(3))
    outer = bytearray(b"@SD" + bytes(82) + b"$")
    outer[10:85] = inner[:75]
    profile = sd_profile("words/data")
    outer[81:85] = profile.compute(bytes(outer[3:81])).to_bytes(4, "little")
    inner[71:75], inner[75] = outer[81:85], outer[85]
    inner[81:85] = profile.compute(bytes(inner[3:81])).to_bytes(4, "little")
    data = bytes(outer) + bytes(inner[76:]) + frame(4)
    assert decode_log(data).offset.tolist() == [0, 96]
    assert len(streamed(data, (1.0, 1.0))) == 2


@pytest.mark.parametrize("data", [b"", b"@SD", bytes(85), bytes(1000), CANONICAL[:85]])
def test_a_log_without_a_frame_has_no_rows(data: bytes) -> None:
    log = decode_log(data)
    assert len(log) == 0
    assert log.magnetic.shape == (0, 9)


@pytest.mark.parametrize(
    "name", ["bytes/frame", "byte-a-word/data", "words-truncated/frame", "field-a-word/data"]
)
def test_any_crc_profile_is_known_to_the_columns(name: str) -> None:
    profile = sd_profile(name)
    data = b""
    for seed in range(4):
        raw = frame(seed)[:81]
        data += raw + profile.compute(raw[profile.first :]).to_bytes(4, "little") + b"$"
    tolerances = Tolerances.parse({"sd_crc": name})
    assert len(decode_log(data, tolerances)) == 4 == len(streamed(data, (1.0, 1.0), tolerances))
    assert len(decode_log(data)) == 0
