"""What a count of failures says about their probability."""

from __future__ import annotations

CONFIDENCE = 0.95


def at_most(failures: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """The exact upper bound of Clopper and Pearson (Biometrika 26, 1934), one-sided: a greater
    probability would, with this confidence, have failed more often. Four digits; 1 for no trial."""
    from scipy.special import betaincinv

    if failures >= trials:
        return 1.0
    bound = float(betaincinv(failures + 1, trials - failures, confidence))
    return float(f"{bound:.4g}")
