"""Areas while a mission runs: a certain breach surfaces, an uncertain one is the mission's own (R5)."""

from __future__ import annotations

import pytest
from engine_world import World, leg, mission

from mission.engine.areas import breached, doubted, fences
from mission.model import Area, Local

SURE, WIDE = (1.0, 0.0, 1.0), (2500.0, 0.0, 2500.0)


def box(name: str, north: float, east: float, half: float, *, out: bool = True, **depths: float):
    ends = ((-half, -half), (-half, half), (half, half), (half, -half))
    return Area(name, out, tuple(Local(north + n, east + e) for n, e in ends), **depths)


def under_way(*areas: Area, depth: float = 5.0) -> World:
    world = World(
        mission(
            leg("a", timeout=600.0),
            leg("b", timeout=600.0),
            on_uncertain="b",
            areas=areas,
        )
    )
    assert world.start()
    world.nav.covariance = SURE
    world.depth = depth
    world.wait(4.0)
    return world


def go(world: World, north: float, east: float, covariance=SURE, seconds: float = 6.0) -> str:
    world.nav.north, world.nav.east, world.nav.covariance = north, east, covariance
    world.wait(seconds)
    return world.state


WRECK = box("wreck", 100.0, 0.0, 20.0)


def test_outside_all_that_is_kept_out_of_nothing_happens() -> None:
    assert go(under_way(WRECK), 60.0, 0.0) == "autonomous/a"


def test_in_what_is_kept_out_of_it_surfaces() -> None:
    world = under_way(WRECK)
    assert go(world, 100.0, 0.0) == "emergency/surfacing"
    assert "against keep out wreck" in world.engine.reason


def test_near_it_the_mission_does_what_it_says_of_uncertainty() -> None:
    world = under_way(WRECK)
    assert go(world, 77.0, 0.0, (4.0, 0.0, 4.0)) == "autonomous/b"
    assert "not clear: keep out wreck" in world.engine.reason


def test_one_sample_is_none() -> None:
    world = under_way(WRECK)
    go(world, 100.0, 0.0, seconds=2.0)
    assert go(world, 0.0, 0.0) == "autonomous/a"


@pytest.mark.parametrize(("depth", "state"), [(5.0, "autonomous/a"), (9.0, "emergency/surfacing")])
def test_it_counts_between_its_depths(depth: float, state: str) -> None:
    deep = box("wreck", 100.0, 0.0, 20.0, top=8.0, bottom=12.0)
    world = under_way(deep)
    world.nav.north = 100.0
    world.depth = depth
    world.wait(6.0)
    assert world.state == state


@pytest.mark.parametrize("out", [True, False])
def test_at_the_surface_it_counts_whatever_little_above_it_the_sensor_says(out: bool) -> None:
    world = under_way(box("wreck", 100.0 if out else 0.0, 0.0, 20.0, out=out))
    world.depth = -0.1
    assert go(world, 100.0, 0.0) == "emergency/surfacing"


def test_out_of_what_is_kept_in_it_surfaces() -> None:
    world = under_way(box("harbour", 0.0, 0.0, 100.0, out=False))
    assert go(world, 90.0, 0.0) == "autonomous/a"
    assert go(world, 110.0, 0.0) == "emergency/surfacing"


def test_of_several_that_are_kept_in_one_is_enough() -> None:
    near = box("near", 0.0, 0.0, 100.0, out=False)
    far = box("far", 150.0, 0.0, 100.0, out=False)
    assert go(under_way(near, far), 120.0, 0.0) == "autonomous/a"


def test_at_the_edge_of_what_is_kept_in_it_is_uncertain() -> None:
    world = under_way(box("harbour", 0.0, 0.0, 100.0, out=False))
    assert go(world, 97.0, 0.0, (4.0, 0.0, 4.0)) == "autonomous/b"


def test_where_two_overlap_the_edge_of_one_is_no_edge() -> None:
    near = box("near", 0.0, 0.0, 100.0, out=False)
    far = box("far", 150.0, 0.0, 100.0, out=False)
    assert go(under_way(near, far), 99.0, 0.0, (4.0, 0.0, 4.0)) == "autonomous/a"


def test_with_all_uncertainty_nothing_is_sure() -> None:
    (fence,) = fences([WRECK], lambda place: (place.north, place.east))  # type: ignore[union-attr]
    assert doubted([fence], (0.0, 0.0), WIDE, 5.0)
    assert not breached([fence], (0.0, 0.0), 5.0)


def test_a_depth_that_is_not_believed_may_be_any() -> None:
    deep = box("wreck", 100.0, 0.0, 20.0, top=8.0, bottom=12.0)
    (fence,) = fences([deep], lambda place: (place.north, place.east))  # type: ignore[union-attr]
    assert breached([fence], (100.0, 0.0), None)
    assert not breached([fence], (100.0, 0.0), 5.0)


def test_after_the_mission_its_areas_say_nothing() -> None:
    world = under_way(WRECK)
    go(world, 100.0, 0.0)
    assert world.engine.core.watch.fences == ()


def test_interrupted_by_the_stick_it_is_judged_again_when_it_goes_on() -> None:
    from engine_world import M

    from protocol.messages import StartMission

    world = under_way(WRECK)
    world.tell(M)
    world.wait(5.0)
    world.tell(StartMission())
    assert world.verdicts[-1].accepted
    assert go(world, 100.0, 0.0) == "emergency/surfacing"
