"""``auvmission doctor``: find what has to be repaired before a dive."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mission.commands.options import AS_JSON

if TYPE_CHECKING:
    from mission.model.vehicle import Vehicle
    from mission.onboard.doctor.findings import Finding


_ON_DECK = "@ZAX0$ ends manual and stops everything. Is the vehicle on deck?"
_IN_WATER = "It will dive and turn. Is it in the water on a rope, a metre from ground and walls?"
_MEND = "mend the file; docs/operation.md lists every key"
_GIVE = (
    "give the file that serve reads, or write one (docs/operation.md has an example); "
    "without -c the defaults are examined"
)


@click.command()
@click.option(
    "-c", "--config", type=click.Path(path_type=Path), help="The configuration file of serve."
)
@click.option(
    "--ask",
    is_flag=True,
    help="Send the AUV's board one stop (@ZAX0$): its answer tells which dialect it speaks. Only "
    "without a serve, with the vehicle on deck.",
)
@click.option(
    "--signs",
    is_flag=True,
    help="Let a vehicle whose loops the Pi closes dive for 4 s and turn for 3 s, and tell whether "
    "axes and signs are as its file says. Only without a serve, in the water, on a rope.",
)
@click.option("--in-water", is_flag=True, help="The vehicle is in the water; do not ask me.")
@click.option("--on-deck", is_flag=True, help="The vehicle is on deck; do not ask me.")
@AS_JSON
def doctor(
    config: Path | None, ask: bool, signs: bool, in_water: bool, on_deck: bool, as_json: bool
) -> None:
    """Examine this Pi, its ports and the vehicle, and say what to do about each fault.

    Listens for some seconds and sends one harmless query (@RI). It does not touch the ports of a
    running serve; it judges what that serve knows instead. Exit 0, or 1 with a fault.
    """
    import json

    from mission.onboard.doctor.findings import Condition

    vehicle, is_served = _named(config)
    if ask and not on_deck and not is_served and (vehicle is None or vehicle.codec == "auv"):
        click.confirm(_ON_DECK, abort=True, err=True)
    closes = vehicle is None or vehicle.outer_loop is not None
    if signs and not in_water and not is_served and closes:
        click.confirm(_IN_WATER, abort=True, err=True)
    found: list[Finding] = []

    def take(finding: Finding) -> None:
        found.append(finding)
        if not as_json:
            _show(finding)

    for finding in _examined(config, ask, signs):
        take(finding)
    faults = sum(one.condition is Condition.FAULT for one in found)
    warnings = sum(one.condition is Condition.WARNING for one in found)
    if as_json:
        click.echo(json.dumps({"ok": not faults, "findings": [_plain(one) for one in found]}))
    else:
        click.echo(f"{_many(faults, 'fault')}, {_many(warnings, 'warning')}")
    raise SystemExit(1 if faults else 0)


def _named(config: Path | None) -> tuple[Vehicle | None, bool]:
    """The vehicle, and whether a serve has its port: then nothing is sent to it. If the vehicle is
    unknown (None), no question is left out."""
    from mission.model.diagnostics import Diagnosed
    from mission.model.shipped import load_vehicle
    from mission.onboard.configuration import load_configuration
    from mission.onboard.serve import health

    try:
        configuration = load_configuration(config)
        folder, wall = configuration.folder, time.time()
        served = health.read(folder, wall) is not None or health.mute(folder, wall) is not None
        return load_vehicle(configuration.vehicle), served
    except (Diagnosed, ImportError):
        return None, False


def _examined(config: Path | None, ask: bool, move: bool) -> Iterator[Finding]:
    """Examine. An unreadable file is a fault; the rest is as serve would start with it."""
    from mission.model.diagnostics import Diagnosed
    from mission.model.shipped import load_vehicle
    from mission.onboard.configuration import load_configuration
    from mission.onboard.doctor.doctor import examine
    from mission.onboard.doctor.findings import fault
    from mission.onboard.rates import rated
    from mission.onboard.serve.provision import Unusable, provide

    try:
        configuration = load_configuration(config)
        vehicle = load_vehicle(configuration.vehicle)
    except (Diagnosed, ImportError) as error:
        said = error.brief if isinstance(error, Diagnosed) else str(error)
        is_there = config is None or config.exists()
        yield fault("configuration", said, _MEND if is_there else _GIVE)
        try:
            got = provide(config, {}, None)
        except Unusable:
            return
        configuration, vehicle = got.configuration, got.vehicle
    yield from examine(rated(configuration, vehicle), vehicle, ask=ask, move=move)


def _many(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _show(finding: Finding) -> None:
    click.echo(f"{finding.condition.value:8} {finding.what:18} {finding.says}")
    if finding.todo:
        click.echo(f"{'':27} -> {finding.todo}")


def _plain(finding: Finding) -> dict[str, Any]:
    return {
        "what": finding.what,
        "state": finding.condition.value,
        "says": finding.says,
        "todo": finding.todo,
    }
