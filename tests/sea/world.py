"""Everything in one water: body, board, receiver, modem, operators, Pi, and the record of a flight."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from ports import free_port

from tests.sea.body import Body, Gears
from tests.sea.clock import Clock, WallClock
from tests.sea.operator import ModemOperator, Operator
from tests.sea.pi import ROOT, Pi
from tests.sea.receiver import Receiver
from tests.sea.wire import PATIENCE, Line

TICK = 0.01  # s
BODY_EVERY = 3  # ticks
HOPELESS = 5


class Device(Protocol):
    """A board: hears bytes, says bytes, drives the thrusters."""

    words: list[Any]
    gears: Gears

    def hear(self, now: float, data: bytes) -> None: ...
    def control(self, now: float, dt: float) -> Gears: ...
    def tick(self, now: float) -> None: ...


@dataclass
class Sample:
    """The truth at one time."""

    at: float
    depth: float
    rate: float
    turning: bool
    up: float  # mean gear of the verticals, upward positive
    level: bool  # right way up


@dataclass
class World:
    """One scene's water. `vehicle` names the vehicle file, a path if a scene makes its own."""

    body: Body
    make_board: Callable[[Body, Line], Any]
    seed: int = 0
    vehicle: str = "auv"
    baud: int = 9600
    gps: bool = True
    receiver_mode: str = "honest"
    modem: bool = False
    settings: str = ""
    real: bool = False  # the machine's time instead of the sea's
    marks: dict[str, float] = field(default_factory=dict)
    samples: list[Sample] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    bound: tuple[float, float, float] = (0.0, 0.0, 0.0)  # time s, depth m, range m, as was proved
    operators: list[Operator] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.clock = WallClock() if self.real else Clock()
        self.folder = Path(tempfile.mkdtemp(prefix="sea-pi-"))
        self.line = Line(self.baud)
        self.line.link(self.folder / "serial0")
        self.lines = [self.line]
        self.board = self.make_board(self.body, self.line)
        self.receiver: Receiver | None = None
        if self.gps:
            self.lines.append(Line(9600))
            self.lines[-1].link(self.folder / "gps0")
            self.receiver = Receiver(self.body, self.lines[-1], self.seed, self.receiver_mode)
        self.acoustic: ModemOperator | None = None
        if self.modem:
            self.lines.append(Line(115200))
            self.acoustic = ModemOperator(self.lines[-1], lambda: self.clock.now)
        self.port = free_port()
        self.pi = Pi(self.clock, self.folder, before=self._flush)
        self.pi.config.write_text(self.configuration())
        self._tasks: list[Iterator[None]] = []
        self._ticks = 0

    @property
    def now(self) -> float:
        """The sea's time in s."""
        return self.clock.now

    def configuration(self) -> str:
        """serve.yaml."""
        gps = f'"serial://{self.receiver.line.path}"' if self.receiver else "null"
        modem = f'"serial://{self.acoustic.line.path}"' if self.acoustic else "null"
        return (
            f"vehicle: {self.vehicle}\n"
            f"folder: {self.pi.state}\n"
            "links:\n"
            f'  vehicle: "serial://{self.line.path}?baud={self.baud}"\n'
            f"  gps: {gps}\n  modem: {modem}\n"
            f'  topside: "tcp-listen://127.0.0.1:{self.port}"\n'
            f"{self.settings}"
        )

    def _flush(self) -> None:
        for line in self.lines:
            line.flush()
            line.taken = 0

    def operator(self, name: str = "boat") -> Operator:
        """A new connection."""
        boat = Operator(self.port, lambda: self.clock.now, name)
        boat.keep()
        self.operators.append(boat)
        return boat

    def spawn(self, task: Iterator[None]) -> None:
        """Have something go on beside the script."""
        self._tasks.append(task)

    def mark(self, name: str) -> None:
        """Put a time on record, the first time."""
        self.marks.setdefault(name, self.now)

    def wait(self, seconds: float) -> Iterator[None]:
        """Let time pass."""
        until = self.now + seconds
        while self.now < until:
            yield

    def until(self, what: Callable[[], bool], within: float) -> Iterator[None]:
        """Let time pass until something is so, `within` s at most."""
        end = self.now + within
        while self.now < end and not what():
            yield

    def rest(self, seconds: float, quiet: float = 30.0) -> Iterator[None]:
        """Let time pass; less, once it has floated for `quiet` s with nothing turning."""
        until, since = self.now + seconds, self.now
        while self.now < until and self.now - since < quiet:
            if self.body.depth > 0.6 or self.board.gears.turning():
                since = self.now
            yield

    def held(self, seconds: float, steady: float = 50.0) -> Iterator[None]:
        """Let time pass; less, once it has been less than 1 m deep for `steady` s, whatever turns."""
        until, since = self.now + seconds, self.now
        while self.now < until and self.now - since < steady:
            if self.body.depth > 1.0:
                since = self.now
            yield

    def command(self, *words: str, to: str = "") -> Iterator[None]:
        """An operator's `auvmission` command, to its end; its code and text are noted."""
        process = subprocess.Popen(
            [sys.executable, "-m", "mission", *words, "--to", to or f"tcp://127.0.0.1:{self.port}"],
            cwd=ROOT,
            env={**os.environ, "HOME": str(self.folder)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        assert process.stdout
        with process, process.stdout as output:
            pace = time.monotonic() - self.now
            while process.poll() is None:  # it has a clock of its own: no faster than that
                time.sleep(max(0.0, pace + self.now - time.monotonic()))
                yield
            text = " ".join(output.read().decode().split())
        self.notes.append(f"{words[0]}={process.returncode} {text}")

    def run(self, script: Iterator[None]) -> None:
        """The whole flight; broken off when the program has ended by itself `HOPELESS` times."""
        self.pi.start()
        for _ in script:
            if len(self.pi.ended) >= HOPELESS:
                return
            self._tasks = [task for task in self._tasks if next(task, self) is None]
            self._tick()

    def _tick(self) -> None:
        self.board.tick(self.now)
        if self.receiver:
            self.receiver.tick(self.now)
        if self.acoustic:
            self.acoustic.tick(self.now)
        self.clock.advance(TICK)
        wrote = sum(line.pump(self.now, self.clock.taken) for line in self.lines) > 0
        for boat in self.operators:
            boat.keep()
            wrote, boat.wrote = wrote or boat.wrote, False
            if boat.waits_until > self.now:
                self.clock.strict_until = max(self.clock.strict_until, self.now + 0.1)
        self.pi.step(wrote)
        self._hear()
        for boat in self.operators:
            boat.receive()
        self._ticks += 1
        if self._ticks % BODY_EVERY == 0:
            self._move(TICK * BODY_EVERY)

    def _hear(self) -> None:
        """What the program has written; all of it, for the kernel takes its time."""
        patience = time.monotonic() + PATIENCE
        while True:
            self.board.hear(self.now, self.line.receive())
            if self.acoustic:
                self.acoustic.receive()
            missing = self.clock.written() - sum(line.taken for line in self.lines)
            if missing <= 0 or time.monotonic() > patience:
                return
            os.sched_yield()

    def _move(self, dt: float) -> None:
        gears = self.board.control(self.now, dt)
        self.body.step(gears, dt)
        roll, _, _ = self.body.attitude()
        self.samples.append(
            Sample(
                self.now,
                self.body.depth,
                self.body.rate(),
                gears.turning(),
                sum(gears.up) / 3,
                math.cos(math.radians(roll)) > 0,
            )
        )

    def close(self) -> None:
        """Give everything back."""
        self.pi.close()
        for boat in self.operators:
            boat.close()
        for line in self.lines:
            line.close()
        self.clock.close()
        shutil.rmtree(self.folder, ignore_errors=True)
