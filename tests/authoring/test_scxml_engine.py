"""Missions that nobody wrote: their exported charts run alike in an independent engine and ours.

The engine and the walk are those of test_graph_scxml; here are charts of every shape that compiles:
groups in groups with rounds, exits and handlers to any leg, ``else`` to any leg.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from later import installed
from test_graph_scxml import walk

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse
from mission.model import Chart, Group, Leg, Node
from mission.model.shipped import load_vehicle

installed("statemachine.io", "python-statemachine is not installed")
GUARDS = ("travelled >= 50", "depth > 3", "altitude < 2 or elapsed > 9s", "not battery < 11")
DEEPEST = 3


class Author:
    """Writes a mission by chance; every leg states all its axes, so that any way in will do.

    Targets are legs and groups of the own group or of one around it.
    """

    def __init__(self, seed: int) -> None:
        self.chance = random.Random(seed)
        self.named = 0

    def text(self) -> str:
        lines = ["mission generated vehicle auv", "home 30.2874595 120.1535765"]
        return "\n".join([*lines, *self.body(self.chance.randint(2, 5), 0, ())]) + "\n"

    def body(self, size: int, depth: int, outer: tuple[str, ...]) -> list[str]:
        names = [self.name() for _ in range(size)]
        scope, lines = (*outer, *names), []
        for i, name in enumerate(names):
            if depth < DEEPEST and i and self.chance.random() < 0.5:
                kind = self.chance.choice(["group", "repeat 2", "repeat 3"])
                inside = self.body(self.chance.randint(1, 3), depth + 1, scope)
                lines += [f"{kind} {name}:", *inside, "end"]
            else:
                lines.append(self.leg(name, scope))
        if self.chance.random() < 0.5:
            lines.append(f"on {self.chance.choice(GUARDS)} -> {self.chance.choice(scope)}")
        return lines

    def name(self) -> str:
        self.named += 1
        return f"n{self.named}"

    def leg(self, name: str, scope: tuple[str, ...]) -> str:
        chance, targets = self.chance, (*scope, "surface")
        words = [f"{name}: depth 3 heading {chance.randrange(360)} gear 4"]
        for _ in range(chance.randint(0, 2)):
            target = f" -> {chance.choice(targets)}" if chance.random() < 0.6 else ""
            words.append(f"until {chance.choice(GUARDS)}{target}")
        words.append(chance.choice(["for 20s", "timeout 30s"]))
        if chance.random() < 0.3:
            words.append(f"else {chance.choice(targets)}")
        return " ".join(words)


def generated(seed: int) -> Chart:
    mission = parse(Author(seed).text())
    return compile_mission(mission, load_vehicle("auv"), digest(mission))


def _depth(nodes: tuple[Node, ...]) -> int:
    return 1 + max((_depth(n.body) for n in nodes if isinstance(n, Group)), default=0)


@pytest.mark.parametrize("seed", range(24))
def test_generated_missions_run_alike_in_both_engines(seed: int, tmp_path: Path) -> None:
    assert walk(generated(seed), tmp_path, 120, seed) > 15


def test_the_generated_missions_have_every_shape() -> None:
    charts = [generated(seed) for seed in range(24)]
    assert max(_depth(c.mission.body) for c in charts) > DEEPEST - 1
    assert any(edge.loops for c in charts for edge in c.edges)
    assert any(len(edge.loops) > 1 for c in charts for edge in c.edges)
    groups = [s.group for c in charts for s in c.states if s.group]
    assert any(group.handlers for group in groups)
    legs = [s.leg for c in charts for s in c.states if isinstance(s.leg, Leg)]
    assert any(leg.otherwise for leg in legs)
    assert any(exit_.target for leg in legs for exit_ in leg.exits)
