"""Scenes of what is believed and of who commands, two and three troubles at a time; on other boards, too."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator

from tests.sea import faults
from tests.sea.boards import CORE, FAINT, FLOAT, ROBOT, ROV, TETHER, TUNED, under_way
from tests.sea.laws import (
    HELD,
    UPWARD,
    Law,
    home,
    lives,
    never,
    never_deeper,
    noted,
    off_within,
    reached,
)
from tests.sea.nuisances import gaps
from tests.sea.others import CoreBoard, Robot, Rov
from tests.sea.scene import LIGHT, TRUE_FIXES, Scene, Script, boat, dive, go, mission, order
from tests.sea.world import World
from tests.sea.wrecks import BACK

Steps = Iterator[None]
LIFTED: tuple[Law, ...] = (reached(), home(300, HELD, off=False), never_deeper(22), lives())
LAND: dict[str, object] = {"vehicle": "robot", "baud": 115200, "gps": False}


def dead_depth(buoyancy: float, over: bool = False) -> Script:
    """The depth is silent for ever, the trim is another, and the vehicle may turn over."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.board.senses.depth = lambda _now, _truth: math.nan
        world.body.buoyancy = buoyancy
        if over:
            world.body.turn_over()
        world.mark("due")
        yield from world.wait(300)

    return script


def over_killed(world: World) -> Steps:
    """It turns over at depth, and the program crashes 8 s later."""
    yield from dive(world)
    world.body.turn_over()
    world.mark("due")
    yield from world.wait(8)
    world.pi.signal(signal.SIGKILL)
    yield from world.rest(230)


def swell(world: World) -> Steps:
    """W; at the surface the pressure swings by 0.8 m with the swell."""
    yield from dive(world)
    world.board.senses.depth = lambda now, truth: truth + 0.8 * math.sin(now / 1.3)
    order(world, "@ZAWF$")
    yield from world.rest(230)


def more_by_a_metre(world: World) -> Steps:
    """From depth on the sensor tells 1.1 m too much, at the surface, too."""
    yield from dive(world)
    world.board.senses.depth = faults.shifted(1.1)
    order(world, "@ZAWF$")
    yield from world.rest(260)


def wild_altimeter(world: World) -> Steps:
    """The altimeter tells full-scale garbage; everything else is well."""
    yield from dive(world, stay="60s")
    world.board.senses.altitude = faults.garbage(world.seed, 30.0)
    world.mark("garbage")
    yield from world.wait(45)
    world.mark("calm")
    yield from world.wait(25)
    world.mark("due")
    yield from world.rest(120)


def yesterday(world: World) -> Steps:
    """At power-up the receiver tells of a place 3 km off, then of the true one."""
    yield from go(world, mission(8, 10))
    world.mark("due")
    assert world.receiver
    world.receiver.mode = "honest"
    yield from world.wait(20)
    letter = yield from boat(world).ask("@AA$", "AA")
    world.notes.append(f"later={letter}")
    yield from world.until(lambda: world.body.depth > 7, 60)
    boat(world).send("@ZAWF$")
    world.receiver.mode = "yesterday"
    yield from world.rest(200)


def clogged(at: float, seen: float, stay: float) -> Script:
    """Asked for 8 m: the port closes at that depth, and is to be noticed in so many seconds."""

    def script(world: World) -> Steps:
        yield from go(world, mission(8, 10))
        yield from world.until(lambda: world.body.depth > at, 120)
        world.board.senses.depth = faults.clogged(at, world.seed)
        yield from world.wait(seen)
        world.mark("due")
        yield from world.rest(stay)

    return script


def late_node(world: World) -> Steps:
    """AUTO closed and opened on deck; a copy of the closing comes by modem, 90 s late, at depth."""
    operator = world.operator()
    yield from world.wait(16)
    for frame in ("@NSOOOOCC$", "@NSOOOOCO$"):
        letter = yield from operator.ask(frame, "NS", 8)
        world.notes.append(f"nodes={letter}")
    asked = world.now
    world.operators.clear()
    operator.close()
    yield from dive(world, stay="2min")
    yield from world.until(lambda: world.now > asked + 90, 90)
    assert world.acoustic
    world.mark("copy")
    world.acoustic.send("@NSOOOOCC$")
    yield from world.wait(15)
    world.mark("calm")
    order(world, "@ZAWF$")
    yield from world.rest(150)


def late_clear(world: World) -> Steps:
    """An emergency cleared at the surface; a copy of the clear comes when the next is under way."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(70)
    letter = yield from boat(world).ask("@AC$", "AC")
    world.notes.append(f"clear={letter}")
    boat(world).send("@ZAWF$")
    yield from world.wait(70)
    assert world.acoustic
    world.acoustic.send("@AC$")
    yield from world.wait(8)
    world.mark("due")
    world.acoustic.send("@AA$")
    yield from world.wait(25)


def board_gaps(text: str, frame: str, buoyancy: float) -> Script:
    """No report for 9 s of each 20 s; a word, and another trim with it."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "6min")
        world.spawn(gaps(world))
        order(world, frame)
        world.body.buoyancy = buoyancy
        yield from (world.wait(300) if buoyancy < 0 else world.rest(220))

    return script


def board_killed(text: str, buoyancy: float) -> Script:
    """A crash under water, and another 40 s later; too heavy from the first one on."""

    def script(world: World) -> Steps:
        yield from under_way(world, text, "6min")
        world.mark("due")
        world.body.buoyancy = buoyancy
        world.pi.power_cut()
        yield from world.wait(40)
        world.pi.power_cut()
        yield from world.wait(240)

    return script


def clogs(text: str, told: float) -> Script:
    """On the way down the port closes at this depth. Nothing proves the surface then: the thrusters
    go on. `down 6` is half the thrust, which may hold a light body: `check` says 50.3 m.
    """

    def script(world: World) -> Steps:
        yield from go(world, text.replace("{stay}", "6min"))
        yield from world.until(lambda: world.body.depth > told, 120)
        world.board.senses.depth = faults.clogged(told, world.seed)
        yield from world.wait(25)
        world.mark("due")
        yield from world.rest(260)

    return script


def over_and_leaking(world: World) -> Steps:
    """It turns over, and its leak flickers: two of five reports."""
    yield from under_way(world, CORE, "6min")
    count = 0

    def bit(_now: float, _truth: float) -> float:
        nonlocal count
        count += 1
        return 1.0 if count % 5 < 2 else 0.0

    world.board.senses.leak = bit
    world.body.turn_over()
    world.mark("due")
    yield from world.rest(260)


def robot_trouble(what: str) -> Script:
    """The robot drives; its reports end, or the program does."""

    def script(world: World) -> Steps:
        yield from go(world, ROBOT.replace("20s", "60s"))
        yield from world.wait(8)
        world.mark("due")
        if what == "mute":
            world.board.mute = True
        else:
            world.pi.power_cut()
        yield from world.wait(30)

    return script


SCENES: tuple[Scene, ...] = (
    Scene(
        "no-depth-neutral",
        "the thrusters lift it; a fix ends it",
        dead_depth(0.3),
        BACK,
        world={"receiver_mode": "wandering"},
    ),
    Scene(
        "no-depth-heavy",
        "25 N of thrust lift 4 N of weight, which sinks in the turns of the others: within 4 m, for ever",
        dead_depth(-4.0),
        (reached(), home(300, 4.0, off=False), never_deeper(30), lives()),
        world=TRUE_FIXES,
    ),
    Scene("no-depth-over", "let go it rises", dead_depth(8.0, over=True), BACK),
    Scene("over-killed", "let go it rises, before and after a crash", over_killed, BACK),
    Scene("swell", "a fix ends what no steady depth does", swell, BACK),
    Scene(
        "metre-too-much",
        "fixes as at the surface, and it rises no more",
        more_by_a_metre,
        (reached(), home(260), never_deeper(16), lives()),
    ),
    Scene(
        "wild-altimeter",
        "garbage contradicts nothing",
        wild_altimeter,
        (*LIGHT, never(UPWARD.pattern, "garbage", "a false alarm", "calm")),
    ),
    Scene(
        "yesterdays-place",
        "home is farther than the radius; a believed depth contradicts fixes",
        yesterday,
        (reached(), noted("start=N"), noted("later=A"), home(200), never_deeper(16)),
        world={"receiver_mode": "yesterday"},
    ),
    Scene(
        "clogged-in-current",
        "full push for 20 s moves no depth",
        clogged(6.5, 25, 230),
        BACK,
        body={"current": (0.2, -0.15), "buoyancy": 4.0},
        world={"receiver_mode": "alternating"},
    ),
    *(
        Scene(
            f"clogged-as-it-dives-{mode}",
            "places said again are none; full push for 20 s moves no depth",
            clogged(0.4, 40, 260),
            BACK,
            world={"receiver_mode": mode},
        )
        for mode in ("stuck", "cycling", "ring")
    ),
    Scene(
        "late-node",
        "the copy closes nothing",
        late_node,
        (*LIGHT, noted("nodes=S"), never("@ZA[XWU]", "copy", "a copy ends a mission", "calm")),
        world={"modem": True},
    ),
    Scene(
        "late-clear",
        "an emergency that came since is not cleared by a copy",
        late_clear,
        (reached(), noted("clear=C"), never("@ZA[SHFD]", "due", "no mission"), home(1)),
        world={"modem": True},
    ),
    Scene(
        "core-over-leaking",
        "let go it rises",
        over_and_leaking,
        (reached(), home(260), lives()),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-killed-twice-heavy",
        "each start surfaces",
        board_killed(CORE, -4.0),
        LIFTED,
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-gappy-heavy-x",
        "it has not risen in 20 s",
        board_gaps(CORE, "@ZAX0$", -4.0),
        LIFTED,
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "core-clogged",
        "a push in vain is noticed",
        clogs(CORE, 3.0),
        (reached(), home(230, off=False), never_deeper(16), lives()),
        FLOAT,
        {},
        TUNED,
        CoreBoard,
    ),
    Scene(
        "rov-killed-twice-heavy",
        "each start surfaces",
        board_killed(ROV, -3.0),
        LIFTED,
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "rov-gappy-heavy-w",
        "the depth between the gaps falls",
        board_gaps(ROV, "@ZAWF$", -3.0),
        LIFTED,
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    Scene(
        "rov-clogged",
        "a push in vain is noticed",
        clogs(ROV, 3.0),
        (reached(), home(260, off=False), never_deeper(50.3), lives()),
        FAINT,
        {},
        TETHER,
        Rov,
    ),
    *[
        Scene(
            f"robot-{what}",
            "what drives is stopped",
            robot_trouble(what),
            (reached(), off_within(9), lives()),
            {},
            {},
            LAND,
            Robot,
        )
        for what in ("mute", "killed")
    ],
)
