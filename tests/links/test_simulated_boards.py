"""What each profile of the STM32 does in automatic mode, told by real bytes on the line."""

from __future__ import annotations

from math import degrees, radians

import pytest
from stm32_line import Pi

from links.simulated.link import PROFILES
from links.simulated.plant import NEUTRAL

# --- answers ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "word", ["F5", "B5", "L5", "R5", "U5", "D5", "S30", "E3", "H-90", "X0", "WF"]
)
def test_every_z_is_answered(word: str) -> None:
    assert Pi("as-built").say(f"@ZA{word}$".encode()) == [b"@ACK_ZAY$"]
    assert Pi("documented").say(f"@ZA{word}$".encode()) == [f"@ACK_Z{word[0]}Y$".encode()]


@pytest.mark.parametrize(
    ("profile", "answer"), [("as-built", b"@ACK_ZAN$"), ("documented", b"@ACK_ZVN$")]
)
def test_speed_is_always_refused(profile: str, answer: bytes) -> None:
    assert Pi(profile).say(b"@ZAV1$") == [answer]


@pytest.mark.parametrize(
    "word", ["F13", "H181", "S-1", "Fx", "X1", "W0", "Q1", "A5,3", "F5.0", "H-20,4"]
)
def test_documented_refuses_what_is_out_of_range_and_changes_nothing(word: str) -> None:
    pi = Pi("documented")
    pi.say(b"@ZAF4$")
    before = pi.pwm
    assert pi.say(f"@ZA{word}$".encode()) == [f"@ACK_Z{word[0]}N$".encode()]
    assert pi.pwm == before


def test_as_built_checks_only_the_upper_bound_of_a_gear() -> None:
    pi = Pi("as-built")
    assert pi.say(b"@ZAF13$") == [b"@ACK_ZAN$"]
    assert pi.say(b"@ZAF-6$") == [b"@ACK_ZAY$"]
    pi.wait(20)
    assert pi.truth.speed == pytest.approx(-0.72, abs=0.05)


def test_an_answer_takes_the_time_of_the_wire() -> None:
    pi = Pi("as-built")
    sent = pi.now
    pi.vehicle.vehicle_link.send(b"@ZAF5$", sent)
    first = None
    while first is None:
        event = pi.vehicle.vehicle_link.next_event()
        assert event is not None
        received = pi.vehicle.vehicle_link.receive(event)
        first = received[0] if received else None
    assert first.data == b"@ACK_ZAY$"
    byte = 10 / 9600
    assert first.t == pytest.approx(sent + 6 * byte + 0.007)
    assert event == pytest.approx(first.t + 9 * byte)


# --- bursts -----------------------------------------------------------------------------------


def test_as_built_two_commands_in_one_burst_are_misread() -> None:
    pi = Pi("as-built")
    assert pi.say(b"@ZAF6$@ZAS10$") == [b"@ACK_ZAY$"]
    pi.wait(20)
    assert pi.truth.depth < 0.5
    assert pi.truth.speed > 0.5


def test_as_built_a_gap_below_five_milliseconds_joins_two_bursts() -> None:
    for gap, answers in ((0.004, 1), (0.020, 2)):
        pi = Pi("as-built")
        wire = 6 * 10 / 9600
        pi.say(b"@ZAF6$", wire + gap)
        pi.say(b"@ZAS10$")
        assert sum(frame == b"@ACK_ZAY$" for frame in pi.heard) == answers


@pytest.mark.parametrize(
    "burst", [b"@ZAF6$\r\n", b" @ZAF6$", b"@ZAF6", b"@ZAF" + b"0" * 94 + b"6$"], ids=repr
)
def test_as_built_loses_a_burst_that_is_no_whole_frame(burst: bytes) -> None:
    pi = Pi("as-built")
    assert pi.say(burst, 0.3) == []
    assert pi.pwm == NEUTRAL


def test_as_built_takes_a_burst_of_99_bytes() -> None:
    assert Pi("as-built").say(b"@ZAF" + b"0" * 93 + b"6$", 0.3) == [b"@ACK_ZAY$"]


def test_documented_frames_are_found_however_they_are_cut() -> None:
    pi = Pi("documented")
    assert pi.say(b"\r\n@ZAF6$\r\n@ZAS10$") == [b"@ACK_ZFY$", b"@ACK_ZSY$"]
    assert pi.say(b"@ZAH") == []
    assert pi.say(b"-90$") == [b"@ACK_ZHY$"]
    assert pi.say(b"@ZA@ZAX0$") == [b"@ACK_ZXY$"]


def test_as_built_an_answer_can_land_inside_the_telemetry() -> None:
    pi = Pi("as-built", splice=1.0)
    pi.wait(3.01 - pi.now)  # an @SD has just begun
    pi.say(b"@ZAF5$", 0.3)
    (frame,) = [frame for frame in pi.heard if b"@ACK" in frame]
    at = frame.index(b"@ACK_ZAY$")
    assert 0 < at < 86
    assert len(frame) == 95
    assert frame.startswith(b"@SD")


def test_without_splices_the_answer_waits_for_the_telemetry() -> None:
    pi = Pi("documented")
    pi.wait(3.01 - pi.now)
    pi.say(b"@ZAF5$", 0.3)
    assert pi.heard[-2][:3] == b"@SD"
    assert len(pi.heard[-2]) == 86
    assert pi.heard[-1] == b"@ACK_ZFY$"


# --- axes -------------------------------------------------------------------------------------


def test_as_built_one_speed_for_both_and_one_mode_each() -> None:
    pi = Pi("as-built", depth=30.0)
    pi.say(b"@ZAF6$")
    pi.say(b"@ZAU10$")
    assert pi.pwm[0] == pi.pwm[1] == pi.pwm[2] == 1917
    pi.say(b"@ZAB3$")
    assert pi.pwm[0] < 1500 < pi.pwm[2]
    assert 1500 - pi.pwm[0] == pi.pwm[2] - 1500


def test_as_built_heading_without_a_speed_stops_the_way() -> None:
    pi = Pi("as-built")
    pi.say(b"@ZAF6$")
    pi.wait(10)
    pi.say(b"@ZAH-90$")
    pi.wait(40)
    assert pi.truth.speed == pytest.approx(0.0, abs=0.03)
    assert degrees(pi.truth.heading) == pytest.approx(90.0, abs=3.0)


def test_as_built_heading_then_forward_loses_the_heading() -> None:
    pi = Pi("as-built")
    pi.say(b"@ZAH-90$")
    pi.say(b"@ZAF6$")
    pi.wait(30)
    assert degrees(pi.truth.heading) < 20.0


@pytest.mark.parametrize(
    ("profile", "words"), [("as-built", [b"@ZAH-90,6$"]), ("documented", [b"@ZAF6$", b"@ZAH-90$"])]
)
def test_each_profile_holds_a_heading_under_way_with_its_own_words(
    profile: str, words: list[bytes]
) -> None:
    pi = Pi(profile)
    for word in words:
        pi.say(word)
    pi.wait(30)
    assert degrees(pi.truth.heading) == pytest.approx(90.0, abs=2.0)
    assert pi.truth.speed == pytest.approx(0.72, abs=0.06)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_depth_is_reached_at_the_planned_rate_and_held(profile: str) -> None:
    pi = Pi(profile)
    pi.say(b"@ZAS10$")
    pi.wait(15)
    before = pi.truth.depth
    pi.wait(10)
    assert (pi.truth.depth - before) / 10 == pytest.approx(0.35, abs=0.02)
    pi.wait(60)
    assert pi.truth.depth == pytest.approx(10.0, abs=0.2)


@pytest.mark.parametrize("profile", PROFILES)
def test_an_altitude_is_reached_and_held(profile: str) -> None:
    pi = Pi(profile, depth=30.0)
    pi.wait(6)  # an echo
    pi.say(b"@ZAE5$")
    pi.wait(150)
    assert pi.truth.altitude == pytest.approx(5.0, abs=0.5)


def test_as_built_depth_hold_only_pushes_down() -> None:
    pi = Pi("as-built", depth=30.0)
    pi.say(b"@ZAS5$")
    for _ in range(40):
        pi.wait(1.0)
        assert pi.pwm[2] <= 1500
    assert pi.truth.depth_rate == pytest.approx(-0.25, abs=0.02)


def test_documented_depth_hold_drives_both_ways() -> None:
    pi = Pi("documented", depth=30.0)
    pi.say(b"@ZAS5$")
    pi.wait(5)
    assert pi.pwm[2] > 1800
    assert pi.truth.depth_rate < -0.4


def test_documented_words_are_independent_axes() -> None:
    pi = Pi("documented")
    for word in (b"@ZAH-90$", b"@ZAS10$", b"@ZAF8$", b"@ZAA0;0$"):
        pi.say(word)
    pi.wait(60)
    assert degrees(pi.truth.heading) == pytest.approx(90.0, abs=2.0)
    assert pi.truth.depth == pytest.approx(10.0, abs=0.2)
    assert pi.truth.speed == pytest.approx(0.98, abs=0.06)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("hold", ["S40", "E1"])
def test_up_ends_a_depth_or_altitude_hold(profile: str, hold: str) -> None:
    pi = Pi(profile, depth=30.0)
    pi.say(f"@ZA{hold}$".encode())
    pi.wait(10)
    pi.say(b"@ZAU12$")
    pi.wait(10)
    assert pi.truth.depth_rate < -0.4


def test_attitude_is_held_where_documented_and_does_nothing_as_built() -> None:
    pi = Pi("documented", depth=20.0)
    pi.say(b"@ZAS20$")
    assert pi.say(b"@ZAA8;0$") == [b"@ACK_ZAY$"]
    pi.wait(30)
    assert degrees(pi.truth.pitch) > 2.0
    pi = Pi("as-built", depth=20.0)
    pi.say(b"@ZAS20$")
    assert pi.say(b"@ZAA8,0$") == [b"@ACK_ZAY$"]
    assert pi.say(b"@ZAA8;0$") == [b"@ACK_ZAN$"]
    pi.wait(30)
    assert abs(degrees(pi.truth.pitch)) < 0.5


# --- stop and surface -------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
def test_x0_stops_everything_and_nothing_comes_back(profile: str) -> None:
    pi = Pi(profile)
    for word in (b"@ZAF8$", b"@ZAS10$"):
        pi.say(word)
    pi.wait(10)
    pi.say(b"@ZAX0$")
    pi.wait(5)
    assert pi.pwm == NEUTRAL
    pi.wait(60)
    assert pi.truth.depth < 0.3


def test_documented_surfacing_sticks() -> None:
    pi = Pi("documented", depth=30.0)
    pi.say(b"@ZAF8$")
    pi.say(b"@ZAS30$")
    pi.say(b"@ZAWF$")
    pi.wait(10)
    assert pi.truth.depth_rate == pytest.approx(-0.5, abs=0.05)
    assert pi.pwm[:2] == (1500, 1500)


def test_as_built_surfacing_does_not_stick() -> None:
    pi = Pi("as-built", depth=30.0)
    pi.say(b"@ZAS40$")
    pi.wait(5)
    assert pi.say(b"@ZAWF$") == [b"@ACK_ZAY$"]
    pi.wait(5)
    assert pi.truth.depth_rate > 0.3
    pi = Pi("as-built", depth=30.0)
    pi.say(b"@ZAWF$")
    pi.wait(10)
    assert pi.pwm[2] == 1500
    assert pi.truth.depth_rate == pytest.approx(-0.25, abs=0.03)


def test_as_built_u12_does_surface() -> None:
    pi = Pi("as-built", depth=30.0)
    pi.say(b"@ZAS40$")
    pi.say(b"@ZAU12$")
    pi.wait(10)
    assert pi.truth.depth_rate == pytest.approx(-0.5, abs=0.05)


def test_as_built_automatic_mode_has_no_dead_man() -> None:
    pi = Pi("as-built")
    pi.say(b"@ZAF6$")
    pi.wait(600)
    assert pi.truth.speed == pytest.approx(0.72, abs=0.05)


# --- telemetry, power -------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
def test_the_report_is_the_truth_in_the_units_of_the_wire(profile: str) -> None:
    pi = Pi(profile, depth=12.0)
    pi.vehicle.plant.yaw = radians(90.0)
    fields = pi.report()
    truth = pi.truth
    assert fields[2] == pytest.approx(-90.0, abs=0.1)  # east is -90
    assert fields[4] == pytest.approx(truth.depth, abs=0.1)
    assert fields[3] == pytest.approx(17.4, abs=0.2)
    assert 30.0 < (fields[6] ** 2 + fields[7] ** 2 + fields[8] ** 2) ** 0.5 < 60.0
    assert fields[15:22] == NEUTRAL


def test_batteries_are_constants_as_built_and_run_down_where_documented() -> None:
    drained: dict[str, list[tuple[float, ...]]] = {}
    for profile in PROFILES:
        pi = Pi(profile)
        pi.vehicle.sensors.used = 500 * 3600.0
        pi.vehicle.sensors.age = 10000
        pi.say(b"@ZAF10$")
        drained[profile] = [pi.report()[22:], pi.report()[22:]]
    assert drained["as-built"] == [(12, 48), (12, 48)]
    assert drained["documented"][0] == (11, 45)


@pytest.mark.parametrize("profile", PROFILES)
def test_power_switches_are_answered_and_seen(profile: str) -> None:
    pi = Pi(profile)
    assert pi.say(b"@RSOCCOOOC$") == [b"@ACK_RSS$"]
    assert pi.say(b"@RSOC$") == []
    pi.vehicle.gps_link.receive(pi.now + 1.0)
    pi.now += 5.0
    assert pi.vehicle.gps_link.receive(pi.now) == []
    pi.say(b"@RSOOOOOOC$")
    pi.now += 5.0
    assert pi.vehicle.gps_link.receive(pi.now) != []


def test_as_built_the_power_mask_can_be_the_tail_byte() -> None:
    pi = Pi("as-built")
    pi.say(b"@RSCCOCCOC$")
    assert pi.say(b"@RI$") == [b"@ACK_RI$$"]
    pi.say(b"@RSCCCCCCC$")
    assert pi.say(b"@RI$") == [b"@ACK_RI\x00$"]


def test_documented_the_power_mask_always_holds_ctd_and_radio() -> None:
    pi = Pi("documented")
    pi.say(b"@RSCCCCCCC$")
    assert pi.say(b"@RI$") == [b"@ACK_RI\x11$"]
    pi.say(b"@RSOOOOOOO$")
    assert pi.say(b"@RI$") == [b"@ACK_RI\x7f$"]
