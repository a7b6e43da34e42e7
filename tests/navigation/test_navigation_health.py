"""Each way in which a sensor can be disbelieved, and how it is believed again."""

from __future__ import annotations

import math

import pytest

from mission.model import Vertical
from mission.model.shipped import load_vehicle
from mission.navigation.health import SENSORS, SensorHealth
from protocol.messages import Fix, Telemetry

_MOVING = (0.5, 0.5, 0.0, 0.0, 0.0)
_ALL = frozenset(SENSORS)


def report(i: int, **fields: object) -> Telemetry:
    base = Telemetry(
        2.0 * i,
        depth=5.0 + 0.01 * i,
        altitude=9.0 - 0.01 * i,
        heading=(6.2 + 0.03 * i) % (2.0 * math.pi),
        pitch=0.001 * i,
        roll=-0.001 * i,
        temperature_c=15.0,
        batteries=(12.0, 48.0),
        actuators=_MOVING,
        leak=False,
    )
    return base._replace(**fields)  # type: ignore[arg-type]


def after(*reports: Telemetry) -> SensorHealth:
    health = SensorHealth(_ALL)
    for r in reports:
        health.telemetry(r)
    return health


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sensor_that_never_reported_is_missing(sensor: str) -> None:
    health = SensorHealth(_ALL).of(sensor, 1.0)
    assert (health.valid, health.reason) == (False, "missing")


def test_a_depth_that_was_frozen_is_believed_as_soon_as_it_moves() -> None:
    """What it said meanwhile speaks against nothing: it was known to be none."""
    pushed = Vertical(-1.0, -math.inf)
    health = after(*(report(i) for i in range(6)))
    for i in range(6, 60):
        health.telemetry(report(i, depth=6.0), pushed)
    assert health.of("depth", 118.0).reason == "frozen"
    health.telemetry(report(60, depth=2.0), pushed)
    assert health.of("depth", 120.0).valid


@pytest.mark.parametrize("sensor", SENSORS)
def test_what_was_heard_a_moment_ago_is_valid_and_grows_stale(sensor: str) -> None:
    health = after(*(report(i) for i in range(8)))
    health.fix(Fix(14.0, 0.5, 2.0, 2.5))
    assert health.of(sensor, 14.5).valid
    late = health.of(sensor, 14.0 + 31.0)
    assert (late.valid, late.reason, late.age) == (False, "stale", 31.0)


@pytest.mark.parametrize("name", ["depth", "altitude", "heading", "pitch", "roll"])
def test_five_identical_reports_are_frozen_and_the_next_change_thaws(name: str) -> None:
    sensor = "attitude" if name in ("pitch", "roll") else name
    reports = [report(i, **{name: 1.25}) for i in range(5)]
    assert after(*reports[:4]).of(sensor, 8.0).valid
    health = after(*reports)
    assert health.of(sensor, 8.0).reason == "frozen"
    health.telemetry(report(5, **{name: 1.2500001}))
    assert health.of(sensor, 10.0).valid


@pytest.mark.parametrize(("hertz", "changes_each"), [(10.0, 0.5), (50.0, 0.2), (10.0, 5.0)])
def test_a_sensor_that_is_slower_than_the_reports_of_its_board_is_not_frozen(
    hertz: float, changes_each: float
) -> None:
    """A depth in whole centimetres, or new twice a second, on a board that says ten reports."""
    health = SensorHealth(_ALL)
    for i in range(int(20 * hertz)):
        t = i / hertz
        depth = 5.0 - 0.01 * math.floor(t / changes_each)
        health.telemetry(report(i, depth=depth)._replace(t=t))
        assert health.of("depth", t).valid
    for i in range(int(20 * hertz), int(28 * hertz)):
        health.telemetry(report(i, depth=4.0)._replace(t=i / hertz))
    assert health.of("depth", 28.0).reason == "frozen"


def test_a_vehicle_at_rest_freezes_nothing() -> None:
    still = (0.0, 0.0, 0.0, 0.0, 0.0)
    health = after(*(report(i, depth=1.25, actuators=still) for i in range(9)))
    assert health.of("depth", 16.0).valid


@pytest.mark.parametrize("hertz", [0.5, 10.0, 50.0])
def test_what_stood_at_rest_has_7_s_of_thrust_before_it_is_frozen(hertz: float) -> None:
    """A depth in the air, a heading on deck: on a fast board some repeats are a moment."""
    health, still, begun = SensorHealth(_ALL), (0.0, 0.0, 0.0, 0.0, 0.0), int(60.0 * hertz)
    for i in range(begun + int(12.0 * hertz)):
        actuators = still if i < begun else _MOVING
        one = report(0, depth=0.0, heading=1.0, actuators=actuators)._replace(t=i / hertz)
        health.telemetry(one)
        assert health.of("depth", one.t).valid or one.t >= 66.0
    assert health.of("depth", one.t).reason == health.of("heading", one.t).reason == "frozen"


def test_batteries_and_temperature_may_be_constant() -> None:
    health = after(*(report(i) for i in range(20)))
    assert health.of("battery", 38.0).valid
    assert health.of("temperature", 38.0).valid


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("depth", 6553.5),
        ("depth", math.nan),
        ("depth", -10.0),
        ("altitude", math.inf),
        ("altitude", 0.0),
        ("heading", 7.0),
        ("pitch", 3.0),
        ("temperature_c", 200.0),
    ],
)
def test_what_cannot_be_is_absurd(name: str, value: float) -> None:
    sensor = {"temperature_c": "temperature", "pitch": "attitude"}.get(name, name)
    health = after(report(0), report(1, **{name: value}))
    assert health.of(sensor, 2.0).reason == "absurd"
    health.telemetry(report(2))
    assert health.of(sensor, 4.0).valid


def test_a_leap_is_absurd_until_three_reports_agree_on_it() -> None:
    health = after(report(0), report(1))
    for i, valid in [(2, False), (3, False), (4, True)]:
        health.telemetry(report(i, altitude=240.0 + 0.1 * i))
        assert health.of("altitude", 2.0 * i).valid is valid


def test_a_depth_that_leapt_is_contradicted_once_three_reports_agree_on_it() -> None:
    health = after(report(0), report(1))
    for i, why in [(2, "absurd"), (3, "absurd"), (4, "contradicted: it leapt by 35.2 m")]:
        health.telemetry(report(i, depth=40.0 + 0.1 * i))
        assert health.of("depth", 2.0 * i).reason == why


@pytest.mark.parametrize("hertz", [10, 20, 50])
@pytest.mark.parametrize("name", ["depth", "altitude", "heading", "pitch"])
def test_what_a_quick_board_repeats_for_less_than_a_second_is_not_agreed_on(
    name: str, hertz: int
) -> None:
    """It may say 50 times a second what its sensor says twice."""
    wrong = {"depth": 9.0, "altitude": 90.0, "heading": 3.0, "pitch": 9.0}[name]
    sensor = "attitude" if name == "pitch" else name
    health = SensorHealth(_ALL)
    for i in range(5 * hertz):
        t = i / hertz
        base = report(0, depth=5.0 + 0.01 * t, altitude=9.0 - 0.01 * t, heading=0.1 + 0.01 * t)
        fields = {name: wrong + 0.001 * t} if 2.0 <= t < 2.9 else {}
        health.telemetry(base._replace(t=t, pitch=0.001 * t, roll=0.001 * t)._replace(**fields))
        if 2.0 <= t < 2.9:
            assert health.of(sensor, t).reason == "absurd"
        elif not 2.9 <= t < 3.5:
            assert health.of(sensor, t).valid
    for i in range(5 * hertz, 7 * hertz):
        t = i / hertz
        health.telemetry(report(0, depth=9.0 + 0.01 * t)._replace(t=t))
    assert health.of("depth", t).reason.startswith("contradicted: it leapt")


@pytest.mark.parametrize(("hertz", "changes_each"), [(10.0, 0.5), (50.0, 0.2), (50.0, 1.0)])
def test_one_wild_value_of_a_sensor_that_is_slower_than_its_board_is_no_leap(
    hertz: float, changes_each: float
) -> None:
    """The board repeats it until there is the next one. What stays elsewhere leapt all the same."""
    health = SensorHealth(_ALL)
    for i in range(int(30.0 * hertz)):
        said = math.floor(i / hertz / changes_each + 1e-6)
        wild = said == math.floor(10.0 / changes_each) or i / hertz > 25.0
        depth = 40.0 if wild else 5.0 + 0.01 * said
        health.telemetry(report(i, depth=depth)._replace(t=i / hertz))
        seen = health.of("depth", i / hertz)
        assert seen.reason in ("", "absurd") or i / hertz > 25.9
        assert seen.valid or not 13.0 < i / hertz < 25.0
    assert seen.reason.startswith("contradicted: it leapt by 3")


@pytest.mark.parametrize(
    ("every", "repeats", "wrong"),
    [(0.1, 5, 6.995), (0.1, 9, 6.995), (2.0, 1, 8.999)],
)
def test_the_way_back_from_one_wild_value_in_reach_is_no_leap(
    every: float, repeats: int, wrong: float
) -> None:
    """The value is as far as a vehicle may go until then, and goes on being repeated."""
    health = SensorHealth(_ALL)
    for i in range(60):
        t, is_wild = i * every, 20 <= i < 20 + repeats
        depth = wrong if is_wild else 5.0 - 0.002 * (i - 20)
        health.telemetry(report(0, depth=depth)._replace(t=t))
        assert health.of("depth", t).reason in ("", "absurd")
    assert health.of("depth", t).valid


@pytest.mark.parametrize(("every", "leap"), [(0.1, 2.2), (0.1, -2.2), (2.0, 5.2), (2.0, -5.2)])
@pytest.mark.parametrize("rate", [-0.5, 0.0, 0.5])
def test_a_depth_that_leaps_while_the_vehicle_moves_is_contradicted(
    every: float, leap: float, rate: float
) -> None:
    """It is nearer to the depth before the last than to the last one, and that is no return."""
    health = SensorHealth(_ALL)
    for i in range(40):
        t = i * every
        depth = 60.0 + rate * t + leap * (i >= 20) + 0.001 * (i % 2)
        health.telemetry(report(0, depth=depth)._replace(t=t))
    assert health.of("depth", t).reason.startswith("contradicted: it leapt")


def test_a_heading_through_north_is_no_leap() -> None:
    health = after(report(0, heading=6.28), report(1, heading=0.01))
    assert health.of("heading", 2.0).valid


def test_what_the_codec_doubts_is_absurd() -> None:
    health = after(report(0), report(1, faults=("depth_m:out_of_range",)))
    assert health.of("depth", 2.0).reason == "absurd"
    assert health.of("heading", 2.0).valid


@pytest.mark.parametrize(
    ("field", "fault"),
    [
        ("depth", "depth_m:nan"),
        ("altitude", "altitude_m:infinite"),
        ("heading", "yaw_deg:nan"),
        ("roll", "roll_deg:nan"),
        ("temperature_c", "temperature_c:nan"),
    ],
)
def test_what_is_no_number_is_absurd_with_that_report_and_not_once_it_is_stale(field, fault):
    sensor = {"temperature_c": "temperature", "roll": "attitude"}.get(field, field)
    health = after(report(0), report(1, **{field: None}, faults=(fault,)))
    assert health.of(sensor, 2.0).reason == "absurd"
    health.telemetry(report(2))
    assert health.of(sensor, 4.0).valid


def test_what_a_report_does_not_speak_of_is_as_it_was() -> None:
    health = after(report(0), report(1, batteries=None, leak=None))
    assert health.of("battery", 2.0).valid
    assert health.of("leak", 2.0).valid


def test_what_the_vehicle_file_says_is_absent_is_missing() -> None:
    health = SensorHealth(_ALL - {"altitude"})
    health.telemetry(report(0))
    assert health.of("altitude", 0.0).reason == "missing"


@pytest.mark.parametrize("sensor", ["depth", "altitude", "heading", "attitude", "leak"])
def test_the_vehicle_file_says_when_its_reports_are_stale(sensor: str) -> None:
    """R16: those of the core board after 1 s; slow quantities and fixes keep their own age."""
    health = SensorHealth(_ALL, load_vehicle("coreboard").stale_after)
    health.telemetry(report(5))
    health.fix(Fix(10.0, 0.5, 2.0, 2.5))
    assert health.of(sensor, 11.0).valid
    assert health.of(sensor, 11.01).reason == "stale"
    for slow in ("temperature", "battery", "position"):
        assert health.of(slow, 15.0).valid
    usual = SensorHealth(_ALL, load_vehicle("auv").stale_after)
    usual.telemetry(report(5))
    assert usual.of(sensor, 16.0).valid
    assert usual.of(sensor, 16.01).reason == "stale"


def stuck(thrust: float, fixes: int = 8) -> tuple[SensorHealth, list[bool]]:
    """A receiver that says one place for ever, second by second, and what is believed of it."""
    health, believed = SensorHealth(_ALL), []
    for i in range(fixes):
        if i % 2 == 0:
            afloat = report(i // 2, depth=0.2 + 0.001 * i)
            health.telemetry(afloat._replace(actuators=(thrust,) * 2 + (0.0,) * 3))
        believed.append(health.fix(Fix(float(i), 0.5, 2.0, 2.5)))
    return health, believed


def test_a_receiver_that_says_one_place_while_the_vehicle_moves_is_frozen():
    health, believed = stuck(0.5)
    assert believed == [True] * 4 + [False] * 4
    assert health.of("position", 8.0).reason == "frozen"
    assert health.fix(Fix(8.0, 0.5, 2.0 + 1e-9, 2.5))
    assert health.of("position", 8.0).valid


@pytest.mark.parametrize(("depth", "teaches"), [(0.5, True), (0.9, False)])
def test_a_fix_under_water_teaches_nothing_while_the_depth_is_believed(depth: float, teaches: bool):
    health = after(*(report(i, depth=depth + 0.001 * i) for i in range(3)))
    assert health.fix(Fix(5.0, 0.5, 2.0, 2.5)) is teaches
    assert health.fix(Fix(6.0, 0.5, 2.1, math.inf))  # the vehicle's own reckoning
    assert health.fix(Fix(11.0, 0.5, 2.2, 2.5))  # the depth is stale


@pytest.mark.parametrize(
    ("deep", "reason"),
    [(5.0, ""), (0.2, "contradicted: it leapt by -4.9 m")],
    ids=["stays at 5 m", "leaps to the surface"],
)
def test_what_the_vehicle_reckons_itself_speaks_neither_for_its_depth_nor_against_it(
    deep: float, reason: str
):
    """Under water it goes on: no receiver has seen the sky there."""
    said = []
    for places in (False, True):
        health = SensorHealth(_ALL)
        for second in range(120):
            depth = 5.0 if second < 30 else deep
            seen = report(0, depth=depth + 0.01 * math.sin(second), altitude=None)
            health.telemetry(seen._replace(t=float(second)), Vertical(0.0, None))
            if places:
                assert health.fix(Fix(second + 0.1, 0.5 + 1e-7 * second, 2.0, math.inf))
        said.append(health.of("depth", 119.0).reason)
    assert said[0] == said[1]
    assert said[0][:26] == reason[:26]


@pytest.mark.parametrize("places", [2, 4, 30])
@pytest.mark.parametrize("pause", [1.0, 20.0])
def test_a_receiver_that_says_a_few_places_in_turn_while_the_vehicle_moves_is_frozen(
    places: int, pause: float
):
    health, believed = SensorHealth(_ALL), []
    for i in range(places + 20):
        health.telemetry(report(i, depth=0.2 + 0.001 * i))
        believed.append(health.fix(Fix(i * pause, 0.5, 2.0 + 1e-6 * (i % places), 2.5)))
    assert believed == [True] * (places + 3) + [False] * 17
    assert health.of("position", (places + 19) * pause).reason == "frozen"
    assert health.fix(Fix((places + 20) * pause, 0.5, 2.1, 2.5))


def test_at_rest_a_receiver_may_say_one_place_for_ever():
    health, believed = stuck(0.0, 60)
    assert all(believed)
    assert health.of("position", 60.0).valid


def test_among_garbage_a_value_that_fits_by_chance_is_not_believed() -> None:
    """Readings of +1000, -1000 and 0 m in turn, at 8 m: 0 is no surface."""
    health = after(*(report(i, depth=8.0 + 0.01 * i) for i in range(5)))
    for i in range(5, 35):
        health.telemetry(report(i, depth=(1000.0, -1000.0, 0.0)[i % 3]))
        assert not health.of("depth", 2.0 * i).valid
    for i in range(35, 38):
        health.telemetry(report(i, depth=9.0 + 0.01 * i))
    assert health.of("depth", 74.0).valid


@pytest.mark.parametrize("garbage", [1, 2, 3, 12])
@pytest.mark.parametrize("name", ["depth_m", "yaw_deg", "roll_deg", "temperature_c", "battery"])
def test_no_sensor_is_lost_for_good_by_garbage_that_ends(name: str, garbage: int) -> None:
    """Flight 6424: 11083: a battery at full scale for 25 s, and its limit never acted again."""
    doubted = (f"{name}:range",) if name != "battery" else ()
    spoilt: dict[str, object] = {"faults": doubted}
    spoilt |= {} if doubted else {"batteries": (65535.0, 65535.0)}
    sensor = {"depth_m": "depth", "yaw_deg": "heading", "roll_deg": "attitude"}.get(name, name)
    sensor = sensor.removesuffix("_c")
    health = after(report(0), *(report(i, **spoilt) for i in range(1, garbage + 1)))
    assert health.of(sensor, 2.0 * garbage).reason == "absurd"
    for i in range(garbage + 1, garbage + 4):
        health.telemetry(report(i))
    assert health.of(sensor, 2.0 * (garbage + 3)).valid


def test_a_report_that_is_absurd_now_and_then_doubts_no_other() -> None:
    health = after(report(0))
    for i in range(1, 40):
        health.telemetry(report(i, **({"depth": -50.0} if i % 4 == 0 else {})))
        assert health.of("depth", 2.0 * i).valid is (i % 4 != 0)


def test_an_altimeter_without_an_echo_every_other_time_is_believed_in_between() -> None:
    health = after(report(0))
    for i in range(1, 40):
        health.telemetry(report(i, **({"altitude": 0.0} if i % 2 else {})))
        assert health.of("altitude", 2.0 * i).valid is (i % 2 == 0)


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        *(("heading", f"{field}:out_of_range") for field in ("yaw_deg", "ez_deg", "heading_deg")),
        *(("attitude", f"{field}:nan") for field in ("ex_deg", "ey_deg", "roll_deg", "pitch_deg")),
        ("depth", "depth_m:nan"),
    ],
)
def test_each_document_s_own_name_of_a_field_doubts_its_channel(name: str, fault: str) -> None:
    health = after(report(0), report(1, faults=(fault,)))
    assert [s for s in SENSORS if health.of(s, 2.0).reason == "absurd"] == [name]


def test_an_unknown_code_of_a_leak_doubts_no_leak() -> None:
    """It counts as one (R16), so guards may go by it."""
    health = after(*(report(i, leak=True, faults=("leak:bad_enum",)) for i in range(3)))
    assert health.of("leak", 4.0).valid
