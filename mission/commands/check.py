"""``auvmission check``: prove bounds of a mission, or refuse it. Exit 0, 1, 2."""

from __future__ import annotations

from pathlib import Path

import click

from mission.commands.options import AS_JSON, BATHYMETRY, MISSION, PARAMETERS, VEHICLE
from mission.commands.seafloor import depths_of
from mission.commands.unreadable import tell_unreadable


@click.command()
@click.argument("mission", type=MISSION)
@VEHICLE
@PARAMETERS
@BATHYMETRY
@AS_JSON
def check(
    mission: Path,
    vehicle: str | None,
    parameters: tuple[str, ...],
    bathymetry: Path | None,
    as_json: bool,
) -> None:
    """Prove what MISSION can do at most, and refuse it if it could lose the vehicle.

    The bounds on time, energy, range and depth hold on every way through it. A refusal names the
    place in the text, and why. With --bathymetry the sea floor under each leg counts too.

    Exit 0 if proved, 1 if refused, 2 if MISSION cannot be read.
    """
    import json
    import sys
    from datetime import UTC, datetime

    from mission.authoring.check.show import as_object, as_text
    from mission.authoring.prepare import Unreadable, check_prepared, parameters_of, prepare
    from mission.model.buoyancy import doubt

    depths = None if bathymetry is None else depths_of(bathymetry)
    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
        report = check_prepared(prepared, depths)
    except Unreadable as error:
        tell_unreadable(error, as_json)
        sys.exit(1 if error.refused else 2)
    today = datetime.now(UTC).date()
    if prepared.vehicle.ascent_measured and (why := doubt(prepared.vehicle, today)):
        click.echo(f"{prepared.vehicle.name}: {why}", err=True)
    text = as_text(prepared.source, report, prepared.chart.digest)
    if depths is not None and not as_json:
        text = f"{depths.source}: {depths.told}\n{text}"
    click.echo(json.dumps(as_object(report)) if as_json else text)
    sys.exit(0 if report.ok else 1)
