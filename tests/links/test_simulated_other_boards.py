"""Laws of the boards that answer nothing: what they hear, what they report, when they go neutral."""

from __future__ import annotations

from itertools import pairwise
from math import degrees, dist, pi, radians
from random import Random

import pytest

from links.base import LinkClosed
from links.simulated.boards import BOARDS, SimulatedBoard
from links.simulated.firmware.boards import RobotBoard
from links.simulated.firmware.ins import ALIGNS, Ins
from links.simulated.ground import Ground
from links.simulated.link import SimulatedVehicle
from links.simulated.settings import SettingError, Settings, parse_settings
from protocol.messages import Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles import codec, link

UP = {"coreboard": "coreboard.main_to_pc", "rov": "rov.up", "robot": "robot.up"}
PERIODS = {"coreboard": 0.1, "rov": 0.05, "robot": 0.1}


def run(vehicle: SimulatedBoard, until: float) -> list[Telemetry]:
    """Reports as the codec of the vehicle reads them."""
    wire = codec(vehicle.name, "documented", {})
    heard: list[Telemetry] = []
    for rx in vehicle.vehicle_link.receive(until):
        for message in wire.receive(rx.data, rx.t):
            assert isinstance(message, Telemetry)
            heard.append(message)
    return heard


def say(vehicle: SimulatedBoard, setpoint: Setpoint, begin: float, end: float) -> None:
    """Every 0.1 s."""
    wire = codec(vehicle.name, "documented", {})
    for i in range(round((end - begin) * 10)):
        for data in wire.encode(setpoint):
            vehicle.vehicle_link.send(data, begin + 0.1 * i)


@pytest.mark.parametrize("name", BOARDS)
def test_reports_come_at_their_pace_whole_and_good(name: str) -> None:
    vehicle = SimulatedBoard(name, seed=1)
    heard = run(vehicle, 5.01)
    assert len(heard) == pytest.approx(5.0 / PERIODS[name], abs=1)
    if name != "robot":
        assert all(abs((t.depth or 0.0) - vehicle.plant.depth) < 0.3 for t in heard)


@pytest.mark.parametrize("name", BOARDS)
def test_a_report_is_there_when_its_last_byte_is_through(name: str) -> None:
    vehicle = SimulatedBoard(name)
    event = vehicle.vehicle_link.next_event()
    assert event is not None
    assert event == pytest.approx(PERIODS[name])
    assert vehicle.vehicle_link.receive(event) == []
    done = vehicle.vehicle_link.next_event()
    assert done is not None
    (rx,) = vehicle.vehicle_link.receive(done)
    assert rx.t == pytest.approx(PERIODS[name])
    assert done - rx.t == pytest.approx(len(rx.data) * 10 / 115200)
    assert link(UP[name]).framer().receive(rx.data, 0.0)


@pytest.mark.parametrize(("name", "silence"), [("coreboard", 0.5), ("rov", 0.5), ("robot", 0.3)])
def test_silence_brings_neutral_and_no_less(name: str, silence: float) -> None:
    vehicle = SimulatedBoard(name)
    say(vehicle, Setpoint(surge=0.8), 0.0, 10.0)  # the last one at 9.9 s
    vehicle.advance(9.9 + silence - 0.05)
    assert drive_of(vehicle) > 0.4
    vehicle.advance(9.9 + silence + 2.0)
    assert drive_of(vehicle) < 0.01
    vehicle.advance(60.0)
    assert abs(vehicle.plant.u) < 0.1


def drive_of(vehicle: SimulatedBoard) -> float:
    """What drives it ahead: a share of full thrust, or m/s on the ground."""
    plant = vehicle.plant
    return plant.u if isinstance(plant, Ground) else sum(plant.thrust[:2]) / 80.0


@pytest.mark.parametrize("name", ["coreboard", "mainboard"])
def test_no_sensor_that_is_well_says_the_same_three_times(name: str) -> None:
    """As a real one does not; who asks whether a sensor lives goes by that."""
    told = run(SimulatedBoard(name), 3.0)
    for sensor in ("depth", "altitude", "heading", "pitch", "roll"):
        said = [getattr(report, sensor) for report in told]
        assert not any(a == b == c for a, b, c in zip(said, said[1:], said[2:], strict=False))


def test_the_core_board_holds_heading_and_depth_in_closed_loop() -> None:
    vehicle = SimulatedBoard("coreboard")
    say(vehicle, Setpoint(surge=0.5, heading=radians(120), depth=3.0), 0.0, 60.0)
    assert vehicle.plant.depth == pytest.approx(3.0, abs=0.2)
    assert degrees(vehicle.plant.yaw) % 360 == pytest.approx(120.0, abs=4.0)


def test_the_core_boards_own_position_scatters_at_the_surface_and_drifts_under_water() -> None:
    vehicle = SimulatedBoard("coreboard")
    say(vehicle, Setpoint(), 0.0, 10.0)
    said = run(vehicle, 10.0)[-50:]
    say(vehicle, Setpoint(heading=0.0, depth=3.0), 10.0, 60.0)
    surface, deep = velocities(said), velocities(run(vehicle, 60.0)[-300:])
    assert len(surface) == 49
    assert len(deep) == 299
    assert max(surface) > 10.0
    assert min(deep) > 0.0
    assert max(deep) < 0.5
    assert max(deep) - min(deep) < 0.01


def velocities(said: list[Telemetry]) -> list[float]:
    """By its own positions, m/s."""
    places = [t.position for t in said if t.position]
    return [10.0 * 6.4e6 * dist(a, b) for a, b in pairwise(places)]


def test_an_ins_that_has_never_been_at_the_surface_knows_no_place() -> None:
    ins, true = Ins(Random(1)), (0.5, 2.1)
    assert ins.place(true, 0.1, 100.0) is None
    ins.switch(True, 0.0)
    assert ins.place(true, 5.0, 10.0) is None
    assert ins.place(true, 0.1, 11.0)
    assert ins.place(true, 5.0, 12.0)
    ins.switch(False, 13.0)
    ins.switch(True, 14.0)
    assert ins.place(true, 5.0, 20.0) is None


def test_the_ins_of_the_core_board_aligns_only_after_a_frame_has_switched_it_on() -> None:
    vehicle = SimulatedBoard("coreboard")
    assert all(t.position is None for t in run(vehicle, 20.0))
    say(vehicle, Setpoint(), 20.0, 22.0)
    told = run(vehicle, 30.0)
    assert all((t.position is not None) == (t.t >= 20.0 + ALIGNS) for t in told if t.t > 20.0)
    off = codec("coreboard", "documented", {}, wire={"ins_on": "0"}).encode(Setpoint())[0]
    vehicle.vehicle_link.send(off, 30.0)
    assert all(t.position is None for t in run(vehicle, 40.0) if t.t > 30.1)


def test_the_rov_turns_to_starboard_and_sinks_as_asked() -> None:
    vehicle = SimulatedBoard("rov")
    say(vehicle, Setpoint(turn=0.4, heave=0.8), 0.0, 5.0)
    assert vehicle.plant.yaw > 0.2
    assert vehicle.plant.depth > 0.8
    turned = [t.heading for t in run(vehicle, 5.1)[-5:]]
    assert all(h is not None and 0.2 < h < 2 * pi for h in turned)


def test_the_rovs_flags_hold_what_is_there_when_they_are_set() -> None:
    vehicle = SimulatedBoard("rov")
    say(vehicle, Setpoint(heave=0.8), 0.0, 12.0)
    began = vehicle.plant.depth
    row = next(t for t in link("rov.down").frames(Tolerances()) if t.name == "rov.DOWN")
    for i in range(150):
        values = {
            "hold_heading": 1, "hold_depth": 1, "led_pct": 0, "servo_deg": 0,
            "x": 0.0, "z": 0.0, "f": 0.0, "reserved": 0,
        }  # fmt: skip
        vehicle.vehicle_link.send(row.encode(values), 12.0 + 0.1 * i)
    assert vehicle.plant.depth == pytest.approx(began, abs=0.3)


def test_a_frame_that_is_wrong_is_not_heard() -> None:
    for name in BOARDS:
        vehicle = SimulatedBoard(name)
        for data in codec(name, "documented", {}).encode(Setpoint(surge=0.5)):
            broken = bytearray(data)
            broken[-3] ^= 1
            vehicle.vehicle_link.send(bytes(broken), 0.0)
        vehicle.advance(2.0)
        assert abs(vehicle.plant.u) < 1e-9


def test_a_handshake_is_answered_by_one_ordinary_report() -> None:
    vehicle = SimulatedBoard("robot")
    assert isinstance(vehicle.board, RobotBoard)
    row = next(iter(link("robot.down").frames(Tolerances())))
    vehicle.vehicle_link.send(row.encode({"address": 1, "command": 0xFF}), 0.02)
    (rx,) = vehicle.vehicle_link.receive(0.05)
    assert len(rx.data) == 7
    assert rx.t == pytest.approx(0.02)


def test_the_robot_drives_one_motion_at_a_time() -> None:
    vehicle = SimulatedBoard("robot")
    say(vehicle, Setpoint(surge=-0.5), 0.0, 4.0)
    assert vehicle.plant.north == pytest.approx(-2.0, abs=0.2)
    place = vehicle.plant.north
    say(vehicle, Setpoint(turn=-0.5), 4.0, 6.0)
    assert vehicle.plant.yaw < -1.0
    assert vehicle.plant.north == pytest.approx(place, abs=0.3)


@pytest.mark.parametrize("name", BOARDS)
def test_the_same_seed_gives_the_same_bytes_however_time_is_cut(name: str) -> None:
    whole, cut = SimulatedBoard(name, seed=5), SimulatedBoard(name, seed=5)
    once = [rx.data for rx in whole.vehicle_link.receive(3.0)]
    often = [rx.data for i in range(1, 61) for rx in cut.vehicle_link.receive(0.05 * i)]
    assert once == often


def flown(name: str, fault: str, until: float = 30.0) -> list[Telemetry]:
    return run(SimulatedBoard(name, seed=1, settings=parse_settings([fault])), until)


@pytest.mark.parametrize(
    ("name", "fault"),
    [("rov", "leak"), ("rov", "battery_low"), ("robot", "heavy"), ("coreboard", "stm32_hang")],
)
def test_a_fault_that_a_board_cannot_have_is_refused_with_those_that_it_can(
    name: str, fault: str
) -> None:
    with pytest.raises(SettingError, match=f"fault={fault}: not of {name}; it has stm32_silent, "):
        flown(name, f"fault={fault}@10+5")


def test_the_auv_has_no_fault_of_another_board() -> None:
    with pytest.raises(SettingError, match="fault=leak: not of the AUV"):
        SimulatedVehicle(settings=parse_settings(["fault=leak@10+5"]))


def test_water_inside_is_reported_for_as_long_as_it_is_there() -> None:
    wet = [t.t for t in flown("coreboard", "fault=leak@10+5") if t.leak]
    assert wet
    assert 9.9 < wet[0] < wet[-1] < 15.3
    assert not any(t.leak for t in flown("coreboard", "floor=30"))


@pytest.mark.parametrize("name", BOARDS)
def test_a_board_that_falls_silent_is_heard_again_when_that_is_over(name: str) -> None:
    heard = [t.t for t in flown(name, "fault=stm32_silent@10+5")]
    assert not [t for t in heard if 10.1 < t < 14.9]
    assert [t for t in heard if t > 15.1]


@pytest.mark.parametrize("name", BOARDS)
def test_a_frame_with_a_bit_turned_over_is_a_fault_and_never_a_reading(name: str) -> None:
    vehicle = SimulatedBoard(name, 1, parse_settings(["fault=bytes_corrupted=1@10+5"]))
    wire = codec(vehicle.name, "documented", {})
    heard = [
        (rx.t, m) for rx in vehicle.vehicle_link.receive(30.0) for m in wire.receive(rx.data, rx.t)
    ]
    good = [t for t, message in heard if isinstance(message, Telemetry)]
    assert not [t for t in good if 10.1 < t < 14.9]
    assert [t for t in good if t < 10.0]
    assert [t for t in good if t > 15.5]


@pytest.mark.parametrize("name", ["coreboard", "rov"])
def test_a_frozen_depth_repeats_to_the_bit(name: str) -> None:
    heard = [t for t in flown(name, "fault=depth_frozen@10+5") if 10.2 < t.t < 14.8]
    assert len({t.depth for t in heard}) == 1
    assert len({t.heading for t in heard}) > 10


@pytest.mark.proof
@pytest.mark.parametrize("name", ["coreboard", "robot"])
def test_a_battery_falls_as_it_is_used_and_when_it_is_told_to(name: str) -> None:
    vehicle = SimulatedBoard(name, seed=1)
    begin = run(vehicle, 5.0)[-1]
    end = run(vehicle, 600.0)[-1]
    assert begin.batteries is not None
    assert end.batteries is not None
    assert end.batteries[0] < begin.batteries[0] - 0.03
    low = [t.batteries for t in flown(name, "fault=battery_low=9@10+5") if 10.2 < t.t < 14.8]
    assert all(volts is not None and volts[0] == pytest.approx(9.0, abs=0.2) for volts in low)


@pytest.mark.parametrize("name", BOARDS)
def test_a_board_that_is_deaf_does_not_move(name: str) -> None:
    vehicle = SimulatedBoard(name, 1, parse_settings(["fault=command_lost@0+20"]))
    say(vehicle, Setpoint(surge=0.5), 1.0, 10.0)
    assert vehicle.plant.u == pytest.approx(0.0, abs=0.01)


def test_a_weak_thruster_of_the_rov_turns_it() -> None:
    sound, weak = (
        SimulatedBoard("rov", 1),
        SimulatedBoard("rov", 1, parse_settings(["fault=left_main_weak=0.2@1+60"])),
    )
    for vehicle in (sound, weak):
        say(vehicle, Setpoint(surge=0.5), 1.0, 11.0)
    assert abs(sound.plant.yaw) < 0.01
    assert weak.plant.yaw < -0.3  # the right one pushes it to the left


def test_the_rov_is_no_torpedo() -> None:
    """Its planning figures (rov.yaml), and no way of its own once nothing pushes."""
    vehicle = SimulatedBoard("rov", 1)
    say(vehicle, Setpoint(surge=1.0), 0.0, 20.0)
    assert vehicle.plant.u == pytest.approx(0.8, abs=0.1)
    say(vehicle, Setpoint(), 20.0, 23.0)
    assert vehicle.plant.u < 0.2
    say(vehicle, Setpoint(turn=1.0), 23.0, 33.0)
    assert degrees(vehicle.plant.r) == pytest.approx(35.0, abs=8.0)
    assert abs(vehicle.plant.pitch) < radians(1.0)
    say(vehicle, Setpoint(heave=1.0), 33.0, 50.0)
    assert vehicle.plant.depth_rate == pytest.approx(0.3, abs=0.08)


def test_a_link_that_was_closed_says_so() -> None:
    vehicle = SimulatedBoard("rov", settings=Settings())
    vehicle.vehicle_link.close()
    with pytest.raises(LinkClosed):
        vehicle.vehicle_link.receive(1.0)
