"""The estimate is as sure as it may be: 30 flights of the simulated vehicle, both profiles.

``python tests/mission/navigation/simulated_truth.py 500`` flies the full sample.
"""

from __future__ import annotations

import pytest
from simulated_truth import Flight, Summary, fly, sum_up

SEEDS = 15


@pytest.fixture(scope="module", params=["one fix", "fixes before"])
def flights(request: pytest.FixtureRequest) -> list[Flight]:
    learning = request.param == "fixes before"
    return [
        fly(seed, "as-built" if seed % 2 else "documented", learning=learning)
        for seed in range(SEEDS)
    ]


@pytest.fixture(scope="module")
def summary(flights: list[Flight]) -> Summary:
    return sum_up(flights)


@pytest.mark.slow
def test_nees_of_every_state_group_is_within_its_bounds(summary: Summary) -> None:
    outside = {
        group: value
        for group, value in summary.nees.items()
        if not summary.bounds[group][0] < value < summary.bounds[group][1]
    }
    assert not outside, summary


@pytest.mark.slow
def test_innovations_of_fixes_are_as_large_as_they_are_believed(summary: Summary) -> None:
    assert 0.9 < summary.nis < 1.1


@pytest.mark.slow
def test_the_ellipse_holds_the_truth_as_often_as_it_says(summary: Summary) -> None:
    """Samples of one flight go together, so 15 flights say it to some percent only."""
    assert 0.88 < summary.coverage < 1.0


@pytest.mark.slow
def test_the_error_at_surfacing_stays_small_against_the_way_swum(flights: list[Flight]) -> None:
    median, most = sum_up(flights).error_pct
    assert median < 6.0
    assert most < 16.0
