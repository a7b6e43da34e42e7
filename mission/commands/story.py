"""``auvmission story``: tell a dive in words."""

from __future__ import annotations

from pathlib import Path

import click

from mission.commands.output import write


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...",
                type=click.Path(path_type=Path, dir_okay=False))  # fmt: skip
@click.option("--form", type=click.Choice(["text", "markdown", "html"]), default="text",
              show_default=True, help="As what it is told.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="File to write; default: standard output.")  # fmt: skip
def story(files: tuple[Path, ...], form: str, output: Path | None) -> None:
    """Tell a dive from its black boxes FILES: what was flown, and why.

    Tells the mission, its legs with the guard that ended each, limits with the least margin,
    alarms, refusals, and every command to the vehicle with its reason. Several files are told in
    the order of their starts, with the restart between two. Exit 2 if a file cannot be used.
    """
    from mission.analysis.journal import recordings
    from mission.analysis.story import story as told
    from mission.analysis.tell import FORMS
    from mission.onboard.blackbox import BlackBoxError

    try:
        chapters = told(recordings(files))
    except BlackBoxError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    except (ValueError, KeyError, TypeError) as error:
        click.echo(f"a start record is not one of this version: {error}", err=True)
        raise SystemExit(2) from None
    write(output, FORMS[form](", ".join(path.name for path in files), chapters))
