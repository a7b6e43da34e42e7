"""The demonstration flown: every mission that is shipped for a vehicle, or that the check lets it fly,
through the real serve and the simulated vehicle of its own, and home. In mid-mission somebody takes
the stick and gives it back."""

from __future__ import annotations

import re
import socket
import time
from pathlib import Path

import pytest
from programs import run

from mission.authoring.prepare import Prepared, Unreadable, check_prepared, prepare
from mission.model import MANUAL_DRIVING, MANUAL_WAITING
from mission.model.shipped import shipped_missions, shipped_vehicles, vehicle_file
from mission.onboard.blackbox import read_parts
from mission.onboard.blackbox.parts import first_part
from mission.onboard.runtime.records import STEP, step_of
from mission.topside.console import converse
from mission.topside.upload import start
from mission.verification.simulation.demo import LEFT, PLANNED, Demo, Progress

SPEED = 6.0
SLOWER = {"mainboard": 3.0}  # what the Pi itself holds needs reports of the last half second (R17)
AFTER = 15.0  # s of mission until somebody takes the stick
HELD = 4.0  # s
PAGE = Path(__file__).parents[2] / "docs" / "vehicles.md"


def flies() -> dict[str, set[str]]:
    """Of each vehicle, as the table of the page says."""
    table = re.search(r"(?m)^\| mission \|(.*)\n\|[-|]*\n((?:\|.*\n)+)", PAGE.read_text("utf-8"))
    assert table is not None
    vehicles = [cell.strip(" `") for cell in table[1].split("|")[:-1]]
    found: dict[str, set[str]] = {vehicle: set() for vehicle in vehicles}
    for row in table[2].splitlines():
        mission, *cells = (cell.strip(" `") for cell in row.split("|")[1:-1])
        for vehicle, cell in zip(vehicles, cells, strict=True):
            found[vehicle] |= {mission} if cell.startswith("yes") else set()
    return found


FLIES = flies()
CUT_SHORT = {("auv", "coreboard-dive")}  # its battery, which never changes, is below the mission's
PAIRS = [(vehicle, mission) for vehicle, flown in FLIES.items() for mission in sorted(flown)]


def named(vehicle: str, folder: Path) -> str:
    """The shipped file; the main board's as somebody leaves it who has seen its signs."""
    if vehicle != "mainboard":
        return vehicle
    text = vehicle_file(vehicle).read_text(encoding="utf-8")
    path = folder / "mainboard.yaml"
    path.write_text(text.replace("outer_loop:", "outer_loop:\n  confirmed: 2026-11-22", 1))
    return str(path)


def fits(name: str, file: str) -> bool:
    try:
        prepared = prepare(name, file)
    except Unreadable:
        return False
    return check_prepared(prepared).ok


@pytest.mark.proof
@pytest.mark.parametrize("vehicle", FLIES)
def test_the_page_of_the_vehicles_names_what_each_of_them_flies(
    tmp_path: Path, vehicle: str
) -> None:
    file = named(vehicle, tmp_path)
    assert {name for name in shipped_missions() if fits(name, file)} == FLIES[vehicle]


def test_the_page_of_the_vehicles_has_every_vehicle_that_reports_and_every_mission() -> None:
    assert set(FLIES) == set(shipped_vehicles()) - {"motorboards"}
    assert set().union(*FLIES.values()) == set(shipped_missions())


class Person:
    """Watches a demonstration, takes its stick for a while, and has the mission go on."""

    def __init__(self, speed: float) -> None:
        self.topside = ""
        self._speed = speed
        self.did: list[str] = []
        self._since: float | None = None  # the mission is under way, by our clock

    def tell(self, words: str) -> None:
        if found := re.search(r"tcp://[^;\s]+", words):
            self.topside = found[0]

    def show(self, progress: Progress) -> None:
        place = f"{progress.state}/{progress.leg}"
        if not self.did and progress.state == "autonomous":
            now = time.monotonic()
            self._since = now if self._since is None else self._since
            if now - self._since > AFTER / self._speed:
                self._push()
        elif self.did == ["pushed"] and place == MANUAL_WAITING:
            converse(self.topside, start(patience=30))
            self.did.append("given back")

    def _push(self) -> None:
        host, port = self.topside.removeprefix("tcp://").split(":")
        with socket.create_connection((host, int(port))) as boat:
            end = time.monotonic() + HELD / self._speed
            while time.monotonic() < end:
                boat.sendall(b"@MMF6$")
                time.sleep(0.2 / self._speed)
        self.did.append("pushed")


def states(folder: Path) -> list[str]:
    """As they were entered, the first of all aside."""
    (box,) = {first_part(path) for path in (folder / "pi" / "log").glob("*.mcap")}
    steps = (step_of(r.payload) for r in read_parts(box) if r.kind == STEP)
    return [step.entered[-1] for step in steps if step.entered]


@pytest.mark.proof
@pytest.mark.minutes
@pytest.mark.parametrize(("vehicle", "mission"), PAIRS)
def test_what_a_vehicle_can_fly_comes_home_on_it_with_the_stick_taken_and_given_back(
    tmp_path: Path, vehicle: str, mission: str
) -> None:
    file = named(vehicle, tmp_path)
    speed = SLOWER.get(vehicle, SPEED)
    prepared, out, person = prepare(mission, file), tmp_path / "out", Person(speed)
    demo = Demo(prepared, out, speed, file, 0, (), worst(prepared), person.tell, person.show)
    flight = demo.fly()
    assert person.did == ["pushed", "given back"]
    assert (flight.outcome, flight.at_surface) == ("completed", True)
    seen = states(out)
    at = seen.index(MANUAL_DRIVING)
    assert MANUAL_WAITING in seen[at:]
    assert seen[at - 1].startswith("autonomous/")
    assert not [state for state in seen if state.startswith("emergency/")]
    assert {path.name for path in out.iterdir()} <= LEFT
    others = {leg.by for leg in flight.legs} - PLANNED - {"operator"}  # who took the stick
    assert others == ({"on"} if (vehicle, mission) in CUT_SHORT else set())


def worst(prepared: Prepared) -> float:
    proved = check_prepared(prepared).proved
    assert proved is not None
    return proved.worst_time


@pytest.mark.proof
@pytest.mark.minutes
@pytest.mark.parametrize("vehicle", ["auv", "coreboard", "mainboard", "rov", "robot"])
def test_the_command_flies_the_vehicles_own_mission_and_leaves_its_pictures(
    tmp_path: Path, vehicle: str
) -> None:
    out = tmp_path / "out"
    ran = run("demo", "--vehicle", vehicle, "--out", str(out))
    assert ran.exit_code == 0, ran.output
    assert (out / "track.png").stat().st_size > 1000
    assert (out / "graph.svg").read_text(encoding="utf-8").startswith("<svg")
    assert list((out / "pi" / "log").glob("*.mcap"))
