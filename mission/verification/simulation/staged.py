"""A simulated vehicle and its serve as two further processes, over real bytes.

    auvmission vehicle   <-- pty ----------->  auvmission serve    <-- TCP -->  the operator
    (board, body, GPS)   <-- pty: GPS ------>  (the Pi's program)

Both have the same time factor, and end with the process that started them.

    DemoError      (a part of the set-up does not work; the message says which process and why)
"""

from __future__ import annotations

import json
import os
import queue
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mission.authoring.prepare import Prepared
from mission.model.shipped import vehicle_file

PORTS = range(10_000, 32_000)  # UDP ports of buses, below those that systems assign themselves
READY_S = 20.0  # real s until a process must report that it is ready
STOP_S = 10.0  # real s for a process to end when told
HURRY_S = 0.5  # the same, if this process was interrupted


class DemoError(RuntimeError):
    pass


@dataclass(frozen=True, slots=True)
class Stage:
    """``named``: the vehicle's file or name. ``port``: that of serve for the boat, 0: any."""

    prepared: Prepared
    folder: Path
    named: str
    speed: float
    seed: int
    settings: tuple[str, ...]
    port: int = 0

    @contextmanager
    def vehicle(self) -> Iterator[dict[str, Any]]:
        command = [sys.executable, "-m", "mission", "vehicle", self._vehicle_file()]
        command += ["--folder", str(self.folder), "--port", str(self.port), "--json"]
        command += ["--seed", str(self.seed), "--speed", str(self.speed)]
        command += ["--track", str(self.folder / "truth.csv"), "--bus", own_bus(os.getpid())]
        for setting in self.settings:
            command += ["--set", setting]
        home = self.prepared.mission.home
        if home is not None:
            command += [f"--position={home.latitude_deg},{home.longitude_deg}"]
        with self._process("the simulated vehicle", command) as lines:
            yield lines.take(READY_S)

    @contextmanager
    def serve(self, vehicle: dict[str, Any]) -> Iterator[Lines]:
        command = [sys.executable, "-m", "mission", "serve", "--config", vehicle["config"]]
        command += ["--speed", str(self.speed), "--events"]
        with self._process("auvmission serve", command) as lines:
            yield lines

    def _vehicle_file(self) -> str:
        """Write the vehicle file in the dialect that is flown, and return its path."""
        text = vehicle_file(self.named).read_text(encoding="utf-8")
        dialect = f"dialect: {self.prepared.vehicle.dialect}"
        path = self.folder / "vehicle.yaml"
        path.write_text(re.sub(r"(?m)^dialect:.*", dialect, text), encoding="utf-8")
        return str(path.resolve())

    @contextmanager
    def _process(self, name: str, command: list[str]) -> Iterator[Lines]:
        log = self.folder / f"{name.split()[-1]}.log"
        with log.open("w", encoding="utf-8") as errors:
            process = subprocess.Popen(
                command,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
                env=os.environ | {"AUVMISSION_STOP_S": "0"},  # no vehicle has to come up
            )
            lines = Lines(name, process, log)
            patience = HURRY_S
            try:
                yield lines
                patience = STOP_S
            finally:
                process.terminate()
                try:
                    process.wait(patience)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()
                lines.close()


def own_bus(process: int) -> str:
    """Return the URL of a CAN bus that no other process of this computer uses for a simulated
    vehicle. The port differs, too, since multicast frames reach all who listen to a port, whatever
    the group."""
    group = f"{192 + (process >> 16) % 64}.{process >> 8 & 255}.{process & 255}"
    return f"can://239.{group}:{PORTS.start + process % len(PORTS)}?interface=udp_multicast"


@contextmanager
def told_to_end() -> Iterator[None]:
    """End the other processes also on SIGTERM and when the terminal is closed, as on ctrl-C."""

    def end(number: int, _: object) -> None:
        raise SystemExit(128 + number)

    before = {number: signal.signal(number, end) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Lines:
    """JSON lines of a process, read in a thread."""

    def __init__(self, name: str, process: subprocess.Popen[str], log: Path) -> None:
        self._name, self._process, self._log = name, process, log
        self._queue: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._is_read = True
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if self._is_read:
                self._queue.put(line)
        self._queue.put(None)

    def ignore(self) -> None:
        """Drop the lines that come from now on."""
        self._is_read = False

    def close(self) -> None:
        """Join the reader and close the pipe, once the process has ended."""
        self._reader.join(STOP_S)
        if self._process.stdout is not None and not self._reader.is_alive():
            self._process.stdout.close()

    def take(self, seconds: float) -> dict[str, Any]:
        """Return the next line. Raises DemoError if none comes within ``seconds``."""
        try:
            line = self._queue.get(timeout=seconds)
        except queue.Empty:
            raise DemoError(f"{self._name} says nothing after {seconds:.0f} s") from None
        if line is None:
            raise self._ended()
        found: dict[str, Any] = json.loads(line)
        return found

    def waiting(self) -> Iterator[dict[str, Any]]:
        while True:
            try:
                line = self._queue.get_nowait()
            except queue.Empty:
                return
            if line is None:
                raise self._ended()
            yield json.loads(line)

    def _ended(self) -> DemoError:
        said = self._log.read_text(encoding="utf-8").strip()
        return DemoError(f"{self._name} has ended: {said or 'without a word'}")
