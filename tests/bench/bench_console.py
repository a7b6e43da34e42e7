"""The cockpit: how soon a text is judged while it is written, what five pages cost, what a day leaves.

    python tests/bench/bench_console.py

Sans-IO parts in this process. The answer is that of every shipped mission, the slowest of them told,
each the best of some runs: what is asked for is what the program needs, not what the machine
does beside it. Pages and the day are of the same frames as `tests/console/test_console_stress.py`.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench")]

from mission.console.board import Board  # noqa: E402
from mission.console.plans import checked  # noqa: E402
from mission.model.shipped import shipped_missions  # noqa: E402
from mission.onboard.serve.monitor import Monitor  # noqa: E402
from mission.topside.monitor import Watched, wish  # noqa: E402

RUNS, PAGES = 3, 5
LOOKS, LOOK_S = 1200, 0.05  # a minute, twenty looks a second
DAY_S, EVERY_S = 86_400, 3  # so that what is bounded has come to its bounds


def answers_ms() -> dict[str, float]:
    """Processor time of each shipped mission."""
    texts = {name: path.read_text(encoding="utf-8") for name, path in shipped_missions().items()}
    found = {}
    for name, text in texts.items():
        times = []
        for _ in range(RUNS):
            began = time.process_time()
            checked(text, f"{name}.yaml", None)
            times.append(time.process_time() - began)
        found[name] = min(times) * 1000
    return found


def state(t: float) -> dict[str, Any]:
    """Of which all is new, as large as the real one."""
    return {"report_at": round(t, 2), **{f"value_{n:02}": round(t + n / 7, 3) for n in range(40)}}


def pages_share() -> float:
    """Of a core, for so many pages whose vehicle tells something new five times a second."""
    board, watched = Board(), Watched()
    names = [f"page {n}" for n in range(PAGES)]
    for name in names:
        board.come(name, 0.0)
    began = time.process_time()
    for look in range(LOOKS):
        now = look * LOOK_S
        if look % 4 == 0:
            watched.take({"n": look + 1, "t": now, "state": state(now)}, now)
        for name in names:
            if board.is_due(name, now) and (
                line := board.frame(name, watched, watched.state, now, now)
            ):
                board.answer(name, json.loads(line)["n"], now)
    return (time.process_time() - began) / (LOOKS * LOOK_S) * 100


def day_mb() -> float:
    """What the second half of a day of records adds to the greatest memory of the first."""
    monitor, watched, board = Monitor(), Watched(), Board()
    monitor.connected("console", 0.0)
    monitor.receive("console", wish(), 0.0)
    board.come("page", 0.0)
    greatest = [0.0, 0.0]
    for t in range(0, DAY_S, EVERY_S):
        monitor.event(f"{t} s info: now here")
        monitor.track.add(t, 60.0 + t * 1e-7, 25.0, 3.0)
        _, said = watched.receive(monitor.frame("console", state(t), t, t), t)
        monitor.receive("console", said, t)
        if board.is_due("page", t) and (line := board.frame("page", watched, watched.state, t, t)):
            board.answer("page", json.loads(line)["n"], t)
        half = 2 * t // DAY_S
        greatest[half] = max(greatest[half], memory_mb())
    return greatest[1] - greatest[0]


def memory_mb() -> float:
    """Of this process, resident now."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def main() -> dict[str, float]:
    answers = answers_ms()
    slowest = max(answers, key=lambda name: answers[name])
    say = sys.stdout.write
    for name, took in answers.items():
        say(f"  {name:<24} judged in {took:6.1f} ms\n")
    share, day = pages_share(), day_mb()
    say(f"  {PAGES} pages: {share:.2f} % of a core; a day's second half: {day:.1f} MiB more\n")
    return {"answer_ms": answers[slowest], "pages_share": share, "day_mb": day}


if __name__ == "__main__":
    main()
