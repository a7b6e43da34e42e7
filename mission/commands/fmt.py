"""``auvmission fmt``: lay out mission files tidily, with their comments."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import click

from mission.commands.options import AS_JSON


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...",
                type=click.Path(path_type=Path))  # fmt: skip
@click.option("--check", "only_check", is_flag=True, help="Change nothing; exit 1 if it would.")
@click.option("--stdout", is_flag=True, help="Print the result and leave the file alone.")
@AS_JSON
def fmt(files: tuple[Path, ...], only_check: bool, stdout: bool, as_json: bool) -> None:
    """Lay out mission FILEs tidily, in place: indentation, blanks, aligned comments.

    Words, numbers, comments and the mission's digest do not change. A file with errors is not
    changed (exit 2). With --check or --stdout a FILE may also be the bare name of a shipped
    mission.
    """
    from mission.authoring.prepare import mission_file
    from mission.model.diagnostics import Diagnosed

    if stdout and as_json:
        raise click.UsageError("--stdout prints the mission, --json what became of it: take one")
    if not (only_check or stdout):
        _refuse_shipped(files)
    changed, refusals = [], list[dict[str, object]]()
    for path in files:
        try:
            if _laid_out(mission_file(path), only_check, stdout):
                changed.append(path)
        except Diagnosed as error:
            click.echo(str(error), err=True)
            refusals += [found.as_object() for found in error.diagnostics]
    for path in changed:
        click.echo(f"{path}: {'would be laid out' if only_check else 'laid out'}", err=True)
    if as_json:
        click.echo(json.dumps({"changed": [str(path) for path in changed], "refusals": refusals}))
    if refusals or (only_check and changed):
        raise SystemExit(2 if refusals else 1)


def _refuse_shipped(files: Iterable[Path]) -> None:
    """Refuse bare names of shipped missions: these files are not to be changed."""
    from mission.model.shipped import shipped_missions

    for path in files:
        if str(path) in shipped_missions() and not path.exists():
            why = f"{path} is a shipped mission, and FILE is laid out in place"
            raise click.UsageError(f"{why}: add --stdout or --check, or name a file of your own")


def _laid_out(path: Path, only_check: bool, stdout: bool) -> bool:
    """Lay out one file. Return whether it is, or would be, changed."""
    from mission.authoring.importing.places import beside
    from mission.authoring.language import digest, layout, load, parse

    mission = load(path, files=beside(path))
    before = path.read_bytes().decode("utf-8")
    after = layout.formatted(before, str(path))
    if digest(parse(after, str(path), files=beside(path))) != digest(mission):
        raise click.ClickException(f"{path}: left alone: laying it out would change the mission")
    if stdout:
        click.echo(after, nl=False)
        return False
    if after == before:
        return False
    if not only_check:
        _replace(path, after)
    return True


def _replace(path: Path, text: str) -> None:
    """Replace the file, whole or not at all."""
    beside = path.with_name(f".{path.name}.new")
    try:
        beside.write_bytes(text.encode("utf-8"))
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise click.ClickException(f"{path}: cannot be written: {error.strerror}") from None
