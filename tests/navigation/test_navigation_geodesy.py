"""The local plane against the geodesic, and back."""

from __future__ import annotations

import builtins
import errno
import math
import sys
import threading

import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.model import Position
from mission.navigation import LocalFrame
from mission.navigation.declination import EPOCHS, declination, of_model, table

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


def test_a_table_is_read_once_and_those_of_all_epochs_are_all_that_any_year_needs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A first fix waits for no card."""
    table.cache_clear()
    of_model.cache_clear()
    tables = [table(epoch) for epoch in EPOCHS]

    def hangs(path: object, *_: object, **__: object) -> None:
        raise AssertionError(f"{path} is read")

    monkeypatch.setattr(builtins, "open", hangs)
    assert [table(epoch) for epoch in EPOCHS] == tables
    for date in (None, *(f"{year}-05-01" for year in range(2005, 2036))):
        assert declination(0.5, 2.1, date) != 0.0


def test_a_table_that_cannot_be_read_is_no_declination_and_no_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def unreadable(self: object, **_: object) -> None:
        raise OSError(errno.EIO, "Input/output error")

    table.cache_clear()
    of_model.cache_clear()
    try:
        with monkeypatch.context() as patch:
            patch.setattr("pygeomag.GeoMag.calculate", unreadable)
            assert declination(0.5, 2.1, "2026-05-01") == 0.0
        assert declination(0.5, 2.1, "2026-05-01") != 0.0, "it can be read again"
    finally:
        table.cache_clear()
        of_model.cache_clear()


def test_two_threads_that_ask_for_declinations_disturb_each_other_in_nothing() -> None:
    places = [(0.01 * i, 0.02 * i) for i in range(-100, 100)]
    alone = [declination(*place, "2026-05-01") for place in places]
    of_model.cache_clear()
    often, found = sys.getswitchinterval(), list[list[float]]()
    work = [
        threading.Thread(
            target=lambda: found.append([declination(*p, "2026-05-01") for p in places])
        )
        for _ in range(4)
    ]
    try:
        sys.setswitchinterval(1e-6)
        for one in work:
            one.start()
        for one in work:
            one.join()
    finally:
        sys.setswitchinterval(often)
    assert found == [alone] * 4
