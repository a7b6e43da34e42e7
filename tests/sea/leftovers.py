"""Scenes of what was left over: nodes that close and clears that come while no depth is told, ports that are
away for a W, surfaces that are proved as it is let go, altimeters and zeros that lie to what floats.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator

from tests.sea import faults
from tests.sea.boards import CORE, FAINT, FLOAT, ROV, TETHER, TUNED, under_way
from tests.sea.laws import (
    HELD,
    Law,
    held_up,
    home,
    lives,
    never_deeper,
    noted,
    reached,
    upward_within,
    word_within,
)
from tests.sea.others import CoreBoard, Rov
from tests.sea.scene import Scene, Script, boat, dive, order
from tests.sea.world import World

Steps = Iterator[None]
FLOOR = 24.0  # m, where a scene lets it sink to the bottom


def silent(_now: float, _truth: float) -> float:
    """Nothing is told."""
    return math.nan


def tells(world: World, lie: faults.Lie = faults.honest) -> None:
    """The depth is told so from now on."""
    world.board.senses.depth = lie


def on_the_bottom(world: World, at_most: float = 300.0) -> Steps:
    """Let it sink, and lie there for a while."""
    yield from world.until(lambda: world.body.altitude < 0.5, at_most)
    yield from world.wait(12)
    world.notes.append(f"bottom={world.body.altitude < 0.5}")


def told_again(world: World) -> Steps:
    """The depth is back, and from now on it is to be brought up."""
    tells(world)
    world.mark("due")
    yield from world.held(260)


def node(world: World, letter: str, name: str) -> Steps:
    """The first operator closes (C) or opens (O) the node AUTO; a node that has no port stays as it is."""
    others = "OOOCC" if world.gps else "OOCCC"
    answer = yield from boat(world).ask(f"@NS{others}{letter}$", "NS", 8)
    world.notes.append(f"{name}={answer}")


def crash(world: World) -> Steps:
    """The program is killed, and there again."""
    starts = world.pi.starts
    world.pi.signal(signal.SIGKILL)
    yield from world.until(lambda: world.pi.starts > starts, 20)
    yield from world.wait(5)


def down(world: World, text: str) -> Steps:
    """Under way: as `dive` has it, or by another board's mission."""
    yield from under_way(world, text, "6min") if text else dive(world)


def closed_in_blind_ascent(text: str = "", killed: bool = False) -> Script:
    """No depth, W, and AUTO is closed in the ascent; water comes in, and it sinks to the bottom. AUTO is opened
    (or a crash opens it), and the depth comes back.
    """

    def script(world: World) -> Steps:
        yield from down(world, text)
        tells(world, silent)
        boat(world).send("@ZAWF$")
        yield from world.wait(4)
        yield from node(world, "C", "closed")
        if text:  # without fixes such an ascent pushes on until an X
            boat(world).send("@ZAX0$")
        world.body.buoyancy = -5.0
        yield from on_the_bottom(world)
        if killed:
            yield from crash(world)
        else:
            yield from node(world, "O", "opened")
        yield from world.wait(10)
        yield from told_again(world)

    return script


def closed_sank_blind(world: World) -> Steps:
    """AUTO is closed at 8 m, where it hovers; then the depth is silent while it sinks, and AUTO is opened."""
    yield from dive(world)
    world.body.buoyancy = 0.0
    yield from node(world, "C", "closed")
    yield from world.wait(20)
    tells(world, silent)
    yield from world.wait(10)
    world.body.buoyancy = -3.0
    yield from on_the_bottom(world)
    yield from node(world, "O", "opened")
    yield from world.wait(10)
    yield from told_again(world)


def cleared_blind(text: str = "") -> Script:
    """No depth, X, and `@AC$` twice; heavy from then on; the depth comes back where it lies on the bottom."""

    def script(world: World) -> Steps:
        yield from down(world, text)
        world.body.buoyancy = 0.0
        tells(world, silent)
        boat(world).send("@ZAX0$")
        yield from world.wait(9)
        for name, pause in (("first", 9.0), ("second", 1.0)):
            letter = yield from boat(world).ask("@AC$", "AC")
            world.notes.append(f"{name}={letter}")
            yield from world.wait(pause)
        world.body.buoyancy = -5.0
        yield from on_the_bottom(world)
        yield from told_again(world)

    return script


def let_go_blind(world: World) -> Steps:
    """A stick holds it down, the depth is silent, the radio is gone; 4 N too heavy; then the depth is back."""
    yield from dive(world, 5)
    world.spawn(boat(world).repeat("@MMD6$", 0.2, until=world.now + 8))
    yield from world.wait(4)
    tells(world, silent)
    yield from world.wait(4)
    boat(world).close()
    world.body.buoyancy = -4.0
    yield from world.wait(20)
    yield from told_again(world)


def blind_at_the_surface(word: str) -> Script:
    """Home by W; the depth is silent, X or nothing is said, and a minute later it sinks to the bottom."""

    def script(world: World) -> Steps:
        yield from dive(world)
        boat(world).send("@ZAWF$")
        yield from world.wait(80)
        tells(world, silent)
        if word:
            boat(world).send(word)
        yield from world.wait(75)
        world.body.buoyancy = -5.0
        yield from on_the_bottom(world)
        yield from told_again(world)

    return script


def held_up_blind_x(world: World) -> Steps:
    """Held up at the surface the depth is silent, and X lets it go; on the bottom the depth is back."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    world.body.buoyancy = -6.0
    yield from world.wait(150)
    tells(world, silent)
    yield from world.wait(3)
    boat(world).send("@ZAX0$")
    yield from on_the_bottom(world)
    yield from told_again(world)


def sank_while_off(word: str, blind: bool = False) -> Script:
    """At the surface by W or by X; the Pi has no power for two minutes, in which the vehicle sinks to the bottom."""

    def script(world: World) -> Steps:
        yield from dive(world, stay="10min")
        boat(world).send(word)
        yield from world.wait(100)
        world.notes.append(f"afloat={world.body.depth < 0.5 and not world.board.gears.turning()}")
        world.pi.wanted = False
        world.pi.power_cut()
        world.body.buoyancy = -5.0
        yield from on_the_bottom(world)
        if blind:
            tells(world, silent)
        world.pi.wanted = True
        world.pi.booted = world.now
        world.pi.start()
        if not blind:
            world.mark("due")
        yield from world.wait(15)
        if blind:
            tells(world)
            world.mark("due")
        yield from world.held(260)

    return script


def closed_on_the_bottom(world: World) -> Steps:
    """Home by W, AUTO is closed; it sinks to the bottom, and its depth is told all the time; a crash opens AUTO."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(90)
    yield from node(world, "C", "closed")
    world.body.buoyancy = -5.0
    yield from on_the_bottom(world)
    world.mark("due")
    yield from crash(world)
    yield from world.held(260)


def w_while_away(text: str = "", buoyancy: float = -4.0, killed: bool = False) -> Script:
    """The board's port is away, W; the port is back, and W again 1.5 s later."""

    def script(world: World) -> Steps:
        yield from down(world, text)
        world.line.vanish()
        yield from world.wait(3)
        boat(world).send("@ZAWF$")
        yield from world.wait(2)
        if killed:
            world.pi.signal(signal.SIGKILL)
            yield from world.wait(6)
        world.line.come_back()
        yield from world.wait(1.5)
        order(world, "@ZAWF$")
        world.body.buoyancy = buoyancy
        yield from world.held(260)

    return script


def w_in_full_thrust(world: World) -> Steps:
    """No depth: full thrust begins. W twice in its turn; the port is away for 1.5 s, and W a third time."""
    yield from dive(world)
    tells(world, silent)
    boat(world).send("@ZAWF$")
    yield from world.wait(1)
    boat(world).send("@ZAWF$")
    yield from world.wait(0.5)
    world.line.vanish()
    yield from world.wait(1.5)
    world.line.come_back()
    yield from world.wait(1.5)
    order(world, "@ZAWF$")
    world.body.buoyancy = -4.0
    yield from world.wait(25)
    tells(world)
    yield from world.held(260)


UP: tuple[Law, ...] = (reached(), home(300, HELD, off=False), held_up(), lives())
BOTTOM: tuple[Law, ...] = (*UP, noted("bottom=True"), never_deeper(FLOOR + 1))
BACK: tuple[Law, ...] = (*BOTTOM, upward_within(8))
LATER: tuple[Law, ...] = (*BOTTOM, upward_within(28))  # not risen in 20 s
NODES: tuple[Law, ...] = (noted("closed=S"), noted("opened=S"))
CLEARED: tuple[Law, ...] = (noted("first=N"), noted("second=C"))
LIFTED: tuple[Law, ...] = (*UP, never_deeper(22))
SHALLOW = {"floor": FLOOR}
SECOND = word_within("@ZAWF", 0.3, "due")
FIRST_DEPTH = (
    "what was under way and came to rest without a depth: up by the first that is believed"
)
SANK = "what sank while no depth was believed is brought up as soon as one is"
SAID_AGAIN = "an operator's W leaves at once"
SCENES: tuple[Scene, ...] = (
    Scene(
        "auto-closed-blind-heavy", FIRST_DEPTH, closed_in_blind_ascent(), (*BACK, *NODES), SHALLOW
    ),
    Scene(
        "auto-closed-blind-documented",
        FIRST_DEPTH,
        closed_in_blind_ascent(),
        (*BACK, *NODES),
        SHALLOW,
        board={"built": False},
    ),
    Scene(
        "auto-closed-blind-killed",
        FIRST_DEPTH,
        closed_in_blind_ascent(killed=True),
        (*BOTTOM, noted("closed=S"), upward_within(30)),
        SHALLOW,
    ),
    Scene(
        "core-auto-closed-blind-heavy",
        FIRST_DEPTH,
        closed_in_blind_ascent(CORE),
        (reached(), noted("bottom=True"), *NODES, home(300, HELD, off=False), lives()),
        {**FLOAT, **SHALLOW},
        {},
        TUNED,
        CoreBoard,
    ),
    Scene("auto-closed-sank-blind", SANK, closed_sank_blind, (*BACK, *NODES), SHALLOW),
    Scene("cleared-blind-heavy", SANK, cleared_blind(), (*LATER, *CLEARED), SHALLOW),
    Scene(
        "core-cleared-blind-heavy",
        SANK,
        cleared_blind(CORE),
        (reached(), noted("bottom=True"), *CLEARED, home(300, HELD, off=False), lives()),
        {**FLOAT, **SHALLOW},
        {},
        TUNED,
        CoreBoard,
    ),
    Scene("let-go-blind-heavy", FIRST_DEPTH, let_go_blind, (*LIFTED, upward_within(8))),
    Scene("surfaced-blind-heavy", SANK, blind_at_the_surface(""), BACK, SHALLOW),
    Scene("surfaced-blind-x-heavy", SANK, blind_at_the_surface("@ZAX0$"), LATER, SHALLOW),
    Scene("held-up-blind-x", SANK, held_up_blind_x, (*BOTTOM, upward_within(28)), SHALLOW),
    *[
        Scene(
            f"sank-while-off-{name}",
            "no state is an end",
            sank_while_off(word, blind),
            (*LATER, noted("afloat=True")),
            SHALLOW,
        )
        for name, word, blind in (
            ("surfaced", "@ZAWF$", False),
            ("stopped", "@ZAX0$", False),
            ("surfaced-blind", "@ZAWF$", True),
        )
    ],
    Scene(
        "auto-closed-bottom-killed",
        "no state is an end",
        closed_on_the_bottom,
        (*LATER, noted("closed=S")),
        SHALLOW,
    ),
    Scene("w-while-away-w", SAID_AGAIN, w_while_away(), (*LIFTED, SECOND)),
    Scene("w-while-away-killed", SAID_AGAIN, w_while_away(killed=True), (*LIFTED, SECOND)),
    Scene("w-in-full-thrust-w", SAID_AGAIN, w_in_full_thrust, (*LIFTED, SECOND)),
    Scene(
        "rov-w-while-away-w",
        "what the ascent has in use is said when the port is back",
        w_while_away(ROV, -2.0),
        (reached(), home(300, HELD, off=False), never_deeper(22), lives()),
        FAINT,
        {},
        TETHER,
        Rov,
    ),
)
