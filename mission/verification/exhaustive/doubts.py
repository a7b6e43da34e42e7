"""Events of a depth that cannot be believed, and of a push that leads down.

Each begins with a W or a restart, so that there is an ascent that could be misled: by a stuck
depth, by a depth from before a silence, by false fixes, by pushes while upside down, by a leap.

What does not live here: what must follow (doubt_laws), sensor faults without an ascent (events).
"""

from __future__ import annotations

from mission.verification.exhaustive.cell import Event
from mission.verification.exhaustive.commands import Play, script
from mission.verification.exhaustive.configurations import SHALLOW
from mission.verification.exhaustive.lines import GPS, U12, WATER, W
from mission.verification.exhaustive.world import World

_PERIOD = 2.0  # s between reports
_OVER_DEG = (170.0, 172.0, -178.0, 171.0, 169.0)  # it changes, as in the water
_LEAP, _RISE = 25.0, 0.8  # m; m in a report period
_MADE_UP = 40  # s of false fixes, less than the rise takes


def _ordered_up(world: World) -> None:
    world.answers = "Y"
    world.put(world.deep)
    world.say(W)
    world.wait(0.5)


def _restarts_and_stands(world: World) -> None:
    """Restart at a shallow depth; reports come late, and then have the same depth each."""
    world.wait(0.05)
    world.sea.depth = SHALLOW
    world.restart()
    world.reports = False
    world.wait(5.0)
    world.reports = True
    world.wait(world.line.period)
    world.sea.frozen.add("depth")
    world.wait(9.5)


def _wanders(world: World) -> None:
    """Let the receiver send a new place each second, wherever the vehicle is."""
    for _ in range(_MADE_UP):
        world.sea.north += 0.5
        world.fix()
        world.wait(1.0)


def _wanders_without_a_depth(world: World) -> None:
    _ordered_up(world)
    world.wait(_PERIOD)
    world.sea.unknown.add("depth")
    _wanders(world)


def _restarts_and_wanders(world: World) -> None:
    """Restart under water, with a depth that is stuck at the surface, and false fixes."""
    world.wait(0.05)
    world.sea.depth = SHALLOW
    world.sea.told()
    world.sea.frozen.add("depth")
    world.sea.depth = world.deep
    world.restart()
    _wanders(world)


def _shallow_once(world: World) -> None:
    """A report from the surface, a silence, and another such report."""
    _ordered_up(world)
    world.wait(_PERIOD)
    world.put(SHALLOW)
    world.wait(world.line.period)
    world.reports = False
    world.wait(8.0)
    world.reports = True
    world.wait(_PERIOD + 1.0)


def _pushed_down(*, blind: bool) -> Play:
    """Lie upside down, so that W and U12 lead deeper."""

    def play(world: World) -> None:
        _ordered_up(world)
        if blind:
            world.sea.unknown.add("depth")
        for i in range(32):
            world.sea.roll_deg = _OVER_DEG[i % len(_OVER_DEG)]
            orders = [t.data for t in world.sent if t.data.startswith(b"@ZA")]
            world.go(1.0 * (orders[-1] in (W, U12)), _PERIOD)

    return script(play)


def _rises_elsewhere(world: World) -> None:
    """Let the depth leap, and follow the vehicle upward from there."""
    _ordered_up(world)
    world.wait(_PERIOD)
    world.sea.depth += _LEAP
    for _ in range(24):
        world.go(-_RISE, _PERIOD)


_WET, _GPS = frozenset({WATER}), frozenset({GPS})
DOUBTS = (
    Event(
        "restart, and the depth stands",
        script(_restarts_and_stands),
        also=frozenset({"restart"}),
        needs=_WET,
    ),
    Event(
        "restart, the depth stands, and fixes are made up",
        script(_restarts_and_wanders),
        also=frozenset({"restart"}),
        needs=_GPS,
    ),
    Event(
        "W, no depth, and fixes are made up",
        script(_wanders_without_a_depth),
        "W",
        "fixes",
        needs=_GPS,
    ),
    Event("W, and shallow before a silence", script(_shallow_once), "W", "quiet", needs=_WET),
    Event("W, upside down", _pushed_down(blind=False), "W", "over", needs=_WET),
    Event(
        "W, upside down and the depth unknown",
        _pushed_down(blind=True),
        "W",
        "over, blind",
        needs=_WET,
    ),
    Event("W, and it rises elsewhere", script(_rises_elsewhere), "W", "elsewhere", needs=_WET),
)
