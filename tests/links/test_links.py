"""Links that are opened by URL: what is special about each scheme. What holds of all is in
tests/worlds/contracts.py."""

from __future__ import annotations

import fcntl
import os
import select
import socket
import struct
import subprocess
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from patience import LONG, until

from links import LinkAddressError, open_link
from links.admission import Admission
from links.base import Link, LinkAbsent, LinkBusy, LinkClosed, LinkError
from links.memory import EXCHANGE, memory_pair
from links.serial import BACKLOG, SerialLink
from links.tcp import TcpClient, TcpServer

ROOT = Path(__file__).resolve().parent.parent.parent
VHANGUP = 0x5437  # Linux: as if the cable were pulled


def again(act: Callable[[], object], times: int = 1000) -> None:
    for _ in range(times):
        act()


def read(link: Link, wanted: int) -> bytes:
    """At least so many bytes, from whoever."""
    data = bytearray()

    def enough() -> bool:
        data.extend(b"".join(rx.data for rx in link.receive(1.0)))
        return len(data) >= wanted

    until(enough)
    return bytes(data)


# --- URLs -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("usb://x", "serial:///dev/ttyUSB0"),
        ("/dev/ttyUSB0", "serial:///dev/ttyUSB0"),
        ("tcp://localhost", "tcp://host:port"),
        ("tcp://localhost:99999", "65535"),
        ("tcp-listen://:9000", "127.0.0.1:9000"),
        ("serial://dev/ttyUSB0", "three slashes"),
        ("serial:///dev/ttyUSB0?baud=fast", "baud=fast"),
        ("memory://", "memory://topside"),
    ],
)
def test_a_wrong_url_is_answered_with_what_to_write(url: str, says: str) -> None:
    with pytest.raises(LinkAddressError, match=says):
        open_link("vehicle", url)


# --- serial -----------------------------------------------------------------------------------


def test_an_absent_port_is_named() -> None:
    with pytest.raises(LinkAbsent, match=r"vehicle: no device /dev/ttyNONE7: is it plugged in"):
        open_link("vehicle", "serial:///dev/ttyNONE7")


def test_a_port_that_another_process_holds_is_busy() -> None:
    master, slave = os.openpty()
    path = os.ttyname(slave)
    code = (
        "import sys; from links import open_link\n"
        "from links.base import LinkBusy\n"
        f"try: open_link('vehicle', 'serial://{path}')\n"
        "except LinkBusy as error: print(error)\n"
    )
    link = SerialLink("vehicle", path)
    try:
        said = subprocess.run(
            [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
        )
        assert f"vehicle: {path} is in use by another program" in said.stdout
        with pytest.raises(LinkBusy):
            SerialLink("again", path)
    finally:
        link.close()
    SerialLink("vehicle", path).close()  # free again
    os.close(master)
    os.close(slave)


def test_a_port_that_goes_away_is_told_and_never_hangs() -> None:
    master, slave = os.openpty()
    link = SerialLink("vehicle", os.ttyname(slave))
    os.close(slave)
    os.close(master)
    with pytest.raises(LinkClosed, match="went away"):
        again(lambda: link.receive(0.0))


def test_a_port_that_was_pulled_out_is_told_though_another_has_its_name_by_now(
    tmp_path: Path,
) -> None:
    """A device behind a name of udev that comes back sooner than anybody looks."""
    name = tmp_path / "ttyAUV"
    master, slave = os.openpty()
    name.symlink_to(os.ttyname(slave))
    link = SerialLink("vehicle", str(name))
    assert link.receive(0.0) == [], "silence is no end"
    try:
        fcntl.ioctl(slave, VHANGUP)
    except OSError as error:
        link.close()
        pytest.skip(f"hanging a terminal up needs rights: {error}")
    with pytest.raises(LinkClosed, match="went away"):
        again(lambda: link.receive(0.0))
    os.close(master)
    os.close(slave)


def test_a_port_that_goes_away_while_it_is_opened_is_absent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    master, slave = os.openpty()
    path = os.ttyname(slave)
    os.close(slave)
    really = termios.tcgetattr

    def is_pulled_out(fd: int) -> list[object]:
        read = really(fd)
        os.close(master)
        return read

    monkeypatch.setattr(termios, "tcgetattr", is_pulled_out)
    with pytest.raises(LinkAbsent, match=f"vehicle: no device {path}"):
        SerialLink("vehicle", path)


def test_a_port_that_takes_nothing_is_closed_before_memory_fills() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    link = SerialLink("vehicle", os.ttyname(slave))
    with pytest.raises(LinkClosed, match="takes no bytes"):
        again(lambda: link.send(b"x" * (BACKLOG // 8), 0.0))
    os.close(master)
    os.close(slave)


# --- TCP --------------------------------------------------------------------------------------


@pytest.fixture
def server() -> Iterator[TcpServer]:
    made = TcpServer("topside", "127.0.0.1", 0, admission=Admission(connections=3))
    yield made
    made.close()


def connect(server: TcpServer) -> socket.socket:
    client = socket.create_connection(("127.0.0.1", server.port), timeout=LONG)
    address = f"127.0.0.1:{client.getsockname()[1]}"
    until(lambda: bool(server.receive(0.0)) or address in server.peers)
    return client


def test_several_peers_are_told_apart_by_address(server: TcpServer) -> None:
    clients = [connect(server) for _ in range(3)]
    for i, client in enumerate(clients):
        client.sendall(b"@NI$" * (i + 1))
    heard: dict[str, bytes] = {}

    def complete() -> bool:
        for rx in server.receive(0.0):
            heard[rx.address] = heard.get(rx.address, b"") + rx.data
        return sum(map(len, heard.values())) == 24

    until(complete)
    for i, client in enumerate(clients):
        address = f"127.0.0.1:{client.getsockname()[1]}"
        assert heard[address] == b"@NI$" * (i + 1)
        server.send(b"only %d" % i, 0.0, address)
    for i, client in enumerate(clients):
        assert client.recv(100) == b"only %d" % i
    server.send(b"all", 0.0)
    for client in clients:
        assert client.recv(100) == b"all"
        client.close()


def test_a_peer_that_leaves_does_not_disturb_the_others(server: TcpServer) -> None:
    gone, stays = connect(server), connect(server)
    address = server.peers[0]
    gone.sendall(b"last words")
    gone.close()
    heard = b""

    def left() -> bool:
        nonlocal heard
        heard += b"".join(rx.data for rx in server.receive(0.0))
        return address not in server.peers

    until(left)
    assert heard == b"last words"
    with pytest.raises(LinkClosed, match="not connected"):
        server.send(b"x", 0.0, address)
    stays.sendall(b"here")
    assert read(server, 4) == b"here"
    stays.close()


def test_more_peers_than_allowed_are_turned_away(server: TcpServer) -> None:
    clients = [connect(server) for _ in range(3)]
    with socket.create_connection(("127.0.0.1", server.port), timeout=LONG) as fourth:
        until(lambda: bool(server.receive(0.0)) or bool(server.turned_away))
        assert fourth.recv(10) == b""
    assert len(server.peers) == 3
    for client in clients:
        client.close()


def test_a_peer_that_reads_nothing_is_dropped_and_the_server_goes_on(server: TcpServer) -> None:
    deaf, good = connect(server), connect(server)
    address = server.peers[0]
    with pytest.raises(LinkClosed):
        again(lambda: server.send(b"x" * 65536, 0.0, address))
    good.sendall(b"still here")
    assert read(server, 10) == b"still here"
    deaf.close()
    good.close()


def test_a_slow_peer_gets_everything_in_order(server: TcpServer) -> None:
    client = connect(server)
    data = os.urandom(250_000)
    (peer,) = server.streams.values()
    peer.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 8192)
    server.send(data, 0.0, server.peers[0])
    assert len(peer.waiting) > 100_000
    assert select.select([server.fileno()], [], [], LONG)[0], "the loop is told when there is room"
    got = bytearray()
    client.settimeout(0.05)

    def complete() -> bool:
        server.receive(0.0)
        try:
            got.extend(client.recv(65536))
        except TimeoutError:
            return False
        return len(got) == len(data)

    until(complete)
    assert bytes(got) == data
    client.close()


def test_a_connection_that_is_reset_as_soon_as_it_is_there_is_absent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As of a vehicle whose program ends in this moment; and its socket is closed."""
    opened, connect = list[socket.socket](), socket.create_connection
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def reset(*where: object, **more: object) -> socket.socket:
            opened.append(connect(*where, **more))  # type: ignore[arg-type]
            accepted, _ = listening.accept()
            accepted.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            accepted.close()
            select.select(opened, [], [], LONG)
            return opened[0]

        monkeypatch.setattr(socket, "create_connection", reset)
        with pytest.raises(LinkAbsent, match="closed the connection at once"):
            open_link("vehicle", f"tcp://127.0.0.1:{listening.getsockname()[1]}")
    assert opened[0].fileno() == -1


def test_a_port_in_use_is_busy_and_nobody_listening_is_absent(server: TcpServer) -> None:
    with pytest.raises(LinkBusy, match=f"port {server.port} on 127.0.0.1 is in use"):
        open_link("topside", f"tcp-listen://127.0.0.1:{server.port}")
    port = server.port
    server.close()
    with pytest.raises(LinkAbsent, match="nobody answers"):
        open_link("vehicle", f"tcp://127.0.0.1:{port}")
    with pytest.raises(LinkError, match="cannot listen"):
        open_link("topside", "tcp-listen://192.0.2.1:9000")


def test_what_the_server_said_before_it_left_is_not_lost() -> None:
    server = TcpServer("topside", "127.0.0.1", 0)
    client = TcpClient("pi", "127.0.0.1", server.port)
    until(lambda: bool(server.receive(0.0)) or bool(server.peers))
    server.send(b"@ACK_AAA$", 0.0)
    server.close()
    assert read(client, 9) == b"@ACK_AAA$"
    with pytest.raises(LinkClosed, match="closed the connection"):
        until(lambda: bool(client.receive(0.0)))


# --- memory -----------------------------------------------------------------------------------


def test_memory_takes_the_time_of_its_delay_and_of_its_wire() -> None:
    one, two = memory_pair("one", "two", delay=0.5, baud=9600)
    one.send(b"0123456789", 1.0)
    one.send(b"ab", 1.0)
    byte = 10 / 9600
    assert two.next_event() == pytest.approx(1.5 + 10 * byte)
    assert two.receive(1.5) == []
    first, second = two.receive(2.0)
    assert (first.t, first.data) == (1.5, b"0123456789")
    assert second.t == pytest.approx(1.5 + 10 * byte)
    assert two.next_event() is None


def test_a_third_end_is_busy_until_one_is_closed() -> None:
    first, second = EXCHANGE.open("wire", "a"), EXCHANGE.open("wire", "b")
    with pytest.raises(LinkBusy, match="memory://wire"):
        EXCHANGE.open("wire", "c")
    first.send(b"bye", 0.0)
    first.close()
    assert [rx.data for rx in second.receive(0.0)] == [b"bye"]
    with pytest.raises(LinkClosed, match="other end"):
        second.receive(0.0)
    EXCHANGE.open("wire", "c").close()
    second.close()
