"""``auvmission limits | time | nodes | power | rudder | output``: the operators' settings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from mission.commands.operator import TO, say
from mission.commands.options import AS_JSON

if TYPE_CHECKING:
    from collections.abc import Callable

    from mission.topside.upload import Script

ANGLES = {"ignore_unknown_options": True}  # -5 is an angle, not an option
SERVOS = {"left": 1, "right": 2, "both": 3}


@click.command()
@click.option("--radius", type=float, metavar="M", help="Greatest distance from home.")
@click.option("--time", "minutes", type=float, metavar="MIN", help="Longest autonomous running.")
@click.option("--depth", type=float, metavar="M", help="Greatest depth.")
@click.option("--voltage", type=float, metavar="V", help="Lowest voltage of the control battery.")
@TO
@AS_JSON
def limits(
    radius: float | None,
    minutes: float | None,
    depth: float | None,
    voltage: float | None,
    to: str,
    as_json: bool,
) -> None:
    """Set today's limits (@SP). Limits that are not given stay as they were.

    The tightest is in force: of these, the mission's, and the vehicle's own.
    """
    from protocol.topside_frames import MOST

    given = {
        "radius_m": radius,
        "minutes": minutes,
        "depth_m": depth,
        "low_voltage_v": voltage,
    }
    if all(value is None for value in given.values()):
        raise click.UsageError("give at least one of --radius, --time, --depth, --voltage")
    options = ("--radius", "--time", "--depth", "--voltage")
    for option, value in zip(options, given.values(), strict=True):
        if value is not None and not 0.0 < value <= MOST:
            why = f"{value:g}: a number above 0, at most {MOST}, is needed"
            raise click.BadParameter(why, param_hint=option)
    say_word(to, "SP", given, as_json)


@click.command()
@click.option("--at", metavar="YYYY-MM-DDThh:mm:ss", help="Instead of this computer's time.")
@click.option(
    "--zone", metavar="+HH:MM", help="Of the vehicle's time_zone; default: this computer's."
)
@TO
@AS_JSON
def time(at: str | None, zone: str | None, to: str, as_json: bool) -> None:
    """Set the vehicle's clock to the local time (@ST). Only time stamps use it, no decision.

    In idle only, and not by modem.
    """
    say_word(to, "ST", {"time": at or _local(zone)}, as_json)


def _local(zone: str | None) -> str:
    from datetime import UTC, datetime, timedelta, timezone

    now = datetime.now(UTC)
    if zone is None:
        return now.astimezone().strftime("%Y-%m-%dT%H:%M:%S")
    found = re.fullmatch(r"([+-])(\d\d):([0-5]\d)", zone)
    if found is None or int(found[2]) > 14:
        raise click.BadParameter(f"{zone!r}: write e.g. +08:00", param_hint="--zone")
    offset = timedelta(hours=int(found[2]), minutes=int(found[3]))
    there = timezone(-offset if found[1] == "-" else offset)
    return now.astimezone(there).strftime("%Y-%m-%dT%H:%M:%S")


@click.command()
@click.argument("changes", nargs=-1, metavar="[NAME=open|closed]...")
@TO
@AS_JSON
def nodes(changes: tuple[str, ...], to: str, as_json: bool) -> None:
    """Show which nodes are open (@NI), or open and close some (@NS).

    STM32, BDGPS, UACM, CAMERA, AUTO; the Pi is shown, too, and never closed. Closing AUTO ends a
    mission. No thruster turns by itself until AUTO is open again.
    """
    from mission.topside.switches import nodes as script
    from protocol.topside_frames import NODES

    switched = tuple(name for name in NODES if name != "Pi")  # E-T2
    wanted = _changes(changes, switched, ("open", "closed"))
    say_script(to, lambda took: script(wanted, took), as_json, "nodes")


@click.command()
@click.argument("changes", nargs=-1, metavar="[NAME=on|off]...")
@TO
@AS_JSON
def power(changes: tuple[str, ...], to: str, as_json: bool) -> None:
    """Show which devices have power (@RI), or switch some on and off (@RS).

    CTD, altimeter, BDGPS, UACM, radio, magnetometer, light; CTD and radio stay on. The nodes of
    BDGPS and UACM have to be closed first.
    """
    from mission.topside.switches import power as script
    from protocol.topside_frames import ALWAYS_ON, SENSORS

    wanted = _changes(changes, SENSORS, ("on", "off"))
    for name in (SENSORS[bit] for bit in ALWAYS_ON):
        if wanted.get(name) is False:
            raise click.UsageError(f"{name} is always on")
    say_script(to, lambda took: script(wanted, took), as_json, "power")


def _changes(
    pairs: tuple[str, ...], names: tuple[str, ...], words: tuple[str, str]
) -> dict[str, bool]:
    known, found = {name.lower(): name for name in names}, dict[str, bool]()
    for pair in pairs:
        name, _, word = pair.partition("=")
        if name.lower() not in known or word not in words:
            raise click.UsageError(
                f"{pair!r}: write NAME={words[0]} or NAME={words[1]}; names: {', '.join(names)}"
            )
        found[known[name.lower()]] = word == words[0]
    return found


@click.command(context_settings=ANGLES)
@click.argument("servo", type=click.Choice(list(SERVOS)))
@click.argument("angle", type=int, metavar="DEG")
@click.option("--step", is_flag=True, help="Turn by so much, not to it; never sent twice.")
@TO
@AS_JSON
def rudder(servo: str, angle: int, step: bool, to: str, as_json: bool) -> None:
    """Turn a rudder to DEG, -15 to 22, up positive (@D); the vehicle stays in its mode.

    Exit 0 if the Pi has the command: no frame reports that the rudder turned.
    """
    from protocol.topside_frames import RUDDER_TRAVEL

    lowest, highest = RUDDER_TRAVEL
    if not step and not lowest <= angle <= highest:
        raise click.UsageError(f"{angle} is outside {lowest}..{highest} deg")
    values = {"mode": "A" if step else "S", "servo": SERVOS[servo], "angle": angle}
    say_word(to, "D", values, as_json)


@click.command(context_settings=ANGLES)
@click.argument("name")
@click.argument("value", type=float)
@TO
@AS_JSON
def output(name: str, value: float, to: str, as_json: bool) -> None:
    """Set an output by its name in the vehicle file (@AO): a lamp, a servo, a switch.

    Refused if the mission under way or an emergency holds it, or outside its bounds. Every
    emergency makes it safe. Outputs that move or hold the vehicle work only under the stick.
    """
    number = int(value) if value.is_integer() else value
    say_word(to, "AO", {"name": name, "value": number}, as_json)


# --- a command and its answer, printed -----------------------------------------------------------


def say_word(to: str, word: str, values: Mapping[str, Any], as_json: bool) -> None:
    """Send a command and print the answer. Exit 2 if it cannot be encoded."""
    from mission.topside.underwater import PREFIX
    from mission.topside.words import command, say
    from protocol.codec import CannotEncode

    try:
        said = command(word, values)
    except CannotEncode as error:
        raise click.UsageError(str(error)) from None

    def tell(words: str) -> None:
        click.echo(words, err=True)

    under_water = to.startswith(PREFIX)
    say_script(to, lambda took: say(said, took, tell, under_water=under_water), as_json, "answer")


def say_script(
    to: str,
    script: Callable[[Callable[[Mapping[str, Any]], None]], Script],
    as_json: bool,
    name: str,
) -> None:
    """Run a script and print its result. ``as_json``: print whether it is done, the text, and under
    ``name`` the values of an answer that has some. Exit codes as in the boat's other commands."""
    from mission.topside.console import converse

    told: dict[str, Any] = {}

    def took(values: Mapping[str, Any]) -> None:
        told[name] = dict(values)

    say(lambda: converse(to, script(took)), as_json, told)
