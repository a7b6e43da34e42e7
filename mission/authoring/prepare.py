"""From a mission file to a chart on a vehicle, and to what the check says of it.

    Unreadable        (the author must act; ``problems`` has every place, str shows them all)

The one way in for every program that takes a mission file; the Pi, which takes lines, has its own
in ``topside``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from mission.authoring.check import Report, check_mission
from mission.authoring.compiler.compiler import CompileErrors, compile_mission
from mission.authoring.language import MissionErrors, digest, parse, read_file
from mission.authoring.language.problems import Problem, Problems
from mission.model import Chart, Mission
from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import Vehicle, VehicleError


class Unreadable(ValueError):
    """There is no chart: the file cannot be read, parsed or compiled."""

    def __init__(self, message: str, problems: tuple[Problem, ...] = ()) -> None:
        super().__init__(message)
        self.problems = problems


@dataclass(frozen=True, slots=True)
class Prepared:
    source: str
    text: str  # as its author wrote it
    mission: Mission
    vehicle: Vehicle
    chart: Chart


def prepare(
    path: str | Path, vehicle: str | None = None, parameters: Mapping[str, str] | None = None
) -> Prepared:
    """``path``: a file or a shipped mission's name. ``vehicle``: likewise; None: the one that the
    mission names."""
    file = mission_file(path)
    source = str(file)
    try:
        text = read_file(file)
        mission = parse(text, source, parameters or {})
        chosen = load_vehicle(vehicle or mission.vehicle)
        chart = compile_mission(mission, chosen, digest(mission))
    except MissionErrors as error:
        raise Unreadable(str(error), error.problems) from None
    except VehicleError as error:
        nowhere = Problem(0, 0, 0, "", str(error), "", "vehicle")
        raise Unreadable(str(error), (nowhere,)) from None
    except CompileErrors as error:
        placed = _placed(text, source, error)
        raise Unreadable(str(placed), placed.problems) from None
    return Prepared(source, text, mission, chosen, chart)


def mission_file(name: str | Path) -> Path:
    """A file as it stands; a bare name that is no file is a shipped mission's. Raises Unreadable
    for a bare name that is neither."""
    path = Path(name)
    if path.suffix or path.name != str(path) or path.exists():
        return path
    shipped = missions_folder() / f"{path}.yaml"
    if shipped.is_file():
        return shipped
    known = ", ".join(sorted(p.stem for p in missions_folder().glob("*.yaml")))
    raise Unreadable(f"{path}: no such file, and no shipped mission; there are {known}")


def check_prepared(prepared: Prepared) -> Report:
    return check_mission(prepared.chart, prepared.vehicle)


def parameters_of(pairs: Iterable[str]) -> dict[str, str]:
    """``name=value`` from a command line. Raises Unreadable."""
    found = {}
    for pair in pairs:
        name, sign, value = pair.partition("=")
        if not sign or not name.strip():
            raise Unreadable(f"--param {pair!r}: write NAME=VALUE, for instance row_length=150")
        found[name.strip()] = value.strip()
    return found


def _placed(text: str, source: str, errors: CompileErrors) -> MissionErrors:
    """The compiler's problems with the lines they stand in."""
    problems = Problems(text, source)
    try:
        for p in errors.problems:
            problems.add(p.rule, p.where, p.message, p.hint)
        problems.complain()
    except MissionErrors as placed:
        return placed
    raise AssertionError("compile errors without a problem")
