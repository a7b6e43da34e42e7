"""Flights in two processes of the pool, and of a Dask cluster, against two processes by hand.

    python tests/bench/bench_campaign.py [rounds]

By hand: each process flies its half when a line comes, and says when it has. All processes are there
and warm before a clock runs; a job is some seconds of flight. The three take turns, because two
cores of a machine that others use do not always give twice one; the best time of each counts.

Then empty jobs on the cluster: the processor time of scheduler and command for each, which bounds how
many jobs a second they can hand out. It hardly depends on what else the machine does.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PATH = [str(ROOT), str(ROOT / "tests" / "bench")]
sys.path[:0] = PATH

from links.simulated.settings import Settings  # noqa: E402
from mission.authoring.language import parse  # noqa: E402
from mission.model.shipped import load_vehicle  # noqa: E402
from mission.verification.campaign.trial import try_out  # noqa: E402
from mission.verification.workers import working  # noqa: E402
from mission.verification.workers.outcome import had  # noqa: E402
from mission.verification.workers.places import Place, place  # noqa: E402

JOBS, WORKERS, ROUNDS = 8, 2, 5
EMPTY = 2000  # jobs
MISSION = """mission half-hour vehicle auv
home 30.2874595 120.1535765
safety radius 2000 time 60min depth 30
assume current 0.1
dive: ZAS8 heading 90 ZAF4 until depth >= 7.5 timeout 2min
repeat 9 rows:
  out: heading 90 ZAF4 for 100s
  back: heading 270 ZAF4 for 100s
end
up: surface timeout 2min
"""
BY_HAND = """
import sys, bench_campaign
bench_campaign.job("warm")
print(flush=True)
for line in sys.stdin:
    for name in line.split():
        bench_campaign.job(name)
    print(flush=True)
"""
Turn = Callable[[], float]  # flies all jobs once; s


def job(name: str) -> str:
    """Every job is the same flight: none of the halves is the longer one."""
    trial = try_out(parse(MISSION), load_vehicle("auv"), "as-built", 1, Settings())
    return f"{name} {trial.state}"


def clocked(fly: Callable[[], object]) -> float:
    begun = time.perf_counter()
    fly()
    return time.perf_counter() - begun


@contextmanager
def by_hand() -> Iterator[Turn]:
    hands = [_program("-c", BY_HAND, pipe=subprocess.PIPE) for _ in range(WORKERS)]
    names = [f"job{n}" for n in range(JOBS // WORKERS)]

    def told() -> None:
        for hand in hands:
            assert hand.stdout is not None
            hand.stdout.readline()

    def fly() -> None:
        for hand in hands:
            assert hand.stdin is not None
            hand.stdin.write(" ".join(names).encode() + b"\n")
            hand.stdin.flush()
        told()

    told()
    try:
        yield lambda: clocked(fly)
    finally:
        for hand in hands:
            _end(hand)


@contextmanager
def at(where: Place) -> Iterator[Turn]:
    with working(job, where) as batch:

        def fly(word: str = "job") -> None:
            for outcome in batch(f"{word}{n}" for n in range(JOBS)):
                had(outcome)

        fly("warm")
        yield lambda: clocked(fly)


@contextmanager
def cluster() -> Iterator[tuple[Place, int]]:
    """The place, and the process of the scheduler."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as programs:
        file = str(Path(folder) / "scheduler.json")
        calls = [["dask_scheduler", "--host", "127.0.0.1", "--port", "0"]]
        calls += [["dask_worker", "--nthreads", "1", "--local-directory", folder]] * WORKERS
        begun = []
        for call in calls:
            module = f"distributed.cli.{call[0]}"
            more = ["--scheduler-file", file, "--no-dashboard"]
            begun.append(_program("-m", module, *call[1:], *more))
            programs.callback(_end, begun[-1])
        yield place(f"dask://{_address(Path(file))}"), begun[0].pid


def _address(file: Path) -> str:
    until = time.monotonic() + 60.0
    while not (file.exists() and file.stat().st_size) and time.monotonic() < until:
        time.sleep(0.1)
    return str(json.loads(file.read_text())["address"]).partition("://")[2]


def _program(*call: str, pipe: int = subprocess.DEVNULL) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, *call],
        stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, start_new_session=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(PATH)},
    )  # fmt: skip


def _end(program: subprocess.Popen[bytes]) -> None:
    os.killpg(program.pid, signal.SIGKILL)
    program.wait()


def per_job(far: Place, scheduler: int) -> tuple[float, float]:
    """ms of the processor that scheduler and this process take for a job."""
    with working(abs, far) as batch:
        list(batch(range(WORKERS)))
        before, own = _used(scheduler), time.process_time()
        list(batch(range(EMPTY)))
        taken = _used(scheduler) - before, time.process_time() - own
    return taken[0] * 1e3 / EMPTY, taken[1] * 1e3 / EMPTY


def _used(pid: int) -> float:
    """s of the processor."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main(rounds: int = ROUNDS) -> dict[str, float]:
    say = sys.stdout.write
    processes = place("processes", WORKERS)
    with ExitStack() as all_of_it:
        far, scheduler = all_of_it.enter_context(cluster())
        hand, pool, dask = map(all_of_it.enter_context, (by_hand(), at(processes), at(far)))
        turns = {"by hand": hand, "pool": pool, "dask": dask}
        times: dict[str, list[float]] = {name: [] for name in turns}
        for _ in range(rounds):
            for name, turn in turns.items():
                times[name].append(turn())
        each = per_job(far, scheduler)
    best = {name: min(found) for name, found in times.items()}
    for name, found in times.items():
        told = ", ".join(f"{t:.2f}" for t in found)
        say(f"{name:8}: {best[name]:6.2f} s ({100 * best['by hand'] / best[name]:.1f} %); {told}\n")
    say(f"an empty job: {each[0]:.2f} ms of the scheduler, {each[1]:.2f} ms of the command\n")
    return {name: 100.0 * best["by hand"] / best[name] for name in ("pool", "dask")}


if __name__ == "__main__":
    import bench_campaign  # the workers look for the job by this name

    bench_campaign.main(*map(int, sys.argv[1:]))
