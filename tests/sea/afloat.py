"""Scenes of what floats or waits: surfaces that are proved as it is let go, slopes and zeros that contradict its
depth, sticks let go without one, ends and crashes under a depth that lies.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator

from tests.sea import faults
from tests.sea.laws import (
    HELD,
    Law,
    held_up,
    home,
    lives,
    never_deeper,
    noted,
    quiet,
    reached,
    sinking_noticed,
    upward_within,
)
from tests.sea.leftovers import LIFTED, SHALLOW, crash, node, silent, tells
from tests.sea.nuisances import Sluggish, gaps
from tests.sea.pairs import Twofold
from tests.sea.scene import TRUE_FIXES, Scene, Script, boat, dive, go, mission
from tests.sea.stm32 import Board
from tests.sea.world import World

Steps = Iterator[None]


def proved_as_let_go(deaf: float) -> Script:
    """Home by W; it sinks, the board is deaf for the first push, and it floats up let go; as it comes to the
    surface it is heavy again.
    """

    def script(world: World) -> Steps:
        yield from dive(world)
        boat(world).send("@ZAWF$")
        yield from world.wait(90)
        world.mark("due")
        for _ in range(2):
            world.body.buoyancy = -5.0
            yield from world.until(lambda: world.body.depth > 1.7, 60)
            world.board.deaf_until = world.now + deaf
            yield from world.wait(4)
            world.body.buoyancy = 6.0
            yield from world.until(lambda: world.body.depth < 0.2, 90)
            yield from world.until(lambda: not world.board.gears.turning(), 20)
        world.body.buoyancy = -5.0
        yield from world.held(260)

    return script


def again_and_again(world: World) -> Steps:
    """Home by W; it takes in water and loses it again, four times, and reports come with gaps."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(90)
    world.mark("due")
    world.spawn(gaps(world, 4, 13))
    for _ in range(4):
        world.body.buoyancy = -6.0
        yield from world.wait(35)
        world.body.buoyancy = 6.0
        yield from world.wait(35)
    yield from world.wait(20)


def slopes(world: World, rate: float, seconds: float) -> Steps:
    """The current carries it over a slope: the floor comes nearer, or goes."""
    begin, floor = world.now, world.body.floor
    while world.now < begin + seconds:
        world.body.floor = floor - rate * (world.now - begin)
        yield


def starts_over(afloat: Callable[[World], Steps]) -> Script:
    """On deck the altimeter tells of what a floating vehicle need not care for; a start, and a dive."""

    def script(world: World) -> Steps:
        world.operator("first")
        yield from world.wait(18)
        yield from afloat(world)
        world.operators.pop().close()
        yield from go(world, mission(5, 7, stay="20s"))
        yield from world.until(lambda: world.body.depth > 4, 60)
        world.notes.append(f"dived={world.body.depth > 4}")
        yield from world.wait(35)
        world.mark("due")
        yield from world.rest(120)

    return script


def garbage_below(world: World) -> Steps:
    """The altimeter tells anything, then a floor that goes at 0.5 m/s."""
    world.board.senses.altitude = faults.garbage(world.seed, 30.0)
    yield from world.wait(40)
    world.board.senses.altitude = faults.drifting(world.now, 0.5)
    yield from world.wait(30)
    world.board.senses.altitude = faults.honest


def slope_and_heavy(killed: bool, away: bool) -> Script:
    """Home by W it drifts over a slope that comes 0.4 m/s nearer; water comes in, at once or when it is over."""

    def script(world: World) -> Steps:
        yield from dive(world)
        boat(world).send("@ZAWF$")
        yield from world.wait(90)
        yield from slopes(world, 0.4, 20)
        if killed:
            yield from crash(world)
        if away:
            yield from world.wait(40)
        world.mark("due")
        world.body.buoyancy = -5.0
        yield from world.held(260)

    return script


def zero_ends(
    after: float, word: str = "@ZAWF$", killed: bool = False, wait: float = 2.0
) -> Script:
    """The zero is 1.3 m off from depth on. So many seconds after the surface it is right again, and 2 s later
    water comes in.
    """

    def script(world: World) -> Steps:
        yield from dive(world)
        tells(world, faults.shifted(1.3))
        boat(world).send(word)
        yield from world.until(lambda: world.body.depth < 0.2, 120)
        yield from world.wait(after)
        if killed:
            world.pi.signal(signal.SIGKILL)
        tells(world)
        yield from world.wait(wait)
        world.mark("due")
        world.body.buoyancy = -5.0
        yield from world.held(280)

    return script


def term_drifting(world: World) -> Steps:
    """systemctl stop, 4 N too heavy, and a depth that loses 5 cm a second for half a minute."""
    yield from dive(world)
    begin = world.now
    tells(world, lambda now, truth: truth - 0.05 * min(30.0, now - begin))
    world.body.buoyancy = -4.0
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.until(lambda: not world.pi.running(), 320)
    yield from world.wait(40)


def stands_over_a_crash(world: World) -> Steps:
    """At 8 m the depth stands at 0.3 m to the last bit, and the program crashes; 4 N too heavy; back at last."""
    yield from dive(world)
    tells(world, lambda _now, _truth: 0.3)
    world.body.buoyancy = -4.0
    yield from crash(world)
    world.mark("due")
    yield from world.wait(90)
    tells(world)
    yield from world.held(260)


def surfaced_blind_killed(after: float) -> Script:
    """Home by W without a depth; so long after it was let go it takes in water, and the program crashes."""

    def script(world: World) -> Steps:
        yield from dive(world)
        tells(world, silent)
        boat(world).send("@ZAWF$")
        yield from world.until(lambda: world.body.depth < 0.2, 200)
        yield from world.until(lambda: not world.board.gears.turning(), 200)
        yield from world.wait(after)
        world.mark("due")
        world.body.buoyancy = -5.0
        yield from crash(world)
        yield from world.wait(260)

    return script


def let_go_without_depth(world: World) -> Steps:
    """A stick holds it down; the depth is silent for ever, and the radio is gone: a minute of waiting."""
    yield from dive(world, 5)
    world.body.buoyancy = 0.0
    world.spawn(boat(world).repeat("@MMD4$", 0.2, until=world.now + 3))
    yield from world.wait(2)
    tells(world, silent)
    yield from world.wait(1)
    boat(world).close()
    world.mark("due")
    yield from world.wait(60)
    world.body.buoyancy = 4.0
    yield from world.rest(260)


def waits_closed(world: World) -> Steps:
    """A stick is let go at 5 m, where it hovers; AUTO is closed for two minutes; opened, it takes in water."""
    yield from dive(world, 5)
    world.body.buoyancy = 0.0
    world.spawn(boat(world).repeat("@MMF2$", 0.2, until=world.now + 3))
    yield from world.wait(8)
    yield from node(world, "C", "closed")
    world.mark("closed")
    yield from world.wait(120)
    world.mark("open")
    yield from node(world, "O", "opened")
    world.body.buoyancy = -3.0
    world.mark("due")
    yield from world.held(260)


def closed_indoors(world: World) -> Steps:
    """Indoors, no depth and no fixes: somebody has tried the stick, lets go, and closes AUTO to reach for a screw."""
    tells(world, silent)
    assert world.receiver
    world.receiver.mode = "dead"
    operator = world.operator()
    yield from world.wait(16)
    world.spawn(operator.repeat("@MMF2$", 0.2, until=world.now + 3))
    yield from world.wait(8)
    yield from node(world, "C", "closed")
    world.mark("due")
    yield from world.wait(100)


def tried_on_deck(end: Callable[[World], object], blind: bool) -> Script:
    """On deck somebody has tried the stick and let go; 6 s later the program is told to end, or crashes. `blind`:
    indoors, where no depth and no fix is told, and with AUTO closed.
    """

    def script(world: World) -> Steps:
        if blind:
            tells(world, silent)
            assert world.receiver
            world.receiver.mode = "dead"
        operator = world.operator()
        yield from world.wait(16)
        world.spawn(operator.repeat("@MMF2$", 0.2, until=world.now + 3))
        yield from world.wait(9)
        if blind:
            yield from node(world, "C", "closed")
        world.mark("due")
        end(world)
        yield from world.wait(50)

    return script


def stopped_closed(world: World) -> Steps:
    """X at 8 m, AUTO is closed, and water comes in: it sinks for 50 s; then AUTO is opened."""
    yield from dive(world)
    boat(world).send("@ZAX0$")
    yield from world.wait(1)
    yield from node(world, "C", "closed")
    world.mark("closed")
    world.body.buoyancy = -1.0
    yield from world.wait(50)
    world.mark("due")
    yield from node(world, "O", "opened")
    yield from world.held(260)


STARTS: tuple[Law, ...] = (
    *(reached(), noted("start=A"), noted("dived=True"), home(120), never_deeper(13), lives()),
)
DRIFTS = "what floats drifts over slopes"
ZERO = "what moves again is believed, and what is not is brought up all the same"
SCENES: tuple[Scene, ...] = (
    *[
        Scene(
            f"proved-as-let-go-{name}",
            "what did not rise by letting go has full thrust at once",
            proved_as_let_go(deaf),
            (*LIFTED, sinking_noticed(within=14 + deaf)),
            make=kind,
        )
        for name, deaf, kind in (
            ("deaf", 12.0, Board),
            ("sluggish", 0, Sluggish),
            ("twofold", 6.0, Twofold),
        )
    ],
    Scene(
        "sinks-again-and-again",
        "as often as it does",
        again_and_again,
        (
            reached(),
            held_up(),
            home(300, HELD, off=False),
            never_deeper(10),
            sinking_noticed(within=16),
            lives(),
        ),
    ),
    Scene("slope-afloat-start", DRIFTS, starts_over(lambda w: slopes(w, 0.1, 80)), STARTS, SHALLOW),
    Scene(
        "slope-falls-afloat-start",
        DRIFTS,
        starts_over(lambda w: slopes(w, -0.3, 50)),
        STARTS,
        {"floor": 14.0},
    ),
    Scene("garbage-below-start", "a leap is no slope", starts_over(garbage_below), STARTS, SHALLOW),
    *[
        Scene(name, DRIFTS, slope_and_heavy(killed, away), LIFTED, SHALLOW)
        for name, killed, away in (
            ("slope-afloat-heavy", False, False),
            ("slope-afloat-heavy-later", False, True),
            ("slope-afloat-killed-heavy", True, False),
        )
    ],
    *[
        Scene(f"zero-ends-after-{after}-s-heavy", ZERO, zero_ends(after), LIFTED)
        for after in (26, 34, 42)
    ],
    Scene("zero-ends-killed-heavy", ZERO, zero_ends(34, killed=True, wait=7), LIFTED),
    Scene("zero-ends-x-heavy", ZERO, zero_ends(38, "@ZAX0$"), LIFTED),
    Scene(
        "term-drifting-heavy",
        "it waits for the surface as its depth tells it, and leaves its thrust",
        term_drifting,
        (reached(), home(300, 4.0, off=False), never_deeper(22), lives()),
    ),
    Scene(
        "stands-over-a-crash-heavy",
        "a depth proves nothing before it has changed",
        stands_over_a_crash,
        (reached(), home(300, 4.0, off=False), never_deeper(30), lives()),
        world=TRUE_FIXES,
    ),
    *[
        Scene(
            f"surfaced-blind-killed-{after}-s",
            "the fixes that proved the surface end within 60 s",
            surfaced_blind_killed(after),
            (reached(), home(300, 4.0, off=False), never_deeper(28), lives()),
            world=TRUE_FIXES,
        )
        for after in (1, 20)
    ],
    Scene(
        "let-go-without-depth",
        "60 s without M, and no surface: an ascent",
        let_go_without_depth,
        (*(reached(), home(300), upward_within(64), never_deeper(16), lives()),),
        world=TRUE_FIXES,
    ),
    Scene(
        "waits-closed-heavy",
        "nothing turns by itself while AUTO is closed; what sinks is brought up when it is open",
        waits_closed,
        (*LIFTED, quiet("closed", "open"), noted("closed=S"), noted("opened=S"), upward_within(20)),
    ),
    Scene(
        "waits-closed-indoors",
        "nothing turns by itself while AUTO is closed",
        closed_indoors,
        (reached(), noted("closed=S"), quiet("due"), lives()),
    ),
    Scene(
        "stopped-closed-heavy",
        "nothing turns by itself while AUTO is closed; not risen in 20 s, once it is open",
        stopped_closed,
        (*LIFTED, quiet("closed", "due"), noted("closed=S"), noted("opened=S"), upward_within(28)),
    ),
    *[
        Scene(
            f"{name}-tried-{where}",
            "on deck and at the surface a stop and a restart turn no thruster",
            tried_on_deck(end, where == "indoors"),
            (reached(), quiet("due"), lives()),
        )
        for name, end, where in (
            ("term", lambda w: w.pi.systemctl_stop(), "on-deck"),
            ("term", lambda w: w.pi.systemctl_stop(), "indoors"),
            ("killed", lambda w: w.pi.signal(signal.SIGKILL), "on-deck"),
        )
    ],
)
