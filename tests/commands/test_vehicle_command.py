"""The simulated vehicles as processes to practise with: all four, under the real serve and boat."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import pytest
from programs import process, run
from served import ASKED_AGAIN, PATIENCE, soon

from links import parse_address
from links.serial import SerialLink
from links.simulated.boards import BOARDS, SimulatedBoard
from links.simulated.pty import PtyVehicle
from mission.onboard.configuration import load_configuration
from protocol.framing import Frame
from protocol.vehicles import link, robot

NAMES = ("auv", *BOARDS)
REPORTS = {
    "auv": "auv.SD",
    "coreboard": "coreboard.MAIN_TO_PC",
    "rov": "rov.UP",
    "robot": "robot.UP",
}
REPORTED_ON = {
    "auv": "auv.from_stm32",
    "coreboard": "coreboard.main_to_pc",
    "rov": "rov.up",
    "robot": "robot.up",
}


def line(started: subprocess.Popen[str]) -> str:
    assert started.stdout is not None
    return started.stdout.readline()


@pytest.mark.proof
@pytest.mark.parametrize("name", NAMES)
def test_each_vehicle_is_served_watched_and_stopped_as_it_would_be_at_sea(
    tmp_path: Path, name: str
) -> None:
    ready = tmp_path / "ready.json"
    folder = tmp_path / "it"
    with process("vehicle", name, "--folder", str(folder), "--json") as sea:
        said = json.loads(line(sea))
        assert said["vehicle"] == f"serial://{folder}/vehicle"
        assert ("gps" in said) == (name == "auv")
        words = ("-c", said["config"], "--ready-file", str(ready), "--topside", "tcp://127.0.0.1:0")
        with process("serve", *words):
            soon(ready.exists, "serve")
            to = json.loads(ready.read_text())["topside"]
            told = ("status", "--to", to)
            soon(lambda: "new" in run(*told).stdout, "its reports", pause=ASKED_AGAIN)
            stopped = run("stop", "--to", to)
            assert stopped.exit_code == (0 if name in ("auv", "rov") else 3)
            words = (said["vehicle"], "-c", said["config"], "--json", "--for", str(PATIENCE))
            with process("listen", *words, "--link", REPORTED_ON[name]) as listening:
                soon(lambda: json.loads(line(listening)).get("type") == REPORTS[name], "a report")
        sea.send_signal(signal.SIGINT)
        assert sea.wait(PATIENCE) == 130
    assert {path.name for path in folder.iterdir()} <= {"serve.yaml", "pi"}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("simulate", "rov-dive", "--set", "doppler=0.03"), "simulated AUV alone"),
        (("vehicle", "rov", "--set", "doppler=0.03"), "simulated AUV alone"),
        (("vehicle", "auv", "--set", "ranges=2"), "ranges need beacons"),
    ],
)
def test_added_sensors_that_would_say_nothing_are_refused(
    words: tuple[str, ...], says: str
) -> None:
    ran = run(*words)
    assert ran.exit_code == 2
    assert says in ran.output


@pytest.mark.parametrize("name", sorted(BOARDS))
def test_a_board_behind_its_port_reports_at_the_pace_of_its_document(name: str) -> None:
    board = SimulatedBoard(name, 1)
    row = {"coreboard": "coreboard.main_to_pc"}.get(name, f"{name}.up")
    with PtyVehicle(board, 20.0) as served:
        port, framer, found = SerialLink("vehicle", served.paths[0]), link(row).framer(), []
        for step in range(1, 201):
            served.step(0.01 * step)
            for rx in port.receive(0.01 * step):
                found += framer.receive(rx.data, rx.t)
        port.close()
    assert all(isinstance(one, Frame) for one in found)
    assert len(found) == pytest.approx(2.0 / board.board.period, abs=1)


def test_what_is_sent_to_a_boards_port_moves_it() -> None:
    board = SimulatedBoard("robot", 1)
    with PtyVehicle(board, 20.0) as served:
        for word in (
            ("address=1", f"command={robot.SPEED}", "speed_mm_s=500"),
            ("address=1", "command=1"),
        ):
            ran = run("send", "--port", f"serial://{served.paths[0]}", "robot.DOWN", *word)
            assert ran.exit_code == 0, ran.stderr
            served.step(board.now + 0.01)
        served.step(board.now + 0.2)
    assert board.plant.u > 0.0


def test_the_configuration_that_is_written_is_one_that_serve_reads(tmp_path: Path) -> None:
    with process("vehicle", "rov", "--folder", str(tmp_path), "--port", "4711") as sea:
        assert "simulated rov" in line(sea)
        read = load_configuration(tmp_path / "serve.yaml")
    assert (read.vehicle, read.links.gps) == ("rov", None)
    assert read.links.topside == "tcp://127.0.0.1:4711"


def test_a_configuration_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "serve.yaml").write_text("vehicle: auv\n")
    ran = run("vehicle", "rov", "--folder", str(tmp_path))
    assert ran.exit_code == 2
    assert (tmp_path / "serve.yaml").read_text() == "vehicle: auv\n"


def test_the_true_track_is_kept_where_it_is_asked_for(tmp_path: Path) -> None:
    track = tmp_path / "track.csv"
    words = ("--folder", str(tmp_path), "--track", str(track), "--position", "30.5,120.5", "--json")
    with process("vehicle", *words, "--speed", "10") as sea:
        port = SerialLink("vehicle", parse_address(json.loads(line(sea))["vehicle"]).path)
        soon(lambda: any(b"@SD" in rx.data for rx in port.receive(0.0)), "a report")
        port.close()
        sea.send_signal(signal.SIGTERM)
        assert sea.wait(PATIENCE) == 0
    rows = track.read_text().splitlines()
    assert len(rows) > 2
    assert rows[1].split(",")[1:3] == ["30.50000000", "120.50000000"]


@pytest.mark.parametrize(
    "words",
    [
        ("submarine",),
        ("rov", "--set", "fault=heading_mirrored@10"),
        ("auv", "--position", "91,0"),
        ("auv", "--position", "here"),
    ],
)
def test_what_cannot_be_simulated_is_refused_with_exit_2(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    assert run("vehicle", *words, "--folder", str(tmp_path)).exit_code == 2
