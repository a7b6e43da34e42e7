"""Parts that must be cheap, each against what it spares or what it has to keep up with.

    python tests/bench/bench_parts.py

Ten comparisons of guards asked outside the machine, against one dispatch of it; the compiler on
its own; the rate limiter, against the fastest link that could fill it.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "worlds")]

from engine_world import World, compiled, leg, mission, when  # noqa: E402

from links.base import Rx  # noqa: E402
from mission.engine.machine import Machine  # noqa: E402
from mission.model import And, Comparison, Exit, Group, Guard, Mission  # noqa: E402
from mission.onboard.serve.rate_limiter import RateLimiter  # noqa: E402

FLOOD = 64 * 1024  # bytes at a time
SMALL, LARGE = 1000, 4000  # legs


def main() -> dict[str, float]:
    outside, dispatch = guards()
    small, large = compiling(SMALL), compiling(LARGE)
    growth = large / small / (LARGE * math.log(LARGE) / (SMALL * math.log(SMALL)))
    rate = sifting()
    say = sys.stdout.write
    say(f"ten comparisons {outside * 1e6:.1f} us, one dispatch {dispatch * 1e6:.1f} us\n")
    say(f"compiling 1000 legs {small:.2f} s, 4000 legs {growth:.2f} times what n log n grows\n")
    say(f"sifting a flood {rate / 1e6:.0f} Mbit/s\n")
    return {
        "guards_ratio": outside / dispatch,
        "compile_s": small,
        "compile_growth": growth,
        "sieve_mbit": rate / 1e6,
    }


def least(work: Callable[[], object], times: int) -> float:
    """Processor time of the quickest: whatever else the machine does is not the work's."""
    took = []
    for _ in range(times):
        begun = time.process_time()
        work()
        took.append(time.process_time() - begun)
    return min(took)


def guards() -> tuple[float, float]:
    names = ("depth", "altitude", "elapsed", "range", "battery")
    exits = [
        Exit(Guard(And((Comparison(n, ">", 900.0), Comparison(n, ">", 950.0))))) for n in names
    ]
    group = Group("g", 1, (leg("a", *exits, timeout=20000.0), leg("b", timeout=20000.0)))
    world = World(mission(group))
    assert world.start()
    core = world.engine.core
    run, vehicle_state = core.run, core.vehicle_state
    assert run is not None
    assert run.look(vehicle_state) is None
    machine = Machine(core.chart)

    def dispatch() -> None:
        machine.restore("autonomous/g/a")
        machine.fire("autonomous/g/a:until1")

    return least(lambda: run.look(vehicle_state), 2000), least(dispatch, 2000)


def compiling(legs: int) -> float:
    made = long_mission(legs)
    return least(lambda: compiled(made), 2)


def long_mission(n: int) -> Mission:
    legs = [leg(f"l{i}", when("depth", ">", 1)) for i in range(n)]
    return mission(*(Group(f"g{k}", 2, tuple(legs[k : k + 10])) for k in range(0, n, 10)))


def sifting() -> float:
    """Bits per second of one that never stops."""
    limiter, flood = RateLimiter(0.0), (b"@AQ$" * FLOOD)[:FLOOD]
    heard = [Rx(n * 1e-4, "topside", flood, "127.0.0.1:1") for n in range(200)]
    spent = least(lambda: [limiter.passes(rx, heard[-1].t) for rx in heard], 3)
    return 8 * FLOOD * len(heard) / spent


if __name__ == "__main__":
    main()
