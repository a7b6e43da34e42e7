"""Read, compile and check a mission: from its text to a chart for a vehicle, and to the report.

Commands and the vehicle's own check of an upload use these functions.

    text or script --language--> Draft --compiler--> Chart --check--> Report

    Unreadable        (the author must act; holds every Diagnostic of every stage)

An error at one stage does not hide the errors of later stages that are already certain. If only a
part of a text can be read, each readable leg is judged by itself. If a mission cannot be compiled,
the checks that do not depend on the settings of its legs still run.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from mission.authoring.bathymetry import Depths
from mission.authoring.check import Report, before_the_proof, check_mission, check_ways, no_home
from mission.authoring.compiler.abilities import guard_problems, own_problems
from mission.authoring.compiler.compiler import compiled
from mission.authoring.language import Draft, digest, draft, read_file
from mission.authoring.language.files import Files, no_files
from mission.model import Chart, Mission, legs_of
from mission.model.diagnostics import (
    Diagnosed,
    Diagnostic,
    MissionErrors,
    Stage,
    ordered,
    placed,
    whole,
)
from mission.model.likeness import nearest
from mission.model.shipped import load_vehicle, shipped_missions
from mission.model.vehicle import Vehicle, VehicleError

_LACKS = (
    "unheard",
    "vehicle-cannot-follow",
    "vehicle-has-no-word",
    "vehicle-cannot-know",
    "never-known",
    "signs-unconfirmed",
)


class Unreadable(Diagnosed):
    """There is no chart: a file cannot be read, or the vehicle cannot fly the mission."""

    @property
    def refused(self) -> bool:
        """Whether all files could be read, so that only the compiler or the check refuses."""
        return all(found.stage in (Stage.COMPILE, Stage.CHECK) for found in self.diagnostics)


@dataclass(frozen=True, slots=True)
class Charted:
    """The result of ``charted``: a chart, or None with the diagnostics in ``found``."""

    chart: Chart | None
    found: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True)
class Prepared:
    source: str
    text: str  # as its author wrote it
    mission: Mission
    vehicle: Vehicle
    chart: Chart


def prepare(
    path: str | Path,
    vehicle: str | Vehicle | None = None,
    parameters: Mapping[str, str] | None = None,
) -> Prepared:
    """Read and compile a mission file.

    ``path``: a file, or the name of a shipped mission. ``vehicle``: a file, the name of a shipped
    vehicle, or a loaded vehicle; None means the vehicle that the mission names. Raises Unreadable.
    """
    from mission.authoring.importing.places import beside

    file = mission_file(path)
    try:
        text = read_file(file)
    except MissionErrors as error:
        raise Unreadable(error.diagnostics, str(file)) from None
    return prepare_text(text, str(file), vehicle, parameters, beside(file))


def prepare_text(
    text: str,
    source: str,
    vehicle: str | Vehicle | None = None,
    parameters: Mapping[str, str] | None = None,
    files: Files = no_files,
) -> Prepared:
    """Read and compile a mission text. Messages call it ``source``; ``files`` reads the files of
    places that it names. Raises Unreadable."""
    read = drafted(text, source, vehicle, parameters, files)
    return prepare_draft(read, text, source, vehicle)


def drafted(
    text: str,
    source: str,
    vehicle: str | Vehicle | None = None,
    parameters: Mapping[str, str] | None = None,
    files: Files = no_files,
) -> Draft:
    """Read the text as far as possible; problems are in the Draft. Raises Unreadable if reading
    ended early (the text is too large)."""
    try:
        return draft(text, source, parameters or {}, _named(vehicle), files)
    except MissionErrors as error:
        raise Unreadable(error.diagnostics, source) from None


def prepare_draft(read: Draft, text: str, source: str, vehicle: str | Vehicle | None) -> Prepared:
    """Compile a text that ``drafted`` has read. Raises Unreadable."""
    try:
        chosen = _loaded(vehicle or read.mission.vehicle)
    except VehicleError as error:
        known = error.diagnostics if vehicle or not len(read.problems) else ()
        raise Unreadable([*known, *read.problems.found()], source) from None
    made = charted(read, chosen)
    if made.chart is None:
        own = chosen.name == read.mission.vehicle
        raise Unreadable(made.found if own else [_unfit(made.found, chosen.name)], source)
    return Prepared(source, text, read.mission, chosen, made.chart)


def _loaded(vehicle: str | Vehicle) -> Vehicle:
    return vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)


def _named(vehicle: str | Vehicle | None) -> Vehicle | None:
    """The vehicle that the caller names; None if there is no name, or its file is unreadable."""
    with contextlib.suppress(VehicleError):
        return None if vehicle is None else _loaded(vehicle)
    return None


def charted(read: Draft, vehicle: Vehicle) -> Charted:
    """Compile what was read; return the chart, or every problem that is certain."""
    mission, place = read.mission, read.problems.placed
    if len(read.problems):
        return Charted(None, ordered([*read.problems.found(), *place(_alone(read, vehicle))]))
    made = compiled(mission, vehicle, digest(mission))
    if made.found or made.chart is None:
        ways = check_ways(made.chart, vehicle) if made.chart is not None else ()
        found = [*made.found, *before_the_proof(mission, vehicle), *ways]
        return Charted(None, place(ordered(found)))
    return Charted(made.chart)


def _alone(read: Draft, vehicle: Vehicle) -> Iterator[Diagnostic]:
    """The problems of the readable statements that do not depend on the unreadable ones."""
    mission = read.mission
    for leg in legs_of(mission.body):
        if read.sound(leg.where):
            yield from own_problems(replace(leg, name=leg.name or "this leg"), vehicle)
    for handler in mission.handlers:
        if read.sound(handler.where):
            yield from guard_problems(handler.guard.expression, vehicle, handler.where, None)
    if not read.says_home:
        yield from no_home(mission)


def mission_file(name: str | Path) -> Path:
    """The path of a mission: ``name`` itself, or the shipped mission of that name.

    A bare name (no suffix, no folder) that is no file must be a shipped mission's; if not, this
    raises Unreadable.
    """
    path = Path(name)
    if path.suffix or path.name != str(path) or path.exists():
        return path
    shipped = shipped_missions()
    if str(path) in shipped:
        return shipped[str(path)]
    message = f"{path}: no such file, and no shipped mission"
    close = nearest(str(path), shipped)
    hint = f"did you mean {close}? " if close else ""
    raise Unreadable([whole("unreadable", message, f"{hint}there are {', '.join(shipped)}")])


def check_prepared(prepared: Prepared, depths: Depths | None = None) -> Report:
    """Check a prepared mission. ``depths``: depths of the sea floor, from a file of the user."""
    report = check_mission(prepared.chart, prepared.vehicle, depths)
    return replace(report, refusals=placed(report.refusals, prepared.text, prepared.source))


def parameters_of(pairs: Iterable[str]) -> dict[str, str]:
    """Parse ``name=value`` pairs of a command line. Raises Unreadable."""
    found = {}
    for pair in pairs:
        name, sign, value = pair.partition("=")
        if not sign or not name.strip():
            hint = "write NAME=VALUE, for instance row_length=150"
            raise Unreadable([whole("parameter-value", f"--param {pair!r} sets nothing", hint)])
        found[name.strip()] = value.strip()
    return found


def _unfit(found: Iterable[Diagnostic], vehicle: str) -> Diagnostic:
    """The main reason why a mission for another vehicle cannot fly on this one.

    Reasons in ``_LACKS`` (something that the vehicle lacks) come first, in that order.
    """
    weight = {code: at for at, code in enumerate(_LACKS)}
    first = min(found, key=lambda d: (weight.get(d.code, len(weight)), d.where.line))
    return replace(first, message=f"not for {vehicle}: {first.message}")
