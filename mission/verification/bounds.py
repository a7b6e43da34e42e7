"""Bound the probability of a failure by the number of failures that were counted."""

from __future__ import annotations

CONFIDENCE = 0.95


def at_most(failures: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """Return the exact one-sided upper bound of Clopper and Pearson (Biometrika 26, 1934), rounded
    to four digits: with a greater probability there would, with this confidence, have been more
    failures. 1 without trials."""
    from scipy.special import betaincinv

    if failures >= trials:
        return 1.0
    bound = float(betaincinv(failures + 1, trials - failures, confidence))
    return float(f"{bound:.4g}")
