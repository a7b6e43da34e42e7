"""Missions in a row for one program: what it must live through, and when its memory has grown."""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import weakref
from pathlib import Path

import pytest
from click.testing import CliRunner
from known_missions import KNOWN

from links.simulated.link import START
from links.simulated.settings import Settings
from mission.commands.faults import faults
from mission.model import SURFACED, SURFACING, Step
from mission.model.shipped import load_vehicle
from mission.onboard.blackbox import part_path
from mission.verification.campaign import memory
from mission.verification.campaign import soak as module
from mission.verification.campaign.memory import LAST, SETTLED, SETTLED_ALIVE, Memory, grown
from mission.verification.campaign.soak import Soaked, last_words, soak
from mission.verification.rig.program import FillableStore, Program
from mission.verification.rig.rig import Rig
from mission.verification.rig.vehicle import simulated

VEHICLE = load_vehicle("auv")
FIRST = next(s for s in KNOWN if s.path.stem == "first-dive")
LEVEL = [100.0 + (i % 3) / 10 for i in range(2 * SETTLED + 60)]
RISING = [100.0 + i for i in range(len(LEVEL))]


def of(values: list[float], lives: list[int] | None = None) -> Memory:
    """The memory of a soak in which only blocks were other than level."""
    return Memory(LEVEL, values, LEVEL, LEVEL, lives or [1] * len(values))


# --- missions in a row ---------------------------------------------------------------------------


@pytest.mark.proof
def test_one_program_lives_through_missions_in_a_row(tmp_path: Path) -> None:
    soaked = soak(0.06, 0, KNOWN, VEHICLE, tmp_path)
    assert soaked.totals.clean
    assert soaked.missions >= 3
    assert soaked.totals.aborted["not started"] < soaked.missions
    found = soaked.memory
    assert len(found.objects) == len(found.blocks) == len(found.lives) == soaked.missions
    assert not soaked.broken_parts


@pytest.mark.proof
@pytest.mark.parametrize("damaged", ["in the midst", "cut", "whole"])
def test_a_part_of_the_black_box_is_read_to_its_end(
    damaged: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is written for others to read, so it is damaged before the soak reads it."""

    def next_part(box: Path, number: int) -> Path:
        part = part_path(box, number)
        if number == 1:
            data = part.read_bytes()
            half = len(data) // 2
            holed = data[:half] + bytes(100) + data[half + 100 :]
            part.write_bytes({"cut": data[:half], "whole": data}.get(damaged, holed))
        return part

    monkeypatch.setattr(module, "PART", 1 << 18)
    monkeypatch.setattr(module, "part_path", next_part)
    soaked = soak(0.02, 0, KNOWN, VEHICLE, tmp_path)
    assert soaked.parts > 1
    assert soaked.broken_parts == (damaged != "whole")


@pytest.mark.proof
def test_one_program_lives_through_all_of_a_calm_soak(tmp_path: Path) -> None:
    soaked = soak(0.06, 0, KNOWN, VEHICLE, tmp_path, calmly=True)
    assert soaked.totals.clean
    assert not soaked.totals.aborted
    assert soaked.memory.lives == [1] * soaked.missions
    assert not soaked.totals.kinds


@pytest.mark.proof
def test_soaks_of_several_seeds_say_what_each_says_alone_and_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "soaks.jsonl"
    call = ["--soak", "0.001", "--seed", "3", "--soaks", "2", "--resume", str(file)]
    done = CliRunner().invoke(faults, [*call, "--on", "processes", "--workers", "2"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout.splitlines()[-1])["soaks"]
    for seed in (3, 4):
        (folder := tmp_path / str(seed)).mkdir()
        alone = soak(0.001, seed, KNOWN, VEHICLE, folder)
        assert found[str(seed)]["digest"] == alone.totals.digest
        assert found[str(seed)]["missions"] == alone.missions
    assert found["3"]["digest"] != found["4"]["digest"]
    again = CliRunner().invoke(faults, [*call, "--on", "local"])
    assert json.loads(again.stdout.splitlines()[-1]) == {"soaks": found, "undone": []}
    calm = CliRunner().invoke(faults, [*call, "--calm", "--on", "local"])
    assert calm.exit_code == 2, "the file has soaks with faults"


def test_several_soaks_are_soaks() -> None:
    done = CliRunner().invoke(faults, ["--soaks", "2"])
    assert (done.exit_code, "--soaks needs --soak" in done.stderr) == (2, True)


def test_the_next_mission_knows_the_last_command_though_an_output_was_set_after_it() -> None:
    """As mission 170 of soak 51 of the core board: its thrust held it up behind *surfaced*."""
    up = Step(80.0, "", (), (), (SURFACING,), ("surge 0 heave -1: no fix for 8 s",), "limit")
    output = Step(80.0, "", (), (), (), ("output dvl 1: outputs in emergency/surfacing",), "")
    reached = Step(86.0, "", (), (), (SURFACED,), (), "surfaced")
    known = last_words((up, output, reached), 100.0)
    assert [step.actions for step in known if isinstance(step, Step)] == [up.actions, ()]


# --- memory --------------------------------------------------------------------------------------


def test_a_program_that_goes_to_another_rig_keeps_nothing_of_the_one_before() -> None:
    program = Program(VEHICLE, FillableStore(), START.timestamp())
    program.boot(0.0)
    rig = Rig(simulated(VEHICLE, 1, Settings()), program, None)
    before = weakref.ref(rig)
    program.begin_again(0.0)
    del rig
    gc.collect()
    assert before() is None


def test_a_leak_is_growth_and_one_large_mission_is_not() -> None:
    flat = LEVEL[:60]
    assert grown(flat, 5) == pytest.approx(0.0, abs=0.01)
    assert grown([*flat[:40], 150.0, *flat[41:]], 5) == pytest.approx(0.0, abs=0.01)
    leaking = grown(RISING[:60], 5)
    assert leaking is not None
    assert leaking > 0.3
    assert of(LEVEL).flat
    assert of(RISING).flat is False


def test_resident_memory_that_the_longest_mission_left_behind_is_no_growth() -> None:
    """As of seed 14: +9 % from one long mission of day 22 on, by pages that hold next to nothing."""
    stepped = Memory(LEVEL, LEVEL, LEVEL, [*LEVEL[:130], *(v + 9 for v in LEVEL[130:])], [1] * 160)
    assert stepped.flat
    assert not list(stepped.in_words())
    assert (stepped.as_json()["resident_mb"], stepped.as_json()["resident_most_mb"]) == (109, 109.2)


def test_a_leak_that_is_neither_object_nor_block_is_growth() -> None:
    """Python gives bytes above 512 to malloc, where libraries also have theirs."""
    leaking = Memory(LEVEL, LEVEL, RISING, LEVEL, [1] * len(LEVEL))
    assert leaking.flat is False
    assert [line.split(" by ")[0] for line in leaking.in_words()] == ["memory grew: malloc"] * 2


@pytest.mark.skipif(memory.allocated() is None, reason="the C library does not tell")
def test_what_malloc_has_given_out_is_counted_until_it_is_given_back() -> None:
    before = memory.allocated() or 0.0
    kept = [bytes(10_000) for _ in range(1000)]
    assert 10e6 <= (memory.allocated() or 0.0) - before < 11e6
    kept.clear()
    assert abs((memory.allocated() or 0.0) - before) < 1e6


def test_what_is_kept_once_by_each_new_mission_is_no_growth() -> None:
    assert of([*RISING[:SETTLED], *(100.0 + SETTLED for _ in LEVEL[SETTLED:])]).flat


def test_a_leak_of_one_program_is_growth_though_restarts_free_it() -> None:
    """The whole soak saws, and ends as low as it was."""
    lives = [1 + i // 8 for i in range(len(LEVEL))]
    lives[112:144] = [99] * 32
    born = {life: lives.index(life) for life in lives}
    leaking = of([100.0 + (i - born[life]) / 5 for i, life in enumerate(lives)], lives)
    assert leaking.longest_life == slice(112, 144)
    assert leaking.growth["blocks"] == pytest.approx(-0.01, abs=0.01)
    assert list(leaking.in_words()) == [
        "memory grew: blocks by 3.5% in one life of the program, of 32 missions, allowed 2%"
    ]
    assert leaking.flat is False
    assert of(LEVEL, lives).flat


def test_a_soak_of_few_missions_says_that_it_has_not_judged_memory() -> None:
    short = of(RISING[: 2 * SETTLED])
    assert short.flat is None
    assert list(short.in_words()) == ["memory: not judged, for want of missions (100 of 105)"]
    assert Soaked(memory=short).held
    lives = list(range(len(LEVEL)))
    assert list(of(LEVEL, lives).in_words()) == [
        "memory of one program: not judged, since none lived through 1 of 15 missions"
    ]


def test_the_settling_leaves_enough_to_judge() -> None:
    assert grown([1.0] * (2 * SETTLED + LAST - 1), SETTLED) is None
    assert grown([1.0] * (2 * SETTLED + LAST), SETTLED) == 0.0
    assert grown([1.0] * (2 * SETTLED_ALIVE + LAST), SETTLED_ALIVE) == 0.0


LEAKING = """
import sys
from known_missions import KNOWN
from mission.commands import faults as command
from mission.verification.campaign import memory
from mission.verification.rig.program import Program

def leaky(program, now):
    begin_again(program, now)
    kept = vars(program.runtime.judge).setdefault("kept", [])
    kept.extend(bytes(100) for _ in range(leaks))

leaks = int(sys.argv[1])
begin_again, Program.begin_again, memory.SETTLED = Program.begin_again, leaky, 15
command._known = lambda vehicle: [s for s in KNOWN if s.path.stem == "first-dive"]
command.faults(["--soak", "0.3", "--calm"])
"""


@pytest.mark.proof
@pytest.mark.parametrize("leaks", [0, 20_000])
def test_a_soak_whose_program_leaks_is_told_by_words_and_exit_code(leaks: int) -> None:
    """In a process of its own: what other tests have left in this one would be judged, too."""
    run = [sys.executable, "-c", LEAKING, str(leaks)]
    path = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        run, capture_output=True, text=True, check=False, env=os.environ | {"PYTHONPATH": path}
    )
    found = json.loads(done.stdout.splitlines()[-1])
    assert (done.returncode, found["flat"]) == ((1, False) if leaks else (0, True)), done.stderr
    assert ("memory grew: blocks by" in done.stderr) == bool(leaks)
