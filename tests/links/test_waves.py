"""Waves act on what sensors say, as linear theory has it, and on nothing else."""

from __future__ import annotations

import math
from itertools import groupby, pairwise

import pytest

from links.simulated.boards import SimulatedBoard
from links.simulated.link import SimulatedVehicle
from links.simulated.settings import parse_settings
from links.simulated.waves import GRAVITY, Waves
from protocol.messages import Telemetry
from protocol.vehicles import codec

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
    there.gps.blind = flat.gps.blind = True  # it draws of the same numbers
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


def test_the_water_goes_to_and_fro_with_the_crests_by_the_amplitude_and_the_frequency() -> None:
    waves = Waves(0.6, 6.0, 4)
    felt = [waves.at(t, 0.0) for t in TIMES]
    most = max(math.hypot(f.north, f.east) for f in felt)
    assert 0.9 * 0.6 * 2.0 * math.pi / 6.0 < most < 0.6 * 2.0 * math.pi / 6.0  # one is longer
    crest = max(felt, key=lambda f: f.head)
    for f in felt:  # along one line, forward in crests, back in troughs
        assert f.north * crest.east == pytest.approx(f.east * crest.north, abs=1e-9)
        if abs(f.head) > 0.2:
            assert (f.north * crest.north + f.east * crest.east > 0.0) == (f.head > 0.0)
    assert sum(f.north for f in felt) / len(felt) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    ("height", "least", "most"), [(0.1, 0.99, 1.0), (0.3, 0.6, 0.95), (0.75, 0.2, 0.7)]
)
def test_waves_wash_over_the_antenna_and_the_receiver_soon_finds_its_satellites_again(
    height: float, least: float, most: float
) -> None:
    """Fixes come and go within seconds: behind a dive it takes longer."""
    there = SimulatedVehicle(seed=5, settings=parse_settings([f"waves={height}@6"]))
    there.advance(10.0)
    there.gps.take(there.now)
    fixed = []
    for t in range(11, 611):
        there.advance(t)
        said = b"".join(c.data for c in there.gps.take(t + 0.5))
        fixed.append(b",,,,,0,00," not in said)
    assert least <= sum(fixed) / len(fixed) <= most
    gaps = [len(list(run)) for has, run in groupby(fixed) if not has]
    assert max(gaps, default=0) <= 10


@pytest.mark.parametrize("name", ["coreboard", "rov", "mainboard"])
def test_boards_of_the_water_report_them_and_the_air_too(name: str) -> None:
    there = SimulatedBoard(name, 3, parse_settings(["waves=0.6@5", "depth_bias=0.3"]))
    differ = []
    for told, calm in zip(reports(there), reports(SimulatedBoard(name, 3)), strict=True):
        assert told.t == calm.t
        felt = there.board.waves.at(told.t, there.plant.depth)
        assert told.depth - calm.depth == pytest.approx(0.3 + felt.head, abs=0.02)
        turned = math.remainder(told.heading - calm.heading, 2.0 * math.pi)
        assert turned == pytest.approx(felt.roll * 35.0 / 33.0, abs=0.01)
        assert told.roll - calm.roll == pytest.approx(felt.roll, abs=0.01)
        differ.append(told.depth - calm.depth)
    assert max(differ) > 0.5 > 0.1 > min(differ)


def reports(vehicle: SimulatedBoard) -> list[Telemetry]:
    """Of a minute afloat, as the codec of the vehicle reads them."""
    wire = codec(vehicle.name, "documented", {})
    heard = [m for rx in vehicle.vehicle_link.receive(60.0) for m in wire.receive(rx.data, rx.t)]
    return [m for m in heard if isinstance(m, Telemetry) and m.depth is not None]
