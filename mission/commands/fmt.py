"""``auvmission fmt``: the tidy layout of mission files, comments kept."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...",
                type=click.Path(path_type=Path))  # fmt: skip
@click.option("--check", "only_check", is_flag=True, help="Change nothing; exit 1 if it would.")
@click.option("--stdout", is_flag=True, help="Print the result and leave the file alone.")
def fmt(files: tuple[Path, ...], only_check: bool, stdout: bool) -> None:
    """Lay out mission FILEs tidily, in place: indentation, blanks, comments in line.

    Words, numbers and comments stay as they are, and so does the mission's digest. A file with
    errors is left as it is (exit 2).
    """
    from mission.authoring.language import MissionErrors

    changed, unreadable = [], False
    for path in files:
        try:
            if _laid_out(path, only_check, stdout):
                changed.append(path)
        except MissionErrors as error:
            click.echo(str(error), err=True)
            unreadable = True
    for path in changed:
        click.echo(f"{path}: {'would be laid out' if only_check else 'laid out'}", err=True)
    if unreadable or (only_check and changed):
        raise SystemExit(2 if unreadable else 1)


def _laid_out(path: Path, only_check: bool, stdout: bool) -> bool:
    """True if the file is, or would be, changed."""
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
    """Whole or not at all."""
    beside = path.with_name(f".{path.name}.new")
    try:
        beside.write_bytes(text.encode("utf-8"))
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise click.ClickException(f"{path}: cannot be written: {error.strerror}") from None
