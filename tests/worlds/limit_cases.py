"""For each row of LIMITS what trips it by a hair, and two ways in which it must not trip.

A row that has no case here fails every test over the rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from engine_world import VEHICLE, World, leg, mission, sets, when

from mission.engine.limits import BLIND_TIME, SILENCE
from mission.model import Outcome, Result
from mission.navigation import distribution
from protocol.messages import SetSafety

LEAKY = replace(VEHICLE, reports=VEHICLE.reports | {"leak"}, constant_batteries=False)
LONG = 20000.0
REPORT_S = 2.0
INSTANT = 1e-3  # s before a deadline

Play = Callable[[World], None]


def flying(depth: float = 10.0, **more: object) -> World:
    """Under way on heading 0 at 10 m, with 20 m asked for."""
    body = leg("out", settings=sets(surge=0.5, heading=0.0, depth=20.0), timeout=LONG)
    away = leg("away", when("depth", ">", 99.0), settings=sets(depth=20.0), timeout=LONG)
    world = World(mission(body, away, **more), vehicle=LEAKY)
    world.leak, world.trembles = False, 0.0  # a hair is less than a depth trembles by
    assert world.start()
    world.depth = depth
    world.nav.covariance = (0.01, 0.0, 0.01)
    world.wait(4.0)
    return world


def idle() -> World:
    world = World()
    world.trembles = 0.0
    world.wait(4.0)
    return world


def sink(world: World, rate: float, seconds: float) -> None:
    for _ in range(round(seconds / REPORT_S)):
        world.depth += REPORT_S * rate
        world.wait(REPORT_S)


def more(value: float) -> float:
    return math.nextafter(value, math.inf)


def reports(world: World, count: int, **state: object) -> None:
    """So many with this; then those as they were, until nothing is left of it."""
    before = {name: getattr(world, name) for name in state}
    for _ in range(count):
        for name, value in state.items():
            setattr(world, name, value)
        world.wait(REPORT_S)
    for name, value in before.items():
        setattr(world, name, value)
    world.wait(2 * REPORT_S)


def at_depth(world: World, count: int, beyond: Callable[[float], float]) -> None:
    world.tell(SetSafety(depth=11.0))
    sink(world, 0.25, 8.0)
    reports(world, count, depth=beyond(12.0))


def at_hard_depth(world: World, count: int, beyond: Callable[[float], float]) -> None:
    """In idle: under way the limit in force, never wider, is the first to act."""
    bound = VEHICLE.limits.depth + 1.0
    world.depth = bound
    world.wait(REPORT_S)
    reports(world, count, depth=beyond(bound))


def unasked(world: World, metres: float, seconds: float) -> None:
    """Below what was asked for: so far, then slowly, so that only how far it is decides."""
    sink(world, 0.5, 20.0)
    sink(world, 0.125, 2.0)
    sink(world, 0.25, metres / 0.25)
    sink(world, 0.125, seconds)
    sink(world, 0.0, 10.0)


def stuck(world: World, metres: float, seconds: float) -> None:
    """On the way to 20 m, from 10 m."""
    sink(world, 0.25, (metres - 10.0) / 0.25)
    world.wait(seconds)


def slowly(world: World) -> None:
    stuck(world, 15.0, 118.0)
    world.depth = 15.5
    world.wait(118.0)


def blind(world: World, seconds: float) -> None:
    world.nav.doubt["depth"] = "frozen"
    world.tell(world.report())
    world.wait(seconds)
    world.nav.doubt.clear()
    world.wait(4.0)


def doubted(world: World, why: str) -> None:
    """For one report."""
    world.nav.doubt["depth"] = why
    world.wait(REPORT_S)
    world.nav.doubt.clear()
    world.wait(4.0)


def unheard(world: World, seconds: float) -> None:
    world.engine.limit_topside_silence(30.0)
    world.engine.hear_topside(world.t)
    world.wait(seconds)


def unanswered(world: World, *times: int) -> None:
    """So many in a row, an answer in between."""
    world.answer = None
    sent = world.engine.core.watch.sent  # what the runtime would report about
    for row in times:
        for _ in range(row):
            world.tell(Outcome(Result.LOST, b"@ZAF6$", sent))
        world.tell(Outcome(Result.ACCEPTED, b"@ZAF6$", sent))


def volts(world: World, value: float, count: int) -> None:
    for _ in range(count):
        world.t += REPORT_S
        world.tell(world.report(batteries=(value, 48.0)))
    world.wait(4.0)


def long_run(world: World, seconds: float) -> None:
    world.tell(SetSafety(time=60.0))
    started = 100.0
    world.until(started + seconds)


def far(world: World, metres: float, count: int) -> None:
    world.tell(SetSafety(radius=500.0))
    world.nav.covariance = (0.0, 0.0, 0.0)
    _at(world, metres, 0.0, count)


def _at(world: World, north: float, sigma: float, count: int) -> None:
    before = world.nav.north, world.nav.covariance
    world.nav.north, world.nav.covariance = north, (sigma**2, 0.0, sigma**2)
    world.wait(count * REPORT_S)
    world.nav.north, world.nav.covariance = before
    world.wait(2 * REPORT_S)


def sigma_95() -> float:
    """With which 450 m from home is within 500 m for just 95 %."""
    low, high = 1.0, 100.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        sure = distribution.within(500.0, 450.0, 0.0, (middle**2, 0.0, middle**2)) >= 0.95
        low, high = (middle, high) if sure else (low, middle)
    return low


def unsure(world: World, share: float, count: int = 3) -> None:
    world.tell(SetSafety(radius=500.0))
    _at(world, 450.0, share * sigma_95(), count)


def turned(world: World, off_deg: float, count: int) -> None:
    """The set is 2 s old at the first of these."""
    reports(world, count, heading=math.radians(off_deg))


def course(world: World, off_deg: float, fixes: int) -> None:
    world.depth = 0.2
    world.nav.speed = 0.75
    world.wait(2.0)
    for second in range(fixes):
        world.wait(1.0)
        world.tell(world.fix(north=0.8 + second, speed=0.8, course=math.radians(off_deg)))


def thrust(world: World, share: float, count: int) -> None:
    reports(world, count, actuators=(share, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0))  # rudders move nothing


@dataclass(frozen=True, slots=True)
class Case:
    """``says``: the reason that goes on record. ``trips``: a hair beyond the bound, for just as long as it takes. ``short``: beyond it, but
    a sample or an instant less. ``bound``: at the bound, for long. Deadlines are reached, not
    passed, so of those ``short`` and ``bound`` are one."""

    says: str
    trips: Play
    short: Play
    bound: Play
    begin: Callable[[], World] = flying


def _same(value: float) -> float:
    return value


def _deadline(says: str, play: Callable[[World, float], None], seconds: float) -> Case:
    before: Play = lambda w: play(w, seconds - INSTANT)  # noqa: E731
    return Case(says, lambda w: play(w, seconds), before, before)


_ROLL = VEHICLE.limits.roll
_VOLTS = VEHICLE.limits.voltage

CASES: dict[str, Case] = {
    "depth": Case(
        "depth 12.0 m, limit 11 m",
        lambda w: at_depth(w, 2, more),
        lambda w: at_depth(w, 1, more),
        lambda w: at_depth(w, 30, _same),
    ),
    "hard depth": Case(
        "depth 101.0 m, hard limit 100 m",
        lambda w: at_hard_depth(w, 2, more),
        lambda w: at_hard_depth(w, 1, more),
        lambda w: at_hard_depth(w, 30, _same),
        begin=idle,
    ),
    "unexplained descent": Case(
        "sinking at 0.12 m/s at 22.8 m, and nothing asked for it",
        lambda w: unasked(w, 2.0, 4.0),
        lambda w: unasked(w, 2.0, 2.0),
        lambda w: unasked(w, 2.0, 0.0),
    ),
    "no progress": Case(
        "for 120 s no nearer to 20 m, at 17.5 m",
        lambda w: stuck(w, 17.5, 120.0),
        slowly,
        lambda w: stuck(w, 18.0, 600.0),
    ),
    "depth contradicted": Case(
        "the depth is contradicted: it stands",
        lambda w: doubted(w, "contradicted: it stands"),
        lambda w: doubted(w, "frozen"),
        lambda w: doubted(w, "absurd"),
    ),
    "depth unknown": _deadline(
        "submerged and without a depth to believe for 6 s", blind, BLIND_TIME
    ),
    "telemetry": _deadline(
        "no good report for 5 s", lambda w, s: w.wait(s, reports=False), SILENCE
    ),
    "topside": _deadline("nothing heard from topside for 30 s", unheard, 30.0),
    "no answer": Case(
        "3 commands in succession without an answer",
        lambda w: unanswered(w, 3),
        lambda w: unanswered(w, 2, 2, 2),
        lambda w: unanswered(w, 2, 0, 2),
    ),
    "leak": Case(
        "water inside",
        lambda w: reports(w, 1, leak=True),
        lambda w: reports(w, 30, leak=False),  # a sample less than one
        lambda w: reports(w, 30, leak=None),
    ),
    "roll-over": Case(
        "roll or pitch beyond 60 deg",
        lambda w: reports(w, 2, roll=-more(_ROLL)),
        lambda w: reports(w, 1, roll=more(_ROLL)),
        lambda w: reports(w, 30, roll=_ROLL),
    ),
    "voltage": Case(
        "control battery below 10 V",
        lambda w: volts(w, math.nextafter(_VOLTS, 0.0), 6),
        lambda w: volts(w, math.nextafter(_VOLTS, 0.0), 5),
        lambda w: volts(w, _VOLTS, 30),
    ),
    "time": _deadline("autonomous for 60 s", long_run, 60.0),
    "radius": Case(
        "500 m from home, limit 500 m",
        lambda w: far(w, more(500.0), 2),
        lambda w: far(w, more(500.0), 1),
        lambda w: far(w, 500.0, 30),
    ),
    "heading does not follow": Case(
        "heading 60 deg off what was set, and growing",
        lambda w: turned(w, 60.0, 5),
        lambda w: turned(w, 60.0, 4),
        lambda w: turned(w, 30.0, 30),
    ),
    "course against heading": Case(
        "course and heading more than 60 deg apart under way at the surface",
        lambda w: course(w, 60.001, 21),
        lambda w: course(w, 60.001, 20),
        lambda w: course(w, 60.0, 60),
    ),
    "brown-out": Case(
        "all thrusters neutral while thrust is set",
        lambda w: thrust(w, 0.02, 4),
        lambda w: thrust(w, 0.02, 3),
        lambda w: thrust(w, more(0.02), 30),
    ),
    "uncertain": Case(
        "95 % bound of the position reaches the radius, 500 m",
        lambda w: unsure(w, 1.001, 2),
        lambda w: unsure(w, 1.001, 1),
        lambda w: unsure(w, 0.999, 30),
    ),
}
