"""``auvmission serve`` as a process of its own: how fast it answers, and what it costs to wait.

    python tests/bench/bench_latency.py [reports]

latency    A scripted STM32 on a pseudo-terminal says ``@SD`` with a heading that opens a guard each
           time, the last byte goes out at a known instant, and the first byte of ``@ZA`` that comes
           back is timed. Nothing paces the pseudo-terminal, so what is measured is beyond the wire.
bare       The same with a process that answers each report with one byte and does nothing else:
           what the machine itself takes to wake a process and to move the bytes.
idle       The share of a core and the memory of a serve that hears an ``@SD`` every 2 s and two GPS
           sentences every second, without a mission, for some seconds after everything is loaded.
start      ``auvmission --help`` and ``import mission.cli``, the median of some processes.
"""

from __future__ import annotations

import json
import os
import re
import select
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT)]

from mission.authoring.language import digest, parse, script  # noqa: E402
from mission.topside.console import converse  # noqa: E402
from mission.topside.upload import start, upload  # noqa: E402
from protocol.nmea import encode_gga, encode_rmc  # noqa: E402
from protocol.vehicles.auv import ACTUATORS, MAGNETOMETERS, SD  # noqa: E402

HOME = 30.2874595, 120.1535765
MISSION = """mission latency vehicle auv
home 30.2874595 120.1535765
safety radius 1500 time 230min depth 30
assume current 0
repeat 150 rounds:
  deep: ZAS3 heading 90 until heading >= 95 timeout 20s
  high: ZAS1 heading 90 until heading <= 85 timeout 20s
end
up: surface timeout 2min
"""
PAUSE_S = 0.12  # between the last answer and the next report
BARE = """
import os, select, sys
fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
while select.select([fd], [], []) and os.read(fd, 4096):
    os.write(fd, b"x")
"""
WORD = re.compile(rb"@Z([A-Z])[^$]*\$")
IDLE_S, SETTLE_S = 20.0, 4.0
TICKS = os.sysconf("SC_CLK_TCK")


class Board:
    """The STM32 and the GPS receiver: two pseudo-terminals."""

    def __init__(self) -> None:
        self._fds = [*os.openpty(), *os.openpty()]
        for fd in self._fds:
            tty.setraw(fd)
        self.paths = os.ttyname(self._fds[1]), os.ttyname(self._fds[3])
        self._heard = b""
        self._begun = time.monotonic()
        self._tenths = 0

    def close(self) -> None:
        for fd in self._fds:
            os.close(fd)

    def report(self, heading_deg: float) -> float:
        """One ``@SD``; when its last byte was written. No two are alike: nothing is frozen."""
        self._tenths = (self._tenths + 1) % 10
        small = 0.01 * self._tenths
        values: dict[str, float] = {
            "roll_deg": 0.5 + small,
            "pitch_deg": 1.0 - small,
            "yaw_deg": small - heading_deg,
            "temperature_c": 18.0 + small,
            "depth_m": 0.1 + small,
            "altitude_m": 25.0 - small,
        }
        values |= dict.fromkeys(MAGNETOMETERS, 30.0 + small)
        values |= {f"pwm_{name}": 1500 for name in ACTUATORS}
        os.write(self._fds[0], SD.encode(values | {"battery_control": 12, "battery_power": 48}))
        return time.monotonic()

    def fix(self) -> None:
        """An epoch of the receiver, at home."""
        utc = datetime(2025, 6, 1, 8, tzinfo=UTC) + timedelta(seconds=time.monotonic())
        place = tuple(x * 0.017453292519943295 for x in HOME)
        os.write(self._fds[2], encode_gga(utc, *place) + encode_rmc(utc, *place))

    def listen(self, seconds: float) -> float | None:
        """When the first byte came; every whole frame is acknowledged. None: silence."""
        if not select.select([self._fds[0]], [], [], seconds)[0]:
            return None
        came = time.monotonic()
        self._heard += os.read(self._fds[0], 4096)
        for found in list(WORD.finditer(self._heard)):
            os.write(self._fds[0], b"@ACK_Z" + found[0][3:4] + b"Y$")
            self._heard = self._heard[found.end() :]
        return came

    def quiet(self, seconds: float) -> None:
        """Acknowledges all that comes until nothing does."""
        while self.listen(seconds) is not None:
            pass


@contextmanager
def serving(board: Board, folder: Path, *more: str) -> Iterator[tuple[int, str]]:
    """Process id and address of a serve at speed 1; ``more``: further options."""
    ready, (stm32, gps) = folder / "ready", board.paths
    links = [f"--vehicle=serial://{stm32}", f"--gps=serial://{gps}", "--topside=tcp://127.0.0.1:0"]
    command = [sys.executable, "-m", "mission", "serve", *links, f"--folder={folder}", *more]
    with (folder / "said").open("wb") as said:
        process = subprocess.Popen(
            [*command, f"--ready-file={ready}"], cwd=ROOT, stdout=said, stderr=said
        )
    try:
        for _ in range(600):
            if ready.exists() or process.poll() is not None:
                break
            time.sleep(0.05)
        if not ready.exists():
            raise RuntimeError((folder / "said").read_text())
        yield process.pid, json.loads(ready.read_text())["topside"]
    finally:
        process.kill()  # told to end, it would first bring the vehicle up
        process.wait()


@contextmanager
def reporting(board: Board) -> Iterator[None]:
    """A report and a fix each second meanwhile: what is not heard for 5 s starts no mission."""
    over = threading.Event()

    def report() -> None:
        while not over.is_set():
            board.fix()
            board.report(90.0)
            board.quiet(1.0)

    thread = threading.Thread(target=report)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def latency(board: Board, address: str, reports: int) -> list[float]:
    """s from the last byte of a report to the first of the command that follows from it."""
    mission = parse(MISSION)
    for _ in range(8):  # a vehicle that has found itself
        board.fix()
        board.report(90.0)
        board.quiet(0.4)
    with reporting(board):
        converse(address, upload(script(mission), digest(mission), lambda have, total: None))
        converse(address, start(patience=20))
    board.quiet(0.5)
    found = []
    for n in range(reports):
        asked = board.report(80.0 if n % 2 else 100.0)
        answered = board.listen(1.0)
        if answered is None:
            raise RuntimeError(f"report {n}: nothing came back")
        found.append(answered - asked)
        board.quiet(PAUSE_S)
    return found


def bare(reports: int) -> list[float]:
    """s, as ``latency``; the reports are as far apart."""
    board, found = Board(), []
    process = subprocess.Popen([sys.executable, "-c", BARE, board.paths[0]])
    try:
        time.sleep(1.0)
        for _ in range(reports):
            asked = board.report(90.0)
            answered = board.listen(5.0)
            if answered is None:
                raise RuntimeError("the bare process says nothing")
            found.append(answered - asked)
            board.quiet(PAUSE_S)
    finally:
        process.kill()
        process.wait()
        board.close()
    return found


def percentiles(found: list[float]) -> tuple[float, float, float]:
    """Median, 99th and the greatest, ms."""
    ordered = sorted(1e3 * s for s in found)
    return ordered[len(ordered) // 2], ordered[int(0.99 * (len(ordered) - 1))], ordered[-1]


def idle(board: Board, pid: int) -> tuple[float, float]:
    """Share of a core, and MB."""
    begun = spent = 0.0
    for second in range(int(SETTLE_S + IDLE_S)):
        if second == SETTLE_S:
            begun, spent = time.monotonic(), _spent(pid)
        board.fix()
        if second % 2 == 0:
            board.report(90.0)
        board.quiet(1.0)
    share = (_spent(pid) - spent) / (time.monotonic() - begun)
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return share, pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _spent(pid: int) -> float:
    """Process time of another process, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def started(command: list[str], times: int = 7) -> float:
    """Median s from the start of a process to its end."""
    taken = []
    for _ in range(times):
        begun = time.perf_counter()
        subprocess.run([sys.executable, *command], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        taken.append(time.perf_counter() - begun)
    return statistics.median(taken)


def main(reports: int = 200) -> dict[str, float]:
    say = sys.stdout.write
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        board, folder = Board(), Path(name)
        with serving(board, folder) as (pid, address):
            share, memory = idle(board, pid)
            say(f"idle for {IDLE_S:.0f} s: {100 * share:.2f} % of a core, {memory:.0f} MB\n")
            p50, p99, most = percentiles(latency(board, address, reports))
        board.close()
    say(f"{reports} @SD on a pty, last byte in to first byte of @ZA out: p50 {p50:.2f} ms, ")
    say(f"p99 {p99:.2f} ms, most {most:.2f} ms\n")
    bare50, bare99, bare_most = percentiles(bare(reports))
    say(f"  a bare process that answers: p50 {bare50:.2f} ms, p99 {bare99:.2f} ms, ")
    say(f"most {bare_most:.2f} ms\n")
    figures |= {"latency_p50_ms": p50, "latency_p99_ms": p99, "bare_p99_ms": bare99}
    figures |= {"idle_cpu": 100 * share, "idle_rss": memory}
    figures["help_s"] = started(["-m", "mission", "--help"])
    figures["import_s"] = started(["-c", "import mission.cli"])
    nothing = started(["-c", "pass"])
    say(f"auvmission --help {figures['help_s']:.3f} s, import mission.cli ")
    say(f"{figures['import_s']:.3f} s, the bare interpreter {nothing:.3f} s\n")
    return figures


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
