"""The command line: names and help only. A command's module is imported when it is called.

A new command needs a file in ``mission.commands``, a row here, and a row in ``examples``. Command
``foo-bar`` is the click command ``foo_bar`` of its module.
"""

from __future__ import annotations

import importlib
import importlib.util
import keyword
import signal
from typing import Any

import click

from mission import __version__
from mission.commands.examples import epilog

INTERRUPTED = 128 + signal.SIGINT  # exit code, as in a shell

# name -> module in mission.commands, in the order of the help page
COMMANDS = {
    "demo": "demo",
    "simulate": "simulate",
    "rehearse": "rehearse",
    "vehicle": "vehicle",
    "water": "water",
    "check": "check",
    "convert": "convert",
    "fmt": "fmt",
    "schema": "schema",
    "import": "importing",
    "graph": "graph",
    "plan": "plan",
    "diff": "diff",
    "serve": "serve",
    "upload": "operator",
    "start": "operator",
    "clear": "operator",
    "status": "operator",
    "stop": "operator",
    "surface": "operator",
    "limits": "words",
    "time": "words",
    "nodes": "words",
    "power": "words",
    "rudder": "words",
    "output": "words",
    "send": "send",
    "stick": "stick",
    "monitor": "monitor",
    "log": "log",
    "story": "story",
    "export": "export",
    "watch": "watch",
    "console": "console",
    "chart": "chart",
    "foxglove": "foxglove",
    "replay": "replay",
    "decode": "decode",
    "encode": "encode",
    "listen": "listen",
    "find-crc": "find_crc",
    "report": "report",
    "calibrate": "calibrate",
    "score": "score",
    "exhaustive": "exhaustive",
    "doctor": "doctor",
    "campaign": "campaign",
    "faults": "faults",
    "keys": "keys",
}


class _Lazy(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return [name for name in COMMANDS if _exists(COMMANDS[name])]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS or not _exists(COMMANDS[name]):
            return None
        module = importlib.import_module(f"mission.commands.{COMMANDS[name]}")
        found: click.Command = getattr(module, _function(name))
        found.epilog = epilog(name)
        return found

    def invoke(self, ctx: click.Context) -> Any:
        """Exit with 130 on Ctrl-C. The exit is outside the handler, so that the exception and the
        frames that it holds are freed first."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            click.echo("interrupted", err=True)
        return ctx.exit(INTERRUPTED)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Print whole first sentences; click itself would cut them at the end of the line."""
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        rows = [(name, found.get_short_help_str(limit=200)) for name, found in commands if found]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


def _function(command: str) -> str:
    """The function of ``foo-bar``: foo_bar. After a keyword of Python comes an underscore."""
    name = command.replace("-", "_")
    return f"{name}_" if keyword.iskeyword(name) else name


def _exists(module: str) -> bool:
    return importlib.util.find_spec(f"mission.commands.{module}") is not None


def _tell_version(ctx: click.Context, _option: click.Parameter, asked: bool) -> None:
    """Print ``auvmission, version 1.0, pure Python``. Only this option looks up the build."""
    if not asked or ctx.resilient_parsing:
        return
    from mission.model.compiled import build

    click.echo(f"auvmission, version {__version__}, {build()}")
    ctx.exit()


@click.group(cls=_Lazy, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, is_eager=True, expose_value=False, callback=_tell_version,
              help="Show the version and exit.")  # fmt: skip
def main() -> None:
    """Write, check, fly and replay missions of autonomous underwater vehicles."""
