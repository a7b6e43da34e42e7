"""Scenes of lines and boards with habits: they echo, double, answer late or not at all, hear nothing for a while."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tests.sea.channels import CALM, strange
from tests.sea.laws import held_up, home, lives, never_deeper, reached
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, order
from tests.sea.stm32 import Board
from tests.sea.world import World
from tests.sea.wrecks import LIFTED

Steps = Iterator[None]


class Echoing(Board):
    """Its line returns what the program writes."""

    def hear(self, now: float, data: bytes) -> None:
        super().hear(now, data)
        if data:
            self.line.send(now, data)


class Doubling(Board):
    """Its reports come twice."""

    def report(self, now: float) -> bytes:
        return super().report(now) * 2


class Splicing(Board):
    """An acknowledgement that is due within 0.3 s of a report lands in its midst, each time."""

    def _answer(self, now: float, data: bytes) -> None:
        super()._answer(now, data)
        if self.next_report - now < 0.3:
            self.acks[-1] = (self.next_report, data)

    def tick(self, now: float) -> None:
        due = [ack for at, ack in self.acks if at <= now]
        if not due or now < self.next_report or self.mute:
            super().tick(now)
            return
        self.acks = [(at, ack) for at, ack in self.acks if at > now]
        self.next_report = now + self.period
        report, cut = self.report(now), self.random.randrange(3, 80)
        self.line.send(now, report[:cut] + b"".join(due) + report[cut:])


class Unheard(Board):
    """Its acknowledgements are lost for a while; its reports are not."""

    lost_until = 0.0

    def _answer(self, now: float, data: bytes) -> None:
        if now >= self.lost_until:
            super()._answer(now, data)


def under(heavy: float | None = None) -> Script:
    """A dive on a line of other habits, and W, with another trim."""

    def script(world: World) -> Steps:
        yield from dive(world, stay="90s")
        if heavy is None:
            yield from strange(world)
            return
        order(world, "@ZAWF$")
        world.body.buoyancy = heavy
        yield from world.held(210)

    return script


def coarse(step: float) -> Script:
    """The depth is told in steps, as cheap sensors do."""

    def script(world: World) -> Steps:
        world.board.senses.depth = lambda _now, truth: round(truth / step) * step
        yield from dive(world, stay="90s")
        yield from strange(world)

    return script


def never_reads(world: World) -> Steps:
    """The commander asks a hundred times a second and reads no answer; another says W by a thin line."""
    yield from dive(world)
    boat(world).reads = False
    world.spawn(boat(world).repeat("@DU$@AQ$@NI$", 0.01, until=world.now + 60))
    yield from world.wait(30)
    other = world.operator("other")
    yield from world.wait(0.5)
    other.send("@ZAWF$")
    world.mark("due")
    yield from world.rest(150)


def swell_heavy(world: World) -> Steps:
    """W, 6 N too heavy; from 3 m on the pressure swings by 0.6 m with the swell."""
    yield from dive(world)
    order(world, "@ZAWF$")
    world.body.buoyancy = -6.0
    yield from world.until(lambda: world.body.depth < 3.0, 120)
    world.board.senses.depth = lambda now, truth: truth + 0.6 * math.sin(now / 1.1)
    yield from world.held(250)


def nothing_but_garbage(world: World) -> Steps:
    """Every number of every report is NaN from the W on; 8 N light."""
    yield from dive(world)
    order(world, "@ZAWF$")
    senses = world.board.senses
    for name in ("depth", "altitude", "heading", "roll", "pitch"):
        setattr(senses, name, lambda _now, _truth: math.nan)
    yield from world.rest(260)


def unanswered(world: World) -> Steps:
    """From X on no acknowledgement comes for 60 s, and 4 N are too much."""
    yield from dive(world)
    world.board.lost_until = world.now + 60
    order(world, "@ZAX0$")
    world.body.buoyancy = -4.0
    yield from world.held(240)


def deaf_at_w(seconds: float, buoyancy: float) -> Script:
    """The board hears nothing for some seconds from the W on, and goes on holding its depth."""

    def script(world: World) -> Steps:
        yield from dive(world)
        order(world, "@ZAWF$")
        world.board.deaf_until = world.now + seconds
        yield from world.wait(seconds)
        world.body.buoyancy = buoyancy
        yield from (world.held(200) if buoyancy < 0 else world.rest(200))

    return script


SCENES: tuple[Scene, ...] = (
    Scene("echo", "its own words are no answers", under(), (*LIGHT, CALM), make=Echoing),
    Scene("echo-heavy", "nor in an ascent", under(heavy=-5.0), LIFTED, make=Echoing),
    Scene("doubled-reports", "a copy is no frozen sensor", under(), (*LIGHT, CALM), make=Doubling),
    Scene("doubled-reports-heavy", "nor a rise", under(heavy=-5.0), LIFTED, make=Doubling),
    Scene(
        "half-rate",
        "a report each 4 s is less than 5 s old",
        under(),
        (*LIGHT, CALM),
        board={"period": 4.0},
    ),
    Scene("half-rate-heavy", "the depth falls", under(heavy=-5.0), LIFTED, board={"period": 4.0}),
    Scene(
        "unanswered-heavy-x", "what is not answered is said again", unanswered, LIFTED, make=Unheard
    ),
    Scene("spliced", "a splice costs no report", under(), (*LIGHT, CALM), make=Splicing),
    Scene("spliced-heavy", "nor an acknowledgement", under(heavy=-5.0), LIFTED, make=Splicing),
    Scene(
        "coarse-depth",
        "the same five times is frozen only while it moves",
        coarse(0.1),
        (*LIGHT, CALM),
    ),
    Scene("coarser-depth", "steps of half a metre still fall", coarse(0.5), LIGHT),
    Scene("never-reads", "who does not read holds nobody up", never_reads, LIGHT),
    Scene("swell-heavy", "held up in the swell", swell_heavy, LIFTED),
    Scene(
        "nothing-but-garbage",
        "fixes end it after the way up",
        nothing_but_garbage,
        (reached(), home(200), never_deeper(16), lives()),
    ),
    Scene(
        "deaf-at-w",
        "each way comes round again",
        deaf_at_w(12, 8.0),
        (reached(), home(150), held_up(), never_deeper(16), lives()),
    ),
    Scene("deaf-at-w-heavy", "each way comes round again", deaf_at_w(9, -5.0), LIFTED),
)
