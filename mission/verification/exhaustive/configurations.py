"""The ways into every configuration of the runtime, for one mission on one profile.

    regions     each row of WAYS, by bytes
    legs        each leg x rounds (first, last, of every group that repeats around it)
                x handlers not acted, acted x no Z outstanding, one, one after two that were lost
    manual      each leg x rounds, interrupted: driving, waiting

A way that needs what a vehicle does not have (acknowledgements, water) is left out. The AUV's
control battery counts as measured here, so that its limit can act, too; it reports no leak.

What does not live here: what happens next (events).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mission.authoring.language import script
from mission.authoring.prepare import Prepared
from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    By,
    Chart,
    Position,
)
from mission.navigation import Navigation
from mission.onboard.store import Stored
from mission.verification.exhaustive.cell import Configuration
from mission.verification.exhaustive.fork import Fork
from mission.verification.exhaustive.lines import (
    ANSWERS,
    GPS,
    SPOKEN,
    THRUSTERS,
    WATER,
    Line,
    line_of,
)
from mission.verification.exhaustive.mooring import from_afar, mooring
from mission.verification.exhaustive.world import World
from protocol.messages import SetSafety
from protocol.topside import encode

PROFILES = {"auv": ("as-built", "documented")}  # by codec; the others have their dialect alone
SHALLOW = 0.2  # m
STICK = b"@MMF5$"
PROVED = 9  # s until a shallow depth has proved the surface, for a board whose own place is a fix
_ABOVE = 0.5  # V over the limit, low enough for the battery handlers of missions
DEEPER = 0.8  # m: where no thrust is reported, 1 m short of the held depth is a push in vain
_NOT_MINE = Position(30.0, 120.0)  # the home if a mission names none


class Unreachable(RuntimeError):
    """A way does not lead to its configuration: a bug of this package."""


@dataclass(frozen=True, slots=True)
class Ground:
    """A mission on a profile, and the worlds that configurations begin from."""

    line: Line
    prepared: Prepared
    profile: str
    chart: Chart
    idle: Fork[World]
    empty: Fork[World]
    under_way: Fork[World]
    acted: Fork[World]

    @property
    def mission(self) -> str:
        return Path(self.prepared.source).name


def profiles_of(prepared: Prepared) -> tuple[str, ...]:
    """Return the profiles of the mission's vehicle. Raises Unreachable if this proof does not have
    the bytes of that vehicle."""
    named = prepared.vehicle
    if named.codec not in SPOKEN:
        raise Unreachable(
            f"{prepared.source}: for {named.name}, and this proof speaks the bytes of "
            f"{', '.join(SPOKEN)} alone; auvmission check takes every vehicle"
        )
    return PROFILES.get(named.codec, (named.dialect,))


def ground(prepared: Prepared, profile: str) -> Ground:
    """Set up a mission on one of its ``profiles_of``. Raises Unreachable if the mission does not
    start."""
    line = line_of(replace(prepared.vehicle, dialect=profile, constant_batteries=False))
    home = prepared.mission.home or _NOT_MINE
    worlds = []
    for lines in ((), tuple(script(from_afar(prepared)))):
        world = World(line.vehicle, Stored(lines), home, line=line)
        world.sea.north, world.sea.east = mooring(prepared, home)
        world.navigate(Navigation(line.vehicle, date="2026-03-01"))
        for _ in range(5 if GPS in line.has else PROVED):
            world.wait(1.0)
            if "position" in line.has:
                world.fix()
        world.wait(0.5)
        worlds.append(world)
    empty, idle = (Fork(world) for world in worlds)
    started = idle.copy()
    started.say(b"@AA$")
    _expect(started, AUTONOMOUS, "@AA")
    started.wait(1.0)
    chart = started.engine.chart
    assert chart is not None
    sink(started)
    under_way = Fork(started)
    _let_handlers_act(started, chart)
    return Ground(line, prepared, profile, chart, idle, empty, under_way, Fork(started))


def configurations(ground: Ground) -> Iterator[tuple[Configuration, World]]:
    for way in WAYS:
        if way.needs <= ground.line.has:
            yield _by(way, ground)
    lines = LINES if ANSWERS in ground.line.has else LINES[:1]
    for leaf, rounds in _places(ground.chart):
        for acted, line in itertools.product((False, True), lines):
            yield _in_leg(ground, leaf, rounds, acted, line)
        for state, seconds in ((MANUAL_DRIVING, 0.1), (MANUAL_WAITING, 2.3)):
            yield _interrupted(ground, leaf, rounds, state, seconds)


def sink(world: World) -> None:
    """Bring the vehicle under water, at a rate that one report shows, so that no limit acts."""
    world.wait(2.0)
    world.put(world.deep + (0.0 if THRUSTERS in world.line.has else DEEPER))
    world.wait(4.0)


def rise(world: World) -> None:
    world.put(SHALLOW)
    world.wait(9.0)


# --- regions ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Way:
    """``begin``: the world of the ground; ``needs``: what the vehicle must have (lines)."""

    name: str
    state: str
    begin: str
    play: Callable[[World], None]
    auto: bool = True
    loaded: bool = True
    preceded: bool = False
    quiet: bool = True
    needs: frozenset[str] = frozenset()


def _stay(world: World) -> None:
    pass


def _auto_off(world: World) -> None:
    world.say(b"@NSOOOOCC$")
    for node in ("UACM", "BDGPS", "STM32"):
        world.node(f"{node} O\n".encode())
    world.wait(0.1)


def _stop(world: World) -> None:
    world.say(b"@ZAX0$")
    world.wait(0.3)


def _surface(world: World) -> None:
    world.say(b"@ZAWF$")
    world.wait(0.3)


def _stick(world: World) -> None:
    """A push, which may take over an emergency (R6)."""
    for seconds in (0.2, 0.1):
        world.say(STICK)
        world.wait(seconds)


def _let_go(world: World) -> None:
    _stick(world)
    world.wait(2.2)


def _deaf(world: World) -> None:
    world.answers = ""


def _surfaced(world: World) -> None:
    _surface(world)
    rise(world)


def _held_up(world: World) -> None:
    """Sink out of surfaced, and come back to the surface by thrust."""
    _surfaced(world)
    while world.state == SURFACED:
        world.go(0.4, 2.0)
    rise(world)


def _deaf_at_the_end(world: World) -> None:
    _surface(world)
    world.put(SHALLOW)
    world.wait(4.0)
    _deaf(world)
    world.wait(5.0)


def _chain(*parts: Callable[[World], None]) -> Callable[[World], None]:
    def play(world: World) -> None:
        for part in parts:
            part(world)

    return play


def _for(seconds: float) -> Callable[[World], None]:
    return lambda world: world.wait(seconds)


_E: Mapping[str, Any] = {"preceded": True}
_ANSWERED, _WET = frozenset({ANSWERS}), frozenset({WATER})
# fmt: off
WAYS: tuple[Way, ...] = (
    Way("empty", IDLE_EMPTY, "empty", _stay, loaded=False),
    Way("empty, deep", IDLE_EMPTY, "empty", sink, loaded=False, needs=_WET),
    Way("ready", IDLE_READY, "idle", _stay),
    Way("ready, deep", IDLE_READY, "idle", sink, needs=_WET),
    Way("ready, AUTO closed", IDLE_READY, "idle", _auto_off, auto=False),
    Way("ended by AUTO", IDLE_READY, "under_way", _auto_off, auto=False),
    Way("driving, empty", MANUAL_DRIVING, "empty", _stick, loaded=False),
    Way("waiting, empty", MANUAL_WAITING, "empty", _let_go, loaded=False),
    Way("driving", MANUAL_DRIVING, "idle", _stick),
    Way("waiting", MANUAL_WAITING, "idle", _let_go),
    Way("driving, deep", MANUAL_DRIVING, "idle", _chain(sink, _stick), needs=_WET),
    Way("waiting, deep", MANUAL_WAITING, "idle", _chain(sink, _let_go), needs=_WET),
    Way("waiting, unanswered", MANUAL_WAITING, "idle", _chain(_deaf, _let_go), quiet=False,
        needs=_ANSWERED),
    Way("driving, AUTO closed", MANUAL_DRIVING, "under_way", _chain(_stick, _auto_off, _stick),
        auto=False),
    Way("waiting, AUTO closed", MANUAL_WAITING, "under_way", _chain(_stick, _auto_off, _for(2.3)),
        auto=False),
    Way("driving, emergency before", MANUAL_DRIVING, "under_way", _chain(_stop, _for(2.0), _stick),
        **_E),
    Way("waiting, emergency before", MANUAL_WAITING, "under_way",
        _chain(_stop, _for(2.0), _let_go), **_E),
    Way("stopped, empty", STOPPED, "empty", _stop, loaded=False, preceded=True),
    Way("stopped", STOPPED, "idle", _stop, preceded=True),
    Way("stopped, deep", STOPPED, "under_way", _stop, preceded=True, needs=_WET),
    Way("stopped, unanswered", STOPPED, "under_way", _chain(_deaf, _stop), quiet=False, **_E,
        needs=_ANSWERED),
    Way("stopped, stick held", STOPPED, "under_way", _chain(_stick, _stop), preceded=True),
    Way("stopped, AUTO closed", STOPPED, "idle", _chain(_auto_off, _stop), auto=False, **_E),
    Way("stopped out of W", STOPPED, "under_way", _chain(_surface, _stop), preceded=True),
    Way("surfacing, empty", SURFACING, "empty", _chain(sink, _surface), loaded=False, **_E,
        needs=_WET),
    Way("surfacing", SURFACING, "under_way", _surface, preceded=True),
    Way("surfacing out of idle", SURFACING, "idle", _chain(sink, _surface), preceded=True,
        needs=_WET),
    Way("surfacing by thrust", SURFACING, "under_way", _chain(_surface, _for(10.5)), **_E,
        needs=_WET),
    Way("surfacing by W again", SURFACING, "under_way", _chain(_surface, _for(20.5)), **_E,
        needs=_WET),
    Way("surfacing, unanswered", SURFACING, "under_way", _chain(_deaf, _surface), quiet=False,
        **_E, needs=_ANSWERED),
    Way("surfacing, stick held", SURFACING, "under_way", _chain(_stick, _surface), **_E),
    Way("surfaced", SURFACED, "under_way", _surfaced, preceded=True),
    Way("surfaced, empty", SURFACED, "empty", _surfaced, loaded=False, preceded=True),
    Way("surfaced, AUTO closed", SURFACED, "under_way", _chain(_held_up, _auto_off), auto=False,
        **_E, needs=_WET),
    Way("surfaced, unanswered", SURFACED, "under_way", _deaf_at_the_end, quiet=False, **_E,
        needs=_ANSWERED),
)
# fmt: on


def _by(way: Way, ground: Ground) -> tuple[Configuration, World]:
    fork: Fork[World] = getattr(ground, way.begin)
    world = fork.copy()
    way.play(world)
    _expect(world, way.state, way.name)
    found = Configuration(
        ground.mission,
        ground.profile,
        way.name,
        way.state,
        auto=way.auto,
        loaded=way.loaded,
        preceded=way.preceded,
        quiet=way.quiet,
    )
    return found, world


# --- legs ---------------------------------------------------------------------------------

Rounds = tuple[tuple[str, int], ...]
LINES = ("quiet", "Z outstanding", "two Z lost, one outstanding")


def _places(chart: Chart) -> Iterator[tuple[str, Rounds]]:
    for state in chart.states:
        if state.leg is None:
            continue
        groups = [
            (s.path, s.group.repeat)
            for s in chart.states
            if s.group is not None and s.group.repeat > 1 and state.path.startswith(s.path + "/")
        ]
        for rounds in itertools.product(*([(p, 1), (p, last)] for p, last in groups)):
            yield state.path, rounds


def _in_leg(
    ground: Ground, leaf: str, rounds: Rounds, acted: bool, line: str
) -> tuple[Configuration, World]:
    world = (ground.acted if acted else ground.under_way).copy()
    world.engine.place(leaf, dict(rounds))
    if line != "quiet":
        _let_go(world)
        _deaf(world)
        world.say(b"@AA$")
        world.wait(0.05 if line == "Z outstanding" else 1.95)
    _expect(world, leaf, line)
    name = f"{leaf} {_words(rounds)}{', handlers acted' if acted else ''}, {line}"
    quiet = line == "quiet"
    found = Configuration(
        ground.mission, ground.profile, name, leaf, leaf, rounds, quiet=quiet, acted=acted
    )
    return found, world


def _interrupted(
    ground: Ground, leaf: str, rounds: Rounds, state: str, seconds: float
) -> tuple[Configuration, World]:
    world = ground.under_way.copy()
    world.engine.place(leaf, dict(rounds))
    world.say(STICK)
    world.wait(seconds)
    _expect(world, state, leaf)
    name = f"{state}, interrupted {leaf} {_words(rounds)}"
    return Configuration(ground.mission, ground.profile, name, state, leaf, rounds), world


def _words(rounds: Rounds) -> str:
    return ", ".join(f"round {number} of {path}" for path, number in rounds)


def _let_handlers_act(world: World, chart: Chart) -> None:
    """Let the battery's handler and ``on uncertain`` act, each once, from the first leg."""
    world.engine.place(chart.initial, {})
    full, own, hard = world.sea.control_v, chart.mission.safety.voltage, world.vehicle.limits
    world.sea.control_v = max(own or 0.0, hard.voltage) + _ABOVE
    world.wait(14.0)
    world.sea.control_v = full
    world.wait(2.0)
    if "position" not in world.line.has:
        return
    world.engine.place(chart.initial, {})
    doubt(world)
    world.say(encode(SetSafety(radius=60000.0)))
    world.wait(2.5)
    _expect(world, AUTONOMOUS, "handlers")
    if not any(step.by is By.UNCERTAIN for step in world.notes.steps):
        raise Unreachable("on uncertain has not acted")


def doubt(world: World) -> None:
    """Set a radius within which the vehicle is, but not with 95 %; it heads along the circle."""
    here = world.engine.estimate
    assert here is not None
    world.sea.heading_deg = 90.0
    world.say(encode(SetSafety(radius=math.hypot(here.north, here.east) + 2.0)))
    world.wait(4.5)


def _expect(world: World, state: str, way: str) -> None:
    if not world.state.startswith(state):
        raise Unreachable(f"{way}: {world.state}, not {state}: {world.runtime.engine.reason}")
