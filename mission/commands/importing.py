"""``auvmission import``: a plan of another program as a mission. Exit 0, 1, 2."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import VEHICLE_NAME

if TYPE_CHECKING:
    from mission.authoring.importing.writing import Answers
    from mission.model import Position
    from mission.model.vehicle import Vehicle


@click.command("import")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="Mission file to write; without it, standard output.")  # fmt: skip
@click.option("--home", metavar="LAT,LON|first",
              help="Where the vehicle starts, in degrees; first: at the first point.")  # fmt: skip
@click.option("--depth", metavar="DEPTH", help="For points that have none, e.g. 5m.")
@click.option("--altitude", metavar="HEIGHT", help="Instead of --depth: above the bottom.")
@click.option("--speed", metavar="SPEED", help="For points that have none, e.g. 1m/s.")
@click.option("--gear", type=click.IntRange(1, 12), help="Instead of --speed.")
@click.option("--within", metavar="RADIUS", default="10 m", show_default=True,
              help="How near to a point counts as there, where the file does not say.")  # fmt: skip
@click.option("--vehicle", type=VEHICLE_NAME, default="auv", show_default=True, metavar="FILE|NAME",
              help="The vehicle that the mission is for.")  # fmt: skip
@click.option("--pick", metavar="NAME", help="The route of that name, where there are several.")
@click.option("--swap", is_flag=True, help="The file has latitude and longitude exchanged.")
def import_(
    file: Path,
    output: Path | None,
    home: str | None,
    depth: str | None,
    altitude: str | None,
    speed: str | None,
    gear: int | None,
    within: str,
    vehicle: str,
    pick: str | None,
    swap: bool,
) -> None:
    """Write FILE, a plan of another program, as a mission, and check it.

    Reads GPX routes, GeoJSON lines, KML and KMZ paths, QGroundControl .plan and WPL, Neptus .nmis
    and .nmisz, Slocum goto lists (.ma) and MOOS waypoint behaviors (.bhv). What has no counterpart
    is named with its line or path. Exit 0 if the mission is proved, 1 if the check refuses it (it
    is written all the same), 2 if FILE cannot be taken over.
    """
    from mission.authoring.importing import Findings, ImportErrors, chosen, format_of, load
    from mission.authoring.importing.writing import mission_of
    from mission.authoring.language import to_yaml
    from mission.model.shipped import load_vehicle
    from mission.model.vehicle import VehicleError

    found = Findings(str(file))
    try:
        boat = load_vehicle(vehicle)
        answers = _answers(home, depth, altitude, speed, gear, within, swap, boat)
        source = load(file, format_of(file, found), found)
        route = chosen(source, pick, found)
        steps = route.steps()
        found.complain()
        mission = mission_of(route.name or file.stem, steps, source, answers, boat, found)
    except (ImportErrors, VehicleError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    text = "".join(f"# {line}\n" for line in _comment(file, route.name, found.left_out))
    _write(output, text + to_yaml(mission))
    for line in found.left_out:
        click.echo(f"{file}: left out: {line}", err=True)
    raise SystemExit(_judged(text + to_yaml(mission), str(output or "the mission"), vehicle))


def _answers(
    home: str | None,
    depth: str | None,
    altitude: str | None,
    speed: str | None,
    gear: int | None,
    within: str,
    swap: bool,
    vehicle: Vehicle,
) -> Answers:
    from mission.authoring.importing.writing import Answers

    if speed is not None:
        gear = vehicle.gear_near(_size("--speed", speed, "m/s"))
    return Answers(
        home=None if home in (None, "first") else _home(str(home)),
        home_first=home == "first",
        swap=swap,
        depth=None if depth is None else _size("--depth", depth, "m"),
        altitude=None if altitude is None else _size("--altitude", altitude, "m"),
        gear=gear,
        within=_size("--within", within, "m"),
    )


def _size(option: str, text: str, unit: str) -> float:
    from mission.model.units import UnitError, quantity

    try:
        value = quantity(text, unit)
    except UnitError as error:
        raise click.UsageError(f"{option}: {error}") from None
    if value <= 0.0:
        raise click.UsageError(f"{option}: {text} is not more than 0")
    return value


def _home(text: str) -> Position:
    from mission.authoring.importing.route import Findings, number, position

    found = Findings("--home")
    parts = text.replace(",", " ").split()
    numbers = [number(part, "a coordinate", text, found) for part in parts]
    place = None
    if len(numbers) == 2 and None not in numbers:
        place = position(numbers[0] or 0.0, numbers[1] or 0.0, text, found)
    if place is None:
        raise click.UsageError(f"--home {text!r}: write LATITUDE,LONGITUDE in degrees, or first")
    return place


def _comment(file: Path, route: str, left_out: tuple[str, ...]) -> list[str]:
    named = f", route {route}" if route else ""
    printable = [f"Imported from {file.name}{named}.", *(f"Left out: {line}" for line in left_out)]
    return ["".join(c if c.isprintable() else "?" for c in line) for line in printable]


def _write(output: Path | None, text: str) -> None:
    if output is None:
        click.echo(text, nl=False)
        return
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        click.echo(f"{output}: cannot be written: {error.strerror or error}", err=True)
        raise SystemExit(2) from None


def _judged(text: str, source: str, vehicle: str) -> int:
    """What the check says goes to standard error, beside the mission."""
    from mission.authoring.check.show import as_text
    from mission.authoring.prepare import Unreadable, check_prepared, prepare_text

    try:
        prepared = prepare_text(text, source, vehicle)
    except Unreadable as error:
        click.echo(str(error), err=True)
        return 1
    report = check_prepared(prepared)
    click.echo(as_text(source, report, prepared.chart.digest), err=True)
    return 0 if report.ok else 1
