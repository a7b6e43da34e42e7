"""The results of scoring as a table: each run, then medians, intervals and coverage over all runs.

What does not live here: how they are computed (scoring).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

_DRAWS = 2000
_NORMAL_95 = 1.95996


@dataclass(frozen=True, slots=True)
class Score:
    """The result of one scoring of one recording; percentages as in the module scoring."""

    file: str
    scoring: str
    end_pct: float
    median_pct: float
    coverage: float
    samples: int
    ellipse_pct: float
    nees: float  # at the end, over its two degrees of freedom
    reference_pct: float | None
    references: dict[str, float]
    equal_pct: float | None = None  # of the reference with equal knowledge
    ends: int = 1  # number of dive ends; ``nees`` is their mean


def as_object(scores: Sequence[Score]) -> dict[str, object]:
    """Return what the command prints: every run, and the medians and the pooled coverage of all."""
    samples = sum(s.samples for s in scores)
    summary = []
    for name in dict.fromkeys(s.scoring for s in scores):
        rows = [s for s in scores if s.scoring == name]
        known = [s.reference_pct for s in rows if s.reference_pct is not None]
        pairs = [(s.end_pct, s.equal_pct) for s in rows if s.equal_pct is not None]
        summary.append(
            {
                "scoring": name,
                "runs": len(rows),
                "end_pct": _median([s.end_pct for s in rows]),
                "end_interval": interval([s.end_pct for s in rows]),
                "reference_pct": _median(known) if known else None,
                "equal_pct": _median([b for _, b in pairs]) if pairs else None,
                "lead_interval": interval([b - a for a, b in pairs]),
                "nees": float(np.mean([s.nees for s in rows])),
                "nees_honest": honest(sum(s.ends for s in rows)),
                "coverage": sum(s.coverage * s.samples for s in rows)
                / sum(s.samples for s in rows),
                "ellipse_pct": float(np.mean([s.ellipse_pct for s in rows])),
                "ellipse_median_pct": _median([s.ellipse_pct for s in rows]),
            }
        )
    return {
        "runs": [asdict(s) for s in scores],
        "summary": summary,
        "coverage": sum(s.coverage * s.samples for s in scores) / samples if samples else None,
        "ellipse_pct": float(np.mean([s.ellipse_pct for s in scores])) if scores else None,
    }


def interval(values: Sequence[float]) -> tuple[float, float] | None:
    """Return the 95 % interval of the median by bootstrap (Efron, Ann. Statist. 7, 1979, 1-26),
    always with the same draws. None for fewer than three values, where it would mean nothing."""
    if len(values) < 3:
        return None
    rng = np.random.default_rng(0)
    drawn = rng.choice(np.array(values), (_DRAWS, len(values)))
    low, high = np.percentile(np.median(drawn, axis=1), (2.5, 97.5))
    return float(low), float(high)


def honest(ends: int) -> tuple[float, float]:
    """Return the 95 % interval of the mean of ``ends`` NEES, each over its two degrees of freedom,
    if the ellipses are right: chi-square (Wilson, Hilferty, Proc. Natl. Acad. Sci. 17, 1931,
    684-688)."""
    ninth = 1.0 / (9.0 * ends)  # 2 / (9 k), of k = 2 ends degrees of freedom
    low, high = ((1.0 - ninth + sign * _NORMAL_95 * math.sqrt(ninth)) ** 3 for sign in (-1, 1))
    return low, high


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))


def summed(found: dict[str, object]) -> list[str]:
    """Return a line for each scoring of ``as_object``."""
    rows = found["summary"]
    assert isinstance(rows, list)
    return [
        f"{row['scoring']} ({row['runs']} recordings): median {row['end_pct']:.1f} % "
        f"{_from_to(row['end_interval'])}, with equal knowledge {_said(row['equal_pct'])}; "
        f"lead {_from_to(row['lead_interval'])}; ellipse holds {100.0 * row['coverage']:.0f} %, "
        f"radius {row['ellipse_median_pct']:.0f} %, mean NEES at the end {row['nees']:.2f} "
        f"(right ellipses: {row['nees_honest'][0]:.2f} to {row['nees_honest'][1]:.2f})"
        for row in rows
    ]


def _from_to(found: tuple[float, float] | None) -> str:
    return "(too few for an interval)" if found is None else f"({found[0]:.1f} to {found[1]:.1f})"


def _said(percent: float | None) -> str:
    return "-" if percent is None else f"{percent:.1f} %"
