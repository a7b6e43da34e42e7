"""A link is shown live, from the port or from the serve that has it; nothing is sent."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import termios
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result
from served import PATIENCE, asked, read_now, running, silent_board, simulated, soon

from links import open_link
from links.base import Rx
from mission.analysis.replay.follow import IN, follow
from mission.commands.decode import decode
from mission.commands.listen import listen
from mission.onboard.blackbox import BlackBox, BlackBoxError, Tail
from mission.onboard.runtime.records import fault_record, rx_record
from mission.topside.hearing import Heard, Hearing, as_line, with_baud
from protocol.framing import Frame
from protocol.messages import FrameFault
from protocol.tolerances import Tolerances
from protocol.vehicles import frame_types, link

ACK, NOISE = b"@ACK_ZXY$", b"\0noise\0"


def listened(*words: str, config: Path | None = None) -> Result:
    named = ("-c", str(config)) if config else ()
    return CliRunner().invoke(listen, [*words, *named])


def objects(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def test_what_is_on_the_line_writes_nothing_of_its_own_into_a_terminal() -> None:
    frame = Frame(frame_types()["auv.AW"], b"@AW\0\1\0\1\x1b[2J$", 0, 0.0)
    assert "\x1b" not in as_line(Heard(0.0, frame, frame.raw), True)


@contextmanager
def saying(master: int, data: bytes, every: float = 0.2) -> Iterator[None]:
    over = threading.Event()

    def say() -> None:
        while not over.wait(every):
            os.write(master, data)

    thread = threading.Thread(target=say)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def test_every_frame_has_a_line_with_its_time_and_what_is_no_frame_is_a_fault() -> None:
    with silent_board() as (master, device), saying(master, ACK + NOISE):
        ran = listened(f"serial://{device}", "--link", "auv.from_stm32", "--for", "1", "--raw")
    assert ran.exit_code == 0
    lines = ran.stdout.splitlines()
    frame = next(at for at, line in enumerate(lines) if "auv.ACK" in line)
    assert lines[frame][2] == lines[frame][5] == ":"
    assert "class=Z func=X ok=True" in lines[frame]
    assert lines[frame + 1].strip() == ACK.hex(" ")
    fault = next(at for at, line in enumerate(lines) if "FAULT" in line)
    assert f"FAULT bad_header, {len(NOISE)} bytes" in lines[fault]
    assert lines[fault + 1].strip() == NOISE.hex(" ")


def test_a_program_reads_one_object_a_line() -> None:
    with silent_board() as (master, device), saying(master, ACK + NOISE):
        ran = listened(f"serial://{device}", "--link", "auv.from_stm32", "--for", "1", "--json")
    found = objects(ran.stdout)
    assert {one.get("type", one.get("fault")) for one in found} == {"auv.ACK", "bad_header"}
    assert all(one["time"].endswith("+00:00") for one in found)
    assert found[0]["values"]["code"] == "X"


@pytest.mark.parametrize(
    ("link", "query", "speed"),
    [
        ("auv.from_stm32", "", termios.B9600),
        ("auv.modem", "", termios.B115200),
        ("rov.up", "", termios.B115200),
        ("robot.up", "", termios.B115200),
        ("coreboard.main_to_pc", "", termios.B115200),
        ("rov.up", "?baud=57600", termios.B57600),
        ("gps", "", termios.B9600),
    ],
)
def test_a_port_is_opened_with_the_bit_rate_of_its_document(
    link: str, query: str, speed: int
) -> None:
    with silent_board() as (master, device):
        port = open_link("port", with_baud(f"serial://{device}{query}", link))
        assert termios.tcgetattr(master)[4:6] == [speed, speed]
        port.close()


def test_nothing_is_said_to_the_board() -> None:
    with silent_board() as (master, device):
        listened(f"serial://{device}", "--link", "auv.from_stm32", "--for", "0.3")
        assert read_now(master) == b""


def test_what_is_recorded_is_what_decode_reads_and_is_never_written_over(tmp_path: Path) -> None:
    file = tmp_path / "kept.bin"
    words = ("--link", "auv.from_stm32", "--for", "1", "--record", str(file))
    with silent_board() as (master, device), saying(master, ACK):
        ran = listened(f"serial://{device}", *words)
        kept = file.read_bytes()
        again = listened(f"serial://{device}", *words)
    assert kept == ACK * ran.stdout.count("auv.ACK")
    read = CliRunner().invoke(decode, ["--link", "auv.from_stm32", "--json", str(file)])
    assert len(objects(read.stdout)) == ran.stdout.count("auv.ACK") > 0
    assert again.exit_code == 2
    assert file.read_bytes() == kept


def test_a_can_bus_is_read_frame_by_frame_and_recorded_as_lines(tmp_path: Path) -> None:
    pytest.importorskip("can", reason="python-can is not installed: pip install auvmission[can]")
    record, file = bytes.fromhex("0001 07 FF001000200030"), tmp_path / "bus.txt"
    bus, url = open_link("board", "can://ear?interface=virtual"), "can://ear?interface=virtual"
    over = threading.Event()

    def say() -> None:
        while not over.wait(0.1):
            bus.send(record, 0.0)

    thread = threading.Thread(target=say)
    thread.start()
    try:
        ran = listened(
            url, "--link", "coreboard.can", "--for", "1", "--json", "--record", str(file)
        )
    finally:
        over.set()
        thread.join()
        bus.close()
    found = objects(ran.stdout)
    assert {one["type"] for one in found} == {"coreboard.CAN_FORCE"}
    assert set(file.read_text().splitlines()) == {"001#ff001000200030"}
    read = CliRunner().invoke(decode, ["--link", "coreboard.can", "--json", str(file)])
    assert len(objects(read.stdout)) == len(found)


def test_a_tcp_stream_is_read_to_its_end_and_its_end_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def say() -> None:
            peer, _ = server.accept()
            with peer:
                peer.sendall(b"@ACK_AAA$")

        thread = threading.Thread(target=say)
        thread.start()
        host, port = server.getsockname()
        ran = listened(f"tcp://{host}:{port}", "--link", "auv.to_topside", "--for", "20")
        thread.join()
    assert "auv.ACK" in ran.stdout
    assert ran.exit_code == 1


def test_a_port_that_is_not_there_says_so() -> None:
    ran = listened("serial:///dev/ttyNOSUCH", "--link", "auv.from_stm32")
    assert ran.exit_code == 1
    assert "no device /dev/ttyNOSUCH" in ran.stderr


@pytest.mark.proof
def test_where_a_serve_has_the_port_its_own_stream_is_shown_and_it_is_left_alone(
    tmp_path: Path,
) -> None:
    config = tmp_path / "serve.yaml"
    config.write_text(f"folder: {tmp_path / 'pi'}\n")
    with simulated(4.0) as sea:
        url = f"serial://{sea.paths[0]}"
        with running(tmp_path / "pi", url, speed=4.0) as pi, pi.boat() as boat:
            soon(lambda: (tmp_path / "pi" / "status.json").exists(), "its health")
            words = [url, "-c", str(config), "--for", "5", "--json", "--link"]
            ears = [started("listen", *words, f"auv.{way}") for way in ("from_stm32", "to_stm32")]
            for ear in ears:
                assert ear.stderr is not None
                assert "this is its own stream" in ear.stderr.readline()
            asked(boat, b"@ZAX0$")
            heard, said = (objects(ear.communicate(timeout=PATIENCE)[0]) for ear in ears)
            assert not pi.has_told("went away")
    assert {"auv.SD", "auv.ACK"} <= {one.get("type") for one in heard}
    assert {one["type"] for one in said} == {"auv.ZA"}
    assert {one["way"] for one in said} == {"out"}


@pytest.mark.parametrize(
    ("link", "types"),
    [
        ("coreboard.main_to_sensor", {"coreboard.MAIN_TO_SENSOR"}),
        ("coreboard.can", {"coreboard.CAN_FORCE", "coreboard.CAN_TORQUE"}),
    ],
)
def test_of_a_bus_and_a_line_that_are_one_link_each_is_heard_alone(
    tmp_path: Path, link: str, types: set[str]
) -> None:
    pytest.importorskip("can", reason="python-can is not installed: pip install auvmission[can]")
    config = tmp_path / "serve.yaml"
    config.write_text(f"folder: {tmp_path / 'pi'}\n")
    with silent_board() as (_, device):
        bus = f"can://{tmp_path.name}?interface=virtual&sensors={device}"
        with running(tmp_path / "pi", bus, kind="mainboard"):
            soon(lambda: (tmp_path / "pi" / "status.json").exists(), "its health")
            url = f"serial://{device}"  # one of the two names the link
            ran = listened(url, "--link", link, "--for", "1", "--json", config=config)
    assert "this is its own stream" in ran.stderr
    assert {one.get("type", one.get("fault")) for one in objects(ran.stdout)} == types


def started(*words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "mission", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_the_tail_of_a_black_box_gives_each_whole_record_once(tmp_path: Path) -> None:
    path = tmp_path / "box.mcap"
    box = BlackBox(path, shell=True)
    box.store(b"")
    tail = Tail(path)
    assert list(tail.read()) == []
    for number in range(3):
        box.record(fault_record(float(number), "vehicle", FrameFault(number, "truncated", 1)))
        whole = box.take()
        with path.open("ab") as file:
            file.write(whole[:-1])
        assert list(tail.read()) == []
        with path.open("ab") as file:
            file.write(whole[-1:])
        assert [record.t for record in tail.read()] == [float(number)]
    tail.close()
    (tmp_path / "other").write_bytes(b"no black box")
    with pytest.raises(BlackBoxError, match="no black box"):
        Tail(tmp_path / "other")


@pytest.mark.parametrize("clock", [0.0, 1e9])
def test_a_frame_that_is_cut_between_two_writings_is_whole_whatever_the_clock_says(
    tmp_path: Path, clock: float
) -> None:
    box = BlackBox(tmp_path / "box.mcap", 1000.0, shell=True)
    box.store(b"")
    pieces = [Rx(1.0, "vehicle", ACK[:4]), Rx(1.0, "gps", ACK), Rx(1.03, "vehicle", ACK[4:])]
    left = iter(pieces)

    def write(_: float) -> None:
        if (rx := next(left, None)) is not None:
            box.record(rx_record(rx, rx.t))
            box.store(box.take())

    paths = iter([box.path] * (len(pieces) + 1))
    times = (clock + n for n in range(1000))
    hearing = Hearing(link("auv.from_stm32"), Tolerances())
    heard = [
        one
        for rx in follow(lambda: next(paths, None), "vehicle", (IN,), lambda: next(times), write)
        for one in hearing.receive(rx)
    ]
    assert [(one.raw, round(one.t, 2)) for one in heard] == [(ACK, 1.0)]
    box.close()
