"""Fly a scene and judge it."""

from __future__ import annotations

import random
import time
import traceback
from dataclasses import dataclass, field

from tests.sea.scene import Draw, Scene
from tests.sea.world import World

PLAIN = Draw()


@dataclass
class Verdict:
    """What became of a flight: `wrong` is empty when every law held."""

    scene: str
    seed: int
    wrong: list[str] = field(default_factory=list)
    deepest: float = 0.0
    last: float = 0.0
    lasted: float = 0.0
    took: float = 0.0
    notes: list[str] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    output: str = ""

    def line(self) -> str:
        """One line for a person."""
        fate = "home" if not self.wrong else "FAILS"
        return (
            f"{self.scene:28} seed {self.seed:<4} {fate:5} deepest {self.deepest:5.1f} m, at the end "
            f"{self.last:5.1f} m; {self.lasted:4.0f} s in {self.took:.0f} s"
            + "".join(f"\n    {wrong}" for wrong in self.wrong)
        )


def fly(scene: Scene, seed: int = 0, draw: Draw = PLAIN) -> Verdict:
    """One flight of a scene with a seed, and with what chance adds."""
    began = time.monotonic()
    verdict = Verdict(scene.name, seed)
    world = scene.build(seed, draw)
    try:
        world.run(scene.script(world))
        verdict.wrong = [wrong for law in scene.laws if (wrong := law(world))]
    except Exception:
        verdict.wrong = [f"the flight broke off: {traceback.format_exc(limit=-3)}"]
    finally:
        _note(verdict, world, draw)
        verdict.took = time.monotonic() - began
        world.close()
    return verdict


def _note(verdict: Verdict, world: World, draw: Draw) -> None:
    verdict.deepest = max((sample.depth for sample in world.samples), default=0.0)
    verdict.last = world.body.depth
    verdict.lasted = world.now - 1000
    verdict.notes = [
        str(draw),
        *world.notes,
        *(f"{name} {at - 1000:.1f}" for name, at in world.marks.items()),
    ]
    verdict.words = _wire(world)
    verdict.output = world.pi.output()


def _wire(world: World) -> list[str]:
    """The wire to the board with the truth beside each word; sticks and rudders once a second."""
    lines, held = [], 0.0
    samples = iter(world.samples)
    sample = next(samples, None)
    for word in world.board.words:
        while sample and sample.at < word.at:
            sample = next(samples, None)
        if word.text[1:2] in "MD" and word.at < held:
            continue
        held = word.at + 1 if word.text[1:2] in "MD" else held
        depth = f"{sample.depth:5.2f} m {sample.rate:+.2f} m/s" if sample else ""
        lines.append(f"{word.at - 1000:8.2f} s  {depth}  {word.text}{'' if word.done else '  (N)'}")
    return lines


def drawn(scenes: tuple[Scene, ...], seed: int) -> tuple[Scene, Draw]:
    """A scene at random, and what chance adds: nothing that a correct program could not bear. A
    slider commands (R12), so there is none where somebody else is to, by modem."""
    dice = random.Random(f"draw {seed}")
    scene = dice.choice(scenes)
    body = {
        "buoyancy": dice.choice((8.0, 8.0, 6.0, 4.0)),
        "current": (dice.uniform(-0.12, 0.12), dice.uniform(-0.12, 0.12)),
        "yaw": dice.uniform(-3.1, 3.1),
    }
    modes = ("honest", "honest", "silent", "stuck", "alternating", "cycling", "wandering")
    slider = dice.choice((0.0, 0.0, dice.uniform(5, 200)))
    mode = dice.choice(modes)
    alone = not scene.world.get("modem")
    return scene, Draw(body, {"receiver_mode": mode}, round(slider) if alone else 0.0)
