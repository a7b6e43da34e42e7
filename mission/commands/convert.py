"""``auvmission convert``: write a mission in the other text form."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mission.commands.options import AS_JSON, MISSION, PARAMETERS
from mission.commands.output import write
from mission.commands.unreadable import tell_unreadable

_BY_SUFFIX = {".yaml": "yaml", ".yml": "yaml", ".mission": "lines", ".txt": "lines"}


@click.command()
@click.argument("mission", type=MISSION)
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="File to write; without it, standard output.")  # fmt: skip
@click.option("--to", "form", type=click.Choice(["yaml", "lines"]),
              help="By default as the output's suffix says, else what MISSION is not.")  # fmt: skip
@PARAMETERS
@AS_JSON
def convert(
    mission: Path,
    output: Path | None,
    form: str | None,
    parameters: tuple[str, ...],
    as_json: bool,
) -> None:
    """Write MISSION as YAML or as lines: the same mission, with the same digest.

    Parameters are resolved, and comments are dropped. The lines are the canonical text that is
    sent to the vehicle. With --json and without --output the object contains the text.
    """
    from mission.authoring.importing.places import beside
    from mission.authoring.language import MissionErrors, digest, is_yaml, load, to_lines, to_yaml
    from mission.authoring.prepare import Unreadable, mission_file, parameters_of

    try:
        mission = mission_file(mission)
        model = load(mission, parameters_of(parameters), beside(mission))
    except (MissionErrors, Unreadable) as error:
        tell_unreadable(error, as_json)
        raise SystemExit(2) from None
    if form is None:
        other = "lines" if is_yaml(mission.read_text(encoding="utf-8"), str(mission)) else "yaml"
        form = _BY_SUFFIX.get(output.suffix, other) if output else other
    text = to_yaml(model) if form == "yaml" else to_lines(model)
    if output is not None or not as_json:
        write(output, text)
    if as_json:
        named = {"file": str(output)} if output else {"text": text}
        click.echo(json.dumps({"form": form, "digest": digest(model), **named}))
