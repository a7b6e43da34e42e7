"""``auvmission plan``: draw the planned track with its growing uncertainty."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mission.commands.options import AS_JSON, BATHYMETRY, MISSION, PARAMETERS, VEHICLE
from mission.commands.output import by_suffix, write
from mission.commands.seafloor import depths_of
from mission.commands.unreadable import tell_unreadable


@click.command()
@click.argument("mission", type=MISSION)
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path, dir_okay=False),
              help="File to write; its suffix says what: .png .svg .html .geojson")  # fmt: skip
@PARAMETERS
@VEHICLE
@BATHYMETRY
@AS_JSON
def plan(
    mission: Path,
    output: Path,
    parameters: tuple[str, ...],
    vehicle: str | None,
    bathymetry: Path | None,
    as_json: bool,
) -> None:
    """Draw the planned track of MISSION, in still water, over a grid.

    Shows legs, areas, turning points with their times, the depth, and the 95 % region of the
    vehicle's own estimate, which grows until the next fix. An .html page also shows, by leg, what
    check expects of dives in the current that MISSION assumes. With --bathymetry it draws the
    file's sea floor under the depth, and prints the least water under the vehicle.

    Exit 0, or 2 if MISSION cannot be read, or does not reach its end in still water.
    """
    from mission.authoring.prepare import Unreadable, parameters_of, prepare
    from mission.verification.planned.formats import FORMATS
    from mission.verification.planned.track import Unplanned, planned

    row = by_suffix(output, FORMATS)
    depths = None if bathymetry is None else depths_of(bathymetry)
    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
        made = planned(prepared.mission, prepared.chart, prepared.vehicle, depths)
        drawn = row.write(made)
    except Unreadable as error:
        tell_unreadable(error, as_json)
        raise SystemExit(2) from None
    except Unplanned as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    write(output, drawn)
    if made.unflown:
        never = ", ".join(made.unflown)
        click.echo(f"not drawn, since no way leads there in still water: {never}", err=True)
    if as_json:
        near = made.clearance
        told = {"file": str(output), "digest": prepared.chart.digest, "seconds": made.seconds}
        told["not_flown"] = list(made.unflown)
        click.echo(json.dumps({**told, "least_water_m": None if near is None else near.least}))
    elif made.clearance is not None:
        click.echo(made.clearance.told)
