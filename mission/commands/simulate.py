"""`auvmission simulate MISSION`: one flight in simulation, as fast as the machine can."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import AS_JSON, MISSION, PARAMETERS, PROFILE, SEED, SETTINGS, VEHICLE
from mission.commands.unreadable import tell_unreadable

if TYPE_CHECKING:
    from mission.onboard.blackbox import BlackBox
    from mission.verification.simulation.flightlog import Flight

UNREADABLE = 2
BLACK_BOX = "flight.mcap"


@click.command()
@click.argument("mission", type=MISSION)
@PROFILE
@SEED
@SETTINGS
@PARAMETERS
@VEHICLE
@click.option(
    "--report",
    type=click.Path(path_type=Path, file_okay=False),
    help="Write track.png and the black box, flight.mcap, into this folder.",
)
@AS_JSON
def simulate(
    mission: Path,
    profile: str | None,
    seed: int,
    settings: tuple[str, ...],
    parameters: tuple[str, ...],
    vehicle: str | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Fly MISSION on a simulated vehicle: the real runtime, engine and codecs in one process.

    Exit 0 if the mission was completed, 1 if not, 2 if it cannot be read.
    """
    import json
    import sys

    from links.simulated.settings import SettingError, parse_settings
    from mission.authoring.prepare import Unreadable, parameters_of, prepare
    from mission.onboard.blackbox import close_recording
    from mission.verification.simulation import reaching
    from mission.verification.simulation.coverage import as_json_of, coverage_of
    from mission.verification.simulation.flight import fly
    from mission.verification.simulation.flown import Flown
    from mission.verification.simulation.legtable import table

    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
        sea = parse_settings(settings)
    except Unreadable as error:
        tell_unreadable(error, as_json)
        sys.exit(UNREADABLE)
    except SettingError as error:
        click.echo(str(error), err=True)
        sys.exit(UNREADABLE)
    try:
        box = None if report is None else _black_box(report)
        flight = fly(prepared.mission, prepared.vehicle, profile or "", seed, sea, box)
        if box is not None and report is not None:
            box.close()
            notes = {"seed": str(seed), "sea": " ".join(settings), "mission": prepared.mission.name}
            close_recording(box.path, notes | {"simulated": profile or prepared.vehicle.dialect})
            _draw(flight, report, prepared.mission.name)
    except SettingError as error:
        click.echo(str(error), err=True)
        sys.exit(UNREADABLE)
    except OSError as error:
        click.echo(f"the report cannot be written: {error}", err=True)
        sys.exit(UNREADABLE)
    auv = prepared.vehicle.codec == "auv"
    flown = Flown(
        prepared.mission.name,
        prepared.vehicle.name,
        (profile or prepared.vehicle.dialect) if auv else "",
        seed,
        settings,
        sea.sea,
        flight.compass_bias,
    )
    if as_json:
        told = flight.as_json() | {
            "coverage": as_json_of(coverage_of(flight, prepared.mission)),
            "purpose": reaching.as_json_of(reaching.achieved_by(flight, prepared.mission)),
            "flown": flown.as_object(),
        }
        click.echo(json.dumps(told))
    else:
        click.echo("\n".join([table(flight, prepared.chart), *flown.as_lines()]))
    sys.exit(0 if flight.outcome == "completed" else 1)


def _black_box(folder: Path) -> BlackBox:
    from mission.onboard.blackbox import BlackBox

    path = folder / BLACK_BOX
    path.unlink(missing_ok=True)
    return BlackBox(path)


def _draw(flight: Flight, folder: Path, name: str) -> None:
    from mission.verification.simulation.plot import draw_flight

    draw_flight(flight, folder / "track.png", name)
