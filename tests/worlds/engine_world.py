"""A small world for laws over the engine: a navigation double, a mission kit, a pilot of time.

The double believes what it is told, so that each law holds one thing fixed: positions are set, not
estimated. The navigation's own laws stand in tests/navigation.
"""

from __future__ import annotations

import math
from dataclasses import replace

from mission.authoring.compiler.compiler import compile_mission
from mission.engine.engine import Engine, Input, Outputs
from mission.legs import Hold
from mission.model import (
    Chart,
    Comparison,
    Estimate,
    Exit,
    Guard,
    Health,
    Leg,
    Loaded,
    Mission,
    NavigationMode,
    Node,
    Outcome,
    Position,
    Result,
    Setting,
    Vertical,
)
from mission.model.shipped import load_vehicle
from protocol.messages import Emergency, Fix, Manual, Order, Setpoint, StartMission, Telemetry

VEHICLE = load_vehicle("auv")
HOME = Position(30.0, 120.0)
X, W = Emergency(Order.STOP), Emergency(Order.SURFACE)
M = Manual("MM", b"@MMF5$")
_METRE = 1.0 / 6371008.8


class Frame:
    def __init__(self, origin: Position) -> None:
        self.origin = origin

    def to_local(self, latitude: float, longitude: float) -> tuple[float, float]:
        north = (latitude - math.radians(self.origin.latitude_deg)) / _METRE
        east = (longitude - math.radians(self.origin.longitude_deg)) / _METRE
        return north, east * math.cos(latitude)

    def to_geodetic(self, north: float, east: float) -> tuple[float, float]:
        latitude = north * _METRE + math.radians(self.origin.latitude_deg)
        longitude = east * _METRE / math.cos(latitude) + math.radians(self.origin.longitude_deg)
        return latitude, longitude


class Navigation:
    """``at`` moves the vehicle; ``doubt[sensor]`` is why it is not to be believed; ``moves``: what
    it changes by is, all the same."""

    def __init__(self) -> None:
        self.frame: Frame | None = None
        self.report: Telemetry | None = None
        self.north = self.east = self.speed = 0.0
        self.covariance = (1.0, 0.0, 1.0)
        self.sigmas: dict[str, float] = {}
        self.current = (0.0, 0.0)
        self.mode = NavigationMode.FIX
        self.doubt: dict[str, str] = {}
        self.moves = False
        self.fix_t: float | None = None

    def set_origin(self, position: Position, now: float) -> None:
        self.frame = Frame(position)

    def start_here(self, now: float, within: float = 0.0) -> None:
        self.within = within
        self.frame = None
        self.mode = NavigationMode.DEAD_RECKONING

    def assume_current(self, most: float) -> None:
        self.assumed_current = most

    def telemetry(self, t: Telemetry, push: Vertical) -> None:
        self.report = t

    def fix(self, f: Fix) -> None:
        self.fix_t = f.t

    def less_off(self, own: Fix) -> Fix:
        return own

    def estimate(self, now: float) -> Estimate | None:
        r = self.report
        if r is None:
            return None
        return Estimate(
            t=now,
            north=self.north,
            east=self.east,
            depth=r.depth,
            depth_rate=0.0,
            altitude=r.altitude,
            heading=r.heading,
            speed=self.speed,
            current_north=self.current[0],
            current_east=self.current[1],
            covariance=self.covariance,
            sigmas=self.sigmas,
            nis=None,
            fix_age=None if self.fix_t is None else now - self.fix_t,
            mode=self.mode,
        )

    def health(self, sensor: str, now: float) -> Health:
        if sensor in self.doubt:
            return Health(False, self.doubt[sensor], 0.0, self.moves)
        fields = {"attitude": "roll", "battery": "batteries", "temperature": "temperature_c"}
        name = fields.get(sensor, sensor)
        if self.report is None or getattr(self.report, name) is None:
            return Health(False, "missing", math.inf)
        age = now - self.report.t
        return Health(age <= 6.0, "stale" if age > 6.0 else "", age)

    def snapshot(self) -> dict[str, object]:
        return dict(self.__dict__, doubt=dict(self.doubt))

    def restore(self, snapshot: dict[str, object]) -> None:
        self.__dict__.update(snapshot)


NEUTRAL = (0.0, 0.0, 0.0, 0.0, 0.0)


class World:
    """Drives an engine through time. The vehicle acknowledges everything unless told otherwise."""

    def __init__(
        self, mission: Mission | None = None, *, vehicle=VEHICLE, navigation: bool = True
    ) -> None:
        self.vehicle = vehicle
        self.nav = Navigation()
        self.engine = Engine(vehicle, self.nav if navigation else None)
        self.t = 100.0
        self.depth: float | None = 0.2
        self.trembles = 0.001  # m, from one report to the next: a depth that lives, and an echo
        self.heading, self.altitude, self.roll = 0.0, 20.0, 0.0
        self.actuators: tuple[float, ...] = (0.3, 0.3, 0.0, 0.0, 0.0)
        self.stops = True  # a stop is obeyed, not acknowledged alone
        self.leak: bool | None = None
        self.answer: Result | None = Result.ACCEPTED
        self.steps: list = []
        self.actions: list = []
        self.verdicts: list = []
        if mission is not None:
            self.tell(Loaded(compiled(mission, vehicle)))

    @property
    def is_stopped(self) -> bool:
        return bool(self.actions) and self.actions[-1][1].command is Order.STOP

    def tell(self, *inputs: Input) -> Outputs:
        """One step now; then what the vehicle answers to what was sent."""
        out = self.engine.step(self.t, inputs)
        self._keep(out)
        if self.answer is not None:
            for action in out.actions:
                self._keep(self.engine.step(self.t, [Outcome(self.answer, b"@Z$", action.command)]))
        return out

    def _keep(self, out: Outputs) -> None:
        self.steps += out.steps
        self.actions += [(self.t, a) for a in out.actions]
        self.verdicts += out.verdicts

    def report(self, **changes: object) -> Telemetry:
        sways = 1e-6 * math.sin(self.t)  # an attitude that stands to the last bit is frozen
        base = Telemetry(
            t=self.t,
            depth=self._trembling(self.depth),
            altitude=self._trembling(self.altitude),
            heading=self.heading,
            pitch=sways,
            roll=self.roll or sways,
            temperature_c=15.0,
            actuators=NEUTRAL if self.stops and self.is_stopped else self.actuators,
            batteries=(12.0, 48.0),
            leak=self.leak,
        )
        return base._replace(**changes)

    def _trembling(self, value: float | None) -> float | None:
        odd = math.floor(self.t / 2.0) % 2.0
        return None if value is None else value + odd * self.trembles

    def fix(self, north: float = 0.0, east: float = 0.0, **changes: object) -> Fix:
        lat, lon = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
        base = Fix(
            t=self.t,
            latitude=lat + north * _METRE,
            longitude=lon + east * _METRE / math.cos(lat),
            accuracy=2.5,
            hdop=1.0,
        )
        return replace(base, **changes)

    def until(self, t: float, *, reports: bool = True) -> None:
        """Time goes on to ``t``: timers when they are due, a report on every even second."""
        while True:
            timer = self.engine.next_timer()
            report = math.floor(self.t / 2.0) * 2.0 + 2.0 if reports else math.inf
            due = min(x for x in (timer, report, t) if x is not None)
            if due >= t and due not in (timer, report):
                self.t = t
                return
            if due > t:
                self.t = t
                return
            self.t = due
            self.tell(*([self.report()] if due == report else []))
            if due >= t:
                return

    def wait(self, seconds: float, *, reports: bool = True) -> None:
        self.until(self.t + seconds, reports=reports)

    def push(self) -> None:
        """The stick, for as long as takes an emergency over (R6)."""
        self.tell(M)
        self.wait(0.2, reports=False)
        self.tell(M)

    def start(self) -> bool:
        """At the surface with a fix, of a place that was not said before: @AA."""
        self.tell(self.report())
        self.tell(self.fix(self.trembles * self.t))
        self.tell(StartMission())
        return self.verdicts[-1].accepted

    @property
    def state(self) -> str:
        return self.engine.state

    def commands(self) -> list[Setpoint | Order]:
        return [a.command for _, a in self.actions]


def compiled(mission: Mission, vehicle=VEHICLE) -> Chart:
    return compile_mission(mission, vehicle, "0" * 64)


def guard(variable: str, operator: str, bound: float, *, held: float = 0.0, sure=None) -> Guard:
    return Guard(Comparison(variable, operator, bound, sure), held)


def when(variable: str, operator: str, bound: float, target: str | None = None, **more) -> Exit:
    return Exit(guard(variable, operator, bound, **more), target)


def sets(**words: float) -> tuple[Setting, ...]:
    return tuple(Setting(word, value) for word, value in words.items())


def leg(name: str, *exits: Exit, timeout: float | None = 60.0, **more) -> Leg:
    settings = more.pop("settings", sets(surge=0.5, heading=0.0, depth=5.0))
    kind = more.pop("kind", Hold())
    return Leg(name, kind, settings, exits, timeout=timeout, **more)


def mission(*body: Node, **more) -> Mission:
    more.setdefault("home", HOME)
    return Mission("test", "auv", body, **more)


def flying(*body: object, depth: float = 5.0, **more: object) -> World:
    """The mission under way for 2 s, at this depth."""
    world = World(mission(*body, **more))  # type: ignore[arg-type]
    assert world.start()
    world.depth = depth
    world.wait(2.0)
    return world


def legs_of(world: World) -> list[str]:
    """Every leg entered, in order, as people call it."""
    leaves = [s.entered[-1] for s in world.steps if s.entered]
    return [p.partition("/")[2] for p in leaves if p.startswith("autonomous/")]


def fixes(world: World, seconds: int, **changes: object) -> None:
    """One a second, each a little farther on."""
    for i in range(seconds):
        world.tell(world.fix(north=0.001 * (world.t + i), **changes))
        world.wait(1.0)
