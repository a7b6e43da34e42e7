"""``auvmission upload | start | clear | status | stop | surface`` towards a Pi."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from mission.authoring.prepare import Prepared
    from mission.topside.looking import Looked
    from mission.topside.upload import Script
    from protocol.messages import Order

TO = click.option(
    "--to",
    default="tcp://127.0.0.1:4000",
    show_default=True,
    metavar="URL",
    help="Where the vehicle's Pi listens.",
)


@click.command()
@click.argument("mission", type=click.Path(path_type=Path))
@TO
@click.option("--force", is_flag=True, help="Although the check refuses it (the Pi decides).")
@click.option("--param", "parameters", multiple=True, metavar="NAME=VALUE", help="Set a parameter.")
@click.option("--vehicle", help="Vehicle file or name; default: the one the mission names.")
def upload(
    mission: Path, to: str, force: bool, parameters: tuple[str, ...], vehicle: str | None
) -> None:
    """Check MISSION and store it in the vehicle, line by line; an upload that was cut goes on.

    Over an acoustic modem (modem+serial:///dev/ttyUSB0?range=800&rate=600: m, bit/s) it goes in
    batches, and only what is missing goes again.

    Exit 0 when the vehicle holds it, by its digest; 1 if not; 2 if it cannot be read.
    """
    from mission.authoring.language import script
    from mission.authoring.prepare import Unreadable, parameters_of, prepare
    from mission.topside import console

    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
    except Unreadable as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    _refuse_unchecked(prepared, force)
    lines = script(prepared.mission)
    say(lambda: console.upload(to, lines, prepared.chart.digest, _Progress(lines).show))


def _refuse_unchecked(prepared: Prepared, force: bool) -> None:
    from mission.authoring.check.show import as_text
    from mission.authoring.prepare import check_prepared

    report = check_prepared(prepared)
    if report.ok:
        return
    click.echo(as_text(prepared.source, report, prepared.chart.digest), err=True)
    if not force:
        click.echo("not uploaded: mend it, or take --force if you know better", err=True)
        raise SystemExit(1)
    click.echo("uploaded in spite of the check (--force)", err=True)


class _Progress:
    """A line per mission line that the vehicle has."""

    def __init__(self, lines: list[str]) -> None:
        self._lines, self._shown = lines, 0

    def show(self, have: int, total: int) -> None:
        if have > self._shown:
            width = len(str(total))
            click.echo(f"{have:{width}}/{total}  {self._lines[have - 1]}", err=True)
            self._shown = have


@click.command()
@TO
@click.option("--wait", default=0, metavar="SECONDS", help="Ask again so long while it refuses.")
def start(to: str, wait: int) -> None:
    """Start the stored mission, or go on with the interrupted one (@AA)."""
    from mission.topside.upload import start as talk

    _converse(to, talk(wait))


@click.command()
@TO
def clear(to: str) -> None:
    """Clear the stored mission, and a latched emergency at the surface (@AC)."""
    from mission.topside.upload import clear as talk

    _converse(to, talk())


@click.command()
@TO
def stop(to: str) -> None:
    """Stop all thrusters, at once and from any state (@ZAX0).

    Then some seconds of reports are looked at. Exit 0 when one shows every thruster off; 3 when it
    was sent and nothing confirms it; 1 when reports contradict it, or it is not known to have
    arrived.
    """
    from protocol.messages import Order

    _order(to, Order.STOP)


@click.command()
@TO
def surface(to: str) -> None:
    """Surface, at once and from any state (@ZAWF).

    Then reports are looked at for up to a minute. Exit 0 when one shows the surface, or a depth
    that has fallen by 0.5 m; 3 when it was sent and nothing confirms it; 1 when the depth does not
    fall, or it is not known to have arrived.
    """
    from protocol.messages import Order

    _order(to, Order.SURFACE)


@click.command()
@TO
@click.option("--json", "as_json", is_flag=True, help="One object on stdout.")
@click.option("--local", is_flag=True, help="On the Pi itself: all that serve knows of its health.")
@click.option("-c", "--config", type=click.Path(path_type=Path), help="As for serve; for --local.")
def status(to: str, as_json: bool, local: bool, config: Path | None) -> None:
    """What the vehicle tells of itself (@DU) and of its store (@AQ).

    Looks again for some seconds: "reports" and "position" say whether what is shown is new.
    """
    import json

    from mission.topside.looking import look
    from mission.topside.underwater import PREFIX

    if local:
        _status_here(config, as_json)
        return
    found: dict[str, Any] = {}

    def took(looked: Looked) -> None:
        found.update(_values(looked))

    _converse(to, look(took, under_water=to.startswith(PREFIX)))
    if as_json:
        click.echo(json.dumps(found))
        return
    for name, value in found.items():
        if value not in (None, ""):
            click.echo(f"{name:12} {value}")


def _status_here(config: Path | None, as_json: bool) -> None:
    """Beyond what the frames of the documents carry: margins, links, black box."""
    import json
    import time

    from mission.onboard.configuration import ConfigurationError, load_configuration
    from mission.onboard.serve import health

    try:
        folder = load_configuration(config).folder
    except ConfigurationError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    wall = time.time()
    found = health.read(folder, wall)
    if found is None:
        mute = health.mute(folder, wall)
        why = (
            f"no serve is running with the folder {folder}"
            if mute is None
            else f"serve (process {mute}) runs, but has not told of its health: is {folder} full?"
        )
        click.echo(why, err=True)
        raise SystemExit(1)
    if as_json:
        click.echo(json.dumps(found))
        return
    for row in health.as_lines(found, wall):
        click.echo(row)


def _values(looked: Looked) -> dict[str, Any]:
    from mission.topside.console import degrees

    told, store = looked.last, looked.store
    fix, own = told.fix, told.telemetry
    batteries = own.batteries if own is not None and own.batteries else (None, None)
    return {
        "time": told.time,
        "reports": looked.reports,
        "position": looked.position,
        "latitude": degrees(fix.latitude, 7) if fix else None,
        "longitude": degrees(fix.longitude, 7) if fix else None,
        "depth_m": own.depth if own else None,
        "altitude_m": own.altitude if own else None,
        "heading_deg": degrees(own.heading, 1) if own else None,
        "pitch_deg": degrees(own.pitch, 1) if own else None,
        "roll_deg": degrees(own.roll, 1) if own else None,
        "battery_v": batteries[0],
        "power_v": batteries[1],
        "store": store.state if store else None,
        "lines": f"{store.have} of {store.total}" if store and store.total else None,
        "missing": store.missing if store else None,
        "digest": store.digest if store else None,
        "refusal": store.refusal if store else None,
    }


def _order(to: str, which: Order) -> None:
    import functools

    from mission.topside.orders import order
    from mission.topside.underwater import PREFIX

    tell = functools.partial(click.echo, err=True)
    _converse(to, order(which, tell, under_water=to.startswith(PREFIX)))


def _converse(to: str, script: Script) -> None:
    from mission.topside.console import converse

    say(lambda: converse(to, script))


def say(talk: Callable[[], str]) -> None:
    """What a conversation achieved; what failed goes to stderr with exit 1, or 3 where nothing is
    known to have failed."""
    from mission.topside.orders import Unconfirmed
    from mission.topside.upload import OperatorError, Refused

    try:
        achieved = talk()
    except OperatorError as error:
        prefix = "refused: " if isinstance(error, Refused) else ""
        click.echo(f"{prefix}{error}", err=True)
        raise SystemExit(3 if isinstance(error, Unconfirmed) else 1) from None
    except KeyboardInterrupt:
        click.echo("what was asked last may or may not have been done", err=True)
        raise
    if achieved:
        click.echo(achieved)
