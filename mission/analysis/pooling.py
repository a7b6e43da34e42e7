"""Pooling of many logs: their mean, the variance between days, and outliers.

Each log's estimate e has a variance v of its own; the days differ by a further t^2 (random effects:
DerSimonian and Laird, Controlled Clinical Trials 7, 1986, 177-188). t^2 makes the median of (e -
m)^2 / (v + t^2) equal to that of chi-square with one degree of freedom, because an outlier does not
move a median. A log that is ``_APART`` sigmas or more from the median is named, and not counted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

_MEDIAN = 0.4549  # median of chi-square, one degree of freedom
_APART = 4.0
FEW = 1.3  # factor on the spread of a few logs, itself uncertain (Student t against normal)
_JUDGES = 4  # logs needed to call one of them an outlier


@dataclass(frozen=True, slots=True)
class Pooled:
    """``between``: variance between days. ``apart``: indices of outliers."""

    between: float
    apart: tuple[int, ...]


def pool(estimates: Sequence[float], variances: Sequence[float]) -> Pooled:
    """Pool estimates; from fewer than two nothing is known, and the variance is 0."""
    if len(estimates) < 2:
        return Pooled(0.0, ())
    apart = _outliers(estimates, variances)
    rows = zip(estimates, variances, strict=True)
    return Pooled(_between([row for i, row in enumerate(rows) if i not in apart]), apart)


def _outliers(estimates: Sequence[float], variances: Sequence[float]) -> tuple[int, ...]:
    if len(estimates) < _JUDGES:
        return ()
    middle, between = median(estimates), _between(list(zip(estimates, variances, strict=True)))
    return tuple(
        i
        for i, (e, v) in enumerate(zip(estimates, variances, strict=True))
        if abs(e - middle) > _APART * math.sqrt(v + between)
    )


def _between(rows: Sequence[tuple[float, float]]) -> float:
    """Find the variance between days by bisection: the median falls as the variance grows."""
    middle = median(e for e, _ in rows)
    share = len(rows) / (len(rows) - 1) if len(rows) > 1 else 1.0  # the median is of the same logs
    low, high = 0.0, 10.0 * max((e - middle) ** 2 for e, _ in rows)
    for _ in range(60):
        between = 0.5 * (low + high)
        off = median((e - middle) ** 2 / (v + between) for e, v in rows)
        low, high = (between, high) if share * off > _MEDIAN else (low, between)
    return high if low > 0.0 else 0.0
