"""Laws of what the engine believes at an instant: depth, surface, home, compass, position."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from engine_world import HOME, NEUTRAL, Frame, Navigation

from mission.engine.vehicle_state import SURFACE_DEPTH, VehicleState
from mission.model import Health, Local, NavigationMode, Position, Vertical
from mission.navigation.fixes import FIX_DEPTH, metres
from protocol.messages import Fix, Order, Setpoint, Telemetry

LAT, LON = math.radians(HOME.latitude_deg), math.radians(HOME.longitude_deg)
_METRE = 1.0 / 6371008.8


def report(t: float, **values: object) -> Telemetry:
    """At the surface, unless told otherwise: a depth that lives, 0.2 m at 10 s."""
    depth = 0.2 + 0.001 * ((t - 10.0) % 4.0)
    base = Telemetry(t=t, depth=depth, altitude=9.0, heading=1.0, actuators=NEUTRAL)
    return base._replace(**values)


def fix(t: float, north: float = 0.0, **values: object) -> Fix:
    return replace(Fix(t, LAT + north * _METRE, LON, accuracy=2.5, hdop=1.0), **values)


class Counting(Navigation):
    """How often it was told or asked for something."""

    def __init__(self) -> None:
        super().__init__()
        self.fixes: list[Fix] = []
        self.asked = 0

    def fix(self, f: Fix) -> None:
        super().fix(f)
        self.fixes.append(f)

    def estimate(self, now: float):
        self.asked += 1
        return super().estimate(now)


def told(vehicle_state: VehicleState, t: float, **values: object) -> VehicleState:
    vehicle_state.at(t)
    vehicle_state.take_telemetry(report(t, **values))
    return vehicle_state


def test_a_shallow_depth_behind_a_silence_is_no_proof_of_the_surface_yet():
    """Where it was meanwhile nobody knows: the six seconds begin anew."""
    vehicle_state = VehicleState()
    for t in (1.0, 3.0, 5.0, 7.0):
        told(vehicle_state, t)
    assert vehicle_state.surfaced(0.0)
    told(vehicle_state, 12.9)
    assert vehicle_state.surfaced(0.0)
    told(vehicle_state, 19.0)
    assert not vehicle_state.surfaced(0.0)
    told(vehicle_state, 25.0)
    assert vehicle_state.surfaced(0.0)


def test_one_report_of_a_shallow_depth_proves_no_surface_however_old_it_is():
    vehicle_state = told(VehicleState(), 3.0)
    vehicle_state.at(9.0)
    assert vehicle_state.depth is not None
    assert not vehicle_state.surfaced(0.0)
    told(vehicle_state, 9.0)
    assert vehicle_state.surfaced(0.0)


def test_a_depth_whose_zero_is_contradicted_still_tells_whether_it_moves():
    """What is clogged does not."""

    class Doubting(Navigation):
        moves = False

        def health(self, sensor: str, now: float) -> Health:
            return Health(False, "contradicted: it leapt by 4.0 m", 0.0, self.moves)

    navigation = Doubting()
    vehicle_state = told(VehicleState(navigation), 1.0, depth=7.0)
    assert (vehicle_state.depth, vehicle_state.moving_depth) == (None, None)
    navigation.moves = True
    told(vehicle_state, 3.0, depth=7.5)
    assert (vehicle_state.depth, vehicle_state.moving_depth) == (None, 7.5)
    assert not vehicle_state.surfaced(0.0)


@pytest.mark.parametrize(
    ("rolls", "counts"),
    [
        ((0.0, 0.0, 0.0), True),
        ((50.0, 51.0, 52.0), True),
        ((70.0, 71.0), True),
        ((70.0, 71.0, 72.0), False),
        ((100.0, 101.0, 102.0), False),
        ((170.0, 171.0, 172.0), False),
        ((100.0, 100.0, 100.0), True),  # it repeats itself
        ((100.0, 101.0, 102.0, 3.0), True),
    ],
)
def test_a_push_of_verticals_that_lie_sideways_is_held_against_no_depth(
    rolls: tuple[float, ...], counts: bool
):
    """As flight 8508 of seed 11833: on its side at the surface, and a board that dives."""

    class Pushed(Navigation):
        push: Vertical | None = None

        def telemetry(self, report: Telemetry, push: Vertical) -> None:
            super().telemetry(report, push)
            self.push = push

    navigation, down = Pushed(), (0.0, 0.0, -1.0, -1.0, -1.0)
    vehicle_state = VehicleState(navigation)
    for i, roll in enumerate(rolls):
        told(vehicle_state, 1.0 + 2.0 * i, roll=math.radians(roll), pitch=0.01, actuators=down)
    assert navigation.push == (Vertical(1.0, None) if counts else Vertical(None, None))


# --- before navigation is there ----------------------------------------------------------------


def test_a_vehicle_that_fell_silent_upside_down_may_lie_either_way():
    """As flight 1427 of seed 1616: righted meanwhile, and heavy, it was let go for ever."""
    vehicle_state = VehicleState()
    for i in range(3):
        told(vehicle_state, 1.0 + 2.0 * i, roll=3.0 + 0.01 * i, pitch=0.0)
    for now, over, doubtful in ((11.0, True, False), (11.1, False, True)):
        vehicle_state.at(now)
        assert vehicle_state.seen_rising[2:] == (over, doubtful)
    told(vehicle_state, 12.0, roll=0.1, pitch=0.0)
    assert vehicle_state.seen_rising[2:] == (False, False)


@pytest.mark.parametrize("thrust", [0.0, 0.1])
@pytest.mark.parametrize("angle", ["roll", "pitch"])
@pytest.mark.parametrize(
    ("degrees", "over"), [(0.0, False), (100.0, False), (170.0, True)], ids=["up", "side", "down"]
)
def test_an_attitude_that_repeats_itself_tells_no_more_which_way_up_it_lies(
    degrees: float, over: bool, angle: str, thrust: float
):
    """As flight 422 of seed 1919: it froze upright, then the vehicle turned over. At rest it may
    well repeat itself; and where a depth is known that tells whether a push down lifts."""
    vehicle_state, frozen = VehicleState(), thrust > 0.0
    for i in range(7):
        turned = {"roll": 0.01 * i, "pitch": 0.01 * i, angle: math.radians(degrees + min(i, 2))}
        told(vehicle_state, float(i), depth=None, actuators=(0.0, thrust), **turned)
        repeats = frozen and i >= 6
        assert vehicle_state.seen_rising[2:] == (
            over and i >= 2 and not repeats,
            repeats or (i < 2 and over),
        )
    told(vehicle_state, 7.0, depth=20.0, actuators=(0.0, thrust), **turned)
    assert vehicle_state.seen_rising[1:] == (20.0, over, frozen)


def test_an_attitude_that_is_slower_than_its_reports_does_not_repeat_itself() -> None:
    """New twice a second, in ten reports."""
    vehicle_state = VehicleState()
    for i in range(100):
        new = 0.001 * (i // 5)
        told(vehicle_state, 0.1 * i, depth=None, actuators=(0.0, 0.5), roll=new, pitch=new)
        assert not vehicle_state.attitude.frozen


@pytest.mark.parametrize("period", [0.02, 0.1, 0.9, 1.8, 2.2])
@pytest.mark.parametrize("angle", ["roll", "pitch"])
def test_an_axis_that_froze_is_noticed_though_the_other_changes_with_every_report(
    angle: str, period: float
) -> None:
    """However often a board reports."""
    vehicle_state = VehicleState()
    for i in range(int(12.0 / period)):
        turned = {"roll": 0.001 * i, "pitch": 0.001 * i, angle: 0.1}
        told(vehicle_state, period * i, depth=None, actuators=(0.0, 0.5), **turned)
        assert vehicle_state.attitude.frozen <= (period * i >= 4.0)
    assert vehicle_state.attitude.frozen


def test_without_navigation_a_finite_depth_is_believed_for_six_seconds():
    vehicle_state = VehicleState()
    assert (vehicle_state.depth, vehicle_state.health("depth").reason) == (None, "missing")
    assert vehicle_state.health("depth").age == math.inf
    told(vehicle_state, 10.0)
    vehicle_state.at(16.0)
    assert vehicle_state.depth == 0.2
    assert vehicle_state.health("depth").valid
    assert (vehicle_state.health("depth").reason, vehicle_state.health("depth").age) == ("", 6.0)
    vehicle_state.at(16.001)
    assert vehicle_state.depth is None
    assert vehicle_state.health("depth").reason == "stale"
    assert vehicle_state.health("depth").age == pytest.approx(6.001)


@pytest.mark.parametrize(("depth", "why"), [(math.nan, "absurd"), (None, "missing")])
def test_without_navigation_what_is_no_number_is_not_believed(depth: float | None, why: str):
    vehicle_state = told(VehicleState(), 10.0, depth=depth)
    assert vehicle_state.depth is None
    assert not vehicle_state.health("depth").valid
    assert vehicle_state.health("depth").reason == why


def test_without_navigation_there_is_no_position_and_no_place():
    vehicle_state = told(VehicleState(), 10.0)
    vehicle_state.take_fix(fix(10.0))
    assert vehicle_state.estimate is None
    assert not vehicle_state.believable("position")
    assert vehicle_state.believable("depth")
    assert vehicle_state.place(HOME) is None
    assert vehicle_state.compass(1.0) is None
    assert vehicle_state.fix == fix(10.0)


# --- depth and surface --------------------------------------------------------------------------


def test_a_vehicle_on_the_ground_is_at_depth_0_and_up_six_seconds_after_it_asks():
    vehicle_state = VehicleState(Navigation(), grounded=True)
    vehicle_state.at(20.0)
    assert vehicle_state.depth == 0.0
    assert vehicle_state.surface_due(14.0) == 20.0
    assert vehicle_state.surfaced(14.0)
    assert not vehicle_state.surfaced(14.001)


def test_half_a_metre_is_no_surface_and_a_hair_less_is():
    for depth, shallow in ((SURFACE_DEPTH, False), (math.nextafter(SURFACE_DEPTH, 0.0), True)):
        vehicle_state = told(VehicleState(Navigation()), 10.0, depth=depth)
        assert vehicle_state.surface_due(0.0) == (16.0 if shallow else None)
        assert vehicle_state.submerged is not shallow
    assert SURFACE_DEPTH == 0.5


def test_the_surface_is_proved_by_six_seconds_of_shallow_reports_after_it_was_asked_for():
    vehicle_state = told(VehicleState(Navigation()), 10.0)
    told(vehicle_state, 12.0)
    assert vehicle_state.surface_due(3.0) == 16.0
    assert vehicle_state.surface_due(11.0) == 17.0
    told(vehicle_state, 15.999)
    assert not vehicle_state.surfaced(3.0)
    vehicle_state.at(16.0)
    assert vehicle_state.surfaced(3.0)
    told(vehicle_state, 17.0, depth=2.0)
    assert not vehicle_state.surfaced(3.0)
    assert vehicle_state.surface_due(3.0) is None


@pytest.mark.parametrize("every", [0.2, 2.0])
@pytest.mark.parametrize("rate", [0.05, 0.1, 0.25])
def test_a_depth_that_still_rises_proves_no_surface(every: float, rate: float):
    """Its zero is off by a metre and a half, or drifts: up is what rises no more."""
    vehicle_state = VehicleState(Navigation())
    steps = int(1.35 / rate / every)  # from 0.6 m to what no depth at the surface is
    for i in range(steps):
        told(vehicle_state, i * every, depth=0.6 - rate * i * every)
        assert not vehicle_state.surfaced(0.0)
    end = steps * every
    while vehicle_state.now < end + 6.0 + every:
        told(vehicle_state, vehicle_state.now + every, depth=0.1 + 0.01 * (vehicle_state.now % 3.0))
    assert vehicle_state.surfaced(end)


@pytest.mark.parametrize(
    ("vertical", "up"), [(-1.0, False), (-0.5, False), (-0.4, True), (1.0, True)]
)
def test_a_shallow_depth_proves_no_surface_while_the_verticals_push_down(vertical: float, up: bool):
    """As of a board that dives by itself: what were at the surface would go under."""
    vehicle_state = VehicleState(Navigation())
    for t in range(0, 20, 2):
        told(vehicle_state, float(t), actuators=(0.0, 0.0, *[vertical] * 3, 0.0, 0.0))
    assert vehicle_state.surfaced(0.0) is up


def test_a_depth_that_is_not_to_be_believed_proves_no_surface_and_begins_anew():
    navigation = Navigation()
    vehicle_state = told(VehicleState(navigation), 10.0)
    navigation.doubt["depth"] = "frozen"
    vehicle_state.at(17.0)
    assert not vehicle_state.surfaced(3.0)
    told(vehicle_state, 18.0)
    assert vehicle_state.surface_due(3.0) is None


def test_only_a_fix_after_it_was_asked_for_proves_the_surface():
    vehicle_state = told(VehicleState(Navigation()), 10.0, depth=0.7)
    vehicle_state.take_fix(fix(12.0))
    assert not vehicle_state.fixed(12.0)
    assert vehicle_state.fixed(11.999)
    assert vehicle_state.surfaced(11.999)
    assert not vehicle_state.surfaced(12.0)


@pytest.mark.parametrize(("depth", "proves"), [(FIX_DEPTH - 1e-9, True), (FIX_DEPTH, False)])
def test_a_fix_proves_nothing_against_a_believed_depth_under_water(depth: float, proves: bool):
    vehicle_state = told(VehicleState(Navigation()), 10.0, depth=depth)
    for second in range(60):
        vehicle_state.take_fix(fix(10.0 + second, north=float(second)))
        told(vehicle_state, 10.0 + second, depth=depth)
    assert vehicle_state.fixed(10.0) is proves
    assert (vehicle_state.fix is not None) is proves


def rising_behind_a_leap(*, moves: bool = True) -> VehicleState:
    """In an ascent, by a depth of which the zero is wrong; ``moves`` as the vehicle does."""
    navigation = Navigation()
    vehicle_state = told(VehicleState(navigation), 0.0, depth=5.0)
    navigation.doubt["depth"] = "contradicted: it leapt by 10.0 m"
    navigation.moves = moves
    vehicle_state.rising_since = 0.0
    return vehicle_state


@pytest.mark.parametrize(
    ("rate", "moves", "proves"), [(-0.3, True, False), (-0.05, True, True), (-0.3, False, True)]
)
def test_no_fix_proves_the_surface_while_a_depth_of_which_the_zero_is_wrong_goes_by_metres(
    rate: float, moves: bool, proves: bool
):
    vehicle_state = rising_behind_a_leap(moves=moves)
    for second in range(1, 60):
        told(vehicle_state, float(second), depth=25.0 + rate * second)
        vehicle_state.take_fix(fix(second + 0.5, north=float(second)))
    assert vehicle_state.fixed(40.0) is proves
    for second in range(60, 95):  # it stands
        told(vehicle_state, float(second), depth=25.0 + rate * 60)
        vehicle_state.take_fix(fix(second + 0.5, north=float(second)))
    assert vehicle_state.fixed(60.0)


@pytest.mark.parametrize("every", [1.0, 2.0])
@pytest.mark.parametrize("turn", [10.0, 15.0, 20.0])
def test_no_fix_proves_the_surface_while_a_depth_of_which_the_zero_is_wrong_goes_down_and_up_again(
    turn: float, every: float
):
    """As flight 840 of seed 777002: let go 12 m deep, since the means of two times 15 s were alike."""
    vehicle_state = rising_behind_a_leap()
    for report in range(1, round(200.0 / every)):
        t = every * report
        told(vehicle_state, t, depth=12.0 + 0.3 * abs(t % (2.0 * turn) - turn))
        vehicle_state.take_fix(fix(t + 0.1, north=t))
        assert t < 30.0 or not vehicle_state.fixed(30.0)


@pytest.mark.parametrize("every", [0.2, 2.0, 2.6])
@pytest.mark.parametrize("period", [5.0, 10.2, 12.0])
@pytest.mark.parametrize(("rate", "proves"), [(0.13, False), (0.02, True)])
def test_waves_hide_no_slow_way_up_by_a_depth_of_which_the_zero_is_wrong(
    rate: float, proves: bool, period: float, every: float
):
    """A vehicle that full thrust just lifts, and a receiver that makes fixes up: it was let go 6 m deep."""
    vehicle_state = rising_behind_a_leap()
    for report in range(1, round(150.0 / every)):
        t = every * report
        told(vehicle_state, t, depth=25.0 - rate * t + 0.55 * math.sin(math.tau * t / period))
        if report % max(round(1.0 / every), 1) == 0:
            vehicle_state.take_fix(fix(t + 0.1, north=t))
    assert vehicle_state.fixed(35.0) is proves


def test_a_depth_of_which_the_zero_is_wrong_says_nothing_of_the_surface_once_reports_have_ended():
    vehicle_state = rising_behind_a_leap()
    for second in range(1, 60):
        told(vehicle_state, float(second), depth=25.0 - 0.3 * second)
    for second in range(60, 90):
        vehicle_state.take_fix(fix(second + 0.5, north=float(second)))
    assert vehicle_state.fixed(60.0)


def test_submerged_is_what_was_last_believed_and_no_fix_since_that_proves_the_surface():
    navigation = Navigation()
    vehicle_state = VehicleState(navigation)
    assert not vehicle_state.submerged
    told(vehicle_state, 10.0, depth=5.0)
    assert vehicle_state.submerged
    vehicle_state.take_fix(fix(10.0))
    assert vehicle_state.submerged
    navigation.doubt["depth"] = "stale"
    told(vehicle_state, 12.0, depth=0.1)
    assert vehicle_state.submerged
    assert vehicle_state.believed_depth == 5.0
    for second in range(60):  # what it said before the dive
        vehicle_state.take_fix(fix(12.5 + second))
    assert vehicle_state.submerged
    for second in range(7):
        vehicle_state.take_fix(fix(73.0 + second, north=second + 1.0))
    assert vehicle_state.submerged  # nothing has told it to come up
    vehicle_state.rising_since = 79.5
    vehicle_state.take_fix(fix(80.0, north=8.0))
    assert not vehicle_state.submerged
    navigation.doubt.clear()
    told(vehicle_state, 82.0, depth=5.1)
    assert not vehicle_state.submerged  # behind the silence it may have frozen elsewhere
    told(vehicle_state, 84.0, depth=5.2)
    assert vehicle_state.submerged


def test_a_depth_that_froze_in_a_silence_proves_no_surface_though_it_is_another():
    """As flight 17387 of seed 5010: 10 m deep, and said 0.2 m."""
    vehicle_state = VehicleState(Navigation())
    told(vehicle_state, 10.0, depth=0.19)
    vehicle_state.rising_since = 20.0
    for second in range(40, 60, 2):
        told(vehicle_state, float(second), depth=0.21)
    assert not vehicle_state.surfaced(20.0)
    for second in range(60, 70, 2):
        told(vehicle_state, float(second), depth=0.21 + 0.001 * second)
    assert vehicle_state.surfaced(20.0)


@pytest.mark.parametrize(
    ("said", "up"),
    [
        ([0.30], False),
        ([0.35], False),
        ([1.1], False),
        ([0.35, 0.32], False),
        ([0.35, 0.32, 0.31], True),
    ],
)
@pytest.mark.parametrize("lived", [False, True])
def test_a_depth_that_froze_proves_no_surface_by_one_other_value(lived: bool, said, up: bool):
    """Which it says among the same: by three that differ it lives again, and by a fourth that it
    did not end with the third."""
    navigation = Navigation()
    vehicle_state = VehicleState(navigation)
    vehicle_state.rising_since = 1.0
    told(vehicle_state, 2.0, depth=0.30 + 0.01 * lived)
    told(vehicle_state, 4.0, depth=0.30)
    navigation.doubt["depth"] = "frozen"
    told(vehicle_state, 6.0, depth=0.30)
    navigation.doubt.clear()
    for i, depth in enumerate([*said, *[0.30] * 4]):
        told(vehicle_state, 8.0 + 2.0 * i, depth=depth)
    assert vehicle_state.surfaced(6.0) is up


def test_the_report_with_which_an_ascent_begins_is_no_change_since():
    """A leak that acts may end the depth sensor in the same moment."""
    vehicle_state = VehicleState()
    for t, depth in ((1.0, 0.2), (3.0, 0.3), (5.0, 0.4)):
        told(vehicle_state, t, depth=depth)
    vehicle_state.rising_since = vehicle_state.now
    for t in (7.0, 9.0, 11.0, 13.0):
        told(vehicle_state, t, depth=0.4)
    assert not vehicle_state.surfaced(5.0)
    for t in (15.0, 17.0, 19.0, 21.0):
        told(vehicle_state, t, depth=0.41)
    assert not vehicle_state.surfaced(5.0)  # nor one that may have ended with that change
    for t in (23.0, 25.0, 27.0, 29.0):
        told(vehicle_state, t, depth=0.41 + 0.001 * (t - 21.0))
    assert vehicle_state.surfaced(5.0)


def test_a_depth_that_dies_at_zero_within_reach_of_the_surface_proves_none():
    """A board that begins anew, or a cable that is torn: 0.0 from then on, which is a change."""
    vehicle_state = VehicleState(Navigation())
    for t, depth in ((10.0, 5.0), (12.0, 4.3)):
        told(vehicle_state, t, depth=depth)
    vehicle_state.rising_since = 12.0
    told(vehicle_state, 14.0, depth=3.6)
    for t in range(16, 116, 2):
        told(vehicle_state, float(t), depth=0.0)
        assert not vehicle_state.surfaced(12.0)
    told(vehicle_state, 116.0, depth=0.1)
    assert vehicle_state.surface_due(12.0) == 120.0  # six seconds from the last that was the same
    told(vehicle_state, 118.0, depth=0.1)
    vehicle_state.at(119.999)
    assert not vehicle_state.surfaced(12.0)
    vehicle_state.at(120.0)
    assert vehicle_state.surfaced(12.0)


def test_where_the_depth_has_died_at_zero_a_fix_still_proves_the_surface():
    vehicle_state = VehicleState(Navigation())
    vehicle_state.rising_since = 9.0
    for t, depth in ((10.0, 1.9), (12.0, 1.2), (14.0, 0.0), (16.0, 0.0), (18.0, 0.0)):
        told(vehicle_state, t, depth=depth)
    vehicle_state.take_fix(fix(18.5))
    assert vehicle_state.surfaced(9.0)


def test_a_depth_repeats_itself_when_it_is_the_same_for_longer_than_eight_seconds():
    vehicle_state = VehicleState(Navigation())
    for t in (10.0, 12.0, 14.0, 16.0, 18.0):
        told(vehicle_state, t, depth=0.3)
        assert not vehicle_state.repeats
    vehicle_state.at(18.001)
    assert vehicle_state.repeats
    told(vehicle_state, 20.0, depth=math.nextafter(0.3, 1.0))
    assert not vehicle_state.repeats
    grounded = VehicleState(Navigation(), grounded=True)
    for t in (10.0, 20.0, 30.0):
        assert not told(grounded, t, depth=0.0).repeats


def test_a_depth_that_stood_for_long_and_went_on_says_nothing_by_standing_again():
    """It is coarse, or 0 in the air."""
    vehicle_state = VehicleState(Navigation())
    for t in range(10, 30, 2):
        told(vehicle_state, float(t), depth=0.0)
    assert vehicle_state.repeats
    told(vehicle_state, 30.0, depth=0.1)
    for t in range(32, 90, 2):
        told(vehicle_state, float(t), depth=0.0)
        assert not vehicle_state.repeats


def test_a_depth_that_stood_once_until_its_sensor_was_awake_is_not_coarse_for_ever():
    vehicle_state = VehicleState(Navigation())
    for t in range(10, 24, 2):
        told(vehicle_state, float(t), depth=1.2)
    for t in range(24, 60, 2):
        told(vehicle_state, float(t), depth=0.2 + 0.01 * (t % 8))
        assert not vehicle_state.repeats
    for t in range(60, 70, 2):
        told(vehicle_state, float(t), depth=0.3)
    vehicle_state.at(68.5)
    assert vehicle_state.repeats


@pytest.mark.parametrize(
    ("before", "up"), [(0.5, True), (0.7, True), (0.999, True), (1.0, False), (3.0, False)]
)
def test_a_coarse_depth_proves_the_surface_by_the_report_before_it(before: float, up: bool):
    """In steps of 0.1 m and more it is 0.0 from the first report at the surface on."""
    vehicle_state = VehicleState(Navigation())
    told(vehicle_state, 8.0, depth=before + 1.0)
    vehicle_state.rising_since = 9.0
    for t, depth in ((10.0, before), (12.0, 0.0), (14.0, 0.0), (16.0, 0.0)):
        told(vehicle_state, t, depth=depth)
    vehicle_state.at(17.999)
    assert not vehicle_state.surfaced(9.0)
    told(vehicle_state, 18.0, depth=0.0)
    assert vehicle_state.surfaced(9.0) is up


def test_what_reports_rarely_repeats_itself_only_once_a_report_is_too_old():
    vehicle_state = VehicleState(Navigation(), stale_after=20.0)
    told(vehicle_state, 10.0, depth=0.3)
    vehicle_state.at(30.0)
    assert not vehicle_state.repeats
    told(vehicle_state, 30.0, depth=0.3)
    vehicle_state.at(30.001)
    assert vehicle_state.repeats


def test_of_two_reports_within_a_step_the_later_is_believed():
    navigation = Navigation()
    vehicle_state = told(VehicleState(navigation), 10.0)
    assert vehicle_state.depth == 0.2
    navigation.doubt["altitude"] = "frozen"
    vehicle_state.take_telemetry(report(10.0, depth=3.0))
    assert vehicle_state.depth == 3.0
    assert not vehicle_state.believable("altitude")


def test_a_clone_asks_anew_and_believes_by_its_own_navigation():
    vehicle_state = told(VehicleState(Navigation()), 10.0)
    assert (vehicle_state.depth, vehicle_state.health("depth").valid) == (0.2, True)
    other = vehicle_state.clone()
    doubting = Navigation()
    doubting.doubt["depth"] = "frozen"
    other.navigation = doubting
    assert (other.depth, other.health("depth").reason) == (None, "frozen")
    assert (vehicle_state.depth, vehicle_state.health("depth").valid) == (0.2, True)


# --- position ------------------------------------------------------------------------------------


def test_an_estimate_is_reckoned_on_when_it_is_older_than_two_seconds_and_a_half():
    navigation = Counting()
    vehicle_state = told(VehicleState(navigation), 10.0)
    vehicle_state.at(12.5)
    assert vehicle_state.estimate.t == 10.0
    vehicle_state.at(12.501)
    assert vehicle_state.estimate.t == 12.501


def test_a_position_is_believed_from_anything_but_nothing():
    navigation = Navigation()
    vehicle_state = told(VehicleState(navigation), 10.0)
    assert vehicle_state.believable("position")
    navigation.mode = NavigationMode.NONE
    told(vehicle_state, 12.0)
    assert not vehicle_state.believable("position")
    navigation.mode, navigation.north = NavigationMode.FIX, math.nan
    told(vehicle_state, 13.0)
    assert not vehicle_state.believable("position")
    navigation.north, navigation.covariance = 0.0, (1.0, 0.0, math.nan)
    told(vehicle_state, 13.5)
    assert not vehicle_state.believable("position")
    assert vehicle_state.believable("heading")
    navigation.doubt["heading"] = "frozen"
    told(vehicle_state, 14.0)
    assert not vehicle_state.believable("heading")


def test_a_fix_is_told_to_navigation_and_estimated_at_once():
    navigation = Counting()
    vehicle_state = told(VehicleState(navigation), 10.0)
    navigation.north = 7.0
    vehicle_state.take_fix(fix(10.5))
    assert navigation.fixes == [fix(10.5)]
    assert (vehicle_state.estimate.t, vehicle_state.estimate.north) == (10.5, 7.0)


def test_the_vehicles_own_position_is_used_once_a_second_and_proves_no_surface():
    navigation = Counting()
    vehicle_state = VehicleState(navigation)
    for t in (10.0, 10.999, 11.0, 11.5):
        told(vehicle_state, t, depth=5.0, position=(0.5, 2.0))
    assert [f.t for f in navigation.fixes] == [10.0, 11.0]
    own = navigation.fixes[0]
    assert (own.latitude, own.longitude, own.accuracy) == (0.5, 2.0, math.inf)
    assert vehicle_state.fix is None
    assert not vehicle_state.surfaced(0.0)


def test_the_vehicles_own_position_is_in_the_estimate_of_its_report():
    class Moved(Navigation):
        def fix(self, f: Fix) -> None:
            super().fix(f)
            self.north = 77.0

    vehicle_state = told(VehicleState(Moved()), 10.0, depth=5.0, position=(0.5, 2.0))
    assert vehicle_state.estimate.north == 77.0


def test_the_vehicles_own_position_is_a_fix_once_the_depth_has_proved_the_surface():
    vehicle_state = VehicleState(Navigation())
    for t in (10.0, 12.0, 14.0, 15.999):
        told(vehicle_state, t, position=(0.5, 2.0))
        assert vehicle_state.fix is None
    told(vehicle_state, 17.0, position=(0.5, 2.0))
    assert vehicle_state.fix.t == 17.0
    vehicle_state = VehicleState(Navigation())
    told(vehicle_state, 10.0, position=(0.5, 2.0))
    told(vehicle_state, 16.0, position=(0.5, 2.0))
    assert vehicle_state.fix.t == 16.0


def test_the_vehicles_own_position_is_no_fix_while_a_receiver_says_places():
    vehicle_state = VehicleState(Navigation())
    for t in (10.0, 12.0, 14.0, 16.0, 17.0):
        told(vehicle_state, t)
    vehicle_state.take_fix(fix(17.5))
    for t in range(18, 30):
        told(vehicle_state, float(t), position=(0.5, 2.0))
        vehicle_state.take_fix(fix(t + 0.5, north=0.1 * min(t, 24)))  # then it is stuck
        assert all(f.accuracy < math.inf for f in vehicle_state.fixes)
    told(vehicle_state, 30.0, position=(0.5, 2.0))
    assert vehicle_state.fix.accuracy == math.inf


def test_a_place_is_metres_from_home_and_unknown_where_home_is():
    navigation = Navigation()
    vehicle_state = VehicleState(navigation)
    assert vehicle_state.place(Local(3.0, 4.0)) == (3.0, 4.0)
    assert vehicle_state.place("home") == (0.0, 0.0)
    assert vehicle_state.place(HOME) is None
    navigation.frame = Frame(HOME)
    north = Position(HOME.latitude_deg + math.degrees(100.0 * _METRE), HOME.longitude_deg)
    assert vehicle_state.place(north) == pytest.approx((100.0, 0.0), abs=1e-6)


def test_the_compass_says_a_true_heading_with_what_it_is_off_now():
    navigation = Navigation()
    vehicle_state = VehicleState(navigation)
    off = 0.5
    estimate = navigation.estimate
    navigation.estimate = lambda now: estimate(now)._replace(heading=6.0)
    told(vehicle_state, 10.0, heading=(6.0 + off) % math.tau)
    assert vehicle_state.compass(1.0) == pytest.approx(1.0 + off)
    assert vehicle_state.compass(6.2) == pytest.approx(6.2 + off - math.tau)
    told(vehicle_state, 12.0, heading=None)
    assert vehicle_state.compass(1.0) == pytest.approx(1.0 + off)
    navigation.doubt["heading"] = "absurd"
    told(vehicle_state, 13.0, heading=3.0)
    assert vehicle_state.compass(1.0) == pytest.approx(1.0 + off)
    navigation.doubt.clear()
    told(vehicle_state, 14.0, heading=6.0)
    assert vehicle_state.compass(1.0) == pytest.approx(1.0)


# --- thrust that is not reported -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "thrust"),
    [
        (None, (0.0, 0.0, 0.0)),
        (Setpoint(surge=0.5, turn=0.2), (0.7, 0.3, 0.0)),
        (Setpoint(surge=0.5, depth=0.0), (0.5, 0.5, 1.0)),
        (Setpoint(surge=0.5, altitude=0.0), (0.5, 0.5, 1.0)),
        (Setpoint(surge=0.5, heave=-0.25), (0.5, 0.5, -0.25)),
        (Order.SURFACE, (0.0, 0.0, -1.0)),
        (Order.STOP, (0.0, 0.0, 0.0)),
    ],
)
def test_thrusters_that_are_not_reported_do_what_they_were_told(command, thrust):
    navigation = Navigation()
    vehicle_state = VehicleState(navigation)
    vehicle_state.word = command
    told(vehicle_state, 10.0, actuators=None)
    assert navigation.report.actuators == pytest.approx(thrust)
    told(vehicle_state, 12.0)
    assert navigation.report.actuators == NEUTRAL


# --- home --------------------------------------------------------------------------------------------


def after(*fixes: Fix) -> VehicleState:
    vehicle_state = VehicleState()
    for one in fixes:
        vehicle_state.take_fix(one)
    return vehicle_state


def test_home_takes_the_last_five_fixes_and_no_older_one():
    good = [fix(float(t), north=float(t)) for t in range(5)]
    assert after(*good[:4]).home_from_fixes() is None
    home = after(*good).home_from_fixes()
    assert math.radians(home.latitude_deg) == pytest.approx(LAT + 2.0 * _METRE, abs=1e-12)
    assert home.longitude_deg == pytest.approx(HOME.longitude_deg)
    assert after(fix(0.0, hdop=9.0), *good).home_from_fixes() == home
    assert after(*good, fix(5.0, hdop=9.0)).home_from_fixes() is None
    assert len(after(*good, *good).fixes) == 5


def test_a_fix_for_home_has_hdop_3_at_most_and_lies_within_ten_metres_of_the_median():
    def with_one(**values: object) -> VehicleState:
        return after(*(fix(float(t)) for t in range(4)), fix(4.0, **values))

    assert with_one(hdop=3.0).home_from_fixes() is not None
    assert with_one(hdop=3.001).home_from_fixes() is None
    assert with_one(hdop=None).home_from_fixes() is None
    assert with_one(north=9.999).home_from_fixes() is not None
    assert with_one(north=-10.001).home_from_fixes() is None


def test_metres_are_those_of_the_mean_sphere_also_across_the_antimeridian():
    degree = math.radians(1.0)
    assert metres(0.0, 0.0, degree, 0.0) == pytest.approx(111195.0802, abs=1e-3)
    assert metres(0.5, 0.0, 0.5, 1e-4) == pytest.approx(637.10088 * math.cos(0.5), abs=1e-4)
    assert metres(0.4, 0.0, 0.6, 1e-4) == pytest.approx(metres(0.6, 1e-4, 0.4, 0.0))
    across = metres(0.0, math.pi - 1e-4, 0.0, -math.pi + 1e-4)
    assert across == pytest.approx(2.0 * 637.10088, abs=1e-4)
    slanted = math.hypot(1e-4, 1e-4 * math.cos(0.5 * (0.5 + 0.5001))) * 6371008.8
    assert metres(0.5, 0.0, 0.5001, 1e-4) == pytest.approx(slanted, abs=1e-6)
