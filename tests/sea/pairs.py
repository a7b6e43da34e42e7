"""Scenes of pairs that met nowhere else: lines and boards with habits, and with them operators, sensors, trims,
ends and crashes. What one trouble does alone is asked by the siblings; no scene here asks it again, and none
asks for what the body could not do with a right word at a right time.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator
from typing import Any

from tests.sea import faults
from tests.sea.ascents import SETS, STAIRS
from tests.sea.boards import CORE, FAINT, FLOAT, ROBOT, ROV, TETHER, TUNED, under_way
from tests.sea.faults import Will
from tests.sea.habits import Echoing, Splicing, Unheard
from tests.sea.laws import (
    HELD,
    Law,
    held_up,
    home,
    legs,
    lives,
    never_deeper,
    noted,
    off_within,
    reached,
    sinking_noticed,
)
from tests.sea.mixtures import LAND
from tests.sea.nuisances import Sluggish, gaps
from tests.sea.others import CoreBoard, Robot, Rov
from tests.sea.scene import Scene, Script, boat, dive, go, mission, order
from tests.sea.stm32 import Board
from tests.sea.world import World
from tests.sea.wrecks import LIFTED

Steps = Iterator[None]


class Tardy(Board):
    """Its acknowledgements come so many seconds late: by then another word may be waiting for one."""

    behind = 0.9

    def _answer(self, now: float, data: bytes) -> None:
        super()._answer(now, data)
        self.acks[-1] = (self.acks[-1][0] + self.behind, data)


class Dull(Sluggish):
    """Hears nothing for longer than three tries last."""

    behind = 0.8


class Twofold(Sluggish):
    """Deaf for 0.5 s behind each word, and each acknowledgement comes twice, 0.15 s apart."""

    def _answer(self, now: float, data: bytes) -> None:
        super()._answer(now, data)
        self.acks.append((self.acks[-1][0] + 0.15, data))


def slides(world: World, rate: float = 200.0, name: str = "") -> None:
    """A rudder slider moves all the time; `name`: on a connection of its own."""
    who = world.operator(name) if name else boat(world)
    world.spawn(who.repeat(lambda n: f"@DS{1 + n % 2},{n % 20}$", 1 / rate))


def relays(world: World) -> None:
    """Power is answered by the board, and steps of a rudder are never replaced."""
    words = ("@RI$", "@DA1,1$", "@RSOOOOOOO$", "@DS2,5$")
    world.spawn(boat(world).repeat(lambda n: words[n % len(words)], 1 / 50))


def flaps(world: World) -> Steps:
    """The board's port goes and comes back as another device, over and over."""
    while True:
        world.line.vanish()
        yield from world.wait(4)
        world.line.come_back()
        yield from world.wait(7)


def clogs(world: World) -> Steps:
    """On the way up the port closes with 4 m in it, for half a minute."""
    yield from world.until(lambda: world.body.depth < 4.0, 60)
    world.board.senses.depth = faults.clogged(4.0, world.seed)
    yield from world.wait(30)
    world.board.senses.depth = faults.honest


def told(lie: faults.Lie) -> Callable[[World], Any]:
    """The depth is told so."""
    return lambda world: setattr(world.board.senses, "depth", lie)


def cut(world: World) -> None:
    """Pi and board lose their power."""
    if isinstance(world.board, Board):
        world.board.restart()
    world.pi.power_cut()


TROUBLES: dict[str, Callable[[World], Any]] = {
    "sliders": lambda world: (slides(world), slides(world, 200, "other")),
    "relays": relays,
    "stick": lambda world: world.spawn(world.operator("stick").repeat("@MMD8$", 0.05)),
    "late": lambda world: told(faults.slow(5.0))(world),
    "gaps": lambda world: world.spawn(gaps(world)),
    "flaps": lambda world: world.spawn(flaps(world)),
    "clogs": lambda world: world.spawn(clogs(world)),
    "over": lambda world: world.body.turn_over(),
    "possessed": lambda world: setattr(
        world.board, "will", Will(obeys=frozenset("U"), times=3, again=40)
    ),
    "lag": lambda world: setattr(world.board, "lag", 3.0),
    "unheard": lambda world: setattr(world.board, "lost_until", world.now + 60),
    "yes": lambda world: setattr(world.board, "yes_until", world.now + 25),
    "noise": lambda world: setattr(world.line, "noise", 1 / 150),
    "again": lambda world: world.spawn(world.operator("again").repeat("@ZAWF$", 0.5)),
    "noisy": lambda world: (
        setattr(world.board.senses, "depth_noise", 0.4),
        setattr(world.board, "period", 4.0),
    ),
    "drifts": lambda world: told(faults.drifting(world.now, -0.1))(world),
    "full": lambda world: world.pi.fill_disk(),
}
ENDS: dict[str, Callable[[World], Any]] = {  # 5 s behind the word
    "killed": lambda world: world.pi.signal(signal.SIGKILL),
    "cut": cut,
    "term": lambda world: world.pi.systemctl_stop(),
}


def meets(kind: type, letter: str, trim: float, troubles: str, text: str = "") -> Script:
    """From X or W on the board is of this kind, with another trim and these troubles."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "6min") if text else dive(world)
        world.board.__class__ = kind
        for name in troubles.split():
            TROUBLES.get(name, lambda _: None)(world)
        other = world.operator("word")
        yield from world.wait(0.4)
        other.send({"W": "@ZAWF$", "X": "@ZAX0$"}[letter])
        world.mark("due")
        world.body.buoyancy = trim
        yield from world.wait(5)
        for name in troubles.split():
            ENDS.get(name, lambda _: None)(world)
        if text and "term" in troubles:  # it goes neutral by itself when serve has ended
            yield from world.until(lambda: not world.pi.running(), 300)
            return
        yield from (world.held(270) if trim < 0 else world.rest(290, 45))

    return script


def tardy_legs(world: World) -> Steps:
    """A mission of many legs, 0.2 s behind with each answer; sliders of two boats."""
    world.board.behind = 0.2
    yield from go(world, STAIRS)
    slides(world, 100)
    slides(world, 100, "other")
    yield from world.wait(75)
    world.mark("due")
    yield from world.rest(110)


def clogged_and_tumbling(world: World) -> Steps:
    """On the way to 8 m the port closes at 6.5 m, and roll and pitch are garbage."""
    yield from go(world, mission(8, 10))
    yield from world.until(lambda: world.body.depth > 6.5, 120)
    told(faults.clogged(6.5, world.seed))(world)
    world.board.senses.roll = faults.garbage(world.seed, 1e9)
    world.board.senses.pitch = faults.garbage(world.seed + 1, 1e9)
    yield from world.wait(30)
    world.mark("due")
    yield from world.rest(380)


def blind_heavy_later(world: World) -> Steps:
    """Home without a depth, by fixes; 26 s after it was let go water comes in, and a slider moves."""

    yield from dive(world)
    told(lambda _now, _truth: math.nan)(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(10)
    yield from world.rest(250, 26)  # no way lasts as long as that without a thruster
    world.mark("due")
    slides(world, 60)
    world.body.buoyancy = -5.0
    yield from world.wait(200)


def taken_and_deaf(world: World) -> Steps:
    """The stick has taken an ascent over; it is let go, the board is deaf for 6 s, 4 N are too much."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(4)
    world.spawn(boat(world).repeat("@MMF5$", 0.2, until=world.now + 3))
    yield from world.wait(3)
    boat(world).close()
    world.board.deaf_until = world.now + 6
    world.body.buoyancy = -4.0
    world.mark("due")
    yield from world.held(250)


def closed_killed_opened(world: World) -> Steps:
    """AUTO is closed at depth, 3 N too heavy; a crash; AUTO is opened again after it."""
    yield from dive(world)
    letter = yield from boat(world).ask("@NSOOOCCC$", "NS", 8)
    world.notes.append(f"closed={letter}")
    world.body.buoyancy = -3.0
    yield from world.wait(3)
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(14)
    letter = yield from boat(world).ask("@NSOOOCCO$", "NS", 8)
    world.notes.append(f"opened={letter}")
    world.mark("due")
    yield from world.held(250)


def idle_heavy(world: World) -> Steps:
    """At rest behind a short mission: water comes in, under sliders, on a board that hears badly."""
    yield from dive(world, stay="5s")
    yield from world.wait(75)
    world.board.__class__ = Sluggish
    world.notes.append(f"afloat={world.body.depth < 0.5 and not world.board.gears.turning()}")
    world.body.buoyancy = -5.0
    world.mark("due")
    TROUBLES["sliders"](world)
    yield from world.held(250)


def pours_in_mission(world: World) -> Steps:
    """A text of 9,999 lines pours in while the mission runs, reports are broken, 14 N too heavy."""
    yield from dive(world)
    world.line.noise = 1 / 800
    total = (9999).to_bytes(2, "little")

    def pours() -> Steps:
        for count in range(20000):
            number = (1 + count % 9999).to_bytes(2, "little")
            boat(world).send(b"@AW" + total + number + b"stay: gear 4 for 9s$")
            if count % 5 == 0:
                yield from world.wait(0.01)

    world.spawn(pours())
    world.body.buoyancy = -14.0  # its holds push down alone: it sinks to the limit
    yield from world.until(lambda: world.body.depth > 10.4, 90)
    world.mark("due")
    yield from world.held(200)


def robot_replugged(world: World) -> Steps:
    """The robot drives; its port is away for 3 s, with a stop in between, under a slider."""
    yield from go(world, ROBOT.replace("20s", "60s"))
    yield from world.wait(8)
    slides(world, 50)
    world.line.vanish()
    yield from world.wait(1)
    order(world, "@ZAX0$")
    yield from world.wait(2)
    world.line.come_back()
    yield from world.wait(20)


OVER: tuple[Law, ...] = (reached(), home(320), never_deeper(18), lives())  # let go it rises
FLOATS: tuple[Law, ...] = (reached(), home(300, off=False), never_deeper(24), lives())
OTHERS: tuple[Law, ...] = (reached(), home(300, HELD, off=False), never_deeper(22), lives())
DEEPER: tuple[Law, ...] = (*OTHERS[:2], held_up(), never_deeper(28), lives())
BLIND: tuple[Law, ...] = (reached(), home(300, 4.0, off=False), never_deeper(28), lives())
AGAIN = "what was not answered is said again"
TURNS = "each way has its turn, and the depth tells"
HALVES = (
    "no answer proves a word: what does not lift it is said again, U12 alone where X0 was heard"
)
RISEN = "not risen in 20 s: an ascent"
MEET: tuple[tuple[str, str, type, str, float, str, tuple[Law, ...]], ...] = (
    ("tardy-sliders-heavy-w", TURNS, Tardy, "W", -5.0, "sliders", LIFTED),
    ("unheard-clogged-heavy", TURNS, Unheard, "W", -4.0, "unheard clogs", LIFTED),
    ("unheard-cut-heavy-x", RISEN, Unheard, "X", -4.0, "unheard cut", DEEPER),
    ("sluggish-relays-heavy", AGAIN, Sluggish, "W", -4.0, "relays stick", LIFTED),
    ("sluggish-killed-heavy-x", RISEN, Sluggish, "X", -4.0, "sliders killed", DEEPER),
    ("sluggish-late-heavy", TURNS, Sluggish, "W", -4.0, "late", DEEPER),
    ("sluggish-possessed-gappy", TURNS, Sluggish, "W", 8.0, "possessed gaps", FLOATS),
    ("sluggish-over-sliders", TURNS, Sluggish, "W", 8.0, "over sliders", OVER),
    ("sluggish-term-sliders-heavy", AGAIN, Sluggish, "W", -4.0, "sliders term", LIFTED),
    ("sluggish-lag-sliders-heavy", TURNS, Sluggish, "W", -4.0, "lag sliders", DEEPER),
    ("dull-heavy-w", HALVES, Dull, "W", -3.0, "relays", DEEPER),
    ("dull-possessed", HALVES, Dull, "W", 8.0, "possessed", FLOATS),
    ("sluggish-w-again-heavy", HALVES, Sluggish, "W", -3.0, "again", DEEPER),
    ("twofold-heavy-w", HALVES, Twofold, "W", -3.0, "", DEEPER),
    ("noisy-half-rate-heavy-w", TURNS, Board, "W", -5.0, "noisy sliders", DEEPER),
    ("drifting-heavy-w", TURNS, Board, "W", -4.0, "drifts stick", BLIND),
    ("echo-possessed-killed", TURNS, Echoing, "W", 8.0, "possessed killed", FLOATS),
    ("spliced-late-gappy-heavy", TURNS, Splicing, "W", -4.0, "late gaps", BLIND),  # it leaps
    ("over-late-killed", "let go it rises", Board, "W", 8.0, "over late killed", OVER),
    ("yes-man-term-sliders-heavy", AGAIN, Board, "X", -4.0, "yes sliders term", DEEPER),
    ("full-flapping-heavy-w", AGAIN, Board, "W", -4.0, "full flaps killed", DEEPER),
    ("flapping-stick-x", "X, and X again", Board, "X", 8.0, "flaps stick", (*DEEPER, home(150))),
)
BESIDE: tuple[tuple[str, str, type, float, str], ...] = (
    ("core-flapping-heavy", "a stick takes nothing over", CoreBoard, -3.0, "flaps stick"),
    ("core-noisy-late-cut-heavy", "each start surfaces", CoreBoard, -3.0, "noise late cut"),
    ("core-gappy-term-stick-heavy", "it waits for the surface", CoreBoard, -3.0, "gaps term stick"),
    ("rov-noisy-stick-heavy", "a stick takes nothing over", Rov, -2.0, "noise stick"),
)
SCENES: tuple[Scene, ...] = (
    *[
        Scene(name, why, meets(kind, letter, trim, troubles), laws)
        for name, why, kind, letter, trim, troubles, laws in MEET
    ],
    *[
        Scene(
            name,
            why,
            meets(kind, "W", trim, troubles, CORE if kind is CoreBoard else ROV),
            OTHERS,
            FLOAT if kind is CoreBoard else FAINT,
            world=TUNED if kind is CoreBoard else TETHER,
            make=kind,
        )
        for name, why, kind, trim, troubles in BESIDE
    ],
    Scene(
        "sluggish-over-documented",
        "let go it rises",
        meets(Sluggish, "W", 8.0, "over relays killed"),
        OVER,
        board={"built": False},
    ),
    Scene(
        "tardy-legs-sliders",
        "the set has rank over relays",
        tardy_legs,
        (reached(), home(150), legs(*SETS), lives()),
        make=Tardy,
    ),
    Scene(
        "clogged-tumbling",
        "letting go lasts longer and longer, and it floats",
        clogged_and_tumbling,
        OVER,
    ),
    Scene(
        "blind-heavy-later",
        "the fixes that proved the surface end within 60 s",
        blind_heavy_later,
        BLIND,
    ),
    Scene(
        "taken-over-deaf-heavy",
        "what sinks in waiting is brought up",
        taken_and_deaf,
        (*LIFTED, sinking_noticed(within=16)),
    ),
    Scene(
        "auto-closed-killed-heavy",
        "what sinks is brought up, once AUTO is open",
        closed_killed_opened,
        (*DEEPER, noted("closed=S"), noted("opened=S")),
    ),
    Scene(
        "idle-sluggish-sliders-heavy",
        "two reports of sinking begin an ascent",
        idle_heavy,
        (*LIFTED, noted("afloat=True"), sinking_noticed(within=12)),
    ),
    Scene("pours-in-mission-heavy", "no text holds up a limit", pours_in_mission, DEEPER),
    Scene(
        "robot-replugged-x",
        "a stop that has not left leaves with the port",
        robot_replugged,
        (reached(), off_within(2.5), lives()),
        world=LAND,
        make=Robot,
    ),
)
