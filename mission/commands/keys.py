"""``auvmission keys``: certificates, so that nobody else commands the vehicle."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--boat", "boats", multiple=True, default=("boat",), metavar="NAME",
              help="A boat that may command the vehicle; repeatable.  [default: boat]")  # fmt: skip
@click.option("--viewer", "viewers", multiple=True, metavar="NAME",
              help="Who may look at the monitor and command nothing; repeatable.")  # fmt: skip
def keys(folder: Path, boats: tuple[str, ...], viewers: tuple[str, ...]) -> None:
    """Make a small certificate authority in FOLDER, with an end for the vehicle and for each boat.

    Called again, it adds what is missing and changes nothing.
    """
    from mission.onboard.serve.keys import KeysError, make_keys

    made: list[Path] = []
    try:
        make_keys(folder, boats, made.append, viewers)
    except KeysError as error:
        click.echo(str(error), err=True)
        raise SystemExit(1) from None
    for path in made:
        click.echo(f"made {path}")
    if not made:
        click.echo(f"{folder} has them all already; nothing was changed")
        return
    click.echo(f"""
on the vehicle:  copy {folder / "vehicle"} to e.g. /etc/auvmission/keys, and configure
                 topside: tls-listen://0.0.0.0:4000?keys=/etc/auvmission/keys
on the boat:     copy {folder / boats[0]} to ~/.config/auvmission/keys, then run
                 auvmission status --to tls://VEHICLE:4000
ashore:          keep {folder / "authority"} there; it can sign further boats""")
