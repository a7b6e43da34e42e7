"""The texts of a difference: those of the pictures, or exact ones if those would be the same.

What does not live here: the layout (show.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from mission.authoring.diff.matching import leg_of, legs_of
from mission.authoring.graph import words
from mission.authoring.language.render import guard_text, node_pairs
from mission.model import AUTONOMOUS, Chart, Exit, Group, Handler, Leg, Mission, State, shown
from mission.model.units import number_text
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint

V = TypeVar("V")


def name(path: str) -> str:
    return path.removeprefix(f"{AUTONOMOUS}/")


def apart(one: V, two: V, plain: Callable[[V], str], exact: Callable[[V], str]) -> tuple[str, str]:
    """Texts for two different values; the exact ones if the usual ones are the same."""
    told = plain(one), plain(two)
    return told if told[0] != told[1] else (exact(one), exact(two))


def stands_after(chart: Chart, path: str) -> str:
    """The place of a leg as text: after which other leg."""
    paths = [s.path for s in legs_of(chart)]
    i = paths.index(path)
    return f"after {name(paths[i - 1])}" if i else "first"


def whole(state: State) -> str:
    """A leg in one line, for one that was added or removed."""
    leg = leg_of(state)
    parts = [words.kind(leg), words.setpoint(state.setpoint), words.outputs(state)]
    parts += [f"until {way(e)}" for e in leg.exits]
    parts += [f"for {time(leg.duration)}"] if leg.duration is not None else []
    parts += [f"timeout {time(leg.timeout)}"] if leg.timeout is not None else []
    parts += [f"else {leg.otherwise}"] if leg.otherwise else []
    return ", ".join(part for part in parts if part)


def home(mission: Mission) -> str:
    if mission.home is None:
        return "where the mission starts"
    return f"{number_text(mission.home.latitude_deg)} {number_text(mission.home.longitude_deg)}"


def start(without_fix: bool) -> str:
    return "also without a fix" if without_fix else "with a fix"


def time(seconds: float | None) -> str:
    return "none" if seconds is None else shown.duration(seconds)


def achieve(scope: Leg | Group | Mission) -> str:
    return words.achieve(scope.achieve) or "not stated"


def group(which: Group) -> str:
    rounds = f"{which.repeat} rounds" if which.repeat > 1 else ""
    aims = f"to achieve {achieve(which)}" if which.achieve else ""
    return ", ".join(filter(None, [rounds, aims, *(f"on {way(h)}" for h in which.handlers)]))


def level(state: State, name: str, vehicle: Vehicle) -> str:
    """The value of an output as text; safe if only the other mission names it."""
    output, levels = vehicle.output(name), dict(state.outputs)
    if output is None:
        return "no such output"
    return number_text(levels.get(name, output.safe))


AXES: dict[str, Callable[[Setpoint], Setpoint]] = {
    "speed": lambda s: Setpoint(surge=s.surge, turn=s.turn),
    "heading": lambda s: Setpoint(heading=s.heading),
    "vertical": lambda s: Setpoint(depth=s.depth, altitude=s.altitude, heave=s.heave),
    "attitude": lambda s: Setpoint(pitch=s.pitch, roll=s.roll),
}
_REST = {"speed": "stopped"}


def axis(axis: str) -> Callable[[Setpoint], str]:
    def told(setpoint: Setpoint) -> str:
        return _REST.get(axis, "not held") if setpoint == Setpoint() else words.setpoint(setpoint)

    return told


def exact_set(setpoint: Setpoint) -> str:
    names = ("surge", "turn", "heave", "heading", "depth", "altitude", "pitch", "roll")
    given = ((n, getattr(setpoint, n)) for n in names)
    return ", ".join(f"{n} {number_text(v)}" for n, v in given if v is not None)


def exact_kind(leg: Leg) -> str:
    bare = replace(leg, settings=(), exits=(), duration=None, timeout=None, otherwise=None,
                   achieve=())  # fmt: skip
    return " ".join(" ".join(pair).strip() for pair in node_pairs(bare, True))


def way(which: Exit | Handler | None) -> str:
    if which is None:
        return ""
    return words.guard(which.guard) + (f" -> {which.target}" if which.target else "")


def exact_way(which: Exit | Handler | None) -> str:
    if which is None:
        return ""
    return guard_text(which.guard, True) + (f" -> {which.target}" if which.target else "")


def exact_time(seconds: float | None) -> str:
    return "none" if seconds is None else f"{number_text(seconds)} s"
