"""``auvmission rehearse``: fly a mission in many seas that it assumes. Exit 0, 1, 2."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.jobs import Where, job_options
from mission.commands.options import (
    AS_JSON,
    BATHYMETRY,
    MISSION,
    PARAMETERS,
    SEED,
    SETTINGS,
    VEHICLE,
)
from mission.commands.output import refuse_unwritable, writing
from mission.commands.seafloor import depths_of
from mission.commands.unreadable import tell_unreadable

if TYPE_CHECKING:
    from mission.authoring.prepare import Prepared
    from mission.model.vehicle import Vehicle
    from mission.verification.rehearsing.flights import Flown, Rehearsed
    from mission.verification.rehearsing.report import Rehearsal
    from mission.verification.workers.outcome import Lost


@click.command()
@click.argument("mission", type=MISSION)
@click.option("--flights", type=click.IntRange(min=1), default=100, show_default=True,
              help="How many to fly.")  # fmt: skip
@SEED
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="Picture to write, .png or .svg: where it comes up, and spreads; or .html, "
              "with all figures.")  # fmt: skip
@SETTINGS
@PARAMETERS
@VEHICLE
@BATHYMETRY
@AS_JSON
@job_options
def rehearse(
    mission: Path,
    flights: int,
    seed: int,
    output: Path | None,
    settings: tuple[str, ...],
    parameters: tuple[str, ...],
    vehicle: str | None,
    bathymetry: Path | None,
    as_json: bool,
    where: Where,
) -> None:
    """Fly MISSION many times, each in a sea drawn from its assumptions and the vehicle file.

    Prints the probability that it is completed; the spreads of time, energy, position error and
    coverage; where it surfaces (with the regions that hold 50, 90 and 99 % of the flights, for the
    boat); legs that no flight reached; limits that came near; and the worst ten flights, with the
    command that flies each again. The same seed gives the same result. A value of --set, a changed
    assumption or a fault, is the same in all flights and is not drawn. With --bathymetry the sea
    floor follows the file; the least water under the vehicle and the number of flights that ran
    aground are printed too.

    A flight without a result is printed with the command that flies it again, and counts as
    `undone`: each interval holds whatever its result would have been.

    Exit 0 if all were completed, 1 if not, 2 if MISSION cannot be read, or flown at all.
    """
    import json

    from mission.verification.rehearsing.flights import Flown, Rehearsed
    from mission.verification.rehearsing.report import as_object, as_text, report_of
    from mission.verification.simulation.flightlog import leg_names

    if output is not None and output.suffix.lower() not in (".png", ".svg", ".html"):
        raise click.UsageError(f"{output}: the suffix says what to write: .png, .svg or .html")
    prepared = _read(mission, vehicle, parameters, as_json)
    if output is not None:
        refuse_unwritable(output)
    depths = None if bathymetry is None else depths_of(bathymetry)
    _can_be_set(settings, prepared.vehicle)
    source = _source(mission, vehicle, parameters, bathymetry)
    found = _fly(Rehearsed(prepared, seed, depths, settings), flights, where, source)
    flown = [one for one in found if isinstance(one, Flown)]
    undone = flights - len(flown)
    if not flown:
        if as_json:
            click.echo(json.dumps({"flights": 0, "undone": undone, "seed": seed}))
        raise SystemExit(1)
    report = report_of(flown, leg_names(prepared.mission), settings, undone)
    told = as_object(report, source, seed)
    click.echo(json.dumps(told) if as_json else as_text(report, source, seed))
    if output is not None:
        _write(output, report, flown, source, seed, prepared.mission.name)
    raise SystemExit(0 if report.outcomes.get("completed", 0) == flights else 1)


def _fly(of: Rehearsed, flights: int, where: Where, source: str) -> list[Flown | Lost]:
    """Fly. Print each flight without a result, with the command that flies it again."""
    import functools

    from mission.verification.rehearsing.flights import Flown, rehearsed
    from mission.verification.rehearsing.report import command
    from mission.verification.workers.outcome import Lost
    from mission.verification.workers.progress import Progress

    tell = functools.partial(click.echo, err=True)
    with where.keeping(_asked(of), Flown) as kept:
        progress = Progress(flights, "flights", tell)
        found = list(rehearsed(of, flights, where.place, kept, progress))
    for number, one in enumerate(found):
        if isinstance(one, Lost):
            tell(f"{one}\n  again: {command(number, of.settings(number), source, of.seed)}")
    return found


def _asked(of: Rehearsed) -> dict[str, object]:
    """All that determines the results, except the program."""
    from dataclasses import fields

    from mission.verification.workers.contents import contents

    asked: dict[str, object] = {
        "rehearsed": of.prepared.chart.digest,
        "vehicle": contents(of.prepared.vehicle),
        "seed": of.seed,
    }
    if of.depths is not None:
        names = [field.name for field in fields(of.depths) if field.name != "source"]
        asked["bathymetry"] = contents({name: getattr(of.depths, name) for name in names})
    if of.given:
        asked["set"] = " ".join(of.given)
    return asked


def _read(mission: Path, vehicle: str | None, parameters: Sequence[str], as_json: bool) -> Prepared:
    """Read the mission. Exit 2 if it cannot be read."""
    from mission.authoring.prepare import Unreadable, parameters_of, prepare

    try:
        return prepare(mission, vehicle, parameters_of(parameters))
    except Unreadable as error:
        tell_unreadable(error, as_json)
        raise SystemExit(2) from None


def _can_be_set(settings: Sequence[str], vehicle: Vehicle) -> None:
    """Exit 2 if a text is no setting, or not one for this vehicle."""
    from links.simulated.settings import SettingError, parse_settings
    from mission.verification.rig.vehicle import simulated

    try:
        simulated(vehicle, settings=parse_settings(settings))
    except SettingError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None


def _source(
    mission: Path, vehicle: str | None, parameters: Sequence[str], bathymetry: Path | None
) -> str:
    """The arguments, quoted for the shell, that give the same mission again."""
    import shlex

    options = [("--param", text) for text in parameters]
    options += [("--vehicle", vehicle)] if vehicle else []
    options += [("--bathymetry", str(bathymetry))] if bathymetry else []
    return shlex.join([str(mission), *(word for option in options for word in option)])


def _write(
    output: Path, report: Rehearsal, flown: Sequence[Flown], source: str, seed: int, name: str
) -> None:
    """Write the page or the picture, by the suffix."""
    from mission.verification.rehearsing.page import html_page
    from mission.verification.rehearsing.picture import draw_rehearsal

    with writing(output):
        if output.suffix.lower() == ".html":
            page = html_page(report, flown, source, seed, name)
            output.write_text(page, encoding="utf-8")
        else:
            draw_rehearsal(report, flown, output, name)
