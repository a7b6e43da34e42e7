"""Laws of the shell: real sockets and pseudo-terminals, and nothing of what they do ends it."""

from __future__ import annotations

import asyncio
import json
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from links.serial import SerialLink
from links.simulated.link import SimulatedVehicle
from links.simulated.pty import PtyVehicle
from links.simulated.settings import Settings
from mission.blackbox import read_parts
from mission.commands.serve import serve as command
from mission.configuration import Configuration, LinkUrls
from mission.drive.drive import Drive
from mission.drive.records import RX, STEP, TX, read_rx, read_tx
from mission.language import digest, parse, script
from mission.operator.console import Unreachable, converse
from mission.operator.upload import start, status, upload
from mission.replay.replay import replay
from mission.serve import ports
from mission.serve import serve as shell
from mission.serve.serve import Ready, Server
from mission.store import DiskStore, MemoryStore, Store
from mission.vehicle import load_vehicle

TEXT = """mission pool vehicle auv
home 30.2874595 120.1535765
safety radius 400 time 20min depth 10 voltage 10
assume current 0.1
dive: depth 3 heading 0 gear 4 until depth >= 2.5 timeout 90
out: heading 90 gear 6 for 20s
up: surface timeout 3min
"""
MISSION = parse(TEXT)
LINES = script(MISSION)
PATIENCE = 8.0  # s, real


def soon(holds: Callable[[], bool], what: str, within: float = PATIENCE) -> None:
    end = time.monotonic() + within
    while not holds():
        assert time.monotonic() < end, f"not within {within} s: {what}"
        time.sleep(0.01)


class Running:
    """A server in a thread, on a free port of the loopback."""

    def __init__(
        self,
        folder: Path,
        vehicle: str,
        gps: str | None = None,
        store: Store | None = None,
        speed: float = 1.0,
        topside: str = "tcp://127.0.0.1:0",
        wait: bool = True,
        **more: object,
    ) -> None:
        links = LinkUrls(vehicle=vehicle, gps=gps, topside=topside)
        configuration = replace(Configuration(), links=links, folder=folder, **more)  # type: ignore[arg-type]
        self.told: list[str] = []
        self.ready: Ready | None = None
        self.server: Server | None = None
        self.store = store or DiskStore(configuration.store)
        self._configuration, self._speed = configuration, speed
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        if wait:
            soon(lambda: self.ready is not None or not self._thread.is_alive(), "listening")

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._main())
        self._loop.close()

    async def _main(self) -> None:
        self.server = Server(
            self._configuration,
            load_vehicle("auv"),
            self.store,
            self.told.append,
            self._announce,
            self._speed,
        )
        await self.server.run()

    def _announce(self, ready: Ready) -> None:
        self.ready = ready

    @property
    def url(self) -> str:
        assert self.ready is not None
        return self.ready.topside

    def boat(self) -> socket.socket:
        host, port = self.url.removeprefix("tcp://").split(":")
        return socket.create_connection((host, int(port)), timeout=PATIENCE)

    def has_told(self, words: str) -> bool:
        return any(words in line for line in self.told)

    def stop(self) -> None:
        if self.server is not None and self._thread.is_alive():
            self._loop.call_soon_threadsafe(self.server.stop)
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()


@contextmanager
def running(folder: Path, vehicle: str, **more: object) -> Iterator[Running]:
    server = Running(folder, vehicle, **more)  # type: ignore[arg-type]
    try:
        yield server
    finally:
        server.stop()


@contextmanager
def silent_board() -> Iterator[tuple[int, str]]:
    """A pseudo-terminal that nobody answers on: its own end, and the device."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    try:
        yield master, os.ttyname(slave)
    finally:
        os.close(master)
        os.close(slave)


def read_now(master: int) -> bytes:
    try:
        return os.read(master, 4096)
    except BlockingIOError:
        return b""


@contextmanager
def simulated(speed: float) -> Iterator[PtyVehicle]:
    vehicle = PtyVehicle(SimulatedVehicle("as-built", 0, Settings()), speed)
    over = threading.Event()
    thread = threading.Thread(target=vehicle.run, kwargs={"stop": over.is_set})
    thread.start()
    try:
        yield vehicle
    finally:
        over.set()
        thread.join(PATIENCE)
        vehicle.close()


def asked(boat: socket.socket, frame: bytes, until: bytes = b"$") -> bytes:
    boat.sendall(frame)
    heard = b""
    while not heard.endswith(until):
        piece = boat.recv(4096)
        assert piece, "the server hung up"
        heard += piece
    return heard


def quiet(have: int, total: int) -> None:
    """Nobody watches."""


def test_a_mission_goes_over_tcp_and_serial_and_its_black_box_replays(tmp_path: Path) -> None:
    with simulated(16.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path, stm32, gps=gps, speed=16.0) as pi:
            stored = converse(pi.url, upload(script(MISSION), digest(MISSION), quiet))
            assert stored.startswith("7 lines stored")
            assert converse(pi.url, start(patience=8)) == "started"
            soon(lambda: sea.vehicle.truth().depth > 1.0, "diving")
            assert pi.ready is not None
            path = Path(pi.ready.black_box)
    records = list(read_parts(path))
    assert any(r.kind == STEP and b"autonomous/dive" in r.payload for r in records)
    assert {read_tx(r).link for r in records if r.kind == TX} == {"vehicle", "topside"}
    result = replay(records)
    assert result.identical, result.divergence
    assert pi.has_told("stopped in autonomous/")


def test_an_upload_that_was_cut_is_resumed_over_a_new_connection(tmp_path: Path) -> None:
    lines = script(MISSION)
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        boat = pi.boat()
        for number in (1, 2, 3):
            frame = b"@AW" + bytes([len(lines), 0, number, 0]) + lines[number - 1].encode() + b"$"
            assert asked(boat, frame) == b"@ACK_AWW$"
        boat.sendall(b"@AW" + bytes([len(lines), 0, 4, 0]) + b"assume cur")
        boat.close()
        have: list[int] = []
        converse(pi.url, upload(lines, digest(MISSION), lambda n, _: have.append(n)))
        assert have[0] == 3
        assert pi.store.content.lines == tuple(lines)


def test_garbage_on_every_link_stops_nothing(tmp_path: Path) -> None:
    chance = random.Random(3)
    with silent_board() as (stm32, device), silent_board() as (gps, other):
        with running(tmp_path, f"serial://{device}", gps=f"serial://{other}") as pi:
            for _ in range(30):
                noise = chance.randbytes(400)
                os.write(stm32, noise)
                os.write(gps, noise[::-1])
                with pi.boat() as boat:
                    boat.sendall(noise)
            with pi.boat() as boat:
                boat.sendall(b"@SD" * 50 + b"@AW\x05")
                soon(lambda: b"@AR,empty" in asked(boat, b"@AQ$"), "an answer to @AQ")
        assert not pi.has_told("fault of the program")
    assert pi.ready is not None
    heard = [read_rx(r) for r in read_parts(Path(pi.ready.black_box)) if r.kind == RX]
    assert {rx.link for rx in heard} == {"vehicle", "gps", "topside"}


def test_a_board_that_does_not_answer_is_asked_again_and_the_boat_still_served(
    tmp_path: Path,
) -> None:
    with (
        silent_board() as (master, device),
        running(tmp_path, f"serial://{device}") as pi,
        pi.boat() as boat,
    ):
        boat.sendall(b"@ZAX0$")
        heard = bytearray()

        def read() -> bool:
            heard.extend(read_now(master))
            return heard.count(b"@ZAX0$") >= 3

        soon(read, "three tries of X")
        assert asked(boat, b"@AQ$").startswith(b"@AR,running")


def test_a_port_that_is_absent_is_told_once_and_taken_when_it_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ports, "RETRY_S", 0.1)
    device = tmp_path / "ttyAUV"
    with silent_board() as (master, real), running(tmp_path, f"serial://{device}") as pi:
        soon(lambda: pi.has_told("no device"), "a message")
        time.sleep(0.5)
        assert sum("no device" in line for line in pi.told) == 1
        device.symlink_to(real)
        soon(lambda: pi.has_told("is open"), "the port")
        os.write(master, b"@ACK_ZAY$")
        path = Path(pi.ready.black_box) if pi.ready else tmp_path
        soon(lambda: any(r.kind == RX and b"ZAY" in r.payload for r in read_parts(path)), "bytes")


def test_a_port_that_is_busy_is_told_and_taken_when_it_is_free(tmp_path: Path) -> None:
    with silent_board() as (_, device):
        first = SerialLink("other", device)
        with running(tmp_path, f"serial://{device}") as pi:
            soon(lambda: pi.has_told("in use by another program"), "a message")
            first.close()
            soon(lambda: pi.has_told("is open"), "the port")


def test_what_was_under_way_surfaces_after_a_restart(tmp_path: Path) -> None:
    store = MemoryStore()
    store.keep_under_way("autonomous/out")
    with (
        silent_board() as (master, device),
        running(tmp_path, f"serial://{device}", store=store),
    ):
        heard = bytearray()

        def read() -> bool:
            heard.extend(read_now(master))
            return b"@ZAWF$" in heard

        soon(read, "W")


def test_serve_that_is_ended_in_a_mission_leaves_a_vehicle_that_is_stopped(tmp_path: Path) -> None:
    with simulated(4.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        heard: list[bytes] = []
        really = sea.vehicle.stm32.receive

        def hear(data: bytes, now: float) -> None:
            heard.append(data)
            really(data, now)

        sea.vehicle.stm32.receive = hear  # type: ignore[method-assign]
        with running(tmp_path, stm32, gps=gps, speed=4.0) as pi:
            converse(pi.url, upload(script(MISSION), digest(MISSION), quiet))
            converse(pi.url, start(patience=60))
            soon(lambda: b"@ZAS3$" in heard, "the mission")
        assert pi.has_told("stopped in autonomous/")
        assert b"".join(heard).endswith(b"@ZAX0$")
        assert pi.store.content.under_way.startswith("emergency"), "the next one surfaces"
        assert pi.ready is not None
        assert replay(list(read_parts(Path(pi.ready.black_box)))).identical


def test_the_first_w_after_a_restart_is_not_lost_on_a_port_that_is_about_to_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opening = threading.Event()
    really = ports.open_link

    def slowly(name: str, url: str) -> object:
        if name == "vehicle":
            assert opening.wait(PATIENCE)
        return really(name, url)

    monkeypatch.setattr(ports, "open_link", slowly)
    monkeypatch.setattr(shell, "FIRST_S", PATIENCE)
    store = MemoryStore()
    store.keep_under_way("autonomous/out")
    with silent_board() as (master, device):
        pi = Running(tmp_path, f"serial://{device}", store=store, wait=False)
        threading.Timer(0.5, opening.set).start()
        heard = bytearray()

        def read() -> bool:
            heard.extend(read_now(master))
            return b"@ZAWF$" in heard

        soon(read, "W")
        pi.stop()
    assert not pi.has_told("NOT SENT")


def test_a_port_that_stays_away_keeps_serve_from_nothing(tmp_path: Path) -> None:
    with running(tmp_path, f"serial://{tmp_path}/absent") as pi, pi.boat() as boat:
        assert asked(boat, b"@AQ$").startswith(b"@AR,empty")
        boat.sendall(b"@ZAX0$")
        soon(lambda: pi.has_told("NOT SENT, the port is closed: @ZAX0$"), "the truth")


def test_a_fault_of_the_program_begins_another_drive_that_surfaces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    really = Drive.receive

    def receive(drive: Drive, rx: object, now: float | None = None) -> object:
        if b"boom" in rx.data:  # type: ignore[attr-defined]
            raise ZeroDivisionError("a bug")
        return really(drive, rx, now)  # type: ignore[arg-type]

    monkeypatch.setattr(Drive, "receive", receive)
    monkeypatch.setattr(shell, "REBIRTH_S", 0.1)
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}") as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@AQ$").startswith(b"@AR,")
        boat.sendall(b"boom")
        soon(lambda: pi.has_told("a bug"), "the fault")
        soon(lambda: len(list((tmp_path / "log").iterdir())) == 2, "another black box")
        assert asked(boat, b"@AQ$").startswith(b"@AR,")
    assert all(replay(list(read_parts(p))).identical for p in (tmp_path / "log").iterdir())


def test_what_was_recorded_before_a_stop_is_in_the_file_however_slow_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.serve.health.write", lambda *_: time.sleep(1.0))
    monkeypatch.setattr("mission.serve.health.EVERY_S", 0.01)
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        with pi.boat() as boat:
            for _ in range(4):
                asked(boat, b"@AQ$")
                time.sleep(0.12)
        assert pi.ready is not None
    records = list(read_parts(Path(pi.ready.black_box)))
    asks = [r for r in records if r.kind == RX and r.payload.endswith(b"@AQ$")]
    assert len(asks) == 4
    assert replay(records).identical


def test_a_disk_that_takes_nothing_stops_nothing(tmp_path: Path) -> None:
    (tmp_path / "log").write_text("a file where the folder should be")
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        assert pi.has_told("nothing will be recorded")
        with pi.boat() as boat:
            assert asked(boat, b"@AQ$").startswith(b"@AR,empty")


def test_systemd_hears_ready_and_the_steps_of_the_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    manager.bind(str(tmp_path / "notify"))
    manager.settimeout(PATIENCE)
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    monkeypatch.setenv("WATCHDOG_USEC", "600000")
    with manager:
        with silent_board() as (_, device), running(tmp_path, f"serial://{device}"):
            heard = [manager.recv(100) for _ in range(6)]
        while heard[-1] != b"STOPPING=1":
            heard.append(manager.recv(100))
    assert b"READY=1" in heard
    assert heard.count(b"WATCHDOG=1") >= 4


def test_the_camera_node_runs_its_command_and_stops_it(tmp_path: Path) -> None:
    flag = tmp_path / "camera.pid"
    command = f"sh -c 'echo $$ > {flag}; exec sleep 100'"
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera=command) as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$"
        soon(lambda: flag.exists() and flag.read_text().strip() != "", "the camera")
        number = int(flag.read_text())
        os.kill(number, 0)
        assert asked(boat, b"@NSOOCCCO$") == b"@ACK_NSS$"
        with pytest.raises(ProcessLookupError):
            os.kill(number, 0)


def test_a_camera_that_ends_by_itself_is_told_and_no_longer_called_open(tmp_path: Path) -> None:
    end = tmp_path / "end"
    command = f"sh -c 'while [ ! -e {end} ]; do sleep 0.05; done; exit 7'"
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera=command) as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$"
        assert asked(boat, b"@NI$") == b"@ACK_NI\x33$"
        end.touch()
        soon(lambda: pi.has_told("exit code 7 by itself"), "the end")
        assert asked(boat, b"@NI$") == b"@ACK_NI\x23$"
        end.unlink()
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$", "and can be opened again"


def test_a_camera_that_fails_at_once_is_never_called_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.drive.nodes.CHANGED_WITHIN_S", 1.0)
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera="false") as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSN$"
        assert pi.has_told("exit code 1 at once")


def test_what_a_camera_started_ends_with_it(tmp_path: Path) -> None:
    flag = tmp_path / "child.pid"
    command = f"sh -c 'sleep 1000 & echo $! > {flag}; wait'"
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera=command) as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$"
        soon(lambda: flag.exists() and flag.read_text().strip() != "", "the camera")
        number = int(flag.read_text())
        assert asked(boat, b"@NSOOCCCO$") == b"@ACK_NSS$"
        soon(lambda: not is_alive(number), "its child is gone, too")


def is_alive(number: int) -> bool:
    """A zombie that nobody collects is not."""
    try:
        state = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_a_second_server_on_the_same_port_says_so_and_waits(tmp_path: Path) -> None:
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        told: list[str] = []
        links = LinkUrls(vehicle=f"serial://{device}", gps=None, topside=pi.url)
        configuration = replace(Configuration(), links=links, folder=tmp_path / "second")
        second = Server(configuration, load_vehicle("auv"), MemoryStore(), told.append)

        async def briefly() -> None:
            task = asyncio.ensure_future(second.run())
            await asyncio.sleep(0.4)
            second.stop()
            await task

        asyncio.run(briefly())
        assert any("is in use by another program" in line for line in told)


def test_where_nobody_listens_the_operator_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with pytest.raises(Unreachable, match="nobody answers"):
        converse(f"tcp://127.0.0.1:{port}", start())


def test_the_program_tells_a_parent_where_it_listens_and_ends_by_sigterm(tmp_path: Path) -> None:
    ready = tmp_path / "ready.json"
    with silent_board() as (_, device):
        call = [
            sys.executable,
            "-c",
            "from mission.cli import main; main()",
            "serve",
            "--vehicle",
            f"serial://{device}",
        ]
        call += ["--gps", "none", "--topside", "tcp://127.0.0.1:0", "--folder", str(tmp_path)]
        child = subprocess.Popen(
            [*call, "--ready-file", str(ready)], stdout=subprocess.PIPE, text=True
        )
        with child:
            try:
                soon(ready.exists, "the ready file")
                where = json.loads(ready.read_text())
                assert converse(where["topside"], status(lambda *_: None)) == ""
            finally:
                child.send_signal(signal.SIGTERM)
            said, _ = child.communicate(timeout=PATIENCE)
    assert child.returncode == 0
    assert where["topside"] in said
    assert replay(list(read_parts(Path(where["black_box"])))).identical


@pytest.mark.parametrize(
    ("option", "url", "words"),
    [
        ("--vehicle", "serail:///dev/tty0", "is no link's URL"),
        ("--topside", "tcp://127.0.0.1", "write tcp-listen://host:port"),
        ("--vehicle", "serial://dev/tty0", "write three slashes"),
    ],
)
def test_a_wrong_link_ends_the_program_with_what_to_write(
    option: str, url: str, words: str, tmp_path: Path
) -> None:
    base = ["--topside", "tcp://127.0.0.1:0", "--vehicle", f"serial://{tmp_path}/tty"]
    given = [*base, "--gps", "none", "--folder", str(tmp_path), option, url]
    ran = CliRunner().invoke(command, given)
    assert ran.exit_code == 2
    assert words in ran.output
