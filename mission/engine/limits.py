"""The limits of R5 and R8 as a table of rows.

Each row names its source, how long a breach must last, where it acts and what follows. In regions
where a row does not act, it is still watched and reported.

What does not live here: what rows look at (watch), their counters (monitor), the bounds in force
(bounds), what a response does (engine).
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass

from mission.engine.areas import breached, doubted
from mission.engine.watch import Watch
from mission.model import AUTONOMOUS, MANUAL_WAITING, STOPPED, SURFACED
from mission.model.regions import IDLE
from mission.model.tables import Table
from mission.model.vehicle import Vehicle
from mission.navigation import distribution

DEPTH_MARGIN = 1.0  # m beyond the bound (R5)
SILENCE = 5.0  # s without a good report (R8)
LOST_MOST = 3  # commands (Z) in succession without an answer (R8)
BLIND_TIME = 6.0  # s without a believed depth, submerged


class Response(enum.Enum):
    SURFACING = "emergency/surfacing"
    UNCERTAIN = "the mission's on uncertain"
    REPEAT = "the whole set again once, then emergency/surfacing"


class On(enum.Enum):
    """When a row is looked at."""

    REPORT = "telemetry"
    FIX = "fix"
    CLOCK = "any time"


def never(watch: Watch) -> float | None:
    return None


@dataclass(frozen=True, slots=True, eq=False)
class Limit:
    """``breached`` returns True, False, or None for unknown (which counts neither way).

    ``bound`` describes the bound in words. A breach must last for ``samples``, or for ``seconds``:
    a sample within the bound takes one back, a second within it two. ``acts``: the regions and
    states in which it acts. ``due``: when a CLOCK row will be breached if nothing changes.
    ``needs``: the reports without which it is disarmed.
    """

    name: str
    source: str
    bound: str
    breached: Callable[[Watch], bool | None]
    why: Callable[[Watch], str]
    on: On = On.REPORT
    samples: int = 1
    seconds: float = 0.0
    acts: frozenset[str] = frozenset({AUTONOMOUS})
    response: Response = Response.SURFACING
    due: Callable[[Watch], float | None] = never
    needs: frozenset[str] = frozenset()

    def disarmed(self, vehicle: Vehicle) -> str:
        """Why the limit can never act on this vehicle; "" if it can."""
        absent = sorted(self.needs - vehicle.reports)
        if absent:
            return f"{vehicle.name} does not report {', '.join(absent)}"
        if "battery" in self.needs and vehicle.constant_batteries:
            return f"{vehicle.name} reports its batteries as constants"
        return ""


def _deeper(watch: Watch, bound: float) -> bool | None:
    depth = watch.vehicle_state.depth
    return None if depth is None else depth > bound + DEPTH_MARGIN


def _depth(watch: Watch) -> bool | None:
    return _deeper(watch, watch.bounds.depth)


def _hard_depth(watch: Watch) -> bool | None:
    return _deeper(watch, watch.vehicle.limits.depth)


def _depth_words(watch: Watch) -> str:
    return f"depth {watch.vehicle_state.depth or 0.0:.1f} m, limit {watch.bounds.depth:g} m"


def _position(watch: Watch) -> tuple[float, float] | None:
    e = watch.vehicle_state.estimate
    if e is None or not watch.vehicle_state.believable("position"):
        return None
    return e.north, e.east


def _radius(watch: Watch) -> bool | None:
    here = _position(watch)
    if here is None:
        return None
    return math.hypot(*here) > watch.bounds.radius or bool(_area(watch, here))


def _area(watch: Watch, here: tuple[float, float]) -> str:
    return (watch.fences and breached(watch.fences, here, watch.vehicle_state.depth)) or ""


def _uncertain(watch: Watch) -> bool | None:
    """Whether the 95 % bound of the estimate reaches the radius, or an area."""
    here, e = _position(watch), watch.vehicle_state.estimate
    if here is None or e is None:
        return None
    if watch.fences and doubted(watch.fences, here, e.covariance, watch.vehicle_state.depth):
        return True
    reach = math.hypot(*here) + distribution.around_95(e.covariance)
    if reach <= watch.bounds.radius:  # surely within, by a cheap test
        return False
    return distribution.within(watch.bounds.radius, *here, e.covariance) < 0.95


def _radius_words(watch: Watch) -> str:
    here = _position(watch) or (0.0, 0.0)
    if area := _area(watch, here):
        return f"north {here[0]:.0f} m, east {here[1]:.0f} m is against {area}"
    far = math.hypot(*here)
    return f"{far:.0f} m from home, limit {watch.bounds.radius:g} m"


def _uncertain_words(watch: Watch) -> str:
    here, e = _position(watch), watch.vehicle_state.estimate
    if here is not None and e is not None:
        depth = watch.vehicle_state.depth
        if area := doubted(watch.fences, here, e.covariance, depth):
            return f"95 % bound of the position is not clear: {area}"
    return f"95 % bound of the position reaches the radius, {watch.bounds.radius:g} m"


def _voltage(watch: Watch) -> bool | None:
    report = watch.vehicle_state.telemetry
    if report is None or not report.batteries or not watch.vehicle_state.health("battery").valid:
        return None
    volts = report.batteries[0]
    return None if volts is None else volts < watch.bounds.voltage


def _unanswered_words(watch: Watch) -> str:
    if watch.lost >= LOST_MOST:
        return f"{watch.lost} commands in succession without an answer"
    times, word = max((times, word) for word, (times, _) in watch.lost_words.items())
    return f"{times} times {word.decode('ascii')} without an answer"


def _time_due(watch: Watch) -> float | None:
    return None if watch.started is None else watch.started + watch.bounds.time


def _silence_due(watch: Watch) -> float | None:
    return watch.heard + SILENCE


def _topside_due(watch: Watch) -> float | None:
    if watch.topside_silence is None:
        return None
    return watch.topside_heard + watch.topside_silence


def _blind_due(watch: Watch) -> float | None:
    return None if watch.blind_since is None else watch.blind_since + BLIND_TIME


def _passed(due: Callable[[Watch], float | None]) -> Callable[[Watch], bool | None]:
    def breached(watch: Watch) -> bool | None:
        at = due(watch)
        return at is not None and watch.vehicle_state.now >= at

    return breached


def _roll(watch: Watch) -> bool | None:
    seen = watch.vehicle_state
    report = seen.telemetry
    if seen.overturned:
        return True
    if report is None or report.roll is None:
        return None
    over = max(abs(report.roll), abs(report.pitch or 0.0)) > watch.vehicle.limits.roll
    believed = seen.health("attitude").valid or (over and seen.attitude.on_its_side)
    return over if believed else None


def _leak(watch: Watch) -> bool | None:
    return watch.vehicle_state.telemetry.leak if watch.vehicle_state.telemetry else None


# includes the states in which everything should be stopped (R7)
_EVERYWHERE = frozenset({IDLE, AUTONOMOUS, MANUAL_WAITING, STOPPED, SURFACED})

_ROWS = (
    Limit(
        "depth",
        "depth",
        "the depth in force, and 1 m",
        _depth,
        _depth_words,
        samples=2,
        needs=frozenset({"depth"}),
    ),
    Limit(
        "hard depth",
        "depth",
        "the vehicle's own depth, and 1 m",
        _hard_depth,
        lambda w: (
            f"depth {w.vehicle_state.depth or 0.0:.1f} m, hard limit {w.vehicle.limits.depth:g} m"
        ),
        samples=2,
        acts=_EVERYWHERE,
        needs=frozenset({"depth"}),
    ),
    Limit(
        "unexplained descent",
        "depth",
        "2 m deeper while nothing asks for it, or 0.5 m deeper than it dives at its fastest",
        lambda w: w.descent.unexplained,
        lambda w: w.descent.words,
        samples=2,
        acts=_EVERYWHERE,
        needs=frozenset({"depth"}),
    ),
    Limit(
        "no progress",
        "depth",
        "120 s at more than 2 m from the depth asked for, and not 0.5 m nearer",
        lambda w: w.progress.stuck,
        lambda w: w.progress.words,
        needs=frozenset({"depth"}),
    ),
    Limit(
        "depth contradicted",
        "depth",
        "a depth that what else is known contradicts",
        lambda w: bool(w.vehicle_state.contradicted),
        lambda w: f"the depth is {w.vehicle_state.contradicted}",
        needs=frozenset({"depth"}),
    ),
    Limit(
        "depth unknown",
        "depth",
        f"{BLIND_TIME:g} s without a depth to believe, and submerged or led down",
        _passed(_blind_due),
        lambda w: f"submerged and without a depth to believe for {BLIND_TIME:g} s",
        on=On.CLOCK,
        due=_blind_due,
        needs=frozenset({"depth"}),
    ),
    Limit(
        "telemetry",
        "the vehicle",
        f"{SILENCE:g} s without a good report",
        _passed(_silence_due),
        lambda w: f"no good report for {SILENCE:g} s",
        on=On.CLOCK,
        due=_silence_due,
    ),
    Limit(
        "topside",
        "the operator",
        "the configured silence; off unless configured",
        _passed(_topside_due),
        lambda w: f"nothing heard from topside for {w.topside_silence or 0.0:g} s",
        on=On.CLOCK,
        due=_topside_due,
    ),
    Limit(
        "no answer",
        "the vehicle",
        f"{LOST_MOST} commands in succession, or one word as often",
        lambda w: w.unanswered >= LOST_MOST,
        _unanswered_words,
        on=On.CLOCK,
    ),
    Limit(
        "leak",
        "leak",
        "water inside",
        _leak,
        lambda w: "water inside",  # confirmed by the codec (R16)
        needs=frozenset({"leak"}),
    ),
    Limit(
        "roll-over",
        "attitude",
        "roll or pitch beyond the vehicle's own, or upside down",
        _roll,
        lambda w: f"roll or pitch beyond {math.degrees(w.vehicle.limits.roll):.0f} deg",
        samples=2,
        needs=frozenset({"attitude"}),
    ),
    Limit(
        "voltage",
        "control battery",
        "the voltage in force",
        _voltage,
        lambda w: f"control battery below {w.bounds.voltage:g} V",
        seconds=10.0,
        needs=frozenset({"battery"}),
    ),
    Limit(
        "time",
        "clock",
        "the autonomous time in force",
        _passed(_time_due),
        lambda w: f"autonomous for {w.bounds.time:g} s",
        on=On.CLOCK,
        due=_time_due,
    ),
    Limit(
        "radius",
        "estimate",
        "the radius in force, and the mission's areas",
        _radius,
        _radius_words,
        samples=2,
        needs=frozenset({"position"}),
    ),
    Limit(
        "heading does not follow",
        "heading",
        "an error beyond 30 deg that grew by 20 deg in 10 s or more, or two whole turns past it",
        lambda w: w.steering.astray,
        lambda w: w.steering.words,
        samples=2,
        needs=frozenset({"heading"}),
    ),
    Limit(
        "course against heading",
        "fixes",
        "60 deg, under way at the surface",
        lambda w: w.course_apart(),
        lambda w: "course and heading more than 60 deg apart under way at the surface",
        on=On.FIX,
        seconds=20.0,
        needs=frozenset({"heading", "position"}),
    ),
    Limit(
        "brown-out",
        "actuators",
        "all thrusters neutral while thrust is set and acknowledged",
        lambda w: w.powerless(),
        lambda w: "all thrusters neutral while thrust is set",
        samples=2,
        response=Response.REPEAT,
    ),
    Limit(
        "uncertain",
        "estimate",
        "the radius in force, and the mission's areas, not 95 % sure to be within",
        _uncertain,
        _uncertain_words,
        samples=2,
        response=Response.UNCERTAIN,
        needs=frozenset({"position"}),
    ),
)


def _name_of(row: Limit) -> str:
    return row.name


LIMITS: Table[str, Limit] = Table(_name_of, _ROWS)
