"""``auvmission exhaustive``: try every event in every state of missions. Exit 0, 1, 2."""

from __future__ import annotations

from pathlib import Path

import click

from mission.commands.jobs import Where, job_options
from mission.commands.options import VEHICLE_NAME

SHARE = 20.0  # a mission on a profile takes at most as long as so many flights


@click.command()
@click.argument("missions", nargs=-1, type=click.Path(path_type=Path, dir_okay=False))
@click.option("--vehicle", type=VEHICLE_NAME, metavar="NAME",
              help="A shipped vehicle: auv, coreboard, rov, robot.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="The object alone on stdout.")
@job_options
def exhaustive(
    missions: tuple[Path, ...], vehicle: str | None, as_json: bool, where: Where
) -> None:
    """Cross every configuration of MISSIONS with every event.

    Without MISSIONS: all shipped ones that fly on the vehicle. Without --vehicle: the one that each
    mission names, else the AUV, in both of its profiles. The bytes are as in the vehicle's own
    document. The last line of stdout is one JSON object.
    """
    import json
    import sys

    from mission.authoring.prepare import Unreadable
    from mission.model.shipped import load_vehicle, missions_folder
    from mission.model.vehicle import VehicleError
    from mission.verification.campaign.faults import fitting
    from mission.verification.exhaustive.configurations import Unreachable
    from mission.verification.exhaustive.run import Found, examine, unasked

    try:
        load_vehicle(vehicle or "auv")
    except VehicleError as error:
        raise click.BadParameter(error.brief, param_hint="--vehicle") from None
    auvs = (p for p in missions_folder().iterdir() if p.is_file())
    others = vehicle not in (None, "auv")
    shipped = [one.path for one in fitting(str(vehicle))] if others else sorted(auvs)
    chosen = missions or tuple(shipped)
    if not chosen:
        raise click.UsageError(f"no shipped mission flies on {vehicle}: name MISSIONS")
    try:
        with where.keeping({"cells": "all"}, Found) as kept:
            found = examine(
                chosen,
                where.lasting(SHARE).place,
                kept,
                lambda line: click.echo(line, err=True),
                vehicle,
            )
    except (Unreadable, Unreachable) as error:
        click.echo(str(error), err=True)
        sys.exit(2)
    if not as_json:
        for law, asked in sorted(found.asked.items()):
            click.echo(f"{asked:9d} cells  {found.broken[law]:6d} broken  {law}")
    silent = unasked(found, of_legs=not (missions or others))
    for law in unasked(found):
        kind = "error: no cell asks" if law in silent else "note: no leg here is of the kind of"
        click.echo(f"{kind}: {law}", err=True)
    click.echo(json.dumps(found.as_json()))
    sys.exit(1 if found.broken or found.undone or silent else 0)
