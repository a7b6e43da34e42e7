"""Whether the vehicle is upside down: a state of the vehicle, not a fault of its sensor (R7).

Beyond 90 degrees a roll is out of the range that document 000 gives it (table 3.2), so sensor
health takes it for absurd. Three reports in a row that differ from each other and agree on it are
taken for the truth; full-scale garbage repeats itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from protocol.messages import Telemetry

OVERTURNED = math.radians(120.0)  # |roll| or |pitch|
_REPORTS = 3
_FULL_CIRCLE = math.radians(180.5)  # beyond it is no angle
_SAME = 1e-9  # rad
_BROKEN_FOR = 60.0  # s for which a sensor that said what is no angle tells nothing


class Attitude(NamedTuple):
    """What the last reports said; ``reports`` of them in a row were beyond 120 degrees. ``told``:
    there has been one; ``gone``: and the last report says nothing of it; ``broken``: when the last
    one came that was no angle, s."""

    roll: float = 0.0
    pitch: float = 0.0
    reports: int = 0
    told: bool = False
    gone: bool = False
    broken: float = -math.inf

    @property
    def overturned(self) -> bool:
        return self.reports >= _REPORTS

    def doubtful(self, now: float) -> bool:
        """It may be upside down: the last report says so, or tells nothing more, or one of the last
        minute was no angle: whatever such a sensor says between."""
        if self.overturned:
            return False
        beyond = max(abs(self.roll), abs(self.pitch)) > OVERTURNED
        return self.gone or beyond or now - self.broken < _BROKEN_FOR

    def after(self, report: Telemetry) -> Attitude:
        """With one more report; one without roll or pitch says that nothing is known (any more)."""
        roll, pitch = report.roll, report.pitch
        if roll is None or pitch is None:
            return Attitude(told=self.told, gone=self.told, broken=self.broken)
        worst = max(abs(roll), abs(pitch))
        if not OVERTURNED < worst <= _FULL_CIRCLE:
            broken = report.t if worst > _FULL_CIRCLE else self.broken
            return Attitude(roll, pitch, told=True, broken=broken)
        repeats = _apart(roll, self.roll) < _SAME and _apart(pitch, self.pitch) < _SAME
        reports = self.reports + (not repeats or not self.reports)
        return Attitude(roll, pitch, reports, told=True, broken=self.broken)


def _apart(a: float, b: float) -> float:
    return abs(math.remainder(a - b, 2.0 * math.pi))
