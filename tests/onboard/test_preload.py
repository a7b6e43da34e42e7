"""What a mission needs is loaded beside everything else, and then costs nobody any time."""

from __future__ import annotations

import gc
import json
import subprocess
import sys
from collections.abc import Iterator

import pytest

from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.command_target import MissionRefused
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.preload import judge_ahead, prepare
from mission.onboard.store import MemoryStore, Stored

LINES = ("mission a vehicle auv", "ZAF6", "wait 10s")
# what none of a start's work needs: each would add a tenth of it, or a multiple
_UNUSED = ("filterpy", "scipy", "matplotlib", "pandas", "textual")
_START = """
import json, sys
import mission.onboard.serve.serve
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.preload import prepare
from mission.onboard.store import MemoryStore
prepare(Runtime(Configuration(), load_vehicle("auv"), MemoryStore()))
print(json.dumps(sorted(sys.modules)))
"""
_FIRST_FIX = """
import json, sys
from datetime import datetime, timezone
import mission.onboard.serve.serve
from links.base import Rx
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.alarm_watch import clock_off
from mission.onboard.serve.preload import prepare
from mission.onboard.store import MemoryStore
from protocol.nmea import encode_gga, encode_rmc
utc = datetime(2026, 6, 1, 8, 0, 4, tzinfo=timezone.utc)
said = encode_gga(utc, 0.5, 2.1) + encode_rmc(utc, 0.5, 2.1, speed=1.0, course=0.5)
runtime = Runtime(Configuration(), load_vehicle("auv"), MemoryStore())
runtime.set_navigation(prepare(runtime), 0.0)
asked = []
sys.addaudithook(lambda what, of: asked.append(f"{what} {of[0]}") if what in ("open", "import") else 0)
runtime.receive(Rx(1.0, "gps", said))
assert clock_off(runtime.situation.fix, 1.0, wall=0.0) is not None
print(json.dumps(asked))
"""


def imported(program: str, *arguments: str) -> list[str]:
    """What a new interpreter has at the end of a program that prints it, as JSON: its modules."""
    call = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(call, check=True, capture_output=True, text=True)
    found: list[str] = json.loads(done.stdout.splitlines()[-1])
    return found


@pytest.fixture(autouse=True)
def _as_it_was() -> Iterator[None]:
    gc.unfreeze()
    yield
    gc.freeze()  # as it is in a run of the tests


def runtime() -> Runtime:
    return Runtime(Configuration(), load_vehicle("auv"), MemoryStore())


@pytest.mark.proof
def test_the_collector_does_not_look_through_what_is_there_for_good() -> None:
    gc.collect()  # what nobody holds any more is thrown away, not frozen
    before = len(gc.get_objects())
    assert prepare(runtime()).estimate(0.0) is None
    assert gc.isenabled()
    assert gc.get_freeze_count() >= before
    assert len(gc.get_objects()) < 0.1 * gc.get_freeze_count()


def test_the_kept_mission_is_judged_ahead_of_idle_but_an_ascent_waits_for_no_judge(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judged: list[tuple[str, ...]] = []

    def refused(lines: tuple[str, ...], _: object) -> None:
        judged.append(lines)
        raise MissionRefused("too long")

    monkeypatch.setattr("mission.onboard.runtime.mission_validator.judge", refused)
    kept = MemoryStore(Stored(LINES, under_way="autonomous/dive"))
    ready = Runtime(Configuration(), load_vehicle("auv"), kept)
    prepare(ready)
    assert judged == []
    judge_ahead(ready)
    with pytest.raises(MissionRefused):
        ready.judge(LINES)
    assert judged == [LINES]


def test_a_further_drive_leaves_its_predecessor_to_the_collector() -> None:
    prepare(runtime())
    frozen = gc.get_freeze_count()
    prepare(runtime())
    assert gc.get_freeze_count() <= frozen


def test_a_filter_that_cannot_be_loaded_leaves_the_collector_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def absent(self: Runtime) -> None:
        raise ImportError("no filterpy")

    monkeypatch.setattr(Runtime, "make_navigation", absent)
    with pytest.raises(ImportError, match="no filterpy"):
        prepare(runtime())
    assert gc.isenabled()


@pytest.mark.proof
def test_a_start_of_serve_imports_the_filter_and_nothing_of_what_lies_beside_it() -> None:
    found = imported(_START)
    assert "mission.navigation.kalman" in found
    assert not [name for name in found if name.split(".")[0] in _UNUSED]
    assert len(found) < 800  # about 660; with all of filterpy 1700


def test_a_first_fix_reads_no_file_and_imports_nothing() -> None:
    """It comes in the loop, and the card may hang."""
    assert imported(_FIRST_FIX) == []


def test_a_page_of_help_imports_no_room_of_the_program() -> None:
    help_page = (
        "import json, sys; from click.testing import CliRunner; from mission.cli import main;"
        "assert not CliRunner().invoke(main, ['--help']).exit_code;"
        "print(json.dumps(sorted(sys.modules)))"
    )
    rooms = {".".join(name.split(".")[:2]) for name in imported(help_page)}
    assert {room for room in rooms if room.startswith("mission")} == {
        *("mission", "mission.cli", "mission.commands"),
    }
