"""Channels beside the motion: where each stands in its frame, and what has to be at rest when."""

from __future__ import annotations

import math
from typing import Any

import pytest

from protocol.codec import CannotEncode, VehicleCodec
from protocol.framing import Frame
from protocol.messages import Order, SetOutput, Setpoint, Telemetry
from protocol.topside import TopsideCodec, encode
from protocol.vehicles import VEHICLES, VehicleRow, codec, link

DOWN = {
    "auv": "auv.to_stm32",
    "coreboard": "coreboard.pc_to_main",
    "rov": "rov.down",
    "robot": "robot.down",
    "mainboard": "coreboard.main_to_sensor",
}
EXAMPLES = {
    "auv": "auv.SD",
    "coreboard": "coreboard.MAIN_TO_PC",
    "mainboard": "coreboard.SENSOR_TO_MAIN",
}
ROWS = [row for row in VEHICLES.values() if row.channels]
CASES = [(row, channel) for row in ROWS for channel in row.channels]


def said(board: VehicleCodec, row: VehicleRow, channel: str, level: float) -> list[dict[str, Any]]:
    """What every frame says that leaves then, with neutral."""
    own = list(board.take_outputs({channel: level}).values())
    frames = [*own, *board.encode(Setpoint())]
    if row.name == "mainboard":  # force and torque go to the bus
        frames = frames[-1:]
    framer = link(DOWN[row.name]).framer()
    read = [item for raw in frames for item in framer.receive(raw, 0.0)]
    assert all(isinstance(item, Frame) for item in read), read
    return [dict(item.values()) for item in read if isinstance(item, Frame)]


@pytest.mark.parametrize(("row", "channel"), CASES, ids=lambda v: getattr(v, "name", ""))
@pytest.mark.parametrize("end", ["low", "high"])
def test_every_channel_is_carried_from_end_to_end_and_read_back(row, channel, end: str) -> None:
    level = getattr(channel, end)
    wide = codec(row.name, row.dialects[0], {})
    if channel.name == "side_speed_mm_s":
        wide.take_outputs({"side": 7})  # without a motion there is no speed
    other = channel.low if end == "high" else channel.high
    before, after = said(wide, row, channel.name, other), said(wide, row, channel.name, level)
    assert before != after


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_nobody_who_sets_nothing_changes_a_byte(row: VehicleRow) -> None:
    one, two = (codec(row.name, row.dialects[0], {}) for _ in range(2))
    told = {name: level for name, level in two.levels.items() if not math.isnan(level)}
    two.take_outputs(told)
    for wanted in (Order.STOP, Order.SURFACE, Setpoint(surge=0.5)):
        assert one.encode(wanted) == two.encode(wanted)


@pytest.mark.parametrize(
    ("name", "channel", "wanted"),
    [
        ("rov", "hold_depth", Setpoint(heave=0.5)),
        ("rov", "hold_depth", Order.SURFACE),
        ("rov", "hold_heading", Setpoint(turn=0.5)),
        ("rov", "hold_heading", Order.STOP),
        ("robot", "side", Setpoint(surge=0.5)),
        ("robot", "side", Order.STOP),
    ],
)
def test_what_fights_a_motion_or_an_order_is_at_rest_in_its_frames(
    name: str, channel: str, wanted: Setpoint | Order
) -> None:
    still, set_ = codec(name, "documented", {}), codec(name, "documented", {})
    set_.take_outputs({channel: 7 if channel == "side" else 1})
    assert set_.encode(wanted) == still.encode(wanted)
    assert set_.encode(Setpoint()) != still.encode(Setpoint())


def test_power_is_said_as_a_whole_and_what_was_switched_before_stays() -> None:
    board = codec("auv", "as-built", {})
    assert board.take_outputs({"power_light": 0}) == {"power": b"@RSOOOOOOC$"}
    assert board.take_outputs({"power_magnetometer": 0}) == {"power": b"@RSOOOOOCC$"}
    assert board.take_outputs({"rudder_left_deg": -15}) == {"rudder_left_deg": b"@DS1,-15$"}


def test_a_report_is_read_by_the_names_of_its_sources() -> None:
    for row in ROWS:
        raw = frame_of(EXAMPLES.get(row.name, f"{row.name}.UP"))
        (report,) = [
            item
            for item in codec(row.name, row.dialects[0], {}).receive(raw, 0.0)
            if isinstance(item, Telemetry)
        ]
        known = {source.name: source.read(report) for source in row.sources}
        assert all(isinstance(value, float | int) for value in known.values()), known


def frame_of(name: str) -> bytes:
    from protocol.examples import examples

    return next(example.raw for example in examples() if example.type == name)


def test_a_field_that_is_doubtful_is_no_reading() -> None:
    row = next(row for row in VEHICLES.values() if row.name == "rov")
    raw = bytearray(frame_of("rov.UP"))
    raw[67] = 200  # metal, beyond 100 %
    raw[68] = sum(raw[4:68]) % 256
    (report,) = codec("rov", "documented", {}).receive(bytes(raw), 0.0)
    assert isinstance(report, Telemetry)
    assert {s.name: s.read(report) for s in row.sources}["metal_pct"] is None


def test_the_word_for_an_output_comes_back_as_it_was() -> None:
    for word in (SetOutput("lamp", 40), SetOutput("tilt", -12.5)):
        assert TopsideCodec().receive(encode(word), 0.0) == [word]
    assert encode(SetOutput("lamp", 40)) == b"@AO,lamp,40,$"


@pytest.mark.parametrize(
    ("raw", "kind"),
    [
        (b"@AO,lamp,$", "field_count"),
        (b"@AO,,4,$", "empty_field"),
        (b"@AO,4lamp,4,$", "bad_enum"),
        (b"@AO,lamp,x,$", "non_numeric"),
        (b"@AO,lamp,,$", "empty_field"),
    ],
)
def test_a_word_that_is_none_is_refused_with_its_kind(raw: bytes, kind: str) -> None:
    codec_ = TopsideCodec()
    found = [*codec_.receive(raw, 0.0), *codec_.flush(1.0)]
    assert len(found) == 1
    fault = found[0]
    assert getattr(fault, "kind", None) == kind


def test_a_name_that_no_frame_can_carry_is_refused() -> None:
    with pytest.raises(CannotEncode):
        encode(SetOutput("la,mp", 1))
