"""A link's scheme is one row: this file has a toy that nobody else knows, and it is seen everywhere."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner
from contracts import keep
from served import PATIENCE, running

from links import (
    LINKS,
    Address,
    LinkAddressError,
    LinkRow,
    at_rate,
    baud_of,
    check_url,
    parse_address,
)
from links.base import LinkClosed, Rx
from mission.analysis.replay.replay import replay
from mission.cli import main
from mission.model.shipped import load_vehicle
from mission.onboard.blackbox import read_records
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.rates import rated
from mission.onboard.runtime.records import RX, TX

DOCS = Path(__file__).resolve().parents[2] / "docs"
WAITING: dict[str, socket.socket] = {}


class Pipe:
    """One end of a pair of local sockets; the first to open a name leaves the other end there."""

    def __init__(self, name: str, end: socket.socket) -> None:
        self.name, self._end = name, end
        end.setblocking(False)

    def fileno(self) -> int:
        return self._end.fileno()

    def receive(self, now: float) -> list[Rx]:
        if self.fileno() < 0:
            raise LinkClosed(f"{self.name}: closed")
        try:
            data = self._end.recv(65536)
        except BlockingIOError:
            return []
        if not data:
            raise LinkClosed(f"{self.name}: the other end was closed")
        return [Rx(now, self.name, data)]

    def send(self, data: bytes, now: float, address: str = "") -> None:
        if self.fileno() < 0:
            raise LinkClosed(f"{self.name}: closed")
        self._end.send(data)

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        self._end.close()


def settings(address: Address) -> tuple[str, float]:
    if not address.host:
        raise LinkAddressError(f"{address.url}: name it, for instance {TOY.example}")
    return address.host, address.number("pace", 9600, 300, 1e6)


def open_url(name: str, address: Address) -> Pipe:
    host, _ = settings(address)
    if host in WAITING:
        return Pipe(name, WAITING.pop(host))
    near, WAITING[host] = socket.socketpair()
    return Pipe(name, near)


TOY = LinkRow(__name__, "pipe://yard?pace=9600", ("pace",), rate="pace")


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setitem(LINKS, "pipe", TOY)
    yield
    for end in WAITING.values():
        end.close()
    WAITING.clear()


def test_its_url_is_read_refused_and_told_with_those_of_the_others() -> None:
    assert parse_address("pipe://yard?pace=300").options == {"pace": "300"}
    check_url("pipe://yard")
    with pytest.raises(LinkAddressError, match="unknown option 'speed'; there are: pace"):
        parse_address("pipe://yard?speed=1")
    with pytest.raises(LinkAddressError, match=r"name it, for instance pipe://yard"):
        check_url("pipe://")
    with pytest.raises(LinkAddressError, match="a number from 300 to"):
        check_url("pipe://yard?pace=1")
    with pytest.raises(LinkAddressError, match=r"pipe://yard\?pace=9600"):
        parse_address("usb://x")


def test_it_keeps_the_contract_of_links_over_a_real_loopback() -> None:
    keep("links", "pipe")


def test_it_gets_the_rate_of_its_role_where_its_url_tells_none() -> None:
    assert at_rate("pipe://yard", 115200) == "pipe://yard?pace=115200"
    assert at_rate("pipe://yard?pace=300", 115200) == "pipe://yard?pace=300"
    given = Configuration(links=LinkUrls(vehicle="pipe://yard", gps=None))
    assert rated(given, load_vehicle("rov")).links.vehicle == "pipe://yard?pace=115200"
    assert baud_of("tcp://somewhere:1", 5.0) == 5.0


def test_serve_speaks_to_a_board_over_it_and_its_black_box_replays_to_the_bit(
    tmp_path: Path,
) -> None:
    with running(tmp_path, "pipe://yard") as serve, serve.boat() as boat:
        board = WAITING["yard"]
        board.settimeout(PATIENCE)
        boat.sendall(b"@ZAX0$")
        assert board.recv(64) == b"@ZAX0$"
        board.sendall(b"@ACK_ZAY$")
        assert boat.recv(64) == b"@ACK_ZXY$"
    (path,) = (tmp_path / "log").glob("*.mcap")
    records = list(read_records(path))
    said = [(r.kind, r.payload) for r in records if b"ZA" in r.payload and r.kind in (RX, TX)]
    assert any(kind == RX and b"@ACK_ZAY$" in payload for kind, payload in said)
    assert any(kind == TX and b"@ZAX0$" in payload for kind, payload in said)
    assert replay(records).identical


def test_it_is_listed_in_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(DOCS))
    from from_code.tables import link_schemes

    assert "| `pipe` | `pipe://yard?pace=9600` | `pace` |" in link_schemes()


def test_the_operators_programs_take_it() -> None:
    ran = CliRunner().invoke(main, ["send", "--port", "pipe://yard?pace=fast", "--text", "@NI$"])
    assert ran.exit_code != 0
    assert "pace=fast: a number from 300 to 1e+06 is needed" in ran.output
