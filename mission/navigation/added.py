"""Sensors that a user adds: which there are, and when one is not believed.

    water    speed ahead through the water        scale u + deviation
    ground   ahead and to starboard over ground   the same and the current, turned into the hull
    place    where it is, from outside            north, east
    range    the way to a beacon                  its length, from where the filter believes to be

A value is used if four of the five before it were off by as much, and if it is within the 99.9 %
bound of its normalised innovation squared: an outlier is neither. The way back of an honest sensor
that the filter would not believe: ``opens`` values in a row beyond the bound, all off by as much
and not all the same to the last bit, widen what they speak of. The speed through the water opens
nothing: what it would tell fades within half a minute by itself. What says the same to the last bit
(a speed: while the vehicle's way has changed) is frozen, and counts for nothing; a speed so, too,
that first came while it gathered way or turned, or that is the first of all.

What does not live here: bytes (protocol.added), when it is used (reckoner), the equations (hull).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from mission.navigation.items import Aiding
from protocol.added import GROUND, PLACE, RANGE, WATER

if TYPE_CHECKING:  # numpy takes its time, and who asks for the table needs none
    from mission.navigation.filter import Motion

_SAME = 3  # times the same to the last bit
_OTHER_SPEED, _OTHER_WAY = 0.1, 0.3  # m/s, rad: the vehicle moves otherwise than then
_APART = 6.0  # sigmas between values that are off by as much
_CONFIRM, _REMEMBERED = 4, 10  # of the last five; values


@dataclass(frozen=True, slots=True)
class Added:
    """``sigma``: one of each value, unless the vehicle file says so; ``opens``: so many in a row
    that are beyond the gate and agree win against it (0: never); ``drift``: by how much more they
    may come apart in a second."""

    kind: str
    unit: str
    sigma: float
    opens: int
    drift: float
    description: str


ADDED: Mapping[str, Added] = MappingProxyType(
    {
        row.kind: row
        for row in (
            Added(WATER, "m/s", 0.05, 0, 0.0, "speed ahead through the water"),
            Added(GROUND, "m/s", 0.03, 10, 0.0, "speed ahead and to starboard over ground"),
            Added(PLACE, "m", 3.0, 5, 0.5, "position, from outside"),
            Added(RANGE, "m", 2.0, 8, 0.5, "way to a beacon"),
        )
    }
)


class Seen(NamedTuple):
    """What is remembered of one sensor: its last value, how often in a row it has come, and how the
    vehicle moved when it first did; when and by how much the last ones were off; how many in a row
    were beyond the gate; whether the last value is another than one before, of a steady course."""

    values: tuple[float, ...] = ()
    same: int = 0
    speed: float = 0.0
    heading: float = 0.0
    off: tuple[tuple[float, tuple[float, ...]], ...] = ()
    refused: int = 0
    lives: bool = False

    def heard(self, a: Aiding, run: Motion, *, steady: bool) -> Seen:
        if a.values == self.values:
            return self._replace(same=self.same + 1)
        lives = steady and self.same > 0
        return Seen(a.values, 1, run.expected, run.heading, self.off, self.refused, lives)

    def frozen(self, kind: str, run: Motion) -> bool:
        if self.same < _SAME:
            return False
        if kind in (PLACE, RANGE):
            return True  # at rest, too: it drifts, and an honest one has its noise
        turned = abs(math.remainder(run.heading - self.heading, 2.0 * math.pi)) > _OTHER_WAY
        return turned or abs(run.expected - self.speed) > _OTHER_SPEED or not self.lives

    def noted(self, t: float, off: tuple[float, ...]) -> Seen:
        return self._replace(off=(*self.off, (t, off))[-_REMEMBERED:])

    def confirmed(self, a: Aiding) -> bool:
        return sum(self._agree(a, self.off[-6:-1])) >= _CONFIRM

    def insists(self, a: Aiding) -> bool:
        """What says the same to the last bit all the time does not: where it froze the vehicle may
        have moved as it moves now, or have been heard for the first time since."""
        most = ADDED[a.kind].opens
        insisted = self.same < most <= self.refused
        return insisted and all(self._agree(a, self.off[-most:]))

    def _agree(
        self, a: Aiding, others: Iterable[tuple[float, tuple[float, ...]]]
    ) -> Iterator[bool]:
        """Whether each of them was off by as much as the last one."""
        t, last = self.off[-1]
        for before, other in others:
            most = _APART * a.sigma + ADDED[a.kind].drift * (t - before)
            yield all(abs(x - y) <= most for x, y in zip(last, other, strict=True))
