"""Scenes of what is promised and of who is refused: bounds of the check, the float test, keys, clears, starts,
texts of any size.
"""

from __future__ import annotations

import contextlib
import json
import math
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator

from tests.sea import hull
from tests.sea.laws import (
    HELD,
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
)
from tests.sea.pi import ROOT
from tests.sea.scene import LIGHT, Scene, Script, boat, dive, go, mission, order
from tests.sea.world import World

Steps = Iterator[None]


def ashore(*words: str) -> subprocess.CompletedProcess[str]:
    """A command of the program's on the laptop, to its end."""
    command = [sys.executable, "-m", "mission", *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1800)


def without_flag(kept: str) -> Script:
    """Whatever the mission waits for is withheld: its fixes, or what `down` waits for as well."""

    def script(world: World) -> Steps:
        text = mission(8, 10, stay="40s")
        path = world.folder / "sea.mission"
        path.write_text("\n".join(line.strip() for line in text.strip().splitlines()) + "\n")
        proved = json.loads(ashore("check", str(path), "--json").stdout)["proved"]
        world.notes.append(f"time={proved['worst_time_s']} depth={proved['max_depth_m']}")
        yield from go(world, text)
        assert world.receiver
        yield from world.until(lambda: world.body.depth > 1.0, 100)
        world.receiver.mode = "dead"
        if kept == "depth":
            world.body.buoyancy = 30.0  # nothing brings it down to 7.4 m
        begin = world.marks["go"]
        world.bound = proved["worst_time_s"], proved["max_depth_m"], proved["max_range_m"]
        yield from world.until(lambda: world.now > begin + proved["worst_time_s"], 2000)
        world.mark("due")
        yield from world.wait(20)

    return script


def within_the_bounds() -> Law:
    """Never deeper, never farther than was proved, and home when the worst time is over."""

    def law(world: World) -> str:
        _time, depth, reach = world.bound
        worst = max(sample.depth for sample in world.samples)
        place = math.hypot(world.body.pose.x, world.body.pose.y)
        if worst > depth + 0.5:
            return f"{worst:.1f} m deep, {depth} m proved"
        return f"{place:.0f} m from home, {reach} m proved" if place > reach else ""

    return law


def float_test(let_go: int) -> Script:
    """The shipped float test, or a copy that lets go deeper; and what `calibrate` reads from its box."""

    def script(world: World) -> Steps:
        text = ashore("convert", "float-test", "--to", "lines").stdout
        deeper = (("depth 5 v", let_go + 3), ("depth 2 u", let_go), ("depth > 4 h", let_go + 2))
        for words, metres in deeper:
            text = text.replace(words, re.sub(r"\d", str(metres), words))
        text = text.replace("depth >= 1.7", f"depth >= {let_go - 0.3}")
        text = text.replace("achieve position 30", "achieve position 60")
        yield from go(world, text)
        world.mark("due")
        yield from world.until(lambda: world.body.depth > 1.0, 60)
        yield from world.rest(700)
        logs = [str(path) for path in sorted((world.pi.state / "log").glob("*.mcap"))]
        done = ashore("calibrate", *logs)
        figure = re.search(r"ascent_buoyancy: (-?[\d.]+)", done.stdout)
        world.notes.append(f"rise={figure[1] if figure else done.stdout + done.stderr}")

    return script


def measured(least: float, most: float) -> Law:
    """The figure is what this body can do, or less: within these bounds in m/s."""

    def law(world: World) -> str:
        note = next((note for note in world.notes if note.startswith("rise=")), "rise=nothing")
        figure = re.fullmatch(r"rise=(-?[\d.]+)", note)
        good = figure and least <= float(figure[1]) <= most
        return "" if good else f"{note}, {least} to {most} m/s wanted"

    return law


def terminal(buoyancy: float) -> float:
    """The pace in m/s at which this body rises by itself: its drag is its buoyancy."""
    return math.sqrt(buoyancy / -hull.Z_WW)


def half_handshakes(world: World) -> Steps:
    """A port with keys; three hundred from the boat's own address begin a handshake and stop; then `surface`."""
    keys = world.folder / "keys"
    ashore("keys", str(keys), "--boat", "deck")
    text = world.pi.config.read_text()
    port = f"tls-listen://127.0.0.1:{world.port}?keys={keys / 'vehicle'}"
    world.pi.config.write_text(text.replace(f"tcp-listen://127.0.0.1:{world.port}", port))
    world.pi.signal(signal.SIGTERM)
    yield from world.until(lambda: world.pi.starts == 2, 20)
    yield from world.wait(5)
    halves = []
    for _ in range(300):
        half = socket.socket()
        half.setblocking(False)
        half.connect_ex(("127.0.0.1", world.port))
        halves.append(half)
        yield from world.wait(0.02)
        with contextlib.suppress(OSError):
            half.send(b"\x16\x03\x01\x02\x00\x01\x00")
    world.mark("asked")
    yield from world.command("nodes", to=f"tls://127.0.0.1:{world.port}?keys={keys / 'deck'}")
    world.mark("due")
    for half in halves:
        half.close()
    yield from world.wait(2)


def answered(name: str) -> Law:
    """The operator's command came to a good end."""

    def law(world: World) -> str:
        note = next((note for note in world.notes if note.startswith(f"{name}=")), "")
        return "" if note.startswith(f"{name}=0 ") else f"{note or name + ' never ended'}"

    return law


def sinks_while_texts_come(world: World) -> Steps:
    """9,999 lines come at 500 a second, each with nots and names; in their midst the body becomes heavy; W."""
    operator = world.operator()
    yield from world.wait(16)
    total = (9999).to_bytes(2, "little")

    def line(count: int) -> bytes:
        words = f"leg{count}: gear 1 until " + "not " * 20 + "depth > 5 timeout 9s"
        text = "mission huge vehicle auv" if count == 1 else words
        return b"@AW" + total + count.to_bytes(2, "little") + text.encode() + b"$"

    def pours() -> Steps:
        for count in range(1, 10000):
            operator.send(line(count))
            if count % 5 == 0:
                yield from world.wait(0.01)

    world.spawn(pours())
    yield from world.wait(6)
    world.mark("due")
    world.body.buoyancy = -5.0
    yield from world.wait(25)
    other = world.operator("other")
    yield from world.wait(0.3)
    other.send("@ZAWF$")
    yield from world.wait(120)


def insists(world: World) -> Steps:
    """W with no buoyancy left, and an operator who says `@AC$` and `@AA$` four times a second."""
    yield from dive(world)
    world.body.buoyancy = 0.3
    order(world, "@ZAWF$")
    world.spawn(boat(world).repeat(lambda n: ("@AC$", "@AA$")[n % 2], 0.25))
    yield from world.held(200)


def closed_and_opened(buoyancy: float) -> Script:
    """AUTO is closed at depth, with another trim, and opened 20 s later; then a start."""

    def script(world: World) -> Steps:
        yield from dive(world)
        world.body.buoyancy = buoyancy
        letter = yield from boat(world).ask("@NSOOOCCC$", "NS", 8)
        world.notes.append(f"closed={letter}")
        yield from world.wait(18)
        letter = yield from boat(world).ask("@NSOOOCCO$", "NS", 8)
        world.notes.append(f"opened={letter}")
        world.mark("due")
        letter = yield from boat(world).ask("@AA$", "AA")
        world.notes.append(f"again={letter}")
        yield from world.held(220 if buoyancy < 0 else 60)

    return script


def far_from_home(world: World) -> Steps:
    """It is put into the water 60 m from home; the mission assumes 25 m."""
    yield from go(world, mission(8, 10))
    world.mark("due")
    yield from world.wait(20)


REFUSED: tuple[Law, ...] = (reached(), noted("start=N"), home(1), never_deeper(2), lives())
SCENES: tuple[Scene, ...] = (
    Scene(
        "bounds-without-fix",
        "each leg has its clock",
        without_flag("fix"),
        (reached(), home(1), within_the_bounds(), lives()),
        body={"current": (0.1, 0.1)},
    ),
    Scene(
        "bounds-without-depth",
        "each leg has its clock",
        without_flag("depth"),
        (reached(), home(1, off=False), within_the_bounds(), lives()),
        body={"current": (0.1, 0.1)},
    ),
    *[
        Scene(
            f"float-test-{newtons}-n",
            f"{newtons} N and the drag of the hull: {terminal(newtons):.2f} m/s, less what it takes to get there",
            float_test(let_go),
            (
                *(reached(), home(700), never_deeper(let_go + 3), lives()),
                measured(0.4 * terminal(newtons), 1.05 * terminal(newtons)),
            ),
            body={"buoyancy": float(newtons)},
        )
        for newtons, let_go in ((8, 6), (1, 2))
    ],
    Scene(
        "half-handshakes",
        "a boat with a certificate gets in",
        half_handshakes,
        (reached(), answered("nodes"), quiet("asked"), lives()),
    ),
    Scene(
        "sinks-while-texts-come",
        "no text holds up a step",
        sinks_while_texts_come,
        (
            *(reached(), home(200, HELD, off=False), sinking_noticed(), passed(0.5)),
            *(never_deeper(12), lives()),
        ),
    ),
    Scene(
        "insists-on-the-clear",
        "N until the surface",
        insists,
        (*LIGHT, never("@ZA[SHFD]", "due", "no mission")),
    ),
    Scene(
        "auto-opened-heavy",
        "sinking below 2 m begins an ascent, once AUTO is open",
        closed_and_opened(-4.0),
        (
            *(reached(), home(300, HELD, off=False), held_up(), never_deeper(24), lives()),
            *(noted("closed=S"), noted("opened=S"), noted("again=N"), upward_within(8)),
        ),
    ),
    Scene(
        "auto-opened-hovering",
        "a mission begins at the surface alone",
        closed_and_opened(0.0),
        (
            *(reached(), noted("closed=S"), noted("opened=S"), noted("again=N"), lives()),
            never("@ZA[SHFD]", "due", "no mission"),
        ),
    ),
    Scene(
        "start-far-from-home",
        "the check rests on 25 m",
        far_from_home,
        REFUSED,
        body={"pose": hull.Pose(x=60.0)},
    ),
)
