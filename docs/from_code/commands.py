"""One command of the command line as Markdown: its help, its usage, its arguments and options."""

from __future__ import annotations

import re
from collections.abc import Iterator

import click

from mission.cli import main

PIPE = "\\|"  # in a cell of a table, also within code


def command_part(name: str) -> str:
    """Raises LookupError for a command that does not exist."""
    context = click.Context(main, info_name="auvmission")
    command = main.get_command(context, name)
    if command is None:
        raise LookupError("no such command")
    usage = command.get_usage(click.Context(command, info_name=name, parent=context))
    lines = ["```text", re.sub(r"\s+", " ", usage.removeprefix("Usage: ")), "```", ""]
    lines += [_paragraphs(command.help or ""), ""]
    options = [one for one in command.params if isinstance(one, click.Option)]
    if options:
        lines += ["| option | what |", "|---|---|", *map(_row, options)]
    return "\n".join(lines)


def _paragraphs(text: str) -> str:
    """A help text as Markdown: what click keeps as it stands (after \\b) is a block of code."""
    return "\n\n".join(_paragraph(part) for part in text.strip().split("\n\n"))


def _paragraph(text: str) -> str:
    if text.startswith("\b"):
        return f"```text\n{text.removeprefix(chr(8)).strip(chr(10))}\n```"
    return escaped(" ".join(text.split()))


def _row(option: click.Option) -> str:
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    value = "" if option.is_flag or option.count else f" `{option.make_metavar(_CONTEXT)}`"
    return f"| {names}{value.replace('|', PIPE)} | {' '.join(_notes(option))} |"


def _notes(option: click.Option) -> Iterator[str]:
    yield escaped(option.help or "")
    default = option.default
    if option.show_default and default not in (None, False, ()):
        yield f"Default: `{default}`."
    if option.required:
        yield "Required."


def escaped(text: str) -> str:
    """Text that means itself in a cell of a Markdown table."""
    return re.sub(r"([\\`*_<>|\[\]{}$])", r"\\\1", text)


_CONTEXT = click.Context(main)
