"""The table of scenes with the AUV of document 000: what goes wrong, and the laws that hold."""

from __future__ import annotations

import signal
from collections.abc import Iterator

from tests.sea import faults
from tests.sea.faults import Will
from tests.sea.laws import (
    HELD,
    Law,
    accepted,
    held_up,
    home,
    legs,
    never,
    never_deeper,
    passed,
    quiet,
    reached,
    sinking_noticed,
    started_again,
    upward_within,
)
from tests.sea.scene import RUINS, Scene, boat, dive, go, mission, order, own_vehicle, ruin
from tests.sea.world import World

Steps = Iterator[None]

LIGHT: tuple[Law, ...] = (reached(), home(150), held_up(), never_deeper(16), passed(), started_again(1))
HEAVY: tuple[Law, ...] = (reached(), home(300, HELD, off=False), held_up(), passed(), started_again(1))

# ---- calm water ---------------------------------------------------------------------------


def calm(world: World) -> Steps:
    yield from dive(world, stay="40s")
    yield from world.wait(45)
    world.mark("due")
    yield from world.wait(110)


def stop_and_up(world: World) -> Steps:
    yield from dive(world)
    order(world, "@ZAX0$")
    yield from world.wait(80)


# ---- 1: no state is an end ------------------------------------------------------------------


def possessed(word: str, obeys: str, again: float | None = None, seconds: float = 200) -> object:
    """The board dives by itself from the moment of this word on, and obeys only some."""

    def script(world: World) -> Steps:
        yield from dive(world)
        order(world, word)
        yield from world.wait(0.5)
        world.board.will = Will(obeys=frozenset(obeys), again=again)
        yield from world.wait(seconds)

    return script


def idle_dives(world: World) -> Steps:
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    world.board.will = Will(obeys=frozenset("U"), again=50, times=3)
    yield from world.wait(420)


def heavy_after(word: str) -> object:
    """Water comes in with this word: 6 N too heavy from then on."""

    def script(world: World) -> Steps:
        yield from dive(world)
        order(world, word)
        world.body.buoyancy = -6.0
        yield from world.wait(300)

    return script


def heavy_idle(world: World) -> Steps:
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    world.body.buoyancy = -6.0
    yield from world.wait(300)


# ---- 2: nothing starves a safety word -------------------------------------------------------


def slider(rate: float, word: str) -> object:
    """The commander's rudder slider moves all the time; then the word."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.spawn(boat(world).repeat(lambda n: f"@DS{1 + n % 2},{n % 20}$", 1 / rate))
        yield from world.wait(5)
        order(world, word)
        yield from world.wait(150)

    return script


STAIRS = """
    mission stairs vehicle auv
    home 30.2874595 120.1535765
    safety radius 900 time 40min depth 12
    one: depth 4 heading 90 gear 4 for 20s
    two: gear 5 for 15s
    three: gear 6 heading 180 for 15s
    four: depth 5 for 15s
    up: surface timeout 5min
"""


def slider_legs(world: World) -> Steps:
    yield from go(world, STAIRS)
    world.spawn(boat(world).repeat(lambda n: f"@DS1,{n % 20}$", 1 / 60))
    yield from world.wait(75)
    world.mark("due")
    yield from world.wait(110)


# ---- 3: an orderly end ----------------------------------------------------------------------


def term_after_w(world: World) -> Steps:
    yield from dive(world)
    order(world, "@ZAWF$")
    yield from world.wait(1)
    world.pi.systemctl_stop()
    yield from world.wait(200)


def term_in_mission(world: World) -> Steps:
    yield from dive(world)
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(200)


def term_on_deck(world: World) -> Steps:
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    world.pi.systemctl_stop()
    yield from world.wait(30)
    world.pi.wanted = True
    world.pi.start()
    yield from world.wait(60)


# ---- 4: serve always begins -----------------------------------------------------------------


def broken(what: str) -> object:
    """Killed at depth; what the next start finds is broken."""

    def script(world: World) -> Steps:
        own_vehicle(world, **{"(assumed)": "(assumed)"})
        world.pi.starts = 0
        yield from dive(world)
        world.mark("due")
        world.pi.signal(signal.SIGKILL)
        ruin(world, what)
        yield from world.wait(200)

    return script


def port_taken(world: World) -> Steps:
    import socket

    yield from dive(world)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    with socket.socket() as thief:
        thief.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        thief.bind(("127.0.0.1", world.port))
        thief.listen()
        yield from world.wait(200)


def killed(world: World) -> Steps:
    yield from dive(world)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    yield from world.wait(200)


# ---- 5: a depth is believed as far as something else agrees -----------------------------------


def clogs_at(told: float) -> object:
    """Asked for 8 m; at this depth the port closes, with what is in it."""

    def script(world: World) -> Steps:
        yield from go(world, mission(8, 10))
        yield from world.until(lambda: world.body.depth > told, 120)
        world.board.senses.depth = faults.clogged(told, world.seed)
        yield from world.wait(25)
        world.mark("due")
        yield from world.wait(230)

    return script


def lies_in_hold(kind: str) -> object:
    """At 8 m, held: the reading drifts away or jumps."""

    def script(world: World) -> Steps:
        yield from dive(world)
        lie = {"drift": faults.drifting(world.now, -0.05), "jump": faults.shifted(-6.0)}[kind]
        world.board.senses.depth = lie
        start = world.body.depth
        yield from world.until(lambda: world.body.depth > start + 6, 160 if kind == "drift" else 20)
        world.mark("due")
        yield from world.wait(200)

    return script


def offset_on_deck(world: World) -> Steps:
    world.board.senses.depth = faults.shifted(3.0)
    yield from go(world, mission(8, 10))
    yield from world.wait(10)
    order(world, "@ZAWF$")
    yield from world.wait(200)


# ---- 6: upside down ---------------------------------------------------------------------------


def turns_over(world: World) -> Steps:
    yield from dive(world)
    world.body.turn_over()
    world.mark("due")
    yield from world.wait(230)


# ---- 7, 20: fixes under water -----------------------------------------------------------------


def lying_receiver(world: World) -> Steps:
    yield from dive(world)
    order(world, "@ZAWF$")
    yield from world.wait(150)


# ---- 8: cleared only at the surface -------------------------------------------------------------


def clear_under_water(world: World) -> Steps:
    yield from dive(world)
    world.body.buoyancy = 0.2
    order(world, "@ZAX0$")
    yield from world.wait(2)
    for wait in (9.0, 0.5):
        letter = yield from boat(world).ask("@AC$", "AC")
        world.notes.append(f"clear={letter}")
        yield from world.wait(wait)
    world.notes.append(f"again={(yield from boat(world).ask('@AA$', 'AA'))}")
    yield from world.wait(250)


# ---- 14: an emergency belongs to whoever ordered it ----------------------------------------------


def stick(frame: str, every: float, restart: bool = False) -> object:
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
            yield from world.wait(3.2)
            boat(world).connect()
        yield from world.wait(150)

    return script


def neutral_after_silence(world: World) -> Steps:
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


# ---- 15: late and doubled words ------------------------------------------------------------------


def late_start(world: World) -> Steps:
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
    yield from go(world, mission(20, 30))
    assert world.acoustic
    first, second = "@SP,900,40,30,10,$", "@SP,900,40,10,10,$"
    yield from boat(world).ask(first, "SP")
    yield from boat(world).ask(second, "SP")
    yield from world.wait(3)
    world.acoustic.send(first)
    yield from world.until(lambda: world.body.depth > 11.3, 100)
    world.mark("due")
    yield from world.wait(180)


# ---- 18: limits see through noise ----------------------------------------------------------------


def flickering_voltage(world: World) -> Steps:
    yield from dive(world)
    world.board.senses.control = faults.flicker(20.4, 1.3, world.seed)
    yield from world.wait(1)
    world.mark("due")
    yield from world.wait(200)


# ---- 19: no sender can hold a receiver ------------------------------------------------------------


def noisy_modem(world: World) -> Steps:
    yield from dive(world)
    assert world.acoustic
    acoustic, count = world.acoustic, 0

    def noise() -> Steps:
        nonlocal count
        due = world.now
        while True:
            if world.now >= due:
                acoustic.noise(b"\x23\x02\x80\x0c\x01" if count % 8 == 0 else bytes([0x41 + count % 20]))
                due, count = due + 0.7, count + 1
            yield

    world.spawn(noise())
    yield from world.wait(10)
    acoustic.send("@ZAWF$")
    yield from world.wait(acoustic.delay)
    world.mark("due")
    yield from world.wait(150)


def _flickering_vehicle(script: object) -> object:
    def changed(world: World) -> Steps:
        own_vehicle(
            world,
            **{"constant_batteries: true": "constant_batteries: false", "voltage: 10 V": "voltage: 22 V"},
        )
        world.board.senses.control = lambda _now, _truth: 25.0
        world.pi.signal(signal.SIGKILL)  # it began before the file was there
        yield from world.wait(4)
        yield from script(world)  # type: ignore[operator]

    return changed


SCENES: tuple[Scene, ...] = (
    Scene("calm", "nothing is wrong", calm, (*LIGHT, legs((r"@ZAS8", 5))), quick=True),
    Scene("calm-documented", "nothing is wrong", calm, LIGHT, board={"built": False}),
    Scene("stop", "the body floats: X lets it rise", stop_and_up, (*LIGHT, never("@ZA[UW]", "due", "it rises by itself"))),
    Scene("dives-after-w", "the board obeys U12, the second way of an ascent", possessed("@ZAWF$", "U"), (*LIGHT, upward_within(1)), quick=True),
    Scene("dives-after-w-x", "the board obeys X0, a part of two ways", possessed("@ZAWF$", "X"), LIGHT),
    Scene("dives-after-w-w", "the board obeys W, the first way, when it comes again", possessed("@ZAWF$", "W"), (reached(), home(200), held_up(), passed())),
    Scene("dives-after-x", "20 s after X it has not risen: an ascent, whose U12 the board obeys", possessed("@ZAX0$", "U"), (reached(), home(200), held_up(), never_deeper(25), upward_within(28), passed())),
    Scene("dives-after-x-again", "each time it comes back U12 ends it", possessed("@ZAX0$", "U", again=45, seconds=300), (reached(), home(200), held_up(), sinking_noticed(within=30), passed())),
    Scene("dives-idle", "in idle two reports of sinking begin an ascent, each time", idle_dives, (reached(), home(0.5), sinking_noticed(), held_up(), never_deeper(16))),
    Scene("heavy-after-x", "25 N of thrust lift 6 N of weight", heavy_after("@ZAX0$"), (*HEAVY, upward_within(28), never_deeper(22))),
    Scene("heavy-after-w", "25 N of thrust lift 6 N of weight, and hold it", heavy_after("@ZAWF$"), (*HEAVY, never_deeper(16))),
    Scene("heavy-idle", "it is held where it sinks again", heavy_idle, (reached(), home(300, HELD, off=False), sinking_noticed(), never_deeper(10))),
    Scene("slider-w", "W, X0 and U12 have rank over a slider", slider(60, "@ZAWF$"), (*LIGHT, upward_within(1)), quick=True),
    Scene("slider-w-200", "the same at 200 a second", slider(200, "@ZAWF$"), LIGHT),
    Scene("slider-x", "X has rank over a slider", slider(60, "@ZAX0$"), LIGHT),
    Scene("slider-legs", "the set has rank over relays", slider_legs, (reached(), home(150), legs((r"@ZAH-90,4", 5), (r"@ZAH-90,5", 25), (r"@ZAH(-?180),6", 20), (r"@ZAS5", 20), (r"@ZA(WF|U)", 20)))),
    Scene("term-after-w", "serve goes on surfacing, then X0", term_after_w, LIGHT, quick=True),
    Scene("term-in-mission", "serve surfaces, then X0", term_in_mission, (*LIGHT, upward_within(5))),
    Scene("term-on-deck", "it is on deck", term_on_deck, (reached(), quiet("due"), home(1))),
    Scene("killed", "the next start surfaces", killed, (*LIGHT, upward_within(10))),
    *[
        Scene(f"killed-{name.replace(' ', '-')}", "the last configuration that worked serves the ascent", broken(name), (*LIGHT, upward_within(12)))
        for name in RUINS
    ],
    Scene("killed-port-taken", "the ascent needs no port for operators", port_taken, (*LIGHT, upward_within(12))),
    Scene("clogged-3m-short", "full push for 20 s moves no depth: not believed; X0 and U12", clogs_at(5.0), (reached(), home(200), never_deeper(16))),
    Scene("clogged-1m-short", "the same", clogs_at(7.0), (reached(), home(200), never_deeper(16)), quick=True),
    Scene("drift", "the altimeter closes on the floor while the depth stands", lies_in_hold("drift"), (reached(), home(200), never_deeper(16)), body={"floor": 25.0}),
    Scene("jump", "no body rises 6 m in 2 s", lies_in_hold("jump"), (reached(), home(200), never_deeper(16))),
    Scene("offset-on-deck", "fixes behave as at the surface and pushing up moves nothing", offset_on_deck, (reached(), home(1), lambda w: home(1)(w), never_deeper(3))),
    Scene("upside-down", "letting go lifts it, and so does D12", turns_over, (reached(), home(220), never_deeper(16))),
    Scene("upside-down-aerospace", "the same, told as a roll of 180", turns_over, (reached(), home(220), never_deeper(16)), board={"turned": False}),
    *[
        Scene(f"fixes-{mode}", "a believed depth contradicts a fix", lying_receiver, LIGHT, world={"receiver_mode": mode})
        for mode in ("stuck", "alternating", "cycling", "wandering")
    ],
    Scene("clear-under-water", "N under water; not risen in 20 s: an ascent", clear_under_water, (reached(), home(250), held_up(), accepted("N", "clear"), accepted("N", "again"), never("@ZA[SHFD]", "due", "no mission"))),
    Scene("held-stick", "a held stick takes nothing over", stick("@MMD6$", 0.3), (*LIGHT, never("^@M", "due", "an emergency is under way"))),
    Scene("neutral-stick", "a neutral stick takes nothing over", stick("@MMF0$", 0.3), (*LIGHT, never("^@M", "due", "an emergency is under way"))),
    Scene("held-stick-restart", "nor after a restart", stick("@MMD6$", 0.3, restart=True), (*LIGHT, never("^@M", "due", "an emergency is under way"))),
    Scene("neutral-after-silence", "a neutral M never takes an emergency over", neutral_after_silence, (*LIGHT, never("^@M", "due", "an emergency is under way"))),
    Scene("late-start", "the copy meets a mission that was started once", late_start, (reached(), quiet("copy")), world={"modem": True}),
    Scene("late-limit", "the copy loosens nothing", late_limit, (*LIGHT, upward_within(6)), world={"modem": True}),
    Scene("flickering-voltage", "most of a window is below the limit", _flickering_vehicle(flickering_voltage), (reached(), home(220), upward_within(60)), board={"built": False}),
    Scene("noisy-modem", "X and W are found in whatever comes", noisy_modem, (reached(), home(150), passed(3.0)), world={"modem": True}),
)
