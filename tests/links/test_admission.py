"""Who may connect, how many, how often, and who has to leave."""

from __future__ import annotations

import socket
import struct

import pytest
from patience import LONG, until

from links import LinkAddressError, open_link, parse_address
from links.admission import (
    AT_ONCE,
    GIVES_WAY,
    LOBBY,
    PER_SECOND,
    PROVES,
    Admission,
    Gate,
    Present,
    admission_of,
)
from links.stream import READ, Stream
from links.tcp import RECEIVE_BUFFER, TcpServer


def listening(**options: object) -> TcpServer:
    return TcpServer("topside", "127.0.0.1", 0, admission=Admission(**options))  # type: ignore[arg-type]


def connect(server: TcpServer, now: float, host: str = "127.0.0.1") -> socket.socket:
    """Connected as far as the system is concerned; the server has decided."""
    client = socket.create_connection(("127.0.0.1", server.port), LONG, source_address=(host, 0))
    name = f"{host}:{client.getsockname()[1]}"

    def decided() -> bool:
        server.receive(now)
        refused = any(r.host == host for r in server.turned_away)
        return name in server.peers or refused

    until(decided)
    return client


def gate(text: str) -> Gate:
    return Gate(admission_of(parse_address(f"tcp-listen://0.0.0.0:1?allow={text}")))


@pytest.mark.parametrize(
    ("allow", "host", "admitted"),
    [
        ("192.168.1.0/24", "192.168.1.77", True),
        ("192.168.1.0/24", "192.168.2.77", False),
        ("192.168.1.0/24", "::ffff:192.168.1.77", True),
        ("192.168.1.0/24,10.0.0.5", "10.0.0.5", True),
        ("10.0.0.5", "10.0.0.6", False),
        ("fe80::/10", "fe80::1%eth0", True),
        ("fe80::/10", "192.168.1.1", False),
        ("", "203.0.113.9", True),
    ],
)
def test_only_addresses_that_are_allowed_get_in(allow: str, host: str, admitted: bool) -> None:
    assert (gate(allow).forbids(host) == "") is admitted


@pytest.mark.parametrize(
    "option", ["allow=boat", "allow=1.2.3.4/40", "each=0", "idle=x", "peers=3"]
)
def test_a_wrong_option_is_refused_with_what_to_write(option: str) -> None:
    with pytest.raises(LinkAddressError, match=option.partition("=")[0]):
        open_link("topside", f"tcp-listen://127.0.0.1:0?{option}")


def test_one_address_that_connects_too_often_waits_and_no_other_does() -> None:
    door = Gate(Admission())
    tried = [door.hurries("10.0.0.1", i * 0.001) for i in range(10_000)]
    assert tried.count("") == pytest.approx(AT_ONCE + 10 * PER_SECOND, abs=1)
    assert door.hurries("10.0.0.2", 10.0) == ""
    assert door.hurries("10.0.0.1", 12.0) == ""


def test_ten_thousand_addresses_leave_no_memory_behind() -> None:
    door = Gate(Admission())
    for i in range(10_000):
        door.hurries(socket.inet_ntoa(struct.pack(">I", i)), i * 0.01)
    assert len(door.arrivals) < 2000


def test_who_is_silent_gives_way_and_who_speaks_does_not() -> None:
    door = Gate(Admission(connections=3, each=2))
    here = [Present("a:1", "a", 5.0), Present("a:2", "a", 3.0), Present("b:1", "b", 1.0)]
    assert door.room("c", here, 9.0) == ("", "3 connections already")
    assert door.room("c", here, 1.0 + GIVES_WAY) == ("b:1", "")
    assert door.room("a", here, 9.0) == ("", "2 connections from there already")
    assert door.room("a", here, 3.0 + GIVES_WAY) == ("a:2", "")
    assert door.room("b", here[:2], 9.0) == ("", "")


def test_who_has_said_nothing_that_makes_sense_gives_way_sooner() -> None:
    door = Gate(Admission(connections=2, each=2))
    drips = [Present("a:1", "a", 5.0, proved=False), Present("b:1", "b", 0.0)]
    assert door.room("c", drips, 5.5) == ("", "2 connections already")
    assert door.room("c", drips, 5.0 + PROVES) == ("a:1", "")


def test_who_drips_bytes_keeps_nobody_out_who_makes_sense() -> None:
    """Slow loris: a byte now and then is no silence, and no frame either."""
    server = listening(connections=3, each=3)
    drips = [connect(server, float(i)) for i in range(3)]
    server.vouch(server.peers[0])
    for drip in drips:
        drip.sendall(b"@")
    until(lambda: sum(s.heard == 9.0 for s in _after(server, 9.0)) == 3)
    operator = connect(server, 9.0, "127.0.0.2")
    assert drips[1].recv(10) == b"", "the first one that was not vouched for"
    server.vouch(server.peers[-1])
    for host in range(3, 9):
        connect(server, 9.5, f"127.0.0.{host}").close()
    operator.sendall(b"@ZAX0$")
    until(lambda: any(rx.data == b"@ZAX0$" for rx in server.receive(9.5)))
    for client in (*drips, operator):
        client.close()
    server.close()


def _after(server: TcpServer, now: float) -> list[Stream]:
    server.receive(now)
    return list(server.streams.values())


def test_in_a_full_lobby_the_first_who_came_from_where_most_came_gives_way_at_once() -> None:
    door = Gate(Admission(connections=3, each=2))
    waiting = [Present(f"a:{i}", "a", 2.0 + i) for i in range(LOBBY - 1)]
    assert door.lobby(waiting) == "", "as many as one address likes"
    assert door.lobby([Present("b:1", "b", 1.0), *waiting]) == "a:0"


def test_a_refused_connection_is_closed_and_told_once_with_its_count() -> None:
    server = listening(allow=admission_of(parse_address("tcp-listen://h:1?allow=127.0.0.9")).allow)
    for _ in range(3):
        with connect(server, 0.0) as refused:
            assert refused.recv(10) == b""
    assert server.peers == ()
    with connect(server, 0.0, "127.0.0.9"):
        assert len(server.peers) == 1
    ((refusal, count),) = server.refusals().items()
    assert (refusal.host, count) == ("127.0.0.1", 3)
    assert "not among those allowed" in refusal.why
    assert not server.refusals()
    server.close()


def test_one_address_cannot_take_every_place() -> None:
    server = listening(connections=6, each=2)
    mine = [connect(server, 0.0) for _ in range(4)]
    assert len(server.peers) == 2
    other = connect(server, 0.0, "127.0.0.2")
    assert len(server.peers) == 3
    for client in (*mine, other):
        client.close()
    server.close()


def test_places_that_are_only_held_are_given_to_who_comes() -> None:
    server = listening(connections=3, each=3)
    held = [connect(server, float(i)) for i in range(3)]
    operator = connect(server, GIVES_WAY, "127.0.0.2")
    assert held[0].recv(10) == b""
    operator.sendall(b"@ZAX0$")
    until(lambda: any(rx.data == b"@ZAX0$" for rx in server.receive(GIVES_WAY)))
    for client in (*held, operator):
        client.close()
    server.close()


def test_a_silent_connection_is_dropped_when_it_is_due_and_a_living_one_is_not() -> None:
    server = listening(idle=60.0)
    silent, living = connect(server, 0.0), connect(server, 0.0)
    assert server.next_event() == 60.0
    living.sendall(b"@DU$")
    until(lambda: bool(server.receive(30.0)))
    server.receive(60.0)
    assert len(server.peers) == 1
    assert silent.recv(10) == b""
    assert server.next_event() == 90.0
    assert [r.why for r in server.refusals()] == ["silent for 60 s"]
    silent.close()
    living.close()
    server.close()


def test_who_floods_gets_no_more_than_his_turn() -> None:
    server = listening()
    flood, other = connect(server, 0.0), connect(server, 0.0)
    for stream in server.streams.values():
        queue = stream.socket.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
        assert queue <= 2 * RECEIVE_BUFFER, "Linux shows it doubled"
    flood.settimeout(0.2)
    with pytest.raises(TimeoutError):  # a bounded queue: the sender waits, not the order behind it
        flood.sendall(b"x" * (64 << 20))
    other.sendall(b"@ZAX0$")
    until(lambda: len(server.selector.select(0.0)) == 2)
    heard = {rx.address: rx.data for rx in server.receive(0.0)}
    assert heard.pop(f"127.0.0.1:{other.getsockname()[1]}") == b"@ZAX0$"
    assert [len(data) for data in heard.values()] == [READ]
    flood.close()
    other.close()
    server.close()


def test_a_loopback_of_the_sixth_version_is_listened_on_too() -> None:
    try:
        server = open_link("topside", "tcp-listen://[::1]:0")
    except OSError:
        pytest.skip("this computer has no IPv6")
    assert isinstance(server, TcpServer)
    with socket.create_connection(("::1", server.port), LONG):
        until(lambda: bool(server.receive(0.0)) or bool(server.peers))
        assert server.peers[0].startswith("[::1]:")
    server.close()
