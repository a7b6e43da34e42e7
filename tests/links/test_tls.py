"""Certificates on both ends, or nothing."""

from __future__ import annotations

import contextlib
import select
import shutil
import socket
import ssl
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import LONG, until

from links import open_link
from links.admission import HANDSHAKE, LOBBY
from links.base import Link, LinkAbsent, LinkClosed
from links.tcp import CONNECT_TIMEOUT, TcpClient, TcpServer
from links.tls import context
from mission.onboard.serve.keys import make_keys
from mission.onboard.serve.listening import listening_to_viewers
from mission.topside.console import patient

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the keys")


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys")
    make_keys(folder / "ours", ["boat", "tablet"], lambda _: None)
    make_keys(folder / "theirs", ["boat"], lambda _: None)
    return folder


@pytest.fixture
def server(keys: Path) -> Iterator[TcpServer]:
    made = open_link("topside", f"tls-listen://127.0.0.1:0?keys={keys / 'ours' / 'vehicle'}")
    assert isinstance(made, TcpServer)
    yield made
    made.close()


def command(server: TcpServer, keys: Path) -> None:
    """Returns if the server answers; raises LinkAbsent or LinkClosed if not."""
    link = open_link("vehicle", f"tls://127.0.0.1:{server.port}?keys={keys}")
    try:
        say_and_listen(link)
    finally:
        link.close()


def say_and_listen(link: Link) -> None:
    link.send(b"@ZAX0$", 0.0)
    until(lambda: bool(link.receive(0.0)))


class Served:
    """A server that lives while its client blocks in a handshake."""

    def __init__(self, server: TcpServer, answer: bytes = b"") -> None:
        """Without an answer of its own it says back what it hears."""
        self._answer = answer
        self.server, self.heard, self._over = server, bytearray(), threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        while not self._over.is_set():
            for rx in self.server.receive(0.0):
                self.heard += rx.data
                self.server.send(self._answer or rx.data, 0.0, rx.address)
            time.sleep(0.001)

    def __enter__(self) -> Served:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()


def test_both_ends_with_our_keys_talk_and_long_texts_arrive_whole(
    server: TcpServer, keys: Path
) -> None:
    said = bytes(range(256)) * 700
    with Served(server):
        boat = open_link("vehicle", f"tls://127.0.0.1:{server.port}?keys={keys / 'ours' / 'boat'}")
        back = bytearray()
        sent = 0

        def complete() -> bool:
            nonlocal sent
            if sent < len(said):
                boat.send(said[sent : sent + 40_000], 0.0)
                sent += 40_000
            back.extend(b"".join(rx.data for rx in boat.receive(0.0)))
            return len(back) == len(said)

        until(complete)
        assert bytes(back) == said
        boat.close()


@pytest.mark.parametrize(
    ("whose", "why"),
    [
        ("theirs/boat", "our vehicle"),  # the client sees a strange authority first
        ("ours/vehicle", "closed the connection"),  # a vehicle's certificate cannot command
    ],
)
def test_other_certificates_never_become_a_peer(
    server: TcpServer, keys: Path, whose: str, why: str
) -> None:
    with Served(server) as served, pytest.raises((LinkAbsent, LinkClosed), match=why):
        command(server, keys / whose)
    assert server.peers == ()
    assert served.heard == b""


def test_a_certificate_of_the_wrong_end_is_called_so(server: TcpServer, keys: Path) -> None:
    with Served(server), pytest.raises(LinkClosed):
        command(server, keys / "ours" / "vehicle")
    (refusal,) = server.refusals()
    assert "a boat needs a boat's" in refusal.why


def test_who_has_no_certificate_keeps_nobody_out_who_has_one(keys: Path) -> None:
    """Handshakes that never begin, from everywhere, renewed as often as they are dropped."""
    vehicle = keys / "ours" / "vehicle"
    made = open_link("topside", f"tls-listen://127.0.0.1:0?connections=4&each=2&keys={vehicle}")
    assert isinstance(made, TcpServer)
    held = []
    with Served(made) as served:
        for turn in range(3):
            for host in range(2, 8):
                where = (f"127.0.{turn}.{host}", 0)
                address = ("127.0.0.1", made.port)
                held.append(socket.create_connection(address, LONG, source_address=where))
            command(made, keys / "ours" / "boat")
    assert bytes(served.heard) == b"@ZAX0$" * 3
    for one in held:
        one.close()
    made.close()


@pytest.mark.proof
def test_half_handshakes_by_the_hundred_from_its_own_address_keep_no_certificate_out(
    server: TcpServer, keys: Path
) -> None:
    """Some say nothing, some have begun and stop; renewed as often as they are dropped."""
    hello = client_hello(keys)
    held: list[socket.socket] = []
    with Served(server) as served:
        for turn in range(4):
            for i in range(LOBBY // 2):
                held.append(socket.create_connection(("127.0.0.1", server.port), 5.0))
                if i % 2:
                    held[-1].sendall(hello)
            command(server, keys / "ours" / ("boat", "tablet")[turn % 2])
            assert len(server.streams) <= LOBBY + 1
    assert bytes(served.heard) == b"@ZAX0$" * 4
    assert not any("a second" in refusal.why for refusal in server.refusals())
    for one in held:
        one.close()


def client_hello(keys: Path) -> bytes:
    """The first words of a handshake."""
    said = ssl.MemoryBIO()
    tls = context(keys / "ours" / "boat", server=False)
    begun = tls.wrap_bio(ssl.MemoryBIO(), said, server_hostname="vehicle")
    with contextlib.suppress(ssl.SSLWantReadError):
        begun.do_handshake()
    return said.read()


def test_a_boat_of_another_team_is_refused_by_the_vehicle_itself(
    server: TcpServer, keys: Path, tmp_path: Path
) -> None:
    """With our authority's certificate (which is public) and a key of its own."""
    shutil.copytree(keys / "theirs" / "boat", tmp_path / "spy")
    shutil.copy(keys / "ours" / "boat" / "ca.pem", tmp_path / "spy" / "ca.pem")
    with Served(server) as served, pytest.raises(LinkClosed):
        command(server, tmp_path / "spy")
    assert served.heard == b""
    (refusal,) = server.refusals()
    assert "not by our certificate authority" in refusal.why


def test_who_shows_no_certificate_is_refused_by_the_vehicle(server: TcpServer, keys: Path) -> None:
    bare = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    bare.check_hostname = False
    bare.load_verify_locations(keys / "ours" / "boat" / "ca.pem")
    with Served(server) as served:
        client = TcpClient("vehicle", "127.0.0.1", server.port, tls=bare)
        with pytest.raises(LinkClosed, match=r"wants a certificate of us|admits nobody"):
            say_and_listen(client)
    assert served.heard == b""
    assert [r.why for r in server.refusals()] == ["it has shown no certificate"]


def test_bytes_that_only_tls_knows_of_do_not_wait_for_more(server: TcpServer, keys: Path) -> None:
    """A record is longer than one read; the selector tells of it once."""
    with Served(server):
        boat = open_link("vehicle", f"tls://127.0.0.1:{server.port}?keys={keys / 'ours' / 'boat'}")
        until(lambda: bool(server.peers))
    boat.send(b"x" * 16000, 0.0)
    heard = 0
    while heard < 16000:
        assert select.select([server.fileno()], [], [], LONG)[0], f"{heard} bytes, then nothing"
        heard += sum(len(rx.data) for rx in server.receive(0.0))
    boat.close()


def test_a_boat_cannot_pose_as_the_vehicle(keys: Path) -> None:
    posing = open_link("topside", f"tls-listen://127.0.0.1:0?keys={keys / 'ours' / 'tablet'}")
    assert isinstance(posing, TcpServer)
    with Served(posing), pytest.raises(LinkAbsent, match="not as our vehicle"):
        open_link("vehicle", f"tls://127.0.0.1:{posing.port}?keys={keys / 'ours' / 'boat'}")
    posing.close()


def test_who_does_not_speak_tls_is_never_heard_and_told(server: TcpServer) -> None:
    with socket.create_connection(("127.0.0.1", server.port), LONG) as plain:
        plain.sendall(b"@ZAX0$ but not in TLS")
        until(lambda: server.receive(0.0) != [] or bool(server.turned_away))
        assert server.peers == ()
    assert [r.why for r in server.refusals()] == ["it does not speak TLS"]


def test_who_stops_in_the_middle_of_the_handshake_is_dropped(server: TcpServer) -> None:
    with socket.create_connection(("127.0.0.1", server.port), LONG) as half_open:
        until(lambda: server.receive(0.0) != [] or bool(server.streams))
        half_open.sendall(b"\x16\x03\x01")
        assert server.next_event() == HANDSHAKE
        server.receive(HANDSHAKE)
        assert half_open.recv(10) == b""
    assert [r.why for r in server.refusals()] == ["it did not say who it is"]


def test_a_server_that_does_not_speak_tls_is_told_from_one_that_refuses(keys: Path) -> None:
    plain = open_link("topside", "tcp-listen://127.0.0.1:0")
    assert isinstance(plain, TcpServer)
    with Served(plain, b"@ACK_AAN$"), pytest.raises(LinkAbsent, match="does not speak TLS"):
        open_link("vehicle", f"tls://127.0.0.1:{plain.port}?keys={keys / 'ours' / 'boat'}")
    plain.close()


def test_missing_keys_name_the_file_and_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(LinkAbsent, match=r"ca\.pem is not there: `auvmission keys`"):
        open_link("topside", f"tls-listen://127.0.0.1:0?keys={tmp_path}")
    for name in ("ca.pem", "cert.pem", "key.pem"):
        (tmp_path / name).write_text("no key at all")
    with pytest.raises(LinkAbsent, match="no keys of ours"):
        open_link("vehicle", f"tls://127.0.0.1:1?keys={tmp_path}")


def test_over_a_thin_radio_a_viewer_waits_as_long_for_the_handshake_as_the_monitor(
    keys: Path,
) -> None:
    """The radio is silent for longer than a client waits that is in a hurry."""
    folder = keys / "ours"
    url = f"tls-listen://127.0.0.1:0?keys={folder / 'vehicle'}"
    server = open_link("monitor", listening_to_viewers(url))
    assert isinstance(server, TcpServer)
    client = f"tls://127.0.0.1:{server.port}?keys={folder / 'boat'}"
    opened = threading.Event()

    def serve_late() -> None:
        time.sleep(CONNECT_TIMEOUT + 1.0)
        while not opened.is_set():
            server.receive(0.0)
            time.sleep(0.001)

    late = threading.Thread(target=serve_late)
    late.start()
    try:
        open_link("monitor", patient(client)).close()
    finally:
        opened.set()
        late.join()
        server.close()
