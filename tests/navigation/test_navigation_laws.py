"""Single laws of the estimate: order, gates, restarts, silence."""

from __future__ import annotations

import math
import random
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace

import pytest
from kinematic_truth import HOME, Sea, Truth, sail

from mission.model import Estimate, NavigationMode, Position
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from mission.navigation import LocalFrame, Navigation
from mission.navigation.distribution import PLANE_95, around_95, principal
from mission.navigation.geodesy import EARTH
from mission.navigation.kalman import KalmanFilter
from mission.navigation.model import CN, COMPASS, DEVIATION, SCALE
from protocol.added import GROUND, PLACE
from protocol.messages import Aid, Fix, Telemetry

Item = tuple[Truth, Telemetry | Fix]


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return replace(load_vehicle("auv"), declination=0.0)


@pytest.fixture(scope="module")
def dive() -> list[Item]:
    return list(sail(Sea(), 200.0, 300.0, 1))


def feed(nav: Navigation, items: list[Item]) -> Navigation:
    for _, item in items:
        if isinstance(item, Telemetry):
            nav.telemetry(item)
        else:
            nav.fix(item)
    return nav


def error(nav: Navigation, truth: Truth) -> float:
    estimate = nav.estimate(truth.t)
    assert estimate is not None
    return math.hypot(estimate.north - truth.north, estimate.east - truth.east)


def test_importing_the_room_does_not_import_the_filter() -> None:
    code = "import mission.navigation, sys; sys.exit('filterpy' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_nothing_heard_nothing_said(vehicle: Vehicle) -> None:
    assert Navigation(vehicle).estimate(10.0) is None


def test_without_any_fix_there_is_depth_and_heading_but_no_position(vehicle: Vehicle) -> None:
    nav = Navigation(vehicle, HOME)
    nav.telemetry(Telemetry(1.0, depth=3.0, heading=0.5))
    estimate = nav.estimate(1.0)
    assert estimate is not None
    assert estimate.mode is NavigationMode.NONE
    assert estimate.depth == pytest.approx(3.0, abs=1e-3)
    assert estimate.heading == pytest.approx(0.5)
    assert estimate.covariance[0] > 1e6


def test_the_current_and_the_scale_learned_at_the_surface_carry_the_dive(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    under = [i for i, (truth, _) in enumerate(dive) if truth.depth > 5.0]
    learned = feed(Navigation(vehicle, HOME), dive[: under[-1]])
    once = [item for item in dive[: under[-1]] if not isinstance(item[1], Fix)]
    first = next(item for item in dive if isinstance(item[1], Fix))
    naive = feed(Navigation(vehicle, HOME), [first, *once])
    truth = dive[under[-1]][0]
    assert error(learned, truth) < 0.5 * error(naive, truth)


def test_late_fixes_leave_the_same_estimate_as_punctual_ones(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    punctual = feed(Navigation(vehicle, HOME), dive[:200])
    late: list[Item] = []
    held: list[tuple[int, Item]] = []
    for i, item in enumerate(dive[:200]):
        if isinstance(item[1], Fix) and i % 3 == 1 and i > 20:
            held.append((i + 5, item))
        else:
            late.append(item)
        while held and held[0][0] <= i:
            late.append(held.pop(0)[1])
    late += [item for _, item in held]
    delayed = feed(Navigation(vehicle, HOME), late)
    assert delayed.dropped == 0
    assert delayed.estimate(500.0) == punctual.estimate(500.0)


@pytest.mark.parametrize("lag", [0.05, 0.2, 0.9])
def test_the_first_fix_counts_though_a_report_came_before_it(vehicle: Vehicle, lag: float) -> None:
    """Waves wash over an antenna: there may be one, and a dive behind it. It was dropped, and the
    radius of the whole dive with it."""
    nav = Navigation(vehicle)
    for t in (1.0, 3.0, 5.0):
        nav.telemetry(Telemetry(t, depth=0.2, heading=0.5))
    nav.fix(Fix(5.0 - lag, 0.5, 2.0, 2.5))
    assert nav.dropped == 0
    nav.set_origin(HOME, 5.5)
    there = nav.estimate(6.0)
    assert there is not None
    assert there.mode is NavigationMode.FIX
    assert there.covariance[0] < 10.0
    home = LocalFrame(HOME).to_local(0.5, 2.0)
    assert (there.north, there.east) == pytest.approx(home, abs=1.0)


@pytest.mark.parametrize(("lag", "counts"), [(0.5, True), (1.05, False)])
def test_what_is_late_behind_a_start_counts_as_of_that_within_a_second(
    vehicle: Vehicle, dive: list[Item], lag: float, counts: bool
) -> None:
    nav = feed(Navigation(vehicle, HOME), dive[:200])
    t = dive[199][0].t
    nav.assume_current(0.5)
    place = LocalFrame(HOME).to_geodetic(dive[199][0].north, dive[199][0].east)
    nav.fix(Fix(t - lag, *place, 2.5))
    assert nav.dropped == (0 if counts else 1)
    later = nav.estimate(t + 1.0)
    assert later is not None
    assert math.hypot(later.north - dive[199][0].north, later.east - dive[199][0].east) < 6.0


def test_what_comes_far_too_late_is_dropped_and_counted(vehicle: Vehicle, dive: list[Item]) -> None:
    nav = feed(Navigation(vehicle, HOME), dive[:200])
    before = nav.estimate(200.0)
    nav.fix(Fix(1.0, 0.5, 2.0, 2.5))
    assert nav.dropped == 1
    assert nav.estimate(200.0) == before


def test_one_wild_fix_does_not_move_the_estimate(vehicle: Vehicle, dive: list[Item]) -> None:
    nav = feed(Navigation(vehicle, HOME), dive[:200])
    truth = dive[199][0]
    wild = LocalFrame(HOME).to_geodetic(truth.north + 500.0, truth.east)
    nav.fix(Fix(truth.t + 0.5, *wild, 2.5))
    assert error(nav, truth) < 6.0


def test_fixes_that_agree_win_against_a_wrong_estimate(vehicle: Vehicle, dive: list[Item]) -> None:
    """As if somebody had carried the vehicle 300 m: the gate must not hold for ever."""
    nav = feed(Navigation(vehicle, HOME), dive[:200])
    frame = LocalFrame(HOME)
    shifted: list[Item] = []
    for truth, item in dive[200:260]:
        moved = replace(truth, north=truth.north + 300.0)
        if isinstance(item, Fix):
            n, e = frame.to_local(item.latitude, item.longitude)
            lat, lon = frame.to_geodetic(n + 300.0, e)
            item = replace(item, latitude=lat, longitude=lon)
        shifted.append((moved, item))
    feed(nav, shifted)
    assert error(nav, shifted[-1][0]) < 10.0


def test_wild_fixes_that_agree_lose_as_long_as_true_ones_come_between(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    """As of a second antenna's reflection: not three in a row."""
    nav = feed(Navigation(vehicle, HOME), dive[:200])
    frame = LocalFrame(HOME)
    for truth, item in dive[200:260]:
        feed(nav, [(truth, item)])
        if isinstance(item, Fix):
            n, e = frame.to_local(item.latitude, item.longitude)
            lat, lon = frame.to_geodetic(n + 300.0, e)
            nav.fix(replace(item, t=item.t + 0.05, latitude=lat, longitude=lon))
            assert error(nav, truth) < 10.0


def with_fixes_of_before(dive: list[Item], stale: int, jitter: float) -> list[Item]:
    """At each surfacing the receiver first says ``stale`` places of before the dive again, each
    ``jitter`` m beside what it was."""
    items, last, frame = list[Item](), list[Fix](), LocalFrame(HOME)
    for truth, item in dive:
        if isinstance(item, Fix):
            if last and item.t - last[-1].t > 60.0:
                for i, old in enumerate(last[-stale:]):
                    n, e = frame.to_local(old.latitude, old.longitude)
                    lat, lon = frame.to_geodetic(n + jitter * (i + 1), e)
                    again = replace(item, t=item.t - 0.08 + 0.01 * i, latitude=lat, longitude=lon)
                    items.append((truth, again))
            last.append(item)
        items.append((truth, item))
    return items


def moved_by(nav: Navigation) -> list[float]:
    """Sigmas of current, speed scale and compass."""
    return [math.sqrt(v) for v in nav.core.filter.covariance.diagonal()[[2, 3, 6, 8]].tolist()]


def test_places_of_before_the_dive_that_are_said_again_after_it_change_nothing(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    clean = feed(Navigation(vehicle, HOME), dive)
    stale = feed(Navigation(vehicle, HOME), with_fixes_of_before(dive, 2, 0.0))
    end = dive[-1][0].t
    assert stale.estimate(end) == clean.estimate(end)


def test_a_gate_that_was_opened_by_wrong_fixes_has_a_way_back(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    """Four places near where it dived agree with each other, and then the true ones come."""
    clean = feed(Navigation(vehicle, HOME), dive)
    misled = feed(Navigation(vehicle, HOME), with_fixes_of_before(dive, 4, 1.0))
    assert error(misled, dive[-1][0]) < 8.0
    for wide, known in zip(moved_by(misled), moved_by(clean), strict=True):
        assert wide < 1.3 * known


def test_the_way_back_leaves_depth_and_bottom_as_they_are(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    """What the filter was before knows nothing of the depths since, and guards go by them."""
    nav = Navigation(vehicle, HOME)
    leaps = []
    for pair in with_fixes_of_before(dive, 4, 1.0):
        before = nav.estimate(pair[1].t)
        feed(nav, [pair])
        after = nav.estimate(pair[1].t)
        if isinstance(pair[1], Fix) and before is not None and after is not None:
            leaps.append((after.depth, after.altitude) != (before.depth, before.altitude))
    assert len(leaps) > 100
    assert not any(leaps)


def test_there_is_no_way_back_behind_a_new_home(vehicle: Vehicle, dive: list[Item]) -> None:
    """The same, and home is set while the wrong places are believed: what is remembered is of
    another frame."""
    nav, home = Navigation(vehicle, HOME), Position(HOME.latitude_deg + 1e-5, HOME.longitude_deg)
    misled = with_fixes_of_before(dive, 4, 1.0)
    at = next(i for i, (t, item) in enumerate(misled) if t.t > 400.0 and isinstance(item, Fix))
    feed(nav, misled[: at + 4])
    nav.set_origin(home, misled[at + 3][1].t)
    nav.assume_current(0.2)
    doubted = moved_by(nav)[0]
    feed(nav, misled[at + 4 : at + 12])
    assert moved_by(nav)[0] > 0.5 * doubted


def test_a_jump_after_a_long_dive_does_not_collapse_the_filter(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    """A current of 1 m/s that set in under water: far beyond what was believed."""
    nav = Navigation(vehicle, HOME)
    frame = LocalFrame(HOME)
    swept: list[Item] = []
    for truth, item in dive:
        away = 1.0 * min(max(truth.t - 200.0, 0.0), 300.0)
        if isinstance(item, Fix):
            n, e = frame.to_local(item.latitude, item.longitude)
            lat, lon = frame.to_geodetic(n + away, e)
            item = replace(item, latitude=lat, longitude=lon)
        swept.append((replace(truth, north=truth.north + away), item))
    feed(nav, swept)
    estimate = nav.estimate(swept[-1][0].t)
    assert estimate is not None
    assert error(nav, swept[-1][0]) < 10.0
    assert estimate.covariance[0] > 0.1  # not certain of itself after a surprise


def test_a_restored_snapshot_goes_on_to_the_last_bit(vehicle: Vehicle, dive: list[Item]) -> None:
    whole = feed(Navigation(vehicle, HOME), dive)
    half = feed(Navigation(vehicle, HOME), dive[:300])
    kept = half.snapshot()
    feed(half, dive[300:350])
    half.restore(kept)
    assert feed(half, dive[300:]).estimate(560.0) == whole.estimate(560.0)
    assert half.health("depth", 560.0) == whole.health("depth", 560.0)


def test_a_restored_snapshot_knows_the_places_that_the_vehicle_had_reckoned(
    vehicle: Vehicle,
) -> None:
    """What it says again to the last bit is none that is new."""
    nav = Navigation(vehicle, HOME)
    for second in range(5):
        nav.telemetry(Telemetry(float(second), depth=3.0 + 0.01 * second, actuators=(0.5,) * 5))
        nav.fix(Fix(second + 0.1, 0.5, 2.0, math.inf))
        kept, nav = nav.snapshot(), Navigation(vehicle, HOME)
        nav.restore(kept)
    assert nav.health("position", 5.0).reason == "frozen"


def reckoned(nav: Navigation, begin: int, end: int, north: float, fixes: bool) -> float:
    """What the vehicle reckons itself, m; beside it a receiver at 0 m; where it is by the end."""
    for second in range(begin, end):
        t, depth = float(second), 0.1 if fixes or begin == 0 else 5.0
        living = 0.01 * (second % 3)
        nav.telemetry(Telemetry(t, depth=depth + living, heading=1.0, actuators=(0.0,) * 5))
        latitude, longitude = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
        nav.fix(Fix(t + 0.1, latitude + (north + living) / EARTH, longitude, math.inf))
        if fixes:
            nav.fix(Fix(t + 0.5, latitude + living / EARTH, longitude, 2.5, hdop=1.0))
    estimate = nav.estimate(float(end))
    assert estimate is not None
    return estimate.north


@pytest.mark.parametrize(("drift", "least", "most"), [(None, 0.5, 5.0), (0.01, 15.0, 30.0)])
def test_a_receiver_is_believed_against_what_the_vehicle_reckons_itself(
    vehicle: Vehicle, drift: float | None, least: float, most: float
) -> None:
    vehicle = replace(vehicle, reckoning=drift)
    nav = Navigation(vehicle, HOME)
    assert reckoned(nav, 0, 20, 100.0, fixes=False) == pytest.approx(100.0, abs=1.0)
    assert reckoned(nav, 20, 30, 100.0, fixes=True) == pytest.approx(0.0, abs=3.0)
    assert reckoned(nav, 30, 60, 100.0, fixes=True) == pytest.approx(0.0, abs=1.0)
    kept, nav = nav.snapshot(), Navigation(vehicle)
    nav.restore(kept)
    # under water it tells how far the vehicle has come, as surely as the vehicle file says
    assert reckoned(nav, 60, 90, 100.0, fixes=False) == pytest.approx(0.0, abs=1.0)
    for metres in range(30):
        reckoned(nav, 90 + metres, 91 + metres, 101.0 + metres, fixes=False)
    assert least < reckoned(nav, 120, 180, 130.0, fixes=False) < most
    # and so it is told to whoever asks for a home
    latitude, longitude = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
    told = nav.less_off(Fix(120.0, latitude + 130.0 / EARTH, longitude, math.inf))
    assert (told.latitude - latitude) * EARTH == pytest.approx(30.0, abs=1.0)
    assert Navigation(vehicle).less_off(told) is told


def test_asking_changes_nothing(vehicle: Vehicle, dive: list[Item]) -> None:
    asked, silent = Navigation(vehicle, HOME), Navigation(vehicle, HOME)
    for item in dive[:150]:
        feed(asked, [item])
        feed(silent, [item])
        asked.estimate(item[0].t + 7.0)
    assert asked.estimate(200.0) == silent.estimate(200.0)


def test_another_home_moves_the_frame_and_not_the_vehicle(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    nav = feed(Navigation(vehicle), dive[:100])
    assert nav.frame is not None
    e = nav.estimate(60.0)
    assert e is not None
    before = nav.frame.to_geodetic(e.north, e.east)
    nav.set_origin(Position(HOME.latitude_deg + 0.005, HOME.longitude_deg), 60.0)
    e = nav.estimate(60.0)
    assert e is not None
    after = nav.frame.to_geodetic(e.north, e.east)
    assert after == pytest.approx(before, abs=1e-12)
    assert e.north < -400.0


@pytest.mark.parametrize("wild", [(0.0, 0.0), (59.0, -10.0), (-30.0, -90.0), (31.0, 121.0)])
def test_a_wild_first_fix_leaves_a_frame_that_can_tell_where_the_vehicle_is(
    vehicle: Vehicle, wild: tuple[float, float]
) -> None:
    nav = Navigation(vehicle)
    nav.telemetry(Telemetry(0.0, depth=0.1, heading=1.0, actuators=(0.0,) * 5))
    nav.fix(Fix(0.5, *map(math.radians, wild), 2.5, hdop=1.0))
    latitude, longitude = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
    for second in range(1, 7):
        nav.fix(Fix(float(second), latitude + 0.1 * second / EARTH, longitude, 2.5, hdop=1.0))
        nav.telemetry(Telemetry(second + 0.5, depth=0.1, heading=1.0, actuators=(0.0,) * 5))
    kept, nav = nav.snapshot(), Navigation(vehicle)
    nav.restore(kept)
    nav.set_origin(HOME, 7.0)
    estimate = nav.estimate(7.0)
    assert estimate is not None
    assert math.hypot(estimate.north, estimate.east) < 2.0


def test_a_frame_that_a_mission_counts_from_stays_wherever_fixes_are(vehicle: Vehicle) -> None:
    for homed in (False, True):
        nav = Navigation(vehicle)
        nav.start_here(0.0)
        nav.telemetry(Telemetry(0.0, depth=0.1, heading=1.0, actuators=(0.0,) * 5))
        if homed:
            nav.set_origin(HOME, 0.0)
        nav.fix(Fix(0.5, 0.1, 0.1, 2.5, hdop=1.0))
        assert nav.frame is not None
        origin = nav.frame.origin
        for second in range(1, 7):
            nav.fix(Fix(float(second), 0.5, 0.5 + 1e-7 * second, 2.5, hdop=1.0))
        assert nav.frame.origin == origin


def test_a_vehicle_held_by_hand_is_not_sure_of_the_current_that_it_dives_into(
    vehicle: Vehicle,
) -> None:
    """Ten minutes of fixes on one spot say that there is no current. From the start on, its 95 %
    radius grows as the current does that the mission assumes."""
    held, dived = Navigation(vehicle, HOME), 300.0
    lat, lon = (math.radians(v) for v in (HOME.latitude_deg, HOME.longitude_deg))
    for t in range(600):
        if t % 2 == 0:
            held.telemetry(Telemetry(float(t), depth=0.2, heading=0.5, actuators=(0.0,) * 5))
        held.fix(Fix(float(t), lat, lon, 2.5, speed=0.0, course=0.0))
    widths = []
    for assumed in (None, 0.2, 0.5):
        nav = Navigation(vehicle, HOME)
        nav.restore(held.snapshot())
        for t in range(600, 600 + int(dived), 2):
            nav.telemetry(Telemetry(float(t), depth=0.2, heading=0.5, actuators=(0.0,) * 5))
            if t == 600 and assumed is not None:
                nav.assume_current(assumed)
        estimate = nav.estimate(600.0 + dived)
        assert estimate is not None
        widths.append(PLANE_95 * principal(estimate.covariance)[1])
    assert widths[0] < 0.2 * dived
    assert 0.2 * dived < widths[1] < 1.4 * 0.2 * dived
    assert 0.5 * dived < widths[2] < 1.2 * 0.5 * dived


def test_a_start_leaves_what_is_less_known_than_it_assumes_as_it_is(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    nav = feed(Navigation(vehicle), dive[:20])
    before = nav.core.filter.covariance
    nav.assume_current(0.0)
    assert (nav.core.filter.covariance == before).all()


@pytest.mark.parametrize("heard", [False, True])
def test_a_start_without_a_fix_counts_from_the_start_and_a_fix_does_not_move_it(
    vehicle: Vehicle, dive: list[Item], heard: bool
) -> None:
    nav = Navigation(vehicle)
    reports = [item for item in dive[:150] if isinstance(item[1], Telemetry)]
    feed(nav, reports[:2])
    if heard:  # some 500 m away, before it was carried to where it starts
        nav.fix(Fix(reports[1][0].t, 0.5 + 500.0 / EARTH, 2.0, 2.5))
    nav.start_here(reports[1][0].t)
    feed(nav, reports[2:])
    before = nav.estimate(80.0)
    assert before is not None
    assert before.mode is NavigationMode.DEAD_RECKONING
    assert math.hypot(before.north, before.east) > 20.0
    nav.fix(Fix(80.0, 0.5, 2.0, 2.5))
    after = nav.estimate(80.0)
    assert after is not None
    assert (after.north, after.east) == pytest.approx((before.north, before.east), abs=0.01)
    assert nav.frame is not None
    assert nav.frame.to_local(0.5, 2.0) == pytest.approx((after.north, after.east), abs=0.01)


@pytest.mark.parametrize("off", [24.0, 60.0, 100.0, 200.0, 600.0])
@pytest.mark.parametrize("how", ["fixes", "places", "a wild fix first", "the first ever is wild"])
def test_where_a_named_home_is_elsewhere_fixes_move_the_vehicle_and_teach_no_current(
    vehicle: Vehicle, dive: list[Item], how: str, off: float
) -> None:
    """A start without a fix within 25 m of home, as the mission assumes; it is further off."""
    nav, alone = Navigation(vehicle), Navigation(vehicle)
    reports = [item for item in dive[:150] if isinstance(item[1], Telemetry)]
    begun, end = reports[1][0].t, reports[-1][0].t
    for each in (nav, alone):
        feed(each, reports[:2])
        if how == "a wild fix first":  # and one of before, behind which it goes back from that
            each.fix(Fix(begun, 0.5, 2.0, 2.5))
        each.start_here(begun, 25.0)
        each.set_origin(HOME, begun)
        each.assume_current(0.3)
    start = nav.estimate(begun)
    assert start is not None
    assert around_95(start.covariance) == pytest.approx(25.0, rel=0.02)
    feed(nav, reports[2:])
    feed(alone, reports[2:])
    assert nav.frame is not None
    for second in range(13):
        for each in (nav, alone):
            each.telemetry(reports[-1][1]._replace(t=end + 1.0 + second))
        x = alone.core.filter.x
        there = x[0] + off, x[1]  # as it reckons, without a current
        wild = (-40.0, 30.0) if "wild" in how and second == 0 else (0.0, 0.0)
        place = nav.frame.to_geodetic(float(there[0] + wild[0]), float(there[1] + wild[1]))
        if how == "places":
            nav.aid(Aid(end + 1.0 + second, PLACE, place))
        else:
            nav.fix(Fix(end + 1.0 + second, *place, 2.5))
    after = nav.estimate(end + 13.0)
    assert after is not None
    assert after.fix_age == (None if how == "places" else 0.0)
    assert math.hypot(after.north - there[0], after.east - there[1]) < 5.0
    assert math.hypot(after.current_north, after.current_east) < 0.12


def test_without_the_compass_the_position_becomes_uncertain_soon(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    sound = feed(Navigation(vehicle, HOME), dive[:400]).estimate(280.0)
    blind = [
        (
            truth,
            item._replace(heading=None) if isinstance(item, Telemetry) and truth.t > 210 else item,
        )
        for truth, item in dive[:400]
    ]
    lost = feed(Navigation(vehicle, HOME), blind).estimate(280.0)
    assert sound is not None
    assert lost is not None
    assert lost.covariance[0] > 4.0 * sound.covariance[0]
    assert lost.sigmas["heading"] > 0.5


def test_a_lost_depth_grows_uncertain_and_does_not_run_away(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    nav = feed(Navigation(vehicle, HOME), dive[:350])
    estimate = nav.estimate(dive[349][0].t + 300.0)
    assert estimate is not None
    assert estimate.depth is not None
    assert abs(estimate.depth - 10.0) < 20.0
    assert estimate.sigmas["depth"] > 2.0


def test_a_second_sentence_of_the_same_second_counts_once(
    vehicle: Vehicle, dive: list[Item]
) -> None:
    doubled: list[Item] = []
    for truth, item in dive[:120]:
        doubled.append((truth, item))
        if isinstance(item, Fix):
            doubled.append((truth, replace(item, t=item.t + 0.2)))
    once = feed(Navigation(vehicle, HOME), dive[:120]).estimate(90.0)
    twice = feed(Navigation(vehicle, HOME), doubled).estimate(90.0)
    assert once is not None
    assert twice is not None
    assert twice.covariance[0] == pytest.approx(once.covariance[0], rel=0.02)


def test_a_receiver_that_contradicts_itself_leaves_a_filter_that_can_be_computed_with(
    vehicle: Vehicle,
) -> None:
    """Its place stands still and its speed does not: the gate is opened again and again."""
    import numpy as np

    nav = Navigation(vehicle, HOME)
    latitude, longitude = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
    before = nav.core.filter.covariance.diagonal()[2:12].copy()
    for second in range(900):
        t = float(second)
        if second % 2 == 0:
            nav.telemetry(Telemetry(t, depth=0.1, heading=1.0, pitch=0.0, actuators=(0.0,) * 5))
        nav.fix(Fix(t + 0.3, latitude, longitude, 2.5, hdop=1.0, speed=0.7, course=0.67))
    covariance = nav.core.filter.covariance
    assert np.linalg.eigvalsh(covariance).min() > 0.0
    assert (covariance.diagonal()[2:12] <= 26.0 * before).all()


@pytest.mark.parametrize("sure", ["surface_drift", "speed_noise", "deviation_sigma"])
def test_a_gate_that_opens_finds_the_vehicle_though_its_file_says_a_sigma_of_0(
    vehicle: Vehicle, sure: str
) -> None:
    calibration = replace(vehicle.calibration, **{sure: 0.0})
    nav = Navigation(replace(vehicle, calibration=calibration), HOME)
    latitude, longitude = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
    for second in range(120):
        t, north = float(second), 500.0 if second >= 60 else 0.0
        if second % 2 == 0:
            nav.telemetry(Telemetry(t, depth=0.1, heading=1.0, pitch=0.0, actuators=(0.0,) * 5))
        there = latitude + (north + 0.01 * (second % 7)) / EARTH
        nav.fix(Fix(t + 0.3, there, longitude, 2.5, hdop=1.0))
    estimate = nav.estimate(120.0)
    assert estimate is not None
    assert estimate.located
    assert estimate.north == pytest.approx(500.0, rel=0.02)


def test_the_declination_that_the_first_fix_brings_is_no_turn() -> None:
    """At rest in a current: what receivers say of it is taken in as if there were none."""
    east, learned = 0.3, []
    for declination in (0.0, None):
        nav = Navigation(replace(load_vehicle("auv"), declination=declination))
        frame = LocalFrame(HOME)
        for t in (0.0, 2.0, 4.0):
            place = frame.to_geodetic(0.0, east * (t + 1.0))
            nav.telemetry(Telemetry(t, 0.2, None, 1.0, 0.0, 0.0, actuators=(0.0,) * 5))
            if t < 4.0:
                nav.fix(Fix(t + 1.0, *place, 2.5, speed=east, course=math.pi / 2.0))
        estimate = nav.estimate(4.0)
        assert estimate is not None
        learned.append(estimate.current_east)
    assert learned[1] == pytest.approx(learned[0], rel=1e-3)
    assert learned[1] > 0.2


@pytest.mark.parametrize("gear", [0.0, 8.0])
def test_a_pitched_hull_goes_where_its_depth_rate_says(vehicle: Vehicle, gear: float) -> None:
    """Sinking upright it drifts ahead; sinking along its bow it makes the cosine of its speed."""
    speed = vehicle.speed_by_gear.at(gear)
    pitch = -0.3 if gear else 0.2
    sinking = speed * math.sin(-pitch) if gear else 0.3
    nav = Navigation(vehicle, HOME)
    for second in range(0, 62, 2):
        report = Telemetry(
            float(second),
            depth=2.0 + sinking * second,
            heading=0.001 * second,
            pitch=pitch + 1e-4 * (second % 4),
            actuators=(gear / 12.0,) * 2 + (0.0,) * 3,
        )
        nav.telemetry(report)
        if second == 0:
            nav.start_here(0.0)
    estimate = nav.estimate(60.0)
    assert estimate is not None
    ahead = speed * math.cos(pitch) if gear else sinking * math.tan(pitch)
    assert estimate.north == pytest.approx(60.0 * ahead, rel=0.08)  # the depth rate is found first


def test_a_silence_of_the_vehicle_is_not_taken_for_a_straight_course(vehicle: Vehicle) -> None:
    """It turns while nothing is heard of it: the ellipse holds it when it is heard again."""
    for silence in (20.0, 60.0, 100.0):
        nav = Navigation(vehicle, HOME)
        track = list(sail(replace(Sea(), heading_noise=0.0), 60.0, 300.0, 2))
        heard = [i for i in track if not 80.0 < i[0].t <= 80.0 + silence]
        upto = next(k for k, i in enumerate(heard) if i[0].t > 80.0 + silence) + 1
        before = feed(Navigation(vehicle, HOME), [i for i in heard if i[0].t <= 80.0])
        feed(nav, heard[:upto])
        truth, estimate = heard[upto - 1][0], nav.estimate(heard[upto - 1][0].t)
        asked = before.estimate(truth.t)
        assert estimate is not None
        assert asked is not None
        a, b, d = estimate.covariance
        n, e = truth.north - estimate.north, truth.east - estimate.east
        assert (d * n * n - 2.0 * b * n * e + a * e * e) / (a * d - b * b) < 5.991
        assert a + d > 0.2 * (asked.covariance[0] + asked.covariance[2])


def test_a_silence_of_days_is_predicted_in_as_many_pieces_as_one_of_an_hour(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A vehicle that waits on deck with its board off: a step of the engine cost half a minute."""
    pieces: list[object] = []
    predict = KalmanFilter.predict
    monkeypatch.setattr(KalmanFilter, "predict", lambda it: (pieces.append(it), predict(it)))
    counts, radii = [], []
    heard = list(sail(Sea(), 60.0, 60.0, 2))
    for silence in (1800.0, 3600.0, 86400.0, 7 * 86400.0):
        nav = feed(Navigation(vehicle, HOME), heard)
        pieces.clear()
        estimate = nav.estimate(heard[-1][0].t + silence)
        assert estimate is not None
        counts.append(len(pieces))
        radii.append(estimate.covariance[0])
    assert counts[0] == pytest.approx(360, abs=5)
    assert counts[1] == counts[2] == counts[3]
    assert radii == sorted(radii)
    assert all(math.isfinite(radius) for radius in radii)


def test_a_vehicle_without_any_compass_may_be_on_any_side(vehicle: Vehicle) -> None:
    nav = Navigation(vehicle, HOME)
    track = sail(Sea(current=(0.0, 0.0), bias=0.0), 10.0, 80.0, 3)
    dumb = [
        (t, i._replace(heading=None) if isinstance(i, Telemetry) else i)
        for t, i in track
        if t.t < 80.0
    ]
    feed(nav, dumb)
    truth, estimate = dumb[-1][0], nav.estimate(dumb[-1][0].t)
    assert estimate is not None
    assert math.sqrt(min(estimate.covariance[0], estimate.covariance[2])) > 40.0
    assert math.hypot(estimate.north, estimate.east) < 30.0
    assert error(nav, truth) < 2.5 * math.sqrt(estimate.covariance[0])


def test_a_receiver_that_got_stuck_teaches_the_thrusters_nothing(vehicle: Vehicle) -> None:
    """Nor the current: two minutes at 0.7 m/s, and it says where it was at first."""
    nav, gear = Navigation(vehicle, HOME), 8.0
    speed = vehicle.speed_by_gear.at(gear)
    lat, lon = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
    for second in range(122):
        if second % 2 == 0:
            nav.telemetry(
                Telemetry(
                    float(second),
                    depth=0.2 + 0.001 * (second % 7),
                    heading=0.001 * second,
                    pitch=1e-4 * second,
                    actuators=(gear / 12.0,) * 2 + (0.0,) * 3,
                )
            )
        nav.fix(Fix(second + 0.1, lat, lon, 2.5))
        if second == 60:
            nav.restore(nav.snapshot())
    estimate = nav.estimate(121.0)
    assert estimate is not None
    assert nav.health("position", 121.0).reason == "frozen"
    off = abs(estimate.north - 121.0 * speed)
    assert off < 2.0 * math.sqrt(estimate.covariance[0])  # it knows what it does not know
    assert off < 0.3 * 121.0 * speed


def test_two_reports_of_a_turn_that_come_together_leave_the_estimate_as_good(
    vehicle: Vehicle,
) -> None:
    """The first was read 2 s late: no hull turns by 40 degrees in 5 ms."""

    def turning(late: float) -> list[Estimate]:
        nav = Navigation(vehicle, HOME)
        nav.start_here(0.0)
        for i in range(16):
            t = 2.0 * i + (late if i == 14 else 0.0)
            heading = math.radians(20.0) * 2.0 * i % (2.0 * math.pi)
            moves = {"depth": 3.0 + 0.01 * i, "pitch": 0.001 * i, "roll": 0.001 * i}
            nav.telemetry(Telemetry(t, heading=heading, actuators=(0.6, 0.6, 0.1), **moves))
        told = [nav.estimate(30.0), nav.estimate(33.0)]
        return [one for one in told if one is not None]

    (then, later), (then_late, later_late) = turning(0.0), turning(1.995)
    way = later.north - then.north, later.east - then.east
    assert later_late.north - then_late.north == pytest.approx(way[0], abs=0.2)
    assert later_late.east - then_late.east == pytest.approx(way[1], abs=0.2)
    widths = [principal(one.covariance)[0] for one in (later, later_late)]
    assert widths[1] == pytest.approx(widths[0], rel=0.05)


@pytest.mark.parametrize("hertz", [10.0, 50.0])
def test_a_speed_over_ground_counts_however_often_a_noisy_compass_reports(hertz: float) -> None:
    """1 degree of noise between two reports of a fast board is no turn."""
    nav, rng = Navigation(load_vehicle("coreboard"), HOME), random.Random(1)
    nav.start_here(0.0)
    for i in range(int(120.0 * hertz)):
        t = (i + rng.uniform(-0.15, 0.15)) / hertz
        heading = 1.0 + math.radians(1.0) * rng.gauss(0.0, 1.0)
        lives = 0.001 * math.sin(i)
        moves = {"depth": 3.0 + lives, "pitch": lives, "roll": lives}
        nav.telemetry(Telemetry(t, heading=heading, actuators=(0.6, 0.6, 0.1), **moves))
        if i % int(hertz) == 0:
            nav.aid(Aid(t + 0.001, GROUND, (0.3 + rng.gauss(0.0, 0.01), rng.gauss(0.0, 0.01))))
    estimate = nav.estimate(120.0)
    assert estimate is not None
    assert estimate.sigmas["current"] < 0.062


# --- before a start ------------------------------------------------------------------------------


def afloat(
    vehicle: Vehicle, seconds: int, way: Callable[[int], float], *, told: bool = True
) -> Navigation:
    """``way``: m/s to the north, by nothing that the reports tell; ``told``: they go on."""
    rng, frame, nav, north = random.Random(1), LocalFrame(HOME), Navigation(vehicle, HOME), 0.0
    for second in range(seconds):
        t, north = float(second), north + way(second)
        if second % 2 == 0 and (told or not way(second)):
            compass = rng.gauss(1.0, 0.03)
            nav.telemetry(Telemetry(t, depth=0.2, heading=compass, actuators=(0.0,) * 5))
        place = frame.to_geodetic(north + rng.gauss(0.0, 1.0), rng.gauss(0.0, 1.0))
        nav.fix(Fix(t + 0.1, *place, 2.5, speed=way(second), course=0.0))
    return nav


def test_the_way_that_a_stick_drove_is_no_current(vehicle: Vehicle) -> None:
    """As built it reports nothing meanwhile, and its thrusters seem to be off."""
    nav = afloat(vehicle, 160, lambda t: 1.2 if 60 <= t < 150 else 0.0, told=False)
    assert nav.core.filter.current_found < 0.3
    assert PLANE_95 * principal(nav.estimate(160.0).covariance)[1] < 25.0


def test_who_was_carried_is_no_surer_of_the_current_than_by_what_was_found_of_it(
    vehicle: Vehicle,
) -> None:
    nav = afloat(vehicle, 120, lambda t: 1.0 if t > 60 else 0.0)
    found = nav.core.filter.current_found
    assert found > 0.7
    nav.assume_current(0.2)
    sigma = math.sqrt(nav.core.filter.covariance[CN, CN])
    assert sigma == pytest.approx(found / PLANE_95)


@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_who_is_carried_learns_nothing_of_compass_and_thrusters(
    vehicle: Vehicle, speed: float
) -> None:
    """Nothing drove: the gate opens again and again, and widens the place and the current alone."""
    nav, still = (afloat(vehicle, 400, way) for way in (lambda t: speed * (t < 300), lambda t: 0.0))
    for state in (COMPASS, SCALE, DEVIATION):
        carried, rested = (n.core.filter.covariance[state, state] for n in (nav, still))
        assert carried <= 1.01 * rested
