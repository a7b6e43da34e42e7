"""The true track of a vehicle that is a process of its own, laid beside what it believed."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mission.authoring.prepare import prepare
from mission.verification.simulation import plot
from mission.verification.simulation.flight import fly
from mission.verification.simulation.legtable import table
from mission.verification.simulation.truth import Truth, read_truth

HEAD = "t,latitude_deg,longitude_deg,depth_m\n"
METRE = math.degrees(1.0 / 6_371_000.0)  # of latitude, to a hundredth


def track(folder: Path) -> Truth:
    """A metre north and one down in each of two seconds."""
    path = folder / "truth.csv"
    rows = (f"{t}.0,{30.0 + t * METRE:.9f},120.0,{t}.0\n" for t in range(3))
    path.write_text(HEAD + "".join(rows), encoding="ascii")
    truth = read_truth(path)
    assert truth is not None
    return truth


def test_between_two_rows_the_vehicle_went_straight_on(tmp_path: Path) -> None:
    truth = track(tmp_path)
    for t in (0.0, 0.25, 1.5, 2.0):
        place = truth.place(t, truth.begin)
        assert (place.north, place.east) == pytest.approx((t, 0.0), abs=0.02)
        assert place.depth == pytest.approx(t)
    assert truth.place(9.0, truth.begin).depth == 2.0, "behind its end as there"


def test_the_truth_is_counted_from_the_home_that_the_vehicle_took(tmp_path: Path) -> None:
    truth = track(tmp_path)
    off = math.radians(30.0 + 5.0 * METRE), math.radians(120.0)
    assert truth.place(0.0, off).north == pytest.approx(-5.0, abs=0.05)
    assert [place.t for place in truth.track(off, 1.0)] == [-1.0, 0.0, 1.0]


def test_a_track_without_a_row_is_none(tmp_path: Path) -> None:
    (tmp_path / "truth.csv").write_text(HEAD, encoding="ascii")
    assert read_truth(tmp_path / "truth.csv") is None


def test_what_drives_on_the_ground_has_no_depth_in_its_picture_and_its_legs_lie_on_its_way() -> (
    None
):
    ready = prepare("robot-drive")
    flight = fly(ready.mission, ready.vehicle, seed=1)
    figure = Figure(figsize=(9.0, 10.0))
    FigureCanvasAgg(figure)
    plot.drawn(figure, flight, "drive")
    plan, profile = figure.axes
    assert "deep" not in plot.title_of(flight, "drive")
    assert (profile.get_ylabel(), list(profile.get_yticks())) == ("", [])
    east, north = (np.asarray(one, float) for one in plan.lines[0].get_data())
    assert np.hypot(np.ptp(east), np.ptp(north)) > 3.0, "though it does not know its way"
    assert re.search(r"(?m)^range +\d", table(flight, ready.chart))
    assert "depth, range" not in table(flight, ready.chart)
