"""R7: surfacing is proved by the depth, in the leg as in the emergency, and never given up."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest
from engine_world import VEHICLE, M, W, World, X, fixes, leg, mission, when

from links.simulated.waves import Waves
from mission.engine.ascent import DOWNWARD, Ascent
from mission.engine.vehicle_state import WRONG_FOR
from mission.legs import Surface
from mission.model import (
    IDLE_READY,
    STOPPED,
    SURFACED,
    SURFACING,
    AutoNode,
    LineOpened,
    Outcome,
    Restarted,
    Result,
)
from protocol.messages import UPWARD, ClearMission, Order, Setpoint, StartMission

LONG = 20000.0
WAYS = (Order.SURFACE, UPWARD, Order.STOP)


def surfacing(depth: float | None = 20.0) -> World:
    world = World(mission(leg("a", timeout=LONG)))
    assert world.start()
    world.depth = depth
    world.until(110.0)
    world.tell(W)
    world.actions.clear()
    return world


def climb(world: World, rate: float, seconds: float) -> None:
    for _ in range(round(seconds / 2.0)):
        world.depth = max(world.depth - 2.0 * rate, 0.0)
        world.wait(2.0)


def sent(world: World) -> list[tuple[float, Setpoint | Order]]:
    return [(round(t - 110.0, 3), a.command) for t, a in world.actions]


def test_while_the_depth_does_not_fall_all_ways_are_tried_in_turn_for_ever():
    world = surfacing()
    world.wait(60.5)
    assert sent(world) == [
        (10.0, UPWARD),
        (20.0, Order.STOP),
        (30.0, Order.SURFACE),
        (40.0, UPWARD),
        (60.0, Order.STOP),
    ]
    world.wait(3600.0)
    assert len(world.actions) == 5 + 3 * 90
    assert world.state == SURFACING


def test_what_makes_the_depth_fall_is_kept():
    world = surfacing()
    climb(world, 0.25, 60.0)
    assert sent(world) == []
    world = surfacing()
    world.wait(10.0)
    climb(world, 0.25, 60.0)
    assert sent(world) == [(10.0, UPWARD)]


def test_upward_is_full_thrust_and_nothing_else():
    assert Setpoint(heave=-1.0) == UPWARD


def begun(depth: float | None = 20.0, **more: bool) -> Ascent:
    return Ascent(0.0, depth, "why", WAYS, **more)


@pytest.mark.parametrize(
    ("depth", "more", "way"),
    [
        (20.0, {}, Order.SURFACE),
        (None, {}, UPWARD),
        (20.0, {"upward": True}, UPWARD),
        (20.0, {"overturned": True}, Order.STOP),
        (None, {"overturned": True}, Order.STOP),
    ],
)
def test_an_ascent_begins_with_what_is_likely_to_help(depth, more, way):
    ascent = begun(depth, **more)
    assert [a.command for a in ascent.first()] == [way]
    rest = [ascent.act(10.0 * (i + 1), depth, False)[0].command for i in range(3)]
    at = WAYS.index(way)
    assert rest == [WAYS[(at + i + 1) % 3] for i in range(3)]


def test_a_vehicle_with_one_push_is_let_go_in_turn():
    ascent = Ascent(0.0, None, "why", (Order.SURFACE, Order.STOP))
    said = [(t, a.command) for t in range(10, 60, 10) for a in ascent.act(float(t), None, False)]
    assert ascent.first()[0].command is Order.SURFACE
    turns = [(10, Order.STOP), (20, Order.SURFACE), (40, Order.STOP), (50, Order.SURFACE)]
    assert said == turns


# --- upside down ---------------------------------------------------------------------------------


def overturned_ways(depths, until: float = 200.0) -> list[tuple[float, Setpoint | Order]]:
    """What an ascent says upside down, asked every half second; ``depths(t, way)``."""
    ascent, t, said = begun(20.0, overturned=True), 0.0, [(0.0, Order.STOP)]
    while t < until:
        t += 0.5
        said += [(t, a.command) for a in ascent.act(t, depths(t, said[-1]), True)]
    return said


def test_upside_down_the_way_down_is_tried_for_five_seconds_once_a_minute():
    said = overturned_ways(lambda t, way: 20.0)
    down = [i for i, (_, way) in enumerate(said) if way == DOWNWARD]
    assert said[1] == (10.0, DOWNWARD)
    assert [said[i + 1][0] - said[i][0] for i in down] == [5.0] * len(down)
    begun = [said[i][0] for i in down]
    assert all(b - a >= 60.0 for a, b in pairwise(begun))
    assert len(begun) >= 3


def test_downward_is_given_up_at_once_when_it_leads_a_metre_deeper():
    def depth(t: float, last: tuple[float, Setpoint | Order]) -> float:
        return 20.0 + (t - last[0] if last[1] == DOWNWARD else 0.0)

    said = overturned_ways(depth, 20.0)
    at = next(i for i, (_, way) in enumerate(said) if way == DOWNWARD)
    assert said[at + 1][0] - said[at][0] == 1.5


def test_downward_that_lifts_is_kept_and_one_that_is_righted_ends():
    ascent = begun(20.0, overturned=True)
    assert ascent.act(10.0, 20.0, True)[0].command == DOWNWARD
    assert not ascent.act(15.0, 18.0, True)
    assert not ascent.act(20.0, 16.0, True)
    assert [a.command for a in ascent.act(20.5, 15.9, False)] == [Order.SURFACE]


def test_without_a_depth_to_believe_nothing_pushes_down():
    ascent = begun(None, overturned=True)
    said = [a.command for t in range(10, 200, 10) for a in ascent.act(float(t), None, True)]
    assert DOWNWARD not in said


def test_upside_down_without_a_depth_to_go_by_it_is_let_go_alone():
    """Every push may be one to the floor; upright again all ways take their turns."""
    ascent = begun(None, overturned=True)
    said = [a.command for t in range(10, 200, 10) for a in ascent.act(float(t), None, True)]
    assert set(said) == {Order.STOP}
    rest = [ascent.act(200.0 + 10.0 * i, None, False)[0].command for i in range(3)]
    assert rest == [*WAYS[:2], Order.STOP]


def test_where_it_may_be_upside_down_unseen_it_is_let_go_ever_longer():
    """Each push may lead down; and what is heavy needs one, so that it begins anew."""
    ascent, said = begun(None), []
    for t in range(10, 1100, 10):
        said += [(t, a.command) for a in ascent.act(float(t), None, False, True)]
    spans = [(way, b - a) for (a, way), (b, _) in pairwise(said)]
    let_go = [span for way, span in spans if way is Order.STOP]
    assert let_go[:7] == [10, 20, 40, 80, 160, 10, 20]
    assert {span for way, span in spans if way is not Order.STOP} == {10}


def test_a_depth_that_is_known_in_the_middle_of_a_turn_shows_whether_it_rises():
    ascent = begun(None)
    rising = [ascent.act(float(t), None if t < 3 else 20.0 - 0.1 * t, False) for t in range(1, 30)]
    assert not any(rising)
    ascent = begun(None)
    assert [t for t in range(1, 25) if ascent.act(float(t), None if t < 3 else 20.0, False)] == [
        10,
        20,
    ]


@pytest.mark.parametrize("seen", [(20.0, False, True), (None, False, False)])
def test_a_depth_or_an_attitude_that_is_known_again_ends_a_long_turn(seen):
    ascent, ticks = begun(None), iter(range(10, 400, 10))
    t = next(t for t in ticks if ascent.act(t, None, False, True) and ascent.next_timer() > t + 40)
    assert not ascent.act(t + 9.9, None, False, True)
    assert [a.command for a in ascent.act(t + 10.0, *seen)] == [Order.SURFACE]


def test_upside_down_a_push_that_has_led_a_metre_deeper_is_not_tried_again():
    """Afloat, under a sensor that is off: each turn of it was a dive of three metres."""
    depth, said, ascent = 1.4, [(0.0, Order.STOP)], begun(1.4, overturned=True)
    for tick in range(2, 1200):
        pushed = said[-1][1] in (UPWARD, Order.SURFACE)
        depth = depth + 0.15 if pushed else max(depth - 0.15, 1.4)
        said += [(tick / 2, a.command) for a in ascent.act(tick / 2, depth, True)]
    assert [way for _, way in said].count(UPWARD) == 1
    assert [way for _, way in said].count(Order.SURFACE) == 1
    ascent.act(600.0, 1.4, False)
    assert ascent.way is not Order.STOP


def test_upside_down_a_push_that_stops_a_rise_and_leads_a_metre_deeper_is_not_tried_again():
    """As flight 1509 of seed 1515: W began while D12's push still lifted it."""
    ascent = begun(20.0, overturned=True)
    assert ascent.act(10.0, 20.0, True)[0].command == DOWNWARD
    assert ascent.act(15.0, 20.0, True)[0].command is Order.SURFACE
    for t, depth in ((17.0, 19.2), (19.0, 19.0), (21.0, 19.5), (23.0, 20.1)):
        assert not ascent.act(t, depth, True)
    said = [a.command for t in range(25, 200) for a in ascent.act(float(t), 20.7, True)]
    assert Order.SURFACE not in said
    assert UPWARD in said


def test_three_hundredths_of_a_metre_a_second_is_rising_and_less_is_not():
    """At the instant when a way is judged; the numbers are exact in binary."""
    for fallen, kept in ((0.3125, True), (0.28125, False)):
        ascent = begun()
        assert ascent.act(9.99, 20.0, False) == ()
        assert (ascent.act(10.0, 20.0 - fallen, False) == ()) is kept


def test_a_way_that_turns_a_vehicle_round_is_kept_though_it_sank_on_before():
    """Heavy, or on a board that obeys late: deeper at the end of the turn, and rising."""
    ascent = begun(20.0)
    for t in range(2, 10, 2):
        assert not ascent.act(float(t), 20.0 + 0.2 * t, False)
    assert ascent.act(10.0, 22.0, False)[0].command == UPWARD
    for t, depth in ((12.0, 22.6), (14.0, 23.0), (16.0, 22.9), (18.0, 22.6), (20.0, 22.2)):
        assert not ascent.act(t, depth, False)
    assert not ascent.act(30.0, 21.0, False)


def test_one_wild_depth_in_each_turn_keeps_no_way_that_does_not_lift():
    """It looks as if it had sunk a metre and turned round: once in succession that is enough."""
    ascent, told = begun(6.0), 0.0
    while ascent.way is Order.SURFACE and told < 100.0:
        told += 2.0
        ascent.act(told, 6.0 + (3.0 if told % 10.0 == 6.0 else 0.0), False)
    assert told <= 50.0


def test_a_way_that_is_given_up_says_what_was_seen():
    for before, after, seen in (
        (20.0, 20.5, "is 20.5 m, no less"),
        (None, 20.0, "is not known"),
        (20.0, None, "is not known"),
    ):
        (action,) = begun(before).act(10.0, after, False)
        assert action.reason == f"why: after 10 s the depth {seen}"
        assert action.command in (UPWARD, Order.STOP)


def test_the_noise_of_a_depth_that_stands_keeps_no_way_for_long():
    """As calm flight 80 of seed 15: W, which left it at 6 m, was kept for minutes by noise of 0.2 m."""
    for seed in range(300):
        noise, ascent, told = random.Random(seed), begun(6.0), 0.0
        while ascent.way is Order.SURFACE and told < 100.0:
            told += 2.0
            ascent.act(told, 6.0 + noise.gauss(0.0, 0.2), False)
        assert told < 60.0, seed


def test_nor_that_of_a_depth_at_which_it_has_come_to_a_stand():
    """As calm flight 505 of seed 18: from 5 m W brought it to 3 m, and noise of 0.2 m kept it."""
    kept = []
    for seed in range(400):
        noise, ascent, told = random.Random(seed), begun(10.0), 0.0
        stands = noise.uniform(11.0, 29.0)
        while ascent.way is Order.SURFACE:
            told += 2.0
            depth = 10.0 - 0.25 * min(told, stands)
            ascent.act(told, depth + noise.gauss(0.0, 0.2), False)
        kept.append(told - stands)
    assert sum(kept) / len(kept) < 30.0
    assert sum(seconds > 60.0 for seconds in kept) <= 2


@pytest.mark.parametrize("period", [4.0, 6.5, 8.0, 12.0])
def test_waves_keep_no_way_for_long_under_which_it_stays_where_it_is(period: float):
    """As built W leaves it at its depth: 3 m deep in waves of 1 m it was kept for 4 minutes."""
    for seed in range(100):
        waves, ascent, told = Waves(1.0, period, seed), begun(3.0), 0.0
        while ascent.way is Order.SURFACE:
            told += 2.0
            ascent.act(told, 3.0 + waves.at(told, 3.0).head, False)
        assert told <= 60.0


@pytest.mark.parametrize("period", [4.0, 6.5, 8.0, 12.0])
def test_nor_do_waves_at_which_it_has_come_to_a_stand(period: float):
    """As flight 3512 of seed 9005: W brought it to 3 m, and what it had risen before counted on."""
    for seed in range(100):
        waves, ascent, told = Waves(0.75, period, seed), begun(20.0), 0.0
        stands = 12.0 + seed % 20
        while ascent.way is Order.SURFACE:
            told += 2.0
            depth = 3.0 + 0.3 * max(stands - told, 0.0)
            ascent.act(told, depth + waves.at(told, 3.0).head, False)
        assert told <= stands + 70.0


def test_in_waves_what_rises_is_kept():
    for seed in range(100):
        waves, ascent, depth = Waves(1.0, 8.0, seed), begun(20.0), 20.0
        for i in range(1, 50):
            depth = 20.0 - 0.3 * 2.0 * i
            ascent.act(2.0 * i, depth + waves.at(2.0 * i, depth).head, False)
            assert ascent.way is Order.SURFACE or depth < 1.0


def test_of_a_depth_that_comes_late_full_thrust_is_tried_for_longer():
    """As flight 8485 of seed 808: while it was let go it was seen to rise, from before."""
    ascent, depths = begun(20.0), [20.0] * 7
    for t in range(0, 400, 2):
        ascent.act(float(t), depths[-7], False)  # 12 s old
        depths.append(depths[-1] + (-0.3 if ascent.way == UPWARD else 0.6))
    assert min(depths) < 3.0


def test_a_rise_behind_a_sinking_that_shows_late_is_kept():
    """As flight 1499 of seed 13247: the depth is 9 s late, and the turn began less deep."""
    ascent = begun(10.8, upward=True, sank=True)
    for t in range(2, 62, 2):
        depth = 10.8 + 0.37 * min(t, 14) - 0.21 * max(t - 14, 0)
        assert not ascent.act(float(t), depth, False)
    assert ascent.way == UPWARD


def test_where_no_depth_tells_full_thrust_lasts_longer_each_time_it_comes_round():
    """What is heavy sinks in the turns of the others."""
    ascent, said = begun(None), [(0, UPWARD)]
    for t in range(1, 400):
        said += [(t, a.command) for a in ascent.act(float(t), None, False)]
    spans = [(way, b - a) for (a, way), (b, _) in pairwise(said)]
    assert [span for way, span in spans if way == UPWARD][:6] == [10, 20, 30, 40, 40, 40]
    assert {span for way, span in spans if way != UPWARD} == {10}


def test_full_thrust_whose_depth_is_doubted_on_the_way_has_its_turns_whatever_the_attitude_says():
    """As flight 9907 of seed 1414: heavy, its depth late and doubted behind 14 s of each push, and
    its attitude garbage; let go as soon as the depth was doubted it never came up."""
    ascent, said = begun(20.0), [(0, Order.SURFACE)]
    for t in range(1, 500):
        known = said[-1][1] != UPWARD or t - said[-1][0] <= 14
        acts = ascent.act(float(t), 20.0 if known else None, False, True)
        said += [(t, a.command) for a in acts]
    spans = [(way, b - a) for (a, way), (b, _) in pairwise(said)]
    assert [span for way, span in spans if way == UPWARD][:5] == [10, 20, 30, 40, 40]
    assert {span for way, span in spans if way != UPWARD} == {10}


def test_a_depth_that_is_known_again_judges_the_long_turn_of_full_thrust():
    for rate, kept in ((-0.25, True), (0.25, False)):
        ascent, ticks = begun(None), iter(range(10, 300, 10))
        t = next(t for t in ticks if not ascent.act(float(t), None, False) and t > 120)
        depths = {t + s: 20.0 + rate * s for s in range(1, 11)}
        acted = [a.command for at, depth in depths.items() for a in ascent.act(at, depth, False)]
        assert (acted == []) is kept


def test_a_copy_of_an_ascent_goes_its_own_way():
    ascent = begun()
    copy = ascent.clone()
    assert ascent.act(10.0, 20.0, False)
    assert (copy.began, copy.next_timer()) == (0.0, 10.0)
    assert copy.act(10.0, 20.0, False)[0].command == UPWARD


def test_a_way_that_stops_working_is_changed_again():
    world = surfacing()
    climb(world, 0.25, 30.0)
    world.wait(40.0)
    assert [c for _, c in sent(world)] == [Order.SURFACE, UPWARD, Order.STOP, Order.SURFACE]


def test_a_way_that_stops_working_is_said_once_more_before_it_is_changed():
    """The board may have lost it; what never worked is not."""
    ascent = begun()
    assert not ascent.act(10.0, 18.0, False)
    again, then = (ascent.act(t, 18.0, False)[0] for t in (20.0, 30.0))
    assert (again.command, then.command) == (Order.SURFACE, UPWARD)
    assert "said again" in again.reason
    assert ascent.act(40.0, 18.0, False)[0].command is Order.STOP


@pytest.mark.parametrize(("last", "kept"), [(21.4, True), (21.45, False)])
def test_a_way_under_which_what_sank_has_just_turned_round_has_another_turn(last, kept: bool):
    ascent = begun()
    for t in range(1, 10):
        assert not ascent.act(float(t), min(20.0 + 0.25 * t, 21.5), False)
    assert (ascent.act(10.0, last, False) == ()) is kept


def test_an_operator_who_says_w_again_and_again_keeps_no_other_way_back():
    """One leaves in each turn of another way, and behind it that way."""
    world = surfacing()
    for _ in range(50):
        world.wait(0.5)
        world.tell(W)
    said = [(t, c) for t, c in sent(world) if t >= 10.0]
    assert [c for _, c in said] == [
        *(UPWARD, Order.SURFACE, UPWARD),
        *(Order.STOP, Order.SURFACE, Order.STOP),
    ]
    assert [t for t, _ in said] == pytest.approx([10.0] * 3 + [20.0] * 3, abs=0.6)


def test_in_its_own_turn_each_w_of_an_operator_leaves():
    world = surfacing()
    for _ in range(3):
        world.wait(1.0)
        world.tell(W)
    assert sent(world) == [(t, Order.SURFACE) for t in (1.0, 2.0, 3.0)]


@pytest.mark.parametrize(
    ("sank", "depth", "turn"),
    [(False, 3.0, 10.0), (True, 3.0, 20.0), (False, None, 10.0), (True, None, 40.0)],
)
def test_what_sank_when_it_was_let_go_has_long_turns_of_full_thrust_at_once(
    sank: bool, depth: float | None, turn: float
):
    """In one a depth that is 12 s late shows no rise, and fixes have no time to settle."""
    ascent = Ascent(0.0, depth, "why", WAYS, upward=True, sank=sank)
    assert next(t for t in range(60) if ascent.act(float(t), depth, False)) == turn


@pytest.mark.parametrize("again", [(), (0.3,), (0.3, 0.3, 0.3)])
def test_an_operators_w_has_a_second_on_the_line_before_the_next_way(again):
    """Once a turn, however often it is said."""
    world = surfacing()
    world.wait(19.9)
    world.tell(W)
    for pause in again:
        world.wait(pause)
        world.tell(W)
    world.wait(3.0)
    said = [(t, c) for t, c in sent(world) if t > 10.0]
    assert said[:2] == [(19.9, Order.SURFACE), (19.9, UPWARD)]
    stopped = next(t for t, c in said if c is Order.STOP)
    assert stopped == pytest.approx(20.9, abs=0.06)


def test_what_an_operator_said_while_the_line_was_away_does_not_count_as_said():
    """Nobody may have heard it: the next W leaves again in the same turn."""
    world = surfacing()
    world.wait(11.0)
    world.tell(W)
    world.tell(W)
    world.tell(LineOpened())
    world.tell(W)
    world.tell(W)
    said = [c for t, c in sent(world) if t > 10.5]
    assert said == [Order.SURFACE, UPWARD, UPWARD, Order.SURFACE, UPWARD]


@pytest.mark.parametrize("doubt", ["frozen", "absurd", "missing"])
def test_an_unknown_depth_counts_as_not_falling(doubt: str):
    world = surfacing()
    world.nav.doubt["depth"] = doubt
    climb(world, 0.25, 40.0)
    assert [c for _, c in sent(world)] == [UPWARD, Order.STOP, Order.SURFACE, UPWARD]


def test_it_goes_on_without_any_report():
    world = surfacing()
    world.wait(40.5, reports=False)
    assert len(sent(world)) == 4


def test_the_surface_is_six_seconds_of_shallow_depth():
    world = surfacing()
    climb(world, 0.5, 38.0)
    world.depth = 0.4
    world.wait(7.9)
    assert world.state == SURFACING
    world.wait(0.2)
    assert world.state == SURFACED
    assert world.commands()[-1] is Order.STOP


def test_a_depth_in_the_air_proves_no_surface_and_a_fix_beside_it_does():
    """As flight 13619 of seed 707: a zero that drifts, 9 m off, said 2 m above the water."""
    world = surfacing()
    climb(world, 0.5, 38.0)
    for _ in range(20):
        world.depth = -0.9 if world.depth > -0.85 else world.depth - 0.05
        world.wait(2.0)
    assert world.state == SURFACING
    fixes(world, 2)
    assert world.state == SURFACED


def test_a_zero_that_is_half_a_metre_off_is_the_surface_all_the_same():
    world = surfacing()
    climb(world, 0.5, 38.0)
    world.depth = -0.6
    world.wait(8.1)
    assert world.state == SURFACED


def test_a_wave_over_the_hull_begins_the_six_seconds_anew():
    world = surfacing()
    for _ in range(10):
        world.depth = 0.3
        world.wait(4.0)
        world.depth = 0.8
        world.wait(2.0)
    assert world.state == SURFACING


def test_the_way_up_counts_from_the_last_depth_that_was_believed():
    """Not from the first word of an ascent that had not risen until then."""
    world = surfacing(14.0)
    world.wait(100.0)
    world.nav.doubt["depth"] = "contradicted: it stands"
    fixes(world, int(14.0 / VEHICLE.ascent_buoyancy) - 1)
    assert world.state == SURFACING
    fixes(world, int((VEHICLE.limits.depth - 14.0) / VEHICLE.ascent_buoyancy) + 10)
    assert world.state == SURFACED


def test_what_it_may_have_sunk_counts_from_the_last_change_of_a_depth_that_stood():
    """It may have frozen at the surface, and the vehicle gone down since."""
    world = World(mission(leg("a", timeout=LONG)))
    world.depth = 0.2
    world.wait(10.0)
    world.trembles = 0.0
    world.wait(90.0)
    world.nav.doubt["depth"] = "frozen"
    world.tell(W)
    least = VEHICLE.limits.descent_rate * (WRONG_FOR + 80.0) / VEHICLE.ascent_buoyancy
    fixes(world, int(least))
    assert world.state == SURFACING
    fixes(world, int(VEHICLE.limits.depth / VEHICLE.ascent_buoyancy - least) + 10)
    assert world.state == SURFACED


def test_the_way_up_is_from_the_vehicles_own_depth_at_most_whatever_was_believed():
    """As flight 13171 of seed 5919: the first report said 945 m, and the next ones were absurd."""
    world = surfacing(945.0)
    world.wait(4.0)
    world.nav.doubt["depth"] = "absurd"
    fixes(world, int(VEHICLE.limits.depth / VEHICLE.ascent_buoyancy) - 10)
    assert world.state == SURFACING
    fixes(world, 30)
    assert world.state == SURFACED


def test_an_operator_who_says_w_again_and_again_puts_off_no_end_of_an_ascent():
    world = surfacing(None)
    for _ in range(int(VEHICLE.limits.depth / VEHICLE.ascent_buoyancy / 5.0) + 3):
        if world.state == SURFACING:
            world.tell(W)
        fixes(world, 5)
    assert world.state == SURFACED


def test_seconds_of_fixes_are_the_surface_too_where_no_depth_is_believed():
    world = surfacing(0.6)
    world.nav.doubt["depth"] = "contradicted: it stands"
    world.wait(60.0)
    fixes(world, 5)
    assert world.state == SURFACING
    fixes(world, 2)
    assert world.state == SURFACED
    assert world.commands()[-1] is Order.STOP


def test_what_sank_out_of_surfaced_is_brought_up_by_the_first_depth_that_is_known_there():
    """The surface was proved by fixes; no depth was known in surfaced before."""
    world = surfacing(0.6)
    world.nav.doubt["depth"] = "absurd"
    world.wait(60.0)
    fixes(world, 7)
    assert world.state == SURFACED
    fixes(world, 20)
    assert world.state == SURFACED
    world.nav.doubt.clear()
    world.depth = 20.0
    world.wait(6.0)
    assert world.state == SURFACING


def unseen_at_the_surface(waited: float) -> World:
    """Proved by fixes alone; ``waited``: s from the ascent's begin until they come."""
    world = surfacing(0.6)
    world.nav.doubt["depth"] = "absurd"
    world.wait(waited)
    fixes(world, 7)
    assert world.state == SURFACED
    return world


@pytest.mark.parametrize("waited", [62.0, 72.0])  # in a turn of letting go, and of a push
def test_what_sinks_unseen_is_brought_up_when_its_fixes_end_and_then_held_up(waited: float):
    """Heavy, and no depth: let go, it would sink for ever without a word."""
    world = unseen_at_the_surface(waited)
    world.wait(6.0)
    assert world.state == SURFACED
    world.wait(6.0)
    assert world.state == SURFACING
    assert world.commands()[-1] == UPWARD
    while world.state == SURFACING:
        fixes(world, 1)
    assert world.state == SURFACED


def said_again(world: World, seconds: int, places: int) -> None:
    """One a second, a few in turn: a receiver that got stuck goes on under water."""
    for i in range(seconds):
        world.tell(world.fix(north=5.0 + i % places))
        world.wait(1.0)


@pytest.mark.parametrize("places", [1, 2, 5])
def test_what_sinks_unseen_is_brought_up_when_its_receiver_says_no_new_place(places: int):
    """As draw 14025 of the sea: two places in turn, to the bottom without a word."""
    world = unseen_at_the_surface(72.0)
    fixes(world, 20)
    said_again(world, 18 + places, places)
    assert world.state == SURFACED
    said_again(world, 4, places)
    assert world.state == SURFACING
    assert world.commands()[-1] == UPWARD


def test_a_receiver_that_says_no_new_place_long_after_it_was_let_go_turns_no_thruster():
    world = unseen_at_the_surface(72.0)
    fixes(world, 45)
    said_again(world, 60, 2)
    assert world.state == SURFACED


def test_fixes_that_end_unseen_long_after_it_was_let_go_turn_no_thruster():
    lifted = unseen_at_the_surface(72.0)
    fixes(lifted, 62)
    lifted.wait(60.0)
    assert lifted.state == SURFACED
    closed = unseen_at_the_surface(72.0)
    closed.tell(AutoNode(False))
    closed.wait(60.0)
    assert closed.state == SURFACED


RISE, SINK = VEHICLE.ascent_buoyancy, VEHICLE.limits.descent_rate
OWN_DEPTH = VEHICLE.limits.depth


def surfaces_after(world: World, seconds: float) -> bool:
    """By fixes alone, and not before: two fixes are a second apart, two reports two seconds."""
    fixes(world, int(seconds) - 3)
    if world.state != SURFACING:
        return False
    fixes(world, 6)
    return world.state == SURFACED


@pytest.mark.parametrize("depth", [0.3, 3.0, 20.0])
def test_without_a_depth_no_fix_proves_the_surface_before_it_can_have_come_up(depth: float):
    """From where it was last believed to be, and what it sinks in the 20 s for which that may have
    been wrong already."""
    world = surfacing(depth)
    world.nav.doubt["depth"] = "absurd"
    assert surfaces_after(world, (depth + 20.0 * SINK) / RISE)


@pytest.mark.parametrize("unseen", [4.0, 30.0])
def test_it_comes_up_from_where_a_dive_that_nobody_saw_has_led(unseen: float):
    """The time of the way up begins with the ascent's first word, not with the last belief."""
    world = World(mission(leg("a", timeout=LONG)))
    assert world.start()
    world.depth = 5.0
    world.wait(4.0)
    believed = world.t
    world.nav.doubt["depth"] = "frozen"
    while world.state != SURFACING and world.t < believed + unseen:
        world.wait(0.5)
    if world.state != SURFACING:
        world.tell(W)
    sunk = SINK * (20.0 + world.t - believed)
    assert surfaces_after(world, (5.0 + sunk) / RISE)


def test_whatever_nobody_saw_it_is_up_after_the_way_from_its_own_depth():
    """So that an ascent without a depth ends, at the surface, however long the depth was unknown."""
    world = World()
    world.depth = 5.0
    world.wait(4.0)
    world.nav.doubt["depth"] = "frozen"
    world.wait(3600.0)
    world.tell(W)
    assert surfaces_after(world, OWN_DEPTH / RISE)


def test_a_program_that_never_believed_a_depth_counts_from_the_vehicles_own():
    world = World()
    world.nav.doubt["depth"] = "absurd"
    world.wait(10.0)
    world.tell(W)
    assert surfaces_after(world, OWN_DEPTH / RISE)


def test_a_stick_ends_the_way_up_and_the_next_ascent_counts_anew():
    world = surfacing(3.0)
    world.nav.doubt["depth"] = "absurd"
    way_up = (3.0 + 20.0 * SINK) / RISE
    world.wait(way_up)
    world.push()
    world.wait(1.0)
    world.tell(W)
    fixes(world, 30)
    assert world.state == SURFACING


@pytest.mark.parametrize("depth", [0.2, 0.7, None])
def test_after_a_restart_fixes_beside_a_depth_that_has_not_changed_wait_for_the_way_up(
    depth: float | None,
):
    """It may be stuck, under water, and the receiver make its places up: nothing is known but how
    deep the vehicle can be."""
    world = World(navigation=False)
    world.trembles = 0.0
    world.depth = depth
    world.tell(Restarted(SURFACING))
    assert surfaces_after(world, OWN_DEPTH / RISE)


def test_after_a_restart_a_fix_beside_a_depth_that_has_changed_is_the_surface():
    world = World(navigation=False)
    world.depth = 0.6
    world.tell(Restarted(SURFACING))
    world.wait(6.5)
    world.depth = 0.7
    world.wait(2.0)
    fixes(world, 1)
    assert world.state == SURFACED


@pytest.mark.parametrize("moves", [True, False])
def test_after_a_restart_a_depth_counts_as_believed_once_it_has_changed(moves: bool):
    world = World()
    world.trembles = 0.0
    world.depth = 8.0
    world.tell(Restarted(SURFACING))
    world.wait(2.0)
    world.depth = 7.9 if moves else 8.0
    world.wait(2.0)
    world.nav.doubt["depth"] = "frozen"
    fixes(world, int((8.0 + 20.0 * SINK) / RISE) + 10)
    assert (world.state == SURFACED) is moves


@pytest.mark.parametrize("changes", [{"hdop": 9.0}, {"satellites": 3}, {"speed": 12.0}])
def test_fixes_that_are_not_as_at_the_surface_prove_none(changes: dict[str, float]):
    world = surfacing()
    world.nav.doubt["depth"] = "frozen"
    fixes(world, 60, **changes)
    assert world.state == SURFACING


def test_fixes_with_gaps_or_leaps_prove_no_surface_where_no_depth_is_believed():
    for step, gap in ((0.5, 3.0), (40.0, 1.0)):
        world = surfacing()
        world.nav.doubt["depth"] = "frozen"
        for i in range(30):
            world.tell(world.fix(north=step * i))
            world.wait(gap)
        assert world.state == SURFACING


def test_fixes_end_no_ascent_against_a_believed_depth_under_water():
    world = surfacing()
    fixes(world, 120)
    assert world.state == SURFACING
    world.depth = 0.7
    world.wait(2.0)
    fixes(world, 1)
    assert world.state == SURFACED


@pytest.mark.parametrize("places", [(0.0,), (0.0, 3.0), (0.0, 3.0, -2.0, 5.0)])
@pytest.mark.parametrize("pause", [1.0, 8.0])
def test_a_receiver_that_goes_on_saying_places_that_it_has_said_proves_no_surface(
    places: tuple[float, ...], pause: float
):
    world = World(mission(leg("a", timeout=LONG)))
    assert world.start()
    world.depth = 0.7
    world.wait(2.0)
    for i in range(40):  # to the last bit
        world.tell(world.fix(north=places[i % len(places)]))
        if i == 5:
            world.tell(W)
        world.wait(pause)
    assert world.state == SURFACING
    world.tell(world.fix(north=0.2))
    assert world.state == SURFACED


def test_a_fix_from_before_is_not():
    world = World(mission(leg("a", timeout=LONG)))
    assert world.start()
    world.depth = 5.0
    world.wait(4.0)
    world.tell(world.fix())
    world.tell(W)
    world.wait(8.0)
    assert world.state == SURFACING


def test_w_at_the_surface_is_proved_there_too():
    world = surfacing(depth=0.2)
    assert world.state == SURFACING
    world.wait(6.1)
    assert world.state == SURFACED


@pytest.mark.parametrize("fixed", [False, True])
def test_a_depth_that_has_not_changed_since_the_ascent_began_proves_no_surface(fixed: bool):
    """It may have frozen shallow while nothing moved: a few seconds of thrust do not tell yet."""
    world = World(mission(leg("a", timeout=LONG)))
    assert world.start()
    world.tell(X)
    world.depth, world.trembles = 0.2, 0.0
    world.wait(60.0)
    world.tell(W)
    for _ in range(12):
        world.wait(1.0)
        if fixed:
            world.tell(world.fix(north=0.2 * world.t))
    assert world.state == SURFACING
    world.depth, world.trembles = 0.25, 0.001
    world.wait(10.1)
    assert world.state == SURFACED


@pytest.mark.parametrize("depth", [0.0, 0.3, 0.499])
def test_a_depth_that_dies_as_a_shallow_one_proves_no_surface(depth: float):
    """Zero is what a board says whose sensor has died, and the ascent goes on; fixes end it."""
    world = surfacing(depth=4.0)
    world.wait(4.0)
    world.depth, world.trembles = depth, 0.0
    world.wait(300.0)
    assert world.state == SURFACING
    world.tell(world.fix(north=5.0))
    assert world.state == SURFACED


def test_after_an_x_in_mid_ascent_the_time_of_the_rise_counts_no_further():
    """What was let go may sink again: fixes alone say nothing of where it is."""
    world = surfacing(depth=8.0)
    world.wait(4.0)
    world.depth = None
    world.tell(X)
    fixes(world, int(OWN_DEPTH / RISE) + 60)
    assert world.state == STOPPED
    assert not world.tell(ClearMission()).verdicts[0].accepted


def test_surfaced_is_latched():
    world = surfacing(depth=0.2)
    world.wait(10.0)
    begun = len(world.actions)
    world.depth = 0.9
    world.wait(100.0)
    assert world.state == SURFACED
    assert len(world.actions) == begun


# --- the same ascent as a leg --------------------------------------------------------------


def test_the_end_of_a_mission_is_an_ascent_and_then_idle():
    world = World(mission(leg("a", timeout=None, duration=10.0)))
    assert world.start()
    world.depth = 6.0
    world.wait(12.0)
    assert world.state == "autonomous/surface"
    climb(world, 0.5, 20.0)
    assert world.state == IDLE_READY
    assert world.commands()[-2:] == [Order.SURFACE, Order.STOP]


def test_a_surface_leg_ends_at_the_surface_and_the_next_leg_begins_with_a_stop():
    up = leg("up", kind=Surface(), settings=(), timeout=300.0)
    world = World(mission(leg("a", when("elapsed", ">", 5.0)), up, leg("b", timeout=LONG)))
    assert world.start()
    world.depth = 4.0
    world.wait(8.0)
    assert world.state == "autonomous/up"
    climb(world, 0.5, 16.0)
    assert world.state == "autonomous/b"
    stop, back = world.commands()[-2:]
    assert stop is Order.STOP
    assert isinstance(back, Setpoint)


def waiting_for_a_fix() -> World:
    up = leg("up", kind=Surface(until_fix=True), settings=(), timeout=300.0)
    world = World(mission(leg("a", when("elapsed", ">", 5.0)), up, leg("b", timeout=LONG)))
    assert world.start()
    world.depth = 0.2
    world.wait(60.0)
    return world


def test_until_fix_waits_at_the_surface_with_everything_stopped():
    world = waiting_for_a_fix()
    assert world.state == "autonomous/up"
    assert [c for c in world.commands() if c is Order.STOP] == [Order.STOP]
    world.tell(world.fix(north=0.2))
    assert world.state == "autonomous/b"


def test_until_fix_waits_for_one_that_navigation_takes():
    """What it refuses as too far off tells nothing of where the next leg begins."""
    world = waiting_for_a_fix()
    taken = world.nav.fix
    world.nav.fix = lambda _: None
    for _ in range(2):
        world.tell(world.fix(north=0.2))
        world.t += 1.0
    assert world.state == "autonomous/up"
    world.nav.fix = taken
    world.tell(world.fix(north=0.3))
    assert world.state == "autonomous/b"


def test_a_surface_leg_for_a_time_stays_up_for_it():
    up = leg("up", kind=Surface(), settings=(), timeout=None, duration=90.0)
    world = World(mission(leg("a", when("elapsed", ">", 5.0)), up, leg("b", timeout=LONG)))
    assert world.start()
    world.depth = 0.2
    world.wait(90.0)
    assert world.state == "autonomous/up"
    assert world.commands()[-1] is Order.STOP
    world.wait(6.0)
    assert world.state == "autonomous/b"


def test_up_and_then_the_missions_end_climbs_once():
    up = leg("up", kind=Surface(), settings=(), timeout=300.0)
    world = World(mission(leg("a", when("elapsed", ">", 5.0)), up))
    assert world.start()
    world.depth = 4.0
    world.wait(8.0)
    climb(world, 0.5, 20.0)
    assert world.state == IDLE_READY
    assert world.commands().count(Order.SURFACE) == 1
    assert world.commands()[-1] is Order.STOP


# --- proved, and still so ---


@pytest.mark.parametrize(("sinks", "over"), [(0.0, True), (0.03, False)])
def test_a_fix_of_minutes_ago_ends_no_mission_under_water(sinks: float, over: bool):
    """The leg that follows begins an ascent of its own."""
    world = World(mission(leg("up", kind=Surface(), settings=(), duration=240.0, timeout=None)))
    assert world.start()
    world.wait(8.0)
    world.tell(world.fix(3.0))
    while world.t < 400.0 and world.state != IDLE_READY:
        world.depth += 2.0 * sinks
        world.wait(2.0)
    assert (world.state == IDLE_READY) is over


def test_what_is_lifted_is_up_by_what_proves_it_behind_the_lift():
    world = World()
    world.tell(world.report())
    world.tell(W)
    world.wait(10.0)
    while world.state == SURFACED:
        world.depth += 0.4
        world.wait(2.0)
    while world.commands()[-1] is not Order.STOP:
        world.wait(1.0)
    world.depth = 0.7
    world.tell(world.report())
    world.tell(world.fix(5.0))  # it proves the surface, and full thrust takes over
    assert world.commands()[-1] == UPWARD
    for _ in range(6):
        world.depth += 0.4
        world.wait(2.0)
        assert world.state == SURFACING


def test_an_operators_w_goes_on_with_the_ascent_of_a_leg():
    world = World(
        mission(
            leg("a", duration=4.0, timeout=None),
            leg("up", kind=Surface(), settings=(), timeout=LONG),
        )
    )
    assert world.start()
    world.depth = 20.0
    world.wait(18.0)
    assert world.commands()[-1] == UPWARD
    world.tell(W)
    assert (world.state, world.commands()[-2:]) == (SURFACING, [Order.SURFACE, UPWARD])


# --- the stop at the end of a leg's ascent ---


def leg_is_up(duration: float | None = None) -> World:
    """A leg's ascent has proved the surface, and waits there for a fix."""
    up = leg("up", kind=Surface(until_fix=True), settings=(), timeout=LONG, duration=duration)
    world = World(mission(leg("a", timeout=None, duration=20.0), up))
    assert world.start()
    world.depth = 5.0
    world.wait(24.0)
    climb(world, 0.5, 14.0)
    while world.commands()[-1] is not Order.STOP:
        world.wait(0.5)
    assert world.state == "autonomous/up"
    return world


@pytest.mark.parametrize("fixed", [True, False])
def test_a_leg_that_waits_for_a_fix_for_a_time_is_over_with_the_first_of_both(fixed: bool) -> None:
    world = leg_is_up(duration=120.0)
    for north in range(10):
        world.wait(1.0)
        if fixed:
            world.tell(world.fix(float(north)))
    assert world.state == (IDLE_READY if fixed else "autonomous/up")
    world.wait(120.0)
    assert world.state == IDLE_READY


def test_the_stop_of_a_leg_that_is_up_is_said_again_until_it_is_acknowledged():
    world = leg_is_up()
    world.answer = None
    world.tell(LineOpened())
    said = len(world.actions)
    world.wait(2.0)
    assert world.commands()[said:] == [Order.STOP] * 4
    world.tell(Outcome(Result.ACCEPTED, b"@ZAX0$", Order.STOP))
    said = len(world.actions)
    world.wait(20.0)
    assert len(world.actions) == said


def test_the_stop_of_a_leg_that_is_up_is_said_again_while_a_thruster_turns():
    world = leg_is_up()
    said = len(world.actions)
    world.wait(20.0)
    assert len(world.actions) == said
    world.stops, world.actuators = False, (0.0, 0.0, 1.0, 1.0, 1.0)
    world.wait(10.0)
    assert set(world.commands()[said:]) == {Order.STOP}
    assert len(world.actions) - said >= 4
    world.stops = True
    world.wait(4.0)
    said = len(world.actions)
    for north in range(8):
        world.wait(1.0)
        world.tell(world.fix(float(north)))
    assert world.state == IDLE_READY


@pytest.mark.parametrize("fixed", [True, False])
def test_a_leg_that_goes_on_behind_the_stick_is_up_by_what_is_seen_then(fixed: bool):
    """It begins anew, and a fix that came under the stick is none of its own."""
    world = leg_is_up()
    world.tell(M)
    if fixed:
        world.tell(world.fix(4.0))
    world.depth = 2.9
    world.wait(2.05)
    world.tell(StartMission())
    assert world.state == "autonomous/up"
    said = len(world.actions)
    world.wait(12.0)
    assert world.state == "autonomous/up"
    assert Order.SURFACE in world.commands()[said - 1 :]
    world.depth = 0.2
    while world.commands()[-1] is not Order.STOP:
        world.wait(1.0)
    world.answer = None
    world.tell(LineOpened())
    said = len(world.actions)
    world.wait(2.0)
    assert world.commands()[said:] == [Order.STOP] * 4
