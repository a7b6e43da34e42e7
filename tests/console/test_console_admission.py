"""Nobody but the page that was opened from here gets anything of the console."""

from __future__ import annotations

import socket
import time
from collections import deque
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest
from console_world import Console, console_of
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

NOBODY = "tcp://127.0.0.1:1"
SECRETS = ["/api/setup", "/api/missions", "/api/vehicles/1/plan", "/api/vehicles/1/events"]
SOCKETS = ["frames", "orders", "commands", "stick"]


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Console]:
    with console_of(NOBODY, tmp_path_factory.mktemp("memory")) as (running, _):
        yield running


@pytest.mark.parametrize("path", [*SECRETS, "/", "/page/style.css"])
@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "0.0.0.0:{port}"]
)
def test_another_name_for_this_computer_gets_nothing(
    console: Console, path: str, host: str
) -> None:
    port = console.host.partition(":")[2]
    status, _, body = console.ask(path, Host=host.format(port=port))
    assert (status, b"vehicles" in body) == (421, False)


@pytest.mark.parametrize("path", [*SECRETS, "/"])
@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://{host}"]
)
def test_a_page_of_another_origin_gets_nothing(console: Console, path: str, origin: str) -> None:
    status, headers, _ = console.ask(path, Origin=origin.format(host=console.host))
    assert status == 403
    assert "access-control-allow-origin" not in headers


@pytest.mark.parametrize("path", SECRETS)
@pytest.mark.parametrize("shown", ["", "Bearer wrong", "Bearer ", "Basic {token}", "{token}"])
def test_without_the_token_only_the_pages_own_files_are_served(
    console: Console, path: str, shown: str
) -> None:
    status, _, body = console.ask(path, Authorization=shown.format(token=console.token))
    assert (status, b"auvmission console" in body) == (403, True)


def test_a_check_needs_the_token_too(console: Console) -> None:
    assert console.ask("/api/check", {"text": "", "source": ""}, Authorization="")[0] == 403


@pytest.mark.parametrize("kind", SOCKETS)
@pytest.mark.parametrize(
    "wrong",
    [
        {"origin": "http://evil.example"},
        {"origin": None},
        {"origin": "null"},
        {"subprotocols": ["auvmission"]},
        {"subprotocols": None},
        {"subprotocols": ["auvmission", "token.wrong"]},
    ],
    ids=str,
)
def test_a_socket_of_anybody_else_is_not_opened(
    console: Console, kind: str, wrong: dict[str, object]
) -> None:
    with pytest.raises(InvalidStatus) as refused, console.socket(kind, **wrong):
        pass
    assert refused.value.response.status_code == 403


@pytest.mark.parametrize("kind", SOCKETS)
def test_a_socket_by_another_name_is_not_opened(console: Console, kind: str) -> None:
    """As of a page whose name has been pointed at 127.0.0.1."""
    port = int(console.host.partition(":")[2])
    reached = socket.create_connection(("127.0.0.1", port))
    url = f"ws://evil.example:{port}/ws/{kind}?vehicle=1"
    shown = ["auvmission", f"token.{console.token}"]
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(url, sock=reached, subprotocols=shown, origin=f"http://evil.example:{port}"),
    ):
        pass
    assert refused.value.response.status_code == 421
    assert b"127.0.0.1 and localhost" in (refused.value.response.body or b"")


def test_whatever_is_served_forbids_to_load_from_elsewhere(console: Console) -> None:
    for path in ("/", "/page/none.js", "/api/setup", "/nothing"):
        _, headers, _ = console.ask(path)
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "http" not in policy
        assert headers["cache-control"] == "no-store"
        assert headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize(
    "name",
    [
        "../app.py",
        "..%2fapp.py",
        "%2e%2e/app.py",
        "../__init__.py",
        "package.json",
        "",
        ".hidden.js",
        "a//b.js",
        "/etc/hosts.js",
    ],
)
def test_no_file_but_the_pages_own_is_served(console: Console, name: str) -> None:
    status, _, body = console.ask(f"/page/{name}")
    assert status in (403, 404)
    assert b"import" not in body


def test_the_page_is_served_with_its_kind(console: Console) -> None:
    status, headers, body = console.ask("/", Authorization="")
    assert (status, headers["content-type"]) == (200, "text/html; charset=utf-8")
    assert b"<script" in body


def test_what_is_too_large_or_no_check_is_refused_in_words(console: Console) -> None:
    assert console.ask("/api/check", b"x" * (1 << 20) + b"x")[0] == 413
    for body in (b"{}", b"[", b"[" * 100_000, b'{"text": "a"}'):
        status, _, said = console.ask("/api/check", body)
        assert (status, b"text and source" in said) == (400, True)


@pytest.mark.parametrize("kind", SOCKETS)
@pytest.mark.parametrize("word", ["nonsense", "[]", "[" * 60_000, '{"do": "fly"}', '{"at": "x"}'])
def test_a_page_that_says_what_no_page_says_is_closed(
    console: Console, kind: str, word: str
) -> None:
    if kind == "frames" and word.startswith("{"):
        return  # an answer to no frame
    with console.socket(kind) as page:
        page.send(word)
        with pytest.raises(ConnectionClosed) as closed:
            deque(page, 0)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1008
        assert closed.value.rcvd.reason


@pytest.mark.parametrize("odd", ["NaN", "-Infinity", "1" + 400 * "0"])
def test_what_is_no_number_moves_no_stick(console: Console, odd: str) -> None:
    with console.socket("stick") as page:
        page.send(f'{{"at": {time.time()}, "surge": {odd}, "turn": 0, "heave": 0}}')
        with pytest.raises(ConnectionClosed) as closed:
            deque(islice(page, 30), 0)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1008


def test_a_vehicle_that_is_not_there_has_no_sockets(console: Console) -> None:
    with pytest.raises(InvalidStatus), console.socket("frames", "7"):
        pass
    with pytest.raises(InvalidStatus), console.socket("review", "1"):
        pass
    assert console.ask("/api/vehicles/7/plan")[0] == 404


def test_whoever_is_turned_away_leaves_no_line_on_the_terminal(
    console: Console, caplog: pytest.LogCaptureFixture
) -> None:
    for wrong in ({"origin": "http://evil.example"}, {"subprotocols": None}):
        with pytest.raises(InvalidStatus):
            console.socket("frames", **wrong)
    console.ask("/api/setup", Authorization="")
    time.sleep(0.2)  # uvicorn says it behind the answer
    assert caplog.records == []


def test_it_listens_on_the_loopback_alone(console: Console, tmp_path: Path) -> None:
    assert console.address.startswith("http://127.0.0.1:")
    assert len(console.token) >= 32
