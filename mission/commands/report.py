"""``auvmission report``: past dives on one page, with smoothed tracks and sensor readings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import AS_JSON, LOGGED_VEHICLE
from mission.commands.output import writing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mission.analysis.report.dive import Dive

_PICTURES = (".png", ".pdf", ".svg")


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...",
                type=click.Path(path_type=Path, dir_okay=False))  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="Page to write; default: the first FILE with the suffix .html. With the suffix "
              ".png, .pdf or .svg the smoothed track of one FILE alone.")  # fmt: skip
@click.option("--map", "map_", type=click.Path(path_type=Path, dir_okay=False),
              help="The map of one FILE as well, as a PNG, PDF or SVG, by its suffix.")  # fmt: skip
@click.option("--pictures", type=click.Path(path_type=Path, file_okay=False),
              help="A folder for the pictures of one FILE, as PNG and PDF.")  # fmt: skip
@LOGGED_VEHICLE
@AS_JSON
def report(
    files: tuple[Path, ...],
    output: Path | None,
    map_: Path | None,
    pictures: Path | None,
    vehicle: str | None,
    as_json: bool,
) -> None:
    """Make a page of dives: map, depth, sensors, limits, fixes, story, and the smoothed track.

    Writes one self-contained HTML file of the black boxes FILE..., in the order of their starts.
    The smoothed track also uses the fixes after the dive. With it come innovations, residuals, and
    the times when a sensor could not be believed. Exit 2 if a FILE cannot be used.
    """
    from mission.analysis.report.dive import dives_of
    from mission.analysis.report.words import figures, track_words
    from mission.model.shipped import load_vehicle
    from mission.model.vehicle import VehicleError
    from mission.onboard.blackbox import BlackBoxError

    page = output or files[0].with_suffix(".html")
    _check_one(files, page, map_, pictures)
    try:
        dives = dives_of(files, load_vehicle(vehicle) if vehicle else None)
        if page.suffix in _PICTURES and dives[0].smoothed is None:
            raise ValueError("there is no fix of a receiver: no smoothed track")
    except (BlackBoxError, VehicleError) as error:
        raise _failed(str(error)) from None
    except (ValueError, KeyError, TypeError) as error:
        raise _failed(f"{', '.join(map(str, files))}: {error}") from None
    made = _write(dives, page, map_, pictures)
    told = [figures(dive) for dive in dives]
    if as_json:
        click.echo(json.dumps(told[0] if len(told) == 1 else told))
        return
    for dive in dives:
        click.echo(track_words(dive))
    for path in made:
        click.echo(f"{'page' if path.suffix == '.html' else 'picture':10} {path}")


def _check_one(
    files: tuple[Path, ...], page: Path, map_: Path | None, pictures: Path | None
) -> None:
    if len(files) > 1 and (map_ or pictures or page.suffix in _PICTURES):
        raise click.UsageError("pictures and a map are of one FILE")
    if page.suffix not in (".html", *_PICTURES):
        raise click.UsageError(
            f"{page}: the suffix says what to write: .html, or .png, .pdf or .svg for the track"
        )
    if map_ is not None and map_.suffix not in _PICTURES:
        raise click.UsageError(f"--map {map_}: a map is a .png, .pdf or .svg")


def _write(
    dives: Sequence[Dive], page: Path, map_: Path | None, pictures: Path | None
) -> list[Path]:
    """Write the files and return them. Exit 2 if one cannot be written."""
    from mission.analysis.drawing import draw_track
    from mission.analysis.report.figures import map_of, pictures_of, save
    from mission.analysis.report.page import report_page
    from mission.analysis.report.words import headline, simulated

    dive = dives[0]
    title = "\n".join(filter(None, (headline(dive), simulated(dive))))
    with writing(page):
        if page.suffix in _PICTURES and dive.smoothed is not None:
            draw_track(dive.smoothed, dive.spells, page, title)
        else:
            page.write_text(report_page(dives), encoding="utf-8")
    made = {map_: map_of(dive)} if map_ is not None else {}
    if pictures is not None:
        with writing(pictures):
            pictures.mkdir(parents=True, exist_ok=True)
        for one in pictures_of(dive):
            made |= {pictures / f"{one.name}.{form}": one for form in ("png", "pdf")}
    for path, picture in made.items():
        with writing(path):
            save(picture, path, title)
    return [page, *made]


def _failed(why: str) -> SystemExit:
    click.echo(why, err=True)
    return SystemExit(2)
