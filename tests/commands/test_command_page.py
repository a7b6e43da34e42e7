"""Laws of the help page: every command is there, and its sentence is whole."""

from __future__ import annotations

import functools
import json
import re
import shlex
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from mission.cli import COMMANDS, main


def test_the_page_has_every_command_with_a_whole_sentence() -> None:
    page = CliRunner().invoke(main, ["--help"], terminal_width=80).stdout
    rows = page.partition("Commands:\n")[2]
    assert [row.split()[0] for row in rows.splitlines() if row[2:3] != " "] == list(COMMANDS)
    assert "..." not in rows.replace("(auv.SD, ...)", "")
    assert max(map(len, page.splitlines())) <= 80


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_of_every_command_says_what_it_is_for(name: str) -> None:
    command = main.get_command(None, name)  # type: ignore[arg-type]
    assert command is not None
    assert CliRunner().invoke(main, [name, "--help"]).exit_code == 0
    silent = [
        option.name
        for option in command.params
        if option.param_type_name == "option" and not getattr(option, "help", None)
    ]
    assert not silent


PAGE = Path(__file__).parents[2] / "docs" / "reference" / "commands.md"


@functools.cache
def without_json() -> dict[str, str]:
    """Of the page's table: by command, why it has no --json."""
    table = PAGE.read_text(encoding="utf-8").partition("| without `--json` | because |\n")[2]
    rows = [row.strip("| ").split(" | ") for row in table.partition("\n\n")[0].splitlines()[1:]]
    return {name: why for names, why in rows for name in re.findall(r"`([a-z-]+)`", names)}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_answers_in_json_or_there_is_a_reason_why_not(name: str) -> None:
    command = main.get_command(click.Context(main), name)
    assert command is not None
    options = {option for one in command.params for option in one.opts}
    assert ("--json" in options) != (name in without_json())


def test_the_reasons_are_of_commands_that_there_are() -> None:
    assert without_json().keys() <= set(COMMANDS)
    assert all(without_json().values())


@pytest.mark.parametrize("name", ["start", "clear", "stop", "surface", "status"])
def test_what_a_vehicle_that_is_not_there_answers_is_one_object(name: str) -> None:
    nobody = ["--to", "tcp://127.0.0.1:1", "--json"]
    ran = CliRunner().invoke(main, [name, *nobody])
    assert ran.exit_code == 1
    assert isinstance(json.loads(ran.stdout), dict)


@pytest.mark.parametrize("command", [
    ["simulate"], ["diff"], ["rehearse"], ["upload"], ["check"],
    ["graph", "-o", "graph.svg"], ["plan", "-o", "plan.svg"],
])  # fmt: skip
def test_a_mission_that_cannot_be_flown_is_told_as_data_with_its_hints(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    bad = tmp_path / "bad.mission"
    bad.write_text("mission bad vehicle auv\nout: heading 90 gear 6\n", encoding="utf-8")
    files = [str(bad)] * (2 if command == ["diff"] else 1)
    ran = CliRunner().invoke(main, [*command, *files, "--json"])
    assert ran.exit_code == (1 if command[0] in ("check", "upload") else 2)
    (found,) = json.loads(ran.stdout)["refusals"]
    assert (found["code"], found["line"], found["file"]) == ("no-time-bound", 2, str(bad))
    assert found["hint"] == "add timeout (or for)"


@pytest.mark.parametrize("name", ["convert", "fmt", "graph", "plan"])
def test_words_that_are_none_are_told_as_data_with_their_hints(name: str, tmp_path: Path) -> None:
    bad = tmp_path / "bad.mission"
    bad.write_text("mission bad vehicle auv\ngroup rows repeat 2\n", encoding="utf-8")
    drawn = ["-o", str(tmp_path / "drawn.svg")] if name in ("graph", "plan") else []
    ran = CliRunner().invoke(main, [name, str(bad), "--json", *drawn])
    assert ran.exit_code == 2
    found = json.loads(ran.stdout)["refusals"]
    assert any(one["code"] == "syntax" and one["line"] == 2 and one["hint"] for one in found)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_help_ends_with_an_example_that_the_command_takes(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = CliRunner().invoke(main, [name, "--help"]).stdout
    shown = page.rpartition("Example:\n")[2].strip()
    program, word, *arguments = shlex.split(shown.partition(" > ")[0])
    assert (program, word) == ("auvmission", name)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recordings").mkdir()
    for file in ("capture.bin", "missions/first-dive.yaml", "US5MA11M.000"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).touch()
    command = main.get_command(click.Context(main), name)
    assert command is not None
    with command.make_context(name, arguments):
        pass
