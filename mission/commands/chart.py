"""``auvmission chart``: convert electronic S-57 charts to GeoJSON for the console."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.output import write

if TYPE_CHECKING:
    from mission.console.charts.enc import Converted
    from mission.verification.workers.outcome import Lost

LONGEST_S = 300.0  # for one cell; the largest ones take some seconds


@click.command()
@click.argument("cells", metavar="CELL...", nargs=-1, required=True,
                type=click.Path(path_type=Path, dir_okay=False, exists=True))  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="File to write; without it, standard output.")  # fmt: skip
def chart(cells: tuple[Path, ...], output: Path | None) -> None:
    """Write each CELL, an electronic chart of S-57 (.000), as GeoJSON for console --chart.

    Writes coasts, land, depth areas, contours, soundings and dangers, with the updates that lie
    beside a cell (.001, ...). Standard error tells scale, contents and depth datum of each cell. A
    cell that cannot be read is named, the others are written, and the exit code is 2. Not for
    navigation: this is only a part of the chart.
    """
    found, left_out = list[object](), 0
    for cell, made in _converted(cells):
        if isinstance(made, str):
            click.echo(made, err=True)
            left_out += 1
        else:
            found += made.geojson["features"]
            _tell(cell, made)
    if found:
        whole = {"type": "FeatureCollection", "features": found}
        write(output, json.dumps(whole, separators=(",", ":")) + "\n")
    if left_out:
        raise SystemExit(2)


def _converted(cells: tuple[Path, ...]) -> Iterator[tuple[Path, Converted | str]]:
    """Yield each cell, converted, or with the reason why not. Each runs in a process of its own,
    because a damaged cell can crash GDAL and its process."""
    from mission.console.charts.enc import convert
    from mission.verification.workers import results
    from mission.verification.workers.outcome import Lost
    from mission.verification.workers.places import PROCESSES, Place

    once = tuple(dict.fromkeys(cells))
    at = Place(PROCESSES, workers=1, patience=LONGEST_S)
    for cell, made in zip(once, results(convert, once, at), strict=True):
        yield cell, _why(cell, made) if isinstance(made, Lost) else made


def _why(cell: Path, lost: Lost) -> str:
    from mission.console.charts.layer import ChartError

    if isinstance(lost.error, ChartError):
        return str(lost.error)
    return f"{cell.name}: GDAL ended over it ({lost.why}): it is damaged: fetch the cell again"


def _tell(cell: Path, made: Converted) -> None:
    counts = ", ".join(f"{number} {kind}" for kind, number in made.counts.items())
    click.echo(f"{cell.name}, 1 : {made.scale}, depths below {made.datum}: {counts}", err=True)
    if made.doubts:
        more = f" (and {len(made.doubts) - 1} more)" if made.doubts[1:] else ""
        click.echo(f"{cell.name}: not all could be made out: {made.doubts[0]}{more}", err=True)
