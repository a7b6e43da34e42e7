"""Scenes of the Pi and the board in trouble, several troubles at a time: power, disks, ports, lines.

Issue 12, part A, items 1 to 4, 13, 14 and 19, and two or three of them together.
"""

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
    passed,
    quiet,
    reached,
    sinking_noticed,
    upward_within,
    word_within,
)
from tests.sea.others import Rov
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, order, own_vehicle
from tests.sea.stm32 import Board
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

# A board that does not do as it is told for a minute, 4 to 5 N too heavy: 0.19 m/s, and 10 s.
DEEPER = (reached(), home(300, HELD, off=False), held_up(), never_deeper(30), lives())


def gaps(world: World, silent: float = 9.0, period: float = 20.0) -> Steps:
    """A plug that moves: no report for 9 s of each 20 s."""
    while True:
        world.board.mute = True
        yield from world.wait(silent)
        world.board.mute = False
        yield from world.wait(period - silent)


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


class Sluggish(Board):
    """Hears nothing for 3 s after each word that it has taken."""

    def hear(self, now: float, data: bytes) -> None:
        count = len(self.words)
        if now >= self.deaf_until:
            super().hear(now, data)
            if len(self.words) > count:
                self.deaf_until = now + 3.0

    deaf_until = 0.0


def sluggish(world: World) -> Steps:
    """From W on, the board takes one word each 3 s, and is 4 N too heavy."""
    yield from dive(world)
    world.board.__class__ = Sluggish
    order(world, "@ZAWF$")
    world.body.buoyancy = -4.0
    yield from world.wait(300)


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
    Scene(
        "brown-out-in-ascent-heavy",
        "what no longer lifts it is said again",
        brown_out_in_ascent,
        DEEPER,
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
    Scene("sluggish-heavy-w", "each way has 10 s", sluggish, LIFTED),
)
