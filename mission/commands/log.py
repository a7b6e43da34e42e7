"""``auvmission log``: print black boxes line by line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mission.analysis.journal import Line, Wanted


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...",
                type=click.Path(path_type=Path, dir_okay=False))  # fmt: skip
@click.option("--topic", "topics", multiple=True, metavar="NAME",
              help="Of this topic (docs/reference/black-box.md has all); default: log, what "
              "happened in words. Repeatable.")  # fmt: skip
@click.option("--from", "since", type=float, default=0.0, metavar="SECONDS",
              help="From this time of the engine on.")  # fmt: skip
@click.option("--to", "until", type=float, default=float("inf"), metavar="SECONDS",
              help="Up to this time of the engine.")  # fmt: skip
@click.option("--text", default="", help="Only lines with this text in them.")
@click.option("--follow", is_flag=True, help="What comes from now on into the one FILE.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object per line.")
def log(
    files: tuple[Path, ...],
    topics: tuple[str, ...],
    since: float,
    until: float,
    text: str,
    follow: bool,
    as_json: bool,
) -> None:
    """Show what happened, from the black boxes FILES: states, commands and why, refusals.

    Each line has wall time (UTC) and the engine's time; values are decoded, by topic. Several files
    are shown in the order of their starts, with the restart between two. Gaps in a damaged file are
    shown where they are. Exit 2 if a file cannot be read.
    """
    import time

    from mission.analysis import journal
    from mission.onboard.blackbox import BlackBoxError

    if since > until:
        raise click.UsageError(f"nothing lies between --from {since:g} and --to {until:g}")
    try:
        wanted = journal.Wanted(frozenset(topics or {"log"}), since, until, text)
        if follow:
            for line in journal.follow(_only(files), wanted, time.sleep):
                _show(line, as_json)
            return
        _show_all(files, wanted, as_json)
    except (BlackBoxError, journal.UnknownTopic, ValueError, KeyError, TypeError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None


def _only(files: tuple[Path, ...]) -> Path:
    if len(files) > 1:
        raise click.UsageError("--follow takes one FILE")
    return files[0]


def _show_all(files: tuple[Path, ...], wanted: Wanted, as_json: bool) -> None:
    from itertools import pairwise

    from mission.analysis import journal

    found = journal.recordings(files)
    between = ["", *(journal.restart(one, other) for one, other in pairwise(found))]
    for items, words in zip(found, between, strict=True):
        if words:
            click.echo(words, err=as_json)
        for line in journal.lines(items, wanted):
            _show(line, as_json)


def _show(line: Line, as_json: bool) -> None:
    import json

    if as_json:
        told = {"t": line.t, "wall": line.wall, "topic": line.topic, "value": line.value}
        click.echo(json.dumps(told))
    else:
        click.echo(str(line).encode("unicode_escape").decode() if not _plain(line) else str(line))


def _plain(line: Line) -> bool:
    """Whether the line has no control characters, which could change the terminal."""
    return str(line).isprintable()
