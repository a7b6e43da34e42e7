"""``auvmission import``: write another program's plan as a mission. Exit 0, 1, 2."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from mission.commands.options import VEHICLE_NAME
from mission.commands.output import write

if TYPE_CHECKING:
    from mission.model import Position


def _size(unit: str) -> Callable[[click.Context, click.Parameter, str | None], float | None]:
    """Return a callback that reads an option as a quantity above 0, in ``unit``."""

    def read(context: click.Context, option: click.Parameter, text: str | None) -> float | None:
        from mission.model.units import UnitError, quantity

        if text is None:
            return None
        try:
            value = quantity(text, unit)
        except UnitError as error:
            raise click.UsageError(f"{option.opts[0]}: {error}") from None
        if value <= 0.0:
            raise click.UsageError(f"{option.opts[0]}: {text} is not more than 0")
        return value

    return read


def _home(
    context: click.Context, option: click.Parameter, text: str | None
) -> Position | Literal["first"] | None:
    from mission.authoring.importing.route import Findings, number, position

    if text is None or text == "first":
        return "first" if text else None
    found = Findings("--home")
    parts = text.replace(",", " ").split()
    numbers = [number(part, "a coordinate", text, found) for part in parts]
    place = None
    if len(numbers) == 2 and None not in numbers:
        place = position(numbers[0] or 0.0, numbers[1] or 0.0, text, found)
    if place is None:
        raise click.UsageError(f"--home {text!r}: write LATITUDE,LONGITUDE in degrees, or first")
    return place


@click.command("import")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="Mission file to write; without it, standard output.")  # fmt: skip
@click.option("--home", metavar="LAT,LON|first", callback=_home,
              help="Where the vehicle starts, in degrees; first: at the first point.")  # fmt: skip
@click.option("--depth", metavar="DEPTH", callback=_size("m"),
              help="For points that have none, e.g. 5m.")  # fmt: skip
@click.option("--altitude", metavar="HEIGHT", callback=_size("m"),
              help="Instead of --depth: above the bottom.")  # fmt: skip
@click.option("--speed", metavar="SPEED", callback=_size("m/s"),
              help="For points that have none, e.g. 1m/s.")  # fmt: skip
@click.option("--gear", type=click.IntRange(1, 12), help="Instead of --speed.")
@click.option("--within", metavar="RADIUS", default="10 m", show_default=True, callback=_size("m"),
              help="How near to a point counts as there, where the file does not say.")  # fmt: skip
@click.option("--vehicle", type=VEHICLE_NAME, default="auv", show_default=True, metavar="FILE|NAME",
              help="The vehicle that the mission is for.")  # fmt: skip
@click.option("--pick", metavar="NAME", help="The route of that name, where there are several.")
@click.option("--swap", is_flag=True, help="The file has latitude and longitude exchanged.")
def import_(
    file: Path,
    output: Path | None,
    home: Position | Literal["first"] | None,
    depth: float | None,
    altitude: float | None,
    speed: float | None,
    gear: int | None,
    within: float,
    vehicle: str,
    pick: str | None,
    swap: bool,
) -> None:
    """Write FILE, a plan of another program, as a mission, and check it.

    Reads GPX routes, GeoJSON lines, KML and KMZ paths, QGroundControl .plan and WPL, Neptus .nmis
    and .nmisz, Slocum goto lists (.ma) and MOOS waypoint behaviors (.bhv). Parts without a
    counterpart are left out, and named with their line or path. Exit 0 if the mission is proved, 1
    if the check refuses it (it is written all the same), 2 if FILE cannot be imported.
    """
    from mission.authoring.importing import Findings, ImportErrors, data_of
    from mission.authoring.importing.taking import taken
    from mission.authoring.importing.writing import Answers
    from mission.model.shipped import load_vehicle
    from mission.model.vehicle import VehicleError

    try:
        boat = load_vehicle(vehicle)
        gear = boat.gear_near(speed) if speed is not None else gear
        place = None if home == "first" else home
        answers = Answers(place, home == "first", swap, depth, altitude, gear, within)
        found = taken(file, data_of(file, Findings(str(file))), answers, pick, boat)
    except (ImportErrors, VehicleError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    write(output, found.text)
    for line in found.left_out:
        click.echo(f"{file}: left out: {line}", err=True)
    raise SystemExit(_judged(found.text, str(output or "the mission"), vehicle))


def _judged(text: str, source: str, vehicle: str) -> int:
    """Check the mission and print the result to standard error. Return the exit code."""
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
