"""One vehicle, four who look at it: by TLS or TCP, by modem, at the monitor, and on the Pi. All see
the same.

Real serve, sockets, certificates and acoustic modems, in real time, for every vehicle.
"""

from __future__ import annotations

import itertools
import json
import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from served import PATIENCE, Running, running, soon

from links import open_link
from links.acoustic import Water
from links.simulated.pty import PtyVehicle
from links.simulated.settings import Settings
from links.simulated.water import Channel
from mission.authoring.language import digest, parse, script
from mission.model.shipped import load_vehicle
from mission.onboard.serve.keys import make_keys
from mission.topside.console import converse, observe
from mission.topside.looking import Looked, look
from mission.topside.monitor import Watched, wish
from mission.topside.showing import as_object
from mission.topside.sources import frame_of
from mission.topside.upload import start, upload
from mission.verification.rig.vehicle import simulated

MISSIONS = {
    "auv": """mission look vehicle auv
home 30.2874595 120.1535765
safety radius 600 time 20min depth 10 voltage 10
assume current 0.1
dive: depth 3 heading 0 gear 4 until depth >= 2.5 timeout 90
out: depth 3 heading 90 gear 4 for 4min
up: surface timeout 3min
""",
    "coreboard": """mission look vehicle coreboard
home 30.2874595 120.1535765
safety radius 600 time 20min depth 20 voltage 12
assume current 0.1
dive: depth 4 heading 90 gear 6 until depth >= 3.7 timeout 90s
hold: depth 4 heading 180 gear 4 for 4min
up: surface until fix timeout 3min
""",
    "rov": """mission look vehicle rov
safety time 20min depth 20
assume current 0
start without fix
out: gear 2 for 60s
up: surface timeout 3min
""",
    "robot": """mission look vehicle robot
safety time 20min
assume start 0
start without fix
out: gear 2 for 4min
""",
}
TRIES = 5  # of a look between two instants of the Pi that are the same


class Truth(NamedTuple):
    """What all must agree on."""

    state: str
    leg: str
    setpoint: str
    alarms: frozenset[str]


class Scene:
    """``pi`` and the ways to it; ``scheme``: of its ports, tls or tcp."""

    def __init__(self, pi: Running, folder: Path, modem: str, scheme: str) -> None:
        assert pi.server is not None
        self.folder, self.watched, self.over = folder, Watched(), threading.Event()
        self.boat = _end(scheme, _port(pi.url), folder, "boat")
        self.modem = f"modem+serial://{modem}?range=50&rate=9600"
        viewing: Any = pi.server.viewing
        soon(lambda: viewing.port.link is not None, "the monitor's port")
        self._viewer = _end(scheme, viewing.port.link.port, folder, "guest")
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()

    def _watch(self) -> None:
        for _ in observe(self._viewer, wish(), self.watched):
            if self.over.is_set():
                return

    def close(self) -> None:
        self.over.set()
        self._thread.join(PATIENCE)

    # --- who looks -----------------------------------------------------------------------------

    def status(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads((self.folder / "status.json").read_text())
        return found

    def local(self) -> Truth:
        found = self.status()
        return _truth(found, found["alarms"])

    def viewed(self) -> Truth:
        soon(lambda: bool(self.watched.state), "the monitor's first frame")
        return _truth(self.watched.state, self.watched.state["alarms"])

    def looked(self, url: str) -> Looked:
        found: list[Looked] = []
        under_water = url == self.modem
        converse(url, look(found.append, under_water=under_water, now=time.monotonic))
        return found[0]

    def asked(self, url: str) -> Truth:
        told = as_object(self.looked(url))
        return _truth(told, told["alarms"])

    def framed(self, url: str) -> Truth:
        """As `watch --frames` has it."""
        state = frame_of(self.looked(url), 100.0)["state"]
        return _truth(state, state["alarms"])

    def all_agree(self, state: str) -> None:
        soon(lambda: re.fullmatch(state, self.local().state) is not None, f"the Pi is in {state}")
        for who, ask in (
            ("the monitor", self.viewed),
            ("the boat by network", lambda: self.asked(self.boat)),
            ("the boat by modem", lambda: self.asked(self.modem)),
            ("watch --frames by modem", lambda: self.framed(self.modem)),
        ):
            self._agrees(who, state, ask)

    def _agrees(self, who: str, state: str, ask: Callable[[], Truth]) -> None:
        seen = []
        for _ in range(TRIES):
            before = self.local()
            told = ask()
            wall = time.time()
            soon(lambda wall=wall: self.status()["wall"] > wall, "the Pi tells")  # type: ignore[misc]
            if before == self.local():
                seen.append((before, told))
                if before == told:
                    return
        pytest.fail(f"{who} in {state}: {seen}")

    def send(self, *frames: bytes) -> None:
        link = open_link("boat", self.boat)
        for frame in frames:
            link.send(frame, time.monotonic())
        link.close()


def _truth(told: Any, alarms: Any) -> Truth:
    """A leg's state is its leg: @AE tells each by itself. None: a question came to nothing."""
    names = frozenset(alarm["name"] for alarm in alarms)
    state = re.sub("^autonomous/.*", "autonomous", told["state"] or "")
    return Truth(state, told["leg"] or "", told["setpoint"] or "", names)


def _end(scheme: str, port: int, folder: Path, role: str) -> str:
    """``role``: whose keys, where there are any."""
    keys = f"?keys={folder / 'keys' / role}" if scheme.startswith("tls") else ""
    return f"{scheme}://127.0.0.1:{port}{keys}"


def _port(url: str) -> int:
    found = re.search(r":(\d+)", url)
    assert found is not None, url
    return int(found[1])


@contextmanager
def threaded(run: Callable[[Callable[[], bool]], object]) -> Iterator[threading.Event]:
    over = threading.Event()
    thread = threading.Thread(target=lambda: run(over.is_set))
    thread.start()
    try:
        yield over
    finally:
        over.set()
        thread.join(PATIENCE)


@contextmanager
def at_sea(folder: Path, name: str, scheme: str) -> Iterator[tuple[Scene, threading.Event]]:
    """The scene, and what ends the board."""
    make_keys(folder / "keys", ("boat",), lambda path: None, ("guest",))
    listen = _end(f"{scheme}-listen", 0, folder, "vehicle")
    with ExitStack() as held:
        channel = held.enter_context(Channel(Water(50.0, 9600.0)))
        held.enter_context(threaded(channel.run))
        board = PtyVehicle(simulated(load_vehicle(name), 1, Settings()))
        held.callback(board.close)
        over = held.enter_context(threaded(lambda stop: board.run(stop=stop)))
        ports = dict(zip(("vehicle", "gps"), (f"serial://{p}" for p in board.paths), strict=False))
        far, near = channel.paths
        pi = held.enter_context(
            running(
                folder, **ports, topside=listen, monitor=listen,
                modem=f"serial://{near}", kind=name,
            )
        )  # fmt: skip
        scene = Scene(pi, folder, far, scheme)
        held.callback(scene.close)
        yield scene, over


FIRST = {("tls", "auv"), ("tcp", "robot")}  # the others repeat them


@pytest.mark.proof
@pytest.mark.parametrize(
    ("scheme", "name"),
    [
        pytest.param(scheme, name, marks=() if (scheme, name) in FIRST else pytest.mark.minutes)
        for scheme, name in itertools.product(("tls", "tcp"), MISSIONS)
    ],
)
def test_boat_modem_and_viewer_see_what_the_pi_sees_in_every_state(
    scheme: str, name: str, tmp_path: Path
) -> None:
    mission = parse(MISSIONS[name])
    with at_sea(tmp_path, name, scheme) as (scene, board):
        scene.all_agree("idle/empty")
        lines = script(mission)
        converse(scene.boat, upload(lines, digest(mission), lambda have, total: None))
        scene.all_agree("idle/ready")
        converse(scene.boat, start(patience=60))
        scene.all_agree("autonomous")
        with threaded(lambda stop: _steer(scene, stop)):
            scene.all_agree("manual/driving")
        scene.all_agree("manual/waiting")
        scene.send(b"@ZAX0$")
        scene.all_agree("emergency/stopped")
        scene.send(b"@ZAWF$")
        scene.all_agree("emergency/.*")
        board.set()
        soon(lambda: "old report" in scene.local().alarms, "the board is gone")
        scene.all_agree("emergency/.*")


def _steer(scene: Scene, stop: Callable[[], bool]) -> None:
    link = open_link("boat", scene.boat)
    while not stop():
        link.send(b"@MMF1$", time.monotonic())
        time.sleep(0.2)
    link.close()
