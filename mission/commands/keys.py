"""``auvmission keys``: make certificates, so that nobody else can command the vehicle."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mission.commands.options import AS_JSON


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--boat", "boats", multiple=True, metavar="NAME",
              help="A boat that may command the vehicle; repeatable.  [default: boat, "
                   "and with --viewer none]")  # fmt: skip
@click.option("--viewer", "viewers", multiple=True, metavar="NAME",
              help="Who may look at the monitor and command nothing; repeatable.")  # fmt: skip
@AS_JSON
def keys(folder: Path, boats: tuple[str, ...], viewers: tuple[str, ...], as_json: bool) -> None:
    """Make a certificate authority in FOLDER, and keys for the vehicle, each boat and each viewer.

    Called again, it adds what is missing and changes nothing else.
    """
    from mission.onboard.serve.keys import KeysError, make_keys

    made: list[Path] = []
    boats = boats or (() if viewers else ("boat",))
    try:
        make_keys(folder, boats, made.append, viewers)
    except KeysError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    if as_json:
        click.echo(json.dumps({"made": [str(path) for path in made]}))
        return
    for path in made:
        click.echo(f"made {path}")
    if not made:
        click.echo(f"{folder} has them all already; nothing was changed")
        return
    if boats:
        _tell(folder, "topside", 4000, "on the boat:", boats[0], "status --to")
    if viewers:
        _tell(folder, "monitor", 4001, "who looks on:", viewers[0], "monitor")
    click.echo(f"ashore:          keep {folder / 'authority'} there; it can sign more")


def _tell(folder: Path, link: str, port: int, who: str, end: str, command: str) -> None:
    """Print where to copy the folders, and what to configure and run there."""
    click.echo(f"""
on the vehicle:  copy {folder / "vehicle"} to e.g. /etc/auvmission/keys, and configure
                 {link}: tls-listen://0.0.0.0:{port}?keys=/etc/auvmission/keys
{who:15}  copy {folder / end} to ~/.config/auvmission/keys, then run
                 auvmission {command} tls://VEHICLE:{port}""")
