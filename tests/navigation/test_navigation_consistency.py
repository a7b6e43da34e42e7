"""The estimate is as sure as it may be: 30 flights of the simulated vehicle, both profiles, in still
water and in waves.

``python tests/worlds/simulated_truth.py 500`` flies the full sample.
"""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from simulated_truth import Flight, Summary, fly, sum_up

# long: make proofs; all by one worker, who flies once
pytestmark = [pytest.mark.proof, pytest.mark.xdist_group("consistency")]

FLIGHTS = 30
HORIZONTAL = ("position", "current", "heading", "speed")


def _flown(*, waves: bool) -> list[Flight]:
    """Both profiles, each with one fix and with fixes before the dive."""
    return [
        fly(seed, "as-built" if seed % 2 else "documented", learning=seed % 4 < 2, waves=waves)
        for seed in range(FLIGHTS)
    ]


@pytest.fixture(scope="module")
def summary() -> Summary:
    return sum_up(_flown(waves=False))


@pytest.fixture(scope="module")
def in_waves() -> Summary:
    return sum_up(_flown(waves=True))


def test_nees_of_every_state_group_is_within_its_bounds(summary: Summary) -> None:
    """That of the current may be less: one velocity does not show that there are no waves."""
    assert not _outside(summary, summary.nees.keys() - {"current"}), summary
    assert 0.5 < summary.nees["current"] < summary.bounds["current"][1], summary


def test_nees_of_the_way_is_within_its_bounds_in_waves(in_waves: Summary) -> None:
    """With every velocity believed as in still water: position 5, current 11."""
    assert not _outside(in_waves, HORIZONTAL), in_waves


def _outside(summary: Summary, groups: Iterable[str]) -> list[str]:
    return [g for g in groups if not summary.bounds[g][0] < summary.nees[g] < summary.bounds[g][1]]


def test_innovations_of_fixes_are_as_large_as_they_are_believed(summary: Summary) -> None:
    assert 0.95 < summary.nis < 1.05


def test_the_ellipse_holds_the_truth_as_often_as_it_says_or_more(
    summary: Summary, in_waves: Summary
) -> None:
    """More in still water, where little is believed of one velocity (its NEES bounds by how much).
    With every velocity believed, 70 % in waves."""
    assert summary.coverage > 0.93
    assert 0.93 < in_waves.coverage < 0.99


def test_the_error_at_surfacing_stays_small_against_the_way_swum(summary: Summary) -> None:
    median, most = summary.error_pct
    assert median < 4.0
    assert most < 12.0
