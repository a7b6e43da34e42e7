"""Scenes of storms: crash after crash, reports that lie about thrusters, lines that garble both ways, boards that
refuse; limits that are tightened under way.
"""

from __future__ import annotations

import math
import random
import signal
from collections.abc import Iterator

from tests.sea import faults
from tests.sea.body import Gears
from tests.sea.faults import Will
from tests.sea.laws import (
    HELD,
    Law,
    held_up,
    home,
    lives,
    never,
    never_deeper,
    noted,
    off_within,
    passed,
    quiet,
    reached,
    upward_within,
    word_within,
)
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, go, mission, order
from tests.sea.stm32 import Board
from tests.sea.world import World
from tests.sea.wrecks import BACK, LIFTED

Steps = Iterator[None]


def crash_loop(world: World) -> Steps:
    """W, 5 N too heavy, and a crash each 12 s for two minutes."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -5.0
    for _ in range(10):
        yield from world.wait(12)
        world.pi.signal(signal.SIGKILL)
    yield from world.wait(130)


def stopped_cut(world: World) -> Steps:
    """X, 5 N too heavy; Pi and board lose their power 5 s later."""
    yield from dive(world)
    boat(world).send("@ZAX0$")
    world.body.buoyancy = -5.0
    yield from world.wait(5)
    world.mark("due")
    world.board.restart()
    world.pi.power_cut()
    yield from world.held(220)


def stick_killed(world: World) -> Steps:
    """A stick holds it down at 6 m; a crash; the stick goes on for half a minute."""
    yield from dive(world, 5)
    world.spawn(boat(world).repeat("@MMD6$", 0.2, until=world.now + 35))
    yield from world.wait(4)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(160)


def term_hopeless(world: World) -> Steps:
    """No report and no fix any more: systemctl stop, and nothing that could prove a surface."""
    yield from dive(world)
    assert world.receiver
    world.receiver.mode = "dead"
    world.board.mute = True
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(280)
    world.mark("last")
    yield from world.wait(30)


def shows(word: str, gears: Gears, buoyancy: float) -> Script:
    """From the hold on every report shows these gears, whatever turns; then the word, and another trim."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.board.shown = gears
        order(world, word)
        world.body.buoyancy = buoyancy
        yield from (world.held(210) if buoyancy < 0 else world.rest(200))

    return script


class Refusing(Board):
    """For a while it answers N to everything, and goes on as it was."""

    no_until = 0.0

    def _automatic(self, now: float, code: str, value: str) -> bool:
        if now < self.no_until:
            self._answer(now, b"@ACK_ZAN$")
            return False
        return super()._automatic(now, code, value)


class Garbled(Board):
    """Of the bytes that come to it one of 40 arrives wrong."""

    def hear(self, now: float, data: bytes) -> None:
        if not hasattr(self, "dice"):
            self.dice = random.Random(self.seed)
        wrong = (byte ^ 0x55 if self.dice.random() < 1 / 40 else byte for byte in data)
        super().hear(now, bytes(wrong))


def refuses(word: str, buoyancy: float) -> Script:
    """For 30 s from the word on the board refuses everything, and holds its depth; then another trim."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.board.no_until = world.now + 30
        order(world, word)
        yield from world.wait(30)
        world.body.buoyancy = buoyancy
        yield from (world.held(200) if buoyancy < 0 else world.rest(200))

    return script


def garbled(noise: float, buoyancy: float) -> Script:
    """From the hold on so many bytes from the board are wrong; W, and another trim."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.line.noise = noise
        yield from world.wait(10)
        order(world, "@ZAWF$")
        world.body.buoyancy = buoyancy
        yield from (world.held(220) if buoyancy < 0 else world.rest(200))

    return script


def tightened(limits: str) -> Script:
    """Today's limits are told anew under way, tighter."""

    def script(world: World) -> Steps:
        yield from dive(world)
        letter = yield from boat(world).ask(limits, "SP")
        world.notes.append(f"limits={letter}")
        yield from world.until(lambda: world.now > world.marks["go"] + 60, 60)
        world.mark("due")
        yield from world.rest(200)

    return script


def no_heading(world: World) -> Steps:
    """The compass is silent from the dive on; the mission has a minute to go."""
    yield from dive(world, stay="60s")
    world.board.senses.heading = lambda _now, _truth: math.nan
    yield from world.wait(70)
    world.mark("due")
    yield from world.rest(200)


def no_depth_on_deck(world: World) -> Steps:
    """The depth is silent on deck; somebody uploads and starts."""
    world.board.senses.depth = lambda _now, _truth: math.nan
    yield from go(world, mission(8, 10))
    world.mark("due")
    yield from world.wait(40)


def possessed_heavy_killed(world: World) -> Steps:
    """X, 4 N too heavy, a board that dives by itself until U12, and a crash: all within 6 s."""
    yield from dive(world)
    order(world, "@ZAX0$")
    world.body.buoyancy = -4.0
    world.board.will = Will(obeys=frozenset("U"), times=2, again=60)
    yield from world.wait(6)
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(200)


def all_at_once(world: World) -> Steps:
    """W; a clogged port, a slider of 200 Hz, a stick by another, gaps, 4 N too heavy, and systemctl stop."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -4.0
    other = world.operator("other")
    world.spawn(boat(world).repeat(lambda n: f"@DS1,{n % 20}$", 1 / 200))
    world.spawn(other.repeat("@MMD8$", 0.3))
    yield from world.wait(3)
    world.board.senses.depth = faults.clogged(8.0, world.seed)
    yield from world.wait(10)
    world.board.senses.depth = faults.honest
    world.pi.systemctl_stop()
    yield from world.held(230)


STUCK = Gears(left=6.0, up=(-4.0, -4.0, -4.0))
CERTAIN: tuple[Law, ...] = (reached(), noted("limits=P"), home(150), never_deeper(16), lives())
SCENES: tuple[Scene, ...] = (
    Scene("crash-loop-heavy", "each start goes on with the ascent", crash_loop, LIFTED),
    Scene(
        "stopped-power-heavy",
        "a restart comes back in stopped; it has not risen in 20 s",
        stopped_cut,
        (*LIFTED, upward_within(32)),
    ),
    Scene(
        "stick-killed",
        "each start surfaces, and the stick was never still",
        stick_killed,
        (
            *LIGHT,
            upward_within(12),
            never("^@M", "due", "the emergency is older than its stillness"),
        ),
    ),
    Scene(
        "term-hopeless",
        "shortly before it is killed: X0 and U12",
        term_hopeless,
        (
            *(reached(), home(200, off=False), never_deeper(16), lives()),
            *(word_within(r"@ZAX0\$", 20, "last"), word_within(r"@ZAU12\$", 20, "last")),
        ),
    ),
    Scene("shows-nothing", "no brown-out in an ascent", shows("@ZAWF$", Gears(), 8.0), LIGHT),
    Scene("shows-nothing-heavy", "the depth tells", shows("@ZAWF$", Gears(), -5.0), LIFTED),
    Scene("shows-a-push-x", "X again and again, and it rises", shows("@ZAX0$", STUCK, 8.0), LIGHT),
    Scene(
        "shows-a-push-heavy-x",
        "it has not risen in 20 s",
        shows("@ZAX0$", STUCK, -5.0),
        (*LIFTED, upward_within(28)),
    ),
    Scene("shows-a-push-heavy-w", "the depth tells", shows("@ZAWF$", STUCK, -5.0), LIFTED),
    Scene(
        "refuses-w", "what was refused comes round", refuses("@ZAWF$", 8.0), LIGHT, make=Refusing
    ),
    Scene(
        "refuses-heavy-x",
        "X until it is acknowledged; then an ascent",
        refuses("@ZAX0$", -4.0),
        (*LIFTED, upward_within(28)),
        make=Refusing,
    ),
    Scene("very-noisy-line-heavy", "one report of two is whole", garbled(1 / 100, -5.0), LIFTED),
    Scene(
        "garbled-words-heavy",
        "what was not answered is said again",
        garbled(0.0, -5.0),
        (reached(), home(300, HELD, off=False), held_up(), never_deeper(26), lives()),
        make=Garbled,
    ),
    Scene(
        "minutes-tightened",
        "in force at once",
        tightened("@SP,900,1,10,10,$"),
        (*CERTAIN, upward_within(4)),
    ),
    Scene(
        "metres-tightened",
        "in force at once",
        tightened("@SP,900,40,5,10,$"),
        (*CERTAIN, upward_within(8, "down")),
    ),
    Scene("no-heading", "the ascent needs none", no_heading, BACK),
    Scene(
        "no-depth-on-deck",
        "no start without a depth to believe",
        no_depth_on_deck,
        (reached(), noted("start=N"), quiet("due"), off_within(0)),
    ),
    Scene(
        "dives-after-x-heavy-killed",
        "U12 is a way of the ascent, before and after a crash",
        possessed_heavy_killed,
        (reached(), home(280, HELD, off=False), held_up(), never_deeper(30), lives()),
    ),
    Scene(
        "all-at-once",
        "one thing at a time",
        all_at_once,
        (
            *(reached(), home(300, HELD, off=False), held_up(), never_deeper(26), lives()),
            *(passed(), never("^@M", "due", "an emergency is under way")),
        ),
    ),
)
