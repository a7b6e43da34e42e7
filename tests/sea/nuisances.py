"""Scenes of boards and lines that are a nuisance: deaf, forgetful, noisy, away; and of who floods them."""

from __future__ import annotations

import signal
from collections.abc import Iterator

from tests.sea.laws import (
    HELD,
    held_up,
    home,
    lives,
    never,
    never_deeper,
    passed,
    reached,
    upward_within,
)
from tests.sea.others import Rov
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, order, slides
from tests.sea.stm32 import Board
from tests.sea.world import World
from tests.sea.wrecks import BACK, LIFTED

Steps = Iterator[None]
# A board that does not do as it is told for a minute, 4 N too heavy: 0.17 m/s, and 10 s.
DEEPER = (reached(), home(300, HELD, off=False), held_up(), never_deeper(30), lives())


def gaps(world: World, silent: float = 9.0, period: float = 20.0) -> Steps:
    """A plug that moves: no report for 9 s of each 20 s."""
    while True:
        world.board.mute = True
        yield from world.wait(silent)
        world.board.mute = False
        yield from world.wait(period - silent)


def brown_out_in_ascent(world: World) -> Steps:
    """W, water inside; the board restarts each 25 s and remembers nothing."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -5.0
    for _ in range(5):
        yield from world.wait(25)
        world.board.restart()
    yield from world.wait(120)


def replugged(world: World) -> Steps:
    """The board's port vanishes for 20 s and comes back as another device; W in between."""
    yield from dive(world)
    world.line.vanish()
    yield from world.wait(8)
    boat(world).send("@ZAWF$")
    yield from world.wait(12)
    world.line.come_back()
    world.mark("due")
    yield from world.rest(180)


def foreign(world: World) -> Steps:
    """For 40 s the board sends reports of an ROV that is 0.1 m deep."""
    yield from dive(world)
    own, stranger = world.board.report, Rov(world.body, world.line, world.seed)
    stranger.senses.depth = lambda _now, _truth: 0.1
    world.board.report = stranger.report
    world.mark("due")
    yield from world.wait(40)
    world.board.report = own
    yield from world.rest(180)


def yes_man(world: World) -> Steps:
    """For 90 s the board answers Y to everything and goes on holding its depth; then it obeys."""
    yield from dive(world)
    world.board.yes_until = world.now + 90
    order(world, "@ZAWF$")
    yield from world.rest(240)


def yes_man_heavy_x(world: World) -> Steps:
    """The same for 60 s from an X on, in which water comes in."""
    yield from dive(world)
    world.board.yes_until = world.now + 60
    order(world, "@ZAX0$")
    world.body.buoyancy = -4.0
    yield from world.wait(330)


def gappy(word: str, buoyancy: float) -> Script:
    """No report for 9 s of each 20 s; a word, and another trim with it."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.spawn(gaps(world))
        if word:
            boat(world).send(word)
        world.mark("due")
        world.body.buoyancy = buoyancy
        yield from (world.wait(300) if buoyancy < 0 else world.rest(200))

    return script


def dripping(world: World) -> Steps:
    """Between its frames the board's line drips: a false header, and a byte each 45 ms."""
    yield from dive(world)
    world.mark("due")

    def drip() -> Steps:
        count = 0
        while True:
            world.line.send(world.now, b"@SD" if count % 30 == 0 else bytes([count % 97]))
            count += 1
            yield from world.wait(0.045)

    world.spawn(drip())
    yield from world.wait(6)
    boat(world).send("@ZAWF$")
    yield from world.rest(200)


def slow_stick(world: World) -> Steps:
    """A program pushes each 1.9 s; another orders W by radio and is gone; then a crash."""
    yield from dive(world)
    world.spawn(boat(world).repeat("@MMD8$", 1.9))
    yield from world.wait(1)
    other = world.operator("other")
    yield from world.wait(0.2)
    other.send("@ZAWF$")
    yield from world.wait(0.3)
    world.mark("due")
    other.close()
    yield from world.wait(5)
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(150)


def heavy_then_light(world: World) -> Steps:
    """6 N too heavy for 70 s from the X on; then a weight drops."""
    yield from dive(world)
    order(world, "@ZAX0$")
    world.body.buoyancy = -6.0
    yield from world.wait(70)
    world.body.buoyancy = 10.0
    yield from world.rest(200)


def noise_slider_x(world: World) -> Steps:
    """Noise on the modem, a slider at 200 Hz on another connection, and X by modem and by radio."""
    yield from dive(world)
    assert world.acoustic
    acoustic = world.acoustic
    world.spawn(boat(world).repeat(lambda n: f"@DS{1 + n % 2},{n % 20}$", 1 / 200))

    def noise() -> Steps:
        while True:
            acoustic.noise(b"\x23\x02\x80\x0c\x01")
            for count in range(7):
                yield from world.wait(0.6)
                acoustic.noise(bytes([0x24 + count]))

    world.spawn(noise())
    yield from world.wait(8)
    acoustic.send("@ZAX0$")
    yield from world.wait(acoustic.delay)
    world.mark("due")
    yield from world.rest(150)


def flood_term(world: World) -> Steps:
    """600 frames a second from two boats, and systemctl stop."""
    yield from dive(world)
    other = world.operator("other")
    for talker in (boat(world), other):
        world.spawn(talker.repeat("@DU$@NI$@AQ$", 0.01, until=world.now + 25))
    yield from world.wait(3)
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.rest(200)


class Sluggish(Board):
    """Hears nothing for so many seconds after each word that it has taken."""

    behind = 0.5

    def hear(self, now: float, data: bytes) -> None:
        count = len(self.words)
        if now >= self.deaf_until:
            super().hear(now, data)
            if len(self.words) > count:
                self.deaf_until = now + self.behind


def sluggish(world: World) -> Steps:
    """From W on, the board is deaf for 0.5 s behind each word, and is 4 N too heavy."""
    yield from dive(world)
    world.board.__class__ = Sluggish
    order(world, "@ZAWF$")
    world.body.buoyancy = -4.0
    yield from world.wait(300)


def sluggish_slider(world: World) -> Steps:
    """The same, and the operator's rudder slider moves all the time."""
    world.spawn(slides(world, 200.0))
    yield from sluggish(world)


SCENES: tuple[Scene, ...] = (
    Scene(
        "brown-out-in-ascent-heavy",
        "what no longer lifts it is said again",
        brown_out_in_ascent,
        LIFTED,
    ),
    Scene("replugged", "when the port is back, what holds is said again", replugged, BACK),
    Scene("foreign-frames", "another vehicle's report is none", foreign, (*BACK, upward_within(9))),
    Scene("yes-man", "an acknowledgement proves nothing", yes_man, BACK),
    Scene(
        "yes-man-heavy-x",
        "not risen in 20 s: an ascent that never gives up",
        yes_man_heavy_x,
        (*DEEPER, upward_within(28)),
    ),
    Scene("gappy", "5 s without a report, and two reports in a gap", gappy("", 8.0), BACK),
    Scene("gappy-heavy-w", "the depth between the gaps falls", gappy("@ZAWF$", -5.0), LIFTED),
    Scene("gappy-heavy-x", "it has not risen in 20 s", gappy("@ZAX0$", -5.0), LIFTED),
    Scene("dripping-line", "what is unfinished is given up", dripping, BACK),
    Scene(
        "slow-stick-restart",
        "who pushes each 1.9 s has never been still for 2 s",
        slow_stick,
        (*LIGHT, never("^@M", "due", "an emergency is under way")),
    ),
    Scene(
        "heavy-then-light",
        "lifted first, and afloat at the end",
        heavy_then_light,
        (reached(), home(300, off=False), held_up(), never_deeper(22), lives()),
    ),
    Scene(
        "modem-noise-slider-x",
        "X is found in noise, and has rank over a slider",
        noise_slider_x,
        (reached(), home(150), passed(3.0), never_deeper(16), lives()),
        world={"modem": True},
    ),
    Scene("flood-term", "a flood keeps no ascent back", flood_term, (*LIGHT, upward_within(5))),
    Scene("sluggish-heavy-w", "what was not answered is said again", sluggish, LIFTED),
    Scene("sluggish-heavy-slider", "a slider waits for the answer", sluggish_slider, LIFTED),
)
