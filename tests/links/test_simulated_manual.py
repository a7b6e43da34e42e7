"""Manual mode and rudders of both profiles: effects, dead man, silence."""

from __future__ import annotations

from math import degrees

import pytest
from stm32_line import Pi

from links.simulated.firmware.stm32 import Mode
from links.simulated.link import PROFILES
from links.simulated.plant import NEUTRAL

# --- manual mode ------------------------------------------------------------------------------


def test_as_built_manual_mode_ends_after_600_ms_with_everything_off() -> None:
    pi = Pi("as-built")
    pi.say(b"@MMF6$", 0.59)
    assert pi.pwm[0] == 1750
    pi.wait(0.15)
    assert pi.pwm == NEUTRAL
    assert pi.vehicle.stm32.mode is Mode.DEFAULT


def test_documented_manual_mode_has_no_dead_man() -> None:
    pi = Pi("documented")
    pi.say(b"@MMF6$")
    pi.wait(30)
    assert pi.pwm[0] == 1750


@pytest.mark.parametrize(("profile", "reports"), [("as-built", 0), ("documented", 5)])
def test_telemetry_is_silent_in_manual_mode_as_built(profile: str, reports: int) -> None:
    pi = Pi(profile)
    pi.heard.clear()
    for _ in range(50):
        pi.say(b"@MMF3$", 0.2)
    assert len([frame for frame in pi.heard if frame.startswith(b"@SD")]) == reports
    pi.say(b"@ZAX0$")
    pi.wait(4.2)
    assert pi.heard[-1].startswith(b"@SD")


@pytest.mark.parametrize("profile", PROFILES)
def test_every_change_of_mode_stops_the_thrusters_first(profile: str) -> None:
    pi = Pi(profile)
    pi.say(b"@ZAS10$")
    pi.say(b"@ZAF8$")
    pi.say(b"@MMU0$")
    assert pi.pwm == NEUTRAL
    pi.say(b"@MMF8$")
    pi.say(b"@ZAS0$")
    assert pi.pwm[:2] == (1500, 1500)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize(
    ("command", "slots", "sign"),
    [
        (b"@MT1,-10$", (0,), -1), (b"@MT3,5$", (3,), 1), (b"@MT5,5$", (2,), 1),
        (b"@MMB5$", (0, 1), -1), (b"@MMU5$", (2, 3, 4), 1), (b"@MMD5$", (2, 3, 4), -1),
    ],
)  # fmt: skip
def test_manual_commands_reach_their_thrusters(
    profile: str, command: bytes, slots: tuple[int, ...], sign: int
) -> None:
    pi = Pi(profile)
    assert pi.say(command) == []
    for slot in range(5):
        offset = pi.pwm[slot] - 1500
        assert (offset * sign > 100) if slot in slots else (offset == 0)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize(
    ("way", "attribute", "sign"),
    [
        ("L", "r", -1),
        ("R", "r", 1),
        ("B", "pitch", -1),
        ("F", "pitch", 1),
        ("U", "roll", -1),
        ("D", "roll", 1),
    ],
)
def test_rotations_are_named_by_their_effect(
    profile: str, way: str, attribute: str, sign: int
) -> None:
    pi = Pi(profile, depth=20.0)
    for _ in range(8):
        pi.say(f"@MR{way}4$".encode(), 0.3)
    assert sign * getattr(pi.vehicle.plant, attribute) > 0.02


@pytest.mark.parametrize("profile", PROFILES)
def test_the_stick_steers_by_its_own_frame(profile: str) -> None:
    """Angle 0 is east, 90 is north, counter-clockwise (E-V12)."""
    pi = Pi(profile)
    for _ in range(100):
        pi.say(b"@MS60,0$", 0.3)
    assert degrees(pi.truth.heading) == pytest.approx(90.0, abs=3.0)
    assert pi.truth.speed > 0.5
    for _ in range(100):
        pi.say(b"@MS60,180$", 0.3)
    assert degrees(pi.truth.heading) == pytest.approx(270.0, abs=3.0)


@pytest.mark.parametrize("profile", PROFILES)
def test_rudders_move_without_entering_manual_mode_and_stop_at_their_ends(profile: str) -> None:
    pi = Pi(profile)
    pi.say(b"@DS1,20$")
    pi.say(b"@DA1,9$")
    pi.say(b"@DS2,-10$")
    assert pi.pwm[5:] == (1720, 1400)
    assert pi.vehicle.stm32.mode is Mode.DEFAULT
    pi.say(b"@DS3,0$")
    assert pi.pwm[5:] == ((1720, 1400) if profile == "as-built" else (1500, 1500))
