"""The float test: how fast the vehicle rises with all thrusters neutral, from its reports.

A rise begins when the thrusters have been neutral for SETTLE. It lasts while they stay neutral and
the vehicle is deeper than TOP, where the hull emerges. The speed is the slope common to all rises,
by least squares with a separate depth for each (Draper and Smith, Applied Regression Analysis,
1998, ch. 14: parallel lines). The result is a lower bound of the rate: two sigma less.

What does not live here: the texts (lessons), what follows from the figure (check, doctor).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mission.engine.thrust import NEUTRAL, THRUSTERS
from protocol.messages import Fix, Telemetry

SETTLE = 3.0  # s: twice the time by which mass over drag delays the speed
TOP = 0.5  # m
ENOUGH = 3  # rises
FREE = 4  # residual degrees of freedom; with fewer, the vehicle file's noise counts
_GAP = 10.0  # s without a report ends a rise
_DEEPEST = 1000.0  # m: a deeper reading is not a depth


@dataclass(frozen=True, slots=True)
class Rise:
    """The rate of ascent by buoyancy alone: ``rate`` m/s upward, ``sigma`` its own, over ``rises``
    rises. ``day``: YYYY-MM-DD of the last log with a date, by its fixes."""

    rate: float
    sigma: float
    rises: int
    day: str

    @property
    def at_least(self) -> float:
        """The rate less two sigma."""
        return self.rate - 2.0 * self.sigma


def rise_of(logs: Sequence[Sequence[Telemetry | Fix]], noise: float) -> Rise | None:
    """Estimate the rise; None if the logs have too few rises, or no date. ``noise``: m, one sigma
    of a depth."""
    rises = [r for log in logs for r in _rises(i for i in log if isinstance(i, Telemetry))]
    days = [i.utc[:10] for log in logs for i in log if isinstance(i, Fix) and i.utc]
    if len(rises) < ENOUGH or not days:
        return None
    along = across = left = 0.0
    for rise in rises:
        t0, d0 = (sum(column) / len(rise) for column in zip(*rise, strict=True))
        along += sum((t - t0) ** 2 for t, _ in rise)
        across += sum((t - t0) * (d - d0) for t, d in rise)
        left += sum((d - d0) ** 2 for _, d in rise)
    slope, count = across / along, sum(map(len, rises))
    free = count - len(rises) - 1
    scatter = math.sqrt(max(left - slope * across, 0.0) / free) if free >= FREE else noise
    return Rise(-slope, scatter / math.sqrt(along), len(rises), max(days))


def _rises(reports: Iterator[Telemetry]) -> Iterator[list[tuple[float, float]]]:
    """Yield the times and depths of each rise that has two or more."""
    let_go: float | None = None
    rise: list[tuple[float, float]] = []
    last = -math.inf
    for report in reports:
        depth, neutral = report.depth, _is_neutral(report)
        known = depth is not None and depth < _DEEPEST and report.t - last <= _GAP
        if not (neutral and known) or depth is None or depth < TOP:
            if len(rise) > 1:
                yield rise
            rise, let_go = [], None
        elif let_go is None:
            let_go = report.t
        elif report.t - let_go >= SETTLE:
            rise.append((report.t, depth))
        last = report.t
    if len(rise) > 1:
        yield rise


def _is_neutral(report: Telemetry) -> bool:
    """Whether all thrusters are neutral; False if the report does not include them."""
    return report.actuators is not None and all(
        abs(a) <= NEUTRAL for a in report.actuators[:THRUSTERS]
    )
