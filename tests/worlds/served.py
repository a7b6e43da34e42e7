"""A serve that runs: in a thread, on real sockets and pseudo-terminals. For the tests of the shell."""

from __future__ import annotations

import asyncio
import os
import select
import socket
import subprocess
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from links.simulated.link import SimulatedVehicle
from links.simulated.pty import PtyVehicle
from links.simulated.settings import Settings
from mission.authoring.language import parse, script
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.kept import Homes
from mission.onboard.serve.journal import AGAIN_S
from mission.onboard.serve.listening import Ready
from mission.onboard.serve.provision import Provision
from mission.onboard.serve.serve import Server
from mission.onboard.store import DiskStore, Store

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
PATIENCE = 60.0  # s, real; the machine may have other things to do


ASKED_AGAIN = 0.5  # s: a connection for each question, and serve admits so many in ten seconds


def soon(
    holds: Callable[[], bool], what: str, within: float = PATIENCE, pause: float = 0.01
) -> None:
    end = time.monotonic() + within
    while not holds():
        assert time.monotonic() < end, f"not within {within} s: {what}"
        time.sleep(pause)


def noted_processes(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[str]]:
    """Every process that is begun from now on."""
    started: list[subprocess.Popen[str]] = []
    popen = subprocess.Popen

    def noted(*args: object, **more: object) -> subprocess.Popen[str]:
        started.append(popen(*args, **more))  # type: ignore[call-overload]
        return started[-1]

    monkeypatch.setattr(subprocess, "Popen", noted)
    return started


def provided(configuration: Configuration, store: Store) -> Provision:
    homes = Homes(None, configuration.folder, {})
    return Provision(configuration, load_vehicle(configuration.vehicle), store, homes)


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
        monitor: str | None = None,
        modem: str | None = None,
        kind: str = "auv",
        wait: bool = True,
        leave_within: float = 0.0,
        **more: object,
    ) -> None:
        links = LinkUrls(vehicle, gps, topside, modem, monitor)
        configuration = replace(Configuration(), vehicle=kind, links=links, folder=folder, **more)  # type: ignore[arg-type]
        self.told: list[str] = []
        self.ready: Ready | None = None
        self.server: Server | None = None
        self.store = store or DiskStore(configuration.store)
        self._configuration, self._speed = configuration, speed
        self._leave_within = leave_within
        self._began = time.monotonic()
        self._loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self._run)
        self.thread.start()
        if wait:
            soon(lambda: self.ready is not None or not self.thread.is_alive(), "listening")

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._main())
        self._loop.close()

    async def _main(self) -> None:
        self.server = Server(
            provided(self._configuration, self.store),
            self.told.append,
            self._announce,
            self._speed,
            leave_within=self._leave_within,
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

    def tells_within_its_rate(self, words: str, things: int = 1) -> bool:
        """At least once; of each of so many things a line and a count a minute, however long this
        has run, and however fast."""
        minutes = 1 + int((time.monotonic() - self._began) // AGAIN_S)
        told = sum(words in line for line in self.told)
        return 1 <= told <= 2 * things * minutes

    def call(self, what: Callable[[], object]) -> None:
        """In its loop."""
        self._loop.call_soon_threadsafe(what)

    def tell_to_end(self) -> None:
        """As by SIGTERM."""
        if self.server is not None and self.thread.is_alive():
            self.call(self.server.stop)

    def stop(self) -> None:
        self.tell_to_end()
        self.thread.join(PATIENCE)
        assert not self.thread.is_alive()


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


@contextmanager
def looked_into(device: str) -> Iterator[Callable[[], bool]]:
    """Whether bytes wait in a port that somebody else reads."""
    port = os.open(device, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        yield lambda: bool(select.select([port], [], [], 0)[0])
    finally:
        os.close(port)


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
