"""Scenes with several operators, late copies of words, and noise on the modem."""

from __future__ import annotations

import signal
from collections.abc import Iterator

from tests.sea.ascents import STAIRS
from tests.sea.laws import home, never, passed, quiet, reached, upward_within
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, go, mission
from tests.sea.world import World

Steps = Iterator[None]
OWNED = (*LIGHT, never("^@M", "due", "an emergency is under way"))


def stick(frame: str, every: float, restart: bool = False) -> Script:
    """A stick is held on one connection; another orders W and is gone."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.spawn(boat(world).repeat(frame, every))
        yield from world.wait(1)
        other = world.operator("other")
        yield from world.wait(0.2)
        other.send("@ZAWF$")
        yield from world.wait(0.3)
        world.mark("due")
        yield from world.wait(0.7)
        other.close()
        if restart:
            world.pi.signal(signal.SIGKILL)
        yield from world.wait(150)

    return script


def neutral_after_silence(world: World) -> Steps:
    """W from another who is gone; 12 s later a program begins to repeat a neutral stick."""
    yield from dive(world)
    other = world.operator("other")
    yield from world.wait(0.2)
    other.send("@ZAWF$")
    yield from world.wait(0.3)
    world.mark("due")
    other.close()
    yield from world.wait(12)
    world.spawn(boat(world).repeat("@MMF0$", 0.3))
    yield from world.wait(140)


def late_start(world: World) -> Steps:
    """A copy of the start comes by modem when the mission is over."""
    yield from go(world, STAIRS.replace("for 15s", "for 2s").replace("for 20s", "for 2s"))
    began = world.marks.get("go", world.now)
    yield from world.wait(20)
    world.mark("due")
    assert world.acoustic
    yield from world.until(lambda: world.now > began + 60, 100)
    world.mark("copy")
    world.acoustic.send("@AA$")
    yield from world.wait(60)


def late_limit(world: World) -> Steps:
    """A copy of the old limits comes by modem after the new ones."""
    yield from go(world, mission(20, 30))
    assert world.acoustic
    first, second = "@SP,900,40,30,10,$", "@SP,900,40,10,10,$"
    yield from boat(world).ask(first, "SP")
    yield from boat(world).ask(second, "SP")
    yield from world.wait(3)
    world.acoustic.send(first)
    yield from world.until(lambda: world.body.depth > 11.3, 100)
    world.mark("due")
    yield from world.rest(180)


def noisy_modem(world: World) -> Steps:
    """A false header now and then and a byte each 0.7 s; among them a W."""
    yield from dive(world)
    assert world.acoustic
    acoustic = world.acoustic

    def noise() -> Steps:
        due, count = world.now, 0
        while True:
            if world.now >= due:
                head = b"\x23\x02\x80\x0c\x01"  # 3200 bytes are to come
                acoustic.noise(head if count % 8 == 0 else bytes([0x41 + count % 20]))
                due, count = due + 0.7, count + 1
            yield

    world.spawn(noise())
    yield from world.wait(10)
    acoustic.send("@ZAWF$")
    yield from world.wait(acoustic.delay)
    world.mark("due")
    yield from world.rest(150)


WET = {"modem": True}
SCENES: tuple[Scene, ...] = (
    Scene("held-stick", "a held stick takes nothing over", stick("@MMD6$", 0.3), OWNED),
    Scene("neutral-stick", "a neutral stick takes nothing over", stick("@MMF0$", 0.3), OWNED),
    Scene("held-stick-restart", "nor after a restart", stick("@MMD6$", 0.3, restart=True), OWNED),
    Scene(
        "neutral-after-silence",
        "a neutral M never takes an emergency over",
        neutral_after_silence,
        OWNED,
    ),
    Scene(
        "late-start",
        "the copy meets a mission that was started once",
        late_start,
        (reached(), quiet("copy")),
        world=WET,
    ),
    Scene(
        "late-limit", "the copy loosens nothing", late_limit, (*LIGHT, upward_within(6)), world=WET
    ),
    Scene(
        "noisy-modem",
        "X and W are found in whatever comes",
        noisy_modem,
        (reached(), home(150), passed(3.0)),
        world=WET,
    ),
)
