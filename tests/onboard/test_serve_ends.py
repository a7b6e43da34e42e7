"""How serve begins and ends: after a restart, a fault of its own, at a stop; and who is told."""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from served import (
    MISSION,
    PATIENCE,
    Running,
    asked,
    quiet,
    read_now,
    running,
    silent_board,
    simulated,
    soon,
)

from links.base import Rx
from links.simulated.pty import PtyVehicle
from mission.analysis.replay.replay import replay
from mission.authoring.language import digest, script
from mission.engine.restart import STOPS, UNANSWERED
from mission.model import STOPPED, SURFACED, SURFACING, Tx
from mission.model.shipped import load_vehicle
from mission.onboard.blackbox import BlackBox, read_parts
from mission.onboard.configuration import Configuration
from mission.onboard.kept import Homes
from mission.onboard.runtime.records import RX, TX, read_rx, read_tx
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve import ports
from mission.onboard.serve import serve as shell
from mission.onboard.serve.rate_limiter import BREAK
from mission.onboard.serve.serve import Server
from mission.onboard.serve.watchdog import Watchdog
from mission.onboard.store import MemoryStore, Stored
from mission.topside.console import converse
from mission.topside.upload import start, status, upload


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
            return b"@ZAU12$" in heard

        soon(read, "an upward word")


def test_the_first_word_of_a_restart_waits_for_no_card(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file of its black box is made when the card lets it, and has that word then."""
    hangs, goes_on, really = threading.Event(), threading.Event(), os.open

    def hang(path: str | Path, *how: Any, **more: Any) -> int:
        if str(path).endswith(".mcap") and not goes_on.is_set():
            hangs.set()
            assert goes_on.wait(PATIENCE)
        return really(path, *how, **more)

    monkeypatch.setattr("mission.onboard.blackbox.box.os.open", hang)
    store, heard = MemoryStore(Stored(under_way="autonomous/out")), bytearray()

    def is_said() -> bool:
        heard.extend(read_now(master))
        return b"@ZAU12$" in heard

    with silent_board() as (master, device):
        with running(tmp_path, f"serial://{device}", store=store) as pi:
            try:
                soon(is_said, "an upward word")
                assert hangs.wait(PATIENCE)
                assert pi.ready is not None
                assert not Path(pi.ready.black_box).exists()
            finally:
                goes_on.set()
        assert replays(pi)
    told = [read_tx(r).data for r in read_parts(Path(pi.ready.black_box)) if r.kind == TX]
    assert b"@ZAU12$" in told


def test_an_upward_word_of_a_restart_waits_for_no_card_that_has_what_worked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hangs, goes_on = threading.Event(), threading.Event()

    def hang(_: Homes) -> None:
        hangs.set()
        assert goes_on.wait(PATIENCE)

    monkeypatch.setattr("mission.onboard.serve.recording.find", hang)
    store, heard = MemoryStore(Stored(under_way="autonomous/out")), bytearray()

    def is_said() -> bool:
        heard.extend(read_now(master))
        return b"@ZAU12$" in heard

    with (
        silent_board() as (master, device),
        running(tmp_path, f"serial://{device}", store=store, wait=False),
    ):
        try:
            assert hangs.wait(PATIENCE)
            soon(is_said, "an upward word", within=PATIENCE / 2)
        finally:
            goes_on.set()


@contextmanager
def diving(folder: Path, leave_within: float) -> Iterator[tuple[Running, PtyVehicle, list[bytes]]]:
    """A serve in a mission, at more than 1.5 m; and what the STM32 hears."""
    with simulated(4.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        heard: list[bytes] = []
        really = sea.vehicle.stm32.receive

        def hear(data: bytes, now: float) -> None:
            heard.append(data)
            really(data, now)

        sea.vehicle.stm32.receive = hear  # type: ignore[method-assign]
        with running(folder, stm32, gps=gps, speed=4.0, leave_within=leave_within) as pi:
            converse(pi.url, upload(script(MISSION), digest(MISSION), quiet))
            converse(pi.url, start(patience=60))
            soon(lambda: sea.vehicle.truth().depth > 1.5, "the dive")
            yield pi, sea, heard


def is_upward(heard: list[bytes]) -> bool:
    said = b"".join(heard)
    return b"@ZAWF$" in said or b"@ZAU12$" in said


def last_of(heard: list[bytes], count: int) -> list[bytes]:
    """The last words; one that is tried again counts once."""
    words = b"".join(heard).replace(b"$", b"$ ").split()
    return [word for word, _ in itertools.groupby(words)][-count:]


def replays(pi: Running) -> bool:
    assert pi.ready is not None
    return replay(list(read_parts(Path(pi.ready.black_box)))).identical


@pytest.mark.proof
def test_serve_that_is_ended_in_a_mission_brings_the_vehicle_up_and_stops_it_first(
    tmp_path: Path,
) -> None:
    with diving(tmp_path, PATIENCE) as (pi, sea, heard):
        before = len(heard)
        pi.stop()
        assert sea.vehicle.truth().depth < 0.5
    assert is_upward(heard[before:])
    assert last_of(heard, 1) == [b"@ZAX0$"]
    assert pi.has_told("serve ends when the vehicle is at the surface")
    assert pi.store.content.under_way == SURFACED, "the next one turns nothing"
    assert replays(pi)


def next_one(pi: Running) -> str:
    """In which state a further program begins."""
    return Runtime(Configuration(), load_vehicle("auv"), MemoryStore(pi.store.content)).state


@pytest.mark.replaces
def test_serve_that_has_no_time_to_bring_the_vehicle_up_leaves_its_thrust_upward(
    tmp_path: Path,
) -> None:
    with diving(tmp_path, 0.0) as (pi, sea, heard):
        pi.stop()
        assert last_of(heard, 2) == [b"@ZAX0$", b"@ZAU12$"]
        soon(lambda: sea.vehicle.truth().depth < 0.5, "up, with nobody there")
    assert pi.has_told("serve ends before the surface is proved")
    assert next_one(pi) == SURFACING, "it goes on"
    assert replays(pi)


@pytest.mark.replaces
def test_told_to_end_twice_serve_ends_at_once_with_its_last_words(tmp_path: Path) -> None:
    with diving(tmp_path, PATIENCE) as (pi, _, heard):
        pi.tell_to_end()
        soon(lambda: is_upward(heard), "on its way up")
        pi.stop()
        assert last_of(heard, 2) == [b"@ZAX0$", b"@ZAU12$"]
    assert replays(pi)


@pytest.mark.replaces
def test_told_to_end_twice_behind_a_fault_serve_says_its_last_words_by_the_next_runtime(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with diving(tmp_path, PATIENCE) as (pi, _, heard):
        with monkeypatch.context() as patch:
            patch.setattr(Runtime, "handle_timer", lambda *_: 1 // 0)
            soon(lambda: pi.has_told("a fault of the program"), "the fault")
            pi.tell_to_end()
        pi.stop()
        assert last_of(heard, 2) == [b"@ZAX0$", b"@ZAU12$"]
    assert next_one(pi) == SURFACING


@pytest.mark.replaces
def test_while_serve_ends_the_operator_is_heard_and_no_mission_starts(tmp_path: Path) -> None:
    with diving(tmp_path, PATIENCE) as (pi, _, heard):
        with pi.boat() as boat:
            pi.tell_to_end()
            soon(lambda: is_upward(heard), "on its way up")
            assert asked(boat, b"@AA$") == b"@ACK_AAN$"
            boat.sendall(b"@ZAX0$")
            soon(lambda: last_of(heard, 1) == [b"@ZAX0$"], "the operator's X")
        pi.stop()
    assert replays(pi)


@pytest.mark.parametrize("during", ["", STOPPED, SURFACED, *STOPS])
def test_serve_that_is_ended_and_begun_again_on_deck_turns_no_thruster(
    tmp_path: Path, during: str
) -> None:
    store = MemoryStore(Stored(under_way=during))
    for _ in range(2):
        with silent_board() as (master, device):
            vehicle = f"serial://{device}"
            with running(tmp_path, vehicle, store=store, speed=60.0, leave_within=PATIENCE):
                time.sleep(0.5)
            heard = read_now(master)
        assert heard == (b"@ZAX0$" * len(heard))[: len(heard)], "and the last may be cut"
        assert bool(heard) == bool(during)
        assert store.content.under_way == (UNANSWERED if during in STOPS else during)


def test_the_first_word_after_a_restart_is_not_lost_on_a_port_that_is_about_to_open(
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
            return b"@ZAU12$" in heard

        soon(read, "an upward word")
        pi.stop()
    assert not pi.has_told("NOT SENT")


@pytest.fixture
def boom(monkeypatch: pytest.MonkeyPatch) -> bytes:
    """What a bug of the program does not bear."""
    really = Runtime.receive

    def receive(runtime: Runtime, rx: Rx, now: float | None = None) -> list[Tx]:
        if b"boom" in rx.data:
            raise ZeroDivisionError("a bug")
        return really(runtime, rx, now)

    monkeypatch.setattr(Runtime, "receive", receive)
    return b"boom"


def test_a_fault_of_the_program_begins_another_drive_that_surfaces(
    boom: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shell, "REBIRTH_S", 0.1)
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}") as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@AQ$").startswith(b"@AR,")
        boat.sendall(boom)
        soon(lambda: pi.has_told("ZeroDivisionError: a bug"), "the fault")
        assert not pi.has_told("raise ZeroDivisionError"), "the card that has the source may hang"
        soon(lambda: len(list((tmp_path / "log").glob("*"))) == 2, "another black box")
        assert asked(boat, b"@AQ$").startswith(b"@AR,")
    assert all(replay(list(read_parts(p))).identical for p in (tmp_path / "log").glob("*"))


class Patient(Server):
    """Behind a fault of the program it waits for a word of topside before it begins again."""

    _said = asyncio.Event()

    async def _begin_again(self) -> None:
        self._said = asyncio.Event()
        await self._said.wait()
        await super()._begin_again()

    def _hear(self, rx: Rx) -> None:
        super()._hear(rx)
        if rx.link == "topside":
            self._said.set()


@pytest.mark.replaces
@pytest.mark.parametrize(
    ("during", "order", "others"),
    [("autonomous/out", b"@ZAX0$", set()), (STOPPED, b"@ZAWF$", {b"@ZAX0$", b"@ZAU12$"})],
)
def test_an_order_between_a_fault_of_the_program_and_the_next_runtime_is_obeyed_by_that(
    boom: bytes, during: str, order: bytes, others: set[bytes], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr("served.Server", Patient)
    monkeypatch.setattr(shell, "REBIRTH_S", 0.0)
    store = MemoryStore(Stored(under_way=during))
    with simulated(1.0) as sea:
        stm32, _ = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path, stm32, store=store) as pi, pi.boat() as boat:
            boat.sendall(boom)
            soon(lambda: pi.has_told("a fault of the program"), "the fault")
            answer = asked(boat, b"@AQ$" + order + b"@MMF5$")
            assert answer.startswith(b"@ACK_Z" + order[3:4])
            assert pi.ready is not None
    (path,) = set((tmp_path / "log").glob("*.mcap")) - {Path(pi.ready.black_box)}
    records = list(read_parts(path))
    heard = [rx.data for r in records if r.kind == RX and (rx := read_rx(r)).link == "topside"]
    said = {tx.data for r in records if r.kind == TX and (tx := read_tx(r)).link == "vehicle"}
    assert heard == [BREAK + order]
    assert said - others == {order}
    assert replay(records).identical


def test_whoever_says_an_order_to_no_runtime_and_hangs_up_commands_no_more(
    boom: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("served.Server", Patient)
    monkeypatch.setattr(shell, "REBIRTH_S", 0.3)
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        with pi.boat() as boat:
            boat.sendall(boom)
            soon(lambda: pi.has_told("a fault of the program"), "the fault")
            boat.sendall(b"@ZAX0$")
        soon(lambda: pi.has_told("emergency/stopped"), "the order is obeyed")
        with pi.boat() as other:
            assert asked(other, b"@NSOOCCCO$") == b"@ACK_NSS$"


def test_behind_a_fault_of_the_program_orders_do_not_wait_for_the_disk_nor_does_it_lose_a_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ordered, closed = threading.Event(), threading.Event()
    really = BlackBox.close

    def close(box: BlackBox) -> None:
        ordered.wait(PATIENCE / 2)
        really(box)
        closed.set()

    monkeypatch.setattr(BlackBox, "close", close)
    monkeypatch.setattr(shell, "REBIRTH_S", 0.1)
    with (
        silent_board() as (master, device),
        running(tmp_path, f"serial://{device}") as pi,
        pi.boat() as boat,
    ):
        with monkeypatch.context() as patch:
            patch.setattr(Runtime, "receive", lambda *_: 1 // 0)
            boat.sendall(b"@NI$")
            soon(lambda: pi.has_told("a fault of the program"), "the fault")

        def is_obeyed() -> bool:
            boat.sendall(b"@ZAX0$")
            return b"@ZAX0$" in read_now(master)

        soon(is_obeyed, "the operator's X")
        assert not closed.is_set()
        ordered.set()
    assert all(replay(list(read_parts(p))).identical for p in (tmp_path / "log").glob("*"))


@pytest.mark.replaces
def test_behind_a_fault_of_the_program_the_nodes_are_as_at_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shell, "REBIRTH_S", 0.1)
    with (
        silent_board() as (master, device),
        running(tmp_path, f"serial://{device}", camera="sleep 100") as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOCCCOC$") == b"@ACK_NSS$", "STM32 and AUTO closed, CAMERA open"
        with monkeypatch.context() as patch:
            patch.setattr(Runtime, "receive", lambda *_: 1 // 0)
            boat.sendall(b"@NI$")
            soon(lambda: pi.has_told("a fault of the program"), "the fault")
        soon(lambda: len(list((tmp_path / "log").glob("*"))) == 2, "another black box")
        assert asked(boat, b"@NI$") == b"@ACK_NI\x23$"
        boat.sendall(b"@ZAX0$")
        heard = bytearray()

        def stopped() -> bool:
            heard.extend(read_now(master))
            return b"@ZAX0$" in heard

        soon(stopped, "the operator's X")
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$", "the camera can be opened again"


def test_what_was_recorded_before_a_stop_is_in_the_file_however_slow_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.onboard.serve.health.write", lambda *_: time.sleep(1.0))
    monkeypatch.setattr("mission.onboard.serve.health.EVERY_S", 0.01)
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        with pi.boat() as boat:
            for _ in range(4):
                asked(boat, b"@AQ$")
                time.sleep(0.12)
        assert pi.ready is not None
    records = list(read_parts(Path(pi.ready.black_box)))
    asks = [r for r in records if r.kind == RX and read_rx(r).data.endswith(b"@AQ$")]
    assert len(asks) == 4
    assert replay(records).identical


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


def test_a_service_manager_that_reads_nothing_holds_nobody_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may have died."""
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    watchdog = Watchdog()

    def notify() -> None:
        for _ in range(2000):  # more than wait anywhere
            watchdog.ready()

    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        at_work = threading.Thread(target=notify)
        at_work.start()
        at_work.join(PATIENCE)
        assert not at_work.is_alive()
        assert manager.recv(100) == b"READY=1"


def test_that_it_is_ready_is_said_until_the_service_manager_takes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    monkeypatch.setenv("WATCHDOG_USEC", "3000000")
    watchdog = Watchdog()
    watchdog.ready()  # nobody is there
    watchdog.fed(1.0)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        watchdog.fed(1.1)
        watchdog.fed(3.0)
        assert [manager.recv(100) for _ in range(2)] == [b"READY=1", b"WATCHDOG=1"]


@pytest.mark.proof
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


def test_a_wall_clock_that_jumps_decides_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when a GPS or a boat sets it, back and forth by years."""
    jumps = itertools.cycle([1.7e9, 0.0, 4.0e9, 1.7e9 - 3600.0])
    monkeypatch.setattr(shell.time, "time", lambda: next(jumps))
    with silent_board() as (master, device), running(tmp_path, f"serial://{device}") as pi:
        with pi.boat() as boat:
            for order in (b"@ZAX0$", b"@ZAWF$"):
                boat.sendall(order)
                heard = bytearray()

                def tried_again(order: bytes = order, heard: bytearray = heard) -> bool:
                    heard.extend(read_now(master))
                    return heard.count(order) >= 2

                soon(tried_again, "timers run as before")
            assert asked(boat, b"@AQ$").startswith(b"@AR,running")
        assert pi.ready is not None
    assert not pi.has_told("fault")
    assert replay(list(read_parts(Path(pi.ready.black_box)))).identical
