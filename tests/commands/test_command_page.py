"""Laws of the help page: every command is there, and its sentence is whole."""

from __future__ import annotations

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
    for file in ("capture.bin", "missions/first-dive.yaml"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).touch()
    command = main.get_command(click.Context(main), name)
    assert command is not None
    with command.make_context(name, arguments):
        pass
