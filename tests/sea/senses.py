"""Scenes of what is believed: depths, attitude, fixes; and what the surface is needed for."""

from __future__ import annotations

from collections.abc import Iterator

from tests.sea import faults
from tests.sea.laws import (
    held_up,
    home,
    never,
    never_deeper,
    noted,
    reached,
    upward_within,
)
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, go, mission, order, own_vehicle
from tests.sea.world import World

Steps = Iterator[None]


def clogs_at(told: float) -> Script:
    """Asked for 8 m; at this depth the port closes, with what is in it."""

    def script(world: World) -> Steps:
        yield from go(world, mission(8, 10))
        yield from world.until(lambda: world.body.depth > told, 120)
        world.board.senses.depth = faults.clogged(told, world.seed)
        yield from world.wait(25)
        world.mark("due")
        yield from world.rest(230)

    return script


def drifts(world: World) -> Steps:
    """At 8 m, held without way: the reading leaves the truth by 5 cm a second, the board follows it.

    Without way, for ahead of a vehicle that moves the floor itself may rise.
    """
    yield from go(world, mission(8, 10).replace("stay: gear 4", "stay: stop"))
    yield from world.until(lambda: world.body.depth > 7.8, 120)
    yield from world.wait(15)
    world.board.senses.depth = faults.drifting(world.now, -0.05)
    yield from world.until(lambda: world.body.depth > 14.5, 160)
    world.mark("due")
    yield from world.rest(200)


def jumps(world: World) -> Steps:
    """At 8 m, held: from one report to the next the reading is 6 m less."""
    yield from dive(world)
    world.board.senses.depth = faults.shifted(-6.0)
    yield from world.wait(20)
    world.mark("due")
    yield from world.rest(200)


def offset_on_deck(world: World) -> Steps:
    """The sensor says 3 m on deck; a start, and a W."""
    world.board.senses.depth = faults.shifted(3.0)
    yield from go(world, mission(8, 10))
    yield from world.wait(10)
    boat(world).send("@ZAWF$")
    yield from world.wait(150)
    world.mark("due")
    yield from world.wait(60)


def turns_over(world: World) -> Steps:
    """The ballast slides: upside down for ever."""
    yield from dive(world)
    world.body.turn_over()
    world.mark("due")
    yield from world.rest(230)


def lying_receiver(world: World) -> Steps:
    """W at depth, while the receiver tells of places."""
    yield from dive(world)
    order(world, "@ZAWF$")
    yield from world.rest(150)


def clear_under_water(world: World) -> Steps:
    """X with a neutral body, and an operator who clears and starts at 8 m."""
    yield from dive(world)
    world.body.buoyancy = 0.2
    order(world, "@ZAX0$")
    yield from world.wait(2)
    for wait in (9.0, 0.5):
        letter = yield from boat(world).ask("@AC$", "AC")
        world.notes.append(f"clear={letter}")
        yield from world.wait(wait)
    letter = yield from boat(world).ask("@AA$", "AA")
    world.notes.append(f"again={letter}")
    yield from world.wait(250)


def own_voltage(world: World) -> Steps:
    """A vehicle whose batteries are measured, with a limit of 22 V."""
    world.board.senses.control = lambda _now, _truth: 25.0
    yield from own_vehicle(
        world,
        **{
            "constant_batteries: true": "constant_batteries: false",
            "voltage: 10 V": "voltage: 22 V",
        },
    )


def flickering_voltage(world: World) -> Steps:
    """The control battery swings about its limit of 22 V, most of the time below it."""
    yield from own_voltage(world)
    yield from dive(world)
    world.board.senses.control = faults.flicker(20.4, 1.3, world.seed)
    yield from world.wait(1)
    world.mark("due")
    yield from world.rest(200)


BACK = (reached(), home(200), never_deeper(16))
SCENES: tuple[Scene, ...] = (
    Scene(
        "clogged-3m-short",
        "full push for 20 s moves no depth: not believed; X0 and U12",
        clogs_at(5.0),
        BACK,
    ),
    Scene("clogged-1m-short", "the same", clogs_at(7.0), BACK, quick=True),
    Scene(
        "drift",
        "the altimeter closes on the floor while the depth stands",
        drifts,
        BACK,
        body={"floor": 25.0},
    ),
    Scene("jump", "no body rises 6 m in 2 s", jumps, BACK),
    Scene(
        "offset-on-deck",
        "fixes behave as at the surface and pushing up moves nothing",
        offset_on_deck,
        (reached(), home(1), never_deeper(3)),
    ),
    Scene(
        "upside-down",
        "letting go lifts it, and so does D12",
        turns_over,
        (reached(), home(220), never_deeper(16)),
    ),
    Scene(
        "upside-down-aerospace",
        "the same, told as a roll of 180",
        turns_over,
        (reached(), home(220), never_deeper(16)),
        board={"turned": False},
    ),
    *[
        Scene(
            f"fixes-{mode}",
            "a believed depth contradicts a fix",
            lying_receiver,
            LIGHT,
            world={"receiver_mode": mode},
        )
        for mode in ("stuck", "alternating", "cycling", "wandering")
    ],
    Scene(
        "clear-under-water",
        "N under water; not risen in 20 s: an ascent",
        clear_under_water,
        (
            reached(),
            home(250),
            held_up(),
            noted("clear=N"),
            noted("again=N"),
            never("@ZA[SHFD]", "due", "no mission"),
        ),
    ),
    Scene(
        "flickering-voltage",
        "most of a window is below the limit",
        flickering_voltage,
        (reached(), home(220), upward_within(60)),
        board={"built": False},
    ),
)
