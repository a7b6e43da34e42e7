"""What many logs say together: their mean, how far another day is from it, and who stands apart.

Each log's estimate e has a variance v of its own; beyond that the days differ by t^2 (random
effects: DerSimonian and Laird, Controlled Clinical Trials 7, 1986, 177-188). t^2 is such that
the median of (e - m)^2 / (v + t^2) is that of chi-square with one degree of freedom, as an
outlier moves no median. One that is ``_APART`` sigmas or more from the median is named, and
not counted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

_MEDIAN = 0.4549  # of chi-square, one degree of freedom
_APART = 4.0
FEW = 1.3  # on the spread of a handful, itself uncertain (Student t against normal)
_JUDGES = 4  # so many logs may say that one of them stands apart


@dataclass(frozen=True, slots=True)
class Pooled:
    """``between``: variance of the days. ``apart``: indices of what stands apart."""

    between: float
    apart: tuple[int, ...]


def pool(estimates: Sequence[float], variances: Sequence[float]) -> Pooled:
    """Of none or one nothing is known."""
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
    """Variance between the days, by bisection: the median falls as it grows."""
    middle = median(e for e, _ in rows)
    share = len(rows) / (len(rows) - 1) if len(rows) > 1 else 1.0  # the middle is theirs
    low, high = 0.0, 10.0 * max((e - middle) ** 2 for e, _ in rows)
    for _ in range(60):
        between = 0.5 * (low + high)
        off = median((e - middle) ** 2 / (v + between) for e, v in rows)
        low, high = (between, high) if share * off > _MEDIAN else (low, between)
    return high if low > 0.0 else 0.0
