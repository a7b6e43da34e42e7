"""Messages between topside and the Pi: every command and every answer, both ways."""

from __future__ import annotations

import math
from typing import Any

import pytest
from canonical_auv import VS

from protocol.codec import CannotEncode
from protocol.framing import Frame
from protocol.messages import (
    Ack,
    ClearMission,
    DataQuery,
    Emergency,
    Fix,
    FrameFault,
    Manual,
    MissionLine,
    NodeQuery,
    NodeSwitch,
    Order,
    Relay,
    SetSafety,
    SetTime,
    StartMission,
    StateQuery,
    StateReport,
    Status,
    StoreQuery,
    StoreReport,
    Telemetry,
)
from protocol.topside import ConsoleCodec, TopsideCodec, answer, encode, encode_ack, status_values
from protocol.vehicles import link

COMMANDS = [
    (NodeSwitch("OOCCOO"), b"@NSOOCCOO$"),
    (NodeQuery(), b"@NI$"),
    (StartMission(), b"@AA$"),
    (ClearMission(), b"@AC$"),
    (StoreQuery(), b"@AQ$"),
    (StateQuery(), b"@AE$"),
    (MissionLine(3, 2, "ZAF5 until depth > 3"), b"@AW\x03\x00\x02\x00ZAF5 until depth > 3$"),
    (SetTime("2025-01-11T16:56:06"), b"@ST,2025/01/11 16:56:06,$"),
    (SetSafety(1000, 300.0, 200, 10), b"@SP,1000,5,200,10,$"),
    (SetSafety(None, 90.0, None, 10.5), b"@SP,,1.5,,10.5,$"),
    (DataQuery(), b"@DU$"),
    (Relay("RS", b"@RSCOOCCCO$"), b"@RSCOOCCCO$"),
    (Relay("RI", b"@RI$"), b"@RI$"),
    (Relay("D", b"@DS3,20$"), b"@DS3,20$"),
    (Manual("MT", b"@MT1,-10$"), b"@MT1,-10$"),
    (Manual("MD", b"@MDA2,-2$"), b"@MDA2,-2$"),
    (Manual("MM", b"@MMF10$"), b"@MMF10$"),
    (Manual("MR", b"@MRL5$"), b"@MRL5$"),
    (Manual("MS", b"@MS120,-90$"), b"@MS120,-90$"),
    (Manual("MP", b"@MP120,-90$"), b"@MP120,-90$"),
    (Emergency(Order.STOP), b"@ZAX0$"),
    (Emergency(Order.SURFACE), b"@ZAWF$"),
]
ANSWERS = [
    (Ack(1.0, "N", "S", ord("S")), b"@ACK_NSS$"),
    (Ack(1.0, "N", "I", 0x24), b"@ACK_NI$$"),
    (Ack(1.0, "A", "W", ord("N")), b"@ACK_AWN$"),
    (Ack(1.0, "R", "S", ord("S")), b"@ACK_RSS$"),
    (StoreReport("staging", 9, 5, "3-5.9", "0123456789abcdef", ""),
     b"@AR,staging,9,5,3-5.9,0123456789abcdef,,$"),
    (StateReport("autonomous", "asker", 1, 423, 38, -120, 45, 7, 860, 31, 1.9, 0, "F50%H90S3", "row"),
     b"@AE,1,AU,Y,1,423,38,-120,45,7,860,31,1.9,0,F50%H90S3,row,$"),
    (StoreReport("empty", 0, 0, "", "", "no bound"), b"@AR,empty,0,0,,,no bound,$"),
]  # fmt: skip


@pytest.mark.parametrize(("command", "raw"), COMMANDS)
def test_a_command_is_encoded_and_understood(command: Any, raw: bytes) -> None:
    assert encode(command) == raw
    assert TopsideCodec().receive(raw, 1.0) == [command]


@pytest.mark.parametrize(("message", "raw"), ANSWERS)
def test_an_answer_is_encoded_and_understood(message: Any, raw: bytes) -> None:
    assert encode(message) == raw
    assert ConsoleCodec().receive(raw, 1.0) == [message]


def test_several_commands_in_one_packet_come_in_order() -> None:
    raw = b"".join(raw for _, raw in COMMANDS)
    assert TopsideCodec().receive(raw, 0.0) == [command for command, _ in COMMANDS]


def test_what_is_cut_is_given_up_on_both_sides() -> None:
    for made in (TopsideCodec(), ConsoleCodec()):
        assert made.next_timer() is None
        assert made.receive(b"@A", 1.0) == []
        assert made.next_timer() == pytest.approx(1.05)
        assert made.flush(2.0) == [FrameFault(0, "truncated", 2)]


def test_an_unusable_item_of_the_safety_parameters_keeps_its_value() -> None:
    (command,) = TopsideCodec().receive(b"@SP,,x,-1,9,$", 0.0)
    assert command == SetSafety(None, None, None, 9)


@pytest.mark.parametrize("code", ["NS", "AA", "AC", "AW", "ST", "SP"])
def test_an_answer_says_done_or_refused(code: str) -> None:
    done, refused = answer(code, True, 2.0), answer(code, False, 2.0)
    assert (done.ok, refused.ok, done.t) == (True, False, 2.0)
    assert encode_ack(done) == b"@ACK_%b%b$" % (code.encode(), code[1:].encode())
    assert encode_ack(refused) == b"@ACK_%bN$" % code.encode()


def test_an_acknowledgement_that_does_not_exist_is_not_sent() -> None:
    with pytest.raises(CannotEncode, match="no acknowledgement"):
        encode_ack(Ack(0.0, "Q", "Q", 1))


FIX = Fix(
    1.0, math.radians(30.5), math.radians(120.25), math.inf, 1.23, math.radians(90), elevation=2.5
)
TELEMETRY = Telemetry(
    t=1.0,
    depth=7.25,
    altitude=3.5,
    heading=math.radians(90),
    pitch=math.radians(-5),
    roll=math.radians(2),
    temperature_c=12.5,
    magnetic=(50e-6, 0.0, -10e-6) * 3,
    actuators=(1.0, -1.0, 0.5, 0.0, 0.0, 0.0, 0.2),
    batteries=(12.0, 48.5),
)


def test_a_status_survives_the_way_to_topside() -> None:
    status = Status("2025-01-19T23:26:25", FIX, TELEMETRY)
    (received,) = ConsoleCodec().receive(encode(status), 1.0)
    assert isinstance(received, Status)
    assert received.time == status.time
    for side in ("fix", "telemetry"):
        sent, came = getattr(status, side), getattr(received, side)
        for name in sent.__slots__:
            a, b = getattr(sent, name), getattr(came, name)
            assert a == b or a == pytest.approx(b), name


def test_a_status_carries_wire_units_and_the_yaw_of_the_telemetry() -> None:
    values = status_values(Status("2025-01-19T23:26:25", FIX, TELEMETRY))
    assert values["heading_deg"] == -90.0
    assert (values["lon_deg"], values["lat_deg"], values["ground_speed"]) == (120.25, 30.5, 123)
    assert (values["mag_front_x"], values["pwm_left_main"], values["pwm_right_main"]) == (
        50000,
        2000,
        1000,
    )


def test_what_is_not_known_is_an_empty_field() -> None:
    raw = encode(Status("2025-01-19T23:26:25"))
    assert raw == b"@VS2025-01-19-23:26:25" + b"," * 29 + b"$"
    (received,) = ConsoleCodec().receive(raw, 1.0)
    assert isinstance(received, Status)
    assert received.fix is None
    assert received.telemetry is not None
    assert received.telemetry.heading is received.telemetry.magnetic is None
    assert received.telemetry.actuators is None
    assert received.telemetry.faults == ()
    nothing = encode(Status(None, None, Telemetry(0.0, depth=math.nan, magnetic=(math.inf,) * 9)))
    assert nothing == b"@VS" + b"," * 29 + b"$"


def test_a_doubtful_status_says_so() -> None:
    (received,) = ConsoleCodec().receive(VS.replace(b"100,0,0", b"100,0,181"), 1.0)
    assert isinstance(received, Status)
    assert received.telemetry is not None
    assert received.telemetry.faults == ("heading_deg:out_of_range",)


def test_a_fix_without_speed_or_course_is_a_fix() -> None:
    raw = VS.replace(b"20,100,0", b",,")
    (received,) = ConsoleCodec().receive(raw, 1.0)
    assert isinstance(received, Status)
    assert received.fix is not None
    assert received.fix.speed is received.fix.course is received.fix.elevation is None


def test_an_absurd_reading_is_an_empty_field() -> None:
    values = status_values(
        Status("2025-01-19T23:26:25", FIX, Telemetry(0.0, depth=1e12, heading=1.0))
    )
    assert values["depth_m"] is None
    assert values["heading_deg"] is not None


@pytest.mark.parametrize("text", [b"12.300000000000001", b"-0.1000000000000000055511151231257827"])
def test_a_number_as_a_program_prints_it_costs_no_status(text: bytes) -> None:
    raw = VS.replace(b"36,360", text + b",360")
    (received,) = ConsoleCodec().receive(raw, 1.0)
    assert isinstance(received, Status)
    assert received.telemetry is not None
    assert received.telemetry.batteries == (float(text), 360)


def test_the_link_to_topside_carries_what_became_of_x_and_w_and_no_other_z() -> None:
    framer = link("auv.to_topside").framer()
    for order in (b"@ACK_ZXY$", b"@ACK_ZXN$", b"@ACK_ZWY$", b"@ACK_ZWN$"):
        (frame,) = framer.receive(order, 0.0)
        assert isinstance(frame, Frame)
    (fault, *_) = framer.receive(b"@ACK_ZFY$", 0.0) + framer.flush(1.0)
    assert isinstance(fault, FrameFault)
