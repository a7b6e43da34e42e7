"""The robot's side moves (document 004, 03 to 08), as an output by name in a leg that drives nowhere."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from mission.authoring.prepare import prepare
from mission.verification.simulation.flight import fly

TEXT = """mission aside vehicle robot
safety time 20min
assume start 0
start without fix
aside: stop output side {side} output side_speed 400 for 5s
"""
BEARINGS = {7: 90.0, 8: 270.0, 3: 45.0, 4: 315.0, 5: 135.0, 6: 225.0}  # deg from its bow


@pytest.mark.parametrize(("side", "bearing"), BEARINGS.items())
def test_each_side_move_goes_where_its_name_says_and_ends_with_the_mission(
    tmp_path: Path, side: int, bearing: float
) -> None:
    path = tmp_path / "m.mission"
    path.write_text(TEXT.format(side=side), encoding="utf-8")
    ready = prepare(path)
    flight = fly(ready.mission, ready.vehicle, seed=1)
    assert flight.outcome == "completed", flight.reason
    end = flight.track[-1]
    assert math.hypot(end.north, end.east) == pytest.approx(2.0, abs=0.15)  # 5 s at 0.4 m/s
    assert math.degrees(math.atan2(end.east, end.north)) % 360.0 == pytest.approx(bearing, abs=2.0)
