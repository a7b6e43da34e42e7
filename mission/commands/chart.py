"""``auvmission chart``: an electronic chart of S-57 as GeoJSON for the console."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mission.commands.output import write


@click.command()
@click.argument("cell", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="File to write; without it, standard output.")  # fmt: skip
def chart(cell: Path, output: Path | None) -> None:
    """Write CELL, an electronic chart of S-57 (.000), as GeoJSON for console --chart.

    Coasts, land, depth areas, contours, soundings and dangers; updates that lie beside it (.001,
    ...) are applied. What it is, how much is in it, and the datum of its depths are told on
    standard error. Not for navigation: of what a chart holds, this is a part.
    """
    from mission.console.charts.enc import convert
    from mission.console.charts.layer import ChartError

    try:
        made = convert(cell)
    except ChartError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    write(output, json.dumps(made.geojson, separators=(",", ":")) + "\n")
    counts = ", ".join(f"{number} {kind}" for kind, number in made.counts.items())
    click.echo(f"{cell.name}, 1 : {made.scale}, depths below {made.datum}: {counts}", err=True)
    if made.doubts:
        more = f" (and {len(made.doubts) - 1} more)" if made.doubts[1:] else ""
        click.echo(f"{cell.name}: not all could be made out: {made.doubts[0]}{more}", err=True)
