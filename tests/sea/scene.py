"""What a scene is, and the steps that scenes share.

A script is a generator that yields once a tick and acts through the world: operators, faults, signals.
"""

from __future__ import annotations

import shutil
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from tests.sea.body import Body
from tests.sea.laws import Law, held_up, home, lives, never_deeper, passed, reached
from tests.sea.operator import Operator
from tests.sea.pi import ROOT
from tests.sea.stm32 import Board
from tests.sea.wire import Line
from tests.sea.world import World

Steps = Iterator[None]
Script = Callable[[World], Steps]

# What holds whenever the body floats: home in 150 s, at most 6 m beyond the mission's 10 m.
LIGHT: tuple[Law, ...] = (
    reached(),
    home(150),
    held_up(),
    never_deeper(16),
    passed(),
    lives(),
)

# Heavy and without a depth, nobody can tell the surface from places that are made up.
TRUE_FIXES = {"receiver_mode": "honest"}


@dataclass(frozen=True)
class Draw:
    """What chance adds to a scene: trim, current and course of the body; what the receiver tells
    under water; a slider of so many Hz."""

    body: dict[str, Any] = field(default_factory=dict)
    world: dict[str, Any] = field(default_factory=dict)
    slider: float = 0.0


@dataclass(frozen=True)
class Scene:
    """A row of the table. `why`: why a correct program comes home in it."""

    name: str
    why: str
    script: Script
    laws: tuple[Law, ...]
    body: dict[str, Any] = field(default_factory=dict)
    board: dict[str, Any] = field(default_factory=dict)
    world: dict[str, Any] = field(default_factory=dict)
    make: Callable[..., Any] = Board
    quick: bool = False  # flown by `make test`

    def build(self, seed: int, draw: Draw) -> World:
        """The water of this scene. What the scene itself says has rank over the draw."""
        body = Body(seed=seed, **{**draw.body, **self.body})

        def board(body: Body, line: Line) -> Any:
            return self.make(body, line, seed, **self.board)

        world = World(body, board, seed=seed, **{**draw.world, **self.world})
        if draw.slider:
            world.spawn(slides(world, draw.slider))
        return world


def slides(world: World, rate: float) -> Steps:
    """The first operator's rudder slider, from the dive on."""
    while "down" not in world.marks:
        yield
    yield from boat(world).repeat(lambda n: f"@DS1,{n % 20}$", 1 / rate)


def mission(depth: float, limit: float, stay: str = "8min", extra: str = "") -> str:
    """A dive to a depth, a straight line there, and up."""
    return f"""
        mission sea vehicle auv
        home 30.2874595 120.1535765
        safety radius 900 time 40min depth {limit}
        down: depth {depth} heading 90 gear 4 until depth >= {depth - 0.6:.1f} held 4s timeout 4min
        stay: gear 4 for {stay}
        up: surface until fix timeout 5min
        {extra}
    """


class NoDive(Exception):
    """The scene never came to what it is about: the mission did not bring the vehicle down."""


SETTLE = 16.0  # s on deck: reports, and five fixes in a row


def go(world: World, text: str, name: str = "boat") -> Iterator[None]:
    """On deck, upload, start; `world.operators[0]` commands. Marks `go` when it is accepted."""
    boat = world.operator(name)
    yield from world.wait(SETTLE)
    letter = yield from boat.upload(text)
    world.notes.append(f"upload={letter}")
    if letter != "W":
        raise NoDive(f"the upload was answered '{letter}'")
    letter = yield from boat.ask("@AA$", "AA")
    if letter != "A":  # a receiver that was slow
        yield from world.wait(10)
        letter = yield from boat.ask("@AA$", "AA")
    world.notes.append(f"start={letter}")
    if letter == "A":
        world.mark("go")


def dive(world: World, depth: float = 8.0, limit: float = 10.0, **more: Any) -> Iterator[None]:
    """`go`, and on until the vehicle is down."""
    yield from go(world, mission(depth, limit, **more))
    yield from world.until(lambda: world.body.depth > depth - 0.7, 120)
    yield from world.wait(6)
    if world.body.depth < depth - 2:
        raise NoDive(f"{world.body.depth:.1f} m deep, {depth} m asked for: {world.notes}")
    world.mark("down")


def boat(world: World) -> Operator:
    """The first operator."""
    return world.operators[0]


def order(world: World, frame: str) -> None:
    """The first operator sends a frame that makes an ascent due."""
    boat(world).send(frame)
    world.mark("due")


def own_vehicle(world: World, **changes: str) -> Steps:
    """Begin anew with a vehicle file of this scene's own: the shipped one, with texts replaced."""
    path = world.folder / "own.yaml"
    text = (ROOT / "missions" / "vehicles" / f"{world.vehicle}.yaml").read_text()
    for old, new in changes.items():
        if old not in text:
            raise ValueError(f"the shipped file has no {old}")
        text = text.replace(old, new)
    path.write_text(text)
    config = world.pi.config.read_text().replace(
        f"vehicle: {world.vehicle}\n", f"vehicle: {path}\n"
    )
    world.pi.config.write_text(config)
    world.pi.signal(signal.SIGTERM)
    yield from world.until(lambda: world.pi.starts == 2, 20)


def ruin(world: World, what: str) -> None:
    """Break what a start finds: `what` is one of the rows of `RUINS`."""
    state = world.pi.state
    RUINS[what](world, state)


def _file_instead(folder: Any) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.write_bytes(b"\x00 not a folder")


RUINS: dict[str, Callable[[World, Any], Any]] = {
    "config broken": lambda world, _: world.pi.config.write_text("links: {vehicle: [\n\x00"),
    "config gone": lambda world, _: world.pi.config.unlink(),
    "config empty of sense": lambda world, _: world.pi.config.write_text("vehicle: 7\nlinks: 3\n"),
    "vehicle file broken": lambda world, _: (world.folder / "own.yaml").write_text("vehicle: {{{"),
    "vehicle file gone": lambda world, _: (world.folder / "own.yaml").unlink(),
    "store a file": lambda _, state: _file_instead(state / "store"),
    "log a file": lambda _, state: _file_instead(state / "log"),
    "status a folder": lambda _, state: (
        (state / "status.json").unlink(),
        (state / "status.json").mkdir(),
    ),
}
