"""Many logs together: how far days differ, and who stands apart."""

from __future__ import annotations

import math
import random

import pytest

from mission.analysis.pooling import pool
from mission.analysis.scores import honest


def drawn(between: float, own: float, n: int, seed: int) -> tuple[list[float], list[float]]:
    rng = random.Random(seed)
    found = [1.9 + rng.gauss(0.0, between) + rng.gauss(0.0, own) for _ in range(n)]
    return found, [own**2] * n


@pytest.mark.parametrize("between", [0.05, 0.2])
@pytest.mark.parametrize("share", [0.2, 1.0])
def test_how_far_days_differ_is_found_beside_what_each_log_errs_by(
    between: float, share: float
) -> None:
    logs = [drawn(between, share * between, 60, seed) for seed in range(20)]
    found = [math.sqrt(pool(*log).between) for log in logs]
    assert sorted(found)[10] == pytest.approx(between, rel=0.25)


def test_logs_that_differ_by_no_more_than_they_err_tell_of_no_difference() -> None:
    found, variances = [1.0, 1.02, 0.98, 1.01, 0.99], [0.04] * 5
    assert pool(found, variances).between == 0.0


def test_one_that_stands_apart_is_named_and_does_not_widen_the_others() -> None:
    found, variances = [1.9, 2.0, 1.95, 2.05, 1.98, 3.5], [1e-4] * 6
    together, alone = pool(found, variances), pool(found[:5], variances[:5])
    assert together.apart == (5,)
    assert together.between == pytest.approx(alone.between)
    assert not alone.apart


def test_of_three_logs_none_can_be_said_to_stand_apart() -> None:
    assert pool([1.0, 1.01, 9.0], [1e-4] * 3).apart == ()


def test_one_log_says_nothing_of_other_days() -> None:
    assert pool([1.0], [0.1]).between == 0.0
    assert pool([], []).apart == ()


@pytest.mark.parametrize("ends", [4, 7, 20, 100])
def test_right_ellipses_have_a_mean_nees_as_chi_square_says(ends: int) -> None:
    from scipy import stats  # takes longer to import than all else here

    limits = stats.chi2.ppf([0.025, 0.975], 2 * ends) / (2 * ends)
    assert honest(ends) == pytest.approx(tuple(limits), rel=0.02)
