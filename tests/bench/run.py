"""Every bench on the pure and on the compiled build, and at the end one table of both.

    python tests/bench/run.py [hour latency ...]

All figures are ratios within one run or bounds that a slow machine meets as well. What a figure
means stands in its bench; each can be run by itself, with more runs. ``before`` is the figure of the
last tree without a compiled build (227b5c71), measured on a machine of two cores by the benches of
that tree; the worst row of the uploads by today's bench with 100 flights. Compare ratios with it,
and seconds only on a machine that is as fast.

Each bench runs in a process of its own, on one build right after the other. The compiled build is
brought up to date first. Where that fails, the table says so and has the pure build alone.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TREE = ROOT / "build" / "compiled"
PURE, COMPILED = "pure", "compiled"
REPLACING = (PURE,)  # benches that replace functions: compiled code calls its own
INTO = "--into"
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench")]


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of the table. ``key`` is its name in the bench's result, ``bound`` what is wanted,
    ``pure`` what is wanted of the pure build if that is less."""

    key: str
    says: str
    unit: str
    bound: float
    at_least: bool = False
    pure: float | None = None
    before: float | None = None

    def wanted(self, build: str) -> float:
        return self.bound if build == COMPILED or self.pure is None else self.pure

    def met(self, value: float, build: str) -> bool:
        wanted = self.wanted(build)
        return value >= wanted if self.at_least else value <= wanted

    def line(self, build: str, value: float | None) -> str:
        wanted = f"{'at least' if self.at_least else 'at most'} {self.wanted(build):g}"
        before = "-" if self.before is None else f"{self.before:.2f}"
        now = "skipped" if value is None else f"{value:.2f}"
        verdict = "" if value is None else "yes" if self.met(value, build) else "NO"
        says = f"{self.says}, {self.unit}"
        return (
            f"  {says:<64} {build:<9}{before:>9}{now:>9}   {wanted:<14} {verdict}".rstrip() + "\n"
        )


@dataclass(frozen=True, slots=True)
class Bench:
    module: str
    says: str
    figures: tuple[Figure, ...]
    builds: tuple[str, ...] = (PURE, COMPILED)

    @property
    def name(self) -> str:
        return self.module.removeprefix("bench_")


BENCHES = (
    Bench(
        "bench_language",
        "reading and judging large missions",
        (
            Figure("read_s", "1000 legs read, processor time", "s", 1.0, before=0.24),
            Figure("judged_s", "1000 legs read, compiled and checked", "s", 3.0, before=0.41),
            Figure("growth", "up to 5000 legs, against n log n", "x", 1.5, before=0.9),
        ),
    ),
    Bench(
        "bench_hour",
        "one hour of mission",
        (
            Figure(
                "hour_ratio",
                "an hour of mission, as fast as naive parts",
                "x",
                28,
                True,
                13.5,
                before=13.3,
            ),
            Figure("black_box_ratio", "the same with its black box", "x", 1.5, before=1.12),
        ),
    ),
    Bench(
        "bench_latency",
        "serve: latency, idle, start",
        (
            Figure(
                "latency_p99_ms", "@SD in to @ZA out beyond the wire, p99", "ms", 5, before=6.06
            ),
            Figure("idle_cpu", "idle serve, share of a core", "%", 2, before=0.6),
            Figure("idle_rss", "idle serve, memory", "MB", 160, before=123.75),
            Figure("help_s", "auvmission --help", "s", 0.3, before=0.1),
            Figure("import_s", "import mission.cli", "s", 0.3, before=0.05),
        ),
    ),
    Bench(
        "bench_navigation",
        "the filter",
        (Figure("ratio", "filterpy against the same equations in numpy", "x", 1.5, before=1.07),),
    ),
    Bench(
        "bench_wire",
        "the wire",
        (
            Figure(
                "stream_mavutil_ratio",
                "the stream of @SD against mavutil",
                "x",
                10,
                True,
                5,
                before=6.71,
            ),
            Figure(
                "stream_ratio",
                "the same against pymavlink's bare parser",
                "x",
                5,
                True,
                3,
                before=3.47,
            ),
        ),
    ),
    Bench(
        "bench_survival",
        "killed in a mission",
        (
            Figure(
                "first_up_s",
                "kill -9 to the first upward command, restart after 1 s, worst",
                "s",
                10,
            ),
            Figure("computing_s", "processor time of it, an eighth of 9 s at most", "s", 1.12),
        ),
        REPLACING,
    ),
    Bench(
        "bench_flood",
        "an order through a flood",
        (Figure("through_flood_s", "X or W through a flood, worst", "s", 2.0, before=0.34),),
    ),
    Bench(
        "bench_viewers",
        "ten slow viewers",
        (
            Figure("viewers_report_ms", "@SD to @ZA, with ten slow viewers, later by", "ms", 1.0),
            Figure("viewers_x_ms", "X of the boat, with ten slow viewers, later by", "ms", 1.0),
        ),
    ),
    Bench(
        "bench_console",
        "the cockpit",
        (
            Figure("answer_ms", "a text judged while it is written, slowest shipped", "ms", 50),
            Figure("pages_share", "five pages of a vehicle, share of a core", "%", 5),
            Figure("day_mb", "a day of records, what its second half adds", "MiB", 4),
        ),
    ),
    Bench(
        "bench_records",
        "recording",
        (Figure("record_s", "recording an hour of mission, processor time", "s", 0.1),),
    ),
    Bench(
        "bench_parts",
        "guards, compiler, sieve",
        (
            Figure("guards_ratio", "ten comparisons against one dispatch", "x", 1.0, before=0.11),
            Figure("compile_s", "1000 legs compiled, processor time", "s", 1.0, before=0.04),
            Figure("compile_growth", "up to 4000 legs, against n log n", "x", 2.0, before=0.99),
            Figure("sieve_mbit", "sifting a flood", "Mbit/s", 100, True, before=17556.54),
        ),
    ),
    Bench(
        "bench_campaign",
        "flights in two processes",
        (
            Figure("pool", "the pool, of two processes by hand", "%", 97, True),
            Figure("dask", "a Dask cluster, of two processes by hand", "%", 93, True),
        ),
    ),
    Bench(
        "bench_tricks",
        "tricks, without by with",
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
        REPLACING,
    ),
    Bench(
        "bench_growth",
        "what grows how",
        (
            Figure("legs_growth", "a leg more to check, up to 5000 against to 3000", "x", 1.5),
            Figure("hours_growth", "an hour more of flight, up to 24 against to 10", "x", 1.5),
        ),
    ),
    Bench(
        "bench_modem",
        "the modem",
        (
            Figure(
                "upload_ratio",
                "an upload against the limit, median of the worst row",
                "x",
                1.5,
                before=7.47,
            ),
        ),
    ),
)


def reached(bench: Bench, tree: Path, python: Path) -> dict[str, float] | None:
    """The figures of one build, from a process of its own; None if the bench ended in an error."""
    with tempfile.TemporaryDirectory() as folder:
        into = Path(folder) / "figures.json"
        command = [python, tree / "tests" / "bench" / "run.py", INTO, into, bench.name]
        plain = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        if subprocess.run(command, cwd=tree, env=plain, check=False).returncode:
            return None
        return {str(key): float(value) for key, value in json.loads(into.read_text()).items()}


def measure(into: str, name: str) -> int:
    """Run one bench here, on whatever build this is."""
    module = importlib.import_module(f"bench_{name}")
    Path(into).write_text(json.dumps(module.main() or {}))
    return 0


def made() -> bool:
    """Whether the compiled build could be brought up to date."""
    command = [sys.executable, str(ROOT / "hatch_build.py"), str(TREE)]
    return subprocess.run(command, check=False).returncode == 0


def table(
    found: dict[tuple[str, str], dict[str, float] | None], benches: Iterable[Bench]
) -> Iterator[str]:
    """Lines, of figures by module and build; None is a bench that ended in an error."""
    yield f"  {'figure':<64} {'build':<9}{'before':>9}{'now':>9}   {'wanted':<14} met\n"
    for bench in benches:
        for figure in bench.figures:
            for build in bench.builds:
                if (values := found.get((bench.module, build))) is not None:
                    yield figure.line(build, values.get(figure.key))
    for module, build in (of for of, values in found.items() if values is None):
        yield f"{module}.py ended in an error on the {build} build\n"


def main(names: list[str]) -> int:
    say = sys.stdout.write
    known = [bench.name for bench in BENCHES]
    if unknown := sorted(set(names) - set(known)):
        say(f"no bench {', '.join(unknown)}; there are {', '.join(known)}\n")
        return 2
    places = {PURE: (ROOT, Path(sys.executable))}
    if made():
        places[COMPILED] = TREE, TREE / ".venv" / "bin" / "python"
    found = {}
    for bench in BENCHES:
        if names and bench.name not in names:
            continue
        for build in (build for build in bench.builds if build in places):
            say(f"\n--- {bench.says} ({bench.module}.py, {build} build) ---\n")
            sys.stdout.flush()
            begun = time.perf_counter()
            found[bench.module, build] = reached(bench, *places[build])
            say(f"({time.perf_counter() - begun:.0f} s)\n")
    say("\n" + "".join(table(found, BENCHES)))
    if COMPILED not in places:
        say("the compiled build was not measured, because it could not be made: see above\n")
    return int(None in found.values())


if __name__ == "__main__":
    if sys.argv[1:2] == [INTO]:
        raise SystemExit(measure(*sys.argv[2:]))
    raise SystemExit(main(sys.argv[1:]))
