"""Scenes of who speaks and what arrives: sliders, sticks, copies, echoes, noise, several at a time."""

from __future__ import annotations

import random
import signal
from collections.abc import Iterator

from tests.sea.ascents import SETS, STAIRS
from tests.sea.laws import (
    UPWARD,
    home,
    legs,
    lives,
    never,
    never_deeper,
    noted,
    passed,
    reached,
    upward_within,
    word_within,
)
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, go, mission, order
from tests.sea.wire import modem_frame
from tests.sea.world import World
from tests.sea.wrecks import LIFTED

Steps = Iterator[None]
WET: dict[str, object] = {"modem": True}
OWNED = (*LIGHT, never("^@M", "due", "an emergency is under way"))
CALM = never(UPWARD.pattern, "strange", "a false alarm", "calm")


def strange(world: World, seconds: float = 45.0) -> Steps:
    """The mission goes on under something that is strange and no fault; then W."""
    world.mark("strange")
    yield from world.wait(seconds)
    world.mark("calm")
    order(world, "@ZAWF$")
    yield from world.rest(150)


def relays_in_legs(world: World) -> Steps:
    """A mission of many legs under rudders, power and questions, 200 frames a second."""
    yield from go(world, STAIRS)
    words = ("@DS1,5$", "@RI$", "@DS2,-3$", "@RSOOOOOOO$", "@DA1,1$", "@DS3,2$")
    world.spawn(boat(world).repeat(lambda n: words[n % len(words)], 1 / 200))
    yield from world.wait(75)
    world.mark("due")
    yield from world.rest(110)


def three_boats(world: World) -> Steps:
    """A slider at 200 Hz, steps of a rudder at 100 Hz, questions by the hundred; W by a third boat, X, W."""
    yield from dive(world)
    world.spawn(boat(world).repeat(lambda n: f"@DS{1 + n % 2},{n % 20}$", 1 / 200))
    world.spawn(boat(world).repeat("@DA1,1$", 1 / 100))
    other, third = world.operator("other"), world.operator("third")
    world.spawn(other.repeat("@DU$@NI$@AQ$@AE$", 1 / 100))
    yield from world.wait(5)
    for frame in ("@ZAWF$", "@ZAX0$", "@ZAWF$"):
        third.send(frame)
        world.mark("due")
        yield from world.wait(1.5)
    yield from world.rest(150)


def quarrel(world: World) -> Steps:
    """Two boats say X and W in turn, twice a second, for 20 s; the last word is W."""
    yield from dive(world)
    other = world.operator("other")
    world.spawn(boat(world).repeat("@ZAX0$", 1.0, until=world.now + 20))
    yield from world.wait(0.5)
    world.spawn(other.repeat("@ZAWF$", 1.0, until=world.now + 20))
    world.mark("due")
    yield from world.rest(200)


def w_again_and_again(buoyancy: float) -> Script:
    """W twice a second for a minute, with another trim: as built, W moves nothing."""

    def script(world: World) -> Steps:
        yield from dive(world)
        order(world, "@ZAWF$")
        world.body.buoyancy = buoyancy
        world.spawn(boat(world).repeat("@ZAWF$", 0.5, until=world.now + 60))
        yield from world.held(210)

    return script


def two_sticks(neutral: str) -> Script:
    """W from a third who is gone; two sticks in turn, each still for 1.6 s, never both for 2 s; a crash."""

    def script(world: World) -> Steps:
        yield from dive(world)
        other, third = world.operator("other"), world.operator("third")
        world.spawn(boat(world).repeat("@MMD8$", 1.6))
        yield from world.wait(0.8)
        world.spawn(other.repeat(neutral, 1.6))
        yield from world.wait(1)
        third.send("@ZAWF$")
        yield from world.wait(0.3)
        world.mark("due")
        third.close()
        yield from world.wait(25)
        world.pi.signal(signal.SIGKILL)
        yield from world.wait(130)

    return script


def stick_against_x(world: World) -> Steps:
    """The commander pushes down 50 times a second; another says X, and is gone."""
    yield from dive(world)
    world.spawn(boat(world).repeat("@MMD12$", 0.02))
    yield from world.wait(2)
    other = world.operator("other")
    yield from world.wait(0.2)
    other.send("@ZAX0$")
    yield from world.wait(0.3)
    world.mark("due")
    other.close()
    yield from world.wait(150)


def taken_over(world: World) -> Steps:
    """W; after 4 s of stillness the commander pushes up by the stick, and lets go 6 s later."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(4)
    world.mark("stick")
    world.spawn(boat(world).repeat("@MMU10$", 0.2, until=world.now + 6))
    yield from world.wait(6)
    world.mark("due")
    yield from world.rest(200)


def stick_by_modem(world: World) -> Steps:
    """By modem somebody pushes the stick, twice a second, in a mission and in an ascent."""
    yield from dive(world, stay="90s")
    acoustic = world.acoustic
    assert acoustic

    def push() -> Steps:
        while True:
            acoustic.send("@MMD12$")
            yield from world.wait(0.5)

    world.spawn(push())
    yield from strange(world, 20)


def copies_in_ascent(world: World) -> Steps:
    """All that made the dive comes again by modem, late, while an ascent of a hovering body is under way."""
    yield from go(world, mission(8, 10))
    asked = world.marks["go"]
    yield from boat(world).ask("@SP,900,40,30,10,$", "SP")
    yield from boat(world).ask("@SP,800,40,12,10,$", "SP")
    yield from world.until(lambda: world.body.depth > 7, 120)
    world.body.buoyancy = 0.5
    order(world, "@ZAWF$")
    acoustic = world.acoustic
    assert acoustic
    while world.now < asked + 115:
        for frame in ("@AA$", "@SP,900,40,30,10,$", "@AC$", "@NSOOOOOO$", "@AA$"):
            acoustic.send(frame)
            yield from world.wait(3)
    yield from world.rest(150)


def late_stop(world: World) -> Steps:
    """X by modem and W by radio; the X comes again 20, 60 and 110 s later; 5 N too heavy."""
    yield from dive(world)
    acoustic = world.acoustic
    assert acoustic
    boat(world).send("@ZAX0$")
    yield from world.wait(2)
    order(world, "@ZAWF$")
    world.body.buoyancy = -5.0
    for pause in (18, 40, 50, 190):
        yield from world.wait(pause)
        if pause < 100:
            acoustic.send("@ZAX0$")


def both_paths(world: World) -> Steps:
    """Every word of the operator's comes by modem as well, 1 to 4 s later, through the whole dive."""
    acoustic = world.acoustic
    assert acoustic

    def twice() -> Steps:
        seen = 0
        while True:
            sent = [frame for boat in world.operators for _, frame in boat.sent]
            for frame in sent[seen:]:
                acoustic.send(frame)
            seen = len(sent)
            yield from world.wait(1.0)

    world.spawn(twice())
    yield from dive(world, stay="60s")
    yield from strange(world, 30)


def foreign_answers(world: World) -> Steps:
    """Another vehicle answers its own boat on the same channel, three times a second."""
    yield from dive(world, stay="90s")
    acoustic = world.acoustic
    assert acoustic
    words = (
        b"@ACK_AAA$@ACK_ACC$",
        b"@ACK_NI\x24$@ACK_NSS$",
        b"@AE,1,EW,other,0,,12,,,,,,,$",
        b"@AR,running,12,12,,0123456789abcdef,,$",
        b"@ACK_ZXY$@ACK_SPP$",
    )

    def speaks() -> Steps:
        count = 0
        while True:
            acoustic.noise(modem_frame(words[count % len(words)], address=2))
            count += 1
            yield from world.wait(0.3)

    world.spawn(speaks())
    yield from strange(world)


def noise_at_pace(gap: float, word: str) -> Script:
    """Noise at the pace of bytes, false headers among them, for as long as the word is said and after."""

    def script(world: World) -> Steps:
        yield from dive(world)
        acoustic = world.acoustic
        assert acoustic
        draw = random.Random(world.seed)

        def noise() -> Steps:
            count = 0
            while True:
                head = b"\x23\x02\x80\x0c\x01" if count % 40 == 0 else b""
                acoustic.noise(
                    head + bytes([draw.choice(b"@$#\x02Z") if count % 3 else count % 256])
                )
                count += 1
                yield from world.wait(gap)

        world.spawn(noise())
        yield from world.wait(6)
        acoustic.send(word)
        yield from world.wait(acoustic.delay)
        world.mark("due")
        yield from world.rest(150)

    return script


def cut_in_a_line(world: World) -> Steps:
    """The radio cuts a line of a mission, a time and a limit; the word behind each is W, X, W."""
    yield from dive(world)
    for cut, word in (
        (b"@AW\x03\x00\x01\x00mission sea veh", "@ZAWF$"),
        (b"@ST,2025/01/1", "@ZAX0$"),
        (b"@AW\x24", "@ZAWF$"),
    ):
        boat(world).send(cut)
        yield from world.wait(0.4)
        order(world, word)
        yield from world.wait(1)
    yield from world.rest(150)


SCENES: tuple[Scene, ...] = (
    Scene(
        "relays-in-legs",
        "the set has rank over relays",
        relays_in_legs,
        (reached(), home(150), legs(*SETS)),
    ),
    Scene("three-boats", "X and W have rank over all", three_boats, (*LIGHT, upward_within(1))),
    Scene("quarrel", "X and W leave as they are said", quarrel, LIGHT),
    Scene(
        "w-again-and-again-heavy",
        "behind each W comes the way that is in use",
        w_again_and_again(-5.0),
        LIFTED,
    ),
    *[
        Scene(f"two-sticks-{name}", "a stick was never still for 2 s", two_sticks(frame), OWNED)
        for name, frame in (("neutral", "@MMF0$"), ("held", "@MMD5$"))
    ],
    Scene("stick-against-x", "a held stick takes nothing over", stick_against_x, OWNED),
    Scene(
        "taken-over",
        "2 s of stillness, and a push: the stick has it, until it is let go",
        taken_over,
        (*LIGHT, word_within("@MMU10", 1, "stick")),
    ),
    Scene(
        "stick-by-modem",
        "an M by modem is none",
        stick_by_modem,
        (*LIGHT, CALM, never("^@M", "strange", "the stick needs the network")),
        world=WET,
    ),
    Scene(
        "copies-in-ascent",
        "none changes anything",
        copies_in_ascent,
        (*LIGHT, never("@ZA[SHFD]", "due", "no mission")),
        world=WET,
    ),
    Scene(
        "late-stop-heavy",
        "an X counts always; it has not risen in 20 s",
        late_stop,
        LIFTED,
        world=WET,
    ),
    Scene(
        "both-paths",
        "what comes twice is done once",
        both_paths,
        (*LIGHT, CALM, noted("start=A")),
        world=WET,
    ),
    Scene(
        "foreign-answers",
        "what a vehicle says is no command",
        foreign_answers,
        (*LIGHT, CALM, never("@Z", "strange", "nobody asked for it", "calm")),
        world=WET,
    ),
    *[
        Scene(
            f"noise-at-pace-{name}",
            "X and W are found in whatever comes",
            noise_at_pace(gap, word),
            (reached(), home(150), passed(3.0), never_deeper(16), lives()),
            world=WET,
        )
        for name, gap, word in (("w", 0.01, "@ZAWF$"), ("x", 0.03, "@ZAX0$"))
    ],
    Scene("cut-in-a-line", "a new start byte begins anew", cut_in_a_line, LIGHT),
)
