"""Sensors that a user adds: what each is worth by truth, and that one which lies spoils nothing."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from random import Random

import pytest
from kinematic_truth import HOME, Sea, Truth, sail

from links.simulated.settings import parse_settings
from mission.analysis.smoothing import smooth
from mission.authoring.language import parse
from mission.model import Estimate
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Beacon
from mission.navigation import Navigation
from mission.navigation.added import ADDED
from mission.navigation.distribution import PLANE_95, principal
from mission.navigation.geodesy import LocalFrame
from mission.verification.simulation.flight import fly
from protocol.messages import Aid, Fix, Telemetry

BEACON = Beacon(math.radians(30.2900), math.radians(120.1560), 8.0)
AUV = replace(load_vehicle("auv"), beacons={"3": BEACON})
LIES = ("frozen", "silent", "wild")
SEA = Sea(current=(0.25, -0.2))
FRAME = LocalFrame(HOME)
BEACON_AT = FRAME.to_local(BEACON.latitude, BEACON.longitude)
Said = Telemetry | Fix | Aid


@cache
def voyage(seed: int = 3) -> tuple[tuple[Truth, Telemetry | Fix], ...]:
    """A minute of fixes, then 500 s under water."""
    return tuple(sail(SEA, 60.0, 500.0, seed))


def aids(kind: str, truth: Truth, rng: Random) -> tuple[float, ...]:
    """What an honest sensor says of it, with its noise."""
    sigma = ADDED[kind].sigma
    c, s = math.cos(truth.heading), math.sin(truth.heading)
    north, east = SEA.current
    exact = {
        "water": (truth.speed,),
        "ground": (truth.speed + north * c + east * s, east * c - north * s),
        "place": (truth.north, truth.east),
        "range": (math.hypot(truth.north - BEACON_AT[0], truth.east - BEACON_AT[1],
                             truth.depth - BEACON.depth),),
    }[kind]  # fmt: skip
    return said(kind, tuple(value + rng.gauss(0.0, sigma) for value in exact))


def said(kind: str, values: tuple[float, ...]) -> tuple[float, ...]:
    """As the line says it."""
    if kind == "place":
        return FRAME.to_geodetic(*values)
    return (3.0, values[0] / BEACON.sound) if kind == "range" else values


def told(kind: str, lie: str = "", since: float = 0.0, seed: int = 1) -> Iterator[Said]:
    """Everything that comes in, with this sensor; ``lie`` from ``since`` on."""
    rng, last = Random(seed), tuple[float, ...]()
    for truth, item in voyage():
        yield item
        slow = kind in ("place", "range") and truth.t % 4
        if not kind or isinstance(item, Fix) or slow:
            continue
        values, lies = aids(kind, truth, rng), lie if truth.t >= since else ""
        wild = tuple(v + rng.uniform(-3.0, 3.0) for v in values)
        if kind == "place":
            wild = FRAME.to_geodetic(
                truth.north + rng.uniform(-300, 300), truth.east + rng.uniform(-300, 300)
            )
        elif kind == "range":
            wild = said(kind, (rng.uniform(1.0, 600.0),))
        if lies != "silent":
            last = {"frozen": last or values, "wild": wild}.get(lies, values)
            yield Aid(item.t + 0.3, kind, last)


def navigated(items: Iterable[Said]) -> Navigation:
    navigation = Navigation(AUV, HOME)
    for item in items:
        if isinstance(item, Telemetry):
            navigation.telemetry(item)
        elif isinstance(item, Fix):
            navigation.fix(item)
        else:
            navigation.aid(item)
    return navigation


def under_water(items: Iterable[Said]) -> list[Said]:
    return [item for item in items if item.t < 555.0]


def error(items: Sequence[Said]) -> float:
    """m, at the end of the dive."""
    truth = next(truth for truth, item in voyage() if truth.t >= items[-1].t - 0.5)
    found = navigated(items).estimate(truth.t)
    assert found is not None
    return math.hypot(found.north - truth.north, found.east - truth.east)


@pytest.mark.parametrize(("kind", "share"), [("ground", 0.35), ("place", 0.15), ("range", 0.35)])
def test_an_honest_sensor_makes_the_estimate_better(kind: str, share: float) -> None:
    without = error(under_water(told("")))
    assert without > 20.0
    assert error(under_water(told(kind))) < share * without


def test_a_speed_log_finds_the_speed_that_the_table_does_not_know() -> None:
    def off(items: Iterable[Said]) -> float:
        found = navigated(items).estimate(554.0)
        assert found is not None
        return abs(found.speed - 1.05)

    wrong = [i for i in under_water(told("")) if not isinstance(i, Fix) or i.t < 3.0]
    right = [i for i in under_water(told("water")) if not isinstance(i, Fix) or i.t < 3.0]
    assert off(right) < 0.6 * off(wrong)


def test_a_doppler_log_beside_a_compass_that_never_spoke_teaches_nothing() -> None:
    """Nobody knows to which side what it says along the bow is."""

    def turned(items: Iterable[Said]) -> Estimate:
        without = (i._replace(heading=None) if isinstance(i, Telemetry) else i for i in items)
        found = navigated(without).estimate(554.0)
        assert found is not None
        return found

    beside, alone = (turned(under_water(told(kind))) for kind in ("ground", ""))
    assert (beside.north, beside.east) == pytest.approx((alone.north, alone.east), abs=0.1)
    assert beside.current_north == pytest.approx(alone.current_north, abs=0.001)


def flood(kind: str, rate: int) -> Iterator[Said]:
    """An honest sensor that speaks so often a second, each time with noise of its own."""
    rng = Random(1)
    for truth, item in voyage():
        yield item
        if isinstance(item, Telemetry):
            for k in range(2 * rate):
                yield Aid(item.t + 0.01 + 1.98 * k / (2 * rate), kind, aids(kind, truth, rng))


@pytest.mark.proof
@pytest.mark.parametrize("rate", [5, 100])
def test_a_doppler_log_that_speaks_often_makes_the_estimate_no_surer_than_it_is(rate: int) -> None:
    items = under_water(flood("ground", rate))
    navigation = navigated(items)
    truth = next(truth for truth, item in voyage() if truth.t >= items[-1].t - 0.5)
    found = navigation.estimate(truth.t)
    assert found is not None
    (nn, ne, ee), dn, de = found.covariance, found.north - truth.north, found.east - truth.east
    assert (ee * dn * dn - 2.0 * ne * dn * de + nn * de * de) / (nn * ee - ne * ne) < 9.21
    assert navigation.dropped == 0  # the fixes of a receiver are not crowded out


@pytest.mark.parametrize("lie", LIES)
@pytest.mark.parametrize("kind", ADDED)
def test_a_sensor_that_lies_from_the_first_spoils_nothing(kind: str, lie: str) -> None:
    assert error(under_water(told(kind, lie))) < 1.3 * error(under_water(told(""))) + 3.0


@pytest.mark.parametrize("lie", LIES)
@pytest.mark.parametrize("kind", ADDED)
def test_a_sensor_that_begins_to_lie_leaves_what_it_taught(kind: str, lie: str) -> None:
    assert error(under_water(told(kind, lie, 250.0))) < 1.3 * error(under_water(told(""))) + 3.0


def test_a_sensor_that_froze_while_its_line_was_away_is_not_believed_in_the_end() -> None:
    """It says half of the speed from the first on that is heard of it again."""

    def frozen() -> Iterator[Said]:
        for item in under_water(told("ground")):
            if not isinstance(item, Aid) or item.t < 250.0:
                yield item
            elif item.t > 300.0:
                yield replace(item, values=(0.5, 0.0))

    assert error(list(frozen())) < 1.3 * error(under_water(told(""))) + 3.0


@pytest.mark.parametrize("sets_off", [True, False])
def test_a_doppler_log_that_froze_before_it_was_heard_on_a_steady_course_teaches_nothing(
    sets_off: bool,
) -> None:
    """At rest, as gear is given; or it froze before the program began. It says half the speed."""

    def said(frozen: bool) -> Iterator[Said]:
        for truth, item in sail(SEA, 8.0, 80.0, 3):
            if sets_off and isinstance(item, Telemetry) and item.t < 8.0:
                item = item._replace(actuators=(0.0,) * 5)
            yield item
            if frozen and isinstance(item, Telemetry) and truth.t < 84.0:
                yield Aid(item.t + 0.3, "ground", (0.5, 0.0))

    found, without = (
        navigated(i for i in said(f) if i.t < 84.0).estimate(84.0) for f in (True, False)
    )
    assert found is not None
    assert without is not None
    assert math.hypot(found.north - without.north, found.east - without.east) < 1.0


def test_a_place_that_froze_while_it_drifted_with_nothing_on_is_not_believed() -> None:
    def said() -> Iterator[Said]:
        rng, frozen = Random(1), (0.0, 0.0)
        for truth, item in sail(SEA, 60.0, 300.0, 3, gear=0.0, speed=0.0):
            yield item
            if isinstance(item, Telemetry) and truth.t % 4 == 0 and truth.t < 355.0:
                frozen = aids("place", truth, rng) if truth.t <= 64.0 else frozen
                yield Aid(item.t + 0.3, "place", frozen)

    found = navigated(item for item in said() if item.t < 355.0).estimate(355.0)
    assert found is not None
    off = math.hypot(found.north - 355.0 * SEA.current[0], found.east - 355.0 * SEA.current[1])
    assert off < PLANE_95 * principal(found.covariance)[1]


def test_a_doppler_log_that_freezes_on_the_bend_into_a_dive_teaches_nothing_of_the_current() -> (
    None
):
    assert flown("doppler=0.03", "added_lie=frozen@8") < 1.2 * flown()


@pytest.mark.parametrize("kind", ["ground", "place", "range"])
def test_an_honest_sensor_that_was_not_believed_is_believed_again(kind: str) -> None:
    def late() -> Iterator[Said]:
        for item in under_water(told(kind)):
            if not isinstance(item, Aid) or item.t > 400.0:
                yield item

    navigation = Navigation(AUV, HOME)
    items = list(late())
    for item in items:
        if isinstance(item, Telemetry):
            navigation.telemetry(item)
            if 390.0 < item.t < 392.0:  # as sure as can be of what is wrong
                navigation.core.place(item.t, 300.0, -300.0, 0.01)
                navigation.core.filter.trust(navigation.core.figures, 0.01)
        elif isinstance(item, Fix):
            navigation.fix(item)
        else:
            navigation.aid(item)
    found = navigation.estimate(554.0)
    assert found is not None
    truth = next(truth for truth, _ in voyage() if truth.t >= 554.0)
    if kind != "ground":
        off = math.hypot(found.north - truth.north, found.east - truth.east)
        assert off < (10.0 if kind == "place" else 100.0)  # one beacon tells one direction
    else:
        water = found.current_north - SEA.current[0], found.current_east - SEA.current[1]
        assert math.hypot(*water) < 0.15


def test_what_comes_late_is_put_in_its_place() -> None:
    punctual = under_water(told("ground"))
    late = list(punctual)
    n = next(n for n, item in enumerate(late) if isinstance(item, Aid) and item.t > 300.0)
    late.insert(n + 4, late.pop(n))
    assert navigated(late).estimate(555.0) == navigated(punctual).estimate(555.0)


def test_a_snapshot_has_what_is_remembered_of_each() -> None:
    items = under_water(told("place", "frozen", 200.0))
    one = navigated(items[:400])
    kept, other = one.snapshot(), Navigation(AUV, HOME)
    other.restore(kept)
    for navigation in (one, other):
        for item in items[400:]:
            if isinstance(item, Telemetry):
                navigation.telemetry(item)
            elif isinstance(item, Aid):
                navigation.aid(item)
    assert one.estimate(555.0) == other.estimate(555.0)


def test_a_place_from_outside_is_no_fix() -> None:
    navigation = Navigation(AUV, HOME)
    for n in range(8):
        assert navigation.core.located is (n > 4)
        navigation.telemetry(Telemetry(1.0 + n, depth=5.0, heading=0.0))
        place = FRAME.to_geodetic(10.0 + 0.1 * n, 20.0)
        navigation.aid(Aid(1.5 + n, "place", place))
    found = navigation.estimate(9.0)
    assert found is not None
    assert (found.north, found.east) == pytest.approx((10.5, 20.0), abs=1.0)
    assert found.fix_age is None
    assert not navigation.health("position", 9.0).valid


# --- ways from beacons ----------------------------------------------------------------------------


def test_a_beacon_that_the_vehicle_file_does_not_know_teaches_nothing() -> None:
    items = under_water(told("range"))
    stranger = [Aid(i.t, i.kind, (4.0, i.values[1])) if isinstance(i, Aid) else i for i in items]
    assert navigated(stranger).estimate(555.0) == navigated(under_water(told(""))).estimate(555.0)


def test_without_a_position_a_range_gives_none() -> None:
    navigation = Navigation(AUV, HOME)
    for n in range(20):
        navigation.telemetry(Telemetry(1.0 + n, depth=5.0, heading=0.0))
        navigation.aid(Aid(1.5 + n, "range", (3.0, 0.2)))
    assert not navigation.core.located


# --- after the dive -------------------------------------------------------------------------------


def smoothed_off(kind: str, lie: str = "") -> float:
    """m, the mean over the dive of the smoothed track from the truth."""
    track = smooth(told(kind, lie), AUV, HOME)
    truth = {t.t: (t.north, t.east) for t, _ in voyage()}
    off = [
        math.dist(place, truth[t])
        for t, place in zip(track.t.tolist(), track.smoothed.tolist(), strict=True)
        if t in truth and 60.0 < t < 560.0
    ]
    assert len(off) > 100
    return sum(off) / len(off)


@pytest.mark.parametrize("kind", ["place", "range"])
def test_the_smoothed_track_is_nearer_to_the_truth_with_a_sensor(kind: str) -> None:
    assert smoothed_off(kind) < 0.8 * smoothed_off("")


def test_the_smoothed_track_is_not_spoilt_by_a_sensor_that_lies() -> None:
    assert smoothed_off("ground", "wild") < 1.3 * smoothed_off("") + 1.0


# --- flown ----------------------------------------------------------------------------------------

FAR = """mission far vehicle auv
home 30.2874595 120.1535765
safety radius 1500 time 60min depth 20
assume current 0.3
down: depth 6 heading 40 gear 6 until depth >= 5 timeout 2min
a: gear 8 heading 40 for 150
b: heading 130 for 150
up: surface until fix timeout 4min
"""


def flown(*settings: str) -> float:
    flight = fly(parse(FAR), AUV, "as-built", 5, parse_settings(["current=0.3@200", *settings]))
    assert flight.outcome == "completed"
    deep = [s for s in flight.samples if s.true.depth > 4.0]
    last = deep[-1]
    return math.hypot(last.estimate.north - last.true.north, last.estimate.east - last.true.east)


@pytest.mark.proof
def test_flown_by_truth_each_is_worth_what_the_manual_says() -> None:
    without = flown()
    assert without > 20.0
    assert flown("doppler=0.03") < 0.3 * without
    assert flown("acoustic=3") < 0.2 * without
    assert flown("ranges=2") < 0.35 * without
    assert flown("doppler=0.03", "added_lie=wild@0") < 1.3 * without
