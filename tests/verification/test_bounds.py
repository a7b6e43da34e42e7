"""What a campaign proves: the bound is exact, and the tables in the docs have it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from mission.verification.bounds import at_most

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.parametrize(("failures", "trials"), [(0, 1), (0, 59), (1, 50), (5, 2870), (19, 20)])
@pytest.mark.parametrize("confidence", [0.95, 0.99])
def test_a_greater_probability_would_have_failed_more_often(
    failures: int, trials: int, confidence: float
) -> None:
    p = at_most(failures, trials, confidence)
    so_few = math.fsum(
        math.comb(trials, k) * p**k * (1.0 - p) ** (trials - k) for k in range(failures + 1)
    )
    assert so_few == pytest.approx(1.0 - confidence, rel=0.03)  # four digits of p


def test_without_a_trial_or_a_success_nothing_is_bounded() -> None:
    assert at_most(0, 0) == at_most(3, 3) == 1.0


@pytest.mark.parametrize(("page", "rows"), [("how-to/campaign.md", 6), ("findings.md", 30)])
def test_the_bounds_that_a_page_tells_are_these(page: str, rows: int) -> None:
    """Rows that end with flights, violations, 95 % and 99 %; without violations the second is
    left out."""
    text = (DOCS / page).read_text()
    bound = r"(0\.\d+|\d\.\d+e-\d+)"
    found = re.findall(rf"\| ([\d,]+) \| (?:(\d+) \| )?{bound} \| {bound} \|$", text, re.M)
    assert len(found) >= rows
    for flights, violations, *told in found:
        trials, failures = int(flights.replace(",", "")), int(violations or 0)
        known = [at_most(failures, trials), at_most(failures, trials, 0.99)]
        assert [float(bound) for bound in told] == known
