"""The second sea: the vehicle comes home in water that the program's authors did not prepare.

A few quick scenes in `make test`; all of them, and some drawn at random, behind the marker `proof`
(`make sea`).
"""

from __future__ import annotations

import pytest

from tests.sea.fly import PLAIN, drawn, fly
from tests.sea.scene import Draw, Scene
from tests.sea.scenes import PAIRS, SCENES


def names(scene: Scene) -> str:
    return scene.name


def home_by_every_law(scene: Scene, seed: int = 0, draw: Draw = PLAIN) -> None:
    verdict = fly(scene, seed, draw)
    wire = "\n".join(verdict.words[-60:])
    assert not verdict.wrong, f"{verdict.line()}\n{verdict.notes}\n{wire}\n{verdict.output[-4000:]}"


@pytest.mark.parametrize("scene", [s for s in SCENES if s.quick], ids=names)
def test_the_vehicle_comes_home_in_a_quick_scene(scene: Scene) -> None:
    home_by_every_law(scene)


@pytest.mark.proof
@pytest.mark.parametrize("scene", [s for s in SCENES if not s.quick], ids=names)
def test_the_vehicle_comes_home_in_every_scene(scene: Scene) -> None:
    home_by_every_law(scene)


@pytest.mark.proof
@pytest.mark.minutes
@pytest.mark.parametrize("scene", PAIRS, ids=names)
def test_the_vehicle_comes_home_under_pairs_of_troubles(scene: Scene) -> None:
    home_by_every_law(scene)


@pytest.mark.proof
@pytest.mark.parametrize("seed", range(1, 31))
def test_the_vehicle_comes_home_in_scenes_drawn_at_random(seed: int) -> None:
    scene, draw = drawn(SCENES, seed)
    home_by_every_law(scene, seed, draw)
