"""Whether the vehicle is upside down: a state of the vehicle, not a fault of its sensor (R7).

Beyond 90 degrees a roll is out of the range that document 000 gives it (table 3.2), so sensor
health takes it for absurd. It is believed by three reports in a row that differ from each other and
are all beyond 90 (or 120) degrees; garbage at full scale repeats itself. Angles that repeat to the
last bit while thrust is on, or for a minute, tell nothing more, whatever their value.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mission.engine.thrust import turns
from protocol.messages import Telemetry

OVERTURNED = math.radians(120.0)  # |roll| or |pitch|
_ON_ITS_SIDE = math.radians(90.0)  # the same angles; sensor health believes none beyond this
_SIDEWAYS = math.radians(60.0)  # and here: less than half of a vertical thrust moves the depth
_REPORTS = 3
_FULL_CIRCLE = math.radians(180.5)  # |angle| beyond this is invalid
_SAME = 1e-9  # rad
_FROZEN, _STOOD = 4, 60.0  # repeats while thrust is on; s that both repeat, whatever the thrust
_BETWEEN = 1.0  # s between repeats that count: a board may repeat a value 50 times a second
_BROKEN_FOR = 60.0  # s after an invalid angle for which the sensor tells nothing


class Repeats(NamedTuple):
    """How often an angle was repeated to the last bit while thrust was on, ``_BETWEEN`` s apart.
    ``counted``: s, when a repeat last counted, or the angle last changed."""

    times: int = 0
    counted: float = -math.inf

    def after(self, t: float, again: bool, driven: bool) -> Repeats:
        if not again:
            return Repeats(0, t)
        if not driven or t < self.counted + _BETWEEN:
            return self
        return Repeats(self.times + 1, t)


class Attitude(NamedTuple):
    """The attitude by the last reports. ``reports``: how many in a row were beyond 120 degrees;
    ``beyond``: the same for 90 degrees; ``sideways``: for 60 degrees. ``told``: an attitude was
    reported at all; ``gone``: but not in the last report. ``broken``: s, when the last invalid
    angle came. ``repeats``: of roll, and of pitch; ``stood``: s for which both have repeated."""

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
    sideways: int = 0

    @property
    def overturned(self) -> bool:
        return self.reports >= _REPORTS

    @property
    def on_its_side(self) -> bool:
        """Whether the vehicle is on its side, or further over."""
        return self.beyond >= _REPORTS

    @property
    def pushes_sideways(self) -> bool:
        """Whether the verticals push sideways, or the other way, rather than up or down."""
        return self.sideways >= _REPORTS

    @property
    def frozen(self) -> bool:
        return max(each.times for each in self.repeats) >= _FROZEN or self.stood >= _STOOD

    def doubtful(self, now: float) -> bool:
        """Whether the vehicle may be upside down, but this is not certain: the last report shows
        it, has no attitude or a frozen one, or an angle of the last minute was invalid. After an
        invalid angle it does not matter what the sensor reports since."""
        if self.overturned or self.frozen:
            return self.frozen
        beyond = max(abs(self.roll), abs(self.pitch)) > OVERTURNED
        return self.gone or beyond or now - self.broken < _BROKEN_FOR

    def after(self, report: Telemetry) -> Attitude:
        """Return the attitude after one more report. Without roll or pitch in it, nothing is known
        any more."""
        roll, pitch = report.roll, report.pitch
        if roll is None or pitch is None:
            return self._replace(reports=0, gone=self.told, beyond=0, sideways=0)
        worst, reports, broken = max(abs(roll), abs(pitch)), 0, self.broken
        beyond = sideways = 0
        if worst > _FULL_CIRCLE:
            broken = report.t
        elif worst > _SIDEWAYS:
            repeats = _apart(roll, self.roll) < _SAME and _apart(pitch, self.pitch) < _SAME
            sideways = max(self.sideways + (not repeats), 1)
            if worst > _ON_ITS_SIDE:
                beyond = max(self.beyond + (not repeats), 1)
            if worst > OVERTURNED:
                reports = max(self.reports + (not repeats), 1)
        rolls, pitches = self.told and roll == self.roll, self.told and pitch == self.pitch
        driven = turns(report)
        repeated = (
            self.repeats[0].after(report.t, rolls, driven),
            self.repeats[1].after(report.t, pitches, driven),
        )
        stood = self.stood + report.t - self.t if rolls and pitches else 0.0
        return Attitude(
            *(roll, pitch, reports, True, False, broken, repeated, stood, report.t, beyond),
            sideways,
        )


def _apart(a: float, b: float) -> float:
    return abs(math.remainder(a - b, 2.0 * math.pi))
