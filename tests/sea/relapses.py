"""Scenes in which it comes back: vehicles that sink again from rest, ends in hold-ups, starts in ruins."""

from __future__ import annotations

import signal
from collections.abc import Iterator

from tests.sea import faults
from tests.sea.faults import Will
from tests.sea.laws import (
    HELD,
    Law,
    held_up,
    home,
    lives,
    never_deeper,
    passed,
    reached,
    sinking_noticed,
    upward_within,
    word_within,
)
from tests.sea.nuisances import gaps
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, order
from tests.sea.world import World
from tests.sea.wrecks import BACK, LIFTED

Steps = Iterator[None]


def held_up_after_w(world: World, buoyancy: float = -6.0) -> Steps:
    """W, too heavy to float, and held up at the surface by thrust."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = buoyancy
    yield from world.wait(150)


def heavy_later(world: World) -> Steps:
    """W, home and at rest for a minute; then water comes in, and the board is deaf for 6 s."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(90)
    world.mark("due")
    world.body.buoyancy = -6.0
    world.board.deaf_until = world.now + 6
    yield from world.held(210)


def dives_waiting(world: World) -> Steps:
    """Somebody lets the stick go at 5 m, and the board dives by itself until it hears U12."""
    yield from dive(world, 5)
    world.spawn(boat(world).repeat("@MMF3$", 0.2, until=world.now + 4))
    yield from world.wait(8)
    world.mark("due")
    world.board.will = Will(obeys=frozenset("U"), times=2, again=60)
    yield from world.wait(210)


def let_go_of_the_held_up(world: World) -> Steps:
    """X for a vehicle that is held up: it sinks, and has not risen 20 s after it was 2 m deep."""
    yield from held_up_after_w(world)
    boat(world).send("@ZAX0$")
    yield from world.until(lambda: world.body.depth > 2.3, 60)
    world.mark("deep")
    yield from world.held(250)


def term_and_start(world: World) -> Steps:
    """systemctl restart, of a vehicle that is held up."""
    yield from held_up_after_w(world)
    world.pi.signal(signal.SIGTERM)
    yield from world.wait(130)


def power_in_hold_up(world: World) -> Steps:
    """Held up at the surface, Pi and board lose their power, twice; reports come with gaps."""
    yield from held_up_after_w(world)
    world.spawn(gaps(world))
    for _ in range(2):
        world.board.restart()
        world.pi.power_cut()
        yield from world.wait(120)


def term_under_stick(world: World) -> Steps:
    """A stick pushes it down; systemctl stop; the stick goes on for 6 s."""
    yield from dive(world, 5)
    world.spawn(boat(world).repeat("@MMD6$", 0.2, until=world.now + 9))
    yield from world.wait(3)
    world.pi.systemctl_stop()
    yield from world.wait(6)
    world.mark("due")
    yield from world.rest(200)


def term_after_x(world: World) -> Steps:
    """X, 4 N too heavy, and systemctl stop 3 s later."""
    yield from dive(world)
    order(world, "@ZAX0$")
    world.body.buoyancy = -4.0
    yield from world.wait(3)
    world.pi.systemctl_stop()
    yield from world.held(270)


def term_without(what: str) -> Script:
    """systemctl stop, of a vehicle without a depth, or without a report."""

    def script(world: World) -> Steps:
        yield from dive(world)
        if what == "depth":
            world.board.senses.depth = lambda _now, _truth: float("nan")
        else:
            world.board.mute = True
        world.mark("due")
        world.pi.systemctl_stop()
        yield from world.rest(260)

    return script


def term_deaf(world: World) -> Steps:
    """systemctl stop; the board hears nothing for 20 s, and goes on holding 8 m; heavy from then on."""
    yield from dive(world)
    world.board.deaf_until = world.now + 20
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(20)
    world.body.buoyancy = -3.0
    yield from world.held(240)


def interrupted(world: World) -> Steps:
    """Ctrl-C in the terminal of serve, and a crash 5 s later: the next start goes on."""
    yield from dive(world)
    world.mark("due")
    world.pi.signal(signal.SIGINT)
    yield from world.wait(5)
    world.pi.signal(signal.SIGKILL)
    yield from world.rest(200)


def port_late(world: World) -> Steps:
    """A crash at depth; the board's port is away at the start and comes as another device 15 s later."""
    yield from dive(world)
    world.line.vanish()
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(15)
    world.body.buoyancy = -4.0
    world.line.come_back()
    world.mark("due")
    yield from world.held(210)


def both_ports(world: World) -> Steps:
    """Board and receiver lose their ports in the ascent of a vehicle without a depth; both come back."""
    yield from dive(world)
    world.board.senses.depth = lambda _now, _truth: float("nan")
    order(world, "@ZAWF$")
    yield from world.wait(3)
    for line in world.lines:
        line.vanish()
    yield from world.wait(15)
    for line in reversed(world.lines):
        line.come_back()
        yield from world.wait(7)
    yield from world.rest(230)


def wild_clock(world: World) -> Steps:
    """W, 5 N too heavy: the wall clock of the Pi leaps by a day to and fro each second."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -5.0
    for count in range(200):
        world.clock.set_wall((-1) ** count * 86400.0)
        yield from world.wait(1)


def wakes_possessed(obeys: str) -> Script:
    """A crash at depth; from then on the board dives by itself until it hears one of these."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.mark("due")
        world.pi.signal(signal.SIGKILL)
        world.board.will = Will(obeys=frozenset(obeys), times=3, again=40)
        yield from world.wait(220)

    return script


def term_twice_heavy(world: World) -> Steps:
    """6 N too heavy in the mission: systemctl stop, and again 4 s later."""
    yield from dive(world)
    world.body.buoyancy = -6.0
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(4)
    world.mark("again")
    world.pi.signal(signal.SIGTERM)
    yield from world.wait(180)


def garbage_in_hold_up(world: World) -> Steps:
    """Held up at the surface; the depth is garbage for 30 s, and true again."""
    yield from held_up_after_w(world)
    world.board.senses.depth = faults.garbage(world.seed)
    yield from world.wait(30)
    world.board.senses.depth = faults.honest
    yield from world.held(200)


DEAF_LIFTED: tuple[Law, ...] = (
    reached(),
    home(300, HELD, off=False),
    held_up(),
    never_deeper(26),
    lives(),
)
SCENES: tuple[Scene, ...] = (
    Scene(
        "heavy-later-deaf",
        "what sinks out of surfaced is brought up, and held up",
        heavy_later,
        (
            *(reached(), home(300, HELD, off=False), sinking_noticed(within=14)),
            *(held_up(), never_deeper(16), lives()),
        ),
    ),
    Scene(
        "dives-waiting",
        "two reports of sinking begin an ascent",
        dives_waiting,
        (reached(), home(300, off=False), sinking_noticed(), never_deeper(25), lives()),
    ),
    Scene(
        "held-up-x",
        "an X ends the way up; it has not risen in 20 s",
        let_go_of_the_held_up,
        (*LIFTED, upward_within(28, "deep"), passed()),
    ),
    Scene("held-up-restart", "held up before, held up again", term_and_start, LIFTED),
    Scene("held-up-power-gappy", "each start surfaces", power_in_hold_up, LIFTED),
    Scene("held-up-garbage", "what sinks is held up by thrust", garbage_in_hold_up, LIFTED),
    Scene(
        "term-under-stick",
        "the stick counts until it is silent; then up",
        term_under_stick,
        (*LIGHT, upward_within(8)),
    ),
    Scene("term-after-x-heavy", "the end waits for what is deep", term_after_x, LIFTED),
    *[
        Scene(f"term-without-{what}", "a fix ends the ascent", term_without(what), BACK)
        for what in ("depth", "report")
    ],
    Scene("term-deaf-heavy", "what was not answered is said again", term_deaf, DEAF_LIFTED),
    Scene("ctrl-c-killed", "an ascent is latched", interrupted, (*LIGHT, upward_within(8))),
    Scene(
        "killed-port-late-heavy",
        "when the port is there, the way in use is said; the next follow in turn",
        port_late,
        (*LIFTED, word_within("@ZAX0", 2, "due"), upward_within(22)),
    ),
    Scene(
        "no-depth-both-ports-away",
        "it dives by itself at 0.36 m/s while the port is away; fixes end it, after all",
        both_ports,
        (reached(), home(200), never_deeper(19), lives()),
    ),
    Scene("wild-clock-heavy", "a clock decides nothing", wild_clock, LIFTED),
    *[
        Scene(
            f"killed-dives-until-{obeys}",
            "one of an ascent's words ends it, each time",
            wakes_possessed(obeys),
            (reached(), home(240, off=False), held_up(), upward_within(12), lives()),
        )
        for obeys in "UX"
    ],
    Scene(
        "term-twice-heavy",
        "X0 and U12 are the last words, and lift 6 N",
        term_twice_heavy,
        (
            *(reached(), home(200, HELD, off=False), never_deeper(22)),
            word_within("@ZAU12", 1, "again"),
        ),
    ),
)
