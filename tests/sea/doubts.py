"""Scenes of what can be believed: depths, attitudes and fixes that lie two at a time, and what follows."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator

from tests.sea import faults, hull
from tests.sea.laws import (
    HELD,
    UPWARD,
    Law,
    home,
    lives,
    never,
    never_deeper,
    reached,
    upward_within,
)
from tests.sea.nuisances import gaps
from tests.sea.scene import LIGHT, TRUE_FIXES, Scene, Script, boat, dive, go, mission, order, ruin
from tests.sea.senses import own_voltage
from tests.sea.world import World
from tests.sea.wrecks import BACK, LIFTED

Steps = Iterator[None]
CALM = never(UPWARD.pattern, "strange", "a false alarm", "calm")
QUIET_DIVE = (*LIGHT, CALM)


def strange(world: World, seconds: float = 45.0) -> Steps:
    """The mission goes on under something that is strange and no fault; then W."""
    world.mark("strange")
    yield from world.wait(seconds)
    world.mark("calm")
    order(world, "@ZAWF$")
    yield from world.rest(150)


def clogged_on_the_way_up(world: World) -> Steps:
    """W, 5 N too heavy; on the way up the port closes with 4 m in it, and opens a minute later."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -5.0
    yield from world.until(lambda: world.body.depth < 4.0, 120)
    world.board.senses.depth = faults.clogged(4.0, world.seed)
    yield from world.wait(60)
    world.board.senses.depth = faults.honest
    yield from world.held(200)


def clogged_at_the_surface(world: World) -> Steps:
    """W, 6 N too heavy; at the surface the port closes for 35 s: let go, it sinks, and says 0.1 m."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -6.0
    yield from world.until(lambda: world.body.depth < 0.3, 120)
    world.board.senses.depth = faults.clogged(0.1, world.seed)
    yield from world.wait(35)
    world.board.senses.depth = faults.honest
    yield from world.wait(200)


def clogged_for_a_while(world: World) -> Steps:
    """Asked for 8 m; the port closes at 6 m, for 45 s, and is free again."""
    yield from go(world, mission(8, 10))
    yield from world.until(lambda: world.body.depth > 6.0, 120)
    world.board.senses.depth = faults.clogged(6.0, world.seed)
    yield from world.wait(25)
    world.mark("due")
    yield from world.wait(20)
    world.board.senses.depth = faults.honest
    yield from world.rest(200)


def jumps_to_and_fro(world: World) -> Steps:
    """The reading is 5 m less for 15 s, then right for 15 s, over and over; W a minute later."""
    yield from dive(world)
    since = world.now
    world.board.senses.depth = lambda now, truth: truth - 5 * (int(now - since) // 15 % 2 == 0)
    yield from world.wait(25)
    world.mark("due")
    yield from world.rest(230)


def scaled(world: World) -> Steps:
    """The sensor tells seven tenths of the depth, in an ascent with 4 N too much weight, too."""
    world.board.senses.depth = lambda _now, truth: 0.7 * truth
    yield from dive(world)
    world.body.buoyancy = -4.0
    order(world, "@ZAWF$")
    yield from world.held(260)


def noisy(world: World) -> Steps:
    """The depth has 0.2 m of noise in the hold."""
    world.board.senses.depth_noise = 0.2
    yield from dive(world, stay="90s")
    yield from strange(world)


def late_and_heavy(world: World) -> Steps:
    """The depth is told 6 s late, and 5 N are too much from the W on."""
    yield from dive(world)
    world.board.senses.depth = faults.slow(6.0)
    order(world, "@ZAWF$")
    world.body.buoyancy = -5.0
    yield from world.held(220)


def dead_and_gappy(world: World) -> Steps:
    """No depth any more, no report for 9 s of each 20 s, and 8 N too heavy.

    At the surface somebody takes hold of it: once fixes have proved the surface it is let go, and an
    unknown depth turns no thruster there.
    """
    yield from dive(world)
    world.board.senses.depth = lambda _now, _truth: math.nan
    world.body.buoyancy = -8.0
    world.spawn(gaps(world))
    world.mark("due")
    yield from world.until(lambda: world.body.depth < 0.3, 300)
    world.body.buoyancy = 8.0
    yield from world.rest(150)


def offset_and_wandering(world: World) -> Steps:
    """The zero is off by a metre and a half, and the receiver makes places up under water; W."""
    yield from dive(world)
    world.board.senses.depth = faults.shifted(1.5)
    order(world, "@ZAWF$")
    yield from world.rest(280)


def negative_zero(world: World) -> Steps:
    """The zero is off by 0.7 m the other way: 7.3 m are told as 8; heavy after X, with fixes that wander."""
    world.board.senses.depth = faults.shifted(-0.7)
    yield from dive(world)
    order(world, "@ZAX0$")
    world.body.buoyancy = -5.0
    yield from world.held(250)


def over_under_the_stick(world: World) -> Steps:
    """A stick holds it down at 6 m, it turns over, and the radio is gone."""
    yield from dive(world, 5)
    world.spawn(boat(world).repeat("@MMD6$", 0.2, until=world.now + 8))
    yield from world.wait(5)
    world.body.turn_over()
    yield from world.wait(3)
    boat(world).close()
    world.mark("due")
    yield from world.rest(320)


def over_and_clogged(world: World) -> Steps:
    """It turns over at 8 m, and the port closes 3 s later."""
    yield from dive(world)
    world.body.turn_over()
    yield from world.wait(3)
    world.board.senses.depth = faults.clogged(8.0, world.seed)
    world.mark("due")
    yield from world.rest(320)


def over_unseen(world: World) -> Steps:
    """It turns over, and roll and pitch are silent from then on; the depth is told."""
    yield from dive(world)
    world.board.senses.roll = world.board.senses.pitch = lambda _now, _truth: math.nan
    world.body.turn_over()
    order(world, "@ZAWF$")
    yield from world.rest(280)


def over_and_back(world: World) -> Steps:
    """The ballast slides to and fro each 25 s."""
    yield from dive(world)
    world.mark("due")
    for _ in range(4):
        world.body.turn_over()
        yield from world.wait(25)
        world.body.ballast = hull.BALLAST
        yield from world.wait(25)
    yield from world.rest(200)


def over_said_again(world: World) -> Steps:
    """It is upside down, and the operator says W twice a second: a board whose W holds pushes down."""
    yield from dive(world)
    world.body.turn_over()
    yield from world.wait(8)
    order(world, "@ZAWF$")
    world.spawn(boat(world).repeat("@ZAWF$", 0.5, until=world.now + 30))
    yield from world.rest(280)


def over_neutral(world: World) -> Steps:
    """It turns over, and no buoyancy is left: only full thrust *down* lifts it, 5 s in a minute."""
    yield from dive(world)
    world.body.turn_over()
    world.body.buoyancy = 0.5
    world.mark("due")
    yield from world.held(500)


def over_term(world: World) -> Steps:
    """It turns over, and systemctl stop."""
    yield from dive(world)
    world.body.turn_over()
    world.mark("due")
    yield from world.wait(2)
    world.pi.systemctl_stop()
    yield from world.rest(280)


def over_killed_blind(world: World) -> Steps:
    """It turns over, the program crashes, and the store is a file at the next start."""
    yield from dive(world)
    world.body.turn_over()
    world.mark("due")
    yield from world.wait(3)
    world.pi.signal(signal.SIGKILL)
    ruin(world, "store a file")
    yield from world.rest(280)


def told_by(seconds: float, **receiver: object) -> Script:
    """A receiver of other habits; the depth is silent from 8 m on, and fixes are what is left."""

    def script(world: World) -> Steps:
        assert world.receiver
        for name, value in receiver.items():
            setattr(world.receiver, name, value)
        yield from dive(world)
        world.board.senses.depth = lambda _now, _truth: math.nan
        yield from world.wait(10)
        world.mark("due")
        yield from world.rest(seconds)

    return script


def bare_sentences(world: World) -> Steps:
    """From the dive on the receiver leaves its checksums out; W."""
    yield from dive(world)
    assert world.receiver
    world.receiver.checked = False
    order(world, "@ZAWF$")
    yield from world.rest(150)


def healthy_voltage(world: World) -> Steps:
    """The control battery swings about its limit of 22 V, most of the time above it."""
    yield from own_voltage(world)
    yield from dive(world, stay="90s")
    world.board.senses.control = faults.flicker(23.4, 1.7, world.seed)
    yield from strange(world)


OVER: tuple[Law, ...] = (reached(), home(300), never_deeper(20), lives())
SCENES: tuple[Scene, ...] = (
    Scene(
        "clogged-on-the-way-up-heavy",
        "thrust upward is kept, and a reading that moves again is believed",
        clogged_on_the_way_up,
        LIFTED,
    ),
    Scene(
        "clogged-at-the-surface-heavy",
        "what leaps and then goes down as a body does, sinks",
        clogged_at_the_surface,
        LIFTED,
    ),
    Scene("clogged-for-a-while", "what moves again is believed", clogged_for_a_while, BACK),
    Scene("jumps-to-and-fro", "no body rises 5 m in 2 s", jumps_to_and_fro, BACK),
    Scene("scale-of-seven-tenths-heavy", "what is told still falls", scaled, LIFTED),
    Scene("noisy-depth", "0.2 m of noise contradict nothing", noisy, QUIET_DIVE),
    Scene("late-depth-heavy", "full thrust is tried for longer", late_and_heavy, LIFTED),
    Scene(
        "no-depth-gappy-heavy",
        "full thrust has longer turns where no depth tells",
        dead_and_gappy,
        (reached(), home(300), never_deeper(30), lives()),
        world=TRUE_FIXES,
    ),
    Scene(
        "zero-off-wandering",
        "at the surface nothing moves it any more, and fixes come",
        offset_and_wandering,
        (reached(), home(260), never_deeper(16), lives()),
        world={"receiver_mode": "wandering"},
    ),
    Scene(
        "zero-off-heavy-x",
        "it has not risen in 20 s, and is held up",
        negative_zero,
        (*LIFTED, upward_within(30)),
        world={"receiver_mode": "wandering"},
    ),
    Scene("over-under-the-stick", "let go it rises", over_under_the_stick, OVER),
    Scene(
        "over-clogged",
        "whatever its depth says, two of the ways lift it: within 4 m of the surface, for ever",
        over_and_clogged,
        (reached(), home(300, 4.0, off=False), never_deeper(20), lives()),
    ),
    Scene("over-unseen", "letting go is what makes the depth fall", over_unseen, OVER),
    Scene("over-and-back", "either way up, one of the ways lifts it", over_and_back, OVER),
    Scene(
        "over-w-said-again",
        "behind each W comes the way that is in use",
        over_said_again,
        OVER,
        board={"built": False},
    ),
    Scene(
        "over-neutral",
        "0.5 N lift it at 0.06 m/s, and D12 helps",
        over_neutral,
        (reached(), home(480, HELD, off=False), never_deeper(20), lives()),
    ),
    Scene("over-term", "an orderly end surfaces first", over_term, OVER),
    Scene("over-killed-store-a-file", "X, then letting go", over_killed_blind, OVER),
    Scene("no-depth-gps-2-hz", "fixes each half second are fixes", told_by(230, period=0.5), BACK),
    Scene("no-depth-gps-5-hz", "or each 0.2 s", told_by(230, period=0.2), BACK),
    Scene("no-depth-gps-1999", "nothing decides by the date", told_by(230, date="310799"), BACK),
    Scene(
        "no-depth-gps-half-hz",
        "a place each 2 s is no fix each second: it floats, and goes on pushing",
        told_by(200, period=2.0),
        (reached(), home(150, off=False), never_deeper(16), lives()),
    ),
    Scene("no-checksums", "the depth proves the surface", bare_sentences, LIGHT),
    Scene(
        "no-depth-ring",
        "five places in turn are stuck",
        told_by(230),
        BACK,
        body={"buoyancy": 2.0},
        world={"receiver_mode": "ring"},
    ),
    Scene(
        "healthy-voltage",
        "most of a window is above the limit",
        healthy_voltage,
        QUIET_DIVE,
        board={"built": False},
    ),
)
