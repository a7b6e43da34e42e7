"""Scenes of the Pi and the board in trouble, several troubles at a time: power, disks, ports, lines."""

from __future__ import annotations

import signal
from collections.abc import Iterator

from tests.sea.ascents import RISES
from tests.sea.faults import Will
from tests.sea.laws import (
    HELD,
    UPWARD,
    Law,
    held_up,
    home,
    lives,
    never,
    never_deeper,
    quiet,
    reached,
    sinking_noticed,
    upward_within,
    word_within,
)
from tests.sea.scene import LIGHT, Scene, Script, dive, order, own_vehicle
from tests.sea.world import World

Steps = Iterator[None]
BACK: tuple[Law, ...] = (reached(), home(230), never_deeper(16), lives())
LIFTED: tuple[Law, ...] = (
    reached(),
    home(300, HELD, off=False),
    held_up(),
    never_deeper(22),
    lives(),
)


def possessed_term_full(world: World) -> Steps:
    """W, a full disk, a board that dives by itself, and systemctl stop: all within 2 s."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.pi.fill_disk()
    yield from world.wait(1)
    world.board.will = Will(obeys=frozenset("U"))
    yield from world.wait(1)
    world.pi.systemctl_stop()
    yield from world.rest(200)


def killed_full(world: World) -> Steps:
    """The disk is full, and stays so over a crash at depth."""
    yield from dive(world)
    world.pi.fill_disk()
    yield from world.wait(15)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    yield from world.rest(150)


def power_twice(world: World) -> Steps:
    """Pi and board lose their power twice within a minute; 3 N too heavy from then on."""
    yield from dive(world)
    world.mark("due")
    world.body.buoyancy = -3.0
    for pause in (25.0, 260.0):
        world.board.restart()
        world.pi.power_cut()
        yield from world.wait(pause)


def power_on_deck(world: World) -> Steps:
    """The same in somebody's hands, with no mission."""
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    for pause in (20.0, 60.0):
        world.board.restart()
        world.pi.power_cut()
        yield from world.wait(pause)


def clock_jumps(world: World) -> Steps:
    """The Pi believes in 1970, is set right at depth, and put back by an hour."""
    world.clock.set_wall(-1.79e9)
    yield from dive(world, stay="60s")
    world.mark("jump")
    world.clock.set_wall(0.0)
    yield from world.wait(15)
    world.clock.set_wall(-3600.0)
    yield from world.wait(30)
    world.mark("calm")
    yield from world.wait(20)
    world.mark("due")
    yield from world.rest(120)


def cut_in_1970(world: World) -> Steps:
    """A power cut at depth: the clock of the Pi has no battery, and begins in 1970."""
    yield from dive(world)
    world.mark("due")
    world.clock.set_wall(-1.79e9)
    world.pi.power_cut()
    yield from world.rest(150)


def killed_in_ascent(world: World) -> Steps:
    """W, water inside, and two crashes: on the way up, and where it is held up."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -6.0
    yield from world.wait(6)
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(90)
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(150)


def held_up_term(world: World) -> Steps:
    """Too heavy, held up at the surface by thrust; then systemctl stop."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -6.0
    yield from world.wait(150)
    world.mark("stop")
    world.pi.systemctl_stop()
    yield from world.wait(120)


def heavy_term(world: World) -> Steps:
    """Water inside in the mission, then systemctl stop."""
    yield from dive(world)
    world.mark("due")
    world.body.buoyancy = -6.0
    world.pi.systemctl_stop()
    yield from world.wait(240)


def term_twice(world: World) -> Steps:
    """systemctl stop, and again 4 s later."""
    yield from dive(world)
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(4)
    world.mark("again")
    world.pi.signal(signal.SIGTERM)
    yield from world.wait(60)


def negative_rate(world: World) -> Steps:
    """A crash at depth; the vehicle file that the next start finds has a dive rate below zero."""
    yield from own_vehicle(world)
    yield from dive(world)
    world.mark("due")
    path = world.folder / "own.yaml"
    path.write_text(path.read_text().replace("dive_rate: 0.35", "dive_rate: -0.35"))
    world.pi.signal(signal.SIGKILL)
    yield from world.rest(200)


def spoiled_store(how: str) -> Script:
    """A crash at depth; what lies in the store is not what was written there."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.mark("due")
        world.pi.signal(signal.SIGKILL)
        for path in (world.pi.state / "store").rglob("*"):
            if path.is_file():
                data = path.read_bytes()
                path.write_bytes(b"" if how == "emptied" else bytes(b ^ 0x55 for b in data))
        yield from world.rest(200)

    return script


def yaml_bomb(world: World) -> Steps:
    """A crash at depth; the configuration has become a text that grows when it is read."""
    yield from dive(world)
    world.mark("due")
    rows = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    rows += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12)]
    world.pi.config.write_text("\n".join([*rows, "vehicle: *a11", ""]))
    world.pi.signal(signal.SIGKILL)
    yield from world.rest(200)


NO_ALARM = never(UPWARD.pattern, "jump", "a clock decides nothing", "calm")
SCENES: tuple[Scene, ...] = (
    Scene(
        "dives-after-w-term-full",
        "U12 is a way of the ascent, an end waits for the surface, a disk is a feature",
        possessed_term_full,
        (*LIGHT, upward_within(1)),
    ),
    Scene("killed-disk-full", "what the disk holds is known", killed_full, RISES),
    Scene("power-twice-heavy", "each start surfaces", power_twice, (*LIFTED, upward_within(12))),
    Scene("power-twice-on-deck", "nothing was under way", power_on_deck, (reached(), quiet("due"))),
    Scene("clock-jumps", "no decision depends on the clock", clock_jumps, (*LIGHT, NO_ALARM)),
    Scene("power-cut-1970", "nor does a start", cut_in_1970, RISES),
    Scene(
        "killed-in-ascent-heavy",
        "an ascent is latched, and what sinks out of surfaced is brought up",
        killed_in_ascent,
        (*LIFTED, sinking_noticed(within=12)),
    ),
    Scene(
        "held-up-term",
        "an orderly end leaves the vehicle on its way up, and this one sinks when let go",
        held_up_term,
        LIFTED,
    ),
    Scene(
        "heavy-term",
        "serve surfaces, and its last word does not sink what cannot float",
        heavy_term,
        LIFTED,
    ),
    Scene(
        "term-twice",
        "told twice, X0 and U12 are the last words",
        term_twice,
        (reached(), home(60, off=False), never_deeper(16), word_within("@ZAU12", 1, "again")),
    ),
    Scene("killed-negative-rate", "each number has its range", negative_rate, RISES),
    *[
        Scene(
            f"killed-store-{how}",
            "where the store cannot tell, two reports can",
            spoiled_store(how),
            RISES,
        )
        for how in ("emptied", "garbled")
    ],
    Scene("killed-yaml-bomb", "a text cannot exhaust a start", yaml_bomb, RISES),
)
