"""A console that runs, in a thread on a free port of the loopback, and a page's part of the wire."""

from __future__ import annotations

import asyncio
import http.client
import json
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import uvicorn
from served import PATIENCE, Running, running, silent_board, soon
from served import simulated as simulated_board
from websockets.sync.client import ClientConnection, connect

from mission.console.app import Shown
from mission.console.charts.shelf import Shelf
from mission.console.serving import listen, serve
from mission.console.vehicle import Given, Vehicle


class Console:
    """``made`` is called in the console's own event loop."""

    def __init__(self, made: Callable[[], Sequence[Shown]], charts: Shelf | None = None) -> None:
        self._made, self._charts, self._server = made, charts, list[uvicorn.Server]()
        self._listening = listen(0)
        self.address = ""
        self.thread = threading.Thread(target=self._run)
        self.thread.start()
        soon(lambda: bool(self.address) or not self.thread.is_alive(), "the page's address")

    def _run(self) -> None:
        end = self._server.append
        asyncio.run(serve(self._listening, self._made, self._ready, end, self._charts))

    def _ready(self, address: str) -> None:
        self.address = address

    @property
    def host(self) -> str:
        return self.address.removeprefix("http://").partition("/")[0]

    @property
    def token(self) -> str:
        return self.address.partition("#")[2]

    def ask(
        self, path: str, body: object = None, **headers: str
    ) -> tuple[int, dict[str, str], bytes]:
        """Status, headers and body; ``headers`` take the place of the page's own."""
        own = {"Host": self.host, "Authorization": f"Bearer {self.token}"} | headers
        method = "GET" if body is None else "POST"
        said = None if body is None else body if isinstance(body, bytes) else json.dumps(body)
        asking = http.client.HTTPConnection(self.host, timeout=PATIENCE)
        asking.request(method, path, said, {name: v for name, v in own.items() if v})
        answer = asking.getresponse()
        found = answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read()
        asking.close()
        return found

    def get(self, path: str, body: object = None) -> Any:
        status, _, said = self.ask(path, body)
        assert status == 200, said
        return json.loads(said)

    def socket(self, kind: str, vehicle: str = "1", **more: Any) -> ClientConnection:
        shown = {
            "subprotocols": ["auvmission", f"token.{self.token}"],
            "origin": f"http://{self.host}",
            "open_timeout": PATIENCE,
        } | more
        return connect(f"ws://{self.host}/ws/{kind}?vehicle={vehicle}", **shown)

    def stop(self) -> None:
        for server in self._server:
            server.should_exit = True
        self.thread.join(PATIENCE)
        assert not self.thread.is_alive()


class Page:
    """The frames of a vehicle as a page has them, each answered."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.state: dict[str, Any] = {}
        self.events: list[str] = []
        self.track: list[list[float]] = []
        self.t, self.snapshots = 0.0, 0

    def take(self) -> dict[str, Any]:
        frame = json.loads(self.socket.recv(PATIENCE))
        if frame["n"] == 1:
            self.state, self.events, self.track = {}, [], []
            self.snapshots += 1
        self.t = frame["t"]
        self.state |= frame.get("state", {})
        self.events += frame.get("events", [])
        self.track += frame.get("track", [])
        self.socket.send(json.dumps({"ack": frame["n"]}))
        return dict(frame)

    def until(self, holds: Callable[[dict[str, Any]], Any], what: str) -> dict[str, Any]:
        end = time.monotonic() + PATIENCE
        while not holds(self.state):
            assert time.monotonic() < end, f"not within {PATIENCE} s: {what}: {self.state}"
            self.take()
        return self.state


def said(socket: ClientConnection, **intent: Any) -> None:
    socket.send(json.dumps({"id": 1, "at": time.time()} | intent))


def heard(socket: ClientConnection, *wanted: str) -> dict[str, Any]:
    """The first answer that ``is`` one of these."""
    end = time.monotonic() + PATIENCE
    while (answer := json.loads(socket.recv(PATIENCE)))["is"] not in wanted:
        assert time.monotonic() < end, f"not within {PATIENCE} s: {wanted}: {answer}"
    return dict(answer)


@contextmanager
def console(made: Callable[[], Sequence[Shown]], charts: Shelf | None = None) -> Iterator[Console]:
    running = Console(made, charts)
    try:
        yield running
    finally:
        running.stop()


@contextmanager
def console_of(
    to: str, memory: Path, monitor: str = "", **more: Any
) -> Iterator[tuple[Console, Vehicle]]:
    """A console of one vehicle."""
    found: list[Vehicle] = []

    def made() -> Sequence[Shown]:
        found.append(Vehicle("1", Given("auv-1", to, monitor, **more), memory))
        return found

    with console(made) as running:
        yield running, found[0]


def monitor_of(pi: Running) -> str:
    assert pi.server is not None
    viewing = pi.server.viewing
    soon(lambda: viewing is not None and viewing.port.link is not None, "the monitor's port")
    return f"tcp://127.0.0.1:{viewing.port.link.port}"  # type: ignore[union-attr]


@contextmanager
def cockpit(folder: Path, **more: object) -> Iterator[tuple[Running, Console, Vehicle]]:
    """A serve with a board that says nothing, and its console."""
    with silent_board() as (_, board):
        url = f"serial://{board}"
        with (
            running(folder, url, monitor="tcp://127.0.0.1:0", **more) as pi,
            console_of(pi.url, folder, monitor_of(pi)) as (console, vehicle),
        ):
            yield pi, console, vehicle


@contextmanager
def at_sea(folder: Path) -> Iterator[tuple[Running, Console, Vehicle]]:
    """The same with a simulated vehicle, in real time."""
    with simulated_board(1.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with (
            running(folder, stm32, gps=gps, monitor="tcp://127.0.0.1:0") as pi,
            console_of(pi.url, folder, monitor_of(pi)) as (console, vehicle),
        ):
            yield pi, console, vehicle
