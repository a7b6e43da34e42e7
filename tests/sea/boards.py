"""Scenes with the boards of documents 002, 003 and 004."""

from __future__ import annotations

from collections.abc import Iterator

from tests.sea import faults
from tests.sea.laws import (
    HELD,
    Law,
    beating,
    home,
    lives,
    never_deeper,
    off_within,
    reached,
    told,
)
from tests.sea.others import CoreBoard, CoreBoardUpward, Robot, Rov, RovDownward
from tests.sea.scene import NoDive, Scene, Script, go, order
from tests.sea.world import World

Steps = Iterator[None]

CORE = """
    mission core vehicle coreboard
    home 30.2874595 120.1535765
    safety radius 700 time 30min depth 10
    down: depth 6 heading 90 gear 4 until depth >= 5.4 held 4s timeout 4min
    stay: gear 4 for {stay}
    up: surface until fix timeout 5min
"""
ROV = """
    mission tether vehicle rov
    start without fix
    safety radius 140 time 55min depth 12
    assume current 0.05
    down: down 6 until depth >= 5 timeout 2min
    stay: down 0 for {stay}
    up: surface timeout 5min
"""
ROBOT = """
    mission drive vehicle robot
    start without fix
    safety radius 90 time 20min
    ahead: gear 6 for 20s
    up: surface timeout 1min
"""


def under_way(world: World, text: str, stay: str = "2min", depth: float = 4.5) -> Steps:
    """Start, and wait until it is as deep as the mission wants it."""
    yield from go(world, text.replace("{stay}", stay))
    yield from world.until(lambda: world.body.depth > depth, 150)
    yield from world.wait(8)
    if world.body.depth < depth - 1:
        raise NoDive(f"{world.body.depth:.1f} m deep, {depth} m asked for: {world.notes}")


def flies(text: str, seconds: float) -> Script:
    """The mission as it is, to its end."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "20s")
        yield from world.wait(25)
        world.mark("due")
        yield from world.rest(seconds)

    return script


def ordered(text: str, frame: str, buoyancy: float | None = None, seconds: float = 200) -> Script:
    """X or W under water; with it the trim may change."""

    def script(world: World) -> Steps:
        yield from under_way(world, text)
        order(world, frame)
        if buoyancy is not None:
            world.body.buoyancy = buoyancy
        yield from world.wait(seconds)

    return script


def leaks(world: World) -> Steps:
    """The bit of the leak reads 1 1 0 1 1 0, report by report."""
    yield from under_way(world, CORE, "6min")
    count = 0

    def bit(_now: float, _truth: float) -> float:
        nonlocal count
        count += 1
        return 0.0 if count % 3 == 0 else 1.0

    world.board.senses.leak = bit
    yield from world.wait(1)
    world.mark("due")
    yield from world.rest(140)


def flickers(world: World) -> Steps:
    """The control voltage swings about its limit of 11 V, most of the time below it."""
    yield from under_way(world, CORE, "6min")
    world.board.senses.control = faults.flicker(10.6, 0.8, world.seed)
    yield from world.wait(1)
    world.mark("due")
    yield from world.rest(140)


def drives(world: World) -> Steps:
    """X while the robot drives."""
    yield from go(world, ROBOT)
    yield from world.wait(5)
    order(world, "@ZAX0$")
    yield from world.wait(10)


def deaf(text: str) -> Script:
    """The board hangs under way: it goes on as it was told last, and goes on reporting."""

    def script(world: World) -> Steps:
        yield from under_way(world, text)
        world.board.deaf_after = world.now
        world.mark("due")
        yield from world.command("stop")
        yield from world.wait(5)

    return script


def idles(world: World) -> Steps:
    """On deck, nothing to do."""
    yield from world.wait(5)
    world.mark("due")
    yield from world.wait(20)


TUNED: dict[str, object] = {"vehicle": "coreboard", "baud": 115200, "gps": False}
TETHER: dict[str, object] = {"vehicle": "rov", "baud": 115200, "gps": False}
ALIVE: tuple[Law, ...] = (reached(), home(200), never_deeper(16), lives())
NOTICED: tuple[Law, ...] = (reached(), home(100), never_deeper(16), lives())
FLOAT = {"buoyancy": 2.0}
FAINT = {"buoyancy": 1.0}

SCENES: tuple[Scene, ...] = (
    Scene("core-calm", "nothing is wrong", flies(CORE, 120), ALIVE, FLOAT, {}, TUNED, CoreBoard),
    Scene(
        "core-stop",
        "all neutral at once; the body rises slowly, and 20 s of not rising would be an ascent",
        ordered(CORE, "@ZAX0$"),
        (*ALIVE, off_within(0.3)),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-w",
        "the thrusters lift it",
        ordered(CORE, "@ZAWF$"),
        ALIVE,
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-w-other-sign",
        "letting go is a way of its own, and so is the depth loop",
        ordered(CORE, "@ZAWF$"),
        (reached(), home(200), never_deeper(20)),
        FLOAT,
        {},
        TUNED,
        CoreBoardUpward,
    ),
    Scene(
        "core-heavy-after-x",
        "the thrusters lift 6 N",
        ordered(CORE, "@ZAX0$", buoyancy=-6.0, seconds=300),
        (reached(), home(300, HELD, off=False), never_deeper(22)),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-leak",
        "two of three reports tell of water",
        leaks,
        NOTICED,
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-voltage", "most of a window is below", flickers, NOTICED, FLOAT, {}, TUNED, CoreBoard
    ),
    Scene(
        "core-deaf-stop",
        "nothing can be done; but the operator is not told that it stopped",
        deaf(CORE),
        (reached(), told("stop", "acknowledged")),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-idle",
        "R16: 10 Hz, neutral in idle, too; the INS has its power from them",
        idles,
        (reached(), beating(0.3), off_within(0)),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene("rov-calm", "nothing is wrong", flies(ROV, 120), ALIVE, FAINT, {}, TETHER, Rov),
    Scene("rov-w", "the thrusters lift it", ordered(ROV, "@ZAWF$"), ALIVE, FAINT, {}, TETHER, Rov),
    Scene(
        "rov-w-other-sign",
        "letting go is a way of its own",
        ordered(ROV.replace("down: down 6", "down: up 6").replace("down 0", "up 0"), "@ZAWF$"),
        (reached(), home(200), never_deeper(20)),
        FAINT,
        {},
        TETHER,
        RovDownward,
    ),
    Scene(
        "rov-heavy-after-x",
        "the thrusters lift 4 N",
        ordered(ROV, "@ZAX0$", buoyancy=-4.0, seconds=300),
        (reached(), home(300, HELD, off=False), never_deeper(22)),
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "robot-stop",
        "on land: stop is one frame",
        drives,
        (reached(), off_within(0.3)),
        {},
        {},
        {"vehicle": "robot", "baud": 115200, "gps": False},
        Robot,
    ),
)
