"""``auvmission exhaustive``: try every event in every state of missions. Exit 0, 1, 2."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.jobs import Where, job_options
from mission.commands.options import VEHICLE_NAME

if TYPE_CHECKING:
    from mission.verification.exhaustive.run import Share
    from mission.verification.workers.outcome import Lost

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
    document. A mission without a result is printed with the command that examines it again, and
    counts as `undone`. The last line of stdout is one JSON object.
    """
    import json
    import sys

    from mission.authoring.prepare import Unreadable, prepare
    from mission.verification.exhaustive.configurations import Unreachable
    from mission.verification.exhaustive.run import Found, examine, shares_of, unasked

    _refuse_unknown(vehicle)
    try:
        shares = shares_of([prepare(path, vehicle) for path in missions or _shipped(vehicle)])
    except (Unreadable, Unreachable) as error:
        click.echo(str(error), err=True)
        sys.exit(2)
    tell = functools.partial(click.echo, err=True)
    undone = functools.partial(_tell_undone, vehicle)
    with where.keeping({"cells": "all"}, Found) as kept:
        found = examine(shares, where.lasting(SHARE).place, kept, tell, undone)
    if not as_json:
        for law, asked in sorted(found.asked.items()):
            click.echo(f"{asked:9d} cells  {found.broken[law]:6d} broken  {law}")
    of_legs = not missions and vehicle in (None, "auv")
    silent = [] if found.undone else unasked(found, of_legs=of_legs)
    for law in [] if found.undone else unasked(found):
        kind = "error: no cell asks" if law in silent else "note: no leg here is of the kind of"
        click.echo(f"{kind}: {law}", err=True)
    click.echo(json.dumps(found.as_json()))
    sys.exit(1 if found.broken or found.undone or silent else 0)


def _refuse_unknown(vehicle: str | None) -> None:
    from mission.model.shipped import load_vehicle
    from mission.model.vehicle import VehicleError

    try:
        load_vehicle(vehicle or "auv")
    except VehicleError as error:
        raise click.BadParameter(error.brief, param_hint="--vehicle") from None


def _shipped(vehicle: str | None) -> list[Path]:
    """The shipped missions that fly on it; None: those of the AUV."""
    from mission.model.shipped import missions_folder
    from mission.verification.campaign.faults import fitting

    if vehicle in (None, "auv"):
        return sorted(path for path in missions_folder().iterdir() if path.is_file())
    found = [one.path for one in fitting(str(vehicle))]
    if not found:
        raise click.UsageError(f"no shipped mission flies on {vehicle}: name MISSIONS")
    return found


def _tell_undone(vehicle: str | None, share: Share, lost: Lost) -> None:
    import shlex

    of = ["--vehicle", vehicle] if vehicle else []
    again = shlex.join(["auvmission", "exhaustive", share.prepared.source, *of])
    click.echo(f"{lost}\n  again: {again}", err=True)
