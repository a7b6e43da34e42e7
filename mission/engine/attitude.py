"""Whether the vehicle is upside down: a state of the vehicle, not a fault of its sensor (R7).

Beyond 90 degrees a roll is out of the range that document 000 gives it (table 3.2), so sensor
health takes it for absurd. Three reports in a row that differ from each other and agree on it (or
on 120 degrees) are taken for the truth; full-scale garbage repeats itself. What repeats itself to
the last bit while thrust is on, or for a minute, tells nothing more, whatever it says.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mission.engine.thrust import turns
from protocol.messages import Telemetry

OVERTURNED = math.radians(120.0)  # |roll| or |pitch|
_ON_ITS_SIDE = math.radians(90.0)  # the same: no report of a sound sensor, as health believes it
_REPORTS = 3
_FULL_CIRCLE = math.radians(180.5)  # beyond it is no angle
_SAME = 1e-9  # rad
_FROZEN, _STOOD = 4, 60.0  # repeats while thrust is on; s of both without it
_BETWEEN = 1.0  # s between repeats that count: a board may say 50 times a second what it knows
_BROKEN_FOR = 60.0  # s for which a sensor that said what is no angle tells nothing


class Repeats(NamedTuple):
    """How often an angle was repeated to the last bit while thrust was on, ``_BETWEEN`` s apart;
    ``counted``: when that last counted, or it changed, s."""

    times: int = 0
    counted: float = -math.inf

    def after(self, t: float, again: bool, driven: bool) -> Repeats:
        if not again:
            return Repeats(0, t)
        if not driven or t < self.counted + _BETWEEN:
            return self
        return Repeats(self.times + 1, t)


class Attitude(NamedTuple):
    """What the last reports said; ``reports`` of them in a row were beyond 120 degrees. ``told``:
    there has been one; ``gone``: and the last report says nothing of it; ``broken``: when the last
    one came that was no angle, s; ``repeats``: of roll, and of pitch; ``stood``: for how long both
    have said the same, s; ``beyond``: as ``reports``, of 90 degrees."""

    roll: float = 0.0
    pitch: float = 0.0
    reports: int = 0
    told: bool = False
    gone: bool = False
    broken: float = -math.inf
    repeats: tuple[Repeats, Repeats] = Repeats(), Repeats()
    stood: float = 0.0
    t: float = -math.inf  # of the report
    beyond: int = 0

    @property
    def overturned(self) -> bool:
        return self.reports >= _REPORTS

    @property
    def on_its_side(self) -> bool:
        """Or further over."""
        return self.beyond >= _REPORTS

    @property
    def frozen(self) -> bool:
        return max(each.times for each in self.repeats) >= _FROZEN or self.stood >= _STOOD

    def doubtful(self, now: float) -> bool:
        """It may be upside down: the last report says so, or tells nothing more, or one of the last
        minute was no angle: whatever such a sensor says between."""
        if self.overturned or self.frozen:
            return self.frozen
        beyond = max(abs(self.roll), abs(self.pitch)) > OVERTURNED
        return self.gone or beyond or now - self.broken < _BROKEN_FOR

    def after(self, report: Telemetry) -> Attitude:
        """With one more report; one without roll or pitch says that nothing is known (any more)."""
        roll, pitch = report.roll, report.pitch
        if roll is None or pitch is None:
            return self._replace(reports=0, gone=self.told, beyond=0)
        worst, reports, broken, beyond = max(abs(roll), abs(pitch)), 0, self.broken, 0
        if worst > _FULL_CIRCLE:
            broken = report.t
        elif worst > _ON_ITS_SIDE:
            repeats = _apart(roll, self.roll) < _SAME and _apart(pitch, self.pitch) < _SAME
            beyond = self.beyond + (not repeats or not self.beyond)
            if worst > OVERTURNED:
                reports = self.reports + (not repeats or not self.reports)
        rolls, pitches = self.told and roll == self.roll, self.told and pitch == self.pitch
        driven = turns(report)
        repeated = (
            self.repeats[0].after(report.t, rolls, driven),
            self.repeats[1].after(report.t, pitches, driven),
        )
        stood = self.stood + report.t - self.t if rolls and pitches else 0.0
        return Attitude(
            *(roll, pitch, reports, True, False, broken, repeated, stood, report.t, beyond)
        )


def _apart(a: float, b: float) -> float:
    return abs(math.remainder(a - b, 2.0 * math.pi))
