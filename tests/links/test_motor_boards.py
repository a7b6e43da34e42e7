"""The motor boards of document 002 on their bus: what they obey, when they stop, a bus of two processes."""

from __future__ import annotations

import json
import signal
import socket
import time
from pathlib import Path

import pytest
from programs import process, run
from served import ASKED_AGAIN, PATIENCE, soon

from links import open_link
from links.simulated.boards import SimulatedBoard
from links.simulated.settings import SettingError, parse_settings
from mission.commands.vehicle import BUS
from mission.model.shipped import load_vehicle
from mission.onboard.blackbox import read_parts
from mission.onboard.runtime.records import TX, read_tx
from mission.verification.rig.vehicle import simulated
from protocol.framing import Frame
from protocol.messages import Order, Setpoint
from protocol.vehicles import codec, link

WIRE = codec("motorcan", "documented", {})
EVERY = 0.05  # s (R16)


def boards() -> SimulatedBoard:
    made = simulated(load_vehicle("motorboards"))
    assert isinstance(made, SimulatedBoard)
    return made


def say(vehicle: SimulatedBoard, setpoint: Setpoint | Order, begin: float, end: float) -> None:
    for i in range(round((end - begin) / EVERY)):
        for record in WIRE.encode(setpoint):
            vehicle.vehicle_link.send(record, begin + EVERY * i)
    vehicle.advance(end)


def test_force_ahead_and_down_and_torque_move_the_body_as_they_say() -> None:
    vehicle = boards()
    say(vehicle, Setpoint(surge=0.5), 0.0, 10.0)
    assert vehicle.plant.u > 0.3
    assert abs(vehicle.plant.yaw) < 0.01
    say(vehicle, Setpoint(turn=0.5), 10.0, 15.0)
    assert vehicle.plant.r > 0.05
    say(vehicle, Setpoint(heave=1.0), 15.0, 30.0)
    assert vehicle.plant.depth > 2.0
    say(vehicle, Order.SURFACE, 30.0, 60.0)
    assert vehicle.plant.depth < 0.5


def test_without_a_frame_for_200_ms_the_motors_stop() -> None:
    vehicle = boards()
    say(vehicle, Setpoint(surge=1.0), 0.0, 5.0)
    assert vehicle.plant.thrust[0] > 30.0
    vehicle.advance(5.1)
    assert vehicle.plant.thrust[0] > 30.0
    vehicle.advance(7.0)
    assert vehicle.plant.thrust[0] == pytest.approx(0.0, abs=0.1)


def test_they_say_nothing_and_have_no_sensor_to_fail() -> None:
    vehicle = boards()
    assert vehicle.vehicle_link.receive(10.0) == []
    with pytest.raises(SettingError, match="not of motorcan"):
        SimulatedBoard("motorcan", settings=parse_settings(["fault=depth_frozen@1+2"]))


def multicast() -> bool:
    """Whether this computer lets a program join a group."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.sendto(b"", ("239.74.163.2", 43113))
        except OSError:
            return False
    return True


@pytest.mark.proof
@pytest.mark.skipif(not multicast(), reason="no UDP multicast here")
def test_two_programs_meet_on_a_bus_by_udp_multicast(tmp_path: Path) -> None:
    bus, track = "can://239.74.163.7:43117?interface=udp_multicast", tmp_path / "track.csv"
    words = ("--bus", bus, "--folder", str(tmp_path / "it"), "--track", str(track), "--json")
    with process("vehicle", "motorboards", *words) as sea:
        assert sea.stdout is not None
        assert json.loads(sea.stdout.readline())["vehicle"] == bus
        opened = open_link("vehicle", bus)
        try:
            for _ in range(80):
                for record in WIRE.encode(Setpoint(surge=1.0)):
                    opened.send(record, 0.0)
                time.sleep(EVERY)
        finally:
            opened.close()
        sea.send_signal(signal.SIGINT)
        assert sea.wait(PATIENCE) == 130
    rows = [row.split(",") for row in track.read_text().splitlines()[1:]]
    assert float(rows[-1][1]) > float(rows[0][1]) + 1e-6, "it went north"


@pytest.mark.proof
@pytest.mark.skipif(not multicast(), reason="no UDP multicast here")
def test_the_pi_in_the_main_boards_place_is_served_watched_and_told_by_name(tmp_path: Path) -> None:
    """Sensor board on a pseudo-terminal, motor boards on a bus, and one serve for both."""
    bus, ready = "can://239.74.163.8:43118?interface=udp_multicast", tmp_path / "ready.json"
    words = ("--bus", bus, "--folder", str(tmp_path / "it"), "--port", "0", "--json")
    with process("vehicle", "mainboard", *words) as sea:
        assert sea.stdout is not None
        said = json.loads(sea.stdout.readline())
        assert said["vehicle"].startswith(f"{bus}&sensors=/dev/")
        with process("serve", "-c", said["config"], "--ready-file", str(ready)):
            soon(ready.exists, "serve")
            to = json.loads(ready.read_text())["topside"]
            told = ("status", "--to", to)
            soon(lambda: "new" in run(*told).stdout, "its sensor board's", pause=ASKED_AGAIN)
            soon(lambda: run("output", "led1", "50", "--to", to).exit_code == 0, "a LED by name")
            assert run("output", "led1", "101", "--to", to).exit_code == 1
            dropped = run("output", "weight", "1", "--to", to)
            assert dropped.exit_code == 0, dropped.output
            box = Path(json.loads(ready.read_text())["black_box"])
            soon(lambda: _told(box) == {"led1": 50, "drop_weight": 1}, "both on the wire")
        sea.send_signal(signal.SIGINT)
        assert sea.wait(PATIENCE) == 130


def _told(box: Path) -> dict[str, int]:
    """What the sensor board was told last."""
    frames = [read_tx(one).data for one in read_parts(box) if one.kind == TX]
    told = [data for data in frames if data[:2] == b"\xfe\xef"]
    if not told:
        return {}
    (frame,) = link("coreboard.main_to_sensor").framer().receive(told[-1], 0.0)
    assert isinstance(frame, Frame)
    return {name: frame.values()[name] for name in ("led1", "drop_weight")}


def test_the_bus_that_the_command_takes_needs_neither_hardware_nor_root() -> None:
    assert "udp_multicast" in BUS
