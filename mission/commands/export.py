"""``auvmission export``: write black boxes as files for other programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import AS_JSON
from mission.commands.output import writing

if TYPE_CHECKING:
    from collections.abc import Sequence


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...",
                type=click.Path(path_type=Path, dir_okay=False))  # fmt: skip
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path, file_okay=False),
              help="Folder to write into, a folder in it for each FILE.")  # fmt: skip
@click.option("--as", "forms", multiple=True, required=True,
              type=click.Choice(["csv", "parquet", "gpx", "kml", "geojson"]),
              help="csv, parquet: every topic. gpx, kml, geojson: track, fixes and plan. "
              "Repeatable.")  # fmt: skip
@click.option("--force", is_flag=True, help="Write over what is there.")
@AS_JSON
def export(
    files: tuple[Path, ...], output: Path, forms: tuple[str, ...], force: bool, as_json: bool
) -> None:
    """Write black boxes as CSV, Parquet, GPX, KML or GeoJSON.

    Each FILE gets a folder of its own in --output, with its name. Units are in columns.csv; in
    Parquet they are with each field. Existing files are overwritten only with --force. Exit 2 if a
    file cannot be used or written; the others are written all the same.
    """
    from mission.analysis.export import ExportError, folders
    from mission.onboard.blackbox import BlackBoxError, first_part

    logs = list(dict.fromkeys(map(first_part, files)))
    try:
        into = folders(output, logs)
        if not force:
            _refuse_what_is_there(into, forms)
        wrong, written = list[str](), list[Path]()
        for log, folder in zip(logs, into, strict=True):
            made, why = _made(log, forms)
            with writing(folder):
                written += _write(folder, made, quiet=as_json)
            for one in why:
                click.echo(one, err=True)
            wrong += why
        if as_json:
            click.echo(json.dumps({"written": [str(path) for path in written], "refusals": wrong}))
        if wrong:
            raise SystemExit(2)
    except (BlackBoxError, ExportError) as error:
        raise _failed(str(error)) from None


def _refuse_what_is_there(into: Sequence[Path], forms: Sequence[str]) -> None:
    from mission.analysis.export import ExportError

    there = [path for folder in into for form in forms for path in folder.glob(f"*.{form}")]
    if there:
        raise ExportError(f"{min(there)} is there: --force writes over it, or name another folder")


def _made(log: Path, forms: Sequence[str]) -> tuple[list[tuple[str, bytes]], list[str]]:
    """The files of a log, and why others are missing. Prints the gaps in the log."""
    from mission.analysis.export import FORMS, ExportError
    from mission.analysis.journal import recordings
    from mission.onboard.blackbox import Gap

    made, why = list[tuple[str, bytes]](), dict[str, None]()
    try:
        (items,) = recordings([log])
        for form in dict.fromkeys(forms):
            try:
                made += list(FORMS[form](items))
            except ExportError as error:
                why[f"{log}: {error}"] = None
    except (ValueError, KeyError, TypeError) as error:
        old = f"{log}: its start record is not one of this version: {error}"
        raise ExportError(old) from None
    for gap in (item for item in items if isinstance(item, Gap) and not item.whole):
        click.echo(str(gap), err=True)
    return made, list(why)


def _write(folder: Path, made: Sequence[tuple[str, bytes]], *, quiet: bool) -> list[Path]:
    if made:
        folder.mkdir(parents=True, exist_ok=True)
    for name, content in made:
        (folder / name).write_bytes(content)
        if not quiet:
            click.echo(folder / name)
    return [folder / name for name, _ in made]


def _failed(why: str) -> SystemExit:
    click.echo(why, err=True)
    return SystemExit(2)
