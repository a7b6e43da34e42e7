"""A mission begins where the check assumed it to begin, or is refused with what would do."""

from __future__ import annotations

import pytest

from mission.engine.bounds import Bounds
from mission.engine.outset import too_far

IN_FORCE = Bounds(radius=400.0, time=600.0, depth=20.0, voltage=10.0)


@pytest.mark.parametrize("far", [0.0, 24.9, 25.0])
def test_within_what_is_assumed_it_begins(far: float) -> None:
    assert too_far(far, IN_FORCE, 25.0) == ""


@pytest.mark.parametrize(
    ("far", "start"), [(25.1, 30), (30.0, 30), (30.1, 40), (399.0, 400), (400.0, 400)]
)
def test_beyond_it_the_start_that_would_do_is_told_in_tens_of_metres(
    far: float, start: int
) -> None:
    said = too_far(far, IN_FORCE, 25.0)
    assert "proved for a start within 25 m" in said
    assert said.endswith(f"let the mission assume start {start}")


def test_beyond_the_radius_in_force_nothing_would_do() -> None:
    assert too_far(400.1, IN_FORCE, 900.0) == "home is 400 m away, the radius in force is 400 m"
