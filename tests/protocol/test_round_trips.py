"""Every type: values -> bytes -> values, and every single wrong byte of a checksummed frame."""

from __future__ import annotations

import math
import random
import struct
from datetime import UTC, datetime

import pytest
from canonical_auv import AUV, SD
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.fields import BinaryFrame, Check, FrameType, Number, Raw, Values
from protocol.framing import Frame
from protocol.state_frame import COMMANDERS, NUMBERS, STATES
from protocol.text import Digit, Int, Letters, TextFrame
from protocol.topside_frames import MOST_LINES
from protocol.vehicles import frame_types, link

TYPES = frame_types()
TABLED = sorted(
    name
    for name, frame in TYPES.items()
    if type(frame) is BinaryFrame or (type(frame) is TextFrame and frame.items)
)
BARE = ("auv.NI", "auv.AA", "auv.AC", "auv.AQ", "auv.AE", "auv.DU", "auv.RI")


def numbers(item: Number) -> st.SearchStrategy[float]:
    if item.choices:
        return st.sampled_from(item.choices)
    if item.floating:
        low, high = item.low, item.high
        width = 32 if item.code == "f" else 64
        bound = 1e6 if low is None or high is None else None
        return st.floats(
            -bound if low is None and bound else low,
            bound if high is None else high,
            width=width,
        )
    size = struct.calcsize(item.code) * 8
    signed = item.code.islower()
    least, most = (-(2 ** (size - 1)), 2 ** (size - 1) - 1) if signed else (0, 2**size - 1)
    if item.low is not None:
        least = max(least, math.ceil((item.low + item.bias) * item.scale))
    if item.high is not None:
        most = min(most, math.floor((item.high + item.bias) * item.scale))
    return st.integers(least, most).map(item.value)


def values_of(frame: FrameType) -> st.SearchStrategy[Values]:
    fields: dict[str, st.SearchStrategy[object]] = {}
    for item in frame.fields if isinstance(frame, BinaryFrame) else getattr(frame, "items", ()):
        match item:
            case Number(name=name):
                fields[name] = numbers(item)
            case Raw(name=name, size=size):
                fields[name] = st.binary(min_size=size, max_size=size).map(bytes.hex)
            case Letters(name=name, size=size, choices=choices):
                fields[name] = st.text(choices, min_size=size, max_size=size)
            case Digit(name=name, choices=choices):
                fields[name] = st.sampled_from([int(c) for c in choices])
            case Int(name=name, low=low, high=high):
                fields[name] = st.integers(low, high)
    return st.fixed_dictionaries(fields)


def same(a: object, b: object) -> bool:
    return a == b or (isinstance(a, float) and isinstance(b, float) and math.isclose(a, b))


@pytest.mark.parametrize("name", TABLED)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_a_table_encodes_and_decodes_the_same_values(name: str, data: st.DataObject) -> None:
    frame = TYPES[name]
    values = data.draw(values_of(frame))
    if name in ("auv.MD", "auv.D") and values["mode"] == "S":
        values["angle"] = max(-15, min(22, values["angle"]))
    raw = frame.encode(values)
    assert frame.check(raw) is None
    assert frame.measure(raw, 0, len(raw)) == len(raw)
    decoded = frame.decode(raw)
    assert all(same(decoded[key], value) for key, value in values.items())
    assert frame.encode(decoded) == raw


PAYLOAD = st.text(
    st.sampled_from([chr(c) for c in range(32, 127) if chr(c) not in "@$"]),
    min_size=1,
    max_size=200,
)
DECIMAL = st.decimals(0, 65535, places=3).map(float).filter(bool)
MISSING = st.sampled_from(["", "3", "3-5", "3-5.9", "1.3.5-7"])
CLOCK = st.integers(0, 4_102_444_799).map(  # s since 1970; R10: to the end of 2099
    lambda t: datetime.fromtimestamp(t, UTC).strftime("%Y-%m-%dT%H:%M:%S")
)
STATUS_NUMBERS = {
    "lon_deg": st.decimals(-180, 180, places=7),
    "lat_deg": st.decimals(-90, 90, places=7),
    "ground_speed": st.decimals(0, 500, places=2),
    "ground_course_deg": st.decimals(0, 360, places=1),
    "heading_deg": st.decimals(-180, 180, places=2),
    "pitch_deg": st.decimals(-180, 180, places=2),
    "roll_deg": st.decimals(-90, 90, places=2),
}


@st.composite
def mission_lines(draw: st.DrawFn) -> Values:
    total = draw(st.integers(1, MOST_LINES))
    current = draw(st.integers(1, total))
    return {"total": total, "current": current, "payload": draw(PAYLOAD)}


@st.composite
def statuses(draw: st.DrawFn) -> Values:
    from protocol.status_frame import NAMES

    values: Values = {"time": draw(st.none() | CLOCK)}
    for name in NAMES[1:]:
        number = STATUS_NUMBERS.get(name, st.integers(0, 2000)).map(float)
        values[name] = draw(st.none() | number)
    return values


@st.composite
def motions(draw: st.DrawFn) -> Values:
    code = draw(st.sampled_from("FBLRUDSEHAVXW"))
    number = {"S": "depth_m", "E": "altitude_m", "V": "speed_mps"}.get(code, "gear")
    match code:
        case "X" | "W":
            return {"code": code}
        case "A":
            pitch, roll = draw(st.integers(-180, 180)), draw(st.integers(-90, 90))
            return {"code": code, "pitch_deg": pitch, "roll_deg": roll}
        case "H":
            return {"code": code, "heading_deg": draw(st.integers(-180, 180))}
        case _:
            return {"code": code, number: draw(st.integers(0, 12 if number == "gear" else 9999))}


STORES = st.fixed_dictionaries(
    {
        "state": st.sampled_from(["empty", "staging", "ready", "running"]),
        "total": st.integers(5, MOST_LINES),
        "have": st.integers(0, 5),
        "missing": MISSING,
        "digest": st.sampled_from(["", "0123456789abcdef"]),
        "refusal": PAYLOAD.filter(lambda t: "," not in t) | st.just(""),
    }
)
STATE_REPORTS = st.fixed_dictionaries(
    {
        "state": st.sampled_from(sorted(STATES.values())),
        "commander": st.sampled_from(sorted(COMMANDERS.values())),
        **{n.name: st.none() | st.integers(int(n.low), int(n.high)) for n in NUMBERS},
        "alarms": st.integers(0, 0xFFFF),
        "setpoint": st.just(""),
        "leg": st.just(""),
    }
)
BY_HAND = {
    "auv.AW": mission_lines(),
    "auv.AO": st.fixed_dictionaries(
        {"name": st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,23}", fullmatch=True), "value": DECIMAL}
    ),
    "auv.ST": st.fixed_dictionaries({"time": CLOCK}),
    "auv.SP": st.fixed_dictionaries(
        {n: st.none() | DECIMAL for n in ("radius_m", "minutes", "depth_m", "low_voltage_v")}
    ),
    "auv.VS": statuses(),
    "auv.ZA": motions(),
    "auv.AR": STORES,
    "auv.AES": STATE_REPORTS,
    "auv.ACK": st.sampled_from(
        [
            *({"class": a, "func": b, "ok": ok} for a, b in ("NS", "AA", "AC", "AW", "AO", "ST", "SP") for ok in (True, False)),
            *({"class": "Z", "func": code, "ok": ok} for code in "FBLRUDSEHAVXW" for ok in (True, False)),
            *({"class": c, "func": "I", "mask": m} for c in "NR" for m in range(256)),
            {"class": "R", "func": "S", "ok": True},
        ]
    ),
    "auv.MODEM": st.builds(
        lambda address, content: {"address": address, "content": content.hex()},
        st.sampled_from([1, 2]),
        st.binary(min_size=1, max_size=3200),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(BY_HAND))
@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_what_is_encoded_comes_through_its_link(name: str, data: st.DataObject) -> None:
    values = data.draw(BY_HAND[name])
    raw = TYPES[name].encode(values)
    (frame,) = link("auv.any").framer().receive(raw, 0.0)
    assert isinstance(frame, Frame)
    decoded = frame.values()
    assert frame.type.name == name
    assert all(same(decoded[key], value) for key, value in values.items())


def test_every_type_has_a_round_trip() -> None:
    tried = {*TABLED, *BY_HAND, *BARE}
    untabled = {n for n in TYPES if n not in tried and n.startswith("auv.")}
    assert untabled == set()


# --- corruption ---


def checksummed() -> list[tuple[str, bytes]]:
    rng = random.Random(5)
    frames = [("auv.SD", SD)]
    values = TYPES["auv.SD"].decode(SD)
    values |= {k: rng.uniform(-90, 90) for k, v in values.items() if isinstance(v, float)}
    frames.append(("auv.SD", TYPES["auv.SD"].encode(values)))
    return frames + [(name, raw) for name, _, raw in AUV if name == "auv.MODEM"]


@pytest.mark.proof
@pytest.mark.parametrize(("name", "raw"), checksummed(), ids=["SD", "SD random", "deck", "vehicle"])
def test_every_single_wrong_byte_of_a_checksummed_frame_is_refused(name: str, raw: bytes) -> None:
    row = link("auv.modem" if name == "auv.MODEM" else "auv.from_stm32")
    for at in range(len(raw)):
        for wrong in range(1, 256):
            broken = bytearray(raw)
            broken[at] ^= wrong
            framer = row.framer()
            items = framer.receive(bytes(broken), 0.0) + framer.flush(1e9)
            assert not any(isinstance(item, Frame) for item in items), (at, wrong)


def test_every_binary_table_adds_up_to_its_checksum_and_ends() -> None:
    for frame in TYPES.values():
        if isinstance(frame, BinaryFrame):
            sizes = list(frame.offsets)
            assert sizes == sorted(sizes)
            for field, at in zip(frame.fields, frame.offsets, strict=True):
                if isinstance(field, Check):
                    assert field.first < at < frame.length
