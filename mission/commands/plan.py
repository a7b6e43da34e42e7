"""``auvmission plan``: the planned track with its growing uncertainty, drawn."""

from __future__ import annotations

from pathlib import Path

import click

from mission.commands.options import MISSION, PARAMETERS, VEHICLE
from mission.commands.output import by_suffix, write


@click.command()
@click.argument("mission", type=MISSION)
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path, dir_okay=False),
              help="File to write; its suffix says what: .png .svg .html .geojson")  # fmt: skip
@PARAMETERS
@VEHICLE
def plan(mission: Path, output: Path, parameters: tuple[str, ...], vehicle: str | None) -> None:
    """Draw where MISSION means to go: its track in still water, over a grid.

    Shows legs, areas, turning points with their times, the depth, and where the vehicle may be by
    its own estimate with 95 %, which grows until the next fix. Exit 0, or 2 if MISSION cannot be
    read, or does not come to its end in still water.
    """
    from mission.authoring.prepare import Unreadable, parameters_of, prepare
    from mission.verification.planned.formats import FORMATS
    from mission.verification.planned.track import Unplanned, planned

    row = by_suffix(output, FORMATS)
    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
        drawn = row.write(planned(prepared.mission, prepared.chart, prepared.vehicle))
    except (Unreadable, Unplanned) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    write(output, drawn)
