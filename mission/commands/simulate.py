"""`auvmission simulate MISSION`: one flight in simulation, as fast as the machine can."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import AS_JSON, PARAMETERS, PROFILE, SEED, SETTINGS, VEHICLE

if TYPE_CHECKING:
    from mission.blackbox import BlackBox
    from mission.simulation.flightlog import Flight

UNREADABLE = 2
BLACK_BOX = "flight.mcap"


@click.command()
@click.argument("mission", type=click.Path(path_type=Path))
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
    profile: str,
    seed: int,
    settings: tuple[str, ...],
    parameters: tuple[str, ...],
    vehicle: str | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Fly MISSION on a simulated vehicle: the real drive, engine and codecs in one process.

    Exit 0 if the mission was completed, 1 if not, 2 if it cannot be read.
    """
    import json
    import sys

    from links.simulated.settings import SettingError, parse_settings
    from mission.prepare import Unreadable, parameters_of, prepare
    from mission.simulation.flight import fly

    try:
        prepared = prepare(mission, vehicle, parameters_of(parameters))
        sea = parse_settings(settings)
    except (Unreadable, SettingError) as error:
        click.echo(str(error), err=True)
        sys.exit(UNREADABLE)
    try:
        box = None if report is None else _black_box(report)
        flight = fly(prepared.mission, prepared.vehicle, profile, seed, sea, box)
        if box is not None and report is not None:
            box.close()
            _draw(flight, report, prepared.mission.name)
    except SettingError as error:
        click.echo(str(error), err=True)
        sys.exit(UNREADABLE)
    except OSError as error:
        click.echo(f"the report cannot be written: {error}", err=True)
        sys.exit(UNREADABLE)
    click.echo(json.dumps(flight.as_json()) if as_json else table(flight))
    sys.exit(0 if flight.outcome == "completed" else 1)


def _black_box(folder: Path) -> BlackBox:
    from mission.blackbox import BlackBox

    path = folder / BLACK_BOX
    path.unlink(missing_ok=True)
    return BlackBox(path)


def _draw(flight: Flight, folder: Path, name: str) -> None:
    from mission.simulation.plot import draw_flight

    draw_flight(flight, folder / "track.png", name)


def table(flight: Flight) -> str:
    """For people: legs, then what came of it."""
    width = max([3, *(len(leg.name) for leg in flight.legs)])
    far = f"{flight.max_range:.1f} m from home (true)"
    rows = [f"{'leg':{width}}  {'entered':>9}  {'left':>9}  {'lasted':>9}  by"]
    for leg in flight.legs:
        times = (leg.entered, leg.left, leg.left - leg.entered)
        cells = "  ".join(f"{t:7.1f} s" for t in times)
        rows.append(f"{leg.name:{width}}  {cells}  {leg.by or '(active)'}")
    error_end, error_p95 = flight.error_end, flight.error_p95
    errors = (
        "unknown"
        if error_end is None
        else f"{error_end:.1f} m at the end, 95 % below {error_p95:.1f} m"
    )
    speed = f", {flight.mission_time / flight.wall:.0f} times real time" if flight.wall else ""
    return "\n".join(
        [
            *rows,
            "",
            f"outcome           {flight.outcome}: {flight.reason}",
            f"final state       {flight.final_state}",
            f"mission           {flight.mission_time:.1f} s, digest {flight.digest[:16]}",
            f"depth, range      {flight.max_depth:.1f} m, {far}",
            f"navigation error  {errors}",
            f"flown in          {flight.wall:.2f} s{speed}",
        ]
    )
