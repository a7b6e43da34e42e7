"""Every bench in turn, and at the end one table: figure, reached, wanted.

    python tests/bench/run.py [hour latency ...]

All figures are ratios within one run or bounds that a slow machine meets as well. What a figure
means stands in its bench; each can be run by itself, with more runs.
"""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench")]


@dataclass(frozen=True, slots=True)
class Figure:
    """One row of the table: ``key`` is the bench's own name for what it measured."""

    key: str
    says: str
    unit: str
    bound: float
    at_least: bool = False

    def met(self, value: float) -> bool:
        return value >= self.bound if self.at_least else value <= self.bound

    def line(self, value: float) -> str:
        wanted = f"{'at least' if self.at_least else 'at most'} {self.bound:g} {self.unit}"
        reached = f"{value:.2f} {self.unit}"
        verdict = "yes" if self.met(value) else "NO"
        return f"  {self.says:<52} {reached:>12}   {wanted:<18} {verdict}\n"


@dataclass(frozen=True, slots=True)
class Bench:
    module: str
    says: str
    run: Callable[[Any], dict[str, float] | None]
    figures: tuple[Figure, ...] = ()


BENCHES = (
    Bench(
        "bench_language",
        "reading and judging large missions",
        lambda module: module.main(),
        (
            Figure("read_s", "1000 legs read, processor time", "s", 1.0),
            Figure("judged_s", "1000 legs read, compiled and checked", "s", 3.0),
            Figure("growth", "up to 5000 legs, against n log n", "x", 1.5),
        ),
    ),
    Bench(
        "bench_hour",
        "one hour of mission",
        lambda module: module.main(),
        (
            Figure("hour_ratio", "an hour of mission, times as fast as naive parts", "x", 15, True),
            Figure("black_box_ratio", "the same with its black box", "x", 1.5),
        ),
    ),
    Bench(
        "bench_latency",
        "serve: latency, idle, start",
        lambda module: module.main(),
        (
            Figure("latency_p99_ms", "@SD in to @ZA out beyond the wire, p99", "ms", 5),
            Figure("idle_cpu", "idle serve, share of a core", "%", 2),
            Figure("idle_rss", "idle serve, memory", "MB", 160),
            Figure("help_s", "auvmission --help", "s", 0.3),
            Figure("import_s", "import mission.cli", "s", 0.3),
        ),
    ),
    Bench(
        "bench_navigation",
        "the filter",
        lambda module: module.main(),
        (Figure("ratio", "filterpy against the same equations in numpy", "x", 1.5),),
    ),
    Bench(
        "bench_wire",
        "the wire",
        lambda module: module.main(),
        (
            Figure("stream_mavutil_ratio", "the stream decoder against mavutil", "x", 5, True),
            Figure("stream_ratio", "the same against pymavlink's bare parser", "x", 5, True),
            Figure("log_ratio", "a whole log against the bare parser", "x", 15, True),
        ),
    ),
    Bench(
        "bench_survival",
        "killed in a mission",
        lambda module: module.main(),
        (
            Figure(
                "first_up_s", "kill -9 to the first upward word, restart after 1 s, worst", "s", 10
            ),
            Figure("computing_s", "processor time of it, an eighth of 9 s at most", "s", 1.12),
        ),
    ),
    Bench(
        "bench_flood",
        "an order through a flood",
        lambda module: module.main(),
        (Figure("through_flood_s", "X or W through a flood, worst", "s", 2.0),),
    ),
    Bench(
        "bench_viewers",
        "ten slow viewers",
        lambda module: module.main(),
        (
            Figure("viewers_report_ms", "@SD to @ZA, with ten slow viewers, later by", "ms", 1.0),
            Figure("viewers_x_ms", "X of the boat, with ten slow viewers, later by", "ms", 1.0),
        ),
    ),
    Bench(
        "bench_console",
        "the cockpit",
        lambda module: module.main(),
        (
            Figure("answer_ms", "a text judged while it is written, slowest shipped", "ms", 50),
            Figure("pages_share", "five pages of a vehicle, share of a core", "%", 5),
            Figure("day_mb", "a day of records, what its second half adds", "MiB", 4),
        ),
    ),
    Bench(
        "bench_records",
        "recording",
        lambda module: module.main(),
        (Figure("record_s", "recording an hour of mission, processor time", "s", 0.1),),
    ),
    Bench(
        "bench_parts",
        "guards, compiler, sieve",
        lambda module: module.main(),
        (
            Figure("guards_ratio", "ten comparisons against one dispatch", "x", 1.0),
            Figure("compile_s", "1000 legs compiled, processor time", "s", 1.0),
            Figure("compile_growth", "up to 4000 legs, against n log n", "x", 2.0),
            Figure("sieve_mbit", "sifting a flood", "Mbit/s", 100, True),
        ),
    ),
    Bench(
        "bench_campaign",
        "flights in two processes",
        lambda module: module.main(),
        (
            Figure("pool", "the pool, of two processes by hand", "%", 97, True),
            Figure("dask", "a Dask cluster, of two processes by hand", "%", 93, True),
        ),
    ),
    Bench(
        "bench_tricks",
        "tricks, without by with",
        lambda module: module.main(),
        (
            Figure("fault_ratio", "a fault by its constructor, of one as a tuple", "x", 1.2, True),
            Figure(
                "report_ratio", "a report by its constructor, of one as a tuple", "x", 1.5, True
            ),
            Figure("judge_ratio", "judging with the collector, of without", "x", 1.03, True),
            Figure("flight_ratio", "a flight with the collector, of without", "x", 1.0, True),
            Figure("freeze_ratio", "a collection before freezing, of after", "x", 10.0, True),
            Figure("switch_ratio", "late timers by Python's interval, of ours", "x", 1.5, True),
        ),
    ),
    Bench(
        "bench_growth",
        "what grows how",
        lambda module: module.main(),
        (
            Figure("legs_growth", "a leg more to check, up to 5000 against to 3000", "x", 1.5),
            Figure("hours_growth", "an hour more of flight, up to 24 against to 10", "x", 1.5),
        ),
    ),
    Bench("bench_modem", "the modem", lambda module: module.main(2)),
)


def main(names: list[str]) -> int:
    say = sys.stdout.write
    known = [bench.module.removeprefix("bench_") for bench in BENCHES]
    if unknown := sorted(set(names) - set(known)):
        say(f"no bench {', '.join(unknown)}; there are {', '.join(known)}\n")
        return 2
    lines: list[str] = []
    for bench, name in zip(BENCHES, known, strict=True):
        if names and name not in names:
            continue
        say(f"\n--- {bench.says} ({bench.module}.py) ---\n")
        sys.stdout.flush()
        begun = time.perf_counter()
        reached = bench.run(importlib.import_module(bench.module)) or {}
        say(f"({time.perf_counter() - begun:.0f} s)\n")
        for figure in bench.figures:
            skipped = f"  {figure.says:<52} {'skipped':>12}\n"
            value = reached.get(figure.key)
            lines.append(skipped if value is None else figure.line(value))
    say("\n" + f"  {'figure':<52} {'reached':>12}   {'wanted':<18} met\n")
    for line in lines:
        say(line)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
