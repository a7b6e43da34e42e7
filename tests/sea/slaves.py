"""More scenes with the boards of documents 002 to 004: deaf for seconds, upside down, flickering under floods,
slow lines, ends and ruins, and what the operator is told of boards that acknowledge nothing.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator

from tests.sea import faults
from tests.sea.boards import (
    ALIVE,
    CORE,
    FAINT,
    FLOAT,
    NOTICED,
    ROBOT,
    ROV,
    TETHER,
    TUNED,
    deaf,
    under_way,
)
from tests.sea.laws import (
    HELD,
    Law,
    held_deep,
    home,
    lives,
    never_deeper,
    noted,
    off_within,
    reached,
    told,
)
from tests.sea.mixtures import LAND
from tests.sea.others import CoreBoard, Robot, Rov
from tests.sea.scene import Scene, Script, boat, go, order, ruin
from tests.sea.world import World

Steps = Iterator[None]
Lie = Callable[[float, float], float]
LIFTED: tuple[Law, ...] = (reached(), home(300, HELD, off=False), never_deeper(22), lives())


def pattern(bits: str) -> Lie:
    """A bit that reads so, report by report, over and over."""
    count = -1

    def tell(_now: float, _truth: float) -> float:
        nonlocal count
        count += 1
        return float(bits[count % len(bits)])

    return tell


def deaf_for(text: str, frame: str, buoyancy: float) -> Script:
    """The board hears nothing for 7 s from the order on, and goes on as it was told last."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "6min")
        world.board.deaf_after, world.board.hears_again = world.now, world.now + 7
        order(world, frame)
        world.body.buoyancy = buoyancy
        yield from (world.held(210) if buoyancy < 0 else world.rest(220))

    return script


def over(text: str, then: str = "") -> Script:
    """It turns over; then the program crashes, or is told to end, or the depth is silent."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "6min")
        world.body.turn_over()
        world.mark("due")
        yield from world.wait(4)
        if then == "killed":
            world.pi.power_cut()
        elif then == "term":
            world.pi.systemctl_stop()
        elif then == "blind":
            world.board.senses.depth = lambda _now, _truth: math.nan
        else:
            boat(world).send("@ZAWF$")
        yield from world.rest(280)

    return script


def leak_under_flood(world: World) -> Steps:
    """The leak reads 1 1 0; the commander moves sliders and a lamp that it has not, 200 times a second."""
    yield from under_way(world, CORE, "6min")
    words = ("@DS1,5$", "@AO,lamp,3,$", "@DS2,5$", "@AO,usbl,1,$", "@DU$")
    world.spawn(boat(world).repeat(lambda n: words[n % len(words)], 1 / 200))
    world.board.senses.leak = pattern("110")
    yield from world.wait(1)
    world.mark("due")
    yield from world.rest(140)


def false_leak(world: World) -> Steps:
    """One report of three tells of water: noise."""
    yield from under_way(world, CORE, "2min")
    world.board.senses.leak = pattern("100")
    world.mark("strange")
    yield from world.wait(40)
    world.mark("calm")
    order(world, "@ZAWF$")
    yield from world.rest(150)


def slow_line(frame: str) -> Script:
    """At 9600 baud, under a stick of 100 words a second; then the order by another boat."""

    def script(world: World) -> Steps:
        yield from under_way(world, CORE, "6min")
        world.spawn(boat(world).repeat(lambda n: f"@MMF{n % 12}$", 0.01, until=world.now + 6))
        yield from world.wait(5)
        other = world.operator("other")
        yield from world.wait(0.3)
        other.send(frame)
        world.mark("due")
        yield from world.rest(200)

    return script


def ends(text: str, how: str, buoyancy: float) -> Script:
    """systemctl stop, or a crash with a broken configuration, with another trim."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "6min")
        world.mark("due")
        world.body.buoyancy = buoyancy
        if (
            how == "term"
        ):  # a board that goes neutral by itself holds nothing up when serve has ended
            world.pi.systemctl_stop()
            yield from world.until(lambda: not world.pi.running(), 300)
            return
        ruin(world, "config broken")
        world.pi.signal(signal.SIGKILL)
        yield from (world.held(220) if buoyancy < 0 else world.rest(220))

    return script


def possessed(text: str) -> Script:
    """An X; the board is 5 N too heavy, its depth 3 s late, its port clogs for half a minute on the way up."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "6min")
        world.board.senses.depth = faults.slow(3.0)
        order(world, "@ZAX0$")
        world.body.buoyancy = -5.0
        yield from world.wait(45)
        told_last = world.body.depth
        world.board.senses.depth = faults.clogged(told_last, world.seed)
        yield from world.wait(30)
        world.board.senses.depth = faults.honest
        yield from world.held(250)

    return script


def deaf_surface(world: World) -> Steps:
    """The board hangs under way, a little too heavy, and somebody says `surface`."""
    yield from under_way(world, ROV)
    world.body.buoyancy = -0.5
    world.board.deaf_after = world.now
    world.mark("due")
    yield from world.command("surface")
    yield from world.wait(5)


def robot_deaf(world: World) -> Steps:
    """The robot drives and hears nothing for 4 s, in which the stop is said."""
    yield from go(world, ROBOT.replace("20s", "60s"))
    yield from world.wait(8)
    world.board.deaf_after, world.board.hears_again = world.now, world.now + 4
    order(world, "@ZAX0$")
    yield from world.wait(25)


def robot_stick(world: World) -> Steps:
    """The robot is driven by a stick, and the radio is gone; systemctl stop."""
    operator = world.operator()
    yield from world.wait(16)
    world.spawn(operator.repeat("@MMF6$", 0.2, until=world.now + 5))
    yield from world.wait(3)
    moved = world.board.gears.turning()
    world.notes.append(f"moved={moved}")
    operator.close()
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(15)


DEEP_ENOUGH = held_deep(4.0, "strange", "calm")
SCENES: tuple[Scene, ...] = (
    Scene(
        "core-deaf-at-w-heavy",
        "frames come ten times a second; the first that is heard lifts it",
        deaf_for(CORE, "@ZAWF$", -5.0),
        LIFTED,
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-deaf-at-x",
        "neutral with the first frame that is heard",
        deaf_for(CORE, "@ZAX0$", 2.0),
        (*ALIVE, off_within(7.3)),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    *[
        Scene(
            f"core-over{'-' if then else ''}{then}",
            "let go it rises",
            over(CORE, then),
            (reached(), home(280), never_deeper(16), lives()),
            FLOAT,
            {},
            TUNED,
            CoreBoard,
        )
        for then in ("", "killed", "term", "blind")
    ],
    Scene(
        "core-leak-flooded",
        "two of three reports tell of water",
        leak_under_flood,
        NOTICED,
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-false-leak",
        "one report of three is noise",
        false_leak,
        (*ALIVE, DEEP_ENOUGH),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    *[
        Scene(
            f"core-slow-line-{name}",
            "a stick gets no more than the line carries",
            slow_line(frame),
            (*ALIVE, *laws),
            FLOAT,
            {},
            {**TUNED, "baud": 9600},
            CoreBoard,
        )
        for name, frame, laws in (("x", "@ZAX0$", (off_within(0.5),)), ("w", "@ZAWF$", ()))
    ],
    *[
        Scene(
            f"core-{how}-heavy",
            "the thrusters lift 5 N",
            ends(CORE, how, -5.0),
            LIFTED,
            FLOAT,
            {},
            TUNED,
            CoreBoard,
        )
        for how in ("term", "ruined")
    ],
    Scene(
        "core-late-clogged-heavy-x",
        "it has not risen in 20 s; thrust upward is kept",
        possessed(CORE),
        (reached(), home(300, HELD, off=False), never_deeper(26), lives()),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "rov-over",
        "let go it rises",
        over(ROV),
        (reached(), home(300), never_deeper(20), lives()),
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "rov-term-heavy",
        "the thrusters lift 3 N, until serve has ended",
        ends(ROV, "term", -3.0),
        LIFTED,
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "rov-ruined",
        "the last configuration that worked",
        ends(ROV, "ruined", 1.0),
        ALIVE,
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "rov-deaf-surface",
        "nothing can be done; but the operator is not told that it comes",
        deaf_surface,
        (reached(), told("surface", "acknowledged")),
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "rov-deaf-stop",
        "the same of a stop",
        deaf(ROV.replace("stay: down 0", "stay: left 2 down 0")),
        (reached(), told("stop", "acknowledged")),
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "robot-deaf",
        "the stop is there when it hears again",
        robot_deaf,
        (reached(), off_within(4.3), lives()),
        {},
        {},
        LAND,
        Robot,
    ),
    Scene(
        "robot-stick-term",
        "who would stop what it moves?",
        robot_stick,
        (reached(), noted("moved=True"), off_within(3.5)),
        {},
        {},
        LAND,
        Robot,
    ),
)
