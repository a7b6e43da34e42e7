"""What a bench must not do: measure a refusal, or end in an error for want of turns."""

from __future__ import annotations

import statistics
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))


def test_a_mission_that_the_check_refuses_is_no_figure_of_judging() -> None:
    from bench_language import judge, mission_of

    assert judge(mission_of(20)).ok
    with pytest.raises(RuntimeError, match="the safety time is 240"):
        judge(mission_of(20).replace("timeout 1s", "timeout 30min"))


def test_an_hour_is_measured_by_one_turn_and_by_many() -> None:
    # here, since it brings all of filterpy, which no other test needs
    from bench_hour import main, quartiles

    assert quartiles([15.0]) == (15.0, 15.0, 15.0)
    many = [float(n) for n in range(32)]
    assert quartiles(many) == tuple(statistics.quantiles(many, n=4))
    with pytest.raises(ValueError, match="0 turns"):
        main(0)
