"""``auvmission upload | start | clear | status | stop | surface``, sent to a Pi."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mission.commands.options import AS_JSON, MISSION, PARAMETERS, VEHICLE, LinkUrl
from mission.commands.unreadable import tell_unreadable

if TYPE_CHECKING:
    from mission.authoring.check import Proved
    from mission.authoring.prepare import Prepared
    from mission.topside.dives import Dives
    from mission.topside.looking import Looked
    from mission.topside.upload import Script
    from protocol.messages import Order

ALARM = 4  # exit code: the vehicle answers, and an alarm stands
TO = click.option(
    "--to",
    type=LinkUrl(),
    default="tcp://127.0.0.1:4000",
    show_default=True,
    metavar="URL",
    help="Where the vehicle's Pi listens.",
)


@click.command()
@click.argument("mission", type=MISSION)
@TO
@click.option("--force", is_flag=True, help="Although the check refuses it (the Pi decides).")
@PARAMETERS
@VEHICLE
@AS_JSON
def upload(
    mission: Path,
    to: str,
    force: bool,
    parameters: tuple[str, ...],
    vehicle: str | None,
    as_json: bool,
) -> None:
    """Check MISSION and store it in the vehicle, line by line; continues an interrupted upload.

    Over an acoustic modem (modem+serial:///dev/ttyUSB0?range=800&rate=600: m, bit/s) the lines are
    sent in batches, and only missing lines are sent again.

    Exit 0 if the vehicle holds it, by its digest; 1 if not; 2 if MISSION cannot be read.
    """
    from mission.authoring.language import script
    from mission.authoring.prepare import Unreadable, parameters_of, prepare
    from mission.topside import console
    from mission.topside.overdue import plan_of

    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
    except Unreadable as error:
        tell_unreadable(error, as_json)
        raise SystemExit(1 if error.refused else 2) from None
    proved = _refuse_unchecked(prepared, force, as_json)
    lines = script(prepared.mission)
    say(lambda: console.upload(to, lines, prepared.chart.digest, _Progress(lines).show), as_json)
    if proved is not None:
        _remembered().uploaded(prepared.chart.digest, plan_of(prepared, proved))


def _remembered() -> Dives:
    from mission.topside.dives import Dives, default_folder

    return Dives(default_folder())


def _refuse_unchecked(prepared: Prepared, force: bool, as_json: bool) -> Proved | None:
    """Return what the check proved; with ``--force`` None if it refuses. Otherwise exit 1."""
    from mission.authoring.check.show import as_object, as_text
    from mission.authoring.prepare import check_prepared

    report = check_prepared(prepared)
    if report.ok:
        return report.proved
    click.echo(as_text(prepared.source, report, prepared.chart.digest), err=True)
    if not force:
        click.echo("not uploaded: mend it, or take --force if you know better", err=True)
        if as_json:
            click.echo(json.dumps(as_object(report)))
        raise SystemExit(1)
    click.echo("uploaded in spite of the check (--force)", err=True)
    return report.proved


class _Progress:
    """Print each mission line when the vehicle has it."""

    def __init__(self, lines: list[str]) -> None:
        self._lines, self._shown = lines, 0

    def show(self, have: int, total: int) -> None:
        if have > self._shown:
            width = len(str(total))
            click.echo(f"{have:{width}}/{total}  {self._lines[have - 1]}", err=True)
            self._shown = have


@click.command()
@TO
@click.option(
    "--wait",
    type=click.IntRange(0),
    default=0,
    metavar="SECONDS",
    help="Ask again so long while it refuses.",
)
@AS_JSON
def start(to: str, wait: int, as_json: bool) -> None:
    """Start the stored mission, or resume the interrupted one (@AA)."""
    from mission.topside.upload import start_telling

    def began(digest: str) -> None:
        _remembered().started(to, digest, time.time())

    _converse(to, start_telling(began, wait), as_json)


@click.command()
@TO
@AS_JSON
def clear(to: str, as_json: bool) -> None:
    """Clear the stored mission, and a latched emergency at the surface (@AC)."""
    from mission.topside.upload import clear as talk

    _converse(to, talk(), as_json)


@click.command()
@TO
@AS_JSON
def stop(to: str, as_json: bool) -> None:
    """Stop all thrusters, at once and from any state (@ZAX0).

    Then it reads reports for some seconds. Exit 0 if one shows every thruster off; 3 if the command
    was sent and nothing confirms it; 1 if reports contradict it, or it is unknown whether the
    command arrived.
    """
    from protocol.messages import Order

    _order(to, Order.STOP, as_json)


@click.command()
@TO
@AS_JSON
def surface(to: str, as_json: bool) -> None:
    """Surface, at once and from any state (@ZAWF).

    Then it reads reports for up to a minute. Exit 0 if one shows the surface, or a depth that has
    decreased by 0.5 m, and the vehicle's program believes it; 3 if the command was sent and nothing
    confirms it; 1 if the depth does not decrease, or it is unknown whether the command arrived.
    """
    from protocol.messages import Order

    _order(to, Order.SURFACE, as_json)


@click.command()
@TO
@click.option("--json", "as_json", is_flag=True, help="One object on stdout.")
@click.option("--local", is_flag=True, help="On the Pi itself: all that serve knows of its health.")
@click.option("-c", "--config", type=click.Path(path_type=Path), help="As for serve; for --local.")
def status(to: str, as_json: bool, local: bool, config: Path | None) -> None:
    """Show the state of the vehicle (@AE), its report (@DU) and its store (@AQ).

    Each value has its age. Exit 0 if nothing is wrong, 4 if an alarm stands; 1 if the vehicle does
    not answer.
    """
    from mission.topside.looking import look
    from mission.topside.showing import alarms_in, contact_of
    from mission.topside.underwater import PREFIX

    if local:
        _status_here(config, as_json)
        return
    found: list[Looked] = []
    try:
        _converse(to, look(found.append, under_water=to.startswith(PREFIX), now=time.monotonic))
    except SystemExit:
        _show_silence(to, as_json)
        raise
    boat = _remembered()
    boat.contact(to, contact_of(found[0], time.time()))
    _show(found[0], boat.of(to).due, as_json)
    if alarms_in(found[0]):
        raise SystemExit(ALARM)


def _show_silence(to: str, as_json: bool) -> None:
    """Print what the boat knows of a vehicle that does not answer."""
    from mission.model.alarms import Condition, standing
    from mission.topside.dives import missing
    from mission.topside.overdue import silent_for

    boat, now = _remembered(), time.time()
    late, dive = missing(boat.missed(to, now), to, now), boat.of(to)
    found = standing(Condition(silent=silent_for(dive, now), overdue=late))
    if as_json:
        alarms = [asdict(alarm) for alarm in found]
        click.echo(json.dumps({"alarms": alarms, "up_by": dive.due}))
        return
    click.echo("\n".join(f"ALARM {alarm}" for alarm in found))
    _show_due(dive.due)


def _show(looked: Looked, up_by: float | None, as_json: bool) -> None:
    """Print the status. ``up_by``: s since 1970 UTC, from the boat's records."""
    from mission.topside.showing import as_lines, as_object

    if as_json:
        click.echo(json.dumps({**as_object(looked), "up_by": up_by}))
        return
    click.echo("\n".join(as_lines(looked)))
    _show_due(up_by)


def _show_due(up_by: float | None) -> None:
    from mission.topside.overdue import moment

    if up_by is not None:
        click.echo(f"{'up by':12} {moment(up_by, time.time())}")


def _status_here(config: Path | None, as_json: bool) -> None:
    """Print what the documents' frames do not carry: margins, links, black box."""
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
            else f"serve (process {mute}) runs, but has not told of its health: is {folder} full, "
            "or read-only?"
        )
        click.echo(why, err=True)
        raise SystemExit(1)
    click.echo(json.dumps(found) if as_json else "\n".join(health.as_lines(found, wall)))
    if found["alarms"]:
        raise SystemExit(ALARM)


def _order(to: str, which: Order, as_json: bool) -> None:
    import functools

    from mission.topside.orders import order
    from mission.topside.underwater import PREFIX

    tell = functools.partial(click.echo, err=True)
    _converse(to, order(which, tell, under_water=to.startswith(PREFIX)), as_json)


def _converse(to: str, script: Script, as_json: bool = False) -> None:
    from mission.topside.console import converse

    say(lambda: converse(to, script), as_json)


def say(
    talk: Callable[[], str], as_json: bool = False, values: Mapping[str, Any] | None = None
) -> None:
    """Run a conversation and print its result. A failure goes to stderr with exit 1; 3 if the
    command was sent but is not confirmed. ``as_json``: print one object in either case, with the
    ``values`` of an answer, which ``talk`` has put there."""
    from mission.topside.orders import Unconfirmed
    from mission.topside.upload import OperatorError, Refused

    code, prefix = 0, ""
    try:
        says = talk()
    except OperatorError as error:
        prefix = "refused: " if isinstance(error, Refused) else ""
        code, says = 3 if isinstance(error, Unconfirmed) else 1, str(error)
    except KeyboardInterrupt:
        click.echo("what was asked last may or may not have been done", err=True)
        raise
    if as_json:
        click.echo(json.dumps({"ok": code == 0, "says": says} | dict(values or {})))
    elif says:
        click.echo(f"{prefix}{says}", err=code != 0)
    if code:
        raise SystemExit(code)
