"""The float test: how fast the vehicle rises with every thruster neutral, out of its reports.

A rise begins when the thrusters have been neutral for SETTLE and lasts while they are, and while it
is deeper than TOP, where the hull emerges. Its speed is the slope common to all rises, by least
squares with a depth of its own for each (Draper and Smith, Applied Regression Analysis, 1998, ch.
14: parallel lines). What is told is what the vehicle rises at least: two sigma less.

What does not live here: the texts (lessons), what follows from the figure (check, doctor).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mission.engine.thrust import NEUTRAL, THRUSTERS
from protocol.messages import Fix, Telemetry

SETTLE = 3.0  # s: twice what mass over drag lets the speed lag
TOP = 0.5  # m
ENOUGH = 3  # rises
FREE = 4  # depths more than figures, without which the vehicle file's noise counts
_GAP = 10.0  # s without a report ends a rise
_DEEPEST = 1000.0  # m: deeper is no depth


@dataclass(frozen=True, slots=True)
class Rise:
    """``rate``: m/s upward, ``sigma`` its own; by so many ``rises``. ``day``: YYYY-MM-DD, of the
    last log that has one, by its fixes."""

    rate: float
    sigma: float
    rises: int
    day: str

    @property
    def at_least(self) -> float:
        """Two sigma; what is less than that is not sure."""
        return self.rate - 2.0 * self.sigma


def rise_of(logs: Sequence[Sequence[Telemetry | Fix]], noise: float) -> Rise | None:
    """None where the logs hold too few rises, or no day. ``noise``: m, one sigma of a depth."""
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
    """Times and depths of each; two or more."""
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
    """A vehicle that does not say what its thrusters do tells nothing of its buoyancy."""
    return report.actuators is not None and all(
        abs(a) <= NEUTRAL for a in report.actuators[:THRUSTERS]
    )
