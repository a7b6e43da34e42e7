"""Laws of the shell: real sockets and pseudo-terminals, and nothing of what they do ends it."""

from __future__ import annotations

import asyncio
import json
import os
import random
import socket
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from ports import free_port
from served import (
    MISSION,
    PATIENCE,
    Running,
    asked,
    looked_into,
    provided,
    quiet,
    read_now,
    running,
    silent_board,
    simulated,
    soon,
)

from links.serial import SerialLink
from mission.analysis.replay.replay import replay
from mission.authoring.language import digest, script
from mission.commands.serve import serve as command
from mission.model import Record
from mission.onboard.blackbox import read_parts
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.runtime.command_target import MissionRefused
from mission.onboard.runtime.records import (
    CONNECTED,
    DISCONNECTED,
    RX,
    STEP,
    TIMER,
    TX,
    read_rx,
    read_tx,
)
from mission.onboard.serve import ports
from mission.onboard.serve.serve import Server
from mission.onboard.store import MemoryStore, Stored
from mission.topside.console import Unreachable, converse
from mission.topside.upload import start, upload
from protocol.modem import Sender, wrap

SPEED = 4.0  # a process that waits for the processor for a second misses no report by R8


def test_a_mission_goes_over_tcp_and_serial_and_its_black_box_replays(tmp_path: Path) -> None:
    with simulated(SPEED) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path, stm32, gps=gps, speed=SPEED) as pi:
            stored = converse(pi.url, upload(script(MISSION), digest(MISSION), quiet))
            assert stored.startswith("7 lines stored")
            assert converse(pi.url, start(patience=int(PATIENCE))) == "started"
            soon(lambda: sea.vehicle.truth().depth > 1.0, "diving")
            assert pi.ready is not None
            path = Path(pi.ready.black_box)
    records = list(read_parts(path))
    assert any(r.kind == STEP and b"autonomous/dive" in r.payload for r in records)
    assert {read_tx(r).link for r in records if r.kind == TX} == {"vehicle", "topside"}
    result = replay(records)
    assert result.identical, result.divergence


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


def recorded(pi: Running) -> list[Record]:
    assert pi.ready is not None
    return list(read_parts(Path(pi.ready.black_box)))


def test_behind_a_stall_the_vehicle_is_heard_before_whoever_spoke_first(tmp_path: Path) -> None:
    with (
        silent_board() as (stm32, device),
        silent_board() as (gps, other),
        looked_into(device) as stm32_waits,
        looked_into(other) as gps_waits,
        running(tmp_path, f"serial://{device}", gps=f"serial://{other}") as pi,
    ):

        def links_of(data: bytes) -> list[str]:
            heard = (read_rx(r) for r in recorded(pi) if r.kind == RX)
            return [rx.link for rx in heard if data in rx.data]

        def stall() -> None:
            for master, it_waits in ((gps, gps_waits), (stm32, stm32_waits)):
                os.write(master, b"late")
                soon(it_waits, "its bytes")

        for master in (stm32, gps):
            os.write(master, b"early")
        soon(lambda: set(links_of(b"early")) == {"gps", "vehicle"}, "both ports")
        pi.call(stall)
        soon(lambda: len(links_of(b"late")) == 2, "what has waited")
        assert links_of(b"late") == ["vehicle", "gps"]


def test_behind_a_stall_what_has_waited_is_heard_before_anything_that_is_due(
    tmp_path: Path,
) -> None:
    """An answer of the board, before the word is said again."""
    begun: list[float] = []
    with (
        silent_board() as (master, device),
        looked_into(device) as it_waits,
        running(tmp_path, f"serial://{device}", speed=60.0) as pi,
        pi.boat() as boat,
    ):

        def stall() -> None:
            assert pi.server is not None
            begun.append(pi.server.now())
            os.write(master, b"@ACK_ZAY$")
            soon(it_waits, "its bytes")

        def stall_when_a_word_is_due() -> None:
            time.sleep(0.2)  # it is said again every 2 s, of which 60 pass in one
            asyncio.get_running_loop().call_soon(stall)

        boat.sendall(b"@ZAX0$")
        soon(lambda: b"@ZAX0$" in read_now(master), "the stop")
        pi.call(stall_when_a_word_is_due)
        soon(lambda: any(b"@ACK_ZAY$" in r.payload for r in recorded(pi)), "the answer")
    behind = (r for r in recorded(pi) if r.kind in (RX, TIMER) and r.t > begun[0])
    assert next(behind).kind == RX


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


def test_the_modem_is_a_way_to_operators_before_any_has_spoken_and_until_it_is_closed(
    tmp_path: Path,
) -> None:
    """R11: the unasked @VS goes there, too."""
    with (
        silent_board() as (_, device),
        silent_board() as (_, modem),
        running(tmp_path, f"serial://{device}", modem=f"serial://{modem}") as pi,
        pi.boat() as boat,
    ):
        soon(lambda: modem_is_open(tmp_path), "the modem")
        assert asked(boat, b"@NSOOCCCO$") == b"@ACK_NSS$"
        soon(lambda: not modem_is_open(tmp_path), "the modem's end")
        assert asked(boat, b"@NSOOCOCO$") == b"@ACK_NSS$"
        soon(lambda: modem_is_open(tmp_path), "the modem again")
    came, left = (CONNECTED, ""), (DISCONNECTED, "")
    assert connections(pi, "modem") == [came, left, came]
    assert not pi.has_told("topside:  is")


def test_a_modem_behind_a_tcp_bridge_is_the_same_one_when_it_has_spoken(tmp_path: Path) -> None:
    bridge = socket.create_server(("127.0.0.1", 0))
    bridge.settimeout(PATIENCE)
    url = f"tcp://127.0.0.1:{bridge.getsockname()[1]}"
    with (
        bridge,
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", modem=url) as pi,
        bridge.accept()[0] as modem,
    ):
        modem.sendall(wrap(b"@NI$", Sender.TOPSIDE))
        modem.settimeout(PATIENCE)
        assert b"@ACK_NI" in modem.recv(1000)
        modem.close()
        soon(lambda: pi.has_told("modem: "), "its end")
    assert connections(pi, "modem")[:2] == [(CONNECTED, ""), (DISCONNECTED, "")]


def modem_is_open(folder: Path) -> bool:
    status = folder / "status.json"
    return status.exists() and json.loads(status.read_text())["links"]["modem"]["open"]


def connections(pi: Running, link: str) -> list[tuple[str, str]]:
    """Who came and went, by the black box of a program that has ended."""
    assert pi.ready is not None
    kinds = (CONNECTED, DISCONNECTED)
    told = [(r.kind, json.loads(r.payload)) for r in read_parts(Path(pi.ready.black_box))
            if r.kind in kinds]  # fmt: skip
    return [(kind, values["address"]) for kind, values in told if values["link"] == link]


def test_behind_a_restart_under_way_the_kept_mission_is_judged_beside_the_ascent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    judged: list[str] = []

    def noted(lines: tuple[str, ...], _: object) -> None:
        judged.append(threading.current_thread().name)
        raise MissionRefused("noted")

    monkeypatch.setattr("mission.onboard.runtime.mission_validator.judge", noted)
    store = MemoryStore(Stored(tuple(script(MISSION)), under_way="autonomous/out"))
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}", store=store) as pi:
        soon(lambda: len(judged) > 0, "the judge")
        assert judged != [pi.thread.name]


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


def test_a_port_that_stays_away_keeps_serve_from_nothing(tmp_path: Path) -> None:
    with running(tmp_path, f"serial://{tmp_path}/absent") as pi, pi.boat() as boat:
        assert asked(boat, b"@AQ$").startswith(b"@AR,empty")
        boat.sendall(b"@ZAX0$")
        soon(lambda: pi.has_told("NOT SENT, the port is closed: @ZAX0$"), "the truth")


def test_a_disk_that_takes_nothing_stops_nothing(tmp_path: Path) -> None:
    (tmp_path / "log").write_text("a file where the folder should be")
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        soon(lambda: pi.has_told("nothing will be recorded"), "the failure")
        with pi.boat() as boat:
            assert asked(boat, b"@AQ$").startswith(b"@AR,empty")


def test_a_second_server_on_the_same_port_says_so_and_waits(tmp_path: Path) -> None:
    with silent_board() as (_, device), running(tmp_path, f"serial://{device}") as pi:
        told: list[str] = []
        links = LinkUrls(vehicle=f"serial://{device}", gps=None, topside=pi.url)
        configuration = replace(Configuration(), links=links, folder=tmp_path / "second")
        second = Server(provided(configuration, MemoryStore()), told.append)

        async def briefly() -> None:
            task = asyncio.ensure_future(second.run())
            while not told:
                await asyncio.sleep(0.01)
            second.stop()
            await task

        asyncio.run(asyncio.wait_for(briefly(), PATIENCE))
        assert any("is in use by another program" in line for line in told)


def test_where_nobody_listens_the_operator_is_told() -> None:
    with pytest.raises(Unreachable, match="nobody answers"):
        converse(f"tcp://127.0.0.1:{free_port()}", start())


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
