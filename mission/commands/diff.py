"""``auvmission diff``: compare two missions as the vehicle flies them. Exit 0, 1, 2."""

from __future__ import annotations

from pathlib import Path

import click

from mission.commands.options import AS_JSON, MISSION, PARAMETERS, VEHICLE
from mission.commands.unreadable import tell_unreadable


@click.command()
@click.argument("before", type=MISSION)
@click.argument("after", type=MISSION)
@VEHICLE
@PARAMETERS
@click.option("--markdown", is_flag=True, help="Tables for a pull request.")
@AS_JSON
def diff(
    before: Path,
    after: Path,
    vehicle: str | None,
    parameters: tuple[str, ...],
    markdown: bool,
    as_json: bool,
) -> None:
    """Show what changes for the vehicle from mission BEFORE to mission AFTER.

    Each may be YAML or lines. Compares legs, complete sets, guards, clocks, handlers, limits and
    assumptions, and the worst cases that the check proves. Exit 0 without a difference for the
    vehicle, 1 with one, 2 if a mission cannot be read.
    """
    import json
    import sys

    from mission.authoring.diff import compare
    from mission.authoring.diff.show import as_markdown, as_object, as_text
    from mission.authoring.prepare import Unreadable, parameters_of, prepare

    if markdown and as_json:
        raise click.UsageError("either --markdown or --json")
    try:
        given = parameters_of(parameters)
        found = compare(prepare(before, vehicle, given), prepare(after, vehicle, given))
    except Unreadable as error:
        tell_unreadable(error, as_json)
        sys.exit(2)
    if as_json:
        click.echo(json.dumps(as_object(found)))
    else:
        click.echo(as_markdown(found) if markdown else as_text(found))
    sys.exit(0 if found.same else 1)
