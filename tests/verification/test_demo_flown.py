"""The demonstration flown: every mission that is shipped for a vehicle, or that the check lets it fly,
through the real serve and the simulated vehicle of its own, and home."""

from __future__ import annotations

from pathlib import Path

import pytest
from programs import run

from mission.authoring.prepare import Unreadable, check_prepared, prepare
from mission.model.shipped import shipped_missions

pytestmark = [pytest.mark.proof, pytest.mark.minutes]
OTHERS = ("coreboard", "rov", "robot")
FLIES = {
    "coreboard": {"coreboard-dive", "first-dive", "lawnmower", "loiter", "thermocline-field"},
    "rov": {"rov-dive"},
    "robot": {"robot-drive"},
}


def fits(name: str, vehicle: str) -> bool:
    try:
        prepared = prepare(name, vehicle)
    except Unreadable:
        return False
    own = prepared.mission.vehicle
    return own in (vehicle, "auv") and check_prepared(prepared).ok


@pytest.mark.parametrize("vehicle", OTHERS)
def test_the_page_of_the_vehicles_names_what_each_of_them_flies(vehicle: str) -> None:
    assert {name for name in shipped_missions() if fits(name, vehicle)} == FLIES[vehicle]
    page = (Path(__file__).parents[2] / "docs" / "vehicles.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in page for name in FLIES[vehicle])


@pytest.mark.parametrize(
    ("vehicle", "mission"),
    [("auv", "first-dive"), *((v, m) for v in OTHERS for m in sorted(FLIES[v]))],
)
def test_what_a_vehicle_can_fly_comes_home_on_it_through_the_real_programs(
    tmp_path: Path, vehicle: str, mission: str
) -> None:
    out = tmp_path / "out"
    ran = run("demo", mission, "--vehicle", vehicle, "--out", str(out))
    assert ran.exit_code == 0, ran.output
    assert (out / "track.png").stat().st_size > 1000
    assert (out / "graph.svg").read_text(encoding="utf-8").startswith("<svg")
    assert list((out / "pi" / "log").glob("*.mcap"))
