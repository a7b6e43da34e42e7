"""Killed at any moment, a disk that fills at any byte: the vehicle surfaces, nothing is corrupt.

Real processes on pseudo-terminals, killed with SIGKILL and started again as the service manager
would (deploy/auvmission.service: RestartSec=1). AUVMISSION_KILLS=n for more than the few of a
usual run. Everything waits for events: how long it takes is measured by tests/bench/bench_survival.
"""

from __future__ import annotations

import itertools
import json
import os
import random
import re
import resource
import signal
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest
from ports import free_port

from links.simulated.link import SimulatedVehicle
from links.simulated.pty import PtyVehicle
from links.simulated.settings import Settings
from mission.analysis.replay.replay import replay
from mission.authoring.language import digest, parse, script
from mission.model import Record
from mission.onboard.blackbox import BlackBox, read_parts
from mission.onboard.runtime.records import RX
from mission.onboard.store import DiskStore, StoreError
from mission.topside.console import converse
from mission.topside.upload import OperatorError, start, upload
from protocol.messages import SetSafety

KILLS = int(os.environ.get("AUVMISSION_KILLS", "4"))
RESTART_S = 1.0  # RestartSec of the unit
FIRST_W_S = 10.0  # from the kill
PATIENCE = 180.0  # the machine may have other things to do
TEXT = """mission pool vehicle auv
home 30.2874595 120.1535765
safety radius 400 time 20min depth 10 voltage 10
assume current 0.1
dive: depth 3 heading 0 gear 4 until depth >= 2.5 timeout 90
out: heading 90 gear 6 for {seconds}s
up: surface timeout 3min
"""
MISSIONS = [parse(TEXT.format(seconds=seconds)) for seconds in (100, 110)]


def soon(holds: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, f"not within {PATIENCE} s: {what}"
        time.sleep(0.005)


class Service:
    """serve in a process of its own, and who starts it again."""

    def __init__(self, folder: Path, vehicle: str, gps: str = "none", speed: float = 1.0) -> None:
        self.url = f"tcp://127.0.0.1:{free_port()}"
        self.folder, self._ready = folder, folder / "ready.json"
        self._command = [sys.executable, "-m", "mission", "serve", "--vehicle", vehicle]
        self._command += ["--gps", gps, "--topside", self.url, "--folder", str(folder)]
        self._command += ["--speed", str(speed), "--ready-file", str(self._ready)]
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self._ready.unlink(missing_ok=True)
        self._process = subprocess.Popen(
            self._command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

    def wait_ready(self) -> None:
        soon(self._ready.exists, "ready")

    def kill(self) -> None:
        if self._process is not None:
            self._process.send_signal(signal.SIGKILL)
            self._process.wait()
            self._process = None

    def computing(self) -> float:
        """s of the processor's time that it has had so far."""
        assert self._process is not None
        stat = Path(f"/proc/{self._process.pid}/stat").read_text()
        user, system = stat.rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def boxes(self) -> list[Path]:
        return sorted((self.folder / "log").glob("*.mcap"))


@contextmanager
def service(folder: Path, *links: str, speed: float = 1.0) -> Iterator[Service]:
    made = Service(folder, *links, speed=speed)
    try:
        yield made
    finally:
        made.kill()


@contextmanager
def silent_board() -> Iterator[str]:
    master, slave = os.openpty()
    tty.setraw(slave)
    try:
        yield f"serial://{os.ttyname(slave)}"
    finally:
        os.close(master)
        os.close(slave)


def quiet(have: int, total: int) -> None:
    """Nobody watches."""


@pytest.mark.proof
def test_killed_at_any_moment_of_an_upload_the_store_holds_one_mission_whole(
    tmp_path: Path,
) -> None:
    chance = random.Random(5)
    lines = [tuple(script(mission)) for mission in MISSIONS]
    accepted: tuple[str, ...] = ()
    with silent_board() as device, service(tmp_path, device) as pi:
        for turn in range(KILLS):
            mine = lines[turn % 2]
            pi.start()
            pi.wait_ready()
            said: list[str] = []

            def talk(n: int = turn % 2, said: list[str] = said) -> None:
                with suppress(OperatorError):
                    talk = upload(lines[n], digest(MISSIONS[n]), quiet)
                    said.append(converse(pi.url, talk))

            operator = threading.Thread(target=talk)
            operator.start()
            time.sleep(chance.uniform(0.0, 0.4))
            pi.kill()
            operator.join(PATIENCE)
            found = DiskStore(tmp_path / "store").content
            assert found.damage == ()
            assert found.lines in (accepted, mine)
            if said:
                assert found.lines == mine, "an accepted mission is never lost"
            accepted = found.lines
        for box in pi.boxes():
            records = list(read_parts(box))
            assert not records or replay(records).identical  # killed before its first flush


class Sea:
    """The simulated vehicle on pseudo-terminals; ``heard``: what the STM32 was sent, and when."""

    def __init__(self, seed: int, speed: float) -> None:
        self._vehicle = PtyVehicle(SimulatedVehicle("as-built", seed, Settings()), speed)
        self.links = [f"serial://{path}" for path in self._vehicle.paths]
        self.heard: list[tuple[float, bytes]] = []
        self._receive = self._vehicle.vehicle.stm32.receive
        self._vehicle.vehicle.stm32.receive = self._hear  # type: ignore[method-assign]
        self._over = threading.Event()
        self._thread = threading.Thread(
            target=self._vehicle.run, kwargs={"stop": self._over.is_set}
        )

    def _hear(self, data: bytes, now: float) -> None:
        self.heard.append((time.monotonic(), data))
        self._receive(data, now)

    @property
    def depth(self) -> float:
        return self._vehicle.vehicle.truth().depth

    def since(self, t: float) -> list[tuple[float, bytes]]:
        return [(at, data) for at, data in self.heard if at > t]

    def words(self, t: float) -> list[tuple[float, bytes]]:
        """Since then, however the port cut them; one that is tried again counts once."""
        each = [(at, word) for at, data in self.since(t) for word in re.findall(rb"@[^$]*\$", data)]
        return [next(run) for _, run in itertools.groupby(each, key=lambda one: one[1])]

    def __enter__(self) -> Sea:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join(PATIENCE)
        self._vehicle.close()


@dataclass(frozen=True, slots=True)
class Killed:
    """``first_up``: s from the kill to the U12. ``computing``: s of the processor's time from the start of the
    next program, as far as that is known by then."""

    first_up: float
    computing: float


def killed_in_a_mission(folder: Path, turn: int, speed: float, pause: float) -> Killed:
    """The vehicle is then at the surface, and nothing is lost or corrupt."""
    lines = script(MISSIONS[0])
    with Sea(turn, speed) as sea, service(folder, *sea.links, speed=speed) as pi:
        pi.start()
        pi.wait_ready()
        converse(pi.url, upload(lines, digest(MISSIONS[0]), quiet))
        converse(pi.url, start(patience=int(PATIENCE)))
        soon(lambda: b"@ZAS3$" in (data for _, data in sea.heard), "the first set of the mission")
        time.sleep(pause)
        pi.kill()
        killed = time.monotonic()
        time.sleep(RESTART_S)
        pi.start()
        soon(lambda: len(sea.words(killed)) > 1, "two commands")
        computing = pi.computing()
        words = sea.words(killed)[:2]  # no depth is known yet (R7)
        assert [word for _, word in words] == [b"@ZAX0$", b"@ZAU12$"]
        first = words[1][0]
        soon(lambda: sea.depth < 0.5, "at the surface")
        found = DiskStore(folder / "store").content
        assert (found.lines, found.damage) == (tuple(lines), ())
        pi.kill()
        assert len(pi.boxes()) == 2
        assert all(replay(list(read_parts(box))).identical for box in pi.boxes())
    return Killed(first - killed, computing)


@pytest.mark.proof
def test_killed_in_a_mission_the_first_commands_after_the_restart_are_upward(
    tmp_path: Path,
) -> None:
    chance = random.Random(6)
    for turn in range(max(1, KILLS // 4)):
        (tmp_path / str(turn)).mkdir()
        killed_in_a_mission(tmp_path / str(turn), turn, 8.0, chance.uniform(0.0, 1.0))


@contextmanager
def full_after(size: int) -> Iterator[None]:
    """The kernel lets no file of this process grow beyond so many bytes, and writes parts of it."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_disk_that_fills_at_any_byte_leaves_the_old_content_of_the_store(tmp_path: Path) -> None:
    store = DiskStore(tmp_path)
    store.keep_lines(("old", "mission"))
    store.keep_limits(SetSafety(100.0, 60.0, 5.0, 11.0))
    store.keep_under_way("autonomous/old")
    before = store.content
    refused = 0
    for size in range(120):
        with full_after(size):
            for keep in (
                lambda: store.keep_lines(("a new mission", "of two lines")),
                lambda: store.keep_limits(SetSafety(1.0, 1.0, 1.0, 1.0)),
                lambda: store.keep_under_way("emergency/surfacing"),
            ):
                try:
                    keep()
                except StoreError:
                    refused += 1
        there = DiskStore(tmp_path).content
        assert there == store.content, "what it says and what is on the disk agree"
        for now, old in zip(
            (there.lines, there.limits, there.under_way),
            (before.lines, before.limits, before.under_way),
            strict=True,
        ):
            assert now == old or size >= len("sha256 ") + 64
    assert refused > 200
    assert store.content != before, "and it recovers"


def test_a_disk_that_fills_at_any_byte_splits_no_record_of_the_black_box(tmp_path: Path) -> None:
    records = [Record(i / 8, RX, bytes([i]) * (10 + i)) for i in range(12)]
    whole = BlackBox(tmp_path / "whole.mcap", shell=True)
    whole.store(b"")
    begun = (tmp_path / "whole.mcap").stat().st_size
    for record in records:
        whole.record(record)
    whole.store(whole.take(), sync=True)
    size = (tmp_path / "whole.mcap").stat().st_size
    whole.close()
    for limit in range(begun, size, 7):
        path = tmp_path / f"{limit}.mcap"
        box = BlackBox(path, shell=True)
        for record in records[:8]:
            box.record(record)
        with full_after(limit):
            box.store(box.take(), sync=True)
            there = list(read_parts(path))
            assert there == records[: len(there)]
        for record in records[8:]:
            box.record(record)
        box.store(box.take(), sync=True)
        assert box.failure == ""
        assert list(read_parts(path)) == records, "nothing was lost, nothing is split"
        box.close()


@pytest.mark.proof
def test_the_health_file_is_whole_at_any_moment(tmp_path: Path) -> None:
    with silent_board() as device, service(tmp_path, device) as pi:
        pi.start()
        pi.wait_ready()
        file = tmp_path / "status.json"
        soon(file.exists, "the file")
        for _ in range(300):
            assert json.loads(file.read_text())["state"] == "idle/empty"
            time.sleep(0.004)
