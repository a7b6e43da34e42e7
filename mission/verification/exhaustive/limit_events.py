"""Events that breach each limit of the table.

What does not live here: readings, answers and time (events), what must follow (laws).
"""

from __future__ import annotations

import math

from mission.engine.areas import Fence
from mission.model import Area, Chart, Local
from mission.verification.exhaustive.cell import Configuration, Event
from mission.verification.exhaustive.commands import Play, script
from mission.verification.exhaustive.configurations import SHALLOW, doubt
from mission.verification.exhaustive.exit_inputs import end_leg
from mission.verification.exhaustive.lines import ANSWERS, GPS, PUSHES, THRUSTERS, told
from mission.verification.exhaustive.world import World
from protocol.messages import SetSafety
from protocol.topside import encode


def _tightens(limits: SetSafety, seconds: float = 4.5) -> Play:
    def play(world: World) -> None:
        world.say(encode(limits))
        world.wait(seconds)

    return script(play)


def _too_deep(world: World) -> None:
    world.put(world.deep)
    world.wait(4.0)
    world.say(encode(SetSafety(depth=1.0)))
    world.wait(4.5)


def _hard_depth(world: World) -> None:
    world.come_to(103.0)
    world.wait(12.5)


def _pushes_in_vain(world: World) -> None:
    world.sea.dives = True
    world.wait(18.5)


def sinks(metres: float, reports: int) -> Play:
    """Sink ``metres`` in each 2 s, ``reports`` times."""

    def play(world: World) -> None:
        world.wait(2.0)
        for _ in range(reports):
            world.go(metres, 2.0)
        world.wait(0.1)

    return script(play)


def _overturned(world: World) -> None:
    for roll_deg in (170.0, 172.0, -178.0, 171.0, 169.0):
        world.sea.roll_deg = roll_deg
        world.wait(2.0)


def _blinded(world: World) -> None:
    world.sea.unknown.add("depth")
    world.wait(8.5)


def _silent(world: World) -> None:
    world.reports = False
    world.wait(7.5)


def _spoilt(world: World) -> None:
    world.spoils = True
    world.wait(7.5)


def _own_depth(world: World, configuration: Configuration, chart: Chart) -> None:
    """Go beyond the mission's own depth, though the operator's limit (@SP) allows more."""
    world.say(encode(SetSafety(depth=60000.0)))
    own, hard = chart.mission.safety, world.vehicle.limits
    bound = hard.depth if own is None or own.depth is None else min(own.depth, hard.depth)
    world.come_to(bound + 1.2)
    world.wait(12.5)


def _stuck(world: World) -> None:
    world.wait(124.5)


def _topside_silent(world: World) -> None:
    world.engine.limit_topside_silence(3.0)
    world.wait(4.5)


def _rolls(world: World) -> None:
    world.sea.roll_deg = 75.0
    world.wait(4.5)


def _low(world: World) -> None:
    world.sea.control_v = 9
    world.wait(14.5)


def _turns_away(world: World, configuration: Configuration, chart: Chart) -> None:
    """Turn away from the heading that the leg holds; from 0 if it holds none."""
    state = chart.state(configuration.leaf) if configuration.leaf else None
    held = state.setpoint.heading if state is not None and state.setpoint is not None else None
    for number in range(10):
        world.sea.heading_deg = math.degrees(held or 0.0) + 15.0 * (number + 1)
        world.wait(2.0)


def _goes_elsewhere(world: World) -> None:
    world.sea.depth = SHALLOW
    world.wait(2.0)
    world.sea.course_deg = world.sea.heading_deg + 120.0
    course = math.radians(world.sea.course_deg)
    for _ in range(24):
        world.sea.north += math.cos(course)
        world.sea.east += math.sin(course)
        world.fix()
        world.wait(1.0)


def _loses_power(world: World) -> None:
    world.wait(2.5)
    world.sea.powered = False
    world.wait(9.0)


def _doubts(world: World) -> None:
    here = world.engine.estimate
    if here is None:
        return
    doubt(world)


def _area(name: str, out: bool, off: float, half: float) -> Play:
    """Set a square area ``off`` m east of the vehicle, as if the mission had named it. ``half``:
    half of its side, m."""

    def play(world: World) -> None:
        here = world.engine.estimate
        if here is None:
            return
        east = here.east + off
        corners = tuple(
            Local(here.north + n * half, east + e * half)
            for n, e in ((-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0))
        )
        places = [(corner.north, corner.east) for corner in corners]
        world.engine.core.watch.fences = (Fence(Area(name, out, corners), tuple(places)),)
        world.wait(4.5)

    return script(play)


def _nobody_answers(world: World, configuration: Configuration, chart: Chart) -> None:
    world.answers = ""
    end_leg(world, configuration, chart)
    world.wait(24.0)


def _leaks(world: World) -> None:
    world.sea.leak = True
    world.wait(4.5)


LIMITS = (
    Event(
        "limit radius",
        _tightens(SetSafety(radius=1.0)),
        "SP",
        limit="radius",
        needs=told("position"),
    ),
    Event(
        "in an area that is kept out of",
        _area("wreck", True, 0.0, 50.0),
        limit="radius",
        needs=told("position"),
    ),
    Event(
        "out of all that is kept in",
        _area("bay", False, 500.0, 50.0),
        limit="radius",
        needs=told("position"),
    ),
    Event("limit time", _tightens(SetSafety(time=0.6), 1.0), "SP", limit="time"),
    Event("limit depth", script(_too_deep), "SP", limit="depth", needs=told("depth")),
    Event("limit hard depth", script(_hard_depth), limit="hard depth", needs=told("depth")),
    Event(
        "limit unexplained descent", sinks(3.0, 3), limit="unexplained descent", needs=told("depth")
    ),
    Event(
        "limit no progress",
        script(_stuck),
        limit="no progress",
        also=frozenset({"minute"}),
        needs=told("depth"),
    ),
    Event(
        "limit depth contradicted",
        script(_pushes_in_vain),
        limit="depth contradicted",
        needs=told(PUSHES),
    ),
    Event(
        "limit depth unknown",
        script(_blinded),
        limit="depth unknown",
        sensor="depth",
        after=6.0,
        needs=told("depth"),
    ),
    Event("limit telemetry", script(_silent), limit="telemetry"),
    Event("limit telemetry, spoilt reports", script(_spoilt), limit="telemetry"),
    Event("limit leak", script(_leaks), limit="leak", needs=told("leak")),
    Event(
        "limit depth, the operator's wider", _own_depth, "SP", limit="depth", needs=told("depth")
    ),
    Event("limit topside", script(_topside_silent), limit="topside"),
    Event("limit no answer", _nobody_answers, limit="no answer", needs=told(ANSWERS)),
    Event("limit roll-over", script(_rolls), limit="roll-over", needs=told("attitude")),
    Event(
        "limit roll-over, upside down",
        script(_overturned),
        limit="roll-over",
        needs=told("attitude"),
    ),
    Event("limit voltage", script(_low), limit="voltage", needs=told("battery")),
    Event(
        "limit heading does not follow",
        _turns_away,
        limit="heading does not follow",
        needs=told("heading"),
    ),
    Event(
        "limit course against heading",
        script(_goes_elsewhere),
        limit="course against heading",
        needs=told(GPS),
    ),
    Event("limit brown-out", script(_loses_power), limit="brown-out", needs=told(THRUSTERS)),
    Event("limit uncertain", script(_doubts), "SP", limit="uncertain", needs=told("position")),
)
