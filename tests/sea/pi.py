"""The Pi: the program as a process, and what systemd does with it.

As deploy/auvmission.service says: started again one second after any end that nobody asked for;
SIGTERM and 300 s of patience for one that was asked for. A start takes `BOOT` s of the sea's time, in
which no program runs and the vehicle goes on; what is then left of the start costs no time.
"""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from tests.sea.clock import Clock

ROOT = Path(__file__).resolve().parents[2]
BOOT = 2.0  # s from exec to the first wait
RESTART = 1.0  # s, RestartSec of the unit
PATIENCE = 300.0  # s, TimeoutStopSec


def _dies_with_the_sea() -> None:
    """No serve outlives a sea that was killed (prctl(2), PR_SET_PDEATHSIG = 1)."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)


@dataclass
class Pi:
    """One `serve` in `folder` (config, state and its own output), and its systemd."""

    clock: Clock
    folder: Path
    process: subprocess.Popen[bytes] | None = None
    starts: int = 0
    ended: list[tuple[float, int]] = field(default_factory=list)  # unasked: time, return code
    wanted: bool = True  # systemd wants it to run
    without: str = ""  # a module that its next start cannot import
    full: bool = False  # no file grows any more, at later starts neither
    read_only: bool = False  # later starts can change no file
    booted: float = 0.0  # s, when the Pi was switched on
    before: Callable[[], None] = lambda: None
    _asked: bool = False
    _due: float | None = None
    _stop_by: float = float("inf")

    @property
    def config(self) -> Path:
        """The configuration file."""
        return self.folder / "serve.yaml"

    @property
    def state(self) -> Path:
        """The folder that the configuration names."""
        return self.folder / "state"

    def running(self) -> bool:
        """Whether the process lives."""
        return self.process is not None and self.process.poll() is None

    def start(self) -> None:
        """Begin `serve`, and wait until it waits."""
        self.before()
        self.starts += 1
        with (self.folder / f"output.{self.starts}").open("wb") as output:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "mission", "serve", "--config", str(self.config)],
                cwd=ROOT,
                env={
                    **os.environ,
                    **self.clock.environment(),
                    "HOME": str(self.folder),
                    "SEA_WITHOUT": self.without,
                    "SEA_READ_ONLY": str(self.folder) if self.read_only else "",
                    "SEA_BOOT": str(self.booted),
                },
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                preexec_fn=_dies_with_the_sea,
            )
        if self.full:
            self.fill_disk()
        self.clock.begin(self.process.pid, self.running)

    def step(self, wrote: bool) -> None:
        """Let the program do what is due, if it lives; restart it when systemd would."""
        if self.process and self.running():
            self.clock.wake(wrote, self.process.pid, self.running)
        if self.process and not self.running():
            if not self._asked:
                self.ended.append((self.clock.now, self.process.returncode))
            self._asked = False
            self.process, self._stop_by = None, float("inf")
            self._due = self.clock.now + RESTART + BOOT if self.wanted else None
        if self.process and self.clock.now > self._stop_by:
            self.process.kill()
        if self._due is not None and self.clock.now >= self._due and self.wanted:
            self._due = None
            self.start()

    def signal(self, which: int) -> None:
        """Send a signal; SIGKILL is what a crash looks like."""
        if self.process and self.running():
            self._asked = True
            self.process.send_signal(which)
            if which == signal.SIGKILL:
                self.process.wait()

    def fill_disk(self) -> None:
        """From now on no write to a file succeeds: Python gets an OSError (setrlimit(2), EFBIG)."""
        self.full = True
        if self.process and self.running():
            resource.prlimit(self.process.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))

    def power_cut(self) -> None:
        """The Pi loses its power and has it back: a crash, and a monotonic clock that begins anew."""
        self.signal(signal.SIGKILL)
        self.booted = self.clock.now

    def systemctl_stop(self) -> None:
        """SIGTERM, and no restart."""
        self.wanted = False
        self._stop_by = self.clock.now + PATIENCE
        self.signal(signal.SIGTERM)

    def close(self) -> None:
        """End what still runs."""
        self.wanted = False
        if self.process:
            self.process.kill()
            self.process.wait()
            self.process = None

    def output(self) -> str:
        """What the program printed, all starts."""
        files = sorted(self.folder.glob("output.*"))
        return "".join(f"--- start {file.suffix[1:]}\n{file.read_text()}" for file in files)
