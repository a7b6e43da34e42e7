"""``auvmission calibrate``: fit speed, compass, noise, buoyancy to dives with fixes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import LOGGED_VEHICLE
from mission.commands.output import write, writing

if TYPE_CHECKING:
    from mission.analysis.calibration import Calibrated


@click.command()
@click.argument("logs", nargs=-1, required=True, type=click.Path(path_type=Path, dir_okay=False))
@LOGGED_VEHICLE
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="File for the section; without it, standard output.")  # fmt: skip
@click.option("--plot", type=click.Path(path_type=Path, dir_okay=False),
              help="PNG with the errors before and after, and the compass's error.")  # fmt: skip
def calibrate(logs: tuple[Path, ...], vehicle: str | None, output: Path | None,
              plot: Path | None) -> None:  # fmt: skip
    """Fit speed, compass, current and noise from black boxes LOGS that hold fixes.

    LOGS may also be recordings (CSV) as `score` reads them, with --vehicle. Prints sections for
    the vehicle file: sensors, compass and calibration; added, if there are added sensors;
    ascent_buoyancy and ascent_measured, if a float test is among the logs. Prints their quality to
    stderr: the error at the end of each dive, before and after calibration. With two logs or more
    each log is calibrated on the others. Figures that the logs do not determine stay as in the
    vehicle file; stderr names them, and which dives would determine them. Exit 2 if the logs cannot
    be used.
    """
    from mission.analysis.calibration import CalibrationError
    from mission.analysis.lessons import kept, left_out, rise, section, taught, untaught
    from mission.analysis.recordings import RecordingError
    from mission.model.buoyancy import heavy
    from mission.model.vehicle import VehicleError
    from mission.onboard.blackbox import BlackBoxError
    from mission.onboard.serve.heard import LogError

    try:
        done = _calibrated(logs, vehicle)
    except (BlackBoxError, LogError, CalibrationError, RecordingError, VehicleError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    click.echo("dive            distance   before    after", err=True)
    for s in done.stretches:
        click.echo(
            f"{logs[s.log].name} {s.begin:.0f}-{s.end:.0f} s: {s.distance:.0f} m, "
            f"{s.before:.1f} m, {s.after:.1f} m",
            err=True,
        )
    before, after = done.percent()
    if not done.stretches:
        click.echo("no dive between two fixes: nothing proves these figures", err=True)
    how = "calibrated on the other logs" if done.held_out else "on the log it was fitted to"
    if done.stretches:
        said = f"median of distance: {before:.1f} % before, {after:.1f} % after ({how})"
        click.echo(said, err=True)
    if after > before:
        click.echo("the error has grown: keep the old figures, calibrate with more logs", err=True)
    for line in (*left_out(done, [log.name for log in logs]), *taught(done), *untaught(done)):
        click.echo(line, err=True)
    text = rise(done) + section(done.vehicle, kept(done), done.waters)
    if why := heavy(done.vehicle):
        click.echo(why, err=True)
    write(output, text)
    if plot is not None:
        from mission.analysis.drawing import draw_calibration

        with writing(plot):
            draw_calibration(done, plot)


def _calibrated(logs: tuple[Path, ...], vehicle: str | None) -> Calibrated:
    """Read the logs and fit them. Raises all errors of reading and fitting."""
    from dataclasses import replace

    from mission.analysis.calibration import calibrate as fit
    from mission.analysis.noise import of_added
    from mission.analysis.recordings import read
    from mission.analysis.teaching import calibrate_by
    from mission.model.shipped import load_vehicle
    from mission.onboard.serve.heard import read_log

    recordings = [log.suffix.lower() == ".csv" for log in logs]
    if not any(recordings):
        heard = [read_log(path) for path in logs]
        known = load_vehicle(vehicle) if vehicle else heard[0].vehicle
        done = fit([log.inputs for log in heard], known)
        added = {**known.added, **of_added([log.aids for log in heard], known)}
        return replace(done, vehicle=replace(done.vehicle, added=added))
    if not all(recordings):
        raise click.UsageError("black boxes and recordings (.csv) are given: give one kind")
    if vehicle is None:
        raise click.UsageError("no recording (.csv) says what vehicle it is: add --vehicle")
    return calibrate_by([read(path) for path in logs], load_vehicle(vehicle))
