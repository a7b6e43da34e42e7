"""``auvmission water``: simulate the acoustic channel between two processes."""

from __future__ import annotations

import signal
from pathlib import Path

import click

from mission.commands.options import AS_JSON, SEED

_SHARE = click.FloatRange(0.0, 1.0)


@click.command()
@click.option("--range", "range_m", type=click.FloatRange(0.0, 1e5, min_open=True), default=1000.0,
              show_default=True, metavar="M", help="Slant range between the modems.")  # fmt: skip
@click.option("--rate", type=click.FloatRange(1.0, 1e6), default=1000.0, show_default=True,
              metavar="BIT/S", help="Bit rate on the water.")  # fmt: skip
@click.option("--preamble", type=click.FloatRange(0.0, 60.0), default=0.0, show_default=True,
              metavar="SECONDS", help="What a modem sends before the data.")  # fmt: skip
@click.option("--loss", type=_SHARE, default=0.0, show_default=True,
              help="Share of bursts that vanish.")  # fmt: skip
@click.option("--errors", type=_SHARE, default=0.0, show_default=True,
              help="Share of bits that are wrong.")  # fmt: skip
@SEED
@click.option("--folder", type=click.Path(path_type=Path, file_okay=False),
              default=Path("out/water"), show_default=True,
              help="Where the two modems are plugged in.")  # fmt: skip
@AS_JSON
def water(
    range_m: float,
    rate: float,
    preamble: float,
    loss: float,
    errors: float,
    seed: int,
    folder: Path,
    as_json: bool,
) -> None:
    """Simulate two acoustic modems and the water between them, in real time.

    FOLDER/boat is the boat's modem, FOLDER/vehicle the one for links.modem of serve. Half duplex: a
    modem that sends receives nothing. Prints sender and size of each burst. Ctrl-C ends it and
    prints the totals.
    """
    import json

    from links.acoustic import Water
    from links.simulated.process import told_to_end
    from links.simulated.water import ENDS, Channel

    def told(name: str, size: int, airtime: float) -> None:
        click.echo(f"{name:8} {size:5} bytes, {airtime:6.2f} s on the water", err=True)

    channel = Channel(Water(range_m, rate, loss, errors, preamble), seed, told)
    places = {name: folder.resolve() / name for name in ENDS}
    _plug(places, channel.paths)
    boat = f"modem+serial://{places['boat']}?range={range_m:.12g}&rate={rate:.12g}"
    modem = f"serial://{places['vehicle']}"
    if as_json:
        click.echo(json.dumps({"boat": boat, "vehicle": modem}))
    else:
        click.echo(f"the vehicle's configuration: links: {{modem: '{modem}', ...}}")
        click.echo(f"  auvmission status --to '{boat}'")
    ended = told_to_end()
    with channel:
        channel.run(lambda: bool(ended))
    for place in places.values():
        place.unlink(missing_ok=True)
    for name, tally in channel.tallies.items():
        click.echo(
            f"{name:8} {tally.bursts} bursts, {tally.size} bytes: {tally.lost} lost, "
            f"{tally.collided} collided, {tally.damaged} damaged",
            err=True,
        )
    if ended[0] == signal.SIGINT:
        raise KeyboardInterrupt


def _plug(places: dict[str, Path], paths: tuple[str, ...]) -> None:
    try:
        for place, path in zip(places.values(), paths, strict=True):
            place.parent.mkdir(parents=True, exist_ok=True)
            place.unlink(missing_ok=True)
            place.symlink_to(path)
    except OSError as error:
        raise click.UsageError(f"{error.filename}: {error.strerror or error}") from None
