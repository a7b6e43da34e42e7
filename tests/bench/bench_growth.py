"""What grows how: the real programs on small and on large work, until they bend.

    python tests/bench/bench_growth.py [SWEEP ...]          tables, as docs/growth.md has them
    python tests/bench/bench_growth.py --write [SWEEP ...]  into the page and its picture

A size of a sweep is a process of its own. Of a command the processor time and the most memory that
it ever had count; of `serve` the share of a core that it takes, the memory that it has, and how long
an X of the boat takes to the board. A line bends where, from there to its end, a unit more costs half
as much again as up to there: that is told of time and of memory, of what is more than noise.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench")]

PAGE = ROOT / "docs" / "growth.md"
PICTURE = ROOT / "docs" / "pictures" / "growth.svg"
BENT = 1.5
NOISE = (0.15, 4.0)  # of a time in s or a share in %, and of a memory in MB
DEEP = 15
PER_MB = 5.8  # rounds of `of_rounds(_, 190)` that fill a MB of the black box
ALLOWED = (
    ("time", "240 min", "2880 min"),
    ("radius", "2000 m", "30000 m"),
    ("usable", "900", "90000"),
)
HEAD = """mission grows vehicle auv
home 30.2874595 120.1535765
safety radius 30000 time 2880min depth 30
assume current 0.1
"""


@dataclass(frozen=True, slots=True)
class Cost:
    """``time``: s of processor, or of serve % of a core; ``memory``: MB; ``order``: ms, of serve."""

    time: float
    memory: float
    order: float | None = None


@dataclass(frozen=True, slots=True)
class Sweep:
    """``counted``: what a size is a number of; marginal costs are told of ``per`` of them."""

    says: str
    counted: str
    per: int
    sizes: tuple[int, ...]
    measure: Callable[[int], Cost]
    served: bool = False


# --- what is measured ---


def command(*words: str) -> Cost:
    """The quickest of four runs of the program, or of as many as begin within 10 s: what else the
    machine does only adds. RuntimeError where it refuses: a refusal costs less than what it did not
    do."""
    costs = [_run(words)]
    while len(costs) < 4 and sum(cost.time for cost in costs) < 10.0:
        costs.append(_run(words))
    return min(costs, key=lambda cost: cost.time)


def _run(words: Sequence[str]) -> Cost:
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "mission", *words], cwd=ROOT, stdout=said, stderr=said
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            said.seek(0)
            raise RuntimeError(f"{words}: exit {process.returncode}\n{said.read().decode()}")
    return Cost(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def of_legs(count: int) -> str:
    """Legs of a second each."""
    words = (f"heading {90 if n % 2 else 270} ZAS{1 + n % 4} ZAF4 for 1s" for n in range(count - 1))
    legs = "".join(f"leg_{n}: {word}\n" for n, word in enumerate(words))
    return f"{HEAD}{legs}up: surface timeout 2min\n"


def of_lines(count: int) -> str:
    """So many lines: the head, groups of two legs of a second, of four lines each, and the end."""
    groups, legs = divmod(count - HEAD.count("\n") - 1, 4)
    body = (
        "".join(
            f"group g{n}:\n  out: heading 90 ZAS{1 + n % 4} ZAF4 for 1s\n  back: heading 270 for 1s\nend\n"
            for n in range(groups)
        )
        + "heading 90 ZAF4 for 1s\n" * legs
    )
    return f"{HEAD}{body}up: surface timeout 2min\n"


def of_states(count: int) -> str:
    """Two states in three are legs of a second, the others groups, DEEP in one another."""
    into, out = "", ""
    nests = []
    for n in range(count // 3):
        into += f"group g{n}:\n  a{n}: heading 90 ZAS{1 + n % 4} ZAF4 for 1s\n"
        out = f"  b{n}: heading 270 ZAF4 for 1s\nend\n{out}"
        if n % DEEP == DEEP - 1 or n == count // 3 - 1:
            nests.append(into + out)
            into, out = "", ""
    return f"{HEAD}{''.join(nests)}up: surface timeout 2min\n"


def of_rounds(count: int, seconds: int = 5) -> str:
    """Out and back for so long each."""
    return (
        f"{HEAD}dive: ZAS8 heading 90 ZAF4 until depth >= 7.5 timeout 2min\nrepeat {count} rows:\n"
        f"  out: heading 90 ZAF4 for {seconds}s\n"
        f"  back: heading 270 ZAF4 for {seconds}s\nend\n"
        "up: surface timeout 2min\n"
    )


@contextmanager
def mission(text: str) -> Iterator[tuple[str, ...]]:
    """Words of a command for a mission, and a vehicle that is allowed days and has the energy."""
    own = (ROOT / "missions" / "vehicles" / "auv.yaml").read_text()
    for named, less, more in ALLOWED:
        assert f"{named}: {less}" in own
        own = own.replace(f"{named}: {less}", f"{named}: {more}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "auv.yaml").write_text(own)
        (folder / "grows.mission").write_text(text)
        yield str(folder / "grows.mission"), "--vehicle", str(folder / "auv.yaml")


def checked(text: str) -> Cost:
    with mission(text) as words:
        return command("check", *words)


def flown(text: str) -> Cost:
    with mission(text) as words:
        return command("simulate", *words)


def hours(count: int) -> Cost:
    return flown(of_rounds(round(3600 * count / (2 * 190)), 190))


def recorded(count: int, name: str, *options: str) -> Cost:
    """What a command takes for a black box of so many MB, all parts together."""
    text = of_rounds(round(PER_MB * count), 190)
    with mission(text) as words, tempfile.TemporaryDirectory() as folder:
        _run(("simulate", *words, "--report", folder))
        size = sum(part.stat().st_size for part in Path(folder).glob("*.mcap")) / 1e6
        if not 0.9 < size / count < 1.1:
            raise RuntimeError(f"the black box has {size:.1f} MB instead of {count}: see PER_MB")
        out = [option.format(folder) for option in options]
        return command(name, f"{folder}/flight.mcap", *out)


def boats(count: int) -> Cost:
    from growth_served import served

    return Cost(*served(boats=count, viewers=0))


def viewers(count: int) -> Cost:
    from growth_served import served

    return Cost(*served(boats=0, viewers=count))


SWEEPS = {
    "legs": Sweep("`check`, by legs", "legs", 1000, (100, 300, 1000, 3000, 5000), lambda n: checked(of_legs(n))),
    "lines": Sweep("`check`, by lines", "lines", 1000, (300, 1000, 3000, 9999), lambda n: checked(of_lines(n))),
    "rounds": Sweep("`check`, by rounds of two legs", "rounds", 1000, (25, 100, 400, 1600, 2499), lambda n: checked(of_rounds(n))),
    "states": Sweep("`check`, by states", "states", 1000, (300, 1000, 3000, 7494), lambda n: checked(of_states(n))),
    "flown": Sweep("`simulate`, by lines", "lines", 1000, (300, 1000, 3000, 9999), lambda n: flown(of_lines(n))),
    "hours": Sweep("`simulate`, by hours of flight", "hours", 1, (1, 2, 5, 10, 24), hours),
    "log": Sweep("`log`, by MB of the black box", "MB", 1, (2, 5, 10), lambda n: recorded(n, "log")),
    "report": Sweep("`report`, by MB of the black box", "MB", 1, (2, 5, 10), lambda n: recorded(n, "report", "-o", "{}/again.html")),
    "boats": Sweep("`serve`, by boats that ask `@AE` once a second", "boats", 10, (1, 10, 30, 100), boats, served=True),
    "viewers": Sweep("`serve`, by viewers who wish for everything five times a second", "viewers", 10, (1, 10, 30, 100), viewers, served=True),
}  # fmt: skip


# --- what is made of it ---


@dataclass(frozen=True, slots=True)
class Point:
    size: int
    cost: Cost


def marginals(points: Sequence[Point], per: int, of: Callable[[Cost], float]) -> list[float]:
    """What ``per`` more cost, from each point to the next."""
    return [
        per * (of(after.cost) - of(before.cost)) / (after.size - before.size)
        for before, after in itertools.pairwise(points)
    ]


def bend(points: Sequence[Point], of: Callable[[Cost], float], noise: float) -> int | None:
    """The first size beyond which, to the end, one more costs half as much again as up to it;
    None: nowhere. Each difference may be wrong by the noise, and then bends nothing."""
    first, last = points[0], points[-1]
    for point in points[1:-1]:
        before, after = of(point.cost) - of(first.cost), of(last.cost) - of(point.cost)
        each = (max(before, 0.0) + noise) / (point.size - first.size)
        if after > noise and after > BENT * each * (last.size - point.size):
            return point.size
    return None


def table(sweep: Sweep, points: Sequence[Point]) -> str:
    unit = "% of a core" if sweep.served else "s"
    more = f"{sweep.per:,} more" if sweep.per > 1 else "one more"
    head = [sweep.counted, unit, "MB", f"{unit}, {more}", f"MB, {more}"]
    head += ["X to the board, ms"] if sweep.served else []
    rows = [head, ["---"] * len(head)]
    times = ["", *map(_figure, marginals(points, sweep.per, lambda cost: cost.time))]
    memories = ["", *map(_figure, marginals(points, sweep.per, lambda cost: cost.memory))]
    for point, time, memory in zip(points, times, memories, strict=True):
        cost = point.cost
        row = [f"{point.size:,}", _figure(cost.time), f"{cost.memory:.0f}", time, memory]
        rows.append(row + ([f"{cost.order:.1f}"] if cost.order is not None else []))
    return "".join(f"| {' | '.join(row)} |\n" for row in rows) + f"\n{bends(sweep, points)}\n"


def bends(sweep: Sweep, points: Sequence[Point]) -> str:
    """In words."""
    found = {
        "time": bend(points, lambda cost: cost.time, NOISE[0]),
        "memory": bend(points, lambda cost: cost.memory, NOISE[1]),
    }
    up_to = f"up to {points[-1].size:,} {sweep.counted}"
    told = "; ".join(
        f"{what}: no bend {up_to}" if at is None else f"{what}: bends at {at:,} {sweep.counted}"
        for what, at in found.items()
    )
    return f"{told[0].upper()}{told[1:]}."


def _figure(value: float) -> str:
    return f"{value:.2f}" if abs(value) < 10 else f"{value:.0f}"


def measured(name: str) -> list[Point]:
    return [Point(size, SWEEPS[name].measure(size)) for size in SWEEPS[name].sizes]


def main(names: Sequence[str] = ()) -> dict[str, float]:
    """For `make bench`: what a leg more to check, and an hour more of flight, cost at the end of
    their lines, against the beginning."""
    figures = {}
    for name in names or ("legs", "hours"):
        points = measured(name)
        sys.stdout.write(f"{SWEEPS[name].says}\n{table(SWEEPS[name], points)}\n")
        before, last = marginals([points[0], *points[-2:]], 1, lambda cost: cost.time)
        figures[f"{name}_growth"] = last / before
    return figures


def write(names: Sequence[str]) -> None:
    from growth_picture import draw, filled

    for name in names or SWEEPS:
        told = table(SWEEPS[name], measured(name))
        sys.stdout.write(f"{SWEEPS[name].says}\n{told}\n")
        sys.stdout.flush()
        PAGE.write_text(filled(PAGE.read_text(), {name: told}))
    draw(PAGE.read_text(), PICTURE)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--write"]:
        write(sys.argv[2:])
    else:
        main(sys.argv[1:])
