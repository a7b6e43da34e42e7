"""In waves, a receiver's velocity is that of the water to and fro, and no current."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from mission.navigation.filter import Motion
from mission.navigation.seaway import ORDINARY, Seaway

RECEIVER = 0.1  # m/s


def _run(speed: float, heading: float) -> Motion:
    return Motion(heading, speed, 1.0, 0.0, 0.0, 1.0, 0.0, True, 0.0, 0.0, False, 0.0)


STILL = _run(0.0, 0.0)


def _heard(velocities: Sequence[tuple[float, float]], run: Motion, apart: float = 1.0) -> Seaway:
    sea = Seaway()
    for second, velocity in enumerate(velocities):
        sea = sea.after(apart * second, velocity, run)
    return sea


def test_one_velocity_counts_as_in_an_ordinary_sea() -> None:
    noise = _heard([(0.5, -0.2)], STILL).noise(RECEIVER, 1.0)
    assert noise == pytest.approx(np.eye(2) * ORDINARY**2)


def test_many_that_agree_count_with_the_receivers_own_noise() -> None:
    noise = _heard([(0.3, 0.1)] * 30, STILL).noise(RECEIVER, 1.0)
    assert noise == pytest.approx(np.eye(2) * RECEIVER**2)


def test_waves_count_along_their_own_direction() -> None:
    """Crests towards 30 deg, 0.6 m/s at 6 s: a variance of 0.18 along, none across."""
    along = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    swing = [0.6 * math.cos(2.0 * math.pi * second / 6.0) for second in range(60)]
    noise = _heard([(v * along[0], v * along[1]) for v in swing], STILL).noise(0.01, 1.0)
    across = -along[1], along[0]
    assert along @ noise @ along == pytest.approx(0.18, rel=0.05)
    assert across @ noise @ across < 0.01


def test_however_often_a_receiver_speaks_a_second_tells_as_much() -> None:
    """A swell of 12 s, once and five times a second: the variance of what a second tells."""
    sea = {}
    for hertz in (1, 5):
        times = [n / hertz for n in range(60 * hertz)]
        swing = [(0.4 * math.cos(2.0 * math.pi * t / 12.0), 0.0) for t in times]
        heard = _heard(swing, STILL, 1.0 / hertz)
        one = heard.noise(0.01, heard.share(heard.t + 1.0 / hertz))
        sea[hertz] = one[0, 0] / hertz
    assert sea[5] == pytest.approx(sea[1], rel=0.05)


def test_the_way_through_the_water_is_no_wave() -> None:
    """On two courses at 1 m/s, in no current."""
    sea = _heard([(1.0, 0.0)] * 20, _run(1.0, 0.0))
    for second in range(20, 40):
        sea = sea.after(second, (0.0, 1.0), _run(1.0, math.pi / 2.0))
    assert sea.noise(RECEIVER, 1.0) == pytest.approx(np.eye(2) * RECEIVER**2)


def test_what_was_heard_minutes_ago_is_forgotten() -> None:
    wild = _heard([(1.0, 0.0), (-1.0, 0.0)], STILL)
    later = wild.after(600.0, (0.1, 0.0), STILL)
    assert later.noise(RECEIVER, 1.0) == pytest.approx(np.eye(2) * ORDINARY**2)
