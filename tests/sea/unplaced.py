"""Scenes of missions that begin where no fix has told of, and of ascents that legs hand on.

The receiver is covered until the vehicle has gone out; home is named, and the boat is some way off it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from tests.sea.hull import Pose
from tests.sea.laws import Law, home, lives, never_deeper, noted, reached
from tests.sea.scene import Scene, Script, go
from tests.sea.world import World

Steps = Iterator[None]

OUT = """
    mission out vehicle auv
    home 30.2874595 120.1535765
    safety radius 400 time 40min depth 8
    assume current 0.1
    start without fix
    down: depth 4 heading 0 gear 6 until depth >= 3.5 timeout 60
    out: goto north 80 east 0 within 8 gear 6 depth 4 timeout 4min
    fix: surface until fix timeout 5min else up
    back: goto home within 8 gear 6 depth 2 timeout 6min
    up: surface until fix timeout 5min
"""
IN_A_ROW = """
    mission row vehicle auv
    home 30.2874595 120.1535765
    safety radius 400 time 40min depth 14
    down: down 10 until depth >= 8 timeout 2min
    peek: surface for 9
    rest: surface for 9
    up: surface until fix timeout 5min
"""
NAMED = "the first fix tells where it is: that is no current, and home is found by it"
AFAR = "beyond the radius, which the first fix tells: it comes up at once"
GOES_ON = "one ascent goes on from leg to leg, where W by itself does not stick"


def unplaced(world: World) -> Steps:
    """No fix until it has come up behind its first leg."""
    receiver = world.receiver
    receiver.mode = "dead"
    yield from go(world, OUT)
    yield from world.until(lambda: world.body.depth > 3.0, 120)
    receiver.mode = "honest"
    yield from world.until(lambda: world.body.depth < 0.3, 400)
    yield from world.wait(20)
    world.mark("up")
    yield from world.wait(460)
    world.mark("due")
    yield from world.wait(60)


def near(metres: float) -> Law:
    """In truth, from home, at the end."""

    def law(world: World) -> str:
        far = math.hypot(world.body.pose.x, world.body.pose.y)
        return f"{far:.0f} m from home at the end" if far > metres else ""

    return law


def stays_up(world: World) -> str:
    """Behind the first fix it goes no leg further: the limit acts as the next one begins."""
    behind = [s.depth for s in world.samples if s.at > world.marks.get("up", math.inf)]
    return "" if behind and max(behind) < 3.0 else "it goes on, beyond the radius"


def in_a_row(world: World) -> Steps:
    yield from go(world, IN_A_ROW)
    yield from world.until(lambda: world.body.depth > 7.5, 120)
    world.mark("due")
    yield from world.wait(120)


def _home(name: str, why: str, off: float, script: Script, *laws: Law) -> Scene:
    return Scene(name, why, script, (reached(), *laws, lives()), {"pose": Pose(x=off)})


SCENES = (
    _home("home-named-24-m-off", NAMED, 24.0, unplaced, noted("start=A"), near(40), home(60)),
    _home("home-named-100-m-off", NAMED, 100.0, unplaced, noted("start=A"), near(60), home(60)),
    _home("home-named-600-m-off", AFAR, 600.0, unplaced, stays_up, home(60)),
    Scene("surface-legs-in-a-row", GOES_ON, in_a_row, (never_deeper(13), home(60), lives())),
)
