"""The estimate is as sure as it may be: 30 flights of the simulated vehicle, both profiles.

``python tests/worlds/simulated_truth.py 500`` flies the full sample.
"""

from __future__ import annotations

import pytest
from simulated_truth import Flight, Summary, fly, sum_up

# long: make proofs; all by one worker, who flies once
pytestmark = [pytest.mark.proof, pytest.mark.xdist_group("consistency")]

FLIGHTS = 30


@pytest.fixture(scope="module")
def flights() -> list[Flight]:
    """Both profiles, each with one fix and with fixes before the dive."""
    return [
        fly(seed, "as-built" if seed % 2 else "documented", learning=seed % 4 < 2)
        for seed in range(FLIGHTS)
    ]


@pytest.fixture(scope="module")
def summary(flights: list[Flight]) -> Summary:
    return sum_up(flights)


def test_nees_of_every_state_group_is_within_its_bounds(summary: Summary) -> None:
    outside = {
        group: value
        for group, value in summary.nees.items()
        if not summary.bounds[group][0] < value < summary.bounds[group][1]
    }
    assert not outside, summary


def test_innovations_of_fixes_are_as_large_as_they_are_believed(summary: Summary) -> None:
    assert 0.95 < summary.nis < 1.05


def test_the_ellipse_holds_the_truth_as_often_as_it_says(summary: Summary) -> None:
    assert 0.93 < summary.coverage < 0.97


def test_the_error_at_surfacing_stays_small_against_the_way_swum(summary: Summary) -> None:
    median, most = summary.error_pct
    assert median < 4.0
    assert most < 12.0
