"""A boat that floods, holds connections, tries ten thousand, or is somebody else's."""

from __future__ import annotations

import shutil
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from served import PATIENCE, Running, asked, read_now, running, silent_board, soon

from mission.onboard.serve.keys import make_keys
from mission.onboard.serve.listening import listening, open_to_all, reached_at
from mission.topside.console import Unreachable, converse
from mission.topside.upload import status

LOCAL, OTHER, THIRD = "127.0.0.1", "127.0.0.2", "127.0.0.3"


def boat(pi: Running, host: str) -> socket.socket:
    address, port = pi.url.partition("://")[2].split(":")
    return socket.create_connection((address, int(port)), PATIENCE, source_address=(host, 0))


@contextmanager
def flooding(pi: Running, host: str, frame: bytes = b"@DU$") -> Iterator[socket.socket]:
    """From one connection, as fast as it goes."""
    over = threading.Event()
    with boat(pi, host) as flood:
        flood.settimeout(0.05)

        def send() -> None:
            while not over.is_set():
                with suppress(OSError):
                    flood.send(frame * 2000)

        thread = threading.Thread(target=send)
        thread.start()
        try:
            yield flood
        finally:
            over.set()
            thread.join(PATIENCE)


@pytest.mark.parametrize("frame", [b"@DU$", b"\xff\x00noise", b"@ZAX", b"@MMF3$"])
def test_x_and_w_get_through_a_flood_of_another(tmp_path: Path, frame: bytes) -> None:
    with silent_board() as (master, device), running(tmp_path, f"serial://{device}") as pi:
        with flooding(pi, LOCAL, frame), boat(pi, OTHER) as operator:
            soon(lambda: pi.has_told("floods"), "the flood is told")
            for order in (b"@ZAX0$", b"@ZAWF$"):
                while read_now(master):
                    pass
                operator.sendall(order)
                heard = bytearray()

                def left(order: bytes = order, heard: bytearray = heard) -> bool:
                    heard.extend(read_now(master))
                    return order in heard

                soon(left, order.decode())
            # What the board never answered may be told in between.
            soon(lambda: asked(operator, b"@AQ$").startswith(b"@AR,running"), "an answer")
        assert pi.tells_within_its_rate("floods")


def test_an_order_in_the_midst_of_its_own_flood_gets_through(tmp_path: Path) -> None:
    with (
        silent_board() as (master, device),
        running(tmp_path, f"serial://{device}") as pi,
        boat(pi, LOCAL) as flood,
    ):

        def send() -> None:
            with suppress(OSError):
                flood.sendall(b"@AQ$" * 500_000 + b"@ZAX0$" + b"@AQ$" * 500_000)

        threads = [
            threading.Thread(target=send),
            threading.Thread(target=_drain, args=(flood,)),
        ]
        for thread in threads:
            thread.start()
        heard = bytearray()

        def left() -> bool:
            heard.extend(read_now(master))
            return b"@ZAX0$" in heard

        soon(left, "X")
        threads[0].join(PATIENCE)
        flood.shutdown(socket.SHUT_RDWR)
        threads[1].join(PATIENCE)


def _drain(connection: socket.socket) -> None:
    with suppress(OSError):
        while connection.recv(65536):
            pass


REASONS = 4  # too often, too many from there, too many, gave its place up


def tried(pi: Running, host: str) -> socket.socket:
    """It does not wait to be let in: a full queue of the system would set the pace."""
    address, port = pi.url.partition("://")[2].split(":")
    made = socket.socket()
    made.setblocking(False)
    made.bind((host, 0))
    made.connect_ex((address, int(port)))
    return made


@pytest.mark.proof
def test_ten_thousand_connections_tried_leave_the_operator_his(tmp_path: Path) -> None:
    with (
        silent_board() as (master, device),
        running(tmp_path, f"serial://{device}") as pi,
        boat(pi, LOCAL) as operator,
    ):
        held: list[socket.socket] = []
        for i in range(10_000):
            held.append(tried(pi, THIRD if i % 2 else OTHER))
            if len(held) > 200:
                held.pop(0).close()
            if i % 100 == 0:
                assert asked(operator, b"@AQ$").startswith(b"@AR,")
        operator.sendall(b"@ZAWF$")
        soon(lambda: b"@ZAWF$" in read_now(master), "W")
        for one in held:
            one.close()
        assert pi.tells_within_its_rate("turned away", 2 * REASONS)


def test_an_address_that_is_not_allowed_is_refused_and_told(tmp_path: Path) -> None:
    with silent_board() as (_, device):
        url = f"tcp://127.0.0.1:0?allow={OTHER}"
        with running(tmp_path, f"serial://{device}", topside=url) as pi:
            with pytest.raises(Unreachable, match="admits nobody from here"):
                converse(pi.url, status(lambda *_: None))
            with boat(pi, OTHER) as operator:
                assert asked(operator, b"@AQ$").startswith(b"@AR,")
            assert pi.has_told(f"{LOCAL} turned away: its address is not among those allowed")


@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the keys")
def test_with_keys_an_operator_commands_and_without_nobody_does(tmp_path: Path) -> None:
    make_keys(tmp_path / "k", ["boat"], lambda _: None)
    with silent_board() as (_, device):
        url = f"tls://127.0.0.1:0?keys={tmp_path}/k/vehicle"
        with running(tmp_path, f"serial://{device}", topside=url) as pi:
            assert pi.url.startswith("tls://127.0.0.1:")
            keyed = f"{pi.url}?keys={tmp_path}/k/boat"
            assert converse(keyed, status(lambda *_: None)) == ""
            with pytest.raises(Unreachable):
                converse(pi.url.replace("tls", "tcp"), status(lambda *_: None))
            soon(lambda: pi.has_told("it does not speak TLS"), "the reason")


def test_who_loses_the_command_is_answered_n_and_the_journal_has_both_names(
    tmp_path: Path,
) -> None:
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}") as pi,
        boat(pi, LOCAL) as first,
        boat(pi, OTHER) as second,
    ):
        assert asked(first, b"@SP,1000,5,200,10,$") == b"@ACK_SPP$"
        assert asked(second, b"@SP,900,5,200,10,$") == b"@ACK_SPN$"
        assert b"commands; others read" in asked(second, b"@AQ$")
        second.sendall(b"@ZAX0$")
        soon(lambda: pi.has_told("has taken the command over from"), "the hand-over")
        (line,) = [line for line in pi.told if "taken the command over" in line]
        assert f"topside {OTHER}:" in line.partition(" has taken ")[0]
        assert f"topside {LOCAL}:" in line.partition(" over from ")[2]
        assert asked(first, b"@SP,800,5,200,10,$") == b"@ACK_SPN$"


def test_ready_is_told_to_the_service_manager_although_topside_cannot_be_listened_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Broken keys must not keep a vehicle that was under way from surfacing."""
    manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    manager.bind(str(tmp_path / "notify"))
    manager.settimeout(PATIENCE)
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    with manager, silent_board() as (_, device):
        url = f"tls://127.0.0.1:0?keys={tmp_path}/absent"
        pi = Running(tmp_path, f"serial://{device}", topside=url, wait=False)
        assert manager.recv(100) == b"READY=1"
        soon(lambda: pi.has_told("auvmission keys"), "the remedy")
        pi.stop()


@pytest.mark.parametrize(
    ("url", "is_open"),
    [
        ("tcp://127.0.0.1:4000", False),
        ("tcp://0.0.0.0:4000", True),
        ("tcp-listen://[::]:4000", True),
        ("tcp://0.0.0.0:4000?allow=10.0.0.0/8", False),
        ("tls://0.0.0.0:4000", False),
    ],
)
def test_what_is_open_to_all_is_known(url: str, is_open: bool) -> None:
    assert open_to_all(url) is is_open
    assert "-listen://" in listening(url)
    assert "-listen" not in reached_at(listening(url))
