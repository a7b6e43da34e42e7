"""``auvmission exhaustive``: every state of every mission, every event. Exit 0, 1, 2."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("missions", nargs=-1, type=click.Path(path_type=Path, dir_okay=False))
@click.option("--json", "as_json", is_flag=True, help="The object alone on stdout.")
@click.option("--workers", type=click.IntRange(1), help="Processes; default: one per core.")
def exhaustive(missions: tuple[Path, ...], as_json: bool, workers: int | None) -> None:
    """Cross every configuration of MISSIONS (default: all shipped) with every event.

    Both profiles of the vehicle. The last line of stdout is one JSON object.
    """
    import json
    import os
    import sys

    from mission.authoring.prepare import Unreadable
    from mission.model.shipped import missions_folder
    from mission.verification.exhaustive.configurations import Unreachable
    from mission.verification.exhaustive.run import examine, unasked

    chosen = missions or tuple(sorted(p for p in missions_folder().iterdir() if p.is_file()))
    try:
        found = examine(
            chosen, workers or os.cpu_count() or 1, lambda line: click.echo(line, err=True)
        )
    except (Unreadable, Unreachable) as error:
        click.echo(str(error), err=True)
        sys.exit(2)
    if not as_json:
        for law, asked in sorted(found.asked.items()):
            click.echo(f"{asked:9d} cells  {found.broken[law]:6d} broken  {law}")
    silent = unasked(found, of_legs=not missions)
    for law in unasked(found):
        kind = "error: no cell asks" if law in silent else "note: no leg here is of the kind of"
        click.echo(f"{kind}: {law}", err=True)
    click.echo(json.dumps(found.as_json()))
    sys.exit(1 if found.broken or silent else 0)
