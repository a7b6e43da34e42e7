"""``auvmission demo``: fly one mission with three processes; results are in out/demo/."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.options import MISSION, PROFILE, SEED, SETTINGS, VEHICLE
from mission.commands.output import make_folder

if TYPE_CHECKING:
    from mission.authoring.prepare import Prepared
    from mission.verification.simulation.demo import Demo, Progress
    from mission.verification.simulation.flightlog import Flight

OWN = {
    "coreboard": "coreboard-dive",
    "mainboard": "rov-dive",  # by thrust and time: nothing is held until its signs are confirmed
    "rov": "rov-dive",
    "robot": "robot-drive",
}


@click.command()
@click.argument("mission", type=MISSION, required=False)
@click.option("--speed", type=click.FloatRange(0.1, 20.0), default=8.0, show_default=True,
              help="Times real time; beyond about 10 answers miss their 300 ms.")  # fmt: skip
@PROFILE
@SEED
@SETTINGS
@VEHICLE
@click.option("--out", type=click.Path(path_type=Path, file_okay=False),
              default=Path("out/demo"), show_default=True,
              help="For pictures, logs and black box; an earlier demo's are removed.")  # fmt: skip
def demo(
    mission: Path | None,
    speed: float,
    profile: str | None,
    seed: int,
    settings: tuple[str, ...],
    vehicle: str | None,
    out: Path,
) -> None:
    """Fly MISSION with serve and a simulated vehicle, over real bytes.

    Without MISSION: first-dive, coreboard-dive, rov-dive or robot-drive, as fits the vehicle.

    Exit 0 only if the vehicle surfaced, the mission completed and every leg ended as planned.
    """
    from dataclasses import replace

    from mission.verification.rig.vehicle import in_dialect
    from mission.verification.simulation.demo import LEFT, Demo, not_as_planned

    path = mission or Path(OWN.get(vehicle or "", "first-dive"))
    prepared, worst = _proved(path, vehicle, settings)
    clear_earlier(out, LEFT)
    make_folder(out)
    click.echo(f"{path}: at most {worst / 60:.1f} min of mission, {speed:g} times real time")
    shown, prepared = Shown(), replace(prepared, vehicle=in_dialect(prepared.vehicle, profile))
    named = vehicle or prepared.mission.vehicle
    demonstration = Demo(prepared, out, speed, named, seed, settings, worst, click.echo, shown.show)
    flight = _flown(demonstration, shown, out)
    _leave(flight, prepared, out, demonstration)
    amiss = not_as_planned(flight)
    if amiss:
        click.echo(f"not as planned: {'; '.join(amiss)}", err=True)
    raise SystemExit(1 if amiss else 0)


def _proved(path: Path, vehicle: str | None, settings: tuple[str, ...]) -> tuple[Prepared, float]:
    """The mission, and its longest duration, s. Exit 2 if it cannot be read, 1 if refused."""
    from links.simulated.settings import SettingError, parse_settings
    from mission.authoring.prepare import Unreadable, check_prepared, prepare

    try:
        prepared = prepare(path, vehicle)
        parse_settings(settings)
    except (Unreadable, SettingError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    report = check_prepared(prepared)
    if not report.ok or report.proved is None:
        click.echo(f"{path}: refused by the check; see auvmission check {path}", err=True)
        raise SystemExit(1)
    return prepared, report.proved.worst_time


def _flown(demonstration: Demo, shown: Shown, out: Path) -> Flight:
    from mission.topside.upload import OperatorError
    from mission.verification.simulation.staged import DemoError

    try:
        return demonstration.fly()
    except (DemoError, OperatorError) as error:
        why = str(error)
    except OSError as error:
        why = f"{error.filename or out}: {error.strerror or error}"
    finally:
        shown.end()
    click.echo(why, err=True)
    raise SystemExit(1)


def _leave(flight: Flight, prepared: Prepared, out: Path, flown: Demo) -> None:
    """Write the page and the pictures, and print the table of the legs."""
    from links.simulated.settings import parse_settings
    from mission.analysis.report.dive import dives_of
    from mission.analysis.report.page import report_page
    from mission.authoring.graph.outline import outline
    from mission.authoring.graph.svg import svg
    from mission.verification.simulation.flown import Flown
    from mission.verification.simulation.legtable import table
    from mission.verification.simulation.plot import draw_flight

    (out / "graph.svg").write_text(svg(outline(prepared.chart, None), False))
    click.echo(table(flight, prepared.chart))
    box = max((out / "pi" / "log").glob("*.mcap"))
    sea = parse_settings(flown.settings).sea
    vehicle = prepared.vehicle
    dialect = vehicle.dialect if vehicle.codec == "auv" else ""
    told = Flown(
        prepared.mission.name, vehicle.name, dialect, flown.seed, flown.settings, sea, None,
        vehicle.drives,
    )  # fmt: skip
    draw_flight(flight, out / "track.png", prepared.mission.name, told.caption)
    page = report_page(dives_of([box], notes=told.as_notes()))
    (out / "report.html").write_text(page, encoding="utf-8")
    click.echo(f"page {out / 'report.html'}, pictures in {out}, black box {box}")


def clear_earlier(out: Path, left: frozenset[str]) -> None:
    """Remove the folder of an earlier flight. Exit 2 if it holds a file not in ``left``."""
    if not out.exists():
        return
    others = sorted({path.name for path in out.iterdir()} - left)
    if others:
        click.echo(f"{out} holds {others[0]}, not of a demo: name another folder", err=True)
        raise SystemExit(2)
    shutil.rmtree(out)


class Shown:
    """Progress: in a terminal one line, overwritten; elsewhere one line per leg."""

    def __init__(self) -> None:
        self._terminal = sys.stdout.isatty()
        self._last = ""

    def show(self, progress: Progress) -> None:
        place = _place(progress)
        depth = "depth unknown" if progress.depth is None else f"{progress.depth:4.1f} m deep"
        left = "" if progress.left is None else f"at most {progress.left / 60:.1f} min left"
        where = f"{progress.state}/{progress.leg}".rstrip("/")
        text = f"{where:28} {depth:14} {place:36} {left}"
        if self._terminal:
            width = shutil.get_terminal_size().columns - 1  # a wrapped line is not overwritten
            click.echo(f"\r\x1b[2K{text[:width]}", nl=False)
        elif where != self._last:
            click.echo(text)
        self._last = where

    def end(self) -> None:
        if self._terminal:
            click.echo()


def _place(progress: Progress) -> str:
    if progress.position is None:
        return "no fix yet"
    north, east = progress.position
    within = "" if progress.uncertainty is None else f" within {progress.uncertainty:.0f} m"
    return f"{north:+.0f} m north {east:+.0f} m east{within}"
