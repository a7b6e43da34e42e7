"""The local plane against the geodesic, and back."""

from __future__ import annotations

import math

import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.model import Position
from mission.navigation import LocalFrame
from mission.navigation.declination import declination

_PLACES = [(0.0, 0.0), (30.2874595, 120.1535765), (-45.0, 179.999), (69.5, -20.0), (84.0, 30.0)]


@pytest.mark.parametrize("place", _PLACES)
def test_two_kilometres_agree_with_the_geodesic_to_a_centimetre(place: tuple[float, float]) -> None:
    frame = LocalFrame(Position(*place))
    for azimuth in range(0, 360, 15):
        there = Geodesic.WGS84.Direct(*place, azimuth, 2000.0)
        north, east = frame.to_local(math.radians(there["lat2"]), math.radians(there["lon2"]))
        a = math.radians(azimuth)
        assert math.hypot(north - 2000.0 * math.cos(a), east - 2000.0 * math.sin(a)) < 0.01


@settings(max_examples=60, deadline=None)
@given(
    st.floats(-80, 80), st.floats(-180, 180), st.floats(-20_000, 20_000), st.floats(-20_000, 20_000)
)
def test_there_and_back_is_where_one_was(lat: float, lon: float, north: float, east: float) -> None:
    frame = LocalFrame(Position(lat, lon))
    n, e = frame.to_local(*frame.to_geodetic(north, east))
    assert math.hypot(n - north, e - east) < 1e-6


def test_declination_is_what_the_world_magnetic_model_publishes() -> None:
    """WMM2025 test values (NOAA report, table of test values): 2025.0, 80 N 0 E: 1.28 deg."""
    found = math.degrees(declination(math.radians(80.0), 0.0, "2025-01-01"))
    assert found == pytest.approx(1.28, abs=0.02)


def test_west_of_newfoundland_the_compass_points_eighteen_degrees_west() -> None:
    found = math.degrees(declination(math.radians(49.57), math.radians(-57.95), "2023-09-20"))
    assert -19.0 < found < -17.0
