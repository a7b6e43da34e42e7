"""Every row of FAULTS changes what comes over the line, and leaves no trace when it is over."""

from __future__ import annotations

import functools
from dataclasses import replace
from math import isnan

import pytest

from links.simulated.faults import FAULTS
from links.simulated.link import PROFILES, SimulatedVehicle, Truth
from links.simulated.plant import NEUTRAL
from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors
from links.simulated.settings import (
    SETTINGS,
    FaultEvent,
    SettingError,
    Settings,
    parse_fault,
    parse_settings,
    setting_of,
)

BEGIN, END = 20.0, 40.0
OWN = [name for name, row in FAULTS.items() if not row.needs]
WORDS = {
    "as-built": [b"@ZAH-90,6$", b"@ZAS10$"],
    "documented": [b"@ZAF6$", b"@ZAH-90$", b"@ZAS10$"],
}


# A board that is deaf to a word is noticed by whoever says it.
HEARD_BY = {
    "deaf_to_w": b"@ZAWF$",
    "deaf_to_u": b"@ZAU9$",
    "deaf_to_x": b"@ZAX0$",
    "deaf_to_f": b"@ZAF6$",
}

# Counts are whole volts, and constants as built: nobody can see these.
UNSEEN = {("as-built", name) for name in FAULTS if name.startswith("battery")} | {
    ("documented", "battery_frozen"),
    ("documented", "battery_intermittent"),
}


def fly(
    profile: str, fault: str | None, until: float = 70.0, *, dive: bool = True, word: bytes = b""
) -> tuple[SimulatedVehicle, list[tuple[float, bytes]]]:
    """Commands before, during and after the fault; what was heard of both lines."""
    events = (FaultEvent(fault, BEGIN, END - BEGIN),) if fault else ()
    errors = replace(SensorErrors(), altitude_drop=0.0)
    settings = Settings(Sea(current=(0.2, 1.0)), errors, faults=events, splice=0.0)
    vehicle = SimulatedVehicle(profile, 5, settings)
    heard: list[tuple[float, bytes]] = []
    words = WORDS[profile] if dive else WORDS[profile][:-1]
    sends = [(t + 0.1 * i, w) for t in (5.0, 25.01, 50.0) for i, w in enumerate(words)]
    sends = sorted([*sends, (30.0, word)])
    for now, word in [*(send for send in sends if send[0] < until), (until, b"")]:
        for link in (vehicle.vehicle_link, vehicle.gps_link):
            heard += [(rx.t, rx.data) for rx in link.receive(now)]
        if word:
            vehicle.vehicle_link.send(word, now)
    return vehicle, heard


@functools.cache
def heard_without(profile: str, dive: bool, word: bytes) -> list[tuple[float, bytes]]:
    """The same without any fault."""
    return fly(profile, None, 45.0, dive=dive, word=word)[1]


def volts(heard: list[tuple[float, bytes]]) -> set[bytes]:
    return {data[77:81] for _, data in heard if data[:3] == b"@SD"}


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("fault", OWN)
def test_a_fault_is_seen_while_it_lasts_and_not_before(profile: str, fault: str) -> None:
    seen = False
    for dive in (True, False):
        word = HEARD_BY.get(fault, b"")
        heard = heard_without(profile, dive, word)
        sick, heard_sick = fly(profile, fault, 45.0, dive=dive, word=word)
        before = [piece for piece in heard if piece[0] < BEGIN]
        assert before == [piece for piece in heard_sick if piece[0] < BEGIN]
        seen |= volts(heard) != volts(heard_sick) if "battery" in fault else heard != heard_sick
        assert sick.edges == []
    assert seen == ((profile, fault) not in UNSEEN)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("fault", OWN)
def test_when_a_fault_is_over_the_vehicle_obeys_and_reports_again(profile: str, fault: str) -> None:
    vehicle, heard = fly(profile, fault, 110.0)
    reports = [data for t, data in heard if t > 45.0 and data[:3] == b"@SD" and len(data) == 86]
    assert len(reports) == 32
    assert vehicle.truth().depth == pytest.approx(10.0, abs=0.3)
    assert vehicle.truth().speed > 0.6
    assert vehicle.sensors.health == vehicle.sensors.bent == {}
    assert vehicle.plant.strength == [1.0] * 5
    assert vehicle.plant.buoyancy == vehicle.plant.body.buoyancy
    assert vehicle.truth().current == pytest.approx(fly(profile, None, 1.0)[0].truth().current)


def state(fault: str, at: float, profile: str = "as-built") -> tuple[SimulatedVehicle, Truth]:
    vehicle, _ = fly(profile, fault, at)
    return vehicle, vehicle.truth()


def test_a_hung_board_keeps_its_thrusters_on_and_says_nothing() -> None:
    vehicle, heard = fly("as-built", "stm32_hang", 39.0)
    assert vehicle.stm32.pwm != NEUTRAL
    assert not [t for t, data in heard if data[:1] == b"@" and t > 21.5]
    vehicle.advance(40.2)
    assert vehicle.stm32.pwm == NEUTRAL


def test_a_brown_out_leaves_everything_neutral_and_forgotten() -> None:
    vehicle, _ = fly("as-built", "stm32_restart", 49.0)
    assert vehicle.stm32.pwm == NEUTRAL


@pytest.mark.parametrize("profile", PROFILES)
def test_a_dive_that_a_restart_fell_into_ends_with_its_fault(profile: str) -> None:
    events = (FaultEvent("unexplained_dive", 10.0, 20.0), FaultEvent("stm32_hang", 15.0, 4.0))
    vehicle = SimulatedVehicle(profile, 1, Settings(Sea(floor=60.0), faults=events))
    vehicle.advance(30.0)
    assert vehicle.truth().depth > 2.0
    vehicle.advance(120.0)
    assert vehicle.truth().at_surface


def test_an_unexplained_dive_ignores_what_is_asked() -> None:
    vehicle, truth = state("unexplained_dive", 39.0)
    assert truth.depth > 6.5
    vehicle.vehicle_link.send(b"@ZAU12$", 39.0)
    vehicle.advance(39.9)
    assert vehicle.truth().depth_rate > 0.3
    vehicle.advance(45.0)
    assert vehicle.truth().depth_rate < -0.3


def test_a_heavy_vehicle_sinks_by_itself() -> None:
    settings = parse_settings(["fault=heavy=25@1+60"])
    vehicle = SimulatedVehicle("as-built", 1, settings)
    vehicle.advance(50.0)
    assert vehicle.truth().depth > 3.0


def test_two_faults_may_overlap() -> None:
    settings = parse_settings(["fault=heavy=5@1+30", "fault=heavy=5@10+30", "fault=gps_lost@5+2"])
    vehicle = SimulatedVehicle("as-built", 1, settings)
    vehicle.advance(12.0)
    assert vehicle.plant.buoyancy == 5.0
    vehicle.advance(60.0)
    assert vehicle.plant.buoyancy == 15.0


def taken(vehicle: SimulatedVehicle) -> list[object]:
    sensors, board = vehicle.sensors, vehicle.stm32
    battery = sensors.battery_override, sensors.battery_noise
    wrong = {slot: type(wrong).__name__ for slot, wrong in sensors.wrong.items()}
    now = tuple(round(speed, 6) for speed in vehicle.current)
    hold = [battery, dict(sensors.health), dict(sensors.bent), wrong, now]
    return [*hold, {*board.ignores}, [*board.dives], board.refuses, [*vehicle.plant.strength]]


def held(*faults: str, at: float) -> list[object]:
    vehicle = SimulatedVehicle("documented", 1, parse_settings([f"fault={f}" for f in faults]))
    vehicle.advance(at)
    return taken(vehicle)


@pytest.mark.parametrize(
    ("one", "other", "both"),
    [
        ("depth_too_deep", "depth_too_shallow", None),
        ("depth_silent", "depth_frozen", None),
        ("depth_stuck", "depth_drifting", None),
        ("battery_low", "battery_flickers", None),
        ("battery_flickers", "battery_low", None),
        ("current_speed", "current_turn", None),
        ("deaf_to_u", "deaf_to_w", (5, {"U", "W"})),
        ("dives_until_up", "dives_until_stop", (6, ["U", "X"])),
        ("verticals_weak", "verticals_dead", None),
        ("mains_dead", "left_main_weak", (8, [0.0, 0.0, 1.0, 1.0, 1.0])),
    ],
)
def test_of_two_that_take_hold_of_the_same_each_end_takes_its_own(one, other, both):
    """The newest counts; deaf to two letters is deaf to both, and the weaker thruster is as weak."""
    first, second = f"{one}@10+20", f"{other}@20+20"
    expected = held(f"{other}@20+20", at=25.0)
    if both is not None:
        expected[both[0]] = both[1]
    assert held(first, second, at=25.0) == expected
    assert held(first, second, at=35.0) == held(f"{other}@20+20", at=35.0)
    assert held(f"{one}@10+50", second, at=45.0) == held(f"{one}@10+50", at=45.0)
    assert held(first, second, at=45.0) == held(at=45.0)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_silent_sensor_is_not_a_number_where_documented(profile: str) -> None:
    vehicle, _ = fly(profile, "depth_silent", 30.0)
    assert isnan(vehicle.sensors.last[4]) == (profile == "documented")


# --- settings ---------------------------------------------------------------------------------

EXAMPLES = {
    "current": "0.3@45", "deep_current": "0.1@200", "floor": "25", "declination": "-6.1",
    "compass_bias": "4", "compass_noise": "1.5", "compass_slow": "2", "deviation": "3",
    "depth_bias": "-0.2", "depth_noise": "0.1", "altitude_range": "30", "altitude_drop": "0.5",
    "thermocline": "4@12", "warm_layer": "2@8", "speed_log": "0.05", "doppler": "0.03",
    "acoustic": "3", "doppler_pd0": "0.03", "ranges": "2", "beacon": "3@30.288,120.154,4", "second_gps": "2.5",
    "added_lie": "frozen@20", "fix_noise": "5", "fix_wander": "2", "fix_settle": "15", "first_fix": "30",
    "buoyancy": "5", "splice": "1", "thrust": "0.8", "answers_late": "0.2", "uneven": "0.4", "waves": "0.4@6",
    "fault": "stm32_hang@12.5+8",
}  # fmt: skip


@pytest.mark.parametrize("key", SETTINGS)
def test_every_setting_sets_something_and_refuses_garbage(key: str) -> None:
    assert parse_settings([f"{key}={EXAMPLES[key]}"]) != Settings()
    for text in ("", "x", "nan", "1e999"):
        with pytest.raises(SettingError, match=key):
            parse_settings([f"{key}={text}"])


def test_settings_add_up_in_radians() -> None:
    settings = parse_settings(
        ["current=0.3@90", "compass_bias=-4", "floor=25", "fault=heavy=7@1+2", "fault=splice@9"]
    )
    assert settings.sea.current == pytest.approx((0.3, 1.5707963))
    assert settings.sea.floor == 25.0
    assert settings.errors.compass_bias == pytest.approx(-0.0698132)
    assert settings.faults == (FaultEvent("heavy", 1.0, 2.0, 7.0), FaultEvent("splice", 9.0))


@pytest.mark.parametrize("text", ["curent=0.3@45", "floor", "=3"])
def test_an_unknown_key_is_answered_with_the_known_ones(text: str) -> None:
    with pytest.raises(SettingError, match=r"(?s)cannot set.*current=SPEED@DIRECTION.*fault="):
        parse_settings([text])


def test_an_unknown_fault_is_answered_with_the_known_ones() -> None:
    with pytest.raises(
        SettingError, match=r"fault=hang@1\+2: no fault 'hang'; known: .*stm32_hang"
    ):
        parse_settings(["fault=hang@1+2"])


@pytest.mark.parametrize("text", ["heavy=7.0@1.0+2.0", "stm32_hang@12.5", "splice@9.0+1.0"])
def test_a_fault_event_can_be_written_down_again(text: str) -> None:
    assert setting_of(parse_fault(text)) == text
