"""Waves act on what sensors say, as linear theory has it, and on nothing else."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from links.simulated.link import SimulatedVehicle
from links.simulated.settings import parse_settings
from links.simulated.waves import GRAVITY, Waves

TIMES = [0.1 * i for i in range(6000)]


@pytest.mark.parametrize(("amplitude", "period"), [(0.3, 4.0), (0.75, 8.0), (1.0, 12.0)])
def test_the_head_swings_by_the_amplitude_near_the_surface_and_about_once_a_period(
    amplitude: float, period: float
) -> None:
    waves = Waves(amplitude, period, 1)
    heads = [waves.at(t, 0.5).head for t in TIMES]
    most = amplitude * math.exp(-0.5 * (2.0 * math.pi / period) ** 2 / GRAVITY)
    assert most <= max(heads) <= 1.07 * most  # both together; the longer one fades less
    assert -1.07 * most <= min(heads) <= -most
    floats = [waves.at(t, 0.0).head for t in TIMES]
    assert max(floats) == pytest.approx(amplitude / 2.0, rel=0.02)  # it goes along
    rises = sum(a < 0.0 <= b for a, b in pairwise(heads))
    assert 600.0 / (1.15 * period) - 1.0 <= rises <= 600.0 / period + 1.0


def test_they_fade_with_depth_short_ones_first() -> None:
    """By e^-kz, k = w^2 / g: half a wave's length down 4 % are left."""
    long = 2.0 * math.pi * GRAVITY / (2.0 * math.pi / 8.0) ** 2  # m, that of 8 s
    at_top, below = Waves(1.0, 8.0, 1), Waves(1.0, 8.0, 1)
    top = 2.0 * max(at_top.at(t, 0.0).head for t in TIMES)
    deep = max(below.at(t, long / 2.0).head for t in TIMES)
    assert math.exp(-math.pi) * 1.0 < deep / top < 2.0 * math.exp(-math.pi)  # one is longer
    short = max(Waves(1.0, 4.0, 1).at(t, long / 2.0).head for t in TIMES)
    assert short < 0.001


def test_they_lean_the_vehicle_by_their_slope_and_turn_the_compass_with_its_roll() -> None:
    waves, still = parse_settings(["waves=0.75@5"]), parse_settings([])
    there, flat = SimulatedVehicle(seed=3, settings=waves), SimulatedVehicle(seed=3, settings=still)
    slope = 0.75 * (2.0 * math.pi / 5.0) ** 2 / GRAVITY
    leans = []
    for t in range(2, 200, 2):
        there.advance(t), flat.advance(t)
        assert there.plant.depth == flat.plant.depth  # the body feels none
        felt = there.sensors.waves.at(there.now - 1.0, there.plant.depth)
        told, calm = there.sensors.last, flat.sensors.last
        assert told[0] - calm[0] == pytest.approx(felt.roll)
        assert told[1] - calm[1] == pytest.approx(felt.pitch)
        assert told[4] - calm[4] == pytest.approx(felt.head)
        turned = math.remainder(told[2] - calm[2], 2.0 * math.pi)
        assert turned == pytest.approx(felt.roll * 35.0 / 33.0)
        leans.append(math.hypot(felt.roll, felt.pitch))
    assert 0.5 * slope < max(leans) <= slope
