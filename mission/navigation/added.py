"""Sensors that a user adds: the table of kinds, and when a sensor is not believed.

    water    speed ahead through the water        scale u + deviation
    ground   ahead and to starboard over ground   the same and the current, turned into the hull
    place    position, from outside               north, east
    range    distance to a beacon                 its length, from the estimated position

- Outliers: a value is used if four of the five values before it had the same innovation, and if its
  normalised innovation squared is within the 99.9 % bound.
- Gate: ``opens`` values in a row beyond the bound, all with the same innovation and not all equal
  to the last bit, widen the states that they measure. So a good sensor that the filter refused is
  believed again. The speed through the water never opens the gate: what it would teach fades within
  half a minute by itself.
- Frozen: values that are equal to the last bit count for nothing. A speed is frozen once the
  vehicle's own speed or heading has changed since; also if it first came while the vehicle gathered
  way or turned, or if it is the first of all.

What does not live here: bytes (protocol.added), when a value is used (reckoner), the equations
(hull).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from mission.navigation.items import Aiding
from protocol.added import GROUND, PLACE, RANGE, WATER

if TYPE_CHECKING:  # importing numpy is slow, and the table alone does not need it
    from mission.navigation.filter import Motion

_SAME = 3  # values in a row that are equal to the last bit
_OTHER_SPEED, _OTHER_WAY = 0.1, 0.3  # m/s, rad: the vehicle's motion has changed by so much
_APART = 6.0  # sigmas between innovations that count as the same
_CONFIRM, _REMEMBERED = 4, 10  # of the five values before; innovations that are kept


@dataclass(frozen=True, slots=True)
class Added:
    """One kind of added sensor.

    ``sigma``: of each value, unless the vehicle file gives another. ``opens``: so many values in a
    row that are beyond the gate and agree open it (0: never). ``drift``: by how much their
    innovations may move apart per second, in ``unit``/s."""

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
    """What is remembered of one sensor.

    ``values``: its last value; ``same``: how often in a row it came; ``speed``, ``heading``: how
    the vehicle moved when it first came. ``off``: times and innovations of the last values.
    ``refused``: how many in a row were beyond the gate. ``lives``: the last value differs from the
    one before it, and first came on a steady course."""

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
            return True  # at rest, too: the vehicle drifts, and a working sensor has noise
        turned = abs(math.remainder(run.heading - self.heading, 2.0 * math.pi)) > _OTHER_WAY
        return turned or abs(run.expected - self.speed) > _OTHER_SPEED or not self.lives

    def noted(self, t: float, off: tuple[float, ...]) -> Seen:
        return self._replace(off=(*self.off, (t, off))[-_REMEMBERED:])

    def confirmed(self, a: Aiding) -> bool:
        return sum(self._agree(a, self.off[-6:-1])) >= _CONFIRM

    def insists(self, a: Aiding) -> bool:
        """Whether the refused values open the gate. Values that are all equal to the last bit do
        not: the sensor may have frozen while the vehicle moved as it does now, or may be received
        for the first time since it froze."""
        most = ADDED[a.kind].opens
        insisted = self.same < most <= self.refused
        return insisted and all(self._agree(a, self.off[-most:]))

    def _agree(
        self, a: Aiding, others: Iterable[tuple[float, tuple[float, ...]]]
    ) -> Iterator[bool]:
        """Yield for each of ``others`` whether its innovation is the same as the last one."""
        t, last = self.off[-1]
        for before, other in others:
            most = _APART * a.sigma + ADDED[a.kind].drift * (t - before)
            yield all(abs(x - y) <= most for x, y in zip(last, other, strict=True))
