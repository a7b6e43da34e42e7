"""Laws of the shell's completion: commands, options, shipped missions and vehicles, files here."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.shell_completion import ShellComplete

from mission.cli import COMMANDS, main
from mission.commands.options import MISSION, VEHICLE_NAME
from mission.model.shipped import load_vehicle, shipped_missions, shipped_vehicles

FILE = "file"  # what the shell completes by itself


def completed(*words: str, end: str = "") -> list[tuple[str, str]]:
    shell = ShellComplete(main, {}, "auvmission", "_AUVMISSION_COMPLETE")
    return [(item.type, item.value) for item in shell.get_completions(list(words), end)]


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def _with(type_: click.ParamType, kind: type[click.Parameter]) -> Iterator[tuple[str, str]]:
    for name in COMMANDS:
        command = main.get_command(click.Context(main), name)
        assert command is not None
        for one in command.params:
            if one.type is type_ and isinstance(one, kind):
                yield name, one.opts[0]


@pytest.mark.parametrize("name", sorted({name for name, _ in _with(MISSION, click.Argument)}))
def test_a_mission_is_completed_with_the_shipped_ones(name: str) -> None:
    assert completed(name) == [("plain", mission) for mission in shipped_missions()]
    assert completed(name, end="harb") == [("plain", "harbour-survey")]


@pytest.mark.parametrize(("name", "option"), sorted(_with(VEHICLE_NAME, click.Option)))
def test_a_vehicle_is_completed_with_the_shipped_ones(name: str, option: str) -> None:
    offered = [value for _, value in completed(name, option)]
    assert offered == shipped_vehicles()
    for vehicle in offered:
        assert load_vehicle(vehicle).name


def test_the_commands_that_take_a_mission_by_name_are_those() -> None:
    taking = {name for name, _ in _with(MISSION, click.Argument)}
    assert taking == {
        *("simulate", "check", "convert", "graph", "plan", "diff", "rehearse", "demo"),
        *("upload", "campaign"),
    }


def test_missions_that_lie_here_are_offered_beside_the_shipped_ones(tmp_path: Path) -> None:
    for name in ("harbour-mine.yaml", "harbour.mission", "harbour.txt"):
        (tmp_path / name).touch()
    values = [value for _, value in completed("check", end="harb")]
    assert values == ["harbour-survey", "harbour-mine.yaml", "harbour.mission"]


def test_what_is_no_name_is_left_to_the_shell_as_a_file() -> None:
    assert completed("check", end="../sea/m") == [(FILE, "../sea/m")]
    assert completed("check", end="nothing") == [(FILE, "nothing")]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_program_prints_the_script_of_each_shell(shell: str) -> None:
    program = [sys.executable, "-m", "mission"]
    asked = {"_AUVMISSION_COMPLETE": f"{shell}_source"}
    ran = subprocess.run(
        program,
        env=asked,
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "_AUVMISSION_COMPLETE" in ran.stdout, ran.stderr
