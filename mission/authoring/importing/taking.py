"""Turn a plan of another program, as bytes, into the text of a mission, in one call."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mission.authoring.importing import bounded, chosen, format_of
from mission.authoring.importing.route import Findings
from mission.authoring.importing.writing import Answers, mission_of
from mission.authoring.language import to_yaml
from mission.model.vehicle import Vehicle


@dataclass(frozen=True, slots=True)
class Taken:
    name: str  # of the mission
    text: str
    left_out: tuple[str, ...]


def taken(file: Path, data: bytes, answers: Answers, pick: str | None, boat: Vehicle) -> Taken:
    """Import one route of a plan. The suffix of ``file`` tells the format; ``pick``: the name of a
    route. Raises ImportErrors with all errors."""
    found = Findings(str(file))
    source = format_of(file, found).read(bounded(data, found), found)
    route = chosen(source, pick, found)
    steps = route.steps()
    found.complain()
    mission = mission_of(route.name or file.stem, steps, source, answers, boat, found)
    comment = _comment(file, route.name, found.left_out)
    text = "".join(f"# {line}\n" for line in comment) + to_yaml(mission)
    return Taken(mission.name, text, found.left_out)


def _comment(file: Path, route: str, left_out: tuple[str, ...]) -> list[str]:
    named = f", route {route}" if route else ""
    printable = [f"Imported from {file.name}{named}.", *(f"Left out: {line}" for line in left_out)]
    return ["".join(c if c.isprintable() else "?" for c in line) for line in printable]
