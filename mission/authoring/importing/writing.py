"""Write an imported route as a mission: a leg for each step, each with a clock.

    goto P  timeout = 1.5 d / (v - c) + 60 s, d from the place before, v at the leg's gear,
            c the vehicle file's current, which the check assumes; v - c is at least v / 5

``Answers`` has the values that the route does not state. After the last step the vehicle surfaces.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from mission.authoring.importing.route import (
    Circle,
    Fence,
    Findings,
    Go,
    Home,
    Mow,
    Point,
    Rise,
    Source,
    Step,
    Undulate,
)
from mission.legs import Goto, Loiter, Rows, Surface, Yoyo
from mission.legs.rows import corners
from mission.legs.waypoints import WITHIN
from mission.model import HOME, Area, Leg, LegKind, Local, Mission, Position, Setting
from mission.model.extent import AREAS, CORNERS, NAME
from mission.model.units import GEARS
from mission.model.vehicle import Vehicle
from mission.navigation.geodesy import EARTH, LocalFrame

_ASCENT = 300.0  # s, timeout of a leg to the surface
_NEAR = 200e3  # m from home: no mission goes farther
_LAST = "up"
_DECIMALS = 7  # of a degree; a centimetre


@dataclass(frozen=True, slots=True)
class Answers:
    """The values where the file states none; SI. ``home`` replaces that of the file."""

    home: Position | None = None
    home_first: bool = False  # the first point is home
    swap: bool = False  # the file has latitude and longitude exchanged
    depth: float | None = None
    altitude: float | None = None
    gear: int | None = None
    within: float = WITHIN.unsaid


def mission_of(
    name: str,
    steps: tuple[Step, ...],
    source: Source,
    answers: Answers,
    vehicle: Vehicle,
    found: Findings,
) -> Mission:
    """The mission of a route. Raises ImportErrors with all errors."""
    areas = tuple(_areas(source.fences, answers.swap, found))
    if answers.swap:
        steps = tuple(_swapped(step, found) for step in steps)
    home = _home(steps, source, answers, found)
    found.complain()
    if home is not None:
        _check_near(steps, home, found)
    written = _Writer(home, answers, vehicle, found)
    legs = tuple(written.legs(steps))
    found.complain()
    return Mission(slug(name) or "imported", vehicle.name, legs, home, areas=areas)


def slug(text: str) -> str:
    """A valid name of the mission language that resembles ``text``."""
    plain = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower()
    return re.sub(r"^(?=\d)", "n", plain)[: NAME.most].rstrip("_")


# --- where home is --------------------------------------------------------------------------------


def _points(steps: tuple[Step, ...]) -> Iterator[Point]:
    return (step.point for step in steps if not isinstance(step, Home | Rise))


def _home(
    steps: tuple[Step, ...], source: Source, answers: Answers, found: Findings
) -> Position | None:
    first = next((p.place for p in _points(steps)), None)
    if first is None:
        raise found.refusal("plan-route", "", "the route has no points")
    if answers.home_first and isinstance(first, Position):
        return _rounded(first)
    home = answers.home or source.home
    if home is None:
        hint = "say --home LATITUDE,LONGITUDE, or --home first for the first point"
        if source.local:
            hint = "say --home: LatOrigin,LongOrigin of the .moos file"
        found.refuse("unsaid", "", "the file does not say where the vehicle starts", hint)
    return home


def _check_near(steps: tuple[Step, ...], home: Position, found: Findings) -> None:
    """Refuse points far from home, with a hint if latitude and longitude seem to be exchanged."""
    far = [
        p for p in _points(steps) if isinstance(p.place, Position) and _far(home, p.place) > _NEAR
    ]
    turned = [_turned(p.place) for p in far if isinstance(p.place, Position)]
    exchanged = all(abs(p.latitude_deg) <= 90.0 and _far(home, p) < _NEAR for p in turned)
    hint = "give the home that it belongs to"
    if exchanged:
        hint = "latitude and longitude are exchanged: say --swap"
    for point in far:
        found.refuse("position", point.where, f"more than {_NEAR / 1000:.0f} km from home", hint)


def _turned(place: Position) -> Position:
    return Position(place.longitude_deg, place.latitude_deg)


def _far(home: Position, place: Position) -> float:
    """The distance in m on the sphere (haversine formula)."""
    north = math.radians(place.latitude_deg), math.radians(home.latitude_deg)
    turn = math.radians(place.longitude_deg - home.longitude_deg)
    across = math.cos(north[0]) * math.cos(north[1]) * math.sin(turn / 2.0) ** 2
    half = math.sin((north[0] - north[1]) / 2.0) ** 2 + across
    return 2.0 * EARTH * math.asin(min(1.0, math.sqrt(half)))


def _swapped(step: Step, found: Findings) -> Step:
    if isinstance(step, Home | Rise) or not isinstance(step.point.place, Position):
        return step
    place = step.point.place
    if abs(place.longitude_deg) > 90.0:
        found.refuse(
            "position",
            step.point.where,
            "exchanged, its latitude is beyond 90 degrees",
            "drop --swap",
        )
    return replace(step, point=replace(step.point, place=_turned(place)))


def _rounded(place: Position | Local) -> Position:
    assert isinstance(place, Position)
    return Position(round(place.latitude_deg, _DECIMALS), round(place.longitude_deg, _DECIMALS))


# --- areas ----------------------------------------------------------------------------------------


def _areas(fences: tuple[Fence, ...], swap: bool, found: Findings) -> Iterator[Area]:
    """The areas of the mission; areas to keep in come first, as in all missions."""
    if len(fences) > AREAS.most:
        found.refuse("too-long", fences[AREAS.most].where, AREAS.exceeded, "join some of them")
    for number, fence in enumerate(sorted(fences, key=lambda fence: fence.out), 1):
        if len(fence.corners) > CORNERS.most:
            found.refuse("too-long", fence.where, CORNERS.exceeded, "make two areas of it")
        corners = [_turned(corner) if swap else corner for corner in fence.corners]
        yield Area(f"fence_{number}", fence.out, tuple(map(_rounded, corners)))


# --- legs -----------------------------------------------------------------------------------------


class _Writer:
    """Writes the legs of one route; keeps the position of the vehicle, m from home."""

    def __init__(
        self, home: Position | None, answers: Answers, vehicle: Vehicle, found: Findings
    ) -> None:
        self._frame = LocalFrame(home) if home is not None else None
        self._answers, self._vehicle, self._found = answers, vehicle, found
        self._here = (0.0, 0.0)
        self._count = 0

    def legs(self, steps: tuple[Step, ...]) -> Iterator[Leg]:
        """The legs of the route; the last one always goes to the surface."""
        for step in steps[:-1] if isinstance(steps[-1], Rise) else steps:
            yield from self._leg(step)
        yield Leg(_LAST, Surface(until_fix=True), timeout=_ASCENT)

    def _leg(self, step: Step) -> Iterator[Leg]:
        match step:
            case Home():
                point = Point(Local(0.0, 0.0), step.where, "home")
                yield self._going(point, Goto(HOME, self._answers.within), self._way_to(point))
            case Rise():
                yield Leg(self._name("up"), Surface(until_fix=True), timeout=_ASCENT)
                if step.seconds > 0.0:
                    self._found.leave_out(step.where, "the time to stay at the surface")
            case Go(point):
                kind = Goto(self._place(point), self._within(point))
                yield self._going(point, kind, self._way_to(point))
            case Circle(point):
                yield self._circle(step)
            case Mow(point):
                yield self._mow(step)
            case Undulate(point):
                yield from self._undulate(step)

    def _circle(self, step: Circle) -> Leg:
        kind = Loiter(self._place(step.point), step.radius, step.side)
        around = step.turns * math.tau * step.radius / self._speed(step.point)
        way = self._way_to(step.point) / self._ground_speed(step.point)
        leg = self._going(step.point, kind, 0.0)
        return replace(leg, timeout=None, duration=_rounded_up(way + (step.seconds or around)))

    def _mow(self, step: Mow) -> Leg:
        point = step.point
        kind = Rows(self._place(point), step.bearing % math.tau, step.length, step.spacing,
                    step.count, step.side, self._within(point))  # fmt: skip
        way = self._way_to(point) + step.count * (step.length + step.spacing)
        leg = self._going(point, kind, way)
        self._here = corners(kind, self._here)[-1]
        return leg

    def _undulate(self, step: Undulate) -> Iterator[Leg]:
        """Cycles on the course to the point, as many as fit in the way; then a goto to it."""
        before, point = self._here, step.point
        way = self._way_to(point)
        height, boat = step.deep - step.shallow, self._vehicle
        lasts = height / boat.dive_rate + height / boat.ascent_buoyancy  # s, whatever its pitch
        steep = 2.0 * height / max(math.tan(step.pitch), 1e-3)
        cycle = max(steep, lasts * self._speed(point))
        cycles = max(1, int(way / cycle)) if cycle > 0.0 else 1
        there = self._here
        heading = math.atan2(there[1] - before[1], there[0] - before[0]) % math.tau
        leg = self._going(point, Yoyo(step.shallow, step.deep, cycles), way)
        surge = [s for s in leg.settings if s.word == "surge"]
        yield replace(leg, settings=(Setting("heading", heading), *surge))
        kind = Goto(self._place(point), self._within(point))
        yield self._going(replace(point, depth=step.shallow), kind, way)

    def _going(self, point: Point, kind: LegKind, way: float) -> Leg:
        settings = (*self._vertical(point), Setting("surge", self._gear(point) / GEARS))
        timeout = _rounded_up(1.5 * way / self._ground_speed(point) + 60.0)
        name = self._name(point.name)
        return Leg(name, kind, settings, timeout=timeout, otherwise=_LAST)

    def _name(self, said: str) -> str:
        """A unique name: the number of the leg, and ``said``."""
        self._count += 1
        return f"p{self._count}_{slug(said)}"[: NAME.most].rstrip("_")

    # --- values of the file or the answers -------------------------------------------------

    def _vertical(self, point: Point) -> tuple[Setting, ...]:
        if point.depth is not None:
            return (Setting("depth", round(point.depth, 2)),)
        if point.altitude is not None:
            return (Setting("altitude", round(point.altitude, 2)),)
        if self._answers.depth is not None:
            return (Setting("depth", self._answers.depth),)
        if self._answers.altitude is not None:
            return (Setting("altitude", self._answers.altitude),)
        hint = "say --depth, or --altitude, for the points that have none"
        self._found.refuse("unsaid", point.where, "no depth", hint)
        return ()

    def _gear(self, point: Point) -> int:
        if point.speed is not None:
            fastest = max(self._vehicle.speed_by_gear.y)
            gear = self._vehicle.gear_near(point.speed)
            if gear == 0 or point.speed > fastest * (1 + 1e-9):
                message = f"{self._vehicle.name} cannot go {point.speed:g} m/s"
                self._found.refuse(
                    "too-fast", point.where, message, f"its fastest is {fastest:g} m/s"
                )
            return max(gear, 1)
        if self._answers.gear is None:
            hint = "say --speed, or --gear, for the points that have none"
            self._found.refuse("unsaid", point.where, "no speed", hint)
        return self._answers.gear or 1

    def _speed(self, point: Point) -> float:
        return max(self._vehicle.speed_by_gear.at(self._gear(point)), 0.01)

    def _ground_speed(self, point: Point) -> float:
        speed = self._speed(point)
        return max(speed - self._vehicle.current, 0.2 * speed)

    def _within(self, point: Point) -> float:
        radius = point.within if point.within is not None else self._answers.within
        return min(max(radius, WITHIN.low), WITHIN.high)

    def _place(self, point: Point) -> Position | Local:
        return point.place if isinstance(point.place, Local) else _rounded(point.place)

    def _way_to(self, point: Point) -> float:
        """The way in m from the current position to the point, which becomes the position."""
        place, before = point.place, self._here
        if isinstance(place, Local):
            self._here = (place.north, place.east)
        elif self._frame is not None:
            latitude, longitude = (
                math.radians(place.latitude_deg),
                math.radians(place.longitude_deg),
            )
            self._here = self._frame.to_local(latitude, longitude)
        return math.dist(before, self._here)


def _rounded_up(seconds: float) -> float:
    """Round up to ten seconds."""
    return math.ceil(seconds / 10.0) * 10.0
