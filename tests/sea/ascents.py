"""Scenes of ascents: boards with a will of their own, trim, sliders, orderly and broken ends."""

from __future__ import annotations

import signal
import socket
from collections.abc import Iterator

from tests.sea.faults import Will
from tests.sea.laws import (
    HELD,
    Law,
    held_up,
    home,
    legs,
    lives,
    never,
    never_deeper,
    passed,
    quiet,
    reached,
    sinking_noticed,
    upward_within,
)
from tests.sea.scene import LIGHT, RUINS, Scene, Script, boat, dive, go, order, own_vehicle, ruin
from tests.sea.world import World

Steps = Iterator[None]
HEAVY: tuple[Law, ...] = (
    reached(),
    home(300, HELD, off=False),
    held_up(),
    passed(),
    lives(),
)


def calm(world: World) -> Steps:
    """The mission as it is."""
    yield from dive(world, stay="40s")
    yield from world.wait(45)
    world.mark("due")
    yield from world.rest(110)


def stop_and_up(world: World) -> Steps:
    """X at depth, and nothing more."""
    yield from dive(world)
    order(world, "@ZAX0$")
    yield from world.rest(80)


def possessed(word: str, obeys: str, again: float | None = None, seconds: float = 200) -> Script:
    """The board dives by itself from the moment of this word on, and obeys only some."""

    def script(world: World) -> Steps:
        yield from dive(world)
        order(world, word)
        yield from world.wait(0.5)
        world.board.will = Will(obeys=frozenset(obeys), again=again, times=3)
        yield from world.wait(seconds)

    return script


def idle_dives(world: World) -> Steps:
    """On deck of the sea, no mission: it dives by itself, three times."""
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    world.board.will = Will(obeys=frozenset("U"), again=50, times=3)
    yield from world.wait(420)


def heavy_after(word: str) -> Script:
    """Water comes in with this word: 6 N too heavy from then on."""

    def script(world: World) -> Steps:
        yield from dive(world)
        order(world, word)
        world.body.buoyancy = -6.0
        yield from world.wait(300)

    return script


def heavy_idle(world: World) -> Steps:
    """Water comes in at the surface, with no mission."""
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    world.body.buoyancy = -6.0
    yield from world.wait(300)


def slider(rate: float, word: str) -> Script:
    """The commander's rudder slider moves all the time; then the word."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.spawn(boat(world).repeat(lambda n: f"@DS{1 + n % 2},{n % 20}$", 1 / rate))
        yield from world.wait(5)
        order(world, word)
        yield from world.rest(150)

    return script


STAIRS = """
    mission stairs vehicle auv
    home 30.2874595 120.1535765
    safety radius 900 time 40min depth 12
    one: depth 4 heading 90 gear 4 for 20s
    two: gear 5 for 15s
    three: gear 6 heading 180 for 15s
    four: depth 5 for 15s
    up: surface timeout 5min
"""
SETS = (
    (r"@ZAH-90,4", 5.0),
    (r"@ZAH-90,5", 25.0),
    (r"@ZAH-?180,6", 20.0),
    (r"@ZAS5", 20.0),
    (r"@ZA(WF|U)", 20.0),
)


def slider_legs(world: World) -> Steps:
    """A mission of many legs under a slider of 60 Hz."""
    yield from go(world, STAIRS)
    world.spawn(boat(world).repeat(lambda n: f"@DS1,{n % 20}$", 1 / 60))
    yield from world.wait(75)
    world.mark("due")
    yield from world.rest(110)


def term_after_w(world: World) -> Steps:
    """W, and a second later systemctl stop."""
    yield from dive(world)
    order(world, "@ZAWF$")
    yield from world.wait(1)
    world.pi.systemctl_stop()
    yield from world.rest(200)


def term_in_mission(world: World) -> Steps:
    """systemctl stop at depth."""
    yield from dive(world)
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.rest(200)


def term_on_deck(world: World) -> Steps:
    """systemctl stop and start where somebody has his hands on the vehicle."""
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(30)
    world.pi.wanted = True
    world.pi.start()
    yield from world.wait(60)


def killed(world: World) -> Steps:
    """A crash at depth, with everything in order at the next start."""
    yield from dive(world)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    yield from world.rest(200)


def broken(what: str) -> Script:
    """A crash at depth; what the next start finds is broken."""

    def script(world: World) -> Steps:
        yield from own_vehicle(world)
        yield from dive(world)
        world.mark("due")
        world.pi.signal(signal.SIGKILL)
        ruin(world, what)
        yield from world.rest(200)

    return script


def without(module: str) -> Script:
    """A crash at depth; at the next start this module cannot be imported."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.mark("due")
        world.pi.signal(signal.SIGKILL)
        world.pi.without = module
        yield from world.rest(200)

    return script


def port_taken(world: World) -> Steps:
    """A crash at depth; at the next start somebody else listens on the operators' port."""
    yield from dive(world)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    with socket.socket() as thief:
        thief.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        thief.bind(("127.0.0.1", world.port))
        thief.listen()
        yield from world.rest(200)


RISES = (*LIGHT, upward_within(12))
SCENES: tuple[Scene, ...] = (
    Scene("calm", "nothing is wrong", calm, (*LIGHT, legs((r"@ZAS8", 5))), quick=True),
    Scene(
        "calm-carried",
        "nothing is wrong; H without its speed would stop the mains",
        calm,
        LIGHT,
        board={"carried": True},
    ),
    Scene("calm-documented", "nothing is wrong", calm, LIGHT, board={"built": False}),
    Scene(
        "stop",
        "the body floats: X lets it rise",
        stop_and_up,
        (*LIGHT, never("@ZA[UW]", "due", "it rises by itself")),
    ),
    Scene(
        "dives-after-w",
        "the board obeys U12, a way of the ascent",
        possessed("@ZAWF$", "U", seconds=120),
        (*LIGHT, upward_within(1)),
        quick=True,
    ),
    Scene("dives-after-w-x", "it obeys X0, a part of two ways", possessed("@ZAWF$", "X"), LIGHT),
    Scene(
        "dives-after-w-w",
        "it obeys W when it comes again",
        possessed("@ZAWF$", "W"),
        (reached(), home(200), held_up(), passed()),
    ),
    Scene(
        "dives-after-x",
        "it has not risen in 20 s: an ascent, whose U12 the board obeys",
        possessed("@ZAX0$", "U", seconds=150),
        (reached(), home(200), held_up(), never_deeper(25), upward_within(28), passed()),
        quick=True,
    ),
    Scene(
        "dives-after-x-again",
        "each time it comes back U12 ends it",
        possessed("@ZAX0$", "U", again=45, seconds=420),
        (reached(), home(200, off=False), held_up(), sinking_noticed(within=30), passed()),
    ),
    Scene(
        "dives-idle",
        "two reports of sinking begin an ascent, each time",
        idle_dives,
        (reached(), home(0.5, off=False), sinking_noticed(), held_up(), never_deeper(16)),
    ),
    Scene(
        "heavy-after-x",
        "25 N of thrust lift 6 N of weight",
        heavy_after("@ZAX0$"),
        (*HEAVY, upward_within(28), never_deeper(22)),
    ),
    Scene(
        "heavy-after-w",
        "25 N of thrust lift 6 N of weight, and hold it",
        heavy_after("@ZAWF$"),
        (*HEAVY, never_deeper(16)),
    ),
    Scene(
        "heavy-idle",
        "it is held where it sinks again",
        heavy_idle,
        (reached(), home(300, HELD, off=False), sinking_noticed(), never_deeper(10)),
    ),
    Scene(
        "slider-w",
        "W, X0 and U12 have rank over a slider",
        slider(60, "@ZAWF$"),
        (*LIGHT, upward_within(1)),
    ),
    Scene("slider-w-200", "the same at 200 a second", slider(200, "@ZAWF$"), LIGHT),
    Scene("slider-x", "X has rank over a slider", slider(60, "@ZAX0$"), LIGHT),
    Scene(
        "slider-legs",
        "the set has rank over relays",
        slider_legs,
        (reached(), home(150), legs(*SETS)),
    ),
    Scene("term-after-w", "serve goes on surfacing, then X0", term_after_w, LIGHT, quick=True),
    Scene(
        "term-in-mission", "serve surfaces, then X0", term_in_mission, (*LIGHT, upward_within(5))
    ),
    Scene("term-on-deck", "it is on deck", term_on_deck, (reached(), quiet("due"), home(1))),
    Scene("killed", "the next start surfaces", killed, RISES),
    *[
        Scene(
            f"killed-{name.replace(' ', '-')}",
            "the last configuration that worked serves the ascent",
            broken(name),
            RISES,
        )
        for name in RUINS
    ],
    *[
        Scene(
            f"killed-no-{module}",
            "a feature may be missing, not the ascent",
            without(module),
            RISES,
        )
        for module in ("mcap", "pynmea2", "filterpy", "matplotlib")
    ],
    Scene("killed-port-taken", "the ascent needs no port for operators", port_taken, RISES),
)
