"""`auvmission simulate MISSION`: simulate one flight, as fast as the machine can."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import (
    AS_JSON,
    BATHYMETRY,
    MISSION,
    PARAMETERS,
    PROFILE,
    SEED,
    SETTINGS,
    VEHICLE,
)
from mission.commands.seafloor import depths_of
from mission.commands.unreadable import tell_unreadable

if TYPE_CHECKING:
    from links.simulated.settings import Settings
    from mission.authoring.prepare import Prepared
    from mission.onboard.blackbox import BlackBox
    from mission.verification.simulation.flightlog import Flight
    from mission.verification.simulation.flown import Flown
    from mission.verification.simulation.seafloor import Clearance

UNREADABLE = 2
BLACK_BOX, PAGE = "flight.mcap", "report.html"


@click.command()
@click.argument("mission", type=MISSION)
@PROFILE
@SEED
@SETTINGS
@PARAMETERS
@VEHICLE
@BATHYMETRY
@click.option(
    "--report",
    type=click.Path(path_type=Path, file_okay=False),
    help="Write report.html, track.png and the black box, flight.mcap, into this folder.",
)
@AS_JSON
def simulate(
    mission: Path,
    profile: str | None,
    seed: int,
    settings: tuple[str, ...],
    parameters: tuple[str, ...],
    vehicle: str | None,
    bathymetry: Path | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Fly MISSION on a simulated vehicle: the real runtime, engine and codecs in one process.

    With --bathymetry the sea floor follows the file. Where the file has no depth, it is the floor
    that the mission assumes, else that of --set floor.

    Exit 0 if the mission was completed, 1 if not, 2 if it cannot be read, or flown at all.
    """
    import sys

    from links.simulated.settings import SettingError, parse_settings
    from mission.authoring.prepare import Unreadable, parameters_of, prepare
    from mission.verification.simulation.seafloor import clearance, over

    depths = None if bathymetry is None else depths_of(bathymetry)
    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
        sea = parse_settings(settings)
        if depths is not None:
            sea = over(sea, prepared.mission, depths)
        flight, flown = _flown(prepared, profile or "", seed, sea, settings, report)
    except Unreadable as error:
        tell_unreadable(error, as_json)
        sys.exit(UNREADABLE)
    except SettingError as error:
        click.echo(str(error), err=True)
        sys.exit(UNREADABLE)
    near = None if depths is None else clearance(flight, prepared.mission, depths)
    _tell(flight, prepared, flown, as_json, near)
    sys.exit(0 if flight.outcome == "completed" else 1)


def _flown(
    prepared: Prepared,
    profile: str,
    seed: int,
    sea: Settings,
    settings: tuple[str, ...],
    report: Path | None,
) -> tuple[Flight, Flown]:
    """Fly. Write page, black box and picture into the folder ``report``; exit 2 if they cannot be
    written. Raises SettingError."""
    from mission.verification.simulation.flight import fly
    from mission.verification.simulation.flown import Flown

    mission, vehicle = prepared.mission, prepared.vehicle
    spoken = (profile or vehicle.dialect) if vehicle.codec == "auv" else ""
    try:
        box = None if report is None else _black_box(report)
        flight = fly(mission, vehicle, profile, seed, sea, box)
        bias = flight.compass_bias
        flown = Flown(
            mission.name, vehicle.name, spoken, seed, settings, sea.sea, bias, vehicle.drives
        )
        if box is not None and report is not None:
            _report(box, flight, flown, report)
    except OSError as error:
        click.echo(f"the report cannot be written: {error}", err=True)
        raise SystemExit(UNREADABLE) from None
    return flight, flown


def _tell(
    flight: Flight, prepared: Prepared, flown: Flown, as_json: bool, near: Clearance | None
) -> None:
    import json

    from mission.verification.simulation import reaching
    from mission.verification.simulation.coverage import as_json_of, coverage_of
    from mission.verification.simulation.legtable import table

    if not as_json:
        least = [] if near is None else [near.told]
        click.echo("\n".join([table(flight, prepared.chart), *least, *flown.as_lines()]))
        return
    covered = coverage_of(flight, prepared.mission)
    reached = reaching.achieved_by(flight, prepared.mission, covered)
    told = flight.as_json() | {
        "coverage": as_json_of(covered),
        "purpose": reaching.as_json_of(reached),
        "flown": flown.as_object(),
    }
    if near is not None:
        told["clearance"] = near.as_object()
    click.echo(json.dumps(told))


def _black_box(folder: Path) -> BlackBox:
    from mission.onboard.blackbox import BlackBox

    path = folder / BLACK_BOX
    path.unlink(missing_ok=True)
    return BlackBox(path)


def _report(box: BlackBox, flight: Flight, flown: Flown, folder: Path) -> None:
    """Write black box, page and picture. Raises OSError."""
    from mission.analysis.report.dive import dives_of
    from mission.analysis.report.page import report_page
    from mission.onboard.blackbox import close_recording
    from mission.verification.simulation.plot import draw_flight

    box.close()
    close_recording(box.path, flown.as_notes())
    page = report_page(dives_of([box.path]))
    (folder / PAGE).write_text(page, encoding="utf-8")
    draw_flight(flight, folder / "track.png", flown.mission, flown.caption)
