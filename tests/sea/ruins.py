"""Scenes of starts in ruins: two or three things broken at once, numbers that no vehicle has, a card that is
read-only; with bodies that are too heavy, and operators who go on as if nothing were.
"""

from __future__ import annotations

import shutil
import signal
from collections.abc import Iterator

from tests.sea.ascents import RISES
from tests.sea.laws import home, lives, never, never_deeper, noted, quiet, reached, upward_within
from tests.sea.scene import RUINS, Scene, Script, boat, dive, own_vehicle, ruin
from tests.sea.world import World
from tests.sea.wrecks import LIFTED

Steps = Iterator[None]


def ruined(*what: str, buoyancy: float = 8.0) -> Script:
    """A crash at depth with another trim; what the next start finds is broken, all of it."""

    def script(world: World) -> Steps:
        yield from own_vehicle(world)
        yield from dive(world)
        world.mark("due")
        world.body.buoyancy = buoyancy
        world.pi.signal(signal.SIGKILL)
        for row in what:
            ruin(world, row)
        yield from (world.held(210) if buoyancy < 0 else world.rest(200))

    return script


def refuses_in_ruins(world: World) -> Steps:
    """A crash at depth, the configuration is gone; an operator uploads, starts, and is refused."""
    yield from own_vehicle(world)
    yield from dive(world)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    ruin(world, "config broken")
    yield from world.until(lambda: world.pi.starts == 3, 20)
    yield from world.wait(3)
    letter = yield from boat(world).ask("@AA$", "AA", 5)
    world.notes.append(f"again={letter}")
    boat(world).send("@ZAWF$")
    yield from world.rest(200)


def numbers(**changes: str) -> Script:
    """A crash at depth; the vehicle file that the next start finds has numbers that no vehicle has."""

    def script(world: World) -> Steps:
        yield from own_vehicle(world)
        yield from dive(world)
        world.mark("due")
        path = world.folder / "own.yaml"
        text = path.read_text()
        for key, value in changes.items():
            head, _, rest = text.partition(f"\n{key}:")
            _, _, below = rest.partition("\n")
            text = f"{head}\n{key}: {value}\n{below}"
        path.write_text(text)
        world.pi.signal(signal.SIGKILL)
        yield from world.rest(200)

    return script


def read_only(how: str) -> Script:
    """A crash at depth; the card comes back read-only, with half a file in the store."""

    def script(world: World) -> Steps:
        yield from dive(world)
        if how == "in-ascent":
            boat(world).send("@ZAWF$")
            yield from world.wait(4)
        world.mark("due")
        world.body.buoyancy = -5.0
        world.pi.read_only = True
        store = world.pi.state / "store"
        for path in [path for path in store.rglob("*") if path.is_file()]:
            path.with_name(path.name + ".tmp").write_bytes(path.read_bytes()[:7])
        world.pi.power_cut()
        yield from world.held(210)

    return script


def on_deck_in_ruins(world: World) -> Steps:
    """In somebody's hands: a crash, and a folder that has lost everything."""
    world.operator()
    yield from world.wait(20)
    world.mark("due")
    world.pi.signal(signal.SIGKILL)
    shutil.rmtree(world.pi.state)
    yield from world.wait(60)


SCENES: tuple[Scene, ...] = (
    Scene(
        "killed-in-ruins",
        "the last configuration that worked; what nobody knows comes up",
        ruined(*[row for row in RUINS if row.endswith(("broken", "file"))]),
        RISES,
    ),
    Scene(
        "killed-in-ruins-heavy",
        "the same lifts 5 N",
        ruined("config gone", "vehicle file gone", "log a file", buoyancy=-5.0),
        (*LIFTED, upward_within(12)),
    ),
    Scene(
        "killed-store-a-file-heavy",
        "two reports over 2 m",
        ruined("store a file", "status a folder", buoyancy=-5.0),
        (*LIFTED, upward_within(12)),
    ),
    Scene(
        "refused-in-ruins",
        "it serves the ascent alone",
        refuses_in_ruins,
        (
            *(reached(), noted("again=N"), home(150), never_deeper(16), upward_within(12)),
            *(never("@ZA[SHFD]", "due", "no mission"), lives()),
        ),
    ),
    Scene(
        "killed-wild-numbers",
        "each number has its range",
        numbers(
            dive_rate=".nan", ascent_buoyancy="0 m/s", ascent_thrust="-0.5 m/s", turn_rate=".inf"
        ),
        RISES,
    ),
    Scene(
        "killed-huge-period",
        "and so has the telemetry's period",
        numbers(sensors="{depth: 1e9 m, telemetry_period: 1e9 s}"),
        RISES,
    ),
    *[
        Scene(
            f"read-only-{how}-heavy",
            "what the disk holds is known",
            read_only(how),
            (*LIFTED, upward_within(12)),
        )
        for how in ("in-mission", "in-ascent")
    ],
    Scene("on-deck-in-ruins", "nothing was under way", on_deck_in_ruins, (reached(), quiet("due"))),
)
