"""What each trick of this program spares: the same work without it and with it, in turns, in one run.

    python tests/bench/bench_tricks.py

    tuples       a named tuple is made as a tuple is, past its own constructor (``tuple.__new__``)
    collector    work during which Python's cyclic collector is off (``mission.onboard.uncollected``),
                 and what was imported taken out of its sight (``mission.onboard.serve.preload``)
    switching    how soon a busy thread gives way to the loop (``sys.setswitchinterval``)

A ratio is without by with: a trick that spares nothing has 1, and goes. Times are those of the
process, the least of some rounds; only timers are of the wall.
"""

from __future__ import annotations

import contextlib
import gc
import random
import statistics
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench")]

from bench_language import judge, mission_of  # noqa: E402
from bench_wire import frames  # noqa: E402

from mission.authoring.prepare import prepare  # noqa: E402
from mission.onboard.serve.foreground import SWITCH_S  # noqa: E402
from mission.onboard.uncollected import uncollected  # noqa: E402
from mission.verification.simulation import flight  # noqa: E402
from protocol.framing import fault  # noqa: E402
from protocol.messages import FrameFault, Telemetry  # noqa: E402
from protocol.vehicles.auv import AuvCodec  # noqa: E402

ROUNDS = 3  # of what takes seconds
SHORT_ROUNDS, MADE = 60, 1000  # of what takes a millisecond: the best of many
LEGS = 1000
TIMERS, EVERY_S = 300, 0.002
Work = Callable[[], object]


def main() -> dict[str, float]:
    say = sys.stdout.write
    faults, reports = a_fault(), a_report()
    judged, pause = collecting(lambda: judge(mission_of(LEGS)))
    flown, _ = collecting(fly, mock.patch.object(flight, "uncollected", contextlib.nullcontext))
    seen, frozen = looking()
    late, soon = lateness(0.005), lateness(SWITCH_S)
    say(f"a fault {faults:.1f}, a report {reports:.1f} times as long by its constructor\n")
    say(
        f"judging {LEGS} legs {judged:.2f}, a flight {flown:.2f} times as long with the collector\n"
    )
    say(f"its longest pause in the judging: {pause * 1e3:.0f} ms\n")
    say(f"a look through everything {seen * 1e3:.0f} ms, {frozen * 1e3:.1f} ms once it is frozen\n")
    say(f"timers beside a busy thread, median: {late * 1e3:.1f} ms late by Python's 5 ms, ")
    say(f"{soon * 1e3:.1f} ms by {SWITCH_S * 1e3:g} ms\n")
    return {
        "fault_ratio": faults,
        "report_ratio": reports,
        "judge_ratio": judged,
        "judge_pause_ms": pause * 1e3,
        "flight_ratio": flown,
        "freeze_ratio": seen / frozen,
        "switch_ratio": late / soon,
    }


def spent(work: Work) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun


def ratio(without: Work, with_it: Work, rounds: int) -> float:
    """In turns, so that a machine that grows slower meanwhile favours neither."""
    took = [(spent(without), spent(with_it)) for _ in range(rounds)]
    return min(t for t, _ in took) / min(t for _, t in took)


# --- tuples ---------------------------------------------------------------------------------------


def a_fault() -> float:
    def by(make: Callable[[int, str, int], FrameFault]) -> Work:
        return lambda: [make(n, "bad_header", 1) for n in range(MADE)]

    return ratio(by(FrameFault), by(fault), SHORT_ROUNDS)


def a_report() -> float:
    """As the stream's reader makes it, without what it reads."""
    (report, *_) = AuvCodec().receive(frames(random.Random(1))[0], 0.0)
    assert isinstance(report, Telemetry)
    made: Callable[..., Telemetry] = tuple.__new__
    assert made(Telemetry, tuple(report)) == report
    named = dict(zip(Telemetry._fields, report, strict=True))
    return ratio(
        lambda: [Telemetry(**named) for _ in range(MADE)],
        lambda: [made(Telemetry, (*report,)) for _ in range(MADE)],
        SHORT_ROUNDS,
    )


# --- the collector ----------------------------------------------------------------------------------


def collecting(
    work: Work, on: contextlib.AbstractContextManager[object] | None = None
) -> tuple[float, float]:
    """How many times as long the work takes, and the collector's longest pause in it, s. ``on``
    keeps the work itself from switching the collector off."""
    pauses = [0.0]
    begun = [0.0]

    def told(phase: str, info: dict[str, int]) -> None:
        if phase == "start":
            begun[0] = time.perf_counter()
        else:
            pauses.append(time.perf_counter() - begun[0])

    def without() -> None:
        with on or contextlib.nullcontext(), _heard(told):
            work()

    def with_it() -> None:
        with uncollected():
            work()

    return ratio(without, with_it, ROUNDS), max(pauses)


@contextlib.contextmanager
def _heard(told: Callable[[str, dict[str, int]], None]) -> Iterator[None]:
    gc.callbacks.append(told)
    try:
        yield
    finally:
        gc.callbacks.remove(told)


def fly() -> None:
    ready = prepare("first-dive")
    flight.fly(ready.mission, ready.vehicle, seed=1)


def looking() -> tuple[float, float]:
    """Seconds of a collection of everything, before and after it is frozen."""
    gc.collect()
    seen = min(spent(gc.collect) for _ in range(ROUNDS))
    gc.freeze()
    frozen = min(spent(gc.collect) for _ in range(ROUNDS))
    gc.unfreeze()
    return seen, max(frozen, 1e-5)


# --- switching ------------------------------------------------------------------------------------


def lateness(interval: float) -> float:
    """Median of what timers are late beside a thread that computes, s."""
    before, stop = sys.getswitchinterval(), threading.Event()

    def compute() -> None:
        while not stop.is_set():
            sum(range(2000))

    busy = threading.Thread(target=compute)
    sys.setswitchinterval(interval)
    busy.start()
    try:
        late = []
        for _ in range(TIMERS):
            due = time.perf_counter() + EVERY_S
            time.sleep(EVERY_S)
            late.append(time.perf_counter() - due)
        return statistics.median(late)
    finally:
        stop.set()
        busy.join()
        sys.setswitchinterval(before)


if __name__ == "__main__":
    main()
