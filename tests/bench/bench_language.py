"""Reading and judging large missions: seconds for 1000 legs, and how they grow up to 5000, which is nearly as long as a mission may be.

python tests/bench/bench_language.py
"""

from __future__ import annotations

import gc
import math
import sys
import time
from collections.abc import Callable

from mission.authoring.check import Report, check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse, to_yaml
from mission.model.shipped import load_vehicle

SMALL, LARGE = 1000, 5000  # legs; 500,000 characters are the most


def mission_of(legs: int) -> str:
    head = "mission big vehicle auv\nhome 30.2874595 120.1535765\nsafety radius 2000 time 240min\n"
    return head + "".join(
        f"leg_{n}: heading {n % 360} gear {1 + n % 8} depth {1 + n % 20} "
        f"until travelled >= {3 + n % 100} or altitude < 1.5 sure 90% timeout 1s\n"
        for n in range(legs)
    )


def spent(work: Callable[[], object]) -> float:
    """Processor time: others may be using this machine."""
    gc.collect()
    begun = time.process_time()
    work()
    return time.process_time() - begun


def judge(text: str) -> Report:
    """RuntimeError where it is refused: a refusal costs less than what it did not do."""
    mission, vehicle = parse(text), load_vehicle("auv")
    report = check_mission(compile_mission(mission, vehicle, digest(mission)), vehicle)
    if not report.ok:
        raise RuntimeError(report.refusals[0].message)
    return report


def main() -> dict[str, float]:
    small, large = mission_of(SMALL), mission_of(LARGE)
    parse(mission_of(10))  # the grammar's tables are made once
    lines, many = spent(lambda: parse(small)), spent(lambda: parse(large))
    small_yaml = to_yaml(parse(small))
    yaml = spent(lambda: parse(small_yaml))
    judged = spent(lambda: judge(small))
    even = LARGE * math.log(LARGE) / (SMALL * math.log(SMALL))  # n log n
    say = sys.stdout.write
    say(f"{SMALL} legs: lines {lines:.2f} s, YAML {yaml:.2f} s, read and judged {judged:.2f} s\n")
    say(f"{LARGE} legs: lines {many:.2f} s, {many / lines / even:.2f} times what n log n grows\n")
    return {"read_s": max(lines, yaml), "judged_s": judged, "growth": many / lines / even}


if __name__ == "__main__":
    main()
