"""``auvmission graph``: write the mission's state graph as a picture, a page, or tables."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mission.commands.options import AS_JSON, MISSION, PARAMETERS, VEHICLE
from mission.commands.output import by_suffix, write
from mission.commands.unreadable import tell_unreadable


@click.command()
@click.argument("mission", type=MISSION)
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path, dir_okay=False),
              help="File to write; its suffix says what: "
              ".svg .png .html .mmd .dot .scxml .json")  # fmt: skip
@click.option("--depth", type=click.IntRange(min=1), help="How many levels of groups to draw open.")
@click.option(
    "--safety",
    is_flag=True,
    help="Also draw the transitions that every mission has (stick, limits, X, W).",
)
@PARAMETERS
@VEHICLE
@AS_JSON
def graph(
    mission: Path,
    output: Path,
    depth: int | None,
    safety: bool,
    parameters: tuple[str, ...],
    vehicle: str | None,
    as_json: bool,
) -> None:
    """Draw MISSION as a state graph: legs, guards, and the ways out of them.

    .svg, .png and .html are for people, .mmd and .dot for other drawing tools. .scxml runs in any
    SCXML engine, .json has the chart's tables.
    """
    from mission.authoring.graph.formats import FORMATS
    from mission.authoring.graph.outline import TooLarge, outline
    from mission.authoring.graph.raster import NoFont
    from mission.authoring.prepare import Unreadable, parameters_of, prepare

    row = by_suffix(output, FORMATS)
    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
        drawn = row.draw(outline(prepared.chart, depth), safety)
    except Unreadable as error:
        tell_unreadable(error, as_json)
        raise SystemExit(2) from None
    except (NoFont, TooLarge) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    write(output, drawn)
    if as_json:
        click.echo(json.dumps({"file": str(output), "digest": prepared.chart.digest}))
