"""Scenes of what was taken for safe: what sinks where no depth tells, boards that begin anew below a hull that
they hold up, sticks that nobody is left to miss, stops said again and again, depths that failed before the dive.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator

from tests.sea import faults
from tests.sea.laws import (
    HELD,
    UPWARD,
    Law,
    home,
    lives,
    never_deeper,
    noted,
    passed,
    quiet,
    reached,
    said,
    upward_within,
)
from tests.sea.leftovers import LIFTED, crash, silent, tells
from tests.sea.nuisances import Sluggish
from tests.sea.pairs import TROUBLES
from tests.sea.relapses import held_up_after_w
from tests.sea.scene import TRUE_FIXES, NoDive, Scene, Script, boat, dive, go, order
from tests.sea.stm32 import Board
from tests.sea.world import World

Steps = Iterator[None]
FROZEN = 0.11  # m, what a depth says that stands still
PATIENCE = 20.0  # s that an X has (R7)

WAITS = """
    mission waits vehicle auv
    home 30.2874595 120.1535765
    safety radius 900 time 40min depth 10
    down: depth 5 heading 90 gear 4 until depth >= 4.4 held 4s timeout 4min
    up: surface for 4min
"""
OVER = """
    mission over vehicle auv
    home 30.2874595 120.1535765
    safety radius 900 time 40min depth 10
    down: depth 5 heading 90 gear 4 until depth >= 4.4 held 4s timeout 4min
    up: surface until fix timeout 5min
"""
FOLLOWS = """
    mission follows vehicle auv
    home 30.2874595 120.1535765
    safety radius 900 time 40min depth 12
    assume floor 14
    out: altitude 4 heading 90 gear 4 for 4min timeout 5min else up
    up: surface until fix timeout 3min
"""


def frozen(_now: float, _truth: float) -> float:
    """The same to the last bit."""
    return FROZEN


def mute_heavy(world: World) -> Steps:
    """No depth and no report any more; 1.5 N too heavy: let go as fixes prove the surface, it sinks unseen."""
    yield from dive(world)
    tells(world, silent)
    world.body.buoyancy = -1.5
    world.board.mute = True
    yield from world.until(lambda: world.body.depth < 0.3, 200)
    world.mark("due")
    yield from world.wait(500)


def clears(world: World, within: float = 400.0) -> Steps:
    """`@AC$` each second, until it is obeyed."""
    end, letter = world.now + within, ""
    while letter != "C" and world.now < end:
        yield from world.wait(1)
        letter = yield from boat(world).ask("@AC$", "AC", 2)
    world.notes.append(f"cleared={letter}")


def cleared_afloat(heavy: float, troubles: str = "") -> Script:
    """Home by W without a depth, and cleared as soon as it is up: just then it takes in water."""

    def script(world: World) -> Steps:
        yield from dive(world)
        tells(world, silent)
        boat(world).send("@ZAWF$")
        yield from clears(world)
        world.mark("due")
        world.body.buoyancy = heavy
        for name in troubles.split():
            TROUBLES[name](world)
        yield from world.wait(200)

    return script


def over_blind(world: World) -> Steps:
    """The mission is over at the surface; the depth is silent, and 3 s later it takes in water."""
    yield from go(world, OVER)
    yield from world.until(lambda: world.body.depth > 4.0, 120)
    yield from world.rest(120, 9)
    tells(world, silent)
    yield from world.wait(3)
    world.mark("due")
    world.body.buoyancy = -1.5
    yield from world.wait(200)


def begins_anew(world: World, away: float) -> Steps:
    """The board has begun anew, all at rest; `away`: its port is away meanwhile, s."""
    world.board.restart()
    if away:
        world.line.vanish()
        yield from world.wait(away)
        world.line.come_back()
    world.mark("due")


def held_blind(away: float, troubles: str = "") -> Script:
    """Without a depth and 1.5 N too heavy it is held up by thrust at last; then the board begins anew."""

    def script(world: World) -> Steps:
        yield from dive(world)
        tells(world, silent)
        world.body.buoyancy = -1.5
        yield from world.held(900)
        for name in troubles.split():
            TROUBLES[name](world)
        yield from begins_anew(world, away)
        yield from world.wait(220)

    return script


def held_then_anew(blind: bool, away: float) -> Script:
    """6 N too heavy it is held up behind a W; `blind`: then its depth is silent; then the board begins anew."""

    def script(world: World) -> Steps:
        yield from held_up_after_w(world)
        world.marks.pop("due")
        if blind:
            tells(world, silent)
        yield from world.wait(5)
        yield from begins_anew(world, away)
        yield from world.wait(200)

    return script


def held_then_anew_twice(world: World) -> Steps:
    """Held up behind a W, its depth silent and 12 N too heavy; then the board begins anew twice: the word that holds
    it up seems to turn nothing, and the other one lasts 0.2 s as built."""
    yield from held_up_after_w(world)
    world.marks.pop("due")
    world.body.buoyancy = -12.0
    tells(world, silent)
    yield from world.wait(5)
    yield from begins_anew(world, 0)
    yield from world.wait(4.5)
    yield from begins_anew(world, 0)
    yield from world.wait(400)


def waits_and_sinks(world: World) -> Steps:
    """The mission's last leg waits at the surface for 4 min; before its end it sinks, as slowly as what leaks does."""
    began = yield from _waits(world)
    yield from world.until(lambda: world.now > began + 208, 240)
    world.body.buoyancy = -0.12
    yield from world.until(lambda: world.now > began + 239, 240)
    world.notes.append(f"sunk={world.body.depth > 0.8}")
    world.mark("due")
    yield from world.wait(260)


def waits_and_leaks_early(world: World) -> Steps:
    """The same soon behind its ascent: it is not to wait for the leg's end."""
    yield from _waits(world)
    world.body.buoyancy = -0.12
    yield from world.until(lambda: world.body.depth > 1.8, 120)
    world.mark("due")
    yield from world.wait(300)


def _waits(world: World) -> Generator[None, None, float]:
    """s: when the leg's ascent began, which is over."""
    yield from go(world, WAITS)
    yield from world.until(lambda: world.body.depth > 4.0, 120)
    yield from world.until(lambda: world.body.depth < 0.5, 120)
    yield from world.wait(12)
    return said(world, "@ZAWF", world.marks["go"])[0].at


def stick(world: World, frame: str, seconds: float) -> Steps:
    """The stick, held for so long."""
    end = world.now + seconds
    while world.now < end:
        boat(world).send(frame)
        yield from world.wait(0.3)


def dives_by_stick(world: World, depth: float) -> Steps:
    """No mission: the stick leads down to a depth."""
    end = world.now + 120
    while world.body.depth < depth and world.now < end:
        boat(world).send("@MMD8$")
        yield from world.wait(0.3)
    if world.body.depth < depth:
        raise NoDive(f"{world.body.depth:.1f} m by the stick")


def stick_killed(heavy: float, after: float) -> Script:
    """The stick leads down and rests; the radio is gone, and so long after it the program crashes."""

    def script(world: World) -> Steps:
        world.operator()
        yield from world.wait(16)
        yield from dives_by_stick(world, 7.5)
        world.body.buoyancy = 0.0
        yield from stick(world, "@MMF0$", 12)
        world.body.buoyancy = heavy
        boat(world).close()
        yield from world.wait(after)
        yield from crash(world)
        world.mark("due")
        yield from world.held(300)

    return script


def stick_over(sinks: bool) -> Script:
    """A depth that stands still from on deck; the stick leads down (`sinks`: it rests, and 2 N are too much) and
    rests there; the radio is gone for good.
    """

    def script(world: World) -> Steps:
        world.operator()
        yield from world.wait(16)
        tells(world, frozen)
        yield from world.wait(6)
        if sinks:
            world.body.buoyancy = -2.0
            yield from stick(world, "@MMF0$", 70)
        else:
            yield from dives_by_stick(world, 7.5)
        world.body.buoyancy = 0.0
        yield from stick(world, "@MMF0$", 12)
        world.notes.append(f"dived={world.body.depth > 6}")
        boat(world).close()
        world.mark("due")
        yield from world.wait(360)

    return script


def x_again(world: World) -> Steps:
    """X at 8 m, where it hovers; whenever an ascent begins by itself, X again: five times, and then no more."""
    yield from dive(world)
    world.body.buoyancy = 0.0
    for count in range(6):
        boat(world).send("@ZAX0$")
        world.mark(f"X{count}")
        if count < 5:
            begin = world.now + 0.1
            yield from world.until(lambda begin=begin: bool(said(world, UPWARD, begin)), 60)
    world.mark("due")
    yield from world.rest(200)


def x_behind_a_stick(world: World) -> Steps:
    """The stick leads down at full speed, and X: it goes on down for a second, and floats up by itself."""
    world.operator()
    yield from world.wait(16)
    yield from dives_by_stick(world, 6.0)
    order(world, "@ZAX0$")
    yield from world.rest(120)


def follows(lie: faults.Lie, after: float) -> Script:
    """From the surface down to 4 m above the bottom, which is deeper than it was said to be; the depth fails
    `after` s behind the start. Negative: it had so long on deck, and fails before it; 0: it never was right.
    """

    def script(world: World) -> Steps:
        world.operator("first")
        yield from world.wait(max(0.0, -after))
        if after <= 0:
            tells(world, lie)
        world.operators.pop().close()
        yield from go(world, FOLLOWS)
        if after > 0:
            yield from world.wait(after)
            world.notes.append(f"afloat={world.body.depth < 0.4}")
            tells(world, lie)
        yield from world.until(lambda: world.body.depth > 2, 60)
        world.notes.append(f"dived={world.body.depth > 2}")
        world.mark("due")
        yield from world.rest(560)

    return script


def each_x_rests(world: World) -> str:
    """No upward word for `PATIENCE` s behind each X of the operator's."""
    for name, at in world.marks.items():
        early = said(world, UPWARD, at + 0.3, at + PATIENCE - 0.5) if name.startswith("X") else []
        if early:
            return f"{early[0].text} {early[0].at - at:.1f} s after {name}"
    return ""


def stays(depth: float) -> Law:
    """From `due` on never deeper than this."""

    def law(world: World) -> str:
        worst = max(
            (s.depth for s in world.samples if s.at >= world.marks.get("due", 1e9)), default=0.0
        )
        return f"{worst:.1f} m deep behind due, {depth:.1f} m allowed" if worst > depth else ""

    return law


BLIND: tuple[Law, ...] = (reached(), home(1, 4.0, off=False), stays(16.0), lives())
HOLDS: tuple[Law, ...] = (
    reached(),
    home(1, HELD, off=False),
    stays(1.0),
    upward_within(5),
    lives(),
)
LOST_FIXES: tuple[Law, ...] = (
    reached(),
    home(120, HELD, off=False),
    stays(5.0),  # where its fixes had ended, too, each way has its turn (R7)
    upward_within(5),
    lives(),
)
NO_DEPTH: tuple[Law, ...] = (
    reached(),
    home(400),
    never_deeper(18),
    noted("start=A"),
    noted("dived=True"),
    lives(),
)
FLOATS: tuple[Law, ...] = (reached(), home(60), quiet("due"), passed(), lives())
UNSEEN = (
    "without a depth, with reports or without, it sinks when the fixes end that proved the surface"
)
HOLDING = "the thrust that holds it up is said again when it shows no more, or its port was away"
LEFT = "what the stick had when the program began again is brought up, once it is deep for 20 s"
STANDS = "a forgotten stick believes no depth that has stood still since before it"
PATIENT = "every X has its 20 s"
LED = "what the stick led down is no descent when it ends"
UNKNOWN = (
    "a dive without a depth to believe is ended, whatever the depth was when it was last believed"
)
DOCUMENTED = {"built": False}
SCENES: tuple[Scene, ...] = (
    Scene("mute-blind-heavy", UNSEEN, mute_heavy, BLIND, world=TRUE_FIXES),
    *[
        Scene(
            name,
            UNSEEN,
            cleared_afloat(heavy, troubles),
            (*BLIND, noted("cleared=C")),
            world=TRUE_FIXES,
            make=kind,
        )
        for name, heavy, troubles, kind in (
            ("cleared-blind-afloat", -1.0, "", Board),
            ("cleared-blind-afloat-sluggish", -1.5, "sliders", Sluggish),
            ("cleared-blind-afloat-gappy", -1.5, "gaps", Board),
        )
    ],
    Scene("over-blind-heavy", UNSEEN, over_blind, BLIND, world=TRUE_FIXES),
    *[
        Scene(name, HOLDING, held_blind(away, troubles), HOLDS, world=TRUE_FIXES, make=kind)
        for name, away, troubles, kind in (
            ("held-blind-browned-out", 0, "", Board),
            ("held-blind-away", 2.5, "", Board),
            ("held-blind-browned-sluggish", 0, "sliders", Sluggish),
            ("held-blind-away-relays", 2.5, "relays", Board),
        )
    ],
    *[
        Scene(name, HOLDING, held_then_anew(blind, away), laws, world=TRUE_FIXES)
        for name, blind, away, laws in (
            ("held-w-browned-out", False, 0, HOLDS),
            ("held-w-away", False, 2.5, HOLDS),
            ("held-w-blind-browned-out", True, 0, HOLDS),
            ("held-w-blind-away", True, 2.5, HOLDS),
            ("held-w-blind-away-longer", True, 7, LOST_FIXES),
        )
    ],
    Scene(
        "held-w-blind-browned-out-twice",
        "without a depth it is lifted by the word that last showed a thruster on",
        held_then_anew_twice,
        (reached(), home(120, HELD, off=False), stays(8.0), upward_within(5), lives()),
        world=TRUE_FIXES,
    ),
    *[
        Scene(
            f"waits-and-leaks-{floor:.0f}-m",
            "what proved the surface counts for 6 s: what sinks as it waits there is lifted first",
            waits_and_sinks,
            (*LIFTED, noted("sunk=True"), upward_within(4)),
            {"floor": floor},
        )
        for floor in (5.0, 40.0)
    ],
    Scene(
        "waits-and-leaks-early",
        "a leg that waits at the surface is watched for sinking as at rest",
        waits_and_leaks_early,
        (*LIFTED, never_deeper(6), upward_within(12)),
        {"floor": 40.0},
    ),
    *[
        Scene(
            name,
            LEFT,
            stick_killed(heavy, after),
            (*LIFTED, upward_within(28)),
            body={"floor": 12.0},
            board=board,
        )
        for name, heavy, after, board in (
            ("stick-killed-hovering", 0.0, 12, {}),
            ("stick-killed-heavy", -3.0, 12, {}),
            ("stick-killed-at-once", 0.0, 1, {}),
            ("stick-killed-documented", 0.0, 12, DOCUMENTED),
        )
    ],
    *[
        Scene(
            name,
            STANDS,
            stick_over(sinks),
            (
                *(reached(), noted("dived=True"), home(300, 4.0, off=False)),
                *(upward_within(66), lives()),
            ),
            {},
            board,
            TRUE_FIXES,
        )
        for name, sinks, board in (
            ("stick-over-frozen", False, {}),
            ("stick-over-frozen-sinks", True, {}),
            ("stick-over-frozen-documented", True, DOCUMENTED),
        )
    ],
    *[
        Scene(
            name,
            PATIENT,
            x_again,
            (reached(), home(120, HELD, off=False), each_x_rests, passed(), lives()),
            board=board,
        )
        for name, board in (
            ("x-against-each-ascent", {}),
            ("x-against-each-documented", DOCUMENTED),
        )
    ],
    Scene("stick-dive-x-documented", LED, x_behind_a_stick, FLOATS, board=DOCUMENTED),
    *[
        Scene(
            f"follows-{name}",
            UNKNOWN,
            follows(lie, after),
            NO_DEPTH,
            {"floor": 28.0},
            world=TRUE_FIXES,
        )
        for name, lie, after in (
            ("frozen-on-deck", frozen, -18.0),
            ("frozen-since-ever", frozen, 0.0),
            ("frozen-afloat", frozen, 1.0),
            ("silent-afloat", silent, 1.0),
        )
    ],
)
