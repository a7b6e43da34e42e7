"""``auvmission score``: score the estimate on recordings of real vehicles with references."""

from __future__ import annotations

from pathlib import Path

import click

from mission.commands.options import VEHICLE_NAME


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--vehicle", type=VEHICLE_NAME, default="auv", show_default=True,
              help="Vehicle file or name whose compass the runs are given.")  # fmt: skip
@click.option("--without", multiple=True, metavar="STATE",
              help="Take a state away, to see what it earns; may be given again.")  # fmt: skip
def score(folder: Path, vehicle: str, without: tuple[str, ...]) -> None:
    """Score the estimate on every recording (CSV) below FOLDER.

    The last line is one JSON object; a table for people goes to stderr. Exit 2 if there is nothing
    to score.
    """
    import json
    import sys

    from mission.analysis.scores import as_object, summed
    from mission.analysis.scoring import WITHOUT, score_folder
    from mission.model.shipped import load_vehicle
    from mission.model.vehicle import VehicleError

    unknown = [name for name in without if name not in WITHOUT]
    if unknown:
        raise click.UsageError(f"no state {unknown[0]!r}; there are: {', '.join(WITHOUT)}")
    try:
        known = load_vehicle(vehicle)
    except VehicleError as error:
        raise click.UsageError(str(error)) from None
    scores, refused = score_folder(folder, known, without)
    for reason in refused:
        click.echo(f"left out: {reason}", err=True)
    click.echo(
        "file, scoring: end %, reference %, equal knowledge %, coverage, ellipse %", err=True
    )
    for s in scores:
        reference, equal = (_said(v) for v in (s.reference_pct, s.equal_pct))
        click.echo(
            f"{s.file}, {s.scoring}: {s.end_pct:.1f}, {reference}, {equal}, "
            f"{s.coverage:.2f}, {s.ellipse_pct:.0f}",
            err=True,
        )
    for line in summed(as_object(scores)):
        click.echo(line, err=True)
    click.echo(json.dumps(as_object(scores)))
    sys.exit(0 if scores else 2)


def _said(percent: float | None) -> str:
    return "-" if percent is None else f"{percent:.1f}"
