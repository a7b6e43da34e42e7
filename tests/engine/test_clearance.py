"""Laws of a depth that is kept above the bottom (R5): the shallower of the two, and never in haste."""

from __future__ import annotations

import pytest
from engine_world import World, flying, leg, mission, sets

from mission.engine.clearance import DEEPER_AFTER, ECHOES_MISSED, Clearance
from mission.legs import Goto
from mission.model import Estimate, Health, Local, NavigationMode, Safety
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from protocol.messages import Setpoint, Telemetry

KEPT = sets(surge=0.5, heading=0.0, depth=8.0, altitude=3.0)
FLOOR = (("floor", 10.0),)
ESTIMATE = Estimate(
    *(0.0, 0.0, 0.0, 2.0, 0.0, None, 0.0, 1.0, 0.0, 0.0, (1.0, 0.0, 1.0)),
    *({}, None, None, NavigationMode.FIX),
)


def over(bottom: float, *, depth: float = 2.0, **more: object) -> World:
    """Under way over a bottom that is so deep, m."""
    world = World(
        mission(leg("a", timeout=600.0, settings=KEPT, **more), assume=FLOOR)  # type: ignore[arg-type]
    )
    world.altitude = bottom - 0.2
    assert world.start()
    move(world, bottom, depth)
    return world


def move(world: World, bottom: float, depth: float, seconds: float = 2.0) -> None:
    world.depth, world.altitude = depth, bottom - depth
    world.wait(seconds)


def depths(world: World) -> list[float | None]:
    return [c.depth for c in world.commands() if isinstance(c, Setpoint)]


def test_the_depth_asked_for_is_held_where_there_is_room():
    assert depths(over(30.0)) == [8.0]


def test_the_bottom_less_the_height_is_held_where_there_is_none():
    assert depths(over(9.0)) == [6.0]


def test_no_set_names_an_altitude():
    sent = [c for c in over(9.0).commands() if isinstance(c, Setpoint)]
    assert [c.altitude for c in sent] == [None]


def test_it_holds_whole_steps_on_the_safe_side():
    assert depths(over(9.9)) == [6.0]


def test_where_nothing_is_left_it_holds_the_surface():
    assert depths(over(2.5, depth=1.0)) == [0.0]


def test_a_bottom_that_rises_acts_with_the_report_that_says_so():
    world = over(30.0)
    move(world, 7.0, 4.0)
    assert depths(world) == [8.0, 4.0]


def test_a_bottom_that_falls_acts_when_there_was_room_for_some_seconds():
    world = over(9.0)
    began = world.t
    move(world, 11.5, 5.0, 20.0)
    told = [t for t, a in world.actions if isinstance(a.command, Setpoint)]
    assert depths(world) == [6.0, 8.0]
    assert DEEPER_AFTER <= told[-1] - began <= DEEPER_AFTER + 4.0


def test_a_moment_of_room_is_none():
    world = over(9.0)
    for _ in range(5):
        move(world, 11.5, 5.0, 4.0)
        move(world, 9.0, 5.0, 2.0)
    assert depths(world) == [6.0]


def test_one_wrong_echo_and_none_behind_it_leads_no_deeper():
    """The navigation believes an echo of 20 m more; it was one, and the bottom is where it was."""
    world = over(9.0)
    move(world, 29.0, 5.0)
    world.altitude = 24.0
    world.nav.doubt["altitude"] = "absurd"
    world.wait(ECHOES_MISSED)
    assert depths(world) == [6.0]


def test_noise_at_the_edge_of_a_step_does_not_steer():
    world = over(9.1)
    for bottom in (8.95, 9.1, 9.05, 9.2, 9.1, 9.15, 9.2, 9.1, 9.05):
        move(world, bottom, 5.0)
    assert depths(world) == [6.0, 5.0]


@pytest.mark.parametrize(("bottom", "blind"), [(30.0, 7.0), (9.0, 7.0)])
def test_without_an_altitude_the_assumed_floor_counts(bottom: float, blind: float):
    world = over(bottom)
    world.nav.doubt["altitude"] = "frozen"
    world.wait(30.0)
    assert depths(world)[-1] == blind


def test_without_an_altitude_from_the_start_the_assumed_floor_counts():
    world = World(mission(leg("a", timeout=600.0, settings=KEPT), assume=FLOOR))
    world.nav.doubt["altitude"] = "missing"
    assert world.start()
    assert depths(world) == [7.0]


def test_a_missed_echo_is_no_loss_of_the_bottom():
    world = over(9.0)
    for _ in range(6):
        world.nav.doubt["altitude"] = "absurd"
        world.wait(ECHOES_MISSED - 2.0)
        world.nav.doubt.clear()
        world.wait(2.0)
    assert depths(world) == [6.0]


def test_an_altitude_without_a_depth_says_nothing_of_the_bottom():
    """Nobody knows how deep the bottom is then; the leg is left, as any that holds a depth."""
    world = over(9.0)
    world.nav.doubt["depth"] = "frozen"
    world.wait(5.0)
    assert depths(world) == [6.0]
    world.wait(10.0)
    assert world.state != "autonomous/a"


def test_where_the_mission_says_nothing_the_depth_allowed_is_the_floor():
    allowed = mission(leg("a", settings=KEPT), safety=Safety(depth=9.0))
    assert Clearance.of(allowed, load_vehicle("auv")).blind(Setpoint(depth=8, altitude=3)) == 6.0


def test_the_altitude_missing_is_no_reason_to_leave_the_leg():
    world = over(30.0)
    world.nav.doubt["altitude"] = "frozen"
    world.wait(60.0)
    assert world.state == "autonomous/a"


def test_a_leg_that_steers_its_heading_is_kept_clear_as_well():
    settings = sets(surge=0.5, depth=8.0, altitude=3.0)
    go = leg("a", kind=Goto(Local(500.0, 0.0), 10.0), timeout=600.0, settings=settings)
    world = World(mission(go, assume=FLOOR))
    world.altitude = 8.8
    assert world.start()
    move(world, 9.0, 4.0)
    move(world, 7.0, 4.0)
    assert depths(world)[0] == 6.0
    assert depths(world)[-1] == 4.0


def test_another_leg_begins_with_what_its_own_set_allows():
    settings = sets(surge=0.5, heading=0.0, depth=7.0, altitude=2.0)
    first = leg("a", timeout=10.0, otherwise="b", settings=KEPT)
    world = World(
        mission(first, leg("b", timeout=600.0, settings=settings), assume=FLOOR, on_timeout="b")
    )
    world.altitude = 8.8
    assert world.start()
    move(world, 9.0, 4.0, 20.0)
    assert depths(world) == [6.0, 7.0]


@pytest.mark.parametrize("wrong", [True, False])
def test_a_leg_of_the_same_set_goes_on_with_what_the_one_before_held(wrong: bool):
    """One wrong echo at the turn of the two leads no deeper."""
    a = leg("a", timeout=None, duration=20.0, settings=KEPT)
    world = World(mission(a, leg("b", timeout=600.0, settings=KEPT), assume=FLOOR))
    world.altitude = 8.8
    assert world.start()
    move(world, 9.0, 4.0, 17.0)
    move(world, 14.0 if wrong else 9.0, 4.0, 2.0)
    world.nav.doubt["altitude"] = "missing"
    world.wait(3.0)
    assert world.state == "autonomous/b"
    assert depths(world) == [6.0, 6.0]


def test_a_vehicle_that_is_told_fractions_is_told_half_metres():
    coreboard: Vehicle = load_vehicle("coreboard")
    kept = Clearance.of(mission(leg("a"), assume=(("floor", 9.8),)), coreboard)
    assert kept.blind(Setpoint(depth=8.0, altitude=3.0)) == 6.5


def test_a_copy_goes_on_as_the_original_would():
    kept = Clearance(10.0, 1.0)
    world = flying(leg("a", settings=sets(surge=0.5, heading=0.0, depth=5.0)))
    state = world.engine.core.vehicle_state
    kept.told(Setpoint(depth=8.0, altitude=3.0), state)
    assert kept.clone().told(Setpoint(depth=9.0, altitude=1.0), state) == kept.told(
        Setpoint(depth=9.0, altitude=1.0), state
    )


# --- to the number ------------------------------------------------------------------------------------


BOTH = Setpoint(surge=0.5, heading=0.0, depth=8.0, altitude=3.0)


class Below:
    """What a clearance asks of a vehicle 2 m deep: the bottom that it sees now, m, or None; and
    the altitude that was told, of which none is the same as the one before."""

    depth = 2.0

    def __init__(self, now: float, bottom: float | None, told: float | None = None) -> None:
        self.now = now
        height = None if bottom is None else bottom - self.depth
        self.estimate = ESTIMATE._replace(t=now, depth=self.depth, altitude=height)
        self.telemetry = Telemetry(t=now, altitude=now if told is None else told)

    def health(self, sensor: str) -> Health:
        return Health(True, "", 0.0)


def held(*seen: tuple[float | None, ...], kept: Setpoint = BOTH) -> list[float | None]:
    """m, as told at each of these times over such a bottom."""
    clearance = Clearance(10.0, 1.0)
    return [clearance.told(kept, Below(*one)).depth for one in seen]  # type: ignore[arg-type]


@pytest.mark.replaces
def test_there_has_to_be_room_for_five_seconds():
    assert held((0.0, 9.0), (1.0, 11.5), (5.9, 11.5), (6.0, 11.5)) == [6.0, 6.0, 6.0, 8.0]


@pytest.mark.replaces
def test_room_for_just_what_is_held_is_none():
    assert held((0.0, 9.25), (1.0, 11.5), (5.0, 11.5), (6.0, 11.5)) == [6.0, 6.0, 6.0, 8.0]


@pytest.mark.replaces
def test_it_goes_down_to_the_least_room_of_the_five_seconds():
    assert held((0.0, 9.0), (1.0, 10.5), (4.0, 11.5), (6.0, 31.0)) == [6.0, 6.0, 6.0, 7.0]


@pytest.mark.replaces
def test_one_echo_is_no_room_however_often_it_is_told():
    """It repeats where there is none, or says nothing; the next that is new counts from it on."""
    told = [(0.0, 9.0), (1.0, 31.0, 29.0), (4.0, 31.0, 29.0), (5.0, None), (6.0, 31.0, 29.0)]
    assert held(*told, (8.0, 31.0, 29.0)) == [6.0] * 6
    assert held(*told, (8.0, 9.0)) == [6.0] * 6
    assert held(*told, (8.0, 31.1)) == [6.0] * 5 + [8.0]


@pytest.mark.replaces
def test_what_repeats_says_nothing_of_a_bottom_that_seems_to_sink_with_the_vehicle():
    """8 m again and again on the way down, over 9 m; then one wrong echo."""
    told = [(0.0, 9.0, 8.0), (2.0, 10.0, 8.0), (4.0, 11.0, 8.0), (6.0, 12.0, 8.0), (9.0, 24.0)]
    assert held(*told) == [6.0] * 5
    assert held(*told, (14.0, 24.1)) == [6.0] * 5 + [8.0]


@pytest.mark.replaces
@pytest.mark.parametrize("blind", [True, False])
def test_room_that_was_seen_before_an_interruption_is_none_behind_it(blind: bool):
    """Of the stick, say, or of six seconds without an echo: a single echo is one."""
    clearance = Clearance(10.0, 1.0)
    seen = [(0.0, 9.0), (4.0, 13.0)]
    seen += [(float(t), None) for t in range(11, 16)] if blind else []
    told = [clearance.told(BOTH, Below(*one)).depth for one in seen]  # type: ignore[arg-type]
    assert told == [6.0] * len(told)
    if not blind:
        clearance.begin()
    wrong = clearance.told(BOTH, Below(16.5, 20.0))  # type: ignore[arg-type]
    assert wrong.depth == 6.0


@pytest.mark.replaces
def test_the_last_bottom_stands_for_six_seconds():
    seen = [(0.0, 9.0), (6.0, None), (6.5, None), (11.0, None), (11.5, None)]
    assert held(*seen) == [6.0, 6.0, 6.0, 6.0, 7.0]


@pytest.mark.replaces
def test_a_depth_or_a_height_of_nought_is_one():
    assert held((0.0, 9.0), kept=Setpoint(depth=0.0, altitude=3.0)) == [0.0]
    assert held((0.0, 8.0), kept=Setpoint(depth=9.0, altitude=0.0)) == [8.0]


@pytest.mark.replaces
def test_a_set_with_one_of_both_is_the_vehicles_own():
    assert held((0.0, 5.0), kept=Setpoint(depth=8.0)) == [8.0]


@pytest.mark.replaces
def test_without_an_estimate_the_assumed_floor_counts():
    below = Below(0.0, None)
    below.estimate = None  # type: ignore[assignment]
    assert Clearance(10.0, 1.0).told(BOTH, below).depth == 7.0  # type: ignore[arg-type]
