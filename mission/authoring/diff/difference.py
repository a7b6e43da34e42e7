"""The difference of two prepared missions: the changes, and the worst cases of both by the check.

What does not live here: the comparison of the charts (changes.py), output (show.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mission.authoring.check import Proved, Report
from mission.authoring.diff.changes import Change, changes
from mission.authoring.prepare import Prepared, check_prepared


@dataclass(frozen=True, slots=True)
class Figure:
    """A worst case before and after, in ``unit``; None where the check proves nothing."""

    name: str
    key: str  # as `check --json` prints it
    unit: str
    before: float | None
    after: float | None

    @property
    def change(self) -> float | None:
        if self.before is None or self.after is None:
            return None
        return self.after - self.before


@dataclass(frozen=True, slots=True)
class Difference:
    before: Prepared
    after: Prepared
    reports: tuple[Report, Report]
    changes: tuple[Change, ...]
    renamed: tuple[tuple[str, str], ...]
    figures: tuple[Figure, ...]

    @property
    def same(self) -> bool:
        """Whether the missions are the same for the vehicle; names do not matter."""
        return not self.changes


_Row = tuple[str, str, str, Callable[[Proved], float]]
_FIGURES: tuple[_Row, ...] = (
    ("time", "worst_time_s", "s", lambda p: p.worst_time),
    ("energy", "worst_energy_wh", "Wh", lambda p: p.worst_energy / 3600.0),
    ("range", "max_range_m", "m", lambda p: p.max_range),
    ("depth", "max_depth_m", "m", lambda p: p.max_depth),
    ("uncertainty", "uncertainty_m", "m", lambda p: p.uncertainty),
)


def compare(before: Prepared, after: Prepared) -> Difference:
    found = changes(before.chart, after.chart, (before.vehicle, after.vehicle))
    reports = check_prepared(before), check_prepared(after)
    return Difference(before, after, reports, found.rows, found.renamed, _figures(reports))


def _figures(reports: tuple[Report, Report]) -> tuple[Figure, ...]:
    def value(of: Callable[[Proved], float], report: Report) -> float | None:
        return None if report.proved is None else round(of(report.proved), 1)

    return tuple(
        Figure(name, key, unit, value(of, reports[0]), value(of, reports[1]))
        for name, key, unit, of in _FIGURES
    )
