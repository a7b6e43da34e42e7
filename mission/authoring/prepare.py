"""From a mission's text to a chart on a vehicle, and to what the check says of it: the one way.

    text or script --language--> Draft --compiler--> Chart --check--> Report

    Unreadable        (the author must act; holds every Diagnostic of every stage)

What is wrong at one stage does not hide what is known of the later ones: of a text that cannot be
read throughout, the legs that can be read are judged each by itself; of a mission that cannot be
compiled, what refuses it whatever its legs set.
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
    """There is no chart: a file cannot be read, or what it says cannot be flown."""

    @property
    def refused(self) -> bool:
        """The mission can be read, and so can all else: it is what it says that cannot be flown."""
        return all(found.stage in (Stage.COMPILE, Stage.CHECK) for found in self.diagnostics)


@dataclass(frozen=True, slots=True)
class Charted:
    """``chart`` is None where something was ``found``."""

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
    """``path``: a file or a shipped mission's name. ``vehicle``: likewise, or one that is loaded;
    None: the one that the mission names. Raises Unreadable."""
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
    """The same of a text that is at hand; ``source`` is what messages call it. ``files`` reads
    those of places that it names."""
    read = drafted(text, source, vehicle, parameters, files)
    return prepare_draft(read, text, source, vehicle)


def drafted(
    text: str,
    source: str,
    vehicle: str | Vehicle | None = None,
    parameters: Mapping[str, str] | None = None,
    files: Files = no_files,
) -> Draft:
    """What the text says, as far as it could be read. Raises Unreadable where reading ended early
    (a text too large)."""
    try:
        return draft(text, source, parameters or {}, _named(vehicle), files)
    except MissionErrors as error:
        raise Unreadable(error.diagnostics, source) from None


def prepare_draft(read: Draft, text: str, source: str, vehicle: str | Vehicle | None) -> Prepared:
    """Of what was read of the text. Raises Unreadable."""
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
    """The vehicle that the caller names; None where it names none, or none that can be read."""
    with contextlib.suppress(VehicleError):
        return None if vehicle is None else _loaded(vehicle)
    return None


def charted(read: Draft, vehicle: Vehicle) -> Charted:
    """The chart of what was read, or everything that is known to be wrong with it."""
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
    """What is known of the statements that could be read, whatever the others were to say."""
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
    """A file as it stands; a bare name that is no file is a shipped mission's. Raises Unreadable
    for a bare name that is neither."""
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
    """``depths``: of the sea floor, where a file of them is given."""
    report = check_mission(prepared.chart, prepared.vehicle, depths)
    return replace(report, refusals=placed(report.refusals, prepared.text, prepared.source))


def parameters_of(pairs: Iterable[str]) -> dict[str, str]:
    """``name=value`` from a command line. Raises Unreadable."""
    found = {}
    for pair in pairs:
        name, sign, value = pair.partition("=")
        if not sign or not name.strip():
            hint = "write NAME=VALUE, for instance row_length=150"
            raise Unreadable([whole("parameter-value", f"--param {pair!r} sets nothing", hint)])
        found[name.strip()] = value.strip()
    return found


def _unfit(found: Iterable[Diagnostic], vehicle: str) -> Diagnostic:
    """Why a mission of another vehicle cannot fly on this one: the one reason that matters, which
    is what the vehicle lacks before what it knows or bears."""
    weight = {code: at for at, code in enumerate(_LACKS)}
    first = min(found, key=lambda d: (weight.get(d.code, len(weight)), d.where.line))
    return replace(first, message=f"not for {vehicle}: {first.message}")
