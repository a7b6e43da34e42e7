"""Predict what the legs of a mission achieve: propagate a covariance along the planned way.

    x = north, east | current north, east | speed scale | compass error: constant, by the heading
        (sin, cos), wandering                      each with the sigma that the estimate assumes

    leg       d(north, east) = t current + scale w + (error) w turned by 90 deg, w through the water
    fix       observes position and speed over ground, and so the causes of the error since the last
              fix

The legs are flown in the order of the text, each to its planned end: to its places at its speed,
after the way, time or depth that its guard waits for, or else until its clock ends it. The vehicle
rises from the depth of the leg before at the rate of its buoyancy. Fixes come once it has been at
the surface for some seconds; a surface leg that awaits none ends before. The current is anywhere in
the assumed disc, so its sigma on each axis is half of the greatest current. Kalman's covariance
needs no readings, only the way (Gelb, Applied Optimal Estimation, 1974, ch. 4.2); the figures are
those of mission/navigation/model.py.

What does not live here: the coverage of an area (covered.py), goals, refusals and advice
(purpose.py).
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from mission.authoring.check.ascents import ascent_time
from mission.authoring.check.assumptions import SPEED_SHARE, TWO_SIGMA
from mission.authoring.check.covered import PIECES, Row, covered
from mission.authoring.check.places import pattern_of, places_of
from mission.authoring.check.slowest import slowest
from mission.legs import LEGS, Surface
from mission.legs.base import Point
from mission.legs.pattern import Pattern
from mission.model import Comparison, Expression, Group, Leg, Mission, Node, Or, Set, Setting
from mission.model.units import GEARS
from mission.model.vehicle import Vehicle
from mission.navigation.distribution import along, around_95, radius_95
from mission.navigation.fixes import SETTLED
from mission.navigation.geodesy import LocalFrame
from mission.navigation.model import figures

_N, _E, _CN, _CE, _SCALE, _BIAS, _SIN, _COS, _WANDER = range(9)
_STATES = 9
MOST = 1000  # most rows that are predicted, rounds included
_VERTICAL = frozenset({"depth", "altitude", "heave"})  # each replaces the others
_SLOW = 1.645 / TWO_SIGMA * SPEED_SHARE  # share of the speed; 95 % of dives lose less
_SLOWEST = 0.2  # least share of the speed that is made good in a current


@dataclass(slots=True)
class Expected:
    """The rows of one leg, those of all rounds in turn. ``pattern`` is as its author wrote it."""

    pattern: Pattern
    rows: list[Row] = field(default_factory=list)

    @property
    def errors(self) -> tuple[float, ...]:
        """The error in m at the end of each row; the worst of the rounds."""
        count = len(self.pattern.rows)
        return tuple(max(row.error for row in self.rows[k::count]) for k in range(count))

    @property
    def coverage(self) -> float:
        """The mean share of the area that is seen (covered.py); the least of the rounds."""
        count = len(self.pattern.rows)
        rounds = range(0, len(self.rows), count)
        return min(covered(self.pattern, self.rows[at : at + count]) for at in rounds)


class TooManyError(Exception):
    """The mission has more than ``MOST`` rows."""


def expected(mission: Mission, vehicle: Vehicle) -> dict[str, Expected]:
    """The rows of each leg of rows, by its path. Raises TooManyError."""
    return outlooks(mission, vehicle)[0]


def outlooks(
    mission: Mission, vehicle: Vehicle
) -> tuple[dict[str, Expected], dict[str, float], dict[str, float]]:
    """Three tables by the paths of legs; of rounds the worst counts. Raises TooManyError.

    1. The rows of each leg of rows. 2. For each leg, the radius in m that contains 95 % of dives at
    its end. 3. For each leg whose clock may end it too early, the s that
    95 % of dives need with the current from the worst direction (inf: the leg never arrives).
    """
    course = _Course(mission, vehicle)
    course.body(mission.body, "")
    return course.found, course.errors, course.late


def meant(mission: Mission, vehicle: Vehicle) -> list[tuple[str, Point]]:
    """For each leg or part of a leg in its order, rounds included: its path, and the m north and
    east from its begin to its planned end in still water. At most ``MOST`` rows of the table."""
    course = _Meant(mission, vehicle)
    with contextlib.suppress(TooManyError):
        course.body(mission.body, "")
    return course.legs


class Drift:
    """The covariance of the estimate, propagated along the way."""

    def __init__(self, vehicle: Vehicle, current: float) -> None:
        """``current``: m/s, the greatest that the mission assumes."""
        self._of = known = figures(vehicle)
        self._fix = vehicle.sensors.fix
        self._adrift = math.hypot(known.ground_velocity, known.drift.sigma)
        c = current / 2.0
        sigmas = (
            self._fix, self._fix, c, c, known.scale, known.compass.sigma, known.harmonic,
            known.harmonic, known.wander.sigma,
        )  # fmt: skip
        self._p = np.diag(np.square(sigmas))
        self._observe(slice(_CN, _CE + 1), self._adrift)  # before the start it drifts afloat

    def go(self, bearing: float, speed: float, time: float) -> None:
        """Go straight ahead; rad, m/s through the water, s."""
        known, way = self._of, speed * time
        c, s = math.cos(bearing), math.sin(bearing)
        f = np.eye(_STATES)
        f[_N, _CN] = f[_E, _CE] = time
        f[_N, _SCALE], f[_E, _SCALE] = way * c, way * s
        for state, share in ((_BIAS, 1.0), (_SIN, s), (_COS, c), (_WANDER, 1.0)):
            f[_N, state], f[_E, state] = -way * s * share, way * c * share
        f[_WANDER, _WANDER] = stays = known.wander.decay(time)
        q = np.zeros((_STATES, _STATES))
        sway = 2.0 * (known.sway.sigma * speed) ** 2 * known.sway.time * time
        ahead = 2.0 * known.deviation.sigma**2 * known.deviation.time * time if speed else 0.0
        aside = sway + (speed * known.heading) ** 2 * known.period * time
        q[_N, _N], q[_E, _E] = ahead * c * c + aside * s * s, ahead * s * s + aside * c * c
        q[_N, _E] = q[_E, _N] = (ahead - aside) * c * s
        q[_WANDER, _WANDER] = known.wander.sigma**2 * (1.0 - stays**2)
        self._p = f @ self._p @ f.T + q

    def afloat(self, time: float) -> None:
        """Stay at the surface for ``time`` s, where wind and waves move it, too."""
        self.go(0.0, 0.0, time)
        drift = self._of.drift.sigma * time
        self._p[_N, _N] += drift**2
        self._p[_E, _E] += drift**2

    def fix(self) -> None:
        """Take a fix: position and speed over ground."""
        self._observe(slice(_N, _E + 1), self._fix)
        self._observe(slice(_CN, _CE + 1), self._adrift)

    def _observe(self, pair: slice, sigma: float) -> None:
        seen = self._p[pair, pair] + sigma**2 * np.eye(2)
        gain = np.linalg.solve(seen, self._p[pair]).T
        self._p = self._p - gain @ self._p[pair]
        self._p = (self._p + self._p.T) / 2.0

    @property
    def place(self) -> tuple[float, float, float]:
        """Covariance nn, ne, ee in m^2."""
        return float(self._p[_N, _N]), float(self._p[_N, _E]), float(self._p[_E, _E])

    @property
    def radius(self) -> float:
        """m, the variable `uncertainty`."""
        return around_95(self.place)


class _Course:
    """Fly the mission in its order, as planned."""

    def __init__(self, mission: Mission, vehicle: Vehicle) -> None:
        self._vehicle, self._current = vehicle, mission.current(vehicle.current)
        self._frame = LocalFrame(mission.home) if mission.home else None
        self._drift = Drift(vehicle, self._current)
        self._at: Point = (0.0, 0.0)
        self._holds = {"surge": 0.0, "depth": 0.0}
        self._deepest = min(mission.safety.depth or math.inf, vehicle.limits.depth)
        self._deep, self._up = 0.0, math.inf  # m that it may still be deep; s at the surface
        self._rows, self._clock = 0, 0.0  # rows so far; clock of the current leg, s
        self._fixes = not mission.start_without_fix
        self.found: dict[str, Expected] = {}
        self.errors: dict[str, float] = {}
        self.late: dict[str, float] = {}

    def body(self, body: Iterable[Node], path: str) -> None:
        for node in body:
            if isinstance(node, Group):
                for _ in range(node.repeat):
                    self.body(node.body, f"{path}{node.name}/")
            else:
                self._node(node, path + node.name)

    def _node(self, node: Leg | Set, path: str) -> None:
        self._hold(node.settings)
        if not isinstance(node, Leg):
            return
        if (pattern := pattern_of(node.kind, self._frame, self._at)) is not None:
            self.found.setdefault(path, Expected(pattern))
        self._clock = node.duration or node.timeout or 0.0
        parts = LEGS[type(node.kind)].parts(node) or (node,)
        for part in self._flown(parts):
            self._hold(part.settings)
            self._leg(part, path)
        self.errors[path] = max(radius_95(self._drift.place), self.errors.get(path, 0.0))

    def _hold(self, settings: tuple[Setting, ...]) -> None:
        given = {setting.word: setting.value for setting in settings}
        if _VERTICAL & given.keys():
            self._holds = {word: v for word, v in self._holds.items() if word not in _VERTICAL}
        self._holds |= given

    def _flown(self, parts: tuple[Leg, ...]) -> Iterator[Leg]:
        """The parts that are flown: a way up is left out if the uncertainty is small enough."""
        passed = False
        for part in parts:
            if not (passed and isinstance(part.kind, Surface)):
                yield part
            bounds = [way.guard.expression for way in part.exits if way.target is not None]
            passed = (
                any(
                    getattr(bound, "variable", "") == "uncertainty"
                    and self._drift.radius <= getattr(bound, "bound", 0.0)
                    for bound in bounds
                )
                and len(parts) > 1
            )

    def _leg(self, leg: Leg, path: str) -> None:
        row, kind = LEGS[type(leg.kind)], leg.kind
        if depths := row.depths(kind):
            self._holds["depth"] = max(depths)
        if (pattern := pattern_of(kind, self._frame, self._at)) is not None:
            self._watch(leg, path, (self._at, *itertools.chain.from_iterable(pattern.rows)))
            self._survey(pattern, path)
        elif row.ascends:
            self._ascend(fixed=row.awaits_fix(kind))
        elif row.ends_at_last or row.places(kind):
            places = [self._at, *places_of(kind, self._frame)]
            self._watch(leg, path, places)
            for point in places_of(kind, self._frame):
                self._to(point)
        else:
            time, speed = self._time(leg), self._speed
            self._watch(leg, path, ((0.0, 0.0), (min(_ways(leg), default=0.0), 0.0)))
            bearing = self._holds.get("heading", 0.0)
            self._go(bearing, speed, time)
            north, east = self._at
            ahead = math.copysign(speed, self._holds["surge"])
            way = ahead * time if "heading" in self._holds else 0.0
            self._at = (north + way * math.cos(bearing), east + way * math.sin(bearing))
        if self._afloat:
            self._drift.fix()

    def _watch(self, leg: Leg, path: str, places: Sequence[Point]) -> None:
        """Record the leg in ``late`` if its clock may end it before it has reached its places. A
        part of a leg has a share of the leg's clock."""
        clock, speed = leg.duration or leg.timeout, (1.0 - _SLOW) * self._speed
        ways = [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(places) if a != b]
        if clock is None or not ways or self._speed <= 0.0:
            return
        needs = slowest(ways, speed, self._current)
        if needs > clock:
            self.late[path] = max(needs * self._clock / clock, self.late.get(path, 0.0))

    @property
    def _afloat(self) -> bool:
        """Whether it has been at the surface for as long as fixes need, and nothing leads down."""
        return self._fixes and self._target == 0.0 and self._up >= SETTLED

    @property
    def _target(self) -> float:
        """The depth in m that is set; with an altitude or downward thrust, the deepest allowed."""
        if "depth" in self._holds:
            return self._holds["depth"]
        down = self._holds.get("altitude", 0.0) > 0.0 or self._holds.get("heave", 0.0) > 0.0
        return self._deepest if down else 0.0

    def _go(self, bearing: float, speed: float, time: float) -> None:
        """Go straight ahead as in Drift; down to the target at once, up to it by buoyancy."""
        rate, target = self._vehicle.ascent_buoyancy, self._target
        rising = min(time, max(self._deep - target, 0.0) / rate)
        self._deep = max(target, self._deep - rate * rising)
        self._up = 0.0 if self._deep > 0.0 else self._up + time - rising
        self._drift.go(bearing, speed, time)

    @property
    def _speed(self) -> float:
        return self._vehicle.speed_by_gear.at(GEARS * abs(self._holds["surge"]))

    def _ascend(self, *, fixed: bool) -> None:
        self._drift.afloat(ascent_time(max(self._deep, self._target), self._vehicle))
        if fixed:
            self._drift.fix()
        self._holds = {"surge": 0.0, "depth": 0.0}
        self._deep = 0.0
        self._up = math.inf if fixed else 0.0  # without a fix, the leg ends at the surface at once

    def _to(self, point: Point) -> None:
        """Go straight to a point; across the current it takes longer."""
        north, east = point[0] - self._at[0], point[1] - self._at[1]
        speed, way = self._speed, math.hypot(north, east)
        if speed > 0.0 and way > 0.0:
            self._go(math.atan2(east, north), speed, way / self._made)
        self._at = point

    @property
    def _made(self) -> float:
        """m/s over ground with the current across the way."""
        return max(_SLOWEST * self._speed, math.sqrt(max(self._speed**2 - self._current**2, 0.0)))

    def _time(self, leg: Leg) -> float:
        """s until the planned end of the leg; other events that may end it earlier do not count."""
        meant = [leg.duration or leg.timeout or 0.0]
        for way in leg.exits:
            meant += [way.guard.held + self._until(one) for one in _either(way.guard.expression)]
        return min(meant)

    def _until(self, one: Comparison) -> float:
        """s until a comparison opens that may be the planned end of a leg: a time, a way, or a
        depth that the leg goes to, from the surface or the depth before. inf for all others."""
        rising = one.operator.startswith("<")
        if one.variable == "elapsed" and not rising:
            return one.bound
        if one.variable == "travelled" and not rising and self._speed > 0.0:
            return one.bound / self._made
        if one.variable == "depth" and rising and self._target <= one.bound:
            return max(self._deep - one.bound, 0.0) / self._vehicle.ascent_buoyancy
        if one.variable == "depth" and not rising and self._target >= one.bound:
            return one.bound / self._vehicle.dive_rate
        return math.inf

    def _survey(self, pattern: Pattern, path: str) -> None:
        self._rows += len(pattern.rows)
        if self._rows > MOST:
            raise TooManyError
        for begin, end in pattern.rows:
            self._to(begin)
            self.found[path].rows.append(self._row(pattern, begin, end))

    def _row(self, pattern: Pattern, begin: Point, end: Point) -> Row:
        across, bearing = [], pattern.bearing
        ends = [along(self._drift.place, bearing)]
        for piece in range(1, PIECES + 1):
            share = piece / PIECES
            before = along(self._drift.place, bearing + math.pi / 2.0)
            self._to(tuple(a + share * (b - a) for a, b in zip(begin, end, strict=True)))  # type: ignore[arg-type]
            after = along(self._drift.place, bearing + math.pi / 2.0)
            across.append((before + after) / 2.0)
        ends.append(along(self._drift.place, bearing))
        missed = sum(ends) / math.sqrt(2.0 * math.pi) + pattern.within / 2.0
        forth = pattern.framed(end)[0] > pattern.framed(begin)[0]
        pieces = tuple(across if forth else reversed(across))
        return Row(pieces, min(missed, math.dist(begin, end)), radius_95(self._drift.place))


class _Meant(_Course):
    def __init__(self, mission: Mission, vehicle: Vehicle) -> None:
        super().__init__(mission, vehicle)
        self._current = 0.0
        self._whole = True
        self.legs: list[tuple[str, Point]] = []

    def _node(self, node: Leg | Set, path: str) -> None:
        self._whole = isinstance(node, Leg) and not LEGS[type(node.kind)].parts(node)
        super()._node(node, path)

    def _leg(self, leg: Leg, path: str) -> None:
        north, east = self._at
        super()._leg(leg, path)
        made_good = self._at[0] - north, self._at[1] - east
        self.legs.append((path if self._whole else f"{path}/{leg.name}", made_good))
        if len(self.legs) >= MOST:
            raise TooManyError


def _ways(leg: Leg) -> Iterator[float]:
    """The m over ground (``travelled``) that alone end the leg."""
    for way in leg.exits:
        for one in _either(way.guard.expression):
            if one.variable == "travelled" and not one.operator.startswith("<"):
                yield one.bound


def _either(expression: Expression) -> Iterator[Comparison]:
    """The comparisons of which any alone opens the guard."""
    if isinstance(expression, Comparison):
        yield expression
    elif isinstance(expression, Or):
        for operand in expression.operands:
            yield from _either(operand)
