"""What a day leaves in the cockpit: the memory of a real page and of its server, hour by hour.

    python tests/bench/bench_page.py            some minutes; needs a Chromium

A monitor tells 24 h as quickly as it is answered: each minute a report, 60 points of the track and six
events. The real console, in a process of its own, passes on as many frames a second as the page
takes. What the page holds is counted behind its garbage collector.
"""

from __future__ import annotations

import math
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "worlds")]

from browser_world import CHROMIUM, FLAGS, playwright  # noqa: E402

from mission.onboard.serve.monitor import Monitor  # noqa: E402

HOURS = (1, 6, 12, 18, 24)
EVERY_S = 60
LEAST_S = 0.03  # of this computer, from frame to frame
VIEWER = "console"
# as `auvmission`, with frames as quick as they are taken instead of five a second
QUICK = """
import json, sys
from mission.console import board, sockets
from mission.onboard.serve import monitor
monitor.FASTEST_HZ, sockets.LOOK_S = 100.0, 0.01
board._WISH = json.dumps({"wish": {"rate": 100, "bytes": 60000, "plan": False}}).encode() + b"\\n"
from mission.cli import main
main(sys.argv[1:])
"""


def state(t: float) -> dict[str, Any]:
    """Of a dive in rows, some 20 m deep."""
    swing = math.sin(t / 300)
    return {
        "state": "autonomous/survey/row", "leg": "survey/row", "reason": f"row {t // 600:.0f}",
        "report_at": t, "fix_at": t - t % 1800, "depth": round(10 + 9 * swing, 2),
        "altitude": round(12 - 9 * swing, 2), "heading": round(180 + 170 * swing, 1),
        "pitch": round(4 * swing, 1), "roll": round(2 * swing, 1), "speed": 0.7,
        "battery": round(16 - t / 86_400, 2), "latitude": round(60 + 0.004 * swing, 7),
        "longitude": round(25 + 0.008 * math.cos(t / 170), 7), "ellipse": [9.0, 6.0, 30.0],
        "current": [0.1, 0.05], "origin": [60.0, 25.0], "alarms": [], "commander": "",
        "to_depth": [round(20 - 9 * swing, 2), 30.0], "to_radius": [400.0, 1000.0],
        "to_voltage": [round(2 - t / 86_400, 2), 14.0], "to_time": [round(1440 - t / 60, 1), 1440.0],
    }  # fmt: skip


class Day:
    """``told``: s that have been; it goes on to ``until`` and waits there."""

    def __init__(self) -> None:
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.url = f"tcp://127.0.0.1:{self._listening.getsockname()[1]}"
        self._monitor, self.told, self.until = Monitor(), 0, 0
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        viewer, _ = self._listening.accept()
        self._monitor.connected(VIEWER, 0.0)
        while said := viewer.recv(65_536):
            self._monitor.receive(VIEWER, said, time.monotonic())
            while self.told >= self.until:
                time.sleep(LEAST_S)
            time.sleep(LEAST_S)
            viewer.sendall(self._next())

    def _next(self) -> bytes:
        for t in range(self.told, self.told + EVERY_S):
            there = state(t)
            place = there["latitude"], there["longitude"], there["depth"]
            self._monitor.track.add(float(t), *place)
        for n in range(6):
            self._monitor.event(
                f"{self.told + n} s info: word MMF4: on to the next place of the row"
            )
        self.told += EVERY_S
        now = time.monotonic()
        return self._monitor.frame(VIEWER, state(float(self.told)), float(self.told), now)


def figures(page: Any, console: int) -> tuple[float, float, float]:
    """MiB of the page's heap, nodes of its document, MiB of the server."""
    told = page.context.new_cdp_session(page)
    told.send("HeapProfiler.collectGarbage")
    told.send("Performance.enable")
    found = {one["name"]: one["value"] for one in told.send("Performance.getMetrics")["metrics"]}
    told.detach()
    held = Path(f"/proc/{console}/statm").read_text(encoding="ascii").split()[1]
    server = int(held) * os.sysconf("SC_PAGE_SIZE") / 2**20
    return found["JSHeapUsedSize"] / 2**20, found["Nodes"], server


def measured(page: Any, console: int, day: Day, seen: list[str]) -> None:
    for hour in HOURS:
        day.until = hour * 3600
        while day.told < day.until:
            page.wait_for_timeout(200)
        page.wait_for_timeout(1000)
        heap, nodes, server = figures(page, console)
        row = f"| {hour} | {len(seen)} | {heap:.1f} | {nodes:.0f} | {server:.0f} |\n"
        sys.stdout.write(row)
        sys.stdout.flush()


def main() -> None:
    day = Day()
    sys.stdout.write("| h | frames on the page | its heap, MiB | its nodes | server, MiB |\n")
    with tempfile.TemporaryDirectory() as home:
        words = ["console", "--to", "tcp://127.0.0.1:9", "--monitor", day.url, "--no-browser"]
        console = subprocess.Popen(
            [sys.executable, "-c", QUICK, *words], stdout=subprocess.PIPE, text=True,
            env={**os.environ, "HOME": home, "PYTHONPATH": str(ROOT)},
        )  # fmt: skip
        try:
            assert console.stdout is not None
            address = console.stdout.readline().removeprefix("open ").strip()
            with playwright.sync_playwright() as running:
                chromium = running.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
                page, seen = chromium.new_page(locale="en-GB"), list[str]()
                page.on("websocket", lambda one: one.on("framereceived", lambda _: seen.append("")))
                page.goto(address)
                measured(page, console.pid, day, seen)
                chromium.close()
        finally:
            console.kill()
            console.communicate()


if __name__ == "__main__":
    main()
