"""Core board, motor CAN, ROV, robot: SI in, setpoints out, and what a vehicle lacks stands in its file."""

from __future__ import annotations

import math
import struct
from dataclasses import replace

import pytest

from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import CLOSED
from protocol.codec import CannotEncode, VehicleCodec
from protocol.examples import MAIN_TO_PC, PC_TO_MAIN, ROV_UP
from protocol.messages import FrameFault, Order, Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles import VEHICLES, codec, coreboard, link, robot, rov

FILES = sorted(path.stem for path in (missions_folder() / "vehicles").glob("*.yaml"))
SILENT = ["coreboard", "motorcan", "mainboard", "rov", "robot"]


def made(name: str) -> VehicleCodec:
    return codec(name, "documented", {})


def telemetry(name: str, raw: bytes) -> Telemetry:
    (message,) = made(name).receive(raw, 7.0)
    assert isinstance(message, Telemetry)
    return message


def xored(raw: bytes, at: int, data: bytes) -> bytes:
    raw = raw[:at] + data + raw[at + len(data) :]
    total = 0
    for byte in raw[:-3]:
        total ^= byte
    return raw[:-3] + bytes([total]) + raw[-2:]


def summed(raw: bytes, at: int, data: bytes) -> bytes:
    raw = raw[:at] + data + raw[at + len(data) :]
    return raw[:-3] + bytes([sum(raw[4:-3]) & 255]) + raw[-2:]


# --- one contract for all -------------------------------------------------------------------


@pytest.mark.parametrize("name", SILENT)
def test_a_codec_frames_times_and_flushes_like_any_other(name: str) -> None:
    one = made(name)
    assert one.next_timer() is None
    assert one.receive(b"\x01\x02\x03", 1.0) == []
    due = one.next_timer()
    assert due is not None
    assert one.flush(due - 0.01) == []
    (fault,) = one.flush(due)
    assert isinstance(fault, FrameFault)
    assert (fault.offset, fault.length) == (0, 3)


AXES = {
    "surge": Setpoint(surge=0.5),
    "turn": Setpoint(turn=0.5),
    "heave": Setpoint(heave=0.5),
    "heading": Setpoint(heading=1.0),
    "depth": Setpoint(depth=3.0),
    "altitude": Setpoint(altitude=3.0),
    "attitude": Setpoint(pitch=0.1),
}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("axis", AXES)
def test_an_axis_is_followed_exactly_where_the_vehicles_file_says_so(name: str, axis: str) -> None:
    vehicle = load_vehicle(name)
    one = codec(vehicle.codec, vehicle.dialect, vehicle.tolerances)
    setpoint = AXES[axis]
    if name == "coreboard" and axis in ("heading", "depth"):
        setpoint = replace(setpoint, heading=1.0, depth=3.0)
    by_the_pi = vehicle.outer_loop is not None and axis in CLOSED
    if axis in vehicle.follows and not by_the_pi:
        assert one.encode(setpoint)
    else:
        with pytest.raises(CannotEncode, match=r"pitch" if axis == "attitude" else axis):
            one.encode(setpoint)


@pytest.mark.parametrize(
    ("name", "raw"),
    [
        ("coreboard", MAIN_TO_PC),
        ("rov", ROV_UP),
        ("robot", bytes.fromhex("AA E8 03 C0 5D B4 DD")),
    ],
)
def test_the_vehicles_file_says_what_telemetry_tells(name: str, raw: bytes) -> None:
    told = telemetry(name, raw)
    known = {
        "depth": told.depth,
        "altitude": told.altitude,
        "heading": told.heading,
        "attitude": told.pitch,
        "temperature": told.temperature_c,
        "battery": told.batteries,
        "leak": told.leak,
        "position": told.position,
    }
    assert load_vehicle(name).reports == {key for key, value in known.items() if value is not None}


@pytest.mark.parametrize("name", [row.name for row in VEHICLES.values()])
def test_every_vehicle_takes_the_two_safety_orders(name: str) -> None:
    row = next(row for row in VEHICLES.values() if row.name == name)
    for order in Order:
        assert row.make(row.dialects[0], Tolerances(), (1.0, 1.0)).encode(order)


@pytest.mark.parametrize("name", SILENT)
@pytest.mark.parametrize(
    "setpoint", [Setpoint(surge=1.01), Setpoint(turn=-1.01), Setpoint(surge=math.nan)]
)
def test_efforts_beyond_full_are_refused_whole(name: str, setpoint: Setpoint) -> None:
    with pytest.raises(CannotEncode, match=r"outside -1\.\.1"):
        made(name).encode(setpoint)


# --- core board -----------------------------------------------------------------------------


def test_the_core_boards_report_in_si() -> None:
    told = telemetry("coreboard", MAIN_TO_PC)
    assert told.t == 7.0
    assert told.roll == pytest.approx(math.radians(-18.376297))
    assert told.pitch == pytest.approx(math.radians(14.883912))
    assert told.heading == pytest.approx(math.radians(360 - 38.013535))
    assert (told.depth, told.altitude, told.temperature_c) == (10.0, 2.5, 38.0)
    assert told.batteries == pytest.approx((12.34, 47.9))
    assert told.position == pytest.approx((math.radians(30.2874595), math.radians(120.1535765)))
    assert told.leak is False
    assert told.faults == ()


def test_a_position_counts_only_while_the_ins_is_aligned() -> None:
    assert telemetry("coreboard", xored(MAIN_TO_PC, 82, b"\x00")).position is None
    nowhere = xored(MAIN_TO_PC, 14, bytes(16))
    assert telemetry("coreboard", nowhere).position is None
    swapped = xored(MAIN_TO_PC, 14, MAIN_TO_PC[22:30] + MAIN_TO_PC[14:22])
    told = telemetry("coreboard", swapped)  # longitude first: the latitude is 120
    assert told.position is None
    assert told.faults == ("lat_deg:out_of_range",)


def test_a_leak_is_confirmed_by_three_frames_more_than_deny_it_whatever_its_code() -> None:
    wet, odd = xored(MAIN_TO_PC, 69, b"\x01"), xored(MAIN_TO_PC, 69, b"\x07")
    one = made("coreboard")
    told = [one.receive(raw, 0.0)[0] for raw in (wet, odd, MAIN_TO_PC, wet, wet, odd, MAIN_TO_PC)]
    leaks = [t.leak for t in told if isinstance(t, Telemetry)]
    assert leaks == [False, False, False, False, True, True, True]
    one = made("coreboard")
    flickers = [one.receive(raw, 0.0)[0] for raw in (wet, MAIN_TO_PC) * 20]
    assert not any(t.leak for t in flickers if isinstance(t, Telemetry))


def sent(name: str, setpoint: Setpoint | Order) -> dict[str, object]:
    (raw,) = made(name).encode(setpoint)
    (frame,) = (
        link({"coreboard": "coreboard.pc_to_main", "rov": "rov.down"}[name])
        .framer()
        .receive(raw, 0.0)
    )
    assert not isinstance(frame, FrameFault)
    return frame.values()


def test_neutral_is_100_on_the_wire_of_the_core_board() -> None:
    for quiet in (Setpoint(), Order.STOP):
        (raw,) = made("coreboard").encode(quiet)
        assert raw[35:41] == bytes([100] * 6)
        assert raw[42] == 0


def test_the_core_board_is_driven_by_forces_and_holds_heading_and_depth_together() -> None:
    values = sent("coreboard", Setpoint(surge=0.5, turn=-0.25, heave=1.0))
    assert (values["tx"], values["mz"], values["tz"], values["closed_loop"]) == (50, -25, 100, 0)
    held = sent("coreboard", Setpoint(surge=0.5, heading=math.radians(270), depth=10.5))
    assert (held["tx"], held["closed_loop"], held["mode"]) == (50, 1, 0)
    assert held["heading_deg"] == pytest.approx(-90.0)
    assert held["depth_m"] == 10.5
    up = sent("coreboard", Order.SURFACE)
    assert (up["tz"], up["tx"], up["closed_loop"]) == (-100, 0, 0)


@pytest.mark.parametrize(
    ("setpoint", "says"),
    [
        (Setpoint(heading=1.0), "depth: the board holds heading and depth together"),
        (Setpoint(depth=1.0), "heading: the board holds heading and depth together"),
        (Setpoint(heading=1.0, depth=1.0, turn=0.1), "turn and heave"),
    ],
)
def test_what_the_core_boards_one_switch_cannot_say_is_refused(
    setpoint: Setpoint, says: str
) -> None:
    with pytest.raises(CannotEncode, match=says):
        made("coreboard").encode(setpoint)


def test_float_order_holds_for_both_ways_of_the_core_board() -> None:
    one = codec("coreboard", "documented", {"float_order": "high"})
    (raw,) = one.encode(Setpoint(heading=math.pi / 2, depth=10.5))
    assert struct.unpack_from(">f", raw, 26)[0] == 10.5
    assert coreboard.pc_to_main(Tolerances()).check(PC_TO_MAIN) is None


# --- motor CAN ------------------------------------------------------------------------------


def test_motors_get_a_force_and_a_torque_frame_and_report_nothing() -> None:
    wire = {"surge_g": "1000", "heave_g": "2000", "turn_nm": "10"}
    one = codec("motorcan", "documented", {}, wire=wire)
    force, torque = one.encode(Setpoint(surge=-0.5, turn=0.5, heave=0.25))
    assert force == bytes.fromhex("0001 07 FF FE0C 0000 01F4")
    assert torque == bytes.fromhex("0002 07 FE 0000 0000 0005")
    assert one.encode(Order.SURFACE)[0] == bytes.fromhex("0001 07 FF 0000 0000 F830")
    assert one.encode(Order.STOP) == one.encode(Setpoint())
    assert one.receive(force + torque, 0.0) == []
    with pytest.raises(CannotEncode, match="heading: the motor boards hold nothing"):
        one.encode(Setpoint(heading=0.0))


# --- ROV ------------------------------------------------------------------------------------


def test_the_rovs_report_in_si() -> None:
    told = telemetry("rov", summed(ROV_UP, 47, struct.pack("<4i", -1000, 0, 500, 1000)))
    assert told.depth == pytest.approx(6.6666667)
    assert told.roll == pytest.approx(math.radians(-6.4459114))
    assert told.pitch == pytest.approx(math.radians(-0.33067858))
    assert told.heading == pytest.approx(math.radians(0.018261943))
    assert told.actuators == (-1.0, 0.0, 0.5, 1.0)
    wire = {"left_front_rpm": "500", "left_up_rpm": "-800"}
    for more, shares in (({}, (-1.0, 0.0, -0.625, 1.0)), ({"right_up_rpm": "0"}, None)):
        board = codec("rov", "documented", {}, wire={**wire, **more})
        (of_its_own,) = board.receive(
            summed(ROV_UP, 47, struct.pack("<4i", -900, 0, 500, 1000)), 0.0
        )
        assert isinstance(of_its_own, Telemetry)
        assert of_its_own.actuators == shares
    west = telemetry("rov", summed(ROV_UP, 39, struct.pack("<f", -90.0)))
    assert west.heading == pytest.approx(math.radians(270))
    assert telemetry("rov", summed(ROV_UP, 43, struct.pack("<f", math.nan))).depth is None


def test_the_sample_of_003_agrees_with_the_signs_taken_from_it() -> None:
    values = rov.up(Tolerances()).decode(ROV_UP)
    told = telemetry("rov", ROV_UP)
    assert told.roll is not None
    assert told.pitch is not None
    assert values["ay_g"] == pytest.approx(-math.sin(told.roll), abs=0.005)
    assert values["ax_g"] == pytest.approx(math.sin(told.pitch), abs=0.005)


def test_the_rov_goes_ahead_to_starboard_and_down() -> None:
    values = sent("rov", Setpoint(surge=0.5, turn=0.25, heave=0.75))
    assert (values["x"], values["z"], values["f"]) == (0.5, 0.25, -0.75)
    assert sent("rov", Order.SURFACE)["f"] == 1.0
    quiet = sent("rov", Order.STOP)
    assert (quiet["x"], quiet["z"], quiet["f"]) == (0.0, 0.0, 0.0)
    assert sent("rov", Setpoint()) == quiet


# --- robot ----------------------------------------------------------------------------------


def test_the_robots_report_in_si() -> None:
    body = bytes([0xAA]) + struct.pack("<hH", -250, 24_000)
    told = telemetry("robot", body + bytes([sum(body) % 255, 0xDD]))
    assert told.velocity == (-0.25, 0.0, 0.0)
    assert told.batteries == (24.0, None)


@pytest.mark.parametrize(
    ("setpoint", "commands"),
    [
        (Setpoint(surge=0.5), [(robot.SPEED, 500), (robot.FORWARD, None)]),
        (Setpoint(surge=-1.0), [(robot.SPEED, 1000), (robot.BACK, None)]),
        (Setpoint(turn=0.25), [(robot.SPEED, 250), (robot.SPIN_RIGHT, None)]),
        (Setpoint(turn=-0.25, heave=0.0), [(robot.SPEED, 250), (robot.SPIN_LEFT, None)]),
        (Setpoint(), [(robot.STOP, None)]),
        (Order.STOP, [(robot.STOP, None)]),
        (Order.SURFACE, [(robot.STOP, None)]),
    ],
)
def test_the_robot_gets_its_speed_before_its_motion(
    setpoint: Setpoint | Order, commands: list[tuple[int, int | None]]
) -> None:
    frames = made("robot").encode(setpoint)
    values = [robot.DownFrame(Tolerances()).decode(raw) for raw in frames]
    assert [(v["command"], v.get("speed_mm_s")) for v in values] == commands
    assert {v["address"] for v in values} == {robot.ROBOT}


def test_the_robot_cannot_drive_a_curve() -> None:
    with pytest.raises(CannotEncode, match="not both at once"):
        made("robot").encode(Setpoint(surge=0.5, turn=0.1))
