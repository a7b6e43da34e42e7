"""Reading is quick, and ten times the mission takes about ten times as long."""

from __future__ import annotations

import gc
import time

import pytest

from mission.language import parse, to_yaml
from mission.model import Mission


def mission_of(legs: int) -> str:
    rows = [
        f"leg_{n}: heading {n % 360} gear {1 + n % 8} depth {n % 20} "
        f"until travelled >= {100 + n} or altitude < 1.5 sure 90% timeout 4min"
        for n in range(legs)
    ]
    return "\n".join(["mission big vehicle auv", *rows])


def spent(text: str) -> tuple[float, Mission]:
    """Processor time: others may be using this machine."""
    gc.collect()
    start = time.process_time()
    mission = parse(text)
    return time.process_time() - start, mission


@pytest.mark.parametrize("form", ["lines", "yaml"])
def test_a_thousand_legs_are_read_within_a_second_and_growth_is_even(form: str) -> None:
    small, large = mission_of(200), mission_of(2000)
    if form == "yaml":
        small, large = to_yaml(parse(small)), to_yaml(parse(large))
    parse(small)  # the grammar's tables are made once
    quick = min(spent(small)[0] for _ in range(2))
    slow, mission = spent(large)
    assert slow / 2 < 1.0
    assert slow < 10 * quick * 2.5
    assert len(mission.body) == 2000
