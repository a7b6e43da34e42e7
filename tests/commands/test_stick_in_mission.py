"""All four vehicles under the real programs: the boat, serve, and the simulated vehicle on its ports.

In mid-mission somebody takes the stick, gives it back, and the mission goes on and comes home."""

from __future__ import annotations

import csv
import json
import math
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from programs import process, run
from served import PATIENCE, soon
from test_stick_command import UP, Person

from links.simulated.geodesy import local
from mission.model import MANUAL_DRIVING, MANUAL_WAITING
from mission.onboard.blackbox import read_parts
from mission.onboard.runtime.records import STEP, TX, read_tx, step_of
from protocol.vehicles import link

pytestmark = pytest.mark.proof
AFLOAT = 0.5  # m (R7)
STAYS = {  # missions in which the vehicle itself goes nowhere
    "auv": """mission stay vehicle auv
home 30.2874595 120.1535765
safety radius 300 time 20min depth 10 voltage 10
assume current 0
dive: depth 2 until depth >= 1.5 timeout 60
stay: depth 2 for 25s
up: surface timeout 3min
""",
    "coreboard": """mission stay vehicle coreboard
home 30.2874595 120.1535765
safety radius 300 time 20min depth 10 voltage 12
assume current 0
dive: depth 2 heading 0 gear 0 until depth >= 1.5 timeout 60
stay: depth 2 heading 0 gear 0 for 25s
up: surface timeout 3min
""",
    "rov": """mission stay vehicle rov
safety time 20min depth 20
assume current 0
start without fix
dive: down 9 until depth >= 1.5 timeout 60
stay: down 5 for 25s
up: surface timeout 3min
""",
    "robot": """mission stay vehicle robot
safety time 20min
assume start 0
start without fix
stay: stop for 25s
""",
}
AHEAD = {  # what the stick says on each wire: link, frame, and the value that drives ahead
    "coreboard": ("coreboard.pc_to_main", "tx"),
    "rov": ("rov.down", "x"),
    "robot": ("robot.down", "command"),
}


@dataclass(frozen=True)
class Sea:
    """Simulated vehicle and serve, both running; ``to``: where the boat connects."""

    process: subprocess.Popen[str]
    to: str
    box: Path
    track: Path

    def state(self) -> str:
        """Region and leg, as `status` tells them."""
        said = run("status", "--to", self.to, "--json").stdout
        told = json.loads(said) if said else {}
        return f"{told.get('state', '')}/{told.get('leg', '')}"

    def reaches(self, state: str) -> None:
        soon(lambda: self.state().startswith(state), state, 4 * PATIENCE)

    def far(self) -> float:
        """m from where it began, at most; and it has ended."""
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(PATIENCE) == 0
        with self.track.open(newline="", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        places = [tuple(math.radians(float(r[n])) for n in ("latitude_deg", "longitude_deg")) for r in rows]  # fmt: skip
        assert float(rows[-1]["depth_m"]) < AFLOAT
        return max(math.hypot(*local(places[0], *place)) for place in places)  # type: ignore[arg-type]


@contextmanager
def at_sea(folder: Path, name: str) -> Iterator[Sea]:
    ready, track = folder / "ready.json", folder / "track.csv"
    words = ("--folder", str(folder / "it"), "--port", "0", "--json", "--track", str(track))
    with process("vehicle", name, *words) as sea:
        assert sea.stdout is not None
        config = json.loads(sea.stdout.readline())["config"]
        with process("serve", "-c", config, "--ready-file", str(ready)):
            soon(ready.exists, "serve")
            told = json.loads(ready.read_text())
            yield Sea(sea, told["topside"], Path(told["black_box"]), track)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in ("auv", "robot") else pytest.mark.minutes)
        for name in STAYS
    ],
)
def test_the_stick_is_taken_and_given_back_in_mid_mission_and_the_mission_comes_home(
    tmp_path: Path, name: str
) -> None:
    mission = tmp_path / "stay.mission"
    mission.write_text(STAYS[name], encoding="utf-8")
    with at_sea(tmp_path, name) as sea:
        soon(lambda: run("upload", str(mission), "--to", sea.to).exit_code == 0, "the upload")
        soon(lambda: run("start", "--to", sea.to).exit_code == 0, "the start")
        sea.reaches("autonomous/stay")
        person = Person("--to", sea.to, "--gear", "12")
        try:
            soon(lambda: _pushes(person, sea), "the stick takes over")
            person.hold(UP, 3.0)
            person.type(b"q")
            assert person.ended() == 0
        finally:
            person.close()
        sea.reaches(MANUAL_WAITING)
        soon(lambda: run("start", "--to", sea.to).exit_code == 0, "the start")
        sea.reaches("autonomous/stay")
        sea.reaches("idle/ready")
        soon(lambda: _recorded(sea.box, name)[0][-1] == "idle/ready", "its record")
        states, driven = _recorded(sea.box, name)
        assert sea.far() > 1.0, "the mission goes nowhere: the stick moved it"
    legs = [state for state in states if state.startswith("autonomous/")]
    assert legs.count("autonomous/stay") == 2
    assert [MANUAL_DRIVING, MANUAL_WAITING] in [states[i : i + 2] for i in range(len(states))]
    assert not any(state.startswith("emergency/") for state in states)
    assert driven > 5, "words ahead on its own wire"


def _pushes(person: Person, sea: Sea) -> bool:
    person.hold(UP, 1.0)
    return sea.state().startswith(MANUAL_DRIVING)


def _recorded(box: Path, name: str) -> tuple[list[str], int]:
    """States as they were entered, and how many frames drove it ahead while the stick was held."""
    states, driven = ["idle/empty"], 0
    for record in read_parts(box):
        if record.kind == STEP:
            states += step_of(record.payload).entered[-1:]
        elif record.kind == TX and states[-1] == MANUAL_DRIVING:
            tx = read_tx(record)
            driven += tx.link == "vehicle" and _drives_ahead(tx.data, name)
    return states, driven


def _drives_ahead(data: bytes, name: str) -> bool:
    if name == "auv":
        return data == b"@MMF12$"
    row, field = AHEAD[name]
    frames = link(row).framer().receive(data, 0.0)
    return any(frame.values()[field] > 0 for frame in frames)  # type: ignore[union-attr]
