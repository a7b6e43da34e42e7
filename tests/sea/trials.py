"""More trials: sensors that fail in other ways, boards that are mute or late, floods, sticks let go;
and what a careful program must still allow (a new start after an emergency, a dead sensor indoors).
"""

from __future__ import annotations

import signal
import socket
from collections.abc import Iterator

from tests.sea import faults
from tests.sea.laws import (
    HELD,
    UPWARD,
    Law,
    held_up,
    home,
    lives,
    never,
    never_deeper,
    noted,
    passed,
    quiet,
    reached,
    sinking_noticed,
    upward_within,
    word_within,
)
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, go, mission, order
from tests.sea.world import World

Steps = Iterator[None]
BACK: tuple[Law, ...] = (reached(), home(200), never_deeper(16), lives())


def clogged_on_deck(world: World) -> Steps:
    """The port is closed from the start: 0.1 m and noise, whatever the depth."""
    world.board.senses.depth = faults.clogged(0.1, world.seed)
    yield from go(world, mission(8, 10))
    yield from world.wait(30)
    world.mark("due")
    yield from world.rest(200)


def too_light(world: World) -> Steps:
    """Nobody has put the lead in: the verticals do not bring it under."""
    world.mark("go")
    yield from go(world, mission(8, 10))
    yield from world.wait(60)
    world.mark("due")
    yield from world.rest(120)


def clogged_then_w(world: World) -> Steps:
    """W at 8 m, where the reading stays: nothing tells of the rise but the fixes at its end."""
    yield from dive(world)
    world.board.senses.depth = faults.clogged(8.0, world.seed)
    order(world, "@ZAWF$")
    yield from world.rest(200)


def told_wrong(lie: str) -> Script:
    """At 8 m, held: the depth is garbage of full scale, or 6 s late, or silent for ever."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.board.senses.depth = {
            "garbage": faults.garbage(world.seed),
            "slow": faults.slow(6.0),
            "nan": lambda _now, _truth: float("nan"),
        }[lie]
        yield from world.wait(20)
        world.mark("due")
        if lie == "slow":
            boat(world).send("@ZAWF$")
        yield from world.rest(200)

    return script


def tumbling_sensor(world: World) -> Steps:
    """Roll and pitch of full scale, in turns: a sensor and not a body."""
    yield from dive(world, stay="60s")
    world.board.senses.roll = faults.garbage(world.seed, 1e9)
    world.board.senses.pitch = faults.garbage(world.seed + 1, 1e9)
    world.mark("garbage")
    yield from world.wait(45)
    world.mark("calm")
    yield from world.wait(25)
    world.mark("due")
    yield from world.rest(120)


def mute(world: World) -> Steps:
    """The board obeys, and reports nothing more."""
    yield from dive(world)
    world.board.mute = True
    world.mark("due")
    yield from world.rest(200)


def unplugged(world: World) -> Steps:
    """The line to the board is interrupted for 15 s, in which W is ordered."""
    yield from dive(world)
    world.line.plugged = False
    yield from world.wait(5)
    boat(world).send("@ZAWF$")
    yield from world.wait(10)
    world.line.plugged = True
    world.mark("due")
    yield from world.rest(180)


def let_go(buoyancy: float) -> Script:
    """Dived by the stick to 6 m; then the radio is gone."""

    def script(world: World) -> Steps:
        yield from dive(world, 5)
        end = world.now + 8
        world.spawn(boat(world).repeat("@MMD8$", 0.2, until=end))
        yield from world.wait(8)
        world.body.buoyancy = buoyancy
        world.mark("due")
        boat(world).close()
        yield from world.wait(260)

    return script


def flood(world: World) -> Steps:
    """One boat sends 600 frames a second and more, another fills the connections; then a W."""
    yield from dive(world)
    many = "@DU$@NI$@AQ$" * 2
    world.spawn(boat(world).repeat(many, 0.01, until=world.now + 12))
    idle = []
    for _ in range(40):
        line = socket.socket()
        line.setblocking(False)
        line.connect_ex(("127.0.0.1", world.port))
        idle.append(line)
    yield from world.wait(5)
    order(world, "@ZAWF$")
    yield from world.rest(150)
    for line in idle:
        line.close()


def hangup(world: World) -> Steps:
    """The terminal that serve was started from is gone."""
    yield from dive(world, stay="40s")
    world.pi.signal(signal.SIGHUP)
    world.mark("hangup")
    yield from world.wait(30)
    world.mark("calm")
    yield from world.wait(15)
    world.mark("due")
    yield from world.rest(120)


def auto_closed(world: World) -> Steps:
    """AUTO is closed on deck; somebody lets the vehicle down on its rope, too heavy to float."""
    operator = world.operator()
    yield from world.wait(16)
    letter = yield from operator.ask("@NSOOOCCC$", "NS", 8)
    world.notes.append(f"closed={letter}")
    world.mark("due")
    world.body.buoyancy = -6.0
    yield from world.wait(15)
    world.body.buoyancy = 8.0
    yield from world.wait(45)


def auto_and_copy(world: World) -> Steps:
    """AUTO closed by radio, opened, a new start; then the copy of the closing by modem."""
    yield from dive(world)
    assert world.acoustic
    world.acoustic.send("@NSOOOOCC$")
    yield from world.until(lambda: b"@ACK_NSS$" in world.acoustic.heard, 20)  # type: ignore[union-attr]
    answered = b"@ACK_NSS$" in world.acoustic.heard
    world.notes.append(f"closed={answered}")
    world.mark("due")
    yield from world.wait(120)


def once_more(world: World) -> Steps:
    """After an emergency: cleared at the surface, and the next mission is flown."""
    yield from dive(world)
    boat(world).send("@ZAWF$")
    yield from world.wait(90)
    letter = yield from boat(world).ask("@AC$", "AC")
    world.notes.append(f"clear={letter}")
    world.marks.pop("go", None)
    text = mission(8, 10, stay="20s").replace("down:", "assume start 200\n        down:", 1)
    letter = yield from boat(world).upload(text)  # it has swum and drifted since
    world.notes.append(f"second={letter}")
    yield from world.wait(5)
    letter = yield from boat(world).ask("@AA$", "AA")
    world.notes.append(f"start2={letter}")
    yield from world.wait(60)
    world.mark("due")
    yield from world.wait(120)


def dead_sensor_indoors(world: World) -> Steps:
    """A sensor of full scale on deck, a stop, and somebody who wants to go on."""
    world.board.senses.depth = faults.garbage(world.seed)
    operator = world.operator()
    yield from world.wait(16)
    operator.send("@ZAX0$")
    yield from world.wait(5)
    letter = yield from operator.ask("@AC$", "AC")
    yield from world.wait(10)
    if letter != "C":
        letter = yield from operator.ask("@AC$", "AC")
    world.notes.append(f"clear={letter}")
    world.mark("due")
    yield from world.wait(20)


def heavy_to_the_limit(world: World) -> Steps:
    """18 N too heavy from the W on."""
    yield from dive(world)
    world.body.buoyancy = -18.0
    order(world, "@ZAWF$")
    yield from world.wait(400)


def neutral(world: World) -> Steps:
    """No buoyancy left from the W on."""
    yield from dive(world)
    world.body.buoyancy = 0.3
    order(world, "@ZAWF$")
    yield from world.wait(180)


def noisy_line(world: World) -> Steps:
    """One byte of 500 from the board is wrong: every sixth report, some acknowledgements."""
    world.line.noise = 1 / 500
    yield from dive(world, stay="60s")
    yield from world.wait(40)
    world.mark("calm")
    yield from world.wait(25)
    world.mark("due")
    yield from world.rest(120)


def brown_out(world: World) -> Steps:
    """The board restarts in the hold, and remembers nothing."""
    yield from dive(world)
    world.board.restart()
    world.mark("reset")
    yield from world.wait(30)
    order(world, "@ZAWF$")
    yield from world.rest(150)


def late_board(world: World) -> Steps:
    """The board does what it is told 4 s later."""
    yield from dive(world)
    order(world, "@ZAWF$")
    yield from world.rest(150)


STILL = never(UPWARD.pattern, "garbage", "a false alarm", "calm")
SCENES: tuple[Scene, ...] = (
    Scene(
        "clogged-on-deck",
        "full push for 20 s moves no depth",
        clogged_on_deck,
        BACK,
    ),
    Scene(
        "clogged-on-deck-places-made-up",
        "what the receiver says is no reason for a push that moves nothing",
        clogged_on_deck,
        BACK,
        world={"receiver_mode": "wandering"},
    ),
    Scene(
        "too-light-to-dive",
        "full push moves it by nothing: the mission ends where it lies",
        too_light,
        (reached(), upward_within(40, "go"), home(60), never_deeper(2), lives()),
        body={"buoyancy": 40.0},
    ),
    Scene(
        "clogged-then-w",
        "it rises by itself, and the fixes at the surface end the ascent",
        clogged_then_w,
        BACK,
    ),
    *[
        Scene(f"depth-{lie}", "the ascent needs no depth, and a fix ends it", told_wrong(lie), BACK)
        for lie in ("garbage", "slow", "nan")
    ],
    Scene(
        "tumbling-sensor",
        "full-scale garbage is no roll-over: the mission goes on",
        tumbling_sensor,
        (*LIGHT, STILL),
    ),
    Scene(
        "noisy-line",
        "what is broken is left out, what was not answered is asked again",
        noisy_line,
        (*LIGHT, never(UPWARD.pattern, "down", "a false alarm", "calm")),
    ),
    Scene(
        "brown-out",
        "the whole set is sent again",
        brown_out,
        (*BACK, word_within("@ZAS8", 8, "reset")),
    ),
    Scene(
        "late-board",
        "each way has 10 s, and a board that is 4 s late obeys in them",
        late_board,
        LIGHT,
        board={"lag": 4.0},
    ),
    Scene(
        "mute", "5 s without a report: an ascent, ended by a fix", mute, (*BACK, upward_within(9))
    ),
    Scene("unplugged", "when the line is back, what holds is said again", unplugged, BACK),
    Scene("let-go", "the dead man of the board, and buoyancy", let_go(8.0), BACK),
    Scene(
        "let-go-heavy",
        "in waiting as in idle: sinking below 2 m begins an ascent",
        let_go(-3.0),
        (reached(), home(260, HELD, off=False), never_deeper(16), sinking_noticed(), lives()),
    ),
    Scene("flood", "X and W are picked out of a flood", flood, (*LIGHT, upward_within(2))),
    Scene(
        "hangup",
        "SIGHUP is ignored",
        hangup,
        (*LIGHT, never(UPWARD.pattern, "hangup", "SIGHUP changes nothing", "calm")),
    ),
    Scene(
        "auto-closed",
        "while AUTO is closed the Pi turns no thruster by itself",
        auto_closed,
        (reached(), noted("closed=S"), quiet("due"), home(60)),
    ),
    Scene(
        "auto-by-modem",
        "what is answered as done is in force: everything stops, and the body rises",
        auto_and_copy,
        (reached(), noted("closed=True"), home(80), never_deeper(16)),
        world={"modem": True},
    ),
    Scene(
        "once-more",
        "an emergency that is cleared at the surface is over",
        once_more,
        (
            *(law for law in LIGHT if law is not LIGHT[1]),
            home(90),
            noted("clear=C"),
            noted("second=W"),
            noted("start2=A"),
        ),
    ),
    Scene(
        "dead-sensor-indoors",
        "a refused clear that is repeated is obeyed where no depth is believed",
        dead_sensor_indoors,
        (reached(), noted("clear=C"), quiet("due")),
    ),
    Scene(
        "heavy-to-the-limit",
        "25 N of thrust lift 18 N of weight, slowly",
        heavy_to_the_limit,
        (reached(), home(400, HELD, off=False), held_up(), passed(), never_deeper(30)),
    ),
    Scene(
        "neutral",
        "a body that neither floats nor sinks is lifted by the thrusters",
        neutral,
        LIGHT,
    ),
)
